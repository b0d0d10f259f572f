//! The frame plan: which passes and models a scene requires, and why. A pure function of the scene.

mod auto;
mod axes;
mod background;
mod costs;
mod cutoff;
mod demand;
mod errors;
mod lens;
mod light;
mod motion;
mod overlap;
mod pane;
mod rays;
mod refused;
mod requirements;
mod shape;

pub use auto::{Choice, Prospect, choose, expected_ms, keep, pick, prospects};
pub use axes::Axes;
pub use costs::Costs;
pub use cutoff::Cutoff;
pub use demand::{Demand, SizeClass, contrast};
pub use errors::{ERRORS, GLINT_RADII_PX, GLINTS, RADII_PX};
pub use light::Light;
pub use requirements::requirements;
pub use shape::DrawnShape;

use self::rays::{DrawnRays, rays_of};
use crate::Result;
use crate::environment::Environment;
use crate::rain::visibility::Frustum;
use crate::rain::{medium, thinned};
use crate::remark::Remark;
use crate::scene::model::{
    FarRain, Lens, Motion, Operator, Optics, Order, PaneModel, Preset, Primitive, Simulation,
};
use crate::scene::real_rain::RealRain;
use crate::scene::{ModelChoice, Scene};
use crate::thousands::counted;

/// Nearer than so many radii a drop does not look as from afar: rays at its rim are off by over 1.8°.
/// `glsl/include/tile_drop.glsl` has the same limit.
const NEAR_RADII: f64 = 32.0;

/// Radii in pixels under which a drop shows two colours, the means of its upper and its lower half: the first over which
/// few drops are expected, else the last.
const SPLAT_PX: [f32; 3] = [0.7, 1.0, 1.5];
/// So few, that is. A picture takes half a microsecond of two CPU cores more than two colours.
const FEW_LARGER: f64 = 2000.0;

/// Radii in pixels from which on a bright source draws lines along the streak of a drop: the first over which few drops are
/// expected, else the last.
const LINE_PX: [f32; 5] = [1.5, 2.0, 3.0, 5.0, 8.0];
/// So few, that is. Each of their pixels takes 10 ns of two CPU cores.
const FEW_LINED: f64 = 100.0;

/// What a frame is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Linear radiance.
    Radiance,
    /// Display colour.
    Display,
    /// Premultiplied rain over nothing, and what each pixel's nearest drop is.
    Layers,
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
    /// Whether points and quads are drawn for the drops in view alone, not for every drop.
    pub compacts: bool,
    /// Edge of the mask's finest level.
    pub mask_size: u32,
    /// Radius in pixels under which a drop on tiles has two colours.
    pub splat_px: f32,
    /// Radius in pixels from which on a bright source draws lines along a drop's streak.
    pub line_px: f32,
    /// Radius in pixels from which a drop's pixels are computed apart, by rays.
    pub rays_px: f32,
    /// Places in a pixel that a drop's light is the mean of; of tiles, where rays are followed.
    pub samples: u32,
    /// Rays of a pixel at most, where a drop's light changes fast.
    pub most_rays: u32,
    /// Rays of a pixel at most, where those do not tell its light.
    pub unsure_rays: u32,
    /// How drops are shown that move while the shutter is open.
    pub motion: Motion,
    /// How drops out of focus are shown.
    pub lens: Lens,
    /// In what shape drops are drawn that are no spheres.
    pub shape: DrawnShape,
    /// How a pane and its drops are drawn; none without a pane.
    pub pane: Option<PaneModel>,
    /// What a drop does to a ray of light.
    pub light: Light,
    /// Factor on the room for drops in view and for their tile fragments; 1 but where a host's view has grown.
    pub room: u32,
    /// From which size on drops of real rain are drawn one by one; none without real rain.
    pub cutoff: Option<Cutoff>,
    /// The display pass; none for a radiance output.
    pub tone_map: Option<Operator>,
    /// Whether the display pass derives its exposure from the picture's log-average luminance.
    pub log_average: bool,
    /// Whether the rain is drawn over nothing.
    pub layers: bool,
    /// Whether each pixel's nearest drop is found.
    pub nearest: bool,
    /// Why preset `auto` chose these models.
    pub why: Option<String>,
    /// Why they may not keep the error that was accepted.
    pub doubt: Option<String>,
    /// Which drops intersect, whose order is not that of each pixel.
    pub overlap: Option<String>,
    /// Every pass in the order of the frame, with its reason.
    pub passes: Vec<(&'static str, String)>,
}

