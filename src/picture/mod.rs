//! Pictures on disk: linear radiance as EXR, display colour as PNG.

pub(crate) mod dwa;
pub mod flip;
pub mod layers;
pub mod masks;
pub mod metrics;
pub mod plate;
pub mod sidecar;
pub mod tone_map;

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use exr::meta::header::Header;
use exr::prelude::{WritableImage, f16};
use glam::Vec3;

use crate::files::write_whole;
use crate::scene::MAX_IMAGE_EDGE;
use crate::{Error, Result};

/// What is wrong with an EXR for which [`is_deep`] holds.
pub(crate) const DEEP: &str = "holds deep data (several samples a pixel), which is not read; flatten it to one sample a pixel";

/// Whether the EXR that begins with these bytes, a magic number and the version with its flags, holds a deep
/// layer. The decoder reads none of the others then either.
pub(crate) fn is_deep([.., flags, _, _]: [u8; 8]) -> bool {
    flags & 0x08 != 0
}

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
    /// Reads a picture as linear RGB: an EXR as it is (its first layer with R, G and B), a PNG or
    /// JPEG, recognised by their content, through the sRGB curve to 0 to 1, alpha ignored.
    ///
    /// Values are returned as they stand in the file: negative, infinite or NaN ones too.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read, is broken, or claims more pixels than so many bytes can
    /// hold.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::read(path, error))?;
        Self::from_bytes(path, &bytes)
    }

    /// As [`Picture::read`], from what stands in a file; `path` stands for it in messages.
    ///
    /// # Errors
    /// Those of [`Picture::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let picture = guarded(GAVE_UP, || match bytes.starts_with(&EXR_MAGIC) {
            true => read_exr(bytes),
            false => read_display(bytes),
        });
        picture.map_err(|problem| Error::read(path, problem))
    }

    /// Whether the file at `path` holds display values (PNG, JPEG) rather than radiance (EXR), by
    /// its first bytes.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read.
    pub fn is_display(path: &Path) -> Result<bool> {
        let mut start = [0; 4];
        let read = File::open(path).and_then(|mut file| file.read(&mut start));
        read.map(|_| start != EXR_MAGIC).map_err(|error| Error::read(path, error))
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
        if start == EXR_MAGIC {
            let blocks = guarded(GAVE_UP, || {
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
    /// Those of [`Picture::write_exr`].
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

/// What a picture is whose decoder panicked.
const GAVE_UP: &str = "it is broken: its decoder gave up";

/// Decodes, and says in one line why it cannot be done; `gave_up` where the decoder panicked.
///
/// The last resort. The decoders are other people's code on other people's bytes, and some panic
/// on broken ones: exr 1.74 subtracts below zero in a B44 block, where overflow is checked; the
/// HDR decoder of image 0.25 overflows on a long chain of empty runs. A picture must not take
/// the program down. Nothing that `decode` touches may outlive a panic.
pub(crate) fn guarded<T>(
    gave_up: &str,
    decode: impl FnOnce() -> Result<T, String>,
) -> Result<T, String> {
    let outcome = catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err(gave_up.into()));
    // Some decoders' messages have several lines.
    outcome.map_err(|problem| problem.split_whitespace().collect::<Vec<_>>().join(" "))
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

/// The first bytes of every OpenEXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Most pixels that a byte of a file can stand for: deflate packs 1032 to 1, a pixel is at least a bit.
const MOST_PIXELS_A_BYTE: usize = 1032 * 8;

/// Refuses a claim that the file cannot hold, before memory is taken for it.
fn check_claim(width: usize, height: usize, bytes: &[u8]) -> Result<(), String> {
    let most = MAX_IMAGE_EDGE as usize;
    if width > most || height > most || width * height > MOST_PIXELS_A_BYTE * bytes.len() {
        return Err(format!("it claims {width} x {height} pixels in {} bytes", bytes.len()));
    }
    Ok(())
}

/// Names of the channels of all layers, for a message.
fn channels(headers: &[Header]) -> String {
    let all = headers.iter().flat_map(|header| &header.channels.list);
    all.map(|channel| channel.name.to_string()).collect::<Vec<_>>().join(", ")
}

fn read_exr(bytes: &[u8]) -> Result<Picture, String> {
    use exr::prelude::{ReadChannels, ReadLayers};
    if bytes.first_chunk().is_some_and(|start| is_deep(*start)) {
        return Err(DEEP.into());
    }
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| error.to_string())?;
    for header in &meta.headers {
        check_claim(header.layer_size.width(), header.layer_size.height(), bytes)?;
    }
    crate::picture::dwa::check_claims(Cursor::new(bytes))?;
    let is_color = |header: &Header| {
        ["R", "G", "B"]
            .iter()
            .all(|name| header.channels.find_index_of_channel(&(*name).into()).is_some())
    };
    if !meta.headers.iter().any(is_color) {
        return Err(format!("it has no channels R, G and B (it has {})", channels(&meta.headers)));
    }
    // In one thread: the crate's thread pool aborts the process where a decoder panics.
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![Vec3::ZERO; size.area()]),
            |(width, pixels): &mut (usize, Vec<Vec3>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = Vec3::new(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let size = image.layer_data.size;
    Ok(Picture {
        width: size.width() as u32,
        height: size.height() as u32,
        pixels: image.layer_data.channel_data.pixels.1,
    })
}

fn read_display(bytes: &[u8]) -> Result<Picture, String> {
    use image::ImageFormat::{Jpeg, Png};
    let format = image::guess_format(bytes).ok().filter(|format| [Png, Jpeg].contains(format));
    let Some(format) = format else {
        return Err("it is no EXR, PNG or JPEG picture".into());
    };
    let reader = || image::ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(|error| error.to_string())?;
    check_claim(width as usize, height as usize, bytes)?;
    let decoded = reader().into_decoder().and_then(upright);
    let image = decoded.map_err(|error| error.to_string())?.into_rgb16();
    let linear = |value: u16| linear_of_srgb(f32::from(value) / 65_535.0);
    let pixels = image.pixels().map(|p| Vec3::from_array(p.0.map(linear))).collect();
    Ok(Picture { width: image.width(), height: image.height(), pixels })
}

/// Decodes a picture, and turns it as its EXIF data says: cameras that were held upright store it lying.
pub(crate) fn upright(
    mut decoder: impl image::ImageDecoder,
) -> image::ImageResult<image::DynamicImage> {
    let orientation = decoder.orientation()?;
    let mut image = image::DynamicImage::from_decoder(decoder)?;
    image.apply_orientation(orientation);
    Ok(image)
}

/// Writes 8-bit sRGB, `width * height` RGB triples row by row from the top, as PNG.
///
/// # Errors
/// [`Error::File`] if it cannot be encoded or written.
pub fn write_png(path: &Path, width: u32, height: u32, srgb: &[u8]) -> Result<()> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    let color = image::ColorType::Rgb8.into();
    image::ImageEncoder::write_image(encoder, srgb, width, height, color)
        .map_err(|error| Error::write(path, error))?;
    write_whole(path, &bytes)
}

/// Display value of a linear one in 0 to 1, by the sRGB curve (IEC 61966-2-1), rounded to 8 bits.
pub fn srgb_byte(linear: f32) -> u8 {
    (srgb_of_linear(linear) * 255.0).round() as u8
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
