//! How a pane of glass and the drops on it are drawn.

use super::FramePlan;
use crate::scene::Scene;
use crate::scene::model::{Optics, PaneModel, Primitive};
use crate::thousands::counted;
use crate::{Error, Result};

/// The model of `scene`'s pane before rain that is drawn as `primitive`; none without a pane.
///
/// # Errors
/// [`Error::Scene`] if it cannot be drawn so, with what can.
pub(super) fn pane_of(
    scene: &Scene,
    primitive: Primitive,
    optics: Optics,
) -> Result<Option<PaneModel>> {
    if scene.pane.is_none() {
        return Ok(None);
    }
    let is_by_rays = optics == Optics::ClosedForm;
    let usual = if is_by_rays { PaneModel::Exact } else { PaneModel::Picture };
    let model = scene.model.pane.unwrap_or(usual);
    let refuse =
        |problem: &str| Err(Error::Scene { place: "pane".into(), problem: problem.into() });
    if model == PaneModel::None {
        return Ok(Some(model));
    }
    if primitive != Primitive::Tile {
        return refuse(
            "a pane is drawn before tiles; take preset fast, exact or auto, or model.pane = \"none\"",
        );
    }
    Ok(Some(model))
}

/// The pass of a pane, if there is one, with its reason.
pub(super) fn in_words(scene: &Scene, plan: &FramePlan) -> Option<(&'static str, String)> {
    let model = plan.pane.filter(|_| plan.draws_pane())?;
    let drops = match scene.pane.as_ref()? {
        _ if scene.host_pane_drops > 0 => {
            format!("up to {} of a host's", counted(scene.host_pane_drops.into(), "drop"))
        }
        pane if pane.has_population() => "the drops of its rain".to_string(),
        pane => counted(pane.drops.len() as u64, "drop"),
    };
    let rays = match model {
        PaneModel::Picture if scene.drawn_lens() > 0.0 => {
            "by rays; those out of focus by a picture each, spread over the lens's disc, or one colour"
        }
        PaneModel::Color if scene.drawn_lens() > 0.0 => {
            "by rays; those out of focus by one colour each, spread over the lens's disc"
        }
        PaneModel::FirstExit => "by rays as far as they leave a drop first",
        _ => "by rays with up to eight reflections",
    };
    Some(("pane", format!("glass before the rain, {drops} on it {rays}")))
}
