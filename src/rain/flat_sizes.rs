//! Rain as drops of a few diameters: which part of what a rain blocks each of them stands for, by the elevation of the
//! camera's direction. What a drop shows is tabulated for these diameters, and linear in between in a measure of them.

use std::f64::consts::PI;

use crate::abi::FLAT_ELEVATIONS;
use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED, axis_ratio};

/// The diameters in mm. The first is a sphere.
pub const DIAMETERS: [f64; 5] = [SMALLEST_FLATTENED, 2.0, 3.0, 4.0, 6.0];

/// Elevations of the camera's direction, from straight down to straight up.
const ELEVATIONS: usize = FLAT_ELEVATIONS as usize;

/// Sizes of a rain's drops that block as much as each other.
const SIZES: u32 = 32;

/// What of a rain is drawn how, by the diameter of its drops.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parted<'a> {
    /// The rain's.
    pub law: &'a Law,
    /// Distance within which drops are shown one by one, for each millimetre of diameter.
    pub one_by_one: f64,
    /// Where the rain ends, in the same unit.
    pub extent: f64,
}

/// By elevation: the shares of [`DIAMETERS`], one in all.
pub(crate) type Shares = Vec<[f64; DIAMETERS.len()]>;

impl Parted<'_> {
    /// Of the drops that are a medium, and of those that are shown one by one; what they show is linear in `measure`.
    pub(crate) fn shares(&self, measure: fn(f64) -> f64) -> [Shares; 2] {
        // Of all that drops of a size block, the part by those that are shown one by one, times a factor.
        let is_endless = self.extent == f64::INFINITY;
        let near = |mm: f64| match is_endless {
            true => mm,
            false => (self.one_by_one * mm / self.extent).min(1.0),
        };
        let far = |mm: f64| if is_endless { 1.0 } else { 1.0 - near(mm) };
        [shares_of(self.law, far, measure), shares_of(self.law, near, measure)]
    }
}

/// By how much a drop of a diameter in mm is lower than wide; under 2 mm squared, over that of 2 mm: light that is reflected
/// totally grows so.
pub(crate) fn flatness(diameter: f64) -> f64 {
    let [flat, least] = [diameter, DIAMETERS[1]].map(|diameter| 1.0 - axis_ratio(diameter));
    match diameter {
        ..=SMALLEST_FLATTENED => 0.0,
        _ if flat < least => flat * flat / least,
        _ => flat,
    }
}

/// The drops of a law, of which `part` counts by diameter.
fn shares_of(law: &Law, part: impl Fn(f64) -> f64, measure: fn(f64) -> f64) -> Shares {
    let sizes: Vec<_> = (0..SIZES)
        .map(|size| law.quantile(2.0, (f64::from(size) + 0.5) / f64::from(SIZES)))
        // No size is left out whole, so that there is a mean even of no drops.
        .map(|diameter| (diameter, part(diameter).max(1e-30), Halves::of_diameter(diameter)))
        .collect();
    let of_elevation = |number: usize| {
        let elevation = PI * (number as f64 / (ELEVATIONS - 1) as f64 - 0.5);
        let mut shares = [0.0; DIAMETERS.len()];
        for (diameter, part, halves) in &sizes {
            let above = DIAMETERS.partition_point(|of| of <= diameter);
            let above = above.clamp(1, DIAMETERS.len() - 1);
            let [from, to] = [DIAMETERS[above - 1], DIAMETERS[above]].map(measure);
            let share = ((measure(*diameter) - from) / (to - from)).clamp(0.0, 1.0);
            let outline = part * halves.outline_area(elevation.sin());
            shares[above - 1] += (1.0 - share) * outline;
            shares[above] += share * outline;
        }
        let all = shares.iter().sum::<f64>();
        shares.map(|share| share / all)
    };
    (0..ELEVATIONS).map(of_elevation).collect()
}
