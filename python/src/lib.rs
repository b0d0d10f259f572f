//! The compiled part of the Python package `raindrops`: scenes, drawing, the reference, comparison, measuring.
//!
//! It has arrays of known types and shapes; what users pass is checked and converted in `raindrops/_arrays.py`. Every call
//! that computes lets go of the interpreter's lock while it does.

mod arrays;
mod bench;
mod document;
mod drawing;
mod interrupt;
mod process;
mod raise;
mod scene;

use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raindrops::picture::metrics;
use raindrops::picture::tone_map::{Exposure, exposure_of};
use raindrops::scene::model::Operator;
use raindrops::scene::{MAX_DROPS, MAX_IMAGE_EDGE, ToneMap};

use self::arrays::{Pixels, srgb};
use self::raise::Raise as _;

/// How far the picture `b` is from the truth `a`, as a dict.
#[pyfunction]
#[pyo3(signature = (a, b, curve=true, key=None, exposure=None))]
fn compare<'py>(
    py: Python<'py>,
    a: Pixels<'py>,
    b: Pixels<'py>,
    curve: bool,
    key: Option<f64>,
    exposure: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    process::enter()?;
    let shows_display = a.is_display();
    let (a, b) = (a.picture()?, b.picture()?);
    let operator = if curve { Operator::Photographic } else { Operator::None };
    let usual = ToneMap::default();
    let tone_map = ToneMap { operator, key: key.unwrap_or(usual.key), exposure };
    let scene = raindrops::scene::Scene { tone_map, ..Default::default() };
    scene.validate("compare").raise(py)?;
    let (comparison, width) = py.detach(|| {
        // Display values have been tone mapped already.
        let exposure =
            if shows_display { Exposure::Clipped(1.0) } else { exposure_of(&tone_map, &a) };
        (metrics::compare(&a, &b, None, exposure), a.width as usize)
    });
    let figures = PyDict::new(py);
    let pixels = comparison.pixels;
    figures.set_item("flip", pixels.flip)?;
    figures.set_item("flip_p99", pixels.flip_p99)?;
    figures.set_item("rmse", pixels.rms())?;
    figures.set_item("psnr_db", pixels.psnr_db)?;
    figures.set_item("rel_mse", pixels.rel_mse)?;
    figures.set_item("max_error", pixels.max_error)?;
    figures.set_item("max_error_at", pixels.max_error_at)?;
    let map: Vec<f32> = comparison.flip_map.iter().map(|error| *error as f32).collect();
    let rows = map.len() / width.max(1);
    let map = numpy::PyArray1::from_vec(py, map).reshape([rows, width])?;
    let map: Bound<'py, PyArray2<f32>> = map;
    figures.set_item("flip_map", map)?;
    Ok(figures)
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("MOST_EDGE", MAX_IMAGE_EDGE)?;
    module.add("MOST_DROPS", MAX_DROPS)?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<process::Session>()?;
    module.add_class::<drawing::Drawing>()?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(srgb, module)?)?;
    module.add_function(wrap_pyfunction!(bench::bench, module)?)?;
    module.add_function(wrap_pyfunction!(process::devices, module)?)?;
    module.add_function(wrap_pyfunction!(process::close, module)?)?;
    Ok(())
}
