//! Random scenes: the same from the same seed, valid, and with every key of the scene file that is not left out on purpose.

use std::collections::{BTreeMap, BTreeSet};

use raindrops::plan::{Output, plan};
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;
use toml::{Table, Value};

use crate::common::scene_keys;
use crate::row::tags;
use crate::scene::{frame, make};

const SCENES: u64 = 1000;

/// Keys that no scene of a hunt gives, and why.
const NEVER: [(&str, &str); 35] = [
    ("model.preset", "each scene is drawn by three presets"),
    ("model.optics", "the presets' models are what is held to the bounds"),
    ("model.primitive", "as optics"),
    ("model.order", "as optics"),
    ("model.simulation", "as optics"),
    ("model.mask_size", "of a model that no preset of a hunt takes"),
    ("model.samples", "as optics"),
    ("model.internal_reflections", "as optics"),
    ("model.weights", "as optics"),
    ("model.fresnel", "as optics"),
    ("model.reflection", "as optics"),
    ("model.lookup", "as optics"),
    ("model.far_rain", "as optics"),
    ("model.cutoff_px", "as optics"),
    ("model.thinned_px", "as optics"),
    ("model.splat_px", "as optics"),
    ("model.motion", "as optics"),
    ("model.lens", "as optics"),
    ("model.shape", "as optics"),
    ("model.pane", "as pane"),
    ("environment.layer", "the files of a hunt have one layer"),
    ("background.color_layer", "the files of a hunt have one layer"),
    ("background.depth_layer", "the files of a hunt have one layer"),
    ("background.depth_invalid", "every depth of a hunt is known"),
    // The two keys below are lists of keys of their own.
    ("film.camera.vertical_fov", "left out: that of the scene"),
    ("film.pace.at", "the first frame is drawn"),
    ("camera.velocity", "the picture of other velocities, by tests/drawn/moving_camera.rs"),
    ("drop.id", "changes no picture"),
    ("particles.file", "as placed drops, by tests/drawn/particles.rs"),
    ("particles.radius", "as the file"),
    ("particles.scale", "as the file"),
    ("particles.fps", "as the file"),
    ("particles.first", "as the file"),
    ("pane", "by tests/drawn/pane_drawn.rs"),
    ("shelter", "drop by drop, by tests/drawn/shelter.rs"),
];

/// Every key of the scene file, as the program names them where it meets one that it does not know.
fn keys() -> BTreeSet<String> {
    const TABLES: [&str; 10] = [
        "camera",
        "image",
        "environment",
        "water",
        "background",
        "rain",
        "particles",
        "model",
        "tone_map",
        "film",
    ];
    scene_keys(&TABLES, &["drop"])
}

/// Adds the values that a scene gives each key, lists of tables item by item.
fn add(found: &mut BTreeMap<String, BTreeSet<String>>, name: &str, value: &Value) {
    let is_of_tables = |list: &[Value]| list.first().is_some_and(Value::is_table);
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
                add(found, &name, value);
            }
        }
        Value::Array(list) if is_of_tables(list) => {
            found.entry(name.into()).or_default().insert(list.len().to_string());
            list.iter().for_each(|item| add(found, name, item));
        }
        value => {
            found.entry(name.into()).or_default().insert(value.to_string());
        }
    }
}

#[test]
fn every_key_is_varied_or_left_out_with_a_reason() {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for number in 0..SCENES {
        let table = make(1, number).text.parse::<Table>().expect("TOML");
        add(&mut found, "", &Value::Table(table));
    }
    let keys = keys();
    assert!(keys.len() > 60, "{} keys: are they looked for?", keys.len());
    let left_out: BTreeSet<&str> = NEVER.iter().map(|(key, _)| *key).collect();
    // One value, with the default where it is left out, makes two.
    let is_varied = |key: &str| found.get(key).is_some_and(|values| !values.is_empty());
    let never: Vec<&String> =
        keys.iter().filter(|key| !is_varied(key) && !left_out.contains(&***key)).collect();
    assert!(never.is_empty(), "no scene has {never:?}");
    let varied: Vec<&&str> =
        left_out.iter().filter(|key| key.starts_with("model.") && is_varied(key)).collect();
    assert!(varied.is_empty(), "said to be left out: {varied:?}");
    // Numbers take many values.
    for key in ["drop.radius", "drop.velocity", "rain.rate", "camera.shutter", "camera.aperture"] {
        assert!(found[key].len() > 50, "{key} has {} values", found[key].len());
    }
}

