//! Numbers at their extremes and past them: float16 and float32 on the GPU against float64. What is
//! promised and what was measured stands in `docs/stability.md`.

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
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use crate::common::painted;
use crate::common::picture::{by_preset, renderer, sum, truth};

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

fn draw(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    preset: Preset,
) -> (Picture, Counts) {
    let (picture, counts) = by_preset(device, scene, environment, preset);
    assert!(picture.pixels.iter().all(|pixel| pixel.is_finite()), "{preset}: not finite");
    (picture, counts)
}

/// Smooth in every direction, without an edge.
fn smooth() -> Environment {
    painted(128, |d| (1.5 + d).as_vec3())
}

/// Black about -z, white elsewhere: what is seen there is drops alone.
fn black_ahead() -> Environment {
    painted(256, |d| Vec3::splat(if -d.z > 0.5 { 0.0 } else { 1.0 }))
}
