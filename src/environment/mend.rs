//! Texels that are negative or not finite are made safe, and counted.
//!
//! Lossy compression rings below zero beside bright texels (DWA) and float16 overflows to infinity
//! at the sun, so real files have both.

use std::fmt;

use glam::{DVec3, Vec3};

/// How many texels of an environment had to be made safe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Texels with a component below 0: that component is 0 now.
    pub negative: u64,
    /// Texels with a NaN or an infinity: each is now the mean of those of its eight neighbours
    /// that were finite, or black if none was.
    pub non_finite: u64,
    /// Texels of an OpenEXR display window that its data window leaves out: black.
    pub missing: u64,
}

impl Mended {
    /// Whether the image was sound.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Mended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.negative, "negative (set to 0)"),
            (self.non_finite, "not finite (set to the mean of the neighbours)"),
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

/// Makes every texel of rows of `width` finite and nowhere negative; `missing` stays 0. A texel
/// that is both counts as non-finite.
///
/// # Errors
/// No texel is finite: there is nothing to mend from.
pub(super) fn mend(texels: &mut [Vec3], width: usize) -> Result<Mended, String> {
    let mut mended = Mended::default();
    let mut holes = Vec::new();
    for (index, texel) in texels.iter_mut().enumerate() {
        if !texel.is_finite() {
            holes.push(index);
        } else if texel.min_element() < 0.0 {
            *texel = texel.max(Vec3::ZERO);
            mended.negative += 1;
        }
    }
    if holes.len() == texels.len() {
        return Err("is full of NaN or infinity: no texel is finite".into());
    }
    mended.non_finite = holes.len() as u64;
    // All fillings are found before any is set, so that none is the mean of another.
    let fillings: Vec<Vec3> = holes.iter().map(|&hole| filling(texels, width, hole)).collect();
    for (hole, filling) in holes.into_iter().zip(fillings) {
        texels[hole] = filling;
    }
    Ok(mended)
}

/// Mean of the finite ones among the eight neighbours, around the seam; black if there is none.
/// In float64, where the sum of eight float32 cannot overflow.
fn filling(texels: &[Vec3], width: usize, hole: usize) -> Vec3 {
    let height = texels.len() / width;
    let (column, row) = (hole % width, hole / width);
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for y in row.saturating_sub(1)..=(row + 1).min(height - 1) {
        for x in [column + width - 1, column, column + 1] {
            let neighbour = texels[y * width + x % width];
            if neighbour.is_finite() {
                sum += neighbour.as_dvec3();
                count += 1.0;
            }
        }
    }
    if count > 0.0 { (sum / count).as_vec3() } else { Vec3::ZERO }
}
