//! The environment blurred for minification: a mip chain whose level i averages, around every
//! texel, the same solid angle from equator to pole.
//!
//! An ordinary chain of a latitude-longitude image averages 2 x 2 texels; near the poles those are
//! slivers, and one level cannot serve both directions there. Here a texel averages as many columns
//! as its row's circle of latitude is shorter, weighted by solid angle: about a square of the sphere.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Environment;

/// One level: linear radiance, row by row from the top.
#[derive(Clone, Debug)]
pub struct Level {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<Vec3>,
}

/// Every level, from the image itself to a single row.
pub fn levels(environment: &Environment) -> Vec<Level> {
    let mut chain = Vec::new();
    for_each_level(environment, |width, height, texels| {
        chain.push(Level { width, height, texels: texels.to_vec() });
        Ok::<_, std::convert::Infallible>(())
    })
    .unwrap_or_else(|never| match never {});
    chain
}

/// Gives width, height and texels of every level to `visit`, from the image itself to a single row.
/// Two levels at most are in memory beside the image, so that this takes under 4 bytes a texel.
///
/// # Errors
/// The first of `visit`.
pub fn for_each_level<E>(
    environment: &Environment,
    mut visit: impl FnMut(u32, u32, &[Vec3]) -> Result<(), E>,
) -> Result<(), E> {
    let (mut width, mut height) = (environment.width(), environment.height());
    visit(width, height, environment.texels())?;
    let mut finer: Option<Vec<Vec3>> = None;
    for level in 1..=environment.height().ilog2() {
        let to = (environment.width() >> level, environment.height() >> level);
        let to = (to.0.max(1), to.1.max(1));
        let fine = finer.as_deref().unwrap_or(environment.texels());
        let texels = coarser(fine, (width, height), to);
        (width, height) = to;
        visit(width, height, &texels)?;
        finer = Some(texels);
    }
    Ok(())
}

/// The level of the size `to` from the next finer one.
fn coarser(fine: &[Vec3], of: (u32, u32), to: (u32, u32)) -> Vec<Vec3> {
    let rows_a_row = f64::from(of.1) / f64::from(to.1);
    let columns_a_column = f64::from(of.0) / f64::from(to.0);
    let mut texels = vec![Vec3::ZERO; to.0 as usize * to.1 as usize];
    texels.par_chunks_exact_mut(to.0 as usize).enumerate().for_each(|(y, row)| {
        let sine = (PI * (y as f64 + 0.5) / f64::from(to.1)).sin();
        // Columns to average: the level's own, widened by 1/sin θ, all around at most.
        let reach = (columns_a_column / sine).min(f64::from(of.0));
        let rows = overlaps(y as f64 * rows_a_row, rows_a_row);
        // Around the seam, as far as a texel beside it reaches.
        let margin = (0.5 * reach).ceil() as usize + 1;
        let means = column_means(fine, of, rows);
        let around = [&means[means.len() - margin..], &means[..], &means[..margin]].concat();
        for (x, texel) in row.iter_mut().enumerate() {
            let center = (x as f64 + 0.5) * columns_a_column;
            let mut sum = DVec3::ZERO;
            for (column, share) in overlaps(center - 0.5 * reach, reach) {
                sum += share * around[(column + margin as i64) as usize];
            }
            *texel = (sum / reach).as_vec3();
        }
    });
    texels
}

/// The cells that the interval [start, start + length] overlaps, each with the length in it.
fn overlaps(start: f64, length: f64) -> impl Iterator<Item = (i64, f64)> {
    let end = start + length;
    (start.floor() as i64..end.ceil() as i64)
        .map(move |cell| (cell, end.min(cell as f64 + 1.0) - start.max(cell as f64)))
        .filter(|(_, share)| *share > 1e-9)
}

/// Mean of each column over some rows, weighted by solid angle.
fn column_means(
    fine: &[Vec3],
    (width, height): (u32, u32),
    rows: impl Iterator<Item = (i64, f64)>,
) -> Vec<DVec3> {
    let mut means = vec![DVec3::ZERO; width as usize];
    let mut total = 0.0;
    for (row, share) in rows {
        let row = row.clamp(0, i64::from(height) - 1) as usize;
        let weight = share * (PI * (row as f64 + 0.5) / f64::from(height)).sin();
        total += weight;
        let texels = &fine[row * width as usize..][..width as usize];
        for (mean, texel) in means.iter_mut().zip(texels) {
            *mean += weight * texel.as_dvec3();
        }
    }
    means.iter().map(|mean| *mean / total).collect()
}

/// Radiance from a unit direction at a fractional level: trilinear, as the GPU's sampler does it.
pub fn sample(chain: &[Level], direction: DVec3, level: f64) -> DVec3 {
    let level = level.clamp(0.0, (chain.len() - 1) as f64);
    let at = |index: usize| {
        let level = &chain[index.min(chain.len() - 1)];
        bilinear(&level.texels, level.width, level.height, direction)
    };
    let fine = level.floor() as usize;
    at(fine).lerp(at(fine + 1), level.fract())
}

/// Unit vector to a place in the image, 0 to 1 from the left and the upper edge; beyond a pole there is the pole.
pub(super) fn direction_of(u: f64, v: f64) -> DVec3 {
    let (azimuth, polar) = ((u - 0.5) * TAU, v.clamp(0.0, 1.0) * PI);
    DVec3::new(azimuth.sin() * polar.sin(), polar.cos(), -azimuth.cos() * polar.sin())
}

/// Radiance from a unit direction: bilinear between texel centres, around the seam, clamped at the
/// poles.
pub(super) fn bilinear(texels: &[Vec3], width: u32, height: u32, direction: DVec3) -> DVec3 {
    interpolate(width, height, direction, |column, row| {
        texels[row * width as usize + column].as_dvec3()
    })
}

/// Like [`bilinear`], of texels by column and row.
pub(super) fn interpolate(
    width: u32,
    height: u32,
    direction: DVec3,
    texel: impl Fn(usize, usize) -> DVec3,
) -> DVec3 {
    let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
    let v = direction.y.clamp(-1.0, 1.0).acos() / PI;
    let (x, y) = (u * f64::from(width) - 0.5, v * f64::from(height) - 0.5);
    let texel = |column: f64, row: f64| {
        let column = (column as i64).rem_euclid(i64::from(width)) as usize;
        let row = (row as i64).clamp(0, i64::from(height) - 1) as usize;
        texel(column, row)
    };
    let (left, top) = (x.floor(), y.floor());
    let upper = texel(left, top).lerp(texel(left + 1.0, top), x - left);
    let lower = texel(left, top + 1.0).lerp(texel(left + 1.0, top + 1.0), x - left);
    upper.lerp(lower, y - top)
}
