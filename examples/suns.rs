//! Rain before, beside and behind a bare sun: eight scenes by `paper`, `fast` and rays against the reference, and how
//! much each flickers while the view turns slowly. `cargo run --release --example suns`, minutes on two cores.
//!
//! Errors are the RMS of sRGB values after the reference's tone mapping: the root of the mean product of the distances
//! from two references, so that their noise is no error; then relMSE of radiance against both together. Flicker is the
//! mean change of an sRGB value from one frame to the next, an eighth of a pixel farther each. Names of models after
//! the command choose them: `suns paper fast 1`; `RAINDROPS_DEVICE` names a device, as `--device` does.

use std::sync::Arc;

use anyhow::Context as _;
use glam::{DQuat, DVec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::picture::metrics::rel_mse;
use raindrops::picture::tone_map::{Exposure, display, exposure_of};
use raindrops::picture::{Picture, srgb_of_linear};
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{RainSettings, Scene};

const REFERENCE_SAMPLES: u32 = 64;
const PAN_FRAMES: u32 = 24;

/// Environment (none: the bundled sky), where the sun stands, degrees off the axis of view, drops, half the box's edge.
const SCENES: [(Option<&str>, &str, f64, u32, f64); 8] = [
    (Some("sunrise"), "in view", 8.0, 20_000, 300.0),
    (None, "in view", 8.0, 100_000, 500.0),
    (None, "beside", 75.0, 20_000, 250.0),
    (None, "behind", 172.0, 300_000, 700.0),
    (Some("sunset"), "in view", 8.0, 20_000, 300.0),
    (Some("sunrise"), "beside", 75.0, 5_000, 150.0),
    (Some("sunrise"), "behind", 172.0, 100_000, 400.0),
    (Some("sunset"), "in view, near", 8.0, 2_000, 40.0),
];

/// Models: a name, a preset, rays a pixel.
const MODELS: [(&str, Preset, Option<u32>); 6] = [
    ("paper", Preset::Paper, None),
    ("fast", Preset::Fast, None),
    ("1", Preset::Exact, Some(1)),
    ("4", Preset::Exact, Some(4)),
    ("16", Preset::Exact, Some(16)),
    ("64", Preset::Exact, Some(64)),
];

fn scene(toward: DVec3, degrees: f64, count: u32, half: f64) -> Scene {
    let mut scene = Scene::default();
    (scene.image.width, scene.image.height) = (256, 256);
    let half_extent = DVec3::splat(half);
    scene.rain = Some(RainSettings { count, half_extent, ..RainSettings::default() });
    scene.camera.vertical_fov = 60.0;
    // A drop at the near plane has a radius of 30 pixels.
    scene.camera.near = 7.4;
    let turned = DQuat::from_rotation_y(degrees.to_radians()) * toward;
    scene.camera.target = DVec3::new(turned.x, 0.3 * turned.y, turned.z);
    scene
}

/// A picture as it is shown, in sRGB values.
fn shown(exposure: Exposure, picture: &Picture) -> Vec<f64> {
    let shown = display(exposure, picture);
    shown.pixels.iter().flat_map(|p| p.to_array()).map(|v| f64::from(srgb_of_linear(v))).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// RMS error of a picture against two references, whose noise is not the same.
fn rms(picture: &[f64], [a, b]: &[Vec<f64>; 2]) -> f64 {
    let pairs = a.iter().zip(b);
    mean(picture.iter().zip(pairs).map(|(p, (a, b))| (p - a) * (p - b))).max(0.0).sqrt()
}

fn renderer(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> anyhow::Result<Renderer> {
    let plan = plan(scene, environment, Output::Radiance)?;
    Ok(Renderer::new(device, scene, environment, &plan)?)
}

fn main() -> anyhow::Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let models: Vec<_> = MODELS
        .into_iter()
        .filter(|(name, ..)| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name))
        .collect();
    let instance = Instance::new(Validation::Off)?;
    let wanted_device = std::env::var("RAINDROPS_DEVICE").ok();
    let device = &Device::open(&instance, instance.choose(wanted_device.as_deref())?)?;
    println!("{}", device.report.summary());
    for (file, name, degrees, count, half) in SCENES {
        let environment = match file {
            Some(file) => Environment::load(format!("assets/environments/{file}.exr").as_ref())?,
            None => Environment::bundled()?,
        };
        let sun = split(&environment).context("no bare sun")?.regions[0].direction;
        let mut scene = scene(sun, degrees, count, half);
        let truth = Truth { samples: REFERENCE_SAMPLES, ..Truth::default() };
        let tracer = Tracer::new(&scene, &environment, truth);
        let halves = [0, 1].map(|seed| tracer.with_seed(seed).picture());
        let pairs = halves[0].pixels.iter().zip(&halves[1].pixels);
        let pixels = pairs.map(|(a, b)| 0.5 * (*a + *b)).collect();
        let reference = Picture { pixels, ..halves[0] };
        let exposure = exposure_of(&scene.tone_map, &reference);
        let references = halves.each_ref().map(|half| shown(exposure, half));
        println!("{}, sun {name}, {count} drops", file.unwrap_or("sky"));
        for &(name, preset, samples) in &models {
            (scene.model.preset, scene.model.samples) = (preset, samples);
            let mut renderer = renderer(device, &scene, &environment)?;
            renderer.submit(&scene)?;
            let first = renderer.read_radiance()?;
            let rel_mse = rel_mse(&reference, &first, None);
            let (mut last, mut flicker) = (shown(exposure, &first), 0.0);
            let rms = rms(&last, &references);
            let step = 0.125 / scene.view().focal_px;
            for frame in 1..=PAN_FRAMES {
                let mut turned = scene.clone();
                let by = DQuat::from_rotation_y(f64::from(frame) * step);
                turned.camera.target = by * scene.camera.target;
                renderer.submit(&turned)?;
                let next = shown(exposure, &renderer.read_radiance()?);
                flicker += mean(last.iter().zip(&next).map(|(a, b)| (a - b).abs()))
                    / f64::from(PAN_FRAMES);
                last = next;
            }
            println!("    {name:5} RMS {rms:.4}, relMSE {rel_mse:.2e}, flicker {flicker:.5}");
        }
    }
    Ok(())
}
