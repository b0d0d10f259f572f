//! Far rain as a medium: drops that are too small in the picture to be drawn one by one take light out of a
//! ray and put in that of a far drop. Mean light and mean transmittance are those of the drops.
//!
//! A drop belongs to the medium where its radius is under the cut-off ρ* in pixels: large drops from farther
//! on than small ones. Of all ways to part the drops this one draws the fewest for a given noise: drops of
//! one pixel radius all count alike. A cut by distance draws 4 to 7 times as many.

use crate::rain::law::{Law, extinction};
use std::f64::consts::PI;

use crate::rain::fall;
use crate::rain::visibility::{Frustum, depth_of_radius};

/// Largest radius in pixels under which no single drop changes a pixel by `seen`, at a contrast between drops and
/// what is behind them; `exposed`: for how long each is seen, in seconds of the rain. Never over the largest cut-off
/// that a scene may name.
pub fn unseen_radius(law: &Law, air_density: f64, contrast: f64, seen: f64, exposed: f64) -> f64 {
    // At rest a drop takes π r² of its pixel.
    let at_rest = (seen / (PI * contrast)).sqrt();
    // A streak's opacity is its diameter over the way that it goes, whatever the distance, greatest for large drops.
    let speed =
        fall::density_factor(air_density) * fall::terminal_speed(law.to, fall::TABLE_AIR_DENSITY);
    let as_streak = 2.0 * seen / (PI * contrast) * speed * exposed.abs() / (1e-3 * law.to);
    // Two digits, so that the drops do not change with a texel.
    let radius = at_rest.max(as_streak).clamp(0.001, 1.0);
    let unit = 10f64.powf(radius.log10().floor() - 1.0);
    (radius / unit).round() * unit
}

/// Optical depth of the medium from the camera to `depth` metres.
pub fn optical_depth(law: &Law, focal_px: f64, cutoff_px: f64, depth: f64) -> f64 {
    let largest = 2e3 * cutoff_px * depth / focal_px;
    let (m2, m3) =
        (law.moment_between(2.0, law.from, largest), law.moment_between(3.0, law.from, largest));
    extinction(depth * m2 - depth_of_radius(focal_px, 1.0, cutoff_px) * m3).max(0.0)
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
