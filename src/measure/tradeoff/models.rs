//! The models that are tried: the presets, and each axis varied alone from the preset to which
//! it belongs.

use std::fmt::Display;

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

/// A preset, and what `set` changes of it.
fn of(preset: Preset, change: &str, set: impl FnOnce(&mut ModelChoice)) -> Model {
    let mut choice = ModelChoice { preset, ..ModelChoice::default() };
    set(&mut choice);
    Model { name: format!("{preset} {change}").trim_end().into(), choice }
}

/// A preset as it is.
fn plain(preset: Preset) -> Model {
    of(preset, "", |_| ())
}

/// A preset with each value of a key.
fn each<T: Copy + Display, const N: usize>(
    preset: Preset,
    key: &str,
    values: [T; N],
    set: impl Fn(&mut ModelChoice, T),
) -> [Model; N] {
    values.map(|value| of(preset, &format!("{key} {value}"), |model| set(model, value)))
}

/// The models of a pane of glass, `fast` first, then `exact`.
pub fn models_of_pane() -> Vec<Model> {
    use PaneModel::{Color, Exact, FirstExit, None, Picture};
    let set = |model: &mut ModelChoice, pane| model.pane = Some(pane);
    let mut all = vec![plain(Preset::Fast), plain(Preset::Exact)];
    all.extend(each(Preset::Fast, "pane", [Exact, FirstExit, Color, None], set));
    all.extend(each(Preset::Exact, "pane", [FirstExit, Picture, Color, None], set));
    all
}

/// The models of real rain, `fast` first, then `exact`: what is drawn one by one, and what becomes of the rest.
pub fn models_of_rain() -> Vec<Model> {
    use FarRain::{Drops, Grain, Medium, None};
    use Preset::{Exact, Fast};
    let mut all = vec![plain(Fast), plain(Exact)];
    all.extend(each(Fast, "cutoff-px", [0.02, 0.1, 0.2, 0.5, 1.0], |m, px| m.cutoff_px = Some(px)));
    all.extend(each(Fast, "thinned-px", [0.1, 0.2, 0.3], |m, px| m.thinned_px = Some(px)));
    all.extend(each(Fast, "far-rain", [Drops, Medium, Grain, None], |m, far| {
        m.far_rain = Some(far)
    }));
    for base in [Fast, Exact] {
        all.push(of(base, "motion instant", |m| m.motion = Some(Motion::Instant)));
        all.push(of(base, "lens pinhole", |m| m.lens = Some(Lens::Pinhole)));
    }
    for shape in [ShapeModel::Sphere, ShapeModel::Stretched, ShapeModel::Spheroid] {
        for base in [Fast, Exact] {
            all.push(of(base, &format!("shape {shape}"), |m| m.shape = Some(shape)));
        }
    }
    for far in [Medium, Grain, None] {
        all.push(of(Fast, &format!("far-rain {far} cutoff-px 0.2"), |m| {
            (m.far_rain, m.cutoff_px) = (Some(far), Some(0.2));
        }));
    }
    all
}

/// Every model, `paper` first, then `paper-compact`.
pub fn models() -> Vec<Model> {
    use Preset::{Auto, Exact, Fast, Paper, PaperCompact};
    let mut all = vec![plain(Paper), plain(PaperCompact)];
    for optics in [
        Optics::MaskF32,
        Optics::MaskSnorm16,
        Optics::SingleMask,
        Optics::Radial,
        Optics::ClosedForm,
        Optics::Far,
        Optics::Appearance,
    ] {
        all.push(of(Paper, optics.name(), |m| m.optics = Some(optics)));
    }
    all.extend(each(Paper, "mask-size", [64, 256], |m, size| m.mask_size = size));
    all.extend(each(Paper, "closed-form samples", [4, 16], |m, samples| {
        (m.optics, m.samples) = (Some(Optics::ClosedForm), Some(samples));
    }));
    all.extend([
        of(Paper, "closed-form internal-reflections 1", |m| {
            (m.optics, m.internal_reflections) = (Some(Optics::ClosedForm), Some(1));
        }),
        of(Paper, "weights physical", |m| m.weights = Some(Weights::Physical)),
        of(Paper, "fresnel schlick", |m| m.fresnel = Some(Fresnel::Schlick)),
        of(Paper, "reflection off", |m| m.reflection = Some(Reflection::Off)),
        of(Paper, "lookup finest", |m| m.lookup = Some(Lookup::Finest)),
        of(Paper, "alpha-to-coverage", |m| m.order = Some(Order::AlphaToCoverage)),
        of(Paper, "quad", |m| m.primitive = Some(Primitive::Quad)),
        of(Paper, "stored", |m| m.simulation = Some(Simulation::Stored)),
        plain(Auto),
    ]);
    all.extend(each(Auto, "error", [0.03, 0.01], |m, error| m.error = Some(error)));

    let samples = |m: &mut ModelChoice, samples| m.samples = Some(samples);
    let orders = |m: &mut ModelChoice, orders| m.internal_reflections = Some(orders);
    all.push(plain(Fast));
    all.extend(each(Fast, "samples", [4, 16], samples));
    all.extend(each(Fast, "internal-reflections", [0, 1], orders));
    all.push(of(Fast, "reflection off", |m| m.reflection = Some(Reflection::Off)));
    all.push(plain(Exact));
    all.extend(each(Exact, "samples", [1, 4, 64], samples));
    all.extend(each(Exact, "internal-reflections", [0, 1], orders));
    all
}
