//! How far away what is behind the drops is, pixel by pixel, as tools write it.

use std::io::Cursor;
use std::path::Path;

use glam::DVec2;
use image::{DynamicImage, ImageFormat, ImageReader};

use super::read::{Format, Planes, check_claim, depth_planes, guarded};
use crate::Error;
use crate::remark::Remark;
use crate::scene::background::{Background, DepthKind};

/// Depth of the sky, in scene units: beyond all rain, and finite, so that no shader multiplies infinity by 0.
pub const SKY: f64 = 1e10;

/// Stored numbers from this on are the sky: programs write 1e9, 1e10, 1e30 or infinity.
const FARTHEST: f64 = 1e9;

/// The largest number of a PNG: what is farther than it can hold, as the sky is.
const LARGEST: u16 = u16::MAX;

/// How far away things are.
#[derive(Clone, Debug, PartialEq)]
pub struct Depth {
    /// Scene units, over 0, row by row from the top; [`SKY`] where nothing is.
    pub values: Vec<f64>,
    /// Along the view axis or along the ray.
    pub kind: DepthKind,
}

/// What a file of depth holds.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedDepth {
    /// One value for each of `width * height` pixels.
    pub depth: Depth,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// What was chosen, filled or left out.
    pub remarks: Vec<Remark>,
}

/// Depth as a file has it.
struct Stored {
    width: usize,
    height: usize,
    values: Vec<f64>,
    remarks: Vec<Remark>,
    /// The number from which on it is the sky.
    sky: f64,
}

impl DecodedDepth {
    /// Reads depth from a file's content, as a background wants it. `path` stands for the file in messages.
    ///
    /// # Errors
    /// [`Error::File`], one line: it is broken, holds no depth, several that may be meant, or one that is not over 0.
    pub fn from_bytes(path: &Path, bytes: &[u8], background: &Background) -> crate::Result<Self> {
        decode(bytes, background).map_err(|problem| Error::unread(path, &problem))
    }

    /// Depth in memory, row by row from the top, by the rules for that of an EXR; the problem in words that follow its name.
    pub(super) fn from_values(
        (width, height): (u32, u32),
        values: Vec<f64>,
        background: &Background,
    ) -> Result<Self, String> {
        let (width, height, remarks) = (width as usize, height as usize, Vec::new());
        in_scene_units(Stored { width, height, values, remarks, sky: FARTHEST }, background)
    }
}

fn decode(bytes: &[u8], background: &Background) -> Result<DecodedDepth, String> {
    let stored = match Format::of(bytes) {
        Some(Format::Exr) => of_exr(bytes, background.depth_layer.as_deref())?,
        Some(Format::Display(ImageFormat::Png)) => of_png(bytes, background)?,
        _ => {
            return Err(
                "is no depth: an OpenEXR with a channel such as Z, or a PNG of 16 bits".into()
            );
        }
    };
    in_scene_units(stored, background)
}

/// Gives unknown depths the nearest known one, refuses what is not over 0, and sets the sky's.
fn in_scene_units(stored: Stored, background: &Background) -> Result<DecodedDepth, String> {
    let Stored { width, height, mut values, mut remarks, sky } = stored;
    if let Some(invalid) = background.depth_invalid {
        let count = fill_unknown(&mut values, width, invalid)?;
        remarks.push(Remark::note(format!(
            "{count} texels of unknown depth ({invalid}) have the nearest known one"
        )));
    }
    let scale = background.depth_scale.unwrap_or(1.0);
    let mut beyond = 0_u64;
    for (index, depth) in values.iter_mut().enumerate() {
        // A number that is none is not over 0.
        if depth.is_nan() || *depth <= 0.0 {
            return Err(nothing_there(*depth, (index % width, index / width), sky));
        }
        let is_sky = *depth >= sky || *depth * scale >= FARTHEST;
        *depth = if is_sky { SKY } else { *depth * scale };
        beyond += u64::from(is_sky);
    }
    if beyond > 0 {
        remarks.push(Remark::detail(format!("{beyond} texels of depth are the sky")));
    }
    let depth = Depth { values, kind: background.depth_kind };
    Ok(DecodedDepth { depth, width: width as u32, height: height as u32, remarks })
}

