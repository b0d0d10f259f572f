//! The noise that single drops would make in the medium that stands for them: a factor on the medium's opacity, a number
//! a pixel and moment.
//!
//! Drops are Poisson, so the opacity of a pixel varies by s² = (π²/16) f² ∫ N D⁴ ∫ g dz/z² dD over all that are in the
//! medium (`Frustum::noise` has the terms). The factor is lognormal with mean 1 and the deviation that makes s of the
//! opacity, so the mean light stays, and no pixel has less than none.
//!
//! It is drawn from a lattice of random numbers that falls with drops of the median-volume size, where those are seen as
//! far as most of the noise is (their depth at the cut-off, twice over); a cell there is about a pixel, and as much longer
//! along the vertical as a streak is. Between numbers it is interpolated so that the variance is 1 everywhere. So the
//! noise stands still in the world when the camera turns, goes by no faster than drops do, and any time is as near as any
//! other.
//!
//! Error: all drops go at one speed at one distance; streaks are upright, and as many as in still air, whatever the
//! wind and the camera's velocity.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::f64::consts::PI;

use crate::abi::MEDIUM_DEPTHS;
use crate::rain::cells::{Lattice, Place};
use crate::rain::fall;
use crate::rain::law::Law;
use crate::rain::visibility::{depth_of_radius, radius_px, streak_px, variance_share};

/// Inverse depths at which the variance is tabulated, and sizes that it is summed over.
const DEPTHS: usize = MEDIUM_DEPTHS as usize;
const SIZES: usize = 64;

/// Variance of the optical depth on the view axis, by the cube root of the inverse depth, from the nearest on.
pub type Variances = [f32; DEPTHS];

/// The grain of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grained {
    /// The lattice that the noise is of.
    pub record: GrainRecord,
    /// How strong it is, by depth.
    pub variances: Variances,
}

/// The lattice of the grain, as `RainField` of `glsl/include/rain_field.glsl` has it; all 0 where there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GrainRecord {
    /// Number of the lattice's cell that the camera is in; a word of the rain's salt.
    base: [u32; 4],
    /// Where in it; depth in scene units from which on there is a medium, over 0.
    within: [f32; 4],
    /// Cells from the camera to where the noise is; the last is unused.
    scale: [f32; 4],
}

/// What a frame's grain is of.
pub struct Grain<'a> {
    /// The law of the drops' sizes.
    pub law: &'a Law,
    /// kg/m³.
    pub air_density: f64,
    /// Distance of the image plane in pixels.
    pub focal_px: f64,
    /// Least radius of a drop that is drawn by itself.
    pub cutoff_px: f64,
    /// For how long each drop is seen, in the rain's seconds.
    pub exposed: f64,
    /// Outlines of drops over those of their spheres.
    pub widened: f64,
}

impl Grain<'_> {
    /// The lattice that the shader reads: by that of the drops of the median size, and the camera's place in it; `way` is
    /// how far a drop moves while it is seen, in metres; `metres` are in a scene unit.
    pub fn record(
        &self,
        median: f64,
        lattice: &Lattice,
        camera: &Place,
        way: f64,
        metres: f64,
    ) -> GrainRecord {
        let far = 2.0 * depth_of_radius(self.focal_px, median, self.cutoff_px);
        let pixel = far / self.focal_px;
        let streak = streak_px(self.focal_px, way, 1.0, far);
        let log2 = (pixel * DVec3::new(1.0, 1.0 + streak, 1.0)).to_array().map(|edge| edge.log2());
        let (mut base, mut within, mut scale) = ([lattice.salt[0]; 4], [0.0; 4], [0.0; 4]);
        for axis in 0..3 {
            // A power of two of the cells' own, so that no number is torn.
            let edge = log2[axis].round() as i32;
            let bits = (32 + edge - lattice.log2_edge).clamp(0, 90);
            let place = i128::from(camera.cell[axis]) << 32 | i128::from(camera.fraction[axis]);
            base[axis] = (place >> bits) as u32;
            within[axis] = ((place & ((1 << bits) - 1)) as f64 / 2f64.powi(bits)) as f32;
            scale[axis] = (far / 2f64.powi(bits - 32 + lattice.log2_edge)) as f32;
        }
        within[3] = (self.nearest() / metres) as f32;
        GrainRecord { base, within, scale }
    }

    /// Depth from which on there is a medium, in metres.
    fn nearest(&self) -> f64 {
        depth_of_radius(self.focal_px, self.law.from, self.cutoff_px)
    }

    /// Variance of the optical depth up to depths whose inverse goes as the cube of a number from 1 to 0.
    pub fn variances(&self) -> Variances {
        let inverse = |i: usize| {
            let left = 1.0 - i as f64 / (DEPTHS - 1) as f64;
            left.powi(3) / self.nearest()
        };
        let mut variances = [0.0_f64; DEPTHS];
        let width = (self.law.to - self.law.from) / SIZES as f64;
        let all = PI * PI / 16.0 * self.focal_px.powi(2) * 1e-12 * self.widened.powi(2);
        for size in 0..SIZES {
            let from = self.law.from + width * size as f64;
            let (diameter, m4) =
                (from + 0.5 * width, self.law.moment_between(4.0, from, from + width));
            let speed = fall::density_factor(self.air_density)
                * fall::terminal_speed(diameter, fall::TABLE_AIR_DENSITY);
            let start = depth_of_radius(self.focal_px, diameter, self.cutoff_px).recip();
            let share = |inverse: f64| {
                let streak = self.focal_px * speed * self.exposed.abs() * inverse;
                let size = PI.sqrt() * radius_px(self.focal_px, diameter, 1.0) * inverse / 3.0;
                variance_share(size, streak)
            };
            let mut sum = 0.0;
            for (i, variance) in variances.iter_mut().enumerate().skip(1) {
                let (low, high) = (inverse(i), inverse(i - 1).min(start));
                if high > low {
                    let half = 0.5 * (high - low);
                    sum += half * (share(low + 0.5 * half) + share(high - 0.5 * half));
                }
                *variance += all * m4 * sum;
            }
        }
        variances.map(|variance| variance as f32)
    }
}
