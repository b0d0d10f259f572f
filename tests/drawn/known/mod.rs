//! Known answers: what comes out is held against closed forms and exact integers that share no code with what
//! computes it, so that a fault in what the GPU and its reference implementation share is seen as well.

mod exposure;
mod levels;
mod light;
mod order;
mod places;

use std::sync::Arc;

use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

/// A scene of drops placed by hand, in an image as wide as it is high.
fn placed(drops: impl IntoIterator<Item = (DVec3, f64)>, edge: u32) -> Scene {
    let place = |(center, radius)| PlacedDrop::sphere(center, radius);
    let mut scene = Scene { rain: None, ..Scene::default() };
    scene.drops = drops.into_iter().map(place).collect();
    scene.image = ImageSize { width: edge, height: edge };
    scene.model.mask_size = 64;
    scene
}

/// Linear radiance by a preset.
fn draw(device: &Arc<Device>, scene: &Scene, environment: &Environment, preset: Preset) -> Picture {
    let (picture, counts) = crate::common::picture::by_preset(device, scene, environment, preset);
    assert_eq!(counts.overflow, 0, "{preset}");
    picture
}

/// The largest difference of two pictures, relative to the brighter pixel.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let pixels = a.pixels.iter().zip(&b.pixels);
    let off = |(a, b): (&glam::Vec3, &glam::Vec3)| {
        (*a - *b).abs().max_element() / a.max(*b).max_element().max(1e-9)
    };
    pixels.map(off).fold(0.0, f32::max)
}
