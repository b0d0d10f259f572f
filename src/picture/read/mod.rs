//! Picture files of all formats: what they hold, as linear Rec. 709, and what is worth saying of it.
//!
//! One reader for plates, environments, depth and pictures to compare, so that a file is the same everywhere. Its first
//! bytes, not its name, tell the format. What a user can rely on: docs/reading.md.

mod color;
mod display;
mod dwa;
mod jpeg;
mod layers;
mod open_exr;
mod radiance;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glam::{DMat3, Vec3};
use image::ImageFormat;

use self::color::Primaries;
pub(crate) use self::open_exr::{Check, Planes};
use super::Picture;
use super::mend::{Edges, Mended, mend};
use crate::remark::Remark;
use crate::scene::MAX_IMAGE_EDGE;
use crate::{Error, Result};

/// What a picture file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// Linear Rec. 709, upright.
    pub picture: Picture,
    /// Display values (PNG, JPEG) rather than radiance.
    pub is_display: bool,
    /// Pixels of an OpenEXR display window that its data window leaves out: black.
    pub missing: u64,
    /// What was chosen, converted or left out.
    pub remarks: Vec<Remark>,
    /// What had to be made safe.
    pub mended: Mended,
    /// What brings the picture to Rec. 709, as long as that is to do.
    matrix: Option<DMat3>,
}

/// How a picture is wanted.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    layer: Option<&'a str>,
    key: &'a str,
    mend: Option<Edges>,
    check: Option<Check<'a>>,
}

impl<'a> Request<'a> {
    /// The finished picture as it is, also what of it is not finite. `key` is what a message calls the choice of a layer.
    pub fn new(key: &'a str) -> Self {
        Self { layer: None, key, mend: None, check: None }
    }

    /// A layer of an OpenEXR file, by its name or the end of it; none: the finished picture.
    pub fn layer(self, layer: Option<&'a str>) -> Self {
        Self { layer, ..self }
    }

    /// With pixels that are not finite made safe; `edges` is what is beside the picture.
    pub fn mended(self, edges: Edges) -> Self {
        Self { mend: Some(edges), ..self }
    }

    /// Refuses a width and height before memory is taken for them.
    pub(crate) fn checked(self, check: Check<'a>) -> Self {
        Self { check: Some(check), ..self }
    }
}

impl Decoded {
    fn radiance(width: usize, height: usize, pixels: Vec<Vec3>) -> Self {
        let picture = Picture { width: width as u32, height: height as u32, pixels };
        let (remarks, mended) = (Vec::new(), Mended::default());
        Self { picture, is_display: false, missing: 0, remarks, mended, matrix: None }
    }

