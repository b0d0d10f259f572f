//! Scene files: what is parsed can be looked at and planned, or is refused in a line.
#![no_main]

use glam::Vec3;
use libfuzzer_sys::fuzz_target;
use raindrops::environment::Environment;
use raindrops::plan::{Output, plan};
use raindrops::scene::Scene;

fuzz_target!(|text: &str| {
    let told = |error: raindrops::Error| {
        let line = error.to_string();
        assert!(!line.contains('\n'), "{line}");
    };
    let scene = match Scene::parse(text, "fuzzed.toml") {
        Ok(scene) => scene,
        Err(error) => return told(error),
    };
    assert!(scene.view().focal_px.is_finite());
    if let Err(error) = plan(&scene, &Environment::constant(Vec3::ONE), Output::Display) {
        told(error);
    }
});
