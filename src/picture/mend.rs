//! Pixels that are negative or not finite are made safe, and counted.
//!
//! Lossy compression rings below zero beside bright texels (DWA) and float16 overflows to infinity
//! at the sun, so real files have both.

use std::fmt;

use glam::{DVec3, Vec3};

/// Least radiance that an overflow stands for: the largest of float16.
const OVERFLOW: f32 = 65_504.0;

/// What is beside a picture's left and right edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// The other edge, as of a panorama.
    Joined,
    /// Nothing.
    Open,
}

/// How many pixels of a picture had to be made safe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mended {
    /// Pixels with a component below 0: that component is 0 now.
    pub negative: u64,
    /// Pixels with a NaN or a negative infinity: each is now the mean of those of its eight neighbours
    /// that were finite, or black if none was.
    pub non_finite: u64,
    /// Pixels with a component that had overflowed to infinity.
    pub overflowed: u64,
    /// What such a component is now: 65,504 or the picture's largest finite one, whichever is more.
    pub overflow: f32,
    /// Pixels of an OpenEXR display window that its data window leaves out: black.
    pub missing: u64,
}

impl Mended {
    /// Whether the image was sound.
    pub fn is_nothing(&self) -> bool {
        self.negative + self.non_finite + self.overflowed + self.missing == 0
    }
}

impl fmt::Display for Mended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let overflow = format!("infinite (set to {})", self.overflow);
        let counts = [
            (self.negative, "negative (set to 0)"),
            (self.non_finite, "NaN (set to the mean of the neighbours)"),
            (self.overflowed, &overflow),
            (self.missing, "missing (black)"),
        ];
        let mut separator = "texels mended: ";
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            write!(formatter, "{separator}{count} {what}")?;
            separator = ", ";
        }
        if self.is_nothing() { write!(formatter, "no texel had to be mended") } else { Ok(()) }
    }
}

/// Makes every pixel of rows of `width` finite; negative ones stay. A pixel that has both an infinity and a NaN counts as
/// NaN.
///
/// # Errors
/// No pixel has a value: there is nothing to mend from.
pub(crate) fn mend(pixels: &mut [Vec3], width: usize, edges: Edges) -> Result<Mended, String> {
    if !pixels.is_empty() && pixels.iter().all(|pixel| pixel.is_finite()) {
        let overflow = pixels.iter().fold(OVERFLOW, |most, pixel| most.max(pixel.max_element()));
        return Ok(Mended { overflow, ..Mended::default() });
    }
    let is_hole = |pixel: Vec3| pixel.is_nan() || pixel.min_element() == f32::NEG_INFINITY;
    if pixels.iter().all(|pixel| is_hole(*pixel)) {
        return Err("is full of NaN: no texel is finite".into());
    }
    let finite = pixels.iter().flat_map(|pixel| pixel.to_array()).filter(|part| part.is_finite());
    let overflow = finite.fold(OVERFLOW, f32::max);
    let mut mended = Mended { overflow, ..Mended::default() };
    let mut holes = Vec::new();
    for (index, pixel) in pixels.iter_mut().enumerate() {
        if is_hole(*pixel) {
            holes.push(index);
        } else if pixel.max_element() == f32::INFINITY {
            *pixel = pixel.min(Vec3::splat(overflow));
            mended.overflowed += 1;
        }
    }
    mended.non_finite = holes.len() as u64;
    // All fillings are found before any is set, so that none is the mean of another.
    let fillings: Vec<Vec3> =
        holes.iter().map(|&hole| filling(pixels, width, hole, edges)).collect();
    for (hole, filling) in holes.into_iter().zip(fillings) {
        pixels[hole] = filling;
    }
    Ok(mended)
}

/// Sets negative components to 0, and counts the pixels that have any.
pub(crate) fn clip_negative(pixels: &mut [Vec3]) -> u64 {
    let mut count = 0;
    for pixel in pixels.iter_mut().filter(|pixel| pixel.min_element() < 0.0) {
        *pixel = pixel.max(Vec3::ZERO);
        count += 1;
    }
    count
}

/// Mean of the finite ones among the eight neighbours; black if there is none.
/// In float64, where the sum of eight float32 cannot overflow.
fn filling(pixels: &[Vec3], width: usize, hole: usize, edges: Edges) -> Vec3 {
    let height = pixels.len() / width;
    let (column, row) = (hole % width, hole / width);
    let columns: Vec<usize> = match edges {
        Edges::Joined => [column + width - 1, column, column + 1].map(|x| x % width).to_vec(),
        Edges::Open => (column.saturating_sub(1)..=(column + 1).min(width - 1)).collect(),
    };
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for y in row.saturating_sub(1)..=(row + 1).min(height - 1) {
        for x in &columns {
            let neighbour = pixels[y * width + x];
            if neighbour.is_finite() {
                sum += neighbour.as_dvec3();
                count += 1.0;
            }
        }
    }
    if count > 0.0 { (sum / count).as_vec3() } else { Vec3::ZERO }
}
