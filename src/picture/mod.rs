//! Pictures on disk: linear radiance as EXR, display colour as PNG. A file appears whole or not at
//! all: it is written beside its place and renamed.

use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use exr::prelude::{WritableImage, f16};
use glam::Vec3;

use crate::{Error, Result};

/// A rectangle of linear radiance, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<Vec3>,
}

impl Picture {
    /// Writes linear radiance as float32 RGB.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        self.write_channels(path, |pixel| (pixel.x, pixel.y, pixel.z))
    }

    /// Writes linear radiance as float16 RGB: half the size, for pictures whose fourth digit does
    /// not matter.
    pub fn write_exr_f16(&self, path: &Path) -> Result<()> {
        let half = f16::from_f32;
        self.write_channels(path, |pixel| (half(pixel.x), half(pixel.y), half(pixel.z)))
    }

    /// ZIP-compressed, in one thread and in order, so that the same picture gives the same bytes.
    fn write_channels<T: exr::prelude::IntoSample + Send + Sync>(
        &self,
        path: &Path,
        channels: impl Fn(Vec3) -> (T, T, T) + Sync,
    ) -> Result<()> {
        let width = self.width as usize;
        let layer = exr::prelude::Layer::new(
            (width, self.height as usize),
            exr::prelude::LayerAttributes::default(),
            exr::prelude::Encoding::SMALL_LOSSLESS,
            exr::prelude::SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
                channels(self.pixels[at.y() * width + at.x()])
            }),
        );
        write_whole(path, |file| {
            exr::prelude::Image::from_layer(layer)
                .write()
                .non_parallel()
                .to_buffered(file)
                .map_err(|error| error.to_string())
        })
    }
}

/// Writes 8-bit sRGB, `width * height` RGB triples row by row from the top, as PNG.
pub fn write_png(path: &Path, width: u32, height: u32, srgb: &[u8]) -> Result<()> {
    write_whole(path, |file| {
        let encoder = image::codecs::png::PngEncoder::new(file);
        image::ImageEncoder::write_image(
            encoder,
            srgb,
            width,
            height,
            image::ColorType::Rgb8.into(),
        )
        .map_err(|error| error.to_string())
    })
}

/// Display value of a linear one in 0 to 1, by the sRGB curve (IEC 61966-2-1), rounded to 8 bits.
pub fn srgb_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded =
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// Writes a file beside `path` and renames it into place when `write` has succeeded.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), String>,
) -> Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Error::write(path, format!("there is no folder {}", folder.display())));
    }
    let aside =
        tempfile::NamedTempFile::new_in(folder).map_err(|error| Error::write(path, error))?;
    let mut buffered = BufWriter::new(aside.reopen().map_err(|error| Error::write(path, error))?);
    write(&mut buffered).map_err(|reason| Error::write(path, reason))?;
    buffered.flush().map_err(|error| Error::write(path, error))?;
    debug_assert!(buffered.stream_position().is_ok_and(|length| length > 0), "empty {path:?}");
    make_readable(aside.as_file());
    aside.persist(path).map_err(|error| Error::write(path, error.error))?;
    Ok(())
}

/// A temporary file is private to its owner; a result is not.
fn make_readable(file: &File) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Best effort: a file system without modes keeps what it has.
        let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
    }
    #[cfg(not(unix))]
    let _ = file;
}