/// What is wrong with a depth, and what helps.
fn nothing_there(depth: f64, (x, y): (usize, usize), sky: f64) -> String {
    let unknown = if depth.is_nan() { "nan".into() } else { format!("{depth}") };
    let sky = if sky == FARTHEST { "infinity" } else { "the largest number of a PNG" };
    format!(
        "has a depth that is not over 0: column {x}, row {y} is {depth}; if {unknown} stands for an unknown depth, \
         give background.depth_invalid = {unknown}; where the sky is, store {sky}"
    )
}

fn of_exr(bytes: &[u8], layer: Option<&str>) -> Result<Stored, String> {
    let planes = depth_planes(bytes, layer, "background.depth_layer")?;
    let values = numbers(&planes, "depth")?;
    let Planes { width, height, mut remarks, missing, .. } = planes;
    if missing > 0 {
        remarks
            .push(Remark::note(format!("{missing} pixels are outside its data window: the sky")));
    }
    Ok(Stored { width, height, values, remarks, sky: FARTHEST })
}

/// The numbers of a file that holds one a pixel, `what`, in one channel or in equal ones.
pub(super) fn numbers(planes: &Planes, what: &str) -> Result<Vec<f64>, String> {
    let (first, others) = planes.values.split_first().ok_or("has no channel")?;
    let differ = |other: &Vec<f32>| {
        first.iter().zip(other).position(|(a, b)| a != b && !(a.is_nan() && b.is_nan()))
    };
    match others.iter().find_map(differ) {
        Some(index) => Err(of_colors(what, index, planes.width)),
        None => Ok(first.iter().copied().map(f64::from).collect()),
    }
}

/// What is wrong with channels that differ at a pixel.
fn of_colors(what: &str, index: usize, width: usize) -> String {
    let (column, row) = (index % width, index / width);
    format!("holds colours and no {what}: its channels differ at column {column}, row {row}")
}

fn of_png(bytes: &[u8], background: &Background) -> Result<Stored, String> {
    if background.depth_layer.is_some() {
        return Err("has no layers, but background.depth_layer names one".into());
    }
    if background.depth_scale.is_none() {
        return Err(
            "is a PNG, whose depth needs a scale: give depth_scale (--depth-scale), scene units a stored unit".into(),
        );
    }
    let (width, height, values) = png_of_16_bits(bytes, "depth")?;
    let remarks = Vec::new();
    Ok(Stored { width, height, values, remarks, sky: f64::from(LARGEST) })
}

/// Width, height and the numbers of a PNG of 16 bits that holds one number a pixel: `what`.
pub(super) fn png_of_16_bits(bytes: &[u8], what: &str) -> Result<(usize, usize, Vec<f64>), String> {
    guarded(|| {
        let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
        let broken = |error: image::ImageError| format!("is broken or cut off: {error}");
        let (width, height) = reader().into_dimensions().map_err(broken)?;
        let (width, height) = (width as usize, height as usize);
        check_claim(width, height, bytes)?;
        let image = reader().decode().map_err(broken)?;
        let color = image.color();
        let pixels: Vec<[u16; 3]> = match image {
            DynamicImage::ImageLuma16(image) => image.pixels().map(|p| [p.0[0]; 3]).collect(),
            DynamicImage::ImageLumaA16(image) => image.pixels().map(|p| [p.0[0]; 3]).collect(),
            DynamicImage::ImageRgb16(image) => image.pixels().map(|p| p.0).collect(),
            DynamicImage::ImageRgba16(image) => {
                image.pixels().map(|p| [p.0[0], p.0[1], p.0[2]]).collect()
            }
            _ => {
                return Err(format!(
                    "has pixels of {color:?}; {what} in a PNG has 16 bits, and one channel or equal ones"
                ));
            }
        };
        if let Some(index) = pixels.iter().position(|[r, g, b]| r != g || g != b) {
            return Err(of_colors(what, index, width));
        }
        let values = pixels.iter().map(|pixel| f64::from(pixel[0])).collect();
        Ok((width, height, values))
    })
}

/// Gives texels that hold `invalid` the depth of the nearest one that does not; returns how many there are. Of most files they
/// are float32, in which a number such as 0.1 is another.
fn fill_unknown(values: &mut [f64], width: usize, invalid: f64) -> Result<usize, String> {
    let in_float32 = f64::from(invalid as f32);
    let is_unknown = |value: f64| match invalid.is_nan() {
        true => value.is_nan(),
        false => value == invalid || value == in_float32 && in_float32.is_finite(),
    };
    let is_known: Vec<bool> = values.iter().map(|value| !is_unknown(*value)).collect();
    let count = is_known.iter().filter(|known| !**known).count();
    if count == values.len() {
        return Err(format!("has no known depth: every texel is {invalid}"));
    }
    if count > 0 {
        let known = values.to_vec();
        for (value, from) in values.iter_mut().zip(nearest(&is_known, width)) {
            *value = known[from];
        }
    }
    Ok(count)
}

