//! A background: what a camera saw behind the drops, and how far away it was.

use std::path::{Path, PathBuf};

use super::Picture;
pub use super::depth::{DecodedDepth, Depth};
use super::mend::Edges;
use super::read::{Decoded, Request, content};
use crate::remark::Remark;
use crate::scene::Scene;
use crate::scene::background::{Background, DepthKind};
use crate::{Error, Result};

/// A background in memory, pixel by pixel of the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plate {
    color: Option<Picture>,
    depth: Option<Depth>,
    remarks: Vec<(PathBuf, Remark)>,
}

impl Plate {
    /// A background of pictures in memory, both of the size of what is drawn.
    pub fn new(color: Option<Picture>, depth: Option<Depth>) -> Self {
        Self { color, depth, remarks: Vec::new() }
    }

    /// A background of pixels in memory, by the rules for files: colour that is not finite is mended, depth is checked and brought
    /// to scene units as `background` says, whose files are not read. Both have this width and height.
    ///
    /// # Errors
    /// [`Error::Scene`]: colour or depth of another number of pixels, colour without a finite pixel, a depth that is no
    /// number or not over 0.
    pub fn from_pixels(
        (width, height): (u32, u32),
        color: Option<Picture>,
        depth: Option<Vec<f64>>,
        background: &Background,
    ) -> Result<Self> {
        let refuse = |place: &str, problem: String| Error::Scene { place: place.into(), problem };
        let pixels = width as usize * height as usize;
        let mut plate = Self::default();
        if let Some(mut picture) = color {
            let place = "the background's colour";
            if picture.pixels.len() != pixels || picture.width != width {
                return Err(refuse(place, format!("is not {width} x {height} pixels")));
            }
            let mended = super::mend::mend(&mut picture.pixels, width as usize, Edges::Open);
            let mended = mended.map_err(|problem| refuse(place, problem))?;
            if !mended.is_nothing() {
                plate.remark(Path::new("colour"), vec![Remark::warning(mended.to_string())]);
            }
            plate.color = Some(picture);
        }
        if let Some(values) = depth {
            let place = "the background's depth";
            if values.len() != pixels {
                return Err(refuse(place, format!("is not {width} x {height} pixels")));
            }
            let decoded = DecodedDepth::from_values((width, height), values, background);
            let decoded = decoded.map_err(|problem| refuse(place, problem))?;
            plate.remark(Path::new("depth"), decoded.remarks);
            plate.depth = Some(decoded.depth);
        }
        Ok(plate)
    }