    /// This decoding with colours of these primaries.
    fn of_primaries(mut self, primaries: Primaries) -> std::result::Result<Self, String> {
        self.matrix = primaries.to_rec709()?;
        if self.matrix.is_some() {
            self.remarks.push(Remark::detail("its primaries are converted to those of Rec. 709"));
        }
        Ok(self)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::File`], one line: it cannot be read, is broken or cut off, is no picture, claims more than it can hold,
    /// or has several layers that may be meant.
    pub fn read(path: &Path, request: Request<'_>) -> Result<Self> {
        let read = content(path).and_then(|bytes| decode(&bytes, request));
        read.map_err(|problem| Error::unread(path, &problem))
    }
}

/// What a format's first bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Exr,
    Radiance,
    Display(ImageFormat),
}

impl Format {
    /// By the first bytes; `None` for what is no format of these.
    pub fn of(start: &[u8]) -> Option<Self> {
        if start.starts_with(&open_exr::MAGIC) {
            Some(Self::Exr)
        } else if start.starts_with(b"#?") {
            Some(Self::Radiance)
        } else if start.starts_with(b"\x89PNG\r\n\x1a\n") {
            Some(Self::Display(ImageFormat::Png))
        } else if start.starts_with(b"\xff\xd8\xff") {
            Some(Self::Display(ImageFormat::Jpeg))
        } else {
            None
        }
    }
}

/// A file's bytes; the error is the problem, in words that follow the file's name.
pub(crate) fn content(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let cannot_read = |error: std::io::Error| format!("cannot be read: {error}");
    // Asked before the file is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(cannot_read)?;
    if metadata.is_dir() {
        return Err("is a folder, not an image file".into());
    }
    if !metadata.is_file() {
        return Err("is not a regular file".into());
    }
    std::fs::read(path).map_err(cannot_read)
}

/// Decodes a picture in memory; the error is the problem, one line in words that follow the file's name.
pub(crate) fn decode(bytes: &[u8], request: Request<'_>) -> std::result::Result<Decoded, String> {
    let check = |width: usize, height: usize| {
        if let Some(check) = request.check {
            check(width, height)?;
        }
        check_claim(width, height, bytes)
    };
    let mut decoded = guarded(|| match Format::of(bytes) {
        _ if bytes.is_empty() => Err("is empty".into()),
        Some(Format::Exr) => open_exr::decode(bytes, &check, request.layer, request.key),
        Some(Format::Radiance) => radiance::decode(bytes, &check),
        Some(Format::Display(format)) => display::decode(bytes, format, &check),
        None => Err("is not an OpenEXR, Radiance HDR, PNG or JPEG image".into()),
    })?;
    if request.layer.is_some() && Format::of(bytes) != Some(Format::Exr) {
        return Err(format!("has no layers, but {} names one", request.key));
    }
    if let Some(edges) = request.mend {
        let width = decoded.picture.width as usize;
        // Before the conversion, which would make NaN of an infinity.
        decoded.mended = mend(&mut decoded.picture.pixels, width, edges)?;
    }
    if let Some(matrix) = decoded.matrix.take() {
        color::convert(&mut decoded.picture.pixels, matrix);
    }
    Ok(decoded)
}

/// A layer's depth: one plane, or three that must be equal.
pub(super) fn depth_planes(
    bytes: &[u8],
    layer: Option<&str>,
    key: &str,
) -> std::result::Result<Planes, String> {
    let check = |width: usize, height: usize| check_claim(width, height, bytes);
    let choose = |headers: &[exr::meta::header::Header]| layers::depth(headers, layer, key);
    guarded(|| open_exr::planes(bytes, &check, &choose, f32::INFINITY))
}

/// Decodes, and says in one line why it cannot be done.
///
/// The last resort. The decoders are other people's code on other people's bytes, and some panic
/// on broken ones: exr 1.74 subtracts below zero in a B44 block, where overflow is checked. A picture must not take
/// the program down. Nothing that `decode` touches may outlive a panic.
pub(super) fn guarded<T>(
    decode: impl FnOnce() -> std::result::Result<T, String>,
) -> std::result::Result<T, String> {
    let gave_up = |_| Err("is broken: its decoder gave up".into());
    let outcome = catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(gave_up);
    // Some decoders' messages have several lines.
    outcome.map_err(|problem: String| problem.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Most pixels that a byte of a file can stand for: deflate packs 1032 to 1, a pixel is at least a bit.
const MOST_PIXELS_A_BYTE: usize = 1032 * 8;

/// Refuses a claim that the file cannot hold, before memory is taken for it.
pub(super) fn check_claim(
    width: usize,
    height: usize,
    bytes: &[u8],
) -> std::result::Result<(), String> {
    let most = MAX_IMAGE_EDGE as usize;
    if width > most || height > most || width * height > MOST_PIXELS_A_BYTE * bytes.len() {
        return Err(format!("claims {width} x {height} pixels in {} bytes", bytes.len()));
    }
    Ok(())
}

/// Words for a decoder's error. A file that is cut off fails in many ways, so all are named.
fn broken(error: impl fmt::Display) -> String {
    format!("is broken or cut off: {error}")
}

/// What is said of pixels that are no squares.
fn pixel_aspect(aspect: f64) -> Remark {
    Remark::warning(format!(
        "its pixels are {aspect:.3} times as wide as high; they are drawn as squares"
    ))
}
