//! Pictures that tests draw and hold against the reference.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::passes::counters::Counts;
use raindrops::picture::Picture;
use raindrops::picture::metrics::{Comparison, compare};
use raindrops::picture::tone_map::exposure_of;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, RainSettings, Scene, ToneMap};

/// No drop yet, a square picture by preset `fast`.
pub fn square(edge: u32) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (edge, edge);
    scene.model.preset = Preset::Fast;
    scene
}

/// A small box of light rain that falls aslant.
pub fn light_rain() -> RainSettings {
    RainSettings {
        count: 4000,
        half_extent: DVec3::splat(30.0),
        radius: 0.12,
        velocity: DVec3::new(3.0, -9.0, 1.0),
        ..RainSettings::default()
    }
}

pub fn moving(center: [f64; 3], velocity: [f64; 3], radius: f64) -> PlacedDrop {
    PlacedDrop { velocity: velocity.into(), ..PlacedDrop::sphere(center.into(), radius) }
}

/// A renderer of a scene, by the plan that is made for it.
pub fn renderer_of(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    output: Output,
) -> Renderer {
    let plan = plan(scene, environment, output).expect("a plan");
    Renderer::new(device, scene, environment, &plan).expect("a renderer")
}

/// A renderer of linear radiance.
pub fn renderer(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Renderer {
    renderer_of(device, scene, environment, Output::Radiance)
}

pub fn frame(renderer: &mut Renderer, scene: &Scene) -> (Picture, Counts) {
    renderer.submit(scene).expect("a frame");
    let counts = renderer.finish().expect("a report").counts;
    (renderer.read_radiance().expect("a picture"), counts)
}

/// A frame from which nothing is left out.
pub fn draw(renderer: &mut Renderer, scene: &Scene) -> (Picture, Counts) {
    let (picture, counts) = frame(renderer, scene);
    assert_eq!(counts.overflow, 0);
    (picture, counts)
}

/// The frame of a renderer of its own.
pub fn picture_of(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Picture {
    frame(&mut renderer(device, scene, environment), scene).0
}

/// The picture of a scene by a preset, and its counts.
pub fn by_preset(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    preset: Preset,
) -> (Picture, Counts) {
    let mut scene = scene.clone();
    scene.model.take_preset(preset);
    frame(&mut renderer(device, &scene, environment), &scene)
}

pub fn truth(scene: &Scene, environment: &Environment, samples: u32) -> Picture {
    Tracer::new(scene, environment, Truth { samples, ..Truth::default() }).picture()
}

/// How far a picture is off, as it is shown.
pub fn against(truth: &Picture, picture: &Picture) -> Comparison {
    compare(truth, picture, None, exposure_of(&ToneMap::default(), truth))
}

/// Sum of the green channel.
pub fn sum(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel.y)).sum()
}

/// A black picture of `edge` pixels an edge, for the tests of `name`.
pub fn black(name: &str, edge: u32) -> PathBuf {
    let path = super::kept_folder(name).join(format!("black-{edge}.exr"));
    let pixels = vec![Vec3::ZERO; (edge * edge) as usize];
    Picture { width: edge, height: edge, pixels }.write_exr(&path).expect("a file");
    path
}
