//! Makes `assets/flat-suns.png` anew: how much of a distant source's light falling drops show, by their size
//! (`src/rain/flat_suns.rs`). `cargo run --release --example flat_suns`, three minutes on two cores.
//!
//! Rays from the source meet drops of one size; where light leaves, it counts for every direction within 5° of that in
//! which a camera sees it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use image::{GrayImage, Luma};
use raindrops::optics::{Shape, WATER, Walk};
use raindrops::rain::flat_sizes::DIAMETERS;
use raindrops::rain::flat_suns::{ANGLES, byte_of};
use raindrops::rain::shape::Halves;
use rayon::prelude::*;

const RAYS: u32 = 1 << 19;
/// Cosine of 5°.
const CONE: f64 = 0.996_195;
/// Edge of the square that rays go through, in radii.
const EDGE: f64 = 2.6;
/// Orders of light.
const EXITS: usize = 12;

/// Unit vector at an elevation and at an azimuth from -z, each by the number of its angle.
fn direction(elevation: usize, azimuth: usize) -> DVec3 {
    let step = PI / (ANGLES - 1) as f64;
    let (sine, cosine) = (elevation as f64 * step - FRAC_PI_2).sin_cos();
    let (across, along) = (azimuth as f64 * step).sin_cos();
    DVec3::new(cosine * across, sine, -cosine * along)
}

/// By elevation and azimuth of the camera's direction: mean radiance of a drop whose outline is so much of a sphere's, for an
/// irradiance of 1 by a source at `elevation`.
fn shown(shape: Shape, outline: impl Fn(f64) -> f64, elevation: usize) -> Vec<f64> {
    let seen: Vec<DVec3> =
        (0..ANGLES * ANGLES).map(|at| direction(at / ANGLES, at % ANGLES)).collect();
    let mut sums = vec![0.0; seen.len()];
    let mut count = |toward: DVec3, share: f64| {
        // The drop is the same on both sides of the source's meridian.
        let toward = DVec3::new(toward.x.abs(), toward.y, toward.z);
        for (sum, seen) in sums.iter_mut().zip(&seen) {
            let mirrored = DVec3::new(-seen.x, seen.y, seen.z);
            let hits = [*seen, mirrored].map(|d| f64::from(u8::from(d.dot(toward) > CONE)));
            *sum += share * (hits[0] + hits[1]);
        }
    };
    let d = -direction(elevation, 0);
    let (u, v) = d.any_orthonormal_pair();
    for ray in 0..RAYS {
        let across = (f64::from(ray) + 0.5) / f64::from(RAYS) - 0.5;
        let along = (0.618_033_988_75 * f64::from(ray)).fract() - 0.5;
        let to_ray = EDGE * (across * u + along * v);
        let Some((near, ..)) = shape.cross(to_ray, d) else { continue };
        let (entry, inside) = Walk::enter(shape, to_ray + near * d, d, WATER);
        count(-entry.reflected, entry.reflectance);
        for exit in inside.into_iter().flat_map(|walk| walk.take(EXITS).flatten()) {
            count(-exit.direction, exit.weight);
        }
    }
    // Each exit was counted twice.
    let of_ray = 0.5 * EDGE * EDGE / f64::from(RAYS) / (TAU * (1.0 - CONE));
    sums.iter().zip(&seen).map(|(sum, seen)| of_ray * sum / (PI * outline(seen.y))).collect()
}

fn main() -> anyhow::Result<()> {
    let rows: Vec<Vec<f64>> = (0..DIAMETERS.len() * ANGLES)
        .into_par_iter()
        .map(|row| {
            let (diameter, elevation) = (DIAMETERS[row / ANGLES], row % ANGLES);
            let halves = Halves::of_diameter(diameter);
            let Halves { joint, equatorial, top, bottom } = halves;
            let shape = Shape::Halves { equatorial, top, bottom, joint };
            match row / ANGLES {
                0 => shown(Shape::Sphere, |_| 1.0, elevation),
                _ => shown(shape, |sine| halves.outline_area(sine), elevation),
            }
        })
        .collect();
    let size = [rows[0].len(), rows.len()].map(|length| length as u32);
    let image = GrayImage::from_fn(size[0], size[1], |column, row| {
        Luma([byte_of(rows[row as usize][column as usize])])
    });
    image.save("assets/flat-suns.png")?;
    let ends = rows
        .iter()
        .flatten()
        .fold([f64::MAX, 0.0_f64], |[least, most], shown| [least.min(*shown), most.max(*shown)]);
    println!("{:.5} to {:.3}", ends[0], ends[1]);
    Ok(())
}
