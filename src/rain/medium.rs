//! Far rain as a medium: drops that are too small in the picture to be drawn one by one take light out of a
//! ray and put in that of a far drop. Mean light and mean transmittance are those of the drops.
//!
//! A drop belongs to the medium where its radius is under the cut-off ρ* in pixels: large drops from farther
//! on than small ones. Of all ways to part the drops this one draws the fewest for a given noise: drops of
//! one pixel radius all count alike. A cut by distance draws 4 to 7 times as many.

use crate::rain::law::{Law, extinction};
use crate::rain::visibility::{Frustum, depth_of_radius};
use crate::scene::ModelChoice;
use crate::scene::model::FarRain;

/// Cut-off in pixels where none is given. A single drop under it changes a pixel by less than 1/255 at a
/// contrast of 0.5.
pub const CUTOFF_PX: f64 = 0.05;

/// Most drops that a picture draws one by one where no cut-off is given: the paper's largest scene. What is
/// over it goes into the medium.
pub const MOST_DROPS: f64 = 4e6;

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

/// Most drops that a picture draws one by one where the scene asks for them.
pub const MOST_ASKED: f64 = 8e6;

/// The cut-off in pixels for a picture, and why. 0: every drop is drawn.
pub fn cutoff(law: &Law, frustum: &Frustum, model: &ModelChoice) -> (f64, String) {
    let (wanted, why, most) = match (model.far_rain, model.cutoff_px) {
        (Some(FarRain::Drops), _) => (0.0, "far_rain = \"drops\"", MOST_ASKED),
        (_, Some(cutoff_px)) => (cutoff_px, "as the scene says", MOST_ASKED),
        _ => (CUTOFF_PX, "no smaller drop shows by 1/255 at half the contrast", MOST_DROPS),
    };
    let drops = frustum.drops_above(law, wanted);
    if drops <= most {
        return (wanted, why.into());
    }
    let cutoff_px = cutoff_of_budget(law, frustum, most);
    let (most, drops) = (most * 1e-6, drops * 1e-6);
    (
        cutoff_px,
        format!(
            "{most:.0} million drops are drawn at most, and {drops:.3e} million are over {wanted} px"
        ),
    )
}

/// Largest cut-off at which a picture holds `drops` drops, if the rain has no end.
pub fn cutoff_of_budget(law: &Law, frustum: &Frustum, drops: f64) -> f64 {
    let at_one = Frustum { extent: f64::INFINITY, ..*frustum }.drops_above(law, 1.0);
    (at_one / drops).cbrt()
}
