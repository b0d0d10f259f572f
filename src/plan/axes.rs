//! What every axis of the models comes to in a plan: the one list that commands print and result files hold. A key of
//! `[model]` that has no field here stands in it as the scene has it.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::FramePlan;
use crate::scene::model::{
    FarRain, Fresnel, Lens, Lookup, Motion, Optics, Order, PaneModel, Preset, Primitive,
    Reflection, ShapeModel, Simulation, Weights,
};
use crate::scene::{ModelChoice, Scene};

/// The keys of `[model]`, each with what is drawn; absent where the scene has nothing that the axis is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each field is the axis of the same name in `model`")]
pub struct Axes {
    pub preset: Preset,
    /// What preset `auto` was asked to keep.
    pub error: Option<f64>,
    pub budget_ms: Option<f64>,
    pub optics: Optics,
    pub primitive: Primitive,
    pub order: Order,
    pub simulation: Simulation,
    /// Size of the mask; only optics by a mask use it.
    pub mask_size: u32,
    pub samples: u32,
    pub internal_reflections: u32,
    pub weights: Weights,
    pub fresnel: Fresnel,
    pub reflection: Reflection,
    pub lookup: Lookup,
    /// How far rain is drawn; only real rain has it.
    pub far_rain: Option<FarRain>,
    /// Least radius of a drop that is drawn by itself; only real rain has it.
    pub cutoff_px: Option<f64>,
    /// Radius under which drops are thinned, none if that is not over the cut-off; only real rain has it.
    pub thinned_px: Option<f64>,
    /// Largest radius of a splat; only optics `appearance` has it.
    pub splat_px: Option<f64>,
    pub motion: Motion,
    pub lens: Lens,
    pub shape: ShapeModel,
    /// How a pane is drawn; none if the scene has none.
    pub pane: Option<PaneModel>,
    /// Keys of the model that nothing above resolves.
    #[serde(flatten)]
    pub others: Map<String, Value>,
}

impl Axes {
    /// The axes of a plan of `scene`.
    pub fn of(scene: &Scene, plan: &FramePlan) -> Self {
        let ModelChoice { preset, error, budget_ms, far_rain, .. } = scene.model;
        let light = &plan.light;
        let by_need = plan.cutoff.as_ref().map(|cutoff| match (cutoff.px, cutoff.is_grainy) {
            (0.0, _) => FarRain::Drops,
            (_, true) => FarRain::Grain,
            (_, false) => FarRain::Medium,
        });
        // Four decimals, and not those of a float32.
        let rounded = |px: f32| (f64::from(px) * 1e4).round() / 1e4;
        let mut axes = Self {
            preset,
            error,
            budget_ms,
            optics: plan.optics,
            primitive: plan.primitive,
            order: plan.order,
            simulation: plan.simulation,
            mask_size: plan.mask_size,
            samples: plan.samples,
            internal_reflections: light.internal_reflections,
            weights: light.weights,
            fresnel: light.fresnel,
            reflection: light.reflection,
            lookup: light.lookup,
            far_rain: far_rain.or(by_need),
            cutoff_px: plan.cutoff.as_ref().map(|cutoff| cutoff.px),
            thinned_px: plan
                .cutoff
                .as_ref()
                .filter(|cutoff| cutoff.thinned_px > 0.0)
                .map(|cutoff| cutoff.thinned_px),
            splat_px: (plan.optics == Optics::Appearance).then(|| rounded(plan.splat_px)),
            motion: plan.motion,
            lens: plan.lens,
            shape: plan.shape.model,
            pane: plan.pane,
            others: object(&scene.model),
        };
        let resolved = Self { others: Map::new(), ..axes.clone() }.values();
        axes.others.retain(|key, _| !resolved.contains_key(key));
        axes
    }

    /// Their names and values, in the order of the scene's keys; `null` for what is absent.
    pub fn values(&self) -> Map<String, Value> {
        object(self)
    }
}

