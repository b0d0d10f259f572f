//! Which combinations of models, and of models with what a scene has, make no sense.

use super::light::of_water;
use super::{Models, Output, SPLAT_PX};
use crate::optics::WATER;
use crate::scene::Scene;
use crate::scene::model::{Optics, Order, Preset, Primitive, Simulation};
use crate::{Error, Result};

/// Refuses the first that does not go with what stands before it; `is_chosen`: by preset `auto`.
///
/// # Errors
/// [`Error::Scene`], with the reason.
pub(super) fn check(scene: &Scene, models: Models, is_chosen: bool, output: Output) -> Result<()> {
    let Models { optics, primitive, order, simulation, samples } = models;
    let choice = &scene.model;
    let (is_tile, on_tiles) = (primitive == Primitive::Tile, optics.is_on_tiles());
    let refuse = |problem: String| Err(Error::Scene { place: "model".into(), problem });
    if is_tile && choice.preset == Preset::PaperCompact {
        return refuse("preset paper-compact draws points or quads; tiles cull by clusters".into());
    }
    if is_tile && optics == Optics::Far {
        return refuse(format!(
            "optics far is not drawn as tile: there, appearance takes two colours for drops under \
                 {} pixels of radius, and better pictures for larger ones",
            SPLAT_PX[2]
        ));
    }
    if is_tile && !on_tiles {
        return refuse(format!("optics {optics} is drawn as point or quad, not as tile"));
    }
    if let (false, Some(rain)) = (is_tile, scene.real_rain()) {
        return refuse(format!(
            "rain.rate = {} makes drops of many sizes, which are drawn as tile, not as {primitive}; take preset \
             fast, exact or auto",
            rain.rate
        ));
    }
    if !on_tiles && scene.indices() != of_water() {
        return refuse(format!(
            "optics {optics} has water's index {WATER} alone; take preset fast, exact or auto"
        ));
    }
    if !is_tile && scene.shelter.is_some() {
        return refuse(format!(
            "a shelter keeps rain off that is drawn as tile, not as {primitive}; take preset fast, exact or auto"
        ));
    }
    if !is_tile && !scene.background.is_none() {
        return refuse(format!(
            "a background is drawn behind tiles, not behind a {primitive}; take preset fast, exact or auto"
        ));
    }
    if output == Output::Layers && !is_tile {
        return refuse(format!(
            "layers are made of tiles, not of drops drawn as {primitive}; take preset fast, exact or auto"
        ));
    }
    if is_tile != (order == Order::Sorted) {
        return refuse(if is_tile {
            format!("tiles hold their drops in exact order: order must be sorted, not {order}")
        } else {
            format!("order sorted is that of tiles; a {primitive} is blended as it comes")
        });
    }
    if simulation == Simulation::Stored && is_tile {
        return refuse(
            "stored positions belong to the paper's points; tiles keep drops in clusters, which only \
             exact positions do not leave"
                .into(),
        );
    }
    if samples > 1 && optics.is_prefiltered() && !is_tile {
        return refuse(format!(
            "optics {optics} is integrated before the frame: samples must be 1"
        ));
    }
    if choice.splat_px.is_some() && !is_chosen && !(is_tile && optics == Optics::Appearance) {
        return refuse(format!(
            "splat_px is for optics appearance on tiles, not for {optics} as {primitive}; take preset fast"
        ));
    }
    if choice.thinned_px.is_some() && !is_chosen && optics != Optics::Appearance {
        return refuse(format!(
            "thinned_px is for optics appearance, not for {optics}, which draws each drop as it is; take preset fast"
        ));
    }
    if choice.internal_reflections.is_some_and(|orders| orders > 0) && optics.is_mask() {
        return refuse(format!("optics {optics} holds no internal reflections"));
    }
    Ok(())
}
