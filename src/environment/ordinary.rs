//! The mean of what is not bright, however bright the rest is, and the median.
//!
//! A sun of one texel may have 10¹² times the light of all other texels together. Then the mean says nothing of the
//! others, and what a subtraction leaves of it is rounding. So the others are summed up without it.
//!
//! Each value v counts as min(v, 30 m), where m is the mean of just that: m = mean(min(v, 30 m)). Let S be the share of
//! the weight with values over 30 m, and O the mean of all with those taken as 0. Then m = O + 30 S m, so
//! m = O / (1 - 30 S). From the mean of all, which is never less, this is Newton's method on a concave function of
//! straight pieces: m falls in every round, and stays after a few. Bright values are in no sum.
//!
//! Where over 1/30 of the weight is bright, that is no small part, and counts.

use std::f64::consts::PI;

use glam::Vec3;

use super::{Environment, LUMINANCE};

/// Mean luminances above which a texel has an excess. What stays below it adds a standard deviation
/// of 30 √p means to a sample, p its share of the sphere: 0.1 for the sun's.
pub const THRESHOLD: f64 = 30.0;

/// Rows, and half of the columns, in which the median is looked for, at most.
const MEDIAN_ROWS: usize = 256;

/// Rounds in which the mean may settle. Three to six are usual.
const MOST_ROUNDS: usize = 64;

/// The mean that settles from the mean of all values. `others` has the mean of those that are not over a bound, those
/// over it taken as 0, and the share of those over it.
pub(crate) fn settled(mean: f64, others: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut settled = mean;
    for _ in 0..MOST_ROUNDS {
        let (others, share) = others(THRESHOLD * settled);
        let lower = others / (1.0 - THRESHOLD * share);
        // Also no number, where rounding makes the share too large.
        if !(lower >= 0.0 && lower < (1.0 - 1e-12) * settled) {
            break;
        }
        settled = lower;
    }
    settled
}

impl Environment {
    /// Mean luminance over the sphere of directions, in which each texel counts up to 30 times that mean: that of what is
    /// beside a sun. 0 if all but small bright parts is black.
    pub fn ordinary_luminance(&self) -> f64 {
        settled(self.mean_luminance(), |bound| {
            let bound = Vec3::splat(bound as f32);
            let others =
                self.mean_luminance_of(|texel| Vec3::select(texel.cmpgt(bound), Vec3::ZERO, texel));
            let share = self
                .mean_luminance_of(|texel| Vec3::select(texel.cmpgt(bound), Vec3::ONE, Vec3::ZERO));
            (others, share)
        })
    }

    /// The luminance that half of all directions have at most, of some 130,000 texels: that of a room, however wide and
    /// bright its window is.
    pub(crate) fn median_luminance(&self) -> f32 {
        let step = (self.height as usize).div_ceil(MEDIAN_ROWS);
        let rows = self.texels.chunks_exact(self.width as usize).enumerate().step_by(step);
        let mut found: Vec<(f32, f64)> = rows
            .flat_map(|(row, texels)| {
                let weight = (PI * (row as f64 + 0.5) / f64::from(self.height)).sin();
                let luminance = |texel: &Vec3| texel.dot(LUMINANCE.as_vec3());
                texels.iter().step_by(step).map(move |texel| (luminance(texel), weight))
            })
            .collect();
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let half = 0.5 * found.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut sum = 0.0;
        let mut reaches_half = |(_, weight): &(f32, f64)| {
            sum += weight;
            sum >= half
        };
        found.iter().find(|texel| reaches_half(texel)).map_or(0.0, |(luminance, _)| *luminance)
    }
}
