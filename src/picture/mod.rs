//! Pictures on disk: linear radiance as EXR, display colour as PNG.

pub mod depth;
pub mod flip;
pub mod heights;
pub mod layers;
pub mod masks;
pub mod mend;
pub mod metrics;
pub mod plate;
pub mod read;
pub mod sidecar;
pub mod tone_map;

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::LazyLock;

use exr::prelude::{WritableImage, f16};
use glam::Vec3;

use self::read::{Decoded, Format, Request, guarded};
use crate::files::write_whole;
use crate::{Error, Result};

/// The last chunk of a PNG: without data, `IEND`, and the sum of that.
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xae\x42\x60\x82";

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
    /// Reads a picture as linear Rec. 709, without what is worth saying of it: [`Decoded::read`]. Values are returned as
    /// they stand in the file: negative, infinite or NaN ones too.
    ///
    /// # Errors
    /// See [`Decoded::read`].
    pub fn read(path: &Path) -> Result<Self> {
        Decoded::read(path, Request::new("its layer")).map(|decoded| decoded.picture)
    }

    /// Like [`Picture::read`], from what stands in a file; `path` stands for it in messages.
    ///
    /// # Errors
    /// See [`Picture::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let decoded = read::decode(bytes, Request::new("its layer"));
        let decoded = decoded.map_err(|problem| Error::unread(path, &problem))?;
        Ok(decoded.picture)
    }

    /// Whether the file at `path` holds display values (PNG, JPEG) rather than radiance (EXR, HDR), by
    /// its first bytes.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read.
    pub fn is_display(path: &Path) -> Result<bool> {
        let mut start = [0; 4];
        let read = File::open(path).and_then(|mut file| file.read(&mut start));
        read.map(|_| !matches!(Format::of(&start), Some(Format::Exr | Format::Radiance)))
            .map_err(|error| Error::read(path, error))
    }

    /// Whether the file at `path` ends where a PNG or an EXR does, by its last chunk or its blocks, none of
    /// which is decoded. One that was cut off does not.
    pub fn is_whole(path: &Path) -> bool {
        let Ok(file) = File::open(path) else { return false };
        let mut file = BufReader::new(file);
        let mut start = [0; 4];
        if file.read_exact(&mut start).and_then(|()| file.rewind()).is_err() {
            return false;
        }
        if Format::of(&start) == Some(Format::Exr) {
            let blocks = guarded(|| {
                let reader = exr::block::read(file, false).map_err(|error| error.to_string())?;
                reader.filter_chunks(true, |_, _, _| true).map_err(|error| error.to_string())
            });
            return blocks.is_ok_and(|mut all| all.all(|block| block.is_ok()));
        }
        let mut end = [0; PNG_END.len()];
        let read = file.seek(SeekFrom::End(-(PNG_END.len() as i64)));
        read.and_then(|_| file.read_exact(&mut end)).is_ok_and(|()| end == PNG_END)
    }

    /// Writes linear radiance as float32 RGB.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be encoded or written.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        self.write_channels(path, |pixel| (pixel.x, pixel.y, pixel.z))
    }

    /// Writes linear radiance as float16 RGB: half the size, for pictures whose fourth digit does
    /// not matter. What is over 65,504 is stored as that much; returns whether anything is.
    ///
    /// # Errors
    /// See [`Picture::write_exr`].
    pub fn write_exr_f16(&self, path: &Path) -> Result<bool> {
        let most = f16::MAX.to_f32();
        let half = |value: f32| f16::from_f32(value.min(most));
        self.write_channels(path, |pixel| (half(pixel.x), half(pixel.y), half(pixel.z)))?;
        Ok(self.pixels.iter().any(|pixel| pixel.max_element() > most))
    }

    /// The pixels as 8-bit sRGB, an RGB triple each; what is below 0 or over 1 is clipped.
    pub fn srgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|pixel| pixel.to_array().map(srgb_byte)).collect()
    }

    /// Writes display values as PNG, see [`Picture::srgb`].
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be encoded or written.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_png(path, self.width, self.height, &self.srgb())
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
        let mut bytes = Cursor::new(Vec::new());
        exr::prelude::Image::from_layer(layer)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .map_err(|error| Error::write(path, error))?;
        write_whole(path, bytes.get_ref())
    }
}

/// Copies a part's pixels, rows of `width` of them, to their place in the whole picture.
pub fn place<T: Copy>(
    whole: &mut [T],
    whole_width: u32,
    [column, row]: [u32; 2],
    part: &[T],
    width: u32,
) {
    for (number, pixels) in part.chunks_exact(width as usize).enumerate() {
        let at = (row as usize + number) * whole_width as usize + column as usize;
        whole[at..at + pixels.len()].copy_from_slice(pixels);
    }
}

/// Writes 8-bit sRGB, `width * height` RGB triples row by row from the top, as PNG
/// with a chunk that says so.
///
/// # Errors
/// [`Error::File`] if it cannot be encoded or written.
pub fn write_png(path: &Path, width: u32, height: u32, srgb: &[u8]) -> Result<()> {
    let mut bytes = Vec::new();
    let encode = |bytes: &mut Vec<u8>| -> std::result::Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        // What the values are, for programs that heed it; with gAMA and cHRM for older ones.
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(srgb)?;
        writer.finish()
    };
    encode(&mut bytes).map_err(|error| Error::write(path, error))?;
    write_whole(path, &bytes)
}

/// Linear steps into which 0 to 1 is divided: so fine that no two values of 8 bits begin in the same one.
const STEPS: usize = 4096;

/// The value of 8 bits at the beginning of each step, and the least linear value of each.
static BYTES: LazyLock<([u8; STEPS + 1], [f32; 257])> = LazyLock::new(|| {
    let byte = |linear: f32| (srgb_of_linear(linear) * 255.0).round() as u8;
    let mut least = [f32::INFINITY; 257];
    let mut all = 0..=1f32.to_bits();
    for value in 1..=255 {
        // Floats over 0 are in the order of their bits.
        let (mut low, mut high) = (*all.start(), *all.end());
        while low < high {
            let middle = low.midpoint(high);
            if byte(f32::from_bits(middle)) < value { low = middle + 1 } else { high = middle }
        }
        least[usize::from(value)] = f32::from_bits(low);
        all = low..=1f32.to_bits();
    }
    (std::array::from_fn(|step| byte(step as f32 / STEPS as f32)), least)
});

/// Display value of a linear one in 0 to 1, by the sRGB curve (IEC 61966-2-1), rounded to 8 bits; by a table.
pub fn srgb_byte(linear: f32) -> u8 {
    // NaN is not over 0.
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let (first, least) = &*BYTES;
    let byte = first[(linear * STEPS as f32) as usize];
    byte + u8::from(linear >= least[usize::from(byte) + 1])
}

/// Display value, 0 to 1, of a linear one (clamped to 0 to 1), by the sRGB curve.
pub fn srgb_of_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of a display one in 0 to 1: the inverse of [`srgb_of_linear`].
pub fn linear_of_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
