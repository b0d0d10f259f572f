//! Arrays to pictures and back: H x W x 3, row 0 at the top.

use glam::Vec3;
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;
use raindrops::picture::{Picture, linear_of_srgb, srgb_byte};

/// A picture of a user's: C-contiguous, as `raindrops/_arrays.py` makes it.
#[derive(FromPyObject)]
pub enum Pixels<'py> {
    /// sRGB.
    Display(PyReadonlyArray3<'py, u8>),
    /// Linear Rec. 709.
    Linear(PyReadonlyArray3<'py, f32>),
}

impl Pixels<'_> {
    /// Whether it holds display values.
    pub fn is_display(&self) -> bool {
        matches!(self, Self::Display(_))
    }

    /// Linear Rec. 709, by the curve by which files of 8 bits are read.
    pub fn picture(&self) -> PyResult<Picture> {
        let ((height, width, _), pixels) = match self {
            Self::Display(array) => {
                let linear: [f32; 256] =
                    std::array::from_fn(|value| linear_of_srgb((value as f64 / 255.0) as f32));
                let values = array.as_slice()?.chunks_exact(3);
                let pixels = values
                    .map(|v| Vec3::from_array(std::array::from_fn(|n| linear[usize::from(v[n])])));
                (array.as_array().dim(), pixels.collect())
            }
            Self::Linear(array) => {
                let pixels = array.as_slice()?.chunks_exact(3).map(Vec3::from_slice);
                (array.as_array().dim(), pixels.collect())
            }
        };
        Ok(Picture { width: width as u32, height: height as u32, pixels })
    }
}

/// H x W x 3 float32 of a picture.
pub fn linear<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let values: &[f32] = bytemuck::cast_slice(&picture.pixels);
    volume(py, values, (picture.width, picture.height))
}

/// H x W x N of values row by row from the top.
pub fn volume<'py, T: Element + Copy>(
    py: Python<'py>,
    values: &[T],
    (width, height): (u32, u32),
) -> PyResult<Bound<'py, PyArray3<T>>> {
    let (width, height) = (width as usize, height as usize);
    let channels = values.len() / (width * height).max(1);
    PyArray1::from_slice(py, values).reshape([height, width, channels])
}

/// H x W of values row by row from the top.
pub fn plane<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    (width, height): (u32, u32),
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_vec(py, values).reshape([height as usize, width as usize])
}

/// Linear values as sRGB of 8 bits; what is below 0 or over 1 is clipped.
#[pyfunction]
pub fn srgb<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray3<'py, f32>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let values = picture.as_slice()?;
    let shape = picture.as_array().dim();
    let bytes = py.detach(|| values.iter().map(|value| srgb_byte(*value)).collect());
    PyArray1::from_vec(py, bytes).reshape([shape.0, shape.1, shape.2])
}