    /// Reads the background of a scene; empty if it has none.
    ///
    /// # Errors
    /// See [`Plate::open`].
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::open(&scene.background, scene.image.width, scene.image.height)
    }

    /// Reads a background for a picture of this size.
    ///
    /// # Errors
    /// See [`Decoded::read`]; [`Error::File`], one line, for a file of another size, a file without depth, a depth
    /// that is no number or not over 0, a PNG of depth that has not 16 bits or comes without a scale.
    pub fn open(background: &Background, width: u32, height: u32) -> Result<Self> {
        let mut plate = Self::default();
        let wanted = (width, height);
        if let Some(path) = &background.color {
            plate.color = Some(plate.open_color(path, background, wanted)?);
        }
        if let Some(path) = &background.depth {
            plate.depth = Some(plate.open_depth(path, background, wanted)?);
        }
        Ok(plate)
    }

    fn open_color(
        &mut self,
        path: &Path,
        background: &Background,
        wanted: (u32, u32),
    ) -> Result<Picture> {
        let layer = background.color_layer.as_deref();
        let request = Request::new("background.color_layer").layer(layer).mended(Edges::Open);
        let Decoded { picture, remarks, mended, missing, .. } = Decoded::read(path, request)?;
        let size = (picture.width, picture.height);
        if size != wanted {
            let advice = format!("--size {}x{} makes it so", size.0, size.1);
            return Err(Error::read(path, another_size(size, wanted, &advice)));
        }
        self.remark(path, remarks);
        let mended = super::mend::Mended { missing, ..mended };
        if !mended.is_nothing() {
            self.remark(path, vec![Remark::warning(mended.to_string())]);
        }
        Ok(picture)
    }

    fn open_depth(
        &mut self,
        path: &Path,
        background: &Background,
        wanted: (u32, u32),
    ) -> Result<Depth> {
        let bytes = content(path).map_err(|problem| Error::unread(path, &problem))?;
        let DecodedDepth { depth, width, height, remarks } =
            DecodedDepth::from_bytes(path, &bytes, background)?;
        let size = (width, height);
        if size != wanted {
            let resample = format!("resample it to {} x {}", wanted.0, wanted.1);
            // The picture has the colour's size already.
            let advice = match background.color {
                Some(_) => resample,
                None => format!("{resample}, or --size {}x{} makes the picture so", size.0, size.1),
            };
            return Err(Error::read(path, another_size(size, wanted, &advice)));
        }
        self.remark(path, remarks);
        Ok(depth)
    }

    fn remark(&mut self, path: &Path, remarks: Vec<Remark>) {
        self.remarks.extend(remarks.into_iter().map(|remark| (path.into(), remark)));
    }

    /// What was chosen in each of its files, converted, mended or left out.
    pub fn remarks(&self) -> &[(PathBuf, Remark)] {
        &self.remarks
    }

    /// A checksum of all that it holds (CRC-32), by which other files under the same names are told apart; none of an
    /// empty one.
    pub fn hash(&self) -> Option<u32> {
        let mut sum = crc32fast::Hasher::new();
        if let Some(color) = &self.color {
            sum.update(bytemuck::cast_slice(&color.pixels));
        }
        if let Some(depth) = &self.depth {
            sum.update(bytemuck::cast_slice(&depth.values));
        }
        (self.color.is_some() || self.depth.is_some()).then(|| sum.finalize())
    }

    /// Radiance, if there is any.
    pub fn color(&self) -> Option<&Picture> {
        self.color.as_ref()
    }

    /// Depth, if there is any.
    pub fn depth(&self) -> Option<&Depth> {
        self.depth.as_ref()
    }

    /// Radiance behind the drops at a pixel, by its number row by row; `None`: the environment's.
    pub fn radiance(&self, pixel: u32) -> Option<glam::DVec3> {
        self.color.as_ref().map(|color| color.pixels[pixel as usize].as_dvec3())
    }

    /// Radiance at a place of the picture, in pixels from its upper left corner: bilinear between the middles of pixels,
    /// and that of the nearest at the edge.
    pub fn bilinear(&self, place: glam::DVec2) -> Option<glam::DVec3> {
        let color = self.color.as_ref()?;
        let last = glam::DVec2::new(f64::from(color.width), f64::from(color.height)) - 1.0;
        let place = (place - 0.5).clamp(glam::DVec2::ZERO, last);
        let (first, share) = (place.floor(), place.fract());
        let next = (first + 1.0).min(last);
        let pixel = |x: f64, y: f64| {
            color.pixels[y as usize * color.width as usize + x as usize].as_dvec3()
        };
        let upper = pixel(first.x, first.y).lerp(pixel(next.x, first.y), share.x);
        let lower = pixel(first.x, next.y).lerp(pixel(next.x, next.y), share.x);
        Some(upper.lerp(lower, share.y))
    }

    /// Where a ray comes to what is behind: distance along it, given the cosine of its angle to the view
    /// axis.
    pub fn reach(&self, pixel: u32, cos_view: f64) -> f64 {
        match &self.depth {
            None => f64::INFINITY,
            Some(Depth { values, kind }) => {
                let depth = values[pixel as usize];
                match kind {
                    DepthKind::Planar => depth / cos_view,
                    DepthKind::Radial => depth,
                }
            }
        }
    }
}

/// What is wrong with a file of another size.
fn another_size(size: (u32, u32), wanted: (u32, u32), advice: &str) -> String {
    format!(
        "it is {} x {}, the picture {} x {}; a background is of the picture's size ({advice})",
        size.0, size.1, wanted.0, wanted.1
    )
}