impl FramePlan {
    /// That it may not keep the error that was accepted, what it leaves out of layers, and which drops' order is coarse.
    pub fn remarks(&self) -> Vec<Remark> {
        let doubts = self.doubt.iter().chain(&self.overlap).map(Remark::warning);
        let is_flat = self.layers && (self.motion == Motion::Streak || self.lens == Lens::Disc);
        let flat = is_flat.then(|| {
            Remark::warning(
                "streaks and discs of one colour are in R, G, B and A, but not in Z, motion, count and id; these have \
                 every drop with shutter = 0 and aperture = 0, or preset exact",
            )
        });
        doubts.chain(flat).collect()
    }
}

impl FramePlan {
    /// Whether the medium of far rain has the noise of single drops.
    pub fn is_grainy(&self) -> bool {
        self.cutoff.as_ref().is_some_and(|cutoff| cutoff.is_grainy)
    }

    /// Whether a pane is drawn.
    pub fn draws_pane(&self) -> bool {
        self.pane.is_some_and(|model| model != PaneModel::None)
    }

    /// Whether both draw by the same models, and so by the same pipelines and tables.
    pub fn has_models_of(&self, other: &Self) -> bool {
        let models = |plan: &Self| Self {
            cutoff: None,
            why: None,
            doubt: None,
            passes: Vec::new(),
            ..plan.clone()
        };
        models(self) == models(other)
    }
}

/// By which models drops are found, lit and put together.
#[derive(Clone, Copy)]
struct Models {
    optics: Optics,
    primitive: Primitive,
    order: Order,
    simulation: Simulation,
    samples: u32,
}

impl Models {
    /// What a scene asks for, else what `auto` has chosen, else the preset's.
    fn of(choice: &ModelChoice, chosen: Option<&Choice>) -> Self {
        let (optics, samples) = match (choice.preset, chosen) {
            (_, Some(chosen)) => (chosen.optics, chosen.samples),
            (Preset::Fast, _) => (Optics::Appearance, 1),
            (Preset::Exact, _) => (Optics::ClosedForm, 16),
            _ => (Optics::Mask, 1),
        };
        let optics = choice.optics.unwrap_or(optics);

        // The preset decides what a drop is drawn as where the optics leave a choice.
        let primitive = choice.primitive.unwrap_or(match (choice.preset, chosen) {
            (_, Some(chosen)) if choice.optics.is_none() => chosen.primitive,
            (Preset::Auto, _) if auto::asks_for_billboards(choice) => Primitive::Point,
            (Preset::Fast | Preset::Exact | Preset::Auto, _) if optics.is_on_tiles() => {
                Primitive::Tile
            }
            _ => Primitive::Point,
        });
        let is_tile = primitive == Primitive::Tile;
        let order = if is_tile { Order::Sorted } else { Order::Unsorted };
        Self {
            optics,
            primitive,
            order: choice.order.unwrap_or(order),
            simulation: choice.simulation.unwrap_or(Simulation::Integer),
            samples: choice.samples.unwrap_or(if is_tile { samples } else { 1 }),
        }
    }
}

/// What `scene` requires for `output`; by preset `auto` what is expected to do, at stated costs of no device
/// in particular ([`Costs::default`]).
///
/// # Errors
/// [`crate::Error::Scene`] for a combination of models that makes no sense, with the reason; for a key of the scene
/// that no preset draws.
pub fn plan(scene: &Scene, environment: &Environment, output: Output) -> Result<FramePlan> {
    let chosen = choose(&scene.whole(), environment, &Costs::default());
    plan_by(scene, environment, chosen.as_ref(), output)
}

