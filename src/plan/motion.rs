//! How drops are drawn that move while the shutter is open.

use super::Optics;
use crate::scene::Scene;
use crate::scene::model::{Motion, Primitive};
use crate::{Error, Result};

/// Largest way of drops in a box during an exposure, as a part of the box: what enters the box by one side within the
/// exposure is drawn where it leaves by the other.
const MOST_OF_BOX: f64 = 0.25;

/// The model of `scene`'s motion for drops that are drawn as `primitive` by `optics`.
///
/// # Errors
/// [`Error::Scene`] if it cannot be drawn so, with what can.
pub(super) fn motion_of(scene: &Scene, primitive: Primitive, optics: Optics) -> Result<Motion> {
    let asked = scene.model.motion;
    if scene.shutter() == 0.0 || asked == Some(Motion::Instant) {
        return Ok(Motion::Instant);
    }
    let refuse = |place: &str, problem: String| Err(Error::Scene { place: place.into(), problem });
    if primitive != Primitive::Tile {
        return refuse(
            "camera: shutter",
            format!(
                "a {primitive} is drawn at an instant; take preset fast, exact or auto, or motion = \"instant\""
            ),
        );
    }
    let usual = if optics == Optics::Appearance { Motion::Streak } else { Motion::Sampled };
    match asked {
        Some(Motion::Streak) if usual != Motion::Streak => {
            return refuse(
                "model",
                format!(
                    "motion streak has a far drop's colours from its table: optics must be appearance, not {optics}"
                ),
            );
        }
        Some(Motion::Sampled) if usual != Motion::Sampled => {
            return refuse(
                "model",
                format!("motion sampled follows rays: optics must be closed-form, not {optics}"),
            );
        }
        _ => {}
    }
    let part = scene.most_crossed();
    if part > MOST_OF_BOX {
        return refuse(
            "camera: shutter",
            format!(
                "while it is open the rain moves through {part:.2} of its box, and over {MOST_OF_BOX} no preset draws; \
                 shorten it, enlarge rain.half_extent, or use `raindrops reference`"
            ),
        );
    }
    Ok(usual)
}

/// What the passes do with drops that move, for the plan: of the small ones, and of the others.
/// `line_px`: of [`super::FramePlan`].
pub(super) fn in_words(motion: Motion, line_px: f32) -> (String, &'static str) {
    match motion {
        Motion::Instant => (String::new(), ""),
        Motion::Streak => (
            format!(
                "; those that move by over a pixel are streaks, the small and faint ones of one colour, along which \
                 a bare sun, if there is one, draws lines from {line_px} px of radius on"
            ),
            ", averaged over their way",
        ),
        Motion::Sampled => (String::new(), ", averaged over their way"),
    }
}
