//! The frame plan: which passes and models a scene requires, and why. A pure function of the scene.

use crate::model::{Operator, Optics, Order, Preset, Primitive, Simulation};
use crate::scene::Scene;
use crate::{Error, Result};

/// Radius in pixels from which a drop is drawn by rays rather than by its prefiltered picture: the
/// finest has 16 texels an edge, and above this one sees them.
const RAYS_PX: f32 = 8.0;

/// What a frame is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Linear radiance.
    Radiance,
    /// Display colour.
    Display,
}

/// One model on every axis, and the passes that follow from them.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlan {
    /// The preset that it started from.
    pub preset: Preset,
    /// How the light leaving a drop is found.
    pub optics: Optics,
    /// What a drop is drawn as.
    pub primitive: Primitive,
    /// In which order drops are composited.
    pub order: Order,
    /// Where positions come from.
    pub simulation: Simulation,
    /// Edge of the mask's finest level.
    pub mask_size: u32,
    /// Radius in pixels from which a drop's pixels are computed apart, by rays.
    pub rays_px: f32,
    /// Rays a pixel of drops that are followed by rays.
    pub samples: u32,
    /// Most reflections inside a drop that are followed.
    pub internal_reflections: u32,
    /// The display pass; none for a radiance output.
    pub tone_map: Option<Operator>,
    /// Every pass in the order of the frame, with its reason.
    pub passes: Vec<(&'static str, String)>,
}

/// What `scene` requires for `output`.
///
/// # Errors
/// [`Error::Scene`] for a combination of models that makes no sense, with the reason.
pub fn plan(scene: &Scene, output: Output) -> Result<FramePlan> {
    let choice = &scene.model;
    let (optics, samples) = match choice.preset {
        Preset::Paper => (Optics::Mask, 1),
        Preset::Fast => (Optics::Appearance, 4),
        Preset::Exact => (Optics::ClosedForm, 16),
    };
    let optics = choice.optics.unwrap_or(optics);
    let is_mask = matches!(optics, Optics::Mask | Optics::MaskF32);
    // The optics decide what a drop can be drawn as, and that in which order.
    let (primitive, order) = if is_mask {
        (Primitive::Point, Order::Unsorted)
    } else {
        (Primitive::Tile, Order::Sorted)
    };
    let refuse = |problem: String| Err(Error::Scene { place: "model".into(), problem });
    if let Some(wanted) = choice.primitive.filter(|wanted| *wanted != primitive) {
        return refuse(format!("optics {optics} is drawn as {primitive}, not as {wanted}"));
    }
    if let Some(wanted) = choice.order.filter(|wanted| *wanted != order) {
        return refuse(format!("{primitive} drops are composited {order}, not {wanted}"));
    }
    let simulation = choice.simulation.unwrap_or(Simulation::Integer);
    if simulation == Simulation::Stored && !is_mask {
        return refuse(format!(
            "stored positions belong to the paper's points; optics {optics} keeps drops in cells, \
             which only exact positions do not leave"
        ));
    }
    if is_mask && choice.samples.is_some_and(|samples| samples > 1) {
        return refuse(format!("optics {optics} looks up one texel a pixel: samples must be 1"));
    }
    let internal_reflections = choice.internal_reflections.unwrap_or(if is_mask { 0 } else { 2 });
    if is_mask && internal_reflections > 0 {
        return refuse(format!("optics {optics} holds no internal reflections"));
    }
    let tone_map = (output == Output::Display).then_some(scene.tone_map.operator);
    let plan = FramePlan {
        preset: choice.preset,
        optics,
        primitive,
        order,
        simulation,
        mask_size: choice.mask_size,
        rays_px: if optics == Optics::Appearance { RAYS_PX } else { 0.0 },
        samples: choice.samples.unwrap_or(samples),
        internal_reflections,
        tone_map,
        passes: Vec::new(),
    };
    Ok(FramePlan { passes: passes(scene, &plan), ..plan })
}

fn passes(scene: &Scene, plan: &FramePlan) -> Vec<(&'static str, String)> {
    let mut passes: Vec<(&'static str, String)> = Vec::new();
    let count = scene.drop_count();
    match plan.primitive {
        Primitive::Point => {
            if count > 0 {
                passes.push(("simulate", format!("{count} drops move ({})", plan.simulation)));
            }
            passes.push(("sky", "the environment behind the drops".into()));
            if count > 0 {
                let optics = plan.optics;
                passes.push(("drops", format!("each drop in view as a point, optics by {optics}")));
            }
        }
        Primitive::Tile => {
            passes.push(("cells", "whole cells of the rain out of view are passed over".into()));
            passes.push(("gather", format!("of {count} drops those in the cells in view move")));
            passes.push(("lists", "the drops of each tile, in exact order".into()));
            let optics = plan.optics;
            passes.push(("composite", format!("drops by {optics} over the sky, front to back")));
        }
    }
    match plan.tone_map {
        Some(Operator::Photographic) => {
            passes.push(("log luminance", "the photographic operator's exposure".into()));
            passes.push(("tone map", "a display output, photographic operator".into()));
        }
        Some(Operator::None) => passes.push(("tone map", "a display output, clipped".into())),
        None => {}
    }
    passes
}
