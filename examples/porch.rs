//! Makes the files of `assets/porch/` anew: what is seen out of a porch, how far away it is, and the heights of what keeps
//! rain off, from one list of boxes. `cargo run --release --example porch`.

use std::path::Path;

use glam::{DVec3, Vec3};
use image::{ImageBuffer, Luma};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::scene::Scene;
use rayon::prelude::*;

/// From a corner to the opposite one, and how much of the light is reflected.
struct Solid(DVec3, DVec3, f32);

/// The map's edge in texels, and from where to where it goes along x and z.
const TEXELS: u32 = 64;
const MAP: [f64; 2] = [-8.0, 8.0];

/// Most that a PNG of 16 bits holds, which stands for the sky.
const SKY: u16 = u16::MAX;

fn solids() -> Vec<Solid> {
    let at = DVec3::new;
    let mut all = vec![
        // A roof with a hole, in four parts around it.
        Solid(at(-6.0, 2.7, -8.0), at(6.0, 2.9, 1.25), 0.25),
        Solid(at(-6.0, 2.7, 1.75), at(6.0, 2.9, 3.0), 0.25),
        Solid(at(-6.0, 2.7, 1.25), at(-1.0, 2.9, 1.75), 0.25),
        Solid(at(-0.5, 2.7, 1.25), at(6.0, 2.9, 1.75), 0.25),
        // The floor, a railing, the ground and hedges.
        Solid(at(-6.0, -0.2, -8.0), at(6.0, 0.0, 3.0), 0.3),
        Solid(at(-6.0, 0.8, 2.8), at(-0.9, 0.9, 2.9), 0.35),
        Solid(at(1.4, 0.8, 2.8), at(6.0, 0.9, 2.9), 0.35),
        Solid(at(-60.0, -0.6, -60.0), at(60.0, -0.4, 60.0), 0.12),
        Solid(at(-60.0, -0.4, 14.0), at(-3.0, 2.6, 16.0), 0.05),
        Solid(at(4.0, -0.4, 12.0), at(60.0, 2.2, 14.0), 0.05),
        Solid(at(-60.0, -0.4, 26.0), at(60.0, 4.6, 28.0), 0.04),
    ];
    all.extend(
        [-3.4, -0.9, 1.4, 3.9]
            .map(|x| Solid(at(x - 0.07, 0.0, 2.78), at(x + 0.07, 2.7, 2.92), 0.35)),
    );
    all
}

/// Distance to a box along a ray, and the outer normal there.
fn meet(solid: &Solid, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let (a, b) = ((solid.0 - origin) / direction, (solid.1 - origin) / direction);
    let (near, far) = (a.min(b), a.max(b));
    let distance = near.max_element();
    let is_met = distance > 1e-6 && distance <= far.min_element();
    let axis = near.max_position();
    is_met.then(|| (distance, -DVec3::AXES[axis] * direction[axis].signum()))
}

fn first(solids: &[Solid], origin: DVec3, direction: DVec3) -> Option<(f64, DVec3, f32)> {
    let all = solids.iter().filter_map(|solid| {
        meet(solid, origin, direction).map(|(distance, normal)| (distance, normal, solid.2))
    });
    all.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Unit vectors over a half of all directions, so that their mean is that of a matt surface.
fn matt(normal: DVec3) -> impl Iterator<Item = DVec3> {
    let (u, v) = normal.any_orthonormal_pair();
    (0..48).map(move |number| {
        let square = (f64::from(number) + 0.5) / 48.0;
        let (sine, cosine) = (2.399_963 * f64::from(number)).sin_cos();
        square.sqrt() * (cosine * u + sine * v) + (1.0 - square).sqrt() * normal
    })
}

/// Light of a ray: of the sky, or of a matt surface that sees a part of it.
fn light(solids: &[Solid], sky: &Environment, origin: DVec3, direction: DVec3) -> DVec3 {
    // The sun itself is left out: in a few directions of many it would be noise.
    let of_sky = |direction: DVec3| sky.radiance(direction).min(DVec3::splat(30.0));
    let Some((distance, normal, albedo)) = first(solids, origin, direction) else {
        return of_sky(direction);
    };
    let place = origin + distance * direction + 1e-4 * normal;
    let open = |direction: &DVec3| first(solids, place, *direction).is_none();
    let seen: DVec3 = matt(normal).filter(open).map(of_sky).sum();
    // Light that comes by other surfaces is a small part of what is around.
    f64::from(albedo) * (seen / 48.0 + 0.02 * of_sky(DVec3::Y))
}

fn main() -> anyhow::Result<()> {
    let folder = Path::new("assets/porch");
    let text = std::fs::read_to_string("assets/scenes/porch.toml")?;
    let (scene, solids) = (Scene::parse(&text, "porch.toml")?, solids());
    let sky = Environment::load(Path::new("assets/low-sun.exr"))?;
    let view = scene.view();
    let through = |x: f64, y: f64| {
        let (across, up) = (x - 0.5 * f64::from(view.width), 0.5 * f64::from(view.height) - y);
        (across * view.right + up * view.up - view.focal_px * view.back).normalize()
    };
    let pixel = |number: u32| {
        let (x, y) = (f64::from(number % view.width), f64::from(number / view.width));
        let places = [(0.3, 0.2), (0.8, 0.3), (0.2, 0.7), (0.7, 0.8)];
        let lights =
            places.map(|(a, b)| light(&solids, &sky, view.position, through(x + a, y + b)));
        let middle = through(x + 0.5, y + 0.5);
        let depth = first(&solids, view.position, middle)
            .map_or(f64::from(SKY), |(distance, ..)| -1000.0 * distance * middle.dot(view.back));
        let light = lights.into_iter().sum::<DVec3>() / 4.0;
        (light.as_vec3(), (depth.round() as u16).clamp(1, SKY))
    };
    let all = (0..view.width * view.height).into_par_iter().map(pixel);
    let (pixels, depths): (Vec<Vec3>, Vec<u16>) = all.unzip();
    Picture { width: view.width, height: view.height, pixels }
        .write_exr_f16(&folder.join("color.exr"))?;
    let depths = ImageBuffer::<Luma<u16>, _>::from_raw(view.width, view.height, depths);
    depths.expect("a depth a pixel").save(folder.join("depth.png"))?;
    let edge = (MAP[1] - MAP[0]) / f64::from(TEXELS);
    let heights = ImageBuffer::from_fn(TEXELS, TEXELS, |column, row| {
        let [x, z] = [column, row].map(|texel| MAP[0] + edge * (f64::from(texel) + 0.5));
        let down = first(&solids, DVec3::new(x, 100.0, z), DVec3::new(1e-12, -1.0, 1e-12));
        // Under the ground nothing is seen of rain.
        Luma([
            down.map_or(0, |(distance, ..)| (1000.0 * (100.0 - distance)).max(0.0).round() as u16)
        ])
    });
    heights.save(folder.join("heights.png"))?;
    Ok(())
}
