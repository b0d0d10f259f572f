//! The models that are tried: the presets, and each axis varied alone from the preset to which
//! it belongs.

use crate::scene::model::{
    FarRain, Fresnel, Lens, Lookup, Motion, Optics, Order, PaneModel, Preset, Primitive,
    Reflection, ShapeModel, Simulation, Weights,
};
use crate::scene::{ModelChoice, Scene};

/// One model by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The preset and what differs from it, as on the command line.
    pub name: String,
    /// The model itself, as a scene has it.
    pub choice: ModelChoice,
}

/// How many of the first of [`models`] the others' speeds are ratios to.
pub const BASES: usize = 2;

/// Every model that draws a scene: of a pane [`models_of_pane`], of real rain [`models_of_rain`].
pub fn models_of(scene: &Scene) -> Vec<Model> {
    match (&scene.pane, scene.real_rain()) {
        (Some(_), _) => models_of_pane(),
        (None, Some(_)) => models_of_rain(),
        (None, None) => models(),
    }
}

/// The models of a pane of glass, `fast` first, then `exact`.
pub fn models_of_pane() -> Vec<Model> {
    let bases = [Preset::Fast, Preset::Exact];
    let preset = |preset: Preset| ModelChoice { preset, ..ModelChoice::default() };
    let mut all: Vec<_> =
        bases.map(|base| Model { name: base.name().into(), choice: preset(base) }).into();
    use PaneModel::{Color, Exact, FirstExit, None, Picture};
    for (base, usual) in bases.into_iter().zip([Picture, Exact]) {
        for model in
            [Exact, FirstExit, Picture, Color, None].into_iter().filter(|model| *model != usual)
        {
            let choice = ModelChoice { pane: Some(model), ..preset(base) };
            all.push(Model { name: format!("{base} pane {model}"), choice });
        }
    }
    all
}

/// The models of real rain, `fast` first, then `exact`: what is drawn one by one, and what becomes of the rest.
pub fn models_of_rain() -> Vec<Model> {
    let preset = |preset: Preset| ModelChoice { preset, ..ModelChoice::default() };
    let mut all = Vec::new();
    for base in [Preset::Fast, Preset::Exact] {
        all.push(Model { name: base.name().into(), choice: preset(base) });
    }
    let fast = preset(Preset::Fast);
    for cutoff_px in [0.02, 0.1, 0.2, 0.5, 1.0] {
        let choice = ModelChoice { cutoff_px: Some(cutoff_px), ..fast };
        all.push(Model { name: format!("fast cutoff-px {cutoff_px}"), choice });
    }
    for thinned_px in [0.1, 0.2, 0.3] {
        let choice = ModelChoice { thinned_px: Some(thinned_px), ..fast };
        all.push(Model { name: format!("fast thinned-px {thinned_px}"), choice });
    }
    for far_rain in [FarRain::Drops, FarRain::Medium, FarRain::Grain, FarRain::None] {
        let choice = ModelChoice { far_rain: Some(far_rain), ..fast };
        all.push(Model { name: format!("fast far-rain {far_rain}"), choice });
    }
    for base in [Preset::Fast, Preset::Exact] {
        let choice = ModelChoice { motion: Some(Motion::Instant), ..preset(base) };
        all.push(Model { name: format!("{base} motion instant"), choice });
        let choice = ModelChoice { lens: Some(Lens::Pinhole), ..preset(base) };
        all.push(Model { name: format!("{base} lens pinhole"), choice });
    }
    for model in [ShapeModel::Sphere, ShapeModel::Stretched, ShapeModel::Spheroid] {
        for base in [Preset::Fast, Preset::Exact] {
            let choice = ModelChoice { shape: Some(model), ..preset(base) };
            all.push(Model { name: format!("{base} shape {model}"), choice });
        }
    }
    let cutoff_px = Some(0.2);
    for far_rain in [FarRain::Medium, FarRain::Grain, FarRain::None] {
        let choice = ModelChoice { far_rain: Some(far_rain), cutoff_px, ..fast };
        all.push(Model { name: format!("fast far-rain {far_rain} cutoff-px 0.2"), choice });
    }
    all
}

/// Every model, `paper` first, then `paper-compact`.
pub fn models() -> Vec<Model> {
    let preset = |preset: Preset| ModelChoice { preset, ..ModelChoice::default() };
    let (paper, fast, exact) = (preset(Preset::Paper), preset(Preset::Fast), preset(Preset::Exact));
    let mut all = Vec::new();
    let mut add = |base: &ModelChoice, change: &str, choice: ModelChoice| {
        all.push(Model { name: format!("{} {change}", base.preset).trim().into(), choice });
    };

    add(&paper, "", paper);
    let compact = preset(Preset::PaperCompact);
    add(&compact, "", compact);
    for optics in [
        Optics::MaskF32,
        Optics::MaskSnorm16,
        Optics::SingleMask,
        Optics::Radial,
        Optics::ClosedForm,
        Optics::Far,
        Optics::Appearance,
    ] {
        add(&paper, optics.name(), ModelChoice { optics: Some(optics), ..paper });
    }
    for mask_size in [64, 256] {
        add(&paper, &format!("mask-size {mask_size}"), ModelChoice { mask_size, ..paper });
    }
    let closed = ModelChoice { optics: Some(Optics::ClosedForm), ..paper };
    for samples in [4, 16] {
        let choice = ModelChoice { samples: Some(samples), ..closed };
        add(&paper, &format!("closed-form samples {samples}"), choice);
    }
    let one_inside = ModelChoice { internal_reflections: Some(1), ..closed };
    add(&paper, "closed-form internal-reflections 1", one_inside);
    add(&paper, "weights physical", ModelChoice { weights: Some(Weights::Physical), ..paper });
    add(&paper, "fresnel schlick", ModelChoice { fresnel: Some(Fresnel::Schlick), ..paper });
    add(&paper, "reflection off", ModelChoice { reflection: Some(Reflection::Off), ..paper });
    add(&paper, "lookup finest", ModelChoice { lookup: Some(Lookup::Finest), ..paper });
    let covering = ModelChoice { order: Some(Order::AlphaToCoverage), ..paper };
    add(&paper, "alpha-to-coverage", covering);
    add(&paper, "quad", ModelChoice { primitive: Some(Primitive::Quad), ..paper });
    add(&paper, "stored", ModelChoice { simulation: Some(Simulation::Stored), ..paper });

    let auto = preset(Preset::Auto);
    add(&auto, "", auto);
    for error in [0.03, 0.01] {
        add(&auto, &format!("error {error}"), ModelChoice { error: Some(error), ..auto });
    }

    add(&fast, "", fast);
    for samples in [4, 16] {
        let choice = ModelChoice { samples: Some(samples), ..fast };
        add(&fast, &format!("samples {samples}"), choice);
    }
    for orders in [0, 1] {
        let choice = ModelChoice { internal_reflections: Some(orders), ..fast };
        add(&fast, &format!("internal-reflections {orders}"), choice);
    }
    add(&fast, "reflection off", ModelChoice { reflection: Some(Reflection::Off), ..fast });

    add(&exact, "", exact);
    for samples in [1, 4, 64] {
        let choice = ModelChoice { samples: Some(samples), ..exact };
        add(&exact, &format!("samples {samples}"), choice);
    }
    for orders in [0, 1] {
        let choice = ModelChoice { internal_reflections: Some(orders), ..exact };
        add(&exact, &format!("internal-reflections {orders}"), choice);
    }
    all
}
