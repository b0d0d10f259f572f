//! From a file's bytes to texels. The first bytes tell the format; the size is checked from
//! the header, before memory is taken for it.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

use glam::Vec3;
use image::codecs::hdr::HdrDecoder;
use image::{ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Image, MAX_HEIGHT, MAX_WIDTH, open_exr};
use crate::picture::{guarded, linear_of_srgb, upright};

/// Most bytes that a decoder of the `image` crate may take: the largest image in float32 RGB
/// (1.6 GB) and some room.
const MAX_DECODER_BYTES: u64 = 2 << 30;

/// Decodes a file; the error is the problem, in one line.
pub(super) fn from_file(path: &Path) -> Result<Image, String> {
    let cannot_read = |error: std::io::Error| format!("cannot be read: {error}");
    // Asked before the file is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(cannot_read)?;
    if metadata.is_dir() {
        return Err("is a folder, not an image file".into());
    }
    if !metadata.is_file() {
        return Err("is not a regular file".into());
    }
    from_reader(BufReader::new(File::open(path).map_err(cannot_read)?))
}

/// Decodes an image in memory; the error is the problem, in one line.
pub(super) fn from_bytes(bytes: &[u8]) -> Result<Image, String> {
    from_reader(Cursor::new(bytes))
}

fn from_reader(reader: impl BufRead + Seek) -> Result<Image, String> {
    guarded("is broken: its decoder gave up", || decode(reader))
}

fn decode(mut reader: impl BufRead + Seek) -> Result<Image, String> {
    let mut start = Vec::new();
    (&mut reader).take(24).read_to_end(&mut start).map_err(broken)?;
    reader.rewind().map_err(broken)?;
    if start.is_empty() {
        return Err("is empty".into());
    }
    if start.starts_with(&exr::meta::magic_number::BYTES) {
        open_exr::decode(reader)
    } else if start.starts_with(b"#?RADIANCE") || start.starts_with(b"#?RGBE") {
        decode_radiance(reader)
    } else if start.starts_with(b"\x89PNG\r\n\x1a\n") {
        // The decoder would take some memory for what the header (IHDR, always first) claims.
        if let Some(&[w0, w1, w2, w3, h0, h1, h2, h3]) = start.get(16..24) {
            let [width, height] = [[w0, w1, w2, w3], [h0, h1, h2, h3]].map(u32::from_be_bytes);
            check_size(u64::from(width), u64::from(height))?;
        }
        decode_display(reader, ImageFormat::Png)
    } else if start.starts_with(b"\xff\xd8\xff") {
        check_jpeg_end(&mut reader)?;
        decode_display(reader, ImageFormat::Jpeg)
    } else {
        Err("is not an OpenEXR, Radiance HDR, PNG or JPEG image".into())
    }
}

/// Refuses what is too large or not twice as wide as high. Called with what a header claims,
/// before memory is taken for it.
pub(super) fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width > u64::from(MAX_WIDTH) || height > u64::from(MAX_HEIGHT) {
        return Err(format!(
            "is {width} x {height}, over the limit of {MAX_WIDTH} x {MAX_HEIGHT}; scale it down"
        ));
    }
    if width == 0 || width != 2 * height {
        return Err(format!(
            "is {width} x {height}, but a latitude-longitude image is twice as wide as it is high; \
             resample it, say to {} x {}",
            2 * height.max(1),
            height.max(1)
        ));
    }
    Ok(())
}

/// Words for a decoder's error. A file that is cut off fails in many ways, so all are named.
pub(super) fn broken(error: impl std::fmt::Display) -> String {
    format!("is broken or cut off: {error}")
}

fn decode_radiance(reader: impl BufRead) -> Result<Image, String> {
    // Not strict: that mode wants the signature to be RADIANCE, and many files have RGBE.
    let decoder = HdrDecoder::new_nonstrict(reader).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    let mut texels = vec![Vec3::ZERO; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(broken)?;
    Ok(Image { width, height, texels, missing: 0 })
}

/// PNG and JPEG: display colours.
fn decode_display(reader: impl BufRead + Seek, format: ImageFormat) -> Result<Image, String> {
    let mut reader = ImageReader::with_format(reader, format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    let display = upright(decoder).map_err(broken)?.into_rgb32f();
    let (width, height) = display.dimensions();
    let texels = display.pixels().map(|pixel| Vec3::from(pixel.0.map(linear_of_srgb))).collect();
    Ok(Image { width, height, texels, missing: 0 })
}

/// Refuses a JPEG without an end-of-image marker. The decoder would fill what was cut off with
/// grey and call it well.
fn check_jpeg_end(reader: &mut (impl BufRead + Seek)) -> Result<(), String> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).map_err(broken)?;
    reader.rewind().map_err(broken)?;
    // Segments up to the first scan are stepped over: an embedded thumbnail has an end of its own.
    let mut at = 2;
    while let Some(&[0xff, marker, high, low]) = bytes.get(at..at + 4) {
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
        if marker == 0xda {
            break;
        }
    }
    // Within scans the encoder stuffs a 0 after each 0xff, so this is a marker.
    let scans = bytes.get(at..).unwrap_or_default();
    if scans.windows(2).any(|pair| pair == [0xff, 0xd9]) {
        Ok(())
    } else {
        Err(broken("the JPEG's end is missing"))
    }
}
