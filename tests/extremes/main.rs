//! Numbers at their extremes and past them: float16 and float32 on the GPU against float64. What is
//! promised and what was measured stands in `docs/stability.md`.

#[path = "../common/mod.rs"]
mod common;

mod flicker;
mod geometry;
mod radiance;
mod surface;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::passes::counters::Counts;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use common::painted;

const PRESETS: [Preset; 3] = [Preset::Paper, Preset::Fast, Preset::Exact];

/// A scene of drops placed by hand.
fn placed(drops: &[(DVec3, f64)], (width, height): (u32, u32)) -> Scene {
    let drops = drops.iter().map(|&(center, radius)| PlacedDrop::sphere(center, radius)).collect();
    let mut scene = Scene { rain: None, drops, ..Scene::default() };
    scene.image = ImageSize { width, height };
    scene.model.mask_size = 256;
    scene
}

fn looking(target: DVec3, up: DVec3, vertical_fov: f64) -> Camera {
    Camera { target, up, vertical_fov, ..Camera::default() }
}

/// A renderer of linear radiance by a preset.
fn renderer(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Renderer {
    let plan = plan(scene, environment, Output::Radiance).expect("a plan");
    Renderer::new(device, scene, environment, &plan).expect("a renderer")
}

fn draw(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    preset: Preset,
) -> (Picture, Counts) {
    let mut scene = scene.clone();
    scene.model.preset = preset;
    let mut renderer = renderer(device, &scene, environment);
    renderer.submit(&scene).expect("a frame");
    let counts = renderer.finish().expect("a report").counts;
    let picture = renderer.read_radiance().expect("radiance");
    assert!(picture.pixels.iter().all(|pixel| pixel.is_finite()), "{preset}: not finite");
    (picture, counts)
}

fn truth(scene: &Scene, environment: &Environment, samples: u32) -> Picture {
    Tracer::new(scene, environment, Truth { samples, ..Truth::default() }).picture()
}

/// Smooth in every direction, without an edge.
fn smooth() -> Environment {
    painted(128, |d| (1.5 + d).as_vec3())
}

/// Black about -z, white elsewhere: what is seen there is drops alone.
fn black_ahead() -> Environment {
    painted(256, |d| Vec3::splat(if -d.z > 0.5 { 0.0 } else { 1.0 }))
}

fn sum(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel.x)).sum()
}
