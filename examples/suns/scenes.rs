//! Rain under a bare sun, in eight scenes, and how far a picture of one is from its reference.

use glam::{DQuat, DVec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::picture::tone_map::{Exposure, display, exposure_of};
use raindrops::picture::{Picture, srgb_of_linear};
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::{RainSettings, Scene};

/// Rain under a bare sun.
pub struct Sun {
    /// Photograph in `assets/environments`; none: the bundled sky.
    pub photograph: Option<&'static str>,
    /// Where the sun stands.
    pub name: &'static str,
    /// Degrees off the axis of view.
    degrees: f64,
    /// How many drops there are.
    pub drops: u32,
    /// Half the edge of the box that they fall in.
    half: f64,
}

const fn sun(
    photograph: Option<&'static str>,
    name: &'static str,
    degrees: f64,
    drops: u32,
    half: f64,
) -> Sun {
    Sun { photograph, name, degrees, drops, half }
}

/// The scenes.
pub const SUNS: [Sun; 8] = [
    sun(Some("sunrise.exr"), "in view", 8.0, 20_000, 300.0),
    sun(None, "in view", 8.0, 100_000, 500.0),
    sun(None, "beside", 75.0, 20_000, 250.0),
    sun(None, "behind", 172.0, 300_000, 700.0),
    sun(Some("sunset.exr"), "in view", 8.0, 20_000, 300.0),
    sun(Some("sunrise.exr"), "beside", 75.0, 5_000, 150.0),
    sun(Some("sunrise.exr"), "behind", 172.0, 100_000, 400.0),
    sun(Some("sunset.exr"), "in view, near", 8.0, 2_000, 40.0),
];

impl Sun {
    /// 256 x 256 pixels, drops of 0.3 to 30 of radius. None without a bare sun.
    pub fn scene(&self, environment: &Environment) -> Option<Scene> {
        let toward = split(environment)?.regions.first()?.direction;
        let mut scene = Scene::default();
        (scene.image.width, scene.image.height) = (256, 256);
        let half_extent = DVec3::splat(self.half);
        scene.rain =
            Some(RainSettings { count: self.drops, half_extent, ..RainSettings::default() });
        scene.camera.vertical_fov = 60.0;
        // A drop at the near plane has a radius of 30 pixels.
        scene.camera.near = 7.4;
        let turned = DQuat::from_rotation_y(self.degrees.to_radians()) * toward;
        scene.camera.target = DVec3::new(turned.x, 0.3 * turned.y, turned.z);
        Some(scene)
    }
}

/// Two references, whose noise is not the same, and how they are shown.
pub struct References {
    /// Their mean, radiance.
    pub mean: Picture,
    /// That of their mean.
    pub exposure: Exposure,
    shown: [Vec<f64>; 2],
}

impl References {
    /// By so many samples a pixel each.
    pub fn new(scene: &Scene, environment: &Environment, samples: u32) -> Self {
        let tracer = Tracer::new(scene, environment, Truth { samples, ..Truth::default() });
        let halves = [0, 1].map(|seed| tracer.with_seed(seed).picture());
        let pairs = halves[0].pixels.iter().zip(&halves[1].pixels);
        let pixels = pairs.map(|(a, b)| 0.5 * (*a + *b)).collect();
        let mean = Picture { pixels, ..halves[0] };
        let exposure = exposure_of(&scene.tone_map, &mean);
        let shown = halves.each_ref().map(|half| shown(exposure, half));
        Self { mean, exposure, shown }
    }

    /// RMS error of a picture as it is shown: the root of the mean product of its distances from both, so that their
    /// noise is no error.
    pub fn rms(&self, shown: &[f64]) -> f64 {
        let [a, b] = &self.shown;
        let pairs = shown.iter().zip(a.iter().zip(b));
        mean(pairs.map(|(p, (a, b))| (p - a) * (p - b))).max(0.0).sqrt()
    }
}

/// A picture as it is shown, in sRGB values.
pub fn shown(exposure: Exposure, picture: &Picture) -> Vec<f64> {
    let shown = display(exposure, picture);
    shown.pixels.iter().flat_map(|p| p.to_array()).map(|v| f64::from(srgb_of_linear(v))).collect()
}

/// Their mean.
pub fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}
