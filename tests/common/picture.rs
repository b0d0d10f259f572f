//! Pictures that tests draw and hold against the reference.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::passes::counters::Counts;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

/// No drop yet, a square picture by preset `fast`.
pub fn square(edge: u32) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (edge, edge);
    scene.model.preset = Preset::Fast;
    scene
}

pub fn renderer(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Renderer {
    let plan = plan(scene, environment, Output::Radiance).expect("a plan");
    Renderer::new(device, scene, environment, &plan).expect("a renderer")
}

/// A frame from which nothing is left out.
pub fn draw(renderer: &mut Renderer, scene: &Scene) -> (Picture, Counts) {
    renderer.submit(scene).expect("a frame");
    let counts = renderer.finish().expect("a report").counts;
    assert_eq!(counts.overflow, 0);
    (renderer.read_radiance().expect("a picture"), counts)
}

pub fn truth(scene: &Scene, environment: &Environment, samples: u32) -> Picture {
    Tracer::new(scene, environment, Truth { samples, ..Truth::default() }).picture()
}

/// Of the green.
pub fn sum(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel.y)).sum()
}

/// A black picture of `edge` pixels an edge, for the tests of `name`.
pub fn black(name: &str, edge: u32) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(format!("black-{edge}.exr"));
    let pixels = vec![Vec3::ZERO; (edge * edge) as usize];
    Picture { width: edge, height: edge, pixels }.write_exr(&path).expect("a file");
    path
}
