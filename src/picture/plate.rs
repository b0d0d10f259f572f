//! A background: what a camera saw behind the drops, and how far away it was.

use std::io::Cursor;
use std::path::Path;

use super::{EXR_MAGIC, GAVE_UP, Picture, check_claim, guarded};
use crate::scene::Scene;
use crate::scene::background::{Background, DepthKind};
use crate::{Error, Result};

/// A background in memory, pixel by pixel of the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plate {
    color: Option<Picture>,
    depth: Option<Depth>,
}

/// How far away things are.
#[derive(Clone, Debug, PartialEq)]
pub struct Depth {
    /// Scene units, over 0, row by row from the top.
    pub values: Vec<f64>,
    /// Along the view axis or along the ray.
    pub kind: DepthKind,
}

impl Plate {
    /// Of pictures in memory, both of the size of what is drawn.
    pub fn new(color: Option<Picture>, depth: Option<Depth>) -> Self {
        Self { color, depth }
    }

    /// Reads the background of a scene; empty if it has none.
    ///
    /// # Errors
    /// Those of [`Plate::open`].
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::open(&scene.background, scene.image.width, scene.image.height)
    }

    /// Reads a background for a picture of this size.
    ///
    /// # Errors
    /// [`Error::File`], one line, for a file that cannot be read or is of another size, a colour that is
    /// not finite, a depth that is not finite and over 0, an EXR without channel Z, a PNG of depth that has
    /// not 16 bits or comes without a scale.
    pub fn open(background: &Background, width: u32, height: u32) -> Result<Self> {
        let color = background.color.as_deref().map(|path| open_color(path, width, height));
        let depth = background.depth.as_deref().map(|path| {
            let read = std::fs::read(path).map_err(|error| error.to_string());
            read.and_then(|bytes| read_depth(&bytes, background.depth_scale))
                .and_then(|(size, values)| {
                    check_size(size, (width, height))?;
                    check_depth(&values, width)?;
                    Ok(Depth { values, kind: background.depth_kind })
                })
                .map_err(|problem| Error::read(path, problem))
        });
        Ok(Self { color: color.transpose()?, depth: depth.transpose()? })
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

fn open_color(path: &Path, width: u32, height: u32) -> Result<Picture> {
    let picture = Picture::read(path)?;
    check_size((picture.width, picture.height), (width, height))
        .map_err(|problem| Error::read(path, problem))?;
    match picture.pixels.iter().position(|pixel| !pixel.is_finite()) {
        None => Ok(picture),
        Some(index) => {
            let (x, y) = (index as u32 % width, index as u32 / width);
            let problem = format!("its colour at column {x}, row {y} is not finite");
            Err(Error::read(path, problem))
        }
    }
}

fn check_size(size: (u32, u32), wanted: (u32, u32)) -> Result<(), String> {
    if size == wanted {
        return Ok(());
    }
    let ((width, height), (wanted_width, wanted_height)) = (size, wanted);
    Err(format!(
        "it is {width} x {height}, the picture {wanted_width} x {wanted_height}; a background is of the \
         picture's size (--size {width}x{height} makes it so)"
    ))
}

fn check_depth(values: &[f64], width: u32) -> Result<(), String> {
    let Some(index) = values.iter().position(|depth| !(depth.is_finite() && *depth > 0.0)) else {
        return Ok(());
    };
    let (x, y) = (index % width as usize, index / width as usize);
    Err(format!(
        "the depth at column {x}, row {y} is {}, not finite and over 0; where nothing is, store a large \
         depth such as 1e10 (in a PNG 65535)",
        values[index]
    ))
}

/// Size and depths of a file's content.
fn read_depth(bytes: &[u8], scale: Option<f64>) -> Result<((u32, u32), Vec<f64>), String> {
    guarded(GAVE_UP, || match bytes.starts_with(&EXR_MAGIC) {
        true => read_exr_depth(bytes, scale.unwrap_or(1.0)),
        false => read_png_depth(bytes, scale),
    })
}

/// The channel Z of the first layer that has one; a layer's own, such as `Depth.Z`, too.
fn read_exr_depth(bytes: &[u8], scale: f64) -> Result<((u32, u32), Vec<f64>), String> {
    use exr::prelude::{ReadChannels, ReadLayers};
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| error.to_string())?;
    for header in &meta.headers {
        check_claim(header.layer_size.width(), header.layer_size.height(), bytes)?;
    }
    super::dwa::check_claims(Cursor::new(bytes))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    for layer in &image.layer_data {
        let is_depth = |name: &str| name == "Z" || name.ends_with(".Z");
        let mut channels = layer.channel_data.list.iter();
        if let Some(channel) = channels.find(|channel| is_depth(&channel.name.to_string())) {
            let size = (layer.size.width() as u32, layer.size.height() as u32);
            let values =
                channel.sample_data.values_as_f32().map(|z| f64::from(z) * scale).collect();
            return Ok((size, values));
        }
    }
    Err(format!("it has no channel Z (it has {})", super::channels(&meta.headers)))
}

fn read_png_depth(bytes: &[u8], scale: Option<f64>) -> Result<((u32, u32), Vec<f64>), String> {
    use image::{DynamicImage, ImageFormat, ImageReader};
    if !image::guess_format(bytes).is_ok_and(|format| format == ImageFormat::Png) {
        return Err("depth is channel Z of an EXR, or a 16-bit PNG; it is neither".into());
    }
    let scale = scale.ok_or(
        "a PNG's depth needs a scale: give depth_scale (--depth-scale), scene units a stored unit",
    )?;
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let (width, height) = reader().into_dimensions().map_err(|error| error.to_string())?;
    check_claim(width as usize, height as usize, bytes)?;
    match reader().decode().map_err(|error| error.to_string())? {
        DynamicImage::ImageLuma16(image) => {
            let values = image.pixels().map(|pixel| f64::from(pixel.0[0]) * scale).collect();
            Ok(((width, height), values))
        }
        other => Err(format!(
            "its pixels are {:?}; depth in a PNG has one channel of 16 bits",
            other.color()
        )),
    }
}
