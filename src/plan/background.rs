//! What the picture shows where no drop is: its exposure, and the error with which it is drawn.

use glam::DVec3;

use crate::environment::Environment;
use crate::environment::levels::{levels, sample};
use crate::picture::tone_map::{Exposure, apply, exposure_of};
use crate::picture::{Picture, srgb_of_linear};
use crate::scene::Scene;

/// Pixels along an edge of those that are looked at.
const GRID: u32 = 48;
/// Samples along an edge of such a pixel.
const FINE: u32 = 8;
/// RMS error by the texture unit, whose filter weights have 8 bits.
const FILTER: f64 = 0.001;

/// The sky of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Background {
    /// Exposure by the sky alone.
    pub exposure: Exposure,
    /// RMS of sRGB values, 0 to 1, as `glsl/sky.comp` draws it.
    pub error: f64,
}

/// Samples along an edge of a pixel that the sky is drawn with: `samples_along` of `glsl/sky.comp`.
fn samples_along(focal_px: f64, environment: &Environment) -> u32 {
    let texel = std::f64::consts::PI / f64::from(environment.height());
    match 3.0 / (focal_px * texel) {
        thirds if thirds <= 1.0 => 1,
        thirds if thirds <= 2.0 => 2,
        _ => 4,
    }
}

impl Background {
    /// That of `scene`, by some of its pixels.
    pub fn of(scene: &Scene, environment: &Environment) -> Self {
        let view = scene.view();
        let chain = levels(environment);
        let texel = std::f64::consts::PI / f64::from(environment.height());
        let mean = |x: f64, y: f64, edge: u32, of: &dyn Fn(DVec3) -> DVec3| {
            let place = |n: u32| (f64::from(n) + 0.5) / f64::from(edge);
            let all =
                (0..edge * edge).map(|n| of(view.ray(x + place(n % edge), y + place(n / edge))));
            (all.sum::<DVec3>() / f64::from(edge * edge)).as_vec3()
        };
        let edge = samples_along(view.focal_px, environment);
        let drawn = |ray: DVec3| {
            let cosine = -ray.dot(view.back);
            let spread = cosine.powf(1.5) / (view.focal_px * f64::from(edge));
            sample(&chain, ray, (spread / texel).log2())
        };
        // Whole pixels, spread over the picture.
        let pixel =
            |n: u32, edge: u32| ((f64::from(n) + 0.5) / f64::from(GRID) * f64::from(edge)).floor();
        let pairs: Vec<_> = (0..GRID * GRID)
            .map(|n| {
                let (x, y) = (pixel(n % GRID, view.width), pixel(n / GRID, view.height));
                let fine = mean(x, y, FINE, &|ray| environment.radiance(ray));
                (fine, mean(x, y, edge, &drawn))
            })
            .collect();
        let pixels = pairs.iter().map(|(fine, _)| *fine).collect();
        let exposure = exposure_of(&scene.tone_map, &Picture { width: GRID, height: GRID, pixels });
        let square = |(fine, drawn): &(glam::Vec3, glam::Vec3)| {
            let (a, b) = (apply(exposure, *fine), apply(exposure, *drawn));
            let channels = a.to_array().into_iter().zip(b.to_array());
            channels
                .map(|(a, b)| f64::from(srgb_of_linear(a) - srgb_of_linear(b)).powi(2))
                .sum::<f64>()
                / 3.0
        };
        let squares: f64 = pairs.iter().map(square).sum();
        Self { exposure, error: (squares / f64::from(GRID * GRID)).sqrt().hypot(FILTER) }
    }
}
