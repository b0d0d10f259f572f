//! Rain as drops of a few diameters: which part of what a rain blocks each of them stands for, by the elevation of the
//! camera's direction. What a drop shows is tabulated for these diameters. In between what suns show is linear in the diameter;
//! other light is a cubic in how flat the drop is, as light that is reflected totally grows faster than any line.

use std::f64::consts::PI;

use crate::abi::FLAT_ELEVATIONS;
use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED, axis_ratio};
use crate::rain::thinned::Reach;

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
    /// How far its drops are shown one by one.
    pub reach: Reach,
    /// Where the rain ends, in metres.
    pub extent: f64,
}

/// Diameters whose cubic a drop's light is on.
const OF_CUBIC: usize = 4;

/// By elevation: the shares of [`DIAMETERS`], one in all; some are under 0 where a cubic is.
pub(crate) type Shares = Vec<[f64; DIAMETERS.len()]>;

impl Parted<'_> {
    /// Shares for the light of suns: of the drops that are a medium, then of those that are shown one by one.
    pub(crate) fn shares_of_suns(&self) -> [Shares; 2] {
        self.shares(on_a_line)
    }

    /// Shares for other light, in the order of [`Parted::shares_of_suns`].
    pub(crate) fn shares_of_light(&self) -> [Shares; 2] {
        self.shares(on_a_cubic)
    }

    /// `parts`: what a drop of a diameter shows of each of [`DIAMETERS`].
    fn shares(&self, parts: fn(f64) -> [f64; DIAMETERS.len()]) -> [Shares; 2] {
        // The share of what the drops of a size block that those shown one by one block, up to a constant factor.
        let is_endless = self.extent == f64::INFINITY;
        let near = |mm: f64| match is_endless {
            true => mm,
            false => self.reach.drawn(mm, self.extent) / self.extent,
        };
        let far = |mm: f64| if is_endless { 1.0 } else { 1.0 - near(mm) };
        [shares_of(self.law, far, parts), shares_of(self.law, near, parts)]
    }
}

/// Number of the diameter above one, from the second on.
fn above(diameter: f64) -> usize {
    DIAMETERS.partition_point(|of| *of <= diameter).clamp(1, DIAMETERS.len() - 1)
}

fn on_a_line(diameter: f64) -> [f64; DIAMETERS.len()] {
    let above = above(diameter);
    let [from, to] = [DIAMETERS[above - 1], DIAMETERS[above]];
    let share = ((diameter - from) / (to - from)).clamp(0.0, 1.0);
    let mut parts = [0.0; DIAMETERS.len()];
    (parts[above - 1], parts[above]) = (1.0 - share, share);
    parts
}

/// By Lagrange's polynomials: each is 1 at its diameter, and 0 at the others.
fn on_a_cubic(diameter: f64) -> [f64; DIAMETERS.len()] {
    let first = above(diameter).saturating_sub(OF_CUBIC / 2).min(DIAMETERS.len() - OF_CUBIC);
    let at = flatness(diameter.min(DIAMETERS[DIAMETERS.len() - 1]));
    let mut parts = [0.0; DIAMETERS.len()];
    for of in first..first + OF_CUBIC {
        let others = (first..first + OF_CUBIC).filter(|other| *other != of);
        let factor = |other: usize| {
            let other = flatness(DIAMETERS[other]);
            (at - other) / (flatness(DIAMETERS[of]) - other)
        };
        parts[of] = others.map(factor).product();
    }
    parts
}

/// By how much a drop of a diameter in mm is lower than wide.
fn flatness(diameter: f64) -> f64 {
    if diameter > SMALLEST_FLATTENED { 1.0 - axis_ratio(diameter) } else { 0.0 }
}

/// The drops of a law, of which `part` counts by diameter.
fn shares_of(
    law: &Law,
    part: impl Fn(f64) -> f64,
    parts: fn(f64) -> [f64; DIAMETERS.len()],
) -> Shares {
    let sizes: Vec<_> = (0..SIZES)
        .map(|size| law.quantile(2.0, (f64::from(size) + 0.5) / f64::from(SIZES)))
        // No size is left out whole, so that there is a mean even of no drops.
        .map(|diameter| (diameter, part(diameter).max(1e-30), Halves::of_diameter(diameter)))
        .collect();
    let of_elevation = |number: usize| {
        let elevation = PI * (number as f64 / (ELEVATIONS - 1) as f64 - 0.5);
        let mut shares = [0.0; DIAMETERS.len()];
        for (diameter, part, halves) in &sizes {
            let outline = part * halves.outline_area(elevation.sin());
            let of_drop = parts(*diameter);
            shares.iter_mut().zip(of_drop).for_each(|(sum, part)| *sum += part * outline);
        }
        let all = shares.iter().sum::<f64>();
        shares.map(|share| share / all)
    };
    (0..ELEVATIONS).map(of_elevation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rain::law::marshall_palmer_slope;

    /// Against sums over many sizes, with the outline of a spheroid: seen along its axis larger than the sphere's by the axis
    /// ratio to the power of -2/3, seen square to that smaller by the ratio to 1/3. What is linear in the diameter keeps its mean.
    #[test]
    fn shares_have_the_mean_diameter_of_what_the_rain_blocks() {
        let law = Law {
            intercept: 8000.0,
            slope: marshall_palmer_slope(60.0),
            mu: 0.0,
            from: 0.5,
            to: 6.0,
        };
        let part = |diameter: f64| 1.0 / (1.0 + diameter);
        let shares = shares_of(&law, part, on_a_line);
        let found = |of: &[f64; DIAMETERS.len()]| -> f64 {
            assert!((of.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{of:?}");
            of.iter().zip(DIAMETERS).map(|(share, diameter)| share * diameter).sum()
        };
        // Straight down, as level as any, straight up.
        for (number, power) in
            [(0, -2.0 / 3.0), (ELEVATIONS / 2, 1.0 / 3.0), (ELEVATIONS - 1, -2.0 / 3.0)]
        {
            let mut sums = [0.0; 2];
            for size in 0..4000 {
                let diameter = law.quantile(2.0, (f64::from(size) + 0.5) / 4000.0);
                let blocks = part(diameter) * axis_ratio(diameter).powf(power);
                sums[0] += blocks;
                sums[1] += blocks * diameter.clamp(DIAMETERS[0], DIAMETERS[4]);
            }
            let (found, expected) = (found(&shares[number]), sums[1] / sums[0]);
            assert!((found / expected - 1.0).abs() < 0.005, "{found}, not {expected}");
        }
    }
}