/// Like [`plan`], with the choice of preset `auto` made; `None` for another preset.
///
/// # Errors
/// Like [`plan`].
pub fn plan_by(
    scene: &Scene,
    environment: &Environment,
    chosen: Option<&Choice>,
    output: Output,
) -> Result<FramePlan> {
    scene.expect_particles()?;
    scene.expect_shelter()?;
    let models = Models::of(&scene.model, chosen);
    refused::check(scene, models, chosen.is_some(), output)?;
    let Models { optics, primitive, order, simulation, samples } = models;
    let by_pictures = optics == Optics::Appearance;
    let rays = rays_of(scene, models, chosen.is_some());
    let DrawnRays { from_px: rays_px, most: most_rays, unsure: unsure_rays, picture_level } = rays;
    let shape = shape::shape_of(scene, primitive, optics, rays_px)?;
    let light = Light::of(scene, models, chosen, shape.is_traced(), picture_level);
    let motion = motion::motion_of(scene, primitive, optics)?;
    let lens = lens::lens_of(scene, primitive, optics)?;
    let choice = &scene.model;
    let by_scene = || first_over_few(scene, &SPLAT_PX, FEW_LARGER);
    let splat_px = choice.splat_px.unwrap_or_else(by_scene);
    let plan = FramePlan {
        preset: choice.preset,
        optics,
        primitive,
        order,
        simulation,
        compacts: choice.preset == Preset::PaperCompact,
        mask_size: choice.mask_size,
        splat_px: if by_pictures { splat_px } else { 0.0 },
        line_px: first_over_few(scene, &LINE_PX, FEW_LINED),
        rays_px: if by_pictures { rays_px } else { 0.0 },
        samples,
        most_rays,
        unsure_rays,
        motion,
        lens,
        shape,
        pane: pane::pane_of(scene, primitive, optics)?,
        light,
        room: 1,
        cutoff: scene.real_rain().map(|rain| match by_pictures {
            true => Cutoff::thinned(scene, &rain, environment),
            false => Cutoff::of(scene, &rain, environment),
        }),
        tone_map: (output == Output::Display).then_some(scene.tone_map.operator),
        log_average: output == Output::Display && scene.tone_map.derives_exposure(),
        layers: output == Output::Layers,
        nearest: output == Output::Layers,
        doubt: chosen.and_then(|chosen| chosen.doubt.clone()),
        why: chosen.map(|chosen| chosen.reason.clone()),
        overlap: overlap::in_words(scene).filter(|_| primitive == Primitive::Tile),
        passes: Vec::new(),
    };
    Ok(FramePlan { passes: passes(scene, &plan), ..plan })
}

/// The first of some radii in pixels over which so few drops are expected, else the last.
fn first_over_few(scene: &Scene, radii: &[f32], few: f64) -> f32 {
    let is_enough = |px: &&f32| demand::drops_above(scene, f64::from(**px)) < few;
    *radii.iter().find(is_enough).unwrap_or(&radii[radii.len() - 1])
}

/// What is passed over, what stands behind, and how many drops there are.
fn of_real_rain(scene: &Scene, rain: &RealRain, cutoff: &Cutoff) -> (String, String, String) {
    let (law, frustum) = (rain.law(), Frustum::of(&scene.view(), rain.extent));
    let Cutoff { px: cutoff_px, thinned_px, why, noise, is_grainy } = cutoff;
    let drops = thinned::drops_drawn(&frustum, &law, *cutoff_px, *thinned_px);
    let drops = counted(drops.round() as u64, "drop");
    let drops = format!("some {drops}");
    let skipped = "cells of the rain out of view, or too far for any of their drops to be seen, are passed over";
    let alone = format!("drops of over {cutoff_px:.3} px of radius are shown one by one ({why})");
    let alone = match *thinned_px > *cutoff_px {
        true => format!("{alone}, of those under {thinned_px:.3} px a few that stand for all"),
        false => alone,
    };
    let far = match scene.model.far_rain {
        Some(FarRain::None) => "the others are left out".to_string(),
        _ if *cutoff_px == 0.0 => "none is left".to_string(),
        _ => {
            let from = medium::starts(&law, frustum.focal_px, *cutoff_px);
            let noise = 255.0 * noise;
            let grain = match is_grainy {
                true => format!("with the noise of single drops ({noise:.1}/255)"),
                false => format!("without the noise of single drops ({noise:.1}/255)"),
            };
            format!("the others are a medium, from {from:.0} m on all, {grain}")
        }
    };
    (format!("{skipped}: {alone}"), format!("the environment behind the drops: {far}"), drops)
}

