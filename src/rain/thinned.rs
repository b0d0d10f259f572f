//! Thinned rain: few drops that stand for many. Of drops that are too small to be seen by themselves, but whose noise is
//! seen, a share is drawn, each as large as the largest of them; the medium has the rest of their light. So mean, variance,
//! and correlation between pixels and moments stay those of the rain, with a fraction of its drops.
//!
//! A share p = (ρ/ρt)⁴ of the drops with a radius of ρ pixels under ρt is drawn with 1/√p of their opacity, which is
//! that of a drop with radius ρt. The variance of so many is that of all, p (1/√p)² = 1; their mean is √p, and 1 - √p is
//! left to the medium. Their number between ρ and ρt is at most three times that of the drops over ρt, where that of all
//! goes as ρ⁻³.
//!
//! The drops of down to ρt/8^¼ are the rain's own. Beyond, where fewer than one in eight is drawn, they are those of a
//! rain of an eighth of the drops, so that eight times fewer cells are looked into; down to ρt/√8, where this ends.
//!
//! Error: no moment over the second is kept. Drops on both sides of the border are others than those of the whole rain,
//! and those that come nearer are exchanged there.

use crate::rain::classes::{self, Class};
use crate::rain::law::Law;
use crate::rain::visibility::Frustum;

/// Least radius of a drop that is drawn, over the largest of a thinned one.
pub const LEAST: f64 = 0.353_553_390_593_273_8; // 1/√8
/// Radius at which one drop in eight is drawn, over the largest of a thinned one: the end of the rain's own.
pub const OWN: f64 = 0.594_603_557_501_360_5; // 8^-¼
/// One in so many drops is in the rain beyond; by this its cells have twice the edge.
pub const FEWER: f64 = 8.0;
/// Classes of the rain beyond.
const CLASSES: u32 = 16;
/// Steps by which sizes are summed.
const STEPS: u32 = 32;

/// The classes of the rain beyond.
pub fn classes_beyond(law: &Law, air_density: f64) -> Vec<Class> {
    let fewer = |class: Class| Class { number: class.number / FEWER, ..class };
    classes::of_number(law, air_density, CLASSES).into_iter().map(fewer).collect()
}

/// Number of drops that a picture draws of those over `cutoff_px`, where those under `thinned_px` are thinned.
pub fn drops_drawn(frustum: &Frustum, law: &Law, cutoff_px: f64, thinned_px: f64) -> f64 {
    if thinned_px <= cutoff_px {
        return frustum.drops_above(law, cutoff_px);
    }
    let step = (thinned_px / cutoff_px).powf(f64::from(STEPS).recip());
    let edge = |number: u32| cutoff_px * step.powi(number as i32);
    let of_step = |number: u32| {
        let share = (edge(number) * step.sqrt() / thinned_px).powi(4);
        share
            * (frustum.drops_above(law, edge(number)) - frustum.drops_above(law, edge(number + 1)))
    };
    (0..STEPS).map(of_step).sum::<f64>() + frustum.drops_above(law, thinned_px)
}

/// How far drops are seen, in metres for each millimetre of diameter.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// To where all are drawn.
    pub all: f64,
    /// To where some are, at least as far.
    pub some: f64,
}

impl Reach {
    /// That of drops of over `cutoff_px`, thinned under `thinned_px` if that is more.
    pub fn new(focal_px: f64, cutoff_px: f64, thinned_px: f64) -> Self {
        let of_px = |px: f64| focal_px * 5e-4 / px;
        Self { all: of_px(thinned_px.max(cutoff_px)), some: of_px(cutoff_px) }
    }

    /// What a law's drops block up to `depth` and the medium has: ∫∫ N D² (1 - √p) dz dD, where `moment(k, from, to)` is
    /// ∫ N D²⁺ᵏ dD between diameters in mm.
    pub fn left_to_medium(&self, depth: f64, moment: impl Fn(usize, f64, f64) -> f64) -> f64 {
        // Larger ones are all drawn, smaller ones not at all.
        let (largest, smallest) = (depth / self.all, depth / self.some);
        let of_end = self.all * (2.0 - self.all / self.some);
        let beyond = depth * moment(0, 0.0, smallest) - of_end * moment(1, 0.0, smallest);
        let some = |k: usize| moment(k, smallest, largest);
        let within =
            depth * some(0) - 2.0 * self.all * some(1) + self.all * self.all / depth * some(2);
        if depth > 0.0 { (beyond + within).max(0.0) } else { 0.0 }
    }

    /// ∫ √p dz of drops of a diameter in mm up to `depth`: so much of the way they are drawn, weighted by their light.
    pub fn drawn(&self, diameter: f64, depth: f64) -> f64 {
        let (all, some) = (self.all * diameter, self.some * diameter);
        if depth <= all { depth } else { all * (2.0 - all / depth.min(some)) }
    }
}