#[test]
fn scenes_are_of_every_kind() {
    let mut of_tag: BTreeMap<String, usize> = BTreeMap::new();
    let (mut radii_px, mut rates, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    let (mut elevations, mut fovs, mut windows) = (Vec::new(), Vec::new(), 0);
    let mut skies = BTreeSet::new();
    for number in 0..SCENES {
        let made = make(1, number);
        let scene = Scene::parse(&made.text, "a scene")
            .unwrap_or_else(|problem| panic!("scene {number}: {problem}\n{}", made.text));
        tags(&scene).into_iter().for_each(|tag| *of_tag.entry(tag).or_default() += 1);
        let frame = frame(&scene);
        let view = frame.view();
        for drop in &frame.drops {
            let away = drop.center_at(frame.drawn_time()).distance(view.position);
            radii_px.push(drop.radius / away * view.focal_px / f64::from(view.height));
        }
        rates.extend(frame.real_rain().map(|rain| rain.rate));
        indices.extend(frame.indices());
        elevations.push(frame.camera.forward().y);
        fovs.push(frame.camera.vertical_fov);
        windows += usize::from(view.width != scene.image.width);
        let (width, height) = scene.picture_size();
        assert!((96..=192).contains(&width) && (96..=192).contains(&height), "scene {number}");
        for (name, beside) in &made.files {
            skies.insert(format!("{name} {:?}", std::mem::discriminant(beside)));
        }
    }
    let is_spread = |values: &[f64], low: f64, high: f64| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(least < low && most > high, "{least} to {most} is not as wide as {low} to {high}");
    };
    is_spread(&radii_px, 0.08 / 192.0, 0.45);
    is_spread(&rates, 0.7, 350.0);
    is_spread(&indices, 1.05, 2.3);
    is_spread(&elevations, -0.999, 0.999);
    is_spread(&fovs, 4.0, 140.0);
    assert!(windows > 50, "{windows} windows");
    for tag in [
        "placed",
        "box",
        "rain",
        "moving",
        "lens",
        "flat",
        "near",
        "over 12 px",
        "index",
        "plate",
        "window",
        "sky",
        "constant",
        "bundled",
        "forest",
    ] {
        let count = of_tag.get(tag).copied().unwrap_or(0);
        assert!(count >= 20, "{count} scenes with {tag}");
    }
    assert!(skies.len() >= 3, "{skies:?}");
}

#[test]
fn a_scene_is_a_function_of_its_seed() {
    for number in 0..40 {
        assert!(make(3, number) == make(3, number), "scene {number} is not the same twice");
        assert!(make(3, number) != make(3, number + 1) && make(3, number) != make(4, number));
    }
}

/// A text that names only what is not as by default is the same scene.
#[test]
fn a_text_is_its_scene() {
    for number in 0..200 {
        let text = make(1, number).text;
        let scene = Scene::parse(&text, "a scene").expect("a scene");
        assert_eq!(crate::text::of(&scene), text, "scene {number}");
        let whole = toml::to_string(&scene).expect("TOML");
        assert_eq!(Scene::parse(&whole, "all keys").expect("a scene"), scene, "scene {number}");
    }
}

/// No model refuses what is drawn.
#[test]
fn every_scene_can_be_planned() {
    let grey = raindrops::environment::Environment::constant(raindrops::glam::Vec3::ONE);
    for number in 0..120 {
        let mut scene = frame(&Scene::parse(&make(1, number).text, "a scene").expect("a scene"));
        for preset in [Preset::Fast, Preset::Exact] {
            scene.model.take_preset(preset);
            plan(&scene, &grey, Output::Radiance)
                .unwrap_or_else(|problem| panic!("scene {number}: {problem}"));
        }
    }
}
