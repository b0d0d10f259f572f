//! The height of the highest surface over the ground, column by column, as a height map has it.

use std::path::Path;

use super::depth::{numbers, png_of_16_bits};
use super::read::{Format, content, depth_planes};
use crate::Error;
use image::ImageFormat;

/// Heights under this, -inf too, say that nothing is there.
const NOTHING_UNDER: f64 = -1e9;

/// Over this a number is no height; 10⁹ metres are beyond the moon.
const HIGHEST: f64 = 1e9;

/// Height where nothing is: below every drop, and finite.
pub const NOTHING: f32 = -1e30;

/// Heights in scene units, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Texels along +x.
    pub columns: usize,
    /// Texels along +z.
    pub rows: usize,
    /// [`NOTHING`] where nothing is.
    pub heights: Vec<f32>,
}

impl HeightMap {
    /// Reads channel `Y` of an OpenEXR, or what else holds one number a pixel as depth does, or a PNG of 16 bits; stored
    /// numbers times `scale`.
    ///
    /// # Errors
    /// [`Error::File`], one line: it is broken, holds no heights, or one that is none.
    pub fn read(path: &Path, scale: f64) -> crate::Result<Self> {
        let map = content(path).and_then(|bytes| Self::from_bytes(&bytes, scale));
        map.map_err(|problem| Error::unread(path, &problem))
    }

    /// Reads a file's content likewise; the problem in words that follow its name.
    ///
    /// # Errors
    /// See [`HeightMap::read`].
    pub fn from_bytes(bytes: &[u8], scale: f64) -> Result<Self, String> {
        let (columns, rows, values) = match Format::of(bytes) {
            Some(Format::Exr) => of_exr(bytes)?,
            Some(Format::Display(ImageFormat::Png)) => png_of_16_bits(bytes, "heights")?,
            _ => {
                return Err(
                    "is no height map: an OpenEXR with a channel Y, or a PNG of 16 bits".into()
                );
            }
        };
        let height = |(index, value): (usize, f64)| {
            let (column, row) = (index % columns, index / columns);
            let height = value * scale;
            if value.is_nan() {
                return Err(format!(
                    "has a height that is no number: column {column}, row {row} is NaN; store -inf where nothing is"
                ));
            }
            if height > HIGHEST {
                return Err(format!(
                    "has a height over {HIGHEST:e}: column {column}, row {row} is {value}; store -inf where nothing is"
                ));
            }
            let is_there = value >= NOTHING_UNDER && height >= NOTHING_UNDER;
            Ok(if is_there { height as f32 } else { NOTHING })
        };
        let heights = values.into_iter().enumerate().map(height).collect::<Result<_, _>>()?;
        Ok(Self { columns, rows, heights })
    }

    /// The height of the highest surface; [`NOTHING`] if there is none.
    pub fn highest(&self) -> f32 {
        self.heights.iter().copied().fold(NOTHING, f32::max)
    }
}

fn of_exr(bytes: &[u8]) -> Result<(usize, usize, Vec<f64>), String> {
    // A height map has one layer: none is chosen.
    let planes = depth_planes(bytes, None, "the layer's name")?;
    let values = numbers(&planes, "heights")?;
    if planes.missing > 0 {
        return Err(format!(
            "leaves out {} pixels of its display window; write the whole map",
            planes.missing
        ));
    }
    Ok((planes.width, planes.height, values))
}
