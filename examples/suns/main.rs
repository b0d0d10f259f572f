//! Rain before, beside and behind a bare sun: eight scenes by `paper`, `fast` and rays against the reference, and how
//! much each flickers while the view turns slowly. `cargo run --release --example suns`, minutes on two cores.
//!
//! Errors are the RMS of sRGB values after the reference's tone mapping ([`References::rms`]), then relMSE of radiance
//! against both references together. Flicker is the
//! mean change of an sRGB value from one frame to the next, an eighth of a pixel farther each. Names of models after
//! the command choose them: `suns paper fast 1`; `RAINDROPS_DEVICE` names a device, as `--device` does.

mod scenes;

use std::sync::Arc;

use anyhow::Context as _;
use glam::DQuat;
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::picture::metrics::rel_mse;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;
use scenes::{References, SUNS, mean, shown};

const REFERENCE_SAMPLES: u32 = 64;
const PAN_FRAMES: u32 = 24;

/// Models: a name, a preset, rays a pixel.
const MODELS: [(&str, Preset, Option<u32>); 6] = [
    ("paper", Preset::Paper, None),
    ("fast", Preset::Fast, None),
    ("1", Preset::Exact, Some(1)),
    ("4", Preset::Exact, Some(4)),
    ("16", Preset::Exact, Some(16)),
    ("64", Preset::Exact, Some(64)),
];

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
    for sun in SUNS {
        let environment = match sun.photograph {
            Some(file) => Environment::load(format!("assets/environments/{file}").as_ref())?,
            None => Environment::bundled()?,
        };
        let mut scene = sun.scene(&environment).context("no bare sun")?;
        let references = References::new(&scene, &environment, REFERENCE_SAMPLES);
        let exposure = references.exposure;
        println!("{}, sun {}, {} drops", sun.photograph.unwrap_or("sky"), sun.name, sun.drops);
        for &(name, preset, samples) in &models {
            (scene.model.preset, scene.model.samples) = (preset, samples);
            let mut renderer = renderer(device, &scene, &environment)?;
            renderer.submit(&scene)?;
            let first = renderer.read_radiance()?;
            let rel_mse = rel_mse(&references.mean, &first, None);
            let (mut last, mut flicker) = (shown(exposure, &first), 0.0);
            let rms = references.rms(&last);
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
