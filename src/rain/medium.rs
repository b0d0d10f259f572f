//! Far rain as a medium: drops that are too small in the picture to be drawn one by one take light out of a
//! ray and put in that of a far drop. Mean light and mean transmittance are those of the drops.
//!
//! A drop belongs to the medium where its radius is under the cut-off ρ* in pixels: large drops from farther
//! on than small ones. Of all ways to part the drops this one draws the fewest for a given noise: drops of
//! one pixel radius all count alike. A cut by distance draws 4 to 7 times as many.

use crate::rain::law::{Law, extinction};
use std::f64::consts::PI;

use crate::rain::shape::Halves;
use crate::rain::thinned::Reach;
use crate::rain::visibility::{Frustum, depth_of_radius};

/// Largest radius in pixels under which no single drop at rest changes a pixel by `seen`, at a contrast between drops
/// and what is behind them. Never over the largest cut-off that a scene may name.
pub fn unseen_radius(contrast: f64, seen: f64) -> f64 {
    // It takes π r² of its pixel.
    let radius = (seen / (PI * contrast)).sqrt().clamp(0.001, 1.0);
    // Two digits, so that the drops do not change with a texel.
    let unit = 10f64.powf(radius.log10().floor() - 1.0);
    (radius / unit).round() * unit
}

/// Optical depth of the medium from the camera to `depth` metres, if single drops are seen so far.
pub fn optical_depth(law: &Law, reach: Reach, depth: f64) -> f64 {
    let moment = |k: usize, from: f64, to: f64| law.moment_between(2.0 + k as f64, from, to);
    extinction(reach.left_to_medium(depth, moment))
}

/// Diameters of a law in so many equal steps, whose drops have one outline.
const STEPS: usize = 48;

/// The outlines of a law's drops that are no spheres: of all that are smaller than each of its steps, the moments by which
/// they block light, seen level and from below.
#[derive(Clone, Debug)]
pub struct Outlines {
    law: Law,
    /// Diameter in mm; ∫ N D^k A dD up to it, of k 2 to 4, A the outline's area over the sphere's: level, from below.
    below: Vec<(f64, [[f64; 2]; 3])>,
    /// Outline's area over the sphere's in the step after each of them: level, from below.
    areas: Vec<[f64; 2]>,
}

impl Outlines {
    /// The outlines of a law's drops, which have the equilibrium shape.
    pub fn new(law: &Law) -> Self {
        let width = (law.to - law.from) / STEPS as f64;
        let below = vec![(law.from, [[0.0; 2]; 3])];
        let mut outlines = Self { law: *law, below, areas: Vec::new() };
        for step in 0..STEPS {
            let from = law.from + width * step as f64;
            let halves = Halves::of_diameter(from + 0.5 * width);
            outlines.areas.push([0.0, 1.0].map(|sine| halves.outline_area(sine)));
            let moments = outlines.moments(from + width);
            outlines.below.push((from + width, moments));
        }
        outlines
    }

    /// ∫ N D^k A dD of the drops under a diameter in mm: by k, 2 to 4, each level and from below.
    fn moments(&self, diameter: f64) -> [[f64; 2]; 3] {
        let step =
            self.below.partition_point(|(edge, _)| *edge <= diameter).clamp(1, self.areas.len())
                - 1;
        let (from, known) = self.below[step];
        [0, 1, 2].map(|k: usize| {
            let rest = self.law.moment_between(2.0 + k as f64, from, diameter);
            std::array::from_fn(|seen| known[k][seen] + self.areas[step][seen] * rest)
        })
    }

    /// [`optical_depth`], level and from below.
    pub fn optical_depth(&self, reach: Reach, depth: f64) -> [f64; 2] {
        std::array::from_fn(|seen| {
            let moment = |k: usize, from: f64, to: f64| {
                let below = |diameter| self.moments(diameter)[k][seen];
                below(to) - below(from)
            };
            extinction(reach.left_to_medium(depth, moment))
        })
    }

    /// Extinction a metre, level and from below.
    pub fn extinction(&self) -> [f64; 2] {
        self.moments(self.law.to)[0].map(extinction)
    }
}

/// Depth in metres from which on all rain is medium.
pub fn starts(law: &Law, focal_px: f64, cutoff_px: f64) -> f64 {
    depth_of_radius(focal_px, law.to, cutoff_px)
}

/// Distance in metres at which a black object has 5 % contrast against the horizon's sky.
pub fn visibility(extinction: f64) -> f64 {
    20.0_f64.ln() / extinction
}

/// Largest cut-off at which a picture holds `drops` drops, if the rain has no end.
pub fn cutoff_of_budget(law: &Law, frustum: &Frustum, drops: f64) -> f64 {
    let at_one = Frustum { extent: f64::INFINITY, ..*frustum }.drops_above(law, 1.0);
    (at_one / drops).cbrt()
}

/// Depths at which a medium's optical depth is tabulated.
const DEPTHS: usize = crate::abi::MEDIUM_DEPTHS as usize;

/// The medium of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumRecord {
    /// Depth from which on all rain is medium; extinction a scene unit, seen level; distance of the rain's end; extinction
    /// seen from below, over 0.
    pub range: [f32; 4],
    /// Optical depth along the view axis at depths up to the first of these, equally far apart: seen level.
    pub optical_depths: [f32; DEPTHS],
    /// Optical depths at these depths, seen from below.
    pub from_below: [f32; DEPTHS],
}

impl MediumRecord {
    /// That of a law's drops in a picture, with the `outlines` of those that are drawn flattened; those under `thinned_px` are thinned
    /// ([`crate::rain::thinned`]); rain to `extent` metres, in scene units of so many metres.
    pub fn new(
        law: &Law,
        outlines: Option<&Outlines>,
        (focal_px, cutoff_px, thinned_px): (f64, f64, f64),
        extent: f64,
        metres: f64,
    ) -> Self {
        let starts = starts(law, focal_px, cutoff_px);
        let reach = Reach::new(focal_px, cutoff_px, thinned_px);
        let depth_of = |i: usize| starts * i as f64 / (DEPTHS - 1) as f64;
        let optical: [[f64; 2]; DEPTHS] = std::array::from_fn(|i| match outlines {
            Some(outlines) => outlines.optical_depth(reach, depth_of(i)),
            None => [optical_depth(law, reach, depth_of(i)); 2],
        });
        let extinction = outlines.map_or([law.extinction(); 2], Outlines::extinction);
        let [level, from_below] = extinction.map(|extinction| (extinction * metres) as f32);
        let end = (extent / metres).min(f64::from(f32::MAX));
        Self {
            range: [(starts / metres) as f32, level, end as f32, from_below],
            optical_depths: optical.map(|[level, _]| level as f32),
            from_below: optical.map(|[_, from_below]| from_below as f32),
        }
    }
}
