//! The picture of single drops on the GPU against the paper's model in float64.

mod common;

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::model::Optics;
use raindrops::paper_twin::{PaperTwin, Sprite};
use raindrops::passes::drops::guard_band;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};
use rayon::prelude::*;

const SIZE: u32 = 512;

/// A smooth environment without edges: a gradient along each axis for each colour.
fn gradient() -> Environment {
    let (width, height) = (512u32, 256u32);
    let texels = (0..width * height).map(|index| {
        let u = (f64::from(index % width) + 0.5) / f64::from(width);
        let v = (f64::from(index / width) + 0.5) / f64::from(height);
        let (longitude, polar) = (std::f64::consts::TAU * (u - 0.5), std::f64::consts::PI * v);
        let d =
            DVec3::new(polar.sin() * longitude.sin(), polar.cos(), -polar.sin() * longitude.cos());
        (1.5 + d).as_vec3()
    });
    Environment::from_texels("gradient", width, height, texels.collect()).expect("a sound image")
}

fn courtyard() -> Option<Environment> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/environments/courtyard.exr");
    if !std::path::Path::new(path).exists() {
        println!("SKIPPED: there is no {path}");
        return None;
    }
    Some(Environment::load(path.as_ref()).expect("a sound image"))
}

/// A drop of radius 1 at a distance, on the axis or 30° off it in a slanted direction.
fn scene(distance: f64, off_axis: bool) -> Scene {
    // A little off the pixel grid, so that no edge of a square passes through pixel centres.
    let direction = if off_axis {
        let angle = 30f64.to_radians();
        DVec3::new(0.8 * angle.sin(), 0.6 * angle.sin(), -angle.cos())
    } else {
        DVec3::new(0.0013, -0.0007, -1.0).normalize()
    };
    let mut scene = common::one_drop(distance * direction, 1.0);
    scene.image = ImageSize { width: SIZE, height: SIZE };
    scene
}

fn render(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Picture {
    let plan = plan(scene, Output::Radiance);
    let mut renderer = Renderer::new(device, scene, environment, &plan).expect("a renderer");
    renderer.submit(scene).expect("a frame");
    renderer.read_radiance().expect("radiance")
}

/// Relative error over the pixels of a drop.
#[derive(Clone, Copy, Debug, Default)]
struct Off {
    pixels: usize,
    mean: f64,
    /// 99 pixels of 100 are within it.
    most_of_99: f64,
    most: f64,
    /// Where the largest is, in sprite coordinates (s, t).
    at: DVec2,
}

fn compare(gpu: &Picture, twin: &PaperTwin, sprites: &[Sprite]) -> Off {
    let mut errors: Vec<(f64, DVec2)> = (0..SIZE * SIZE)
        .into_par_iter()
        .filter_map(|index| {
            let point = DVec2::new((index % SIZE).into(), (index / SIZE).into()) + 0.5;
            let at = sprites.iter().find_map(|sprite| sprite.texture_place(point))?;
            let exact = twin.pixel(sprites, point);
            let off = (gpu.pixels[index as usize].as_dvec3() - exact).abs().max_element();
            let st = DVec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
            Some((off / exact.max_element(), st))
        })
        .collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(most, at)) = errors.last() else { return Off::default() };
    Off {
        pixels: errors.len(),
        mean: errors.iter().map(|(error, _)| error).sum::<f64>() / errors.len() as f64,
        most_of_99: errors[(errors.len() - 1) * 99 / 100].0,
        most,
        at,
    }
}

fn point_limit(device: &Device) -> f64 {
    guard_band(device, SIZE, SIZE).1.into()
}

const DISTANCES: [f64; 5] = [1.6, 3.0, 10.0, 60.0, 400.0];

fn check(environment: &Environment, optics: Optics) {
    common::on_device(|device| {
        for off_axis in [false, true] {
            for distance in DISTANCES {
                let mut scene = scene(distance, off_axis);
                scene.model.optics = Some(optics);
                let twin = PaperTwin::new(&scene, environment);
                let sprites = PaperTwin::sprites(&scene, point_limit(device));
                assert_eq!(sprites.len(), 1);
                let off = compare(&render(device, &scene, environment), &twin, &sprites);
                println!(
                    "{}, {optics}, d = {distance}{}: {} pixels, mean {:.1e}, 99 % {:.1e}, largest \
                     {:.1e} at ({:+.3}, {:+.3}), |st| {:.3}, level {:.2}",
                    environment.name(),
                    if off_axis { ", 30° off" } else { "" },
                    off.pixels,
                    off.mean,
                    off.most_of_99,
                    off.most,
                    off.at.x,
                    off.at.y,
                    off.at.length(),
                    sprites[0].level,
                );
            }
        }
    });
}

#[test]
fn gradient_through_the_float16_mask() {
    check(&gradient(), Optics::Mask);
}

#[test]
fn gradient_through_the_float32_mask() {
    check(&gradient(), Optics::MaskF32);
}

#[test]
fn the_bundled_sky() {
    check(&Environment::bundled().expect("the sky"), Optics::MaskF32);
}

#[test]
fn a_courtyard() {
    if let Some(environment) = courtyard() {
        check(&environment, Optics::MaskF32);
    }
}
