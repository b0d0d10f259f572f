//! The frame plan: which passes and models a scene requires, and why. A pure function of the scene.

use crate::model::{Operator, Optics, Order, Preset, Primitive, Simulation};
use crate::scene::Scene;

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
    /// The display pass; none for a radiance output.
    pub tone_map: Option<Operator>,
    /// Every pass in the order of the frame, with its reason.
    pub passes: Vec<(&'static str, String)>,
}

/// What `scene` requires for `output`.
pub fn plan(scene: &Scene, output: Output) -> FramePlan {
    let choice = &scene.model;
    let (optics, primitive, order, simulation) = match choice.preset {
        Preset::Paper => (Optics::Mask, Primitive::Point, Order::Unsorted, Simulation::Integer),
    };
    let optics = choice.optics.unwrap_or(optics);
    let simulation = choice.simulation.unwrap_or(simulation);
    let tone_map = (output == Output::Display).then_some(scene.tone_map.operator);

    let mut passes = Vec::new();
    if scene.drop_count() > 0 {
        passes.push(("simulate", format!("{} drops move ({simulation})", scene.drop_count())));
        passes.push(("order large", "drops over the point size go back to front as quads".into()));
    }
    passes.push(("sky", "the environment behind the drops".into()));
    if scene.drop_count() > 0 {
        passes.push(("drops", format!("each drop in view as a {primitive}, optics by {optics}")));
    }
    match tone_map {
        Some(Operator::Photographic) => {
            passes.push(("log luminance", "the photographic operator's exposure".into()));
            passes.push(("tone map", "a display output, photographic operator".into()));
        }
        Some(Operator::None) => passes.push(("tone map", "a display output, clipped".into())),
        None => {}
    }
    FramePlan {
        preset: choice.preset,
        optics,
        primitive: choice.primitive.unwrap_or(primitive),
        order: choice.order.unwrap_or(order),
        simulation,
        mask_size: choice.mask_size,
        tone_map,
        passes,
    }
}
