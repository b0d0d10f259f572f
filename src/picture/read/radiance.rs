//! Radiance HDR: the radiance that was measured or traced, in any orientation, RGBE or XYZE.
//!
//! Format: G. Ward, *Real Pixels* (Graphics Gems II, 1991) and `ray/src/common/color.c` of Radiance. A header's lines
//! EXPOSURE and COLORCORR were multiplied into the pixels, so they are divided out. A mantissa stands for the middle of
//! its step: (m + 1/2) · 2^(e - 136).

use glam::{DVec3, Vec3};

use super::color::{self, Primaries};
use super::{Decoded, broken};
use crate::remark::Remark;

/// What the header says.
#[derive(Debug, PartialEq)]
struct Header {
    is_xyz: bool,
    primaries: Option<[f64; 8]>,
    /// What pixels were multiplied with: product of all EXPOSURE and COLORCORR lines.
    scale: DVec3,
    /// Height over width of a pixel.
    pixel_aspect: f64,
}

/// Where scanlines and pixels lie in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Orientation {
    width: usize,
    height: usize,
    /// Scanlines are columns.
    is_by_columns: bool,
    /// Columns count from the right.
    is_from_right: bool,
    /// Rows count from the bottom.
    is_from_bottom: bool,
}

impl Orientation {
    /// From a line such as `-Y 512 +X 1024`.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, first_count, second, second_count] = words[..] else { return None };
        let counts = [first_count.parse().ok()?, second_count.parse().ok()?];
        let is_by_columns = match (first.get(1..)?, second.get(1..)?) {
            ("Y", "X") => false,
            ("X", "Y") => true,
            _ => return None,
        };
        let is_minus = |word: &str| match &word[..1] {
            "-" => Some(true),
            "+" => Some(false),
            _ => None,
        };
        let (x, y) = if is_by_columns { (first, second) } else { (second, first) };
        let [height, width] = if is_by_columns { [counts[1], counts[0]] } else { counts };
        Some(Self {
            width,
            height,
            is_by_columns,
            is_from_right: is_minus(x)?,
            is_from_bottom: !is_minus(y)?,
        })
    }

    /// Number of a pixel in the picture, row by row from the top, by its scanline and its place there.
    fn index(&self, line: usize, place: usize) -> usize {
        let (column, row) = if self.is_by_columns { (line, place) } else { (place, line) };
        let column = if self.is_from_right { self.width - 1 - column } else { column };
        let row = if self.is_from_bottom { self.height - 1 - row } else { row };
        row * self.width + column
    }

    /// Number of scanlines, and of pixels in each.
    fn scanlines(&self) -> (usize, usize) {
        if self.is_by_columns { (self.width, self.height) } else { (self.height, self.width) }
    }
}

/// Decodes a file; `check` refuses a size before memory is taken for it.
pub(super) fn decode(
    bytes: &[u8],
    check: &dyn Fn(usize, usize) -> Result<(), String>,
) -> Result<Decoded, String> {
    let mut rest = bytes;
    let header = Header::read(&mut rest)?;
    let line = line(&mut rest).ok_or_else(|| broken("its header has no end"))?;
    let orientation = Orientation::parse(&line)
        .ok_or_else(|| broken(format!("'{line}' is no resolution such as -Y 512 +X 1024")))?;
    check(orientation.width, orientation.height)?;
    let mut pixels = vec![Vec3::ZERO; orientation.width * orientation.height];
    let (lines, length) = orientation.scanlines();
    let mut scanline = vec![[0; 4]; length];
    for number in 0..lines {
        read_scanline(&mut rest, &mut scanline)
            .ok_or_else(|| broken(format!("scanline {number} of {lines} is not whole")))?;
        for (place, packed) in scanline.iter().enumerate() {
            pixels[orientation.index(number, place)] = unpack(*packed, header.scale);
        }
    }
    header.apply(Decoded::radiance(orientation.width, orientation.height, pixels))
}

impl Header {
    fn read(rest: &mut &[u8]) -> Result<Self, String> {
        let mut header =
            Self { is_xyz: false, primaries: None, scale: DVec3::ONE, pixel_aspect: 1.0 };
        while let Some(line) = line(rest) {
            if line.trim().is_empty() {
                return Ok(header);
            }
            let Some((name, value)) = line.split_once('=') else { continue };
            let value = value.trim();
            let wrong = || broken(format!("its line {name} is '{value}'"));
            let numbers: Option<Vec<f64>> =
                value.split_whitespace().map(|word| word.parse().ok()).collect();
            match name.trim() {
                "FORMAT" => {
                    header.is_xyz = match value {
                        "32-bit_rle_rgbe" => false,
                        "32-bit_rle_xyze" => true,
                        _ => return Err(format!("has the format {value}, which is not read")),
                    }
                }
                "EXPOSURE" | "COLORCORR" => {
                    let factor = match numbers.ok_or_else(wrong)?[..] {
                        [all] => DVec3::splat(all),
                        [red, green, blue] => DVec3::new(red, green, blue),
                        _ => return Err(wrong()),
                    };
                    if !(factor.is_finite() && factor.min_element() > 0.0) {
                        return Err(wrong());
                    }
                    header.scale *= factor;
                }
                "PRIMARIES" => {
                    header.primaries =
                        Some(numbers.ok_or_else(wrong)?.try_into().map_err(|_| wrong())?);
                }
                "PIXASPECT" => {
                    let [aspect] = numbers.ok_or_else(wrong)?[..] else { return Err(wrong()) };
                    header.pixel_aspect *= aspect;
                }
                _ => {}
            }
        }
        Err(broken("its header has no end"))
    }

