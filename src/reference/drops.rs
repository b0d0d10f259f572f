//! The drops of a scene as the ray tracer takes them: float64 spheres around the camera.

use glam::DVec3;
use rayon::prelude::*;

use crate::rain::tick_of_seconds;
use crate::scene::Scene;

/// One drop, seen from the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre relative to the camera, in scene units along the world's axes.
    pub center: DVec3,
    /// Radius, in scene units.
    pub radius: f64,
    /// 1, less where the drop fades in behind the near plane; over 0.
    pub opacity: f64,
}

/// Every drop of the scene that is drawn, random ones first, in the order of their indices.
///
/// Positions are those of [`crate::rain::Rain::relative`], float32 as the GPU has them, so that a
/// difference between the two pictures is never one of place. Of a random drop only the image
/// nearest the camera exists, as on the GPU: a drop that reaches through a wall of the box does not
/// reappear at the opposite one.
///
/// Left out: a drop whose centre is nearer than `camera.near`, and a drop that the camera is in
/// (what a camera under water sees is another picture than the paper's).
pub fn of_scene(scene: &Scene) -> Vec<Sphere> {
    let camera = &scene.camera;
    let drawn = |center: DVec3, radius: f64| {
        let distance = center.length();
        let opacity = fade(distance, camera.near, camera.near_fade);
        (distance > radius && opacity > 0.0).then_some(Sphere { center, radius, opacity })
    };
    let mut spheres: Vec<Sphere> = match scene.rain() {
        None => Vec::new(),
        Some(rain) => {
            let shift = rain.shift(tick_of_seconds(scene.time));
            let eye = rain.camera_place(camera.position);
            (0..rain.count)
                .into_par_iter()
                .filter_map(|index| {
                    let center = rain.relative(rain.place(index, shift), eye).as_dvec3();
                    drawn(center, rain.radius)
                })
                .collect()
        }
    };
    spheres.extend(
        scene.drops.iter().filter_map(|drop| drawn(drop.center - camera.position, drop.radius)),
    );
    spheres
}

/// Opacity of a drop whose centre is `distance` away: 0 nearer than `near`, 1 from `near + width`
/// on, a smoothstep between (the paper's section 5 asks for a fade and leaves its form open).
pub fn fade(distance: f64, near: f64, width: f64) -> f64 {
    if distance < near {
        return 0.0;
    }
    if distance >= near + width {
        return 1.0;
    }
    let x = (distance - near) / width;
    x * x * (3.0 - 2.0 * x)
}