fn object(value: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(value) {
        Ok(Value::Object(values)) => values,
        // Names and finite numbers always have a form in JSON.
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Environment;
    use crate::plan::{Output, plan};

    /// The axes of the schema are those of the list, name by name.
    #[test]
    fn no_axis_of_the_scene_is_forgotten() {
        let white = Environment::constant(glam::Vec3::ONE);
        let scene = Scene::default();
        let plan = plan(&scene, &white, Output::Display).expect("a plan");
        let schema = serde_json::to_value(scene.model).expect("JSON");
        let keys = |value: &Map<String, Value>| value.keys().cloned().collect::<Vec<_>>();
        let schema = keys(schema.as_object().expect("an object"));
        assert!(schema.contains(&"motion".to_string()) && schema.len() >= 20, "{schema:?}");
        assert_eq!(keys(&Axes::of(&scene, &plan).values()), schema);
    }

    #[test]
    fn what_is_drawn_is_told_and_not_what_was_asked() {
        let white = Environment::constant(glam::Vec3::ONE);
        let of = |text: &str| {
            let scene = Scene::parse(text, "a.toml").expect("a scene");
            let plan = plan(&scene, &white, Output::Display).expect("a plan");
            Axes::of(&scene, &plan).values()
        };
        let paper = of("[model]\npreset = 'paper'\nmask_size = 64");
        assert_eq!((&paper["optics"], &paper["mask_size"]), (&"mask".into(), &64.into()));
        assert_eq!((&paper["motion"], &paper["lens"]), (&"instant".into(), &"pinhole".into()));
        for absent in ["far_rain", "cutoff_px", "splat_px", "error"] {
            assert_eq!(paper[absent], Value::Null, "{absent}");
        }
        let rain = "[rain]\nrate = 25.0\nextent = 60.0\n[camera]\naperture = 0.02\nfocus = 3.0\nshutter = 0.01\n";
        let fast = of(&format!("{rain}[model]\npreset = 'fast'\nfar_rain = 'grain'"));
        let drawn = ["motion", "lens", "shape", "far_rain"].map(|axis| fast[axis].clone());
        assert_eq!(drawn, ["streak", "disc", "stretched", "grain"].map(Value::from));
        assert!(fast["cutoff_px"].as_f64() > Some(0.0) && fast["splat_px"].as_f64() > Some(0.0));
        let told = of("[model]\npreset = 'fast'\nsplat_px = 0.7654321");
        assert_eq!(told["splat_px"], 0.7654);
        let exact = of(&format!("{rain}[model]\npreset = 'exact'\nmotion = 'instant'"));
        let drawn = ["motion", "lens", "shape"].map(|axis| exact[axis].clone());
        assert_eq!(drawn, ["instant", "sampled", "equilibrium"].map(Value::from));
        let thinned = of(&format!("{rain}[model]\npreset = 'fast'\nthinned_px = 0.15"));
        assert_eq!((&thinned["thinned_px"], &exact["thinned_px"]), (&0.15.into(), &Value::Null));
    }

    /// Off tiles a picture is held against a mask of the same light.
    #[test]
    fn pictures_show_eight_orders_on_tiles_and_else_as_many_as_rays() {
        let white = Environment::constant(glam::Vec3::ONE);
        for (model, expected) in [
            ("preset = 'fast'", (2, 8)),
            ("preset = 'fast'\ninternal_reflections = 1", (1, 1)),
            ("preset = 'paper'\noptics = 'appearance'", (0, 0)),
            ("preset = 'paper'\noptics = 'appearance'\ninternal_reflections = 3", (3, 3)),
        ] {
            let scene = Scene::parse(&format!("[model]\n{model}"), "a.toml").expect("a scene");
            let light = plan(&scene, &white, Output::Display).expect("a plan").light;
            assert_eq!(
                (light.internal_reflections, light.picture_reflections),
                expected,
                "{model}"
            );
        }
    }
}