    /// The picture with what the header says of its colours and pixels.
    fn apply(&self, mut decoded: Decoded) -> Result<Decoded, String> {
        let primaries = match (self.is_xyz, self.primaries) {
            (true, _) => Some(color::XYZ),
            (false, stated) => stated.map(Primaries::from_array),
        };
        if self.scale != DVec3::ONE {
            let text = format!("EXPOSURE and COLORCORR, {} in all, are divided out", self.scale);
            decoded.remarks.push(Remark::detail(text));
        }
        if (self.pixel_aspect - 1.0).abs() > 0.01 {
            decoded.remarks.push(super::pixel_aspect(self.pixel_aspect));
        }
        match primaries {
            Some(primaries) => decoded.of_primaries(primaries),
            None => Ok(decoded),
        }
    }
}

/// The next line, without its end; none where the file ends before the line does.
fn line(rest: &mut &[u8]) -> Option<String> {
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    Some(String::from_utf8_lossy(line).trim_end_matches('\r').to_string())
}

/// Radiance of a pixel, its scale divided out.
fn unpack([r, g, b, e]: [u8; 4], scale: DVec3) -> Vec3 {
    if e == 0 {
        return Vec3::ZERO;
    }
    let step = f64::exp2(f64::from(e) - 136.0);
    let middle = DVec3::new(f64::from(r), f64::from(g), f64::from(b)) + 0.5;
    (middle * step / scale).as_vec3()
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}

/// Fills a scanline; none if the file does not hold it.
fn read_scanline(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> Option<()> {
    let start: [u8; 4] = rest.get(..4)?.try_into().ok()?;
    let [2, 2, high, low] = start else { return read_pixels(rest, scanline) };
    if high >= 128 || usize::from(u16::from_be_bytes([high, low])) != scanline.len() {
        return read_pixels(rest, scanline);
    }
    take(rest, 4)?;
    // One component after the other: runs of over 128 repeat a byte, others are as they stand.
    for component in 0..4 {
        let mut at = 0;
        while at < scanline.len() {
            let count = usize::from(take(rest, 1)?[0]);
            let (count, is_run) = if count > 128 { (count - 128, true) } else { (count, false) };
            let bytes = take(rest, if is_run { 1 } else { count })?;
            for (number, pixel) in scanline.get_mut(at..at + count)?.iter_mut().enumerate() {
                pixel[component] = if is_run { bytes[0] } else { bytes[number] };
            }
            // A count of 0 stands for nothing, and would go on for ever.
            at += count.max(1);
        }
    }
    Some(())
}

/// Whole pixels, of which (1, 1, 1, n) repeats the one before n times; such ones in a row count in powers of 256.
fn read_pixels(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> Option<()> {
    let (mut at, mut shift) = (0, 0);
    while at < scanline.len() {
        let pixel: [u8; 4] = take(rest, 4)?.try_into().ok()?;
        if pixel[..3] == [1, 1, 1] {
            let before = *scanline.get(at.checked_sub(1)?)?;
            let count = usize::from(pixel[3]).checked_shl(shift)?;
            scanline.get_mut(at..at.checked_add(count)?)?.fill(before);
            (at, shift) = (at + count, shift + 8);
            // More would be over any scanline.
            if shift > 24 {
                return None;
            }
        } else {
            scanline[at] = pixel;
            (at, shift) = (at + 1, 0);
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the eight forms, for a picture of 2 x 3 whose pixels are numbered row by row.
    #[test]
    fn orientations() {
        let numbers = |line: &str| {
            let orientation = Orientation::parse(line).expect("a resolution");
            let (lines, length) = orientation.scanlines();
            (0..lines * length)
                .map(|n| orientation.index(n / length, n % length))
                .collect::<Vec<_>>()
        };
        let forms = [
            ("-Y 3 +X 2", [0, 1, 2, 3, 4, 5]),
            ("-Y 3 -X 2", [1, 0, 3, 2, 5, 4]),
            ("+Y 3 +X 2", [4, 5, 2, 3, 0, 1]),
            ("+Y 3 -X 2", [5, 4, 3, 2, 1, 0]),
            ("+X 2 -Y 3", [0, 2, 4, 1, 3, 5]),
            ("-X 2 -Y 3", [1, 3, 5, 0, 2, 4]),
            ("+X 2 +Y 3", [4, 2, 0, 5, 3, 1]),
            ("-X 2 +Y 3", [5, 3, 1, 4, 2, 0]),
        ];
        for (line, expected) in forms {
            assert_eq!(numbers(line), expected, "{line}");
        }
        for wrong in ["", "-Y 3", "-Y 3 +Y 2", "-Y 3 *X 2", "-Y x +X 2", "Y 3 X 2", "-Y -3 +X 2"] {
            assert_eq!(Orientation::parse(wrong), None, "{wrong}");
        }
    }

    /// A chain of runs: 2, then 1 · 256 more.
    #[test]
    fn old_runs_count_in_powers_of_256() {
        let mut scanline = vec![[0; 4]; 1 + 2 + 256];
        let bytes = [9, 8, 7, 6, 1, 1, 1, 2, 1, 1, 1, 1];
        assert_eq!(read_scanline(&mut &bytes[..], &mut scanline), Some(()));
        assert!(scanline.iter().all(|pixel| *pixel == [9, 8, 7, 6]));
        // One pixel fewer has no room for the run.
        assert_eq!(read_scanline(&mut &bytes[..], &mut scanline[1..]), None);
        // A run without a pixel before it.
        assert_eq!(read_scanline(&mut &bytes[4..], &mut scanline), None);
    }
}
