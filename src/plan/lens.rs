//! How drops out of focus are drawn.

use super::Optics;
use crate::scene::Scene;
use crate::scene::model::{Lens, Primitive};
use crate::{Error, Result};

/// Widest lens and nearest focus that are drawn, in scene units: beyond them float32 tells no blur.
const MOST_APERTURE: f64 = 1e6;
const LEAST_FOCUS: f64 = 1e-6;

/// The model of `scene`'s lens for drops that are drawn as `primitive` by `optics`.
///
/// # Errors
/// [`Error::Scene`] if it cannot be drawn so, with what can.
pub(super) fn lens_of(scene: &Scene, primitive: Primitive, optics: Optics) -> Result<Lens> {
    let (camera, asked) = (&scene.camera, scene.model.lens);
    if scene.drawn_lens() == 0.0 {
        return Ok(Lens::Pinhole);
    }
    let refuse = |place: &str, problem: String| Err(Error::Scene { place: place.into(), problem });
    if primitive != Primitive::Tile {
        return refuse(
            "camera: aperture",
            format!(
                "a {primitive} is drawn through a pinhole; take preset fast, exact or auto, or lens = \"pinhole\""
            ),
        );
    }
    if camera.aperture > MOST_APERTURE || camera.focus < LEAST_FOCUS {
        return refuse(
            "camera",
            format!(
                "aperture = {} and focus = {}: no preset draws a lens wider than {MOST_APERTURE:e} scene units, or a \
                 focus nearer than {LEAST_FOCUS:e}; `raindrops reference` does",
                camera.aperture, camera.focus
            ),
        );
    }
    let usual = if optics == Optics::Appearance { Lens::Disc } else { Lens::Sampled };
    match asked {
        Some(Lens::Disc) if usual != Lens::Disc => refuse(
            "model",
            format!(
                "lens disc has a far drop's colours from its table: optics must be appearance, not {optics}"
            ),
        ),
        Some(Lens::Sampled) if usual != Lens::Sampled => refuse(
            "model",
            format!("lens sampled follows rays: optics must be closed-form, not {optics}"),
        ),
        _ => Ok(usual),
    }
}

/// What the passes do with drops out of focus, for the plan: of the small ones, and of the others.
pub(super) fn in_words(lens: Lens) -> (&'static str, &'static str) {
    match lens {
        Lens::Pinhole => ("", ""),
        Lens::Disc => (
            "; those out of focus by over half a pixel are discs, the small and faint ones of one colour",
            ", spread over the lens's disc",
        ),
        Lens::Sampled => ("", ", each ray from a place on the lens"),
    }
}