/// What stands behind the drops, where that is not the environment.
fn behind_of(scene: &Scene, environment: String) -> String {
    let background = &scene.background;
    let depth =
        if background.depth.is_some() { "; its depth hides drops that are farther" } else { "" };
    match &background.color {
        Some(file) => {
            format!("{} in place of {environment}{depth}", file.display())
        }
        None => format!("{environment}{depth}"),
    }
}

fn passes(scene: &Scene, plan: &FramePlan) -> Vec<(&'static str, String)> {
    let mut passes: Vec<(&'static str, String)> = Vec::new();
    let count = scene.drop_count();
    let all = counted(count.into(), "drop");
    match plan.primitive {
        Primitive::Point | Primitive::Quad => {
            if count > 0 {
                passes.push(("simulate", format!("moves {all} ({})", plan.simulation)));
            }
            if count > 0 && plan.compacts {
                let order = "those in view are drawn, in the order of their index".into();
                passes.push(("compact", order));
            }
            passes.push(("sky", "the environment behind the drops".into()));
            if count > 0 {
                let (primitive, optics, order) = (plan.primitive, plan.optics, plan.order);
                let drawn =
                    format!("each drop in view as a {primitive}, optics by {optics}, {order}");
                passes.push(("drops", drawn));
            }
        }
        Primitive::Tile => {
            let (splat_px, rays_px, optics) = (plan.splat_px, plan.rays_px, plan.optics);
            let (skipped, behind, drops) = match (scene.real_rain(), &plan.cutoff) {
                (Some(rain), Some(cutoff)) => of_real_rain(scene, &rain, cutoff),
                _ => (
                    "whole clusters of drops out of view are passed over".into(),
                    "the environment behind the drops, when the view has moved".into(),
                    all,
                ),
            };
            passes.push(("clusters", skipped));
            let behind = match plan.lens {
                Lens::Pinhole => behind,
                _ => format!("{behind}, seen through the lens"),
            };
            passes.push(("sky", behind_of(scene, behind)));
            let (small, others) = motion::in_words(plan.motion, plan.line_px);
            let (small_blurred, others_blurred) = lens::in_words(plan.lens);
            let splats = if splat_px > 0.0 {
                format!("; those under {splat_px} px of radius get two colours")
            } else {
                String::new()
            };
            passes.push((
                "gather",
                format!(
                    "of {drops} those in the clusters in view move{splats}{small}{small_blurred}"
                ),
            ));
            let fine = if plan.light.picture_level == 5 { " of up to 32 texels" } else { "" };
            passes.push((
                "large",
                format!(
                    "the others' coverage and pictures{fine}, tile by tile{others}{others_blurred}"
                ),
            ));
            passes.push(("rays", format!("radius over {rays_px} px, or near: closed form")));
            passes.push((
                "glints",
                "images of small bright sources in the larger drops, if the environment has any"
                    .into(),
            ));
            let nearest = if plan.nearest {
                "; each pixel's nearest is found, and how many cover it"
            } else {
                ""
            };
            passes.push((
                "composite",
                format!("drops by {optics} over the sky, front to back{nearest}"),
            ));
        }
    }
    passes.extend(pane::in_words(scene, plan));
    if plan.log_average {
        passes.push(("log luminance", "the photographic operator's exposure".into()));
    }
    let curve = plan.tone_map.map(|operator| match operator {
        Operator::Photographic => "photographic operator",
        Operator::None => "clipped",
    });
    let fixed = scene.tone_map.exposure.map(|factor| format!(", fixed exposure {factor}"));
    passes.extend(curve.map(|curve| {
        ("tone map", format!("a display output, {curve}{}", fixed.unwrap_or_default()))
    }));
    passes
}