/// For each pixel the nearest one that is known, itself if it is. There must be one.
///
/// P. Felzenszwalb and D. Huttenlocher, *Distance Transforms of Sampled Functions* (2012): first along columns, then
/// along rows by the lower envelope of parabolas.
fn nearest(is_known: &[bool], width: usize) -> Vec<usize> {
    let height = is_known.len() / width;
    // The nearest known row in the same column.
    let mut rows: Vec<Option<usize>> = vec![None; is_known.len()];
    for x in 0..width {
        for y in 0..height {
            let above = if y > 0 { rows[(y - 1) * width + x] } else { None };
            rows[y * width + x] = if is_known[y * width + x] { Some(y) } else { above };
        }
        for y in (0..height.saturating_sub(1)).rev() {
            let (own, below) = (rows[y * width + x], rows[(y + 1) * width + x]);
            let far = |row: Option<usize>| row.map_or(usize::MAX, |row| row.abs_diff(y));
            rows[y * width + x] = if far(below) < far(own) { below } else { own };
        }
    }
    let mut all = Vec::with_capacity(is_known.len());
    for y in 0..height {
        // Columns whose parabola is the lowest somewhere, and from where on.
        let mut lowest: Vec<(usize, f64)> = Vec::new();
        let point = |x: usize| {
            rows[y * width + x].map(|row| DVec2::new(x as f64, (row.abs_diff(y) as f64).powi(2)))
        };
        for x in 0..width {
            let Some(new) = point(x) else { continue };
            let mut from = f64::NEG_INFINITY;
            while let Some(&(last, start)) = lowest.last() {
                let old = point(last).unwrap_or(new);
                from = 0.5 * ((new.y - old.y) / (new.x - old.x) + new.x + old.x);
                if from > start {
                    break;
                }
                lowest.pop();
                from = f64::NEG_INFINITY;
            }
            lowest.push((x, from));
        }
        let mut number = 0;
        for x in 0..width {
            while lowest.get(number + 1).is_some_and(|(_, from)| *from < x as f64) {
                number += 1;
            }
            let column = lowest[number].0;
            all.push(rows[y * width + column].unwrap_or(y) * width + column);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{fill_unknown, nearest};

    /// 0.1 of a scene is that of a file in float32; what is beyond float32 is not the infinity of the sky.
    #[test]
    fn an_unknown_depth_is_found_as_float32_holds_it() {
        let filled = |stored: f32, invalid: f64| {
            let mut values = [2.0, stored.into(), f64::INFINITY];
            (fill_unknown(&mut values, 3, invalid), values)
        };
        assert_eq!(filled(0.1, 0.1), (Ok(1), [2.0, 2.0, f64::INFINITY]));
        let others = [2.0, 0.25, f64::INFINITY];
        assert_eq!(filled(0.25, 0.1), (Ok(0), others));
        assert_eq!(filled(0.25, 1e300), (Ok(0), others));
    }

    /// Against a search over all, for patterns with few, many and lined-up known pixels.
    #[test]
    fn nearest_known_pixels_are_nearest() {
        let (width, height) = (17, 11);
        for pattern in 1_usize..40 {
            let known =
                |index: usize| (index * 7919 + pattern * 104_729).is_multiple_of(3 * pattern + 1);
            let is_known: Vec<bool> = (0..width * height).map(known).collect();
            if !is_known.contains(&true) {
                continue;
            }
            let far = |a: usize, b: usize| {
                (a % width).abs_diff(b % width).pow(2) + (a / width).abs_diff(b / width).pow(2)
            };
            for (index, found) in nearest(&is_known, width).into_iter().enumerate() {
                let all = (0..is_known.len()).filter(|other| is_known[*other]);
                let least = all.map(|other| far(index, other)).min();
                assert!(is_known[found], "{pattern}: {found} is not known");
                assert_eq!(Some(far(index, found)), least, "{pattern}: pixel {index}");
            }
        }
    }
}
