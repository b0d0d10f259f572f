//! How preset `auto` keeps its word: twelve scenes at four accepted errors, each against every model that it
//! chooses from. `cargo run --release --example auto`, minutes on two cores. `RAINDROPS_DEVICE` names a device, as `--device` does.
//!
//! For each: what is chosen, its error over all pixels against the reference, and its time over that of the
//! quickest model that keeps the error. Kept, told to be out of reach, told although a model reaches it, or
//! missed in silence.

use std::sync::Arc;

use anyhow::Context as _;
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::measure::bench::{Effort, Variant, measure};
use raindrops::measure::{costs, resolve};
use raindrops::picture::tone_map::{display, exposure_of};
use raindrops::picture::{Picture, srgb_of_linear};
use raindrops::plan::{Choice, Output, Prospect, keep, plan_by, prospects};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

const ERRORS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
const REFERENCE_SAMPLES: u32 = 256;

/// Name, environment file (none: the bundled sky), edge in pixels, field of view, and drops.
fn scenes() -> Vec<(&'static str, Option<&'static str>, Scene)> {
    let rain = |count, half: f64, edge, fov| {
        let mut scene = Scene::default();
        let half_extent = DVec3::splat(half);
        scene.rain = Some(RainSettings { count, half_extent, ..RainSettings::default() });
        scene.camera.near = 2.0;
        scene.camera.vertical_fov = fov;
        (scene.image.width, scene.image.height) = (edge, edge);
        scene
    };
    let placed =
        |drops: Vec<PlacedDrop>, edge, fov| Scene { rain: None, drops, ..rain(0, 9.0, edge, fov) };
    let one = vec![PlacedDrop::sphere(DVec3::new(2.0, 1.0, -4.0), 1.0)];
    let forty = (0..40).map(|n| f64::from(n) * 2.4).map(|angle| {
        let center = DVec3::new(angle * angle.cos(), 0.6 * angle * angle.sin(), -90.0 - angle);
        PlacedDrop::sphere(center, 1.0 + (7.0 * angle).sin().abs())
    });
    let mut upward = rain(20_000, 150.0, 192, 75.0);
    upward.camera.target = DVec3::new(0.3, 0.8, -0.5);
    vec![
        ("nothing", Some("studio"), rain(0, 9.0, 256, 90.0)),
        ("nothing", Some("forest"), rain(0, 9.0, 192, 90.0)),
        ("one aside", Some("courtyard"), placed(one.clone(), 256, 60.0)),
        ("one aside", None, placed(one, 256, 60.0)),
        ("forty", Some("city"), placed(forty.collect(), 256, 50.0)),
        ("small", None, rain(100_000, 400.0, 256, 90.0)),
        ("small", Some("sunset"), rain(200_000, 600.0, 256, 90.0)),
        ("million", Some("forest"), rain(1_000_000, 1025.0, 256, 90.0)),
        ("near", Some("interior"), rain(3_000, 40.0, 256, 60.0)),
        ("near", Some("night"), rain(2_000, 50.0, 256, 60.0)),
        ("upward", Some("sunrise"), upward),
        ("narrow", Some("studio"), rain(50_000, 300.0, 256, 30.0)),
    ]
}

fn picture(
    device: &Arc<Device>,
    variant: &Variant,
    environment: &Environment,
) -> anyhow::Result<Picture> {
    let mut renderer = Renderer::new(device, &variant.scene, environment, &variant.plan)?;
    renderer.submit(&variant.scene)?;
    Ok(renderer.read_radiance()?)
}

fn main() -> anyhow::Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let instance = Instance::new(Validation::Off)?;
    let wanted_device = std::env::var("RAINDROPS_DEVICE").ok();
    let device = &Device::open(&instance, instance.choose(wanted_device.as_deref())?)?;
    let costs = costs::measure(device)?;
    println!("{}: {costs:?}", device.report.summary());
    let (mut kept, mut told, mut over_told, mut missed, mut slow) = (0, 0, 0, 0, 0);
    for (number, (name, file, mut scene)) in scenes().into_iter().enumerate() {
        if !wanted.is_empty() && !wanted.contains(&number.to_string()) {
            continue;
        }
        let environment = match file {
            Some(file) => Environment::load(format!("assets/environments/{file}.exr").as_ref())?,
            None => Environment::bundled()?,
        };
        scene.model.preset = Preset::Auto;
        // Two references, so that their noise, which is not the same in both, is not taken for an error.
        let references = [7, 8].map(|seed| {
            let truth = Truth { samples: REFERENCE_SAMPLES / 2, seed, ..Truth::default() };
            Tracer::new(&scene, &environment, truth).picture()
        });
        let exposure = exposure_of(&scene.tone_map, &references[0]);
        let shown = references.map(|reference| display(exposure, &reference));
        let variant = |scene: &Scene, choice: &Choice| -> anyhow::Result<Variant> {
            let plan = plan_by(scene, &environment, Some(choice), Output::Radiance)?;
            Ok(Variant { scene: scene.clone(), plan })
        };
        let rms = |variant: &Variant| -> anyhow::Result<f64> {
            let found = display(exposure, &picture(device, variant, &environment)?);
            let [a, b] = &shown;
            let srgb = |pixel: &Vec3| Vec3::from(pixel.to_array().map(srgb_of_linear)).as_dvec3();
            let of_pixel =
                |((c, a), b): ((&Vec3, &Vec3), &Vec3)| (srgb(c) - srgb(a)).dot(srgb(c) - srgb(b));
            let pixels = found.pixels.iter().zip(&a.pixels).zip(&b.pixels);
            let sum: f64 = pixels.map(of_pixel).sum();
            Ok((sum / (3 * found.pixels.len()) as f64).max(0.0).sqrt())
        };

        // Every model that there is to choose from: its error and its time, in turn.
        let prospects = prospects(&scene, &environment, &costs);
        let mut variants = Vec::new();
        for prospect in &prospects {
            variants.push(variant(&scene, &keep(1.0, None, &[*prospect], "expected"))?);
        }
        let effort = Effort { seconds: 0.15, frames: 6, stop: || false };
        let times = measure(device, &environment, &variants, effort, &|_| ())?;
        let mut fixed = Vec::new();
        for ((variant, times), prospect) in variants.iter().zip(&times).zip(&prospects) {
            // The least: what else the machine does only adds.
            let ms = times.samples_ms.iter().copied().fold(f64::INFINITY, f64::min);
            let (error, plan) = (rms(variant)?, variant.plan.clone());
            let Prospect { error: expected, ms: expected_ms, .. } = prospect;
            println!(
                "    {:12} {:2} rays, {} internal, reflection {:3}: error {error:.4} (expected {expected:.4}), \
                 {ms:8.1} ms ({expected_ms:.1})",
                plan.optics, plan.samples, plan.light.internal_reflections, plan.light.reflection
            );
            fixed.push((plan, error, ms));
        }
        for accepted in ERRORS {
            scene.model.error = Some(accepted);
            let choice = resolve(device, &scene, &environment, &costs)?.context("preset auto")?;
            let chosen = variant(&scene, &choice)?;
            let same = fixed.iter().find(|(plan, ..)| {
                (plan.optics, plan.samples, plan.light)
                    == (chosen.plan.optics, chosen.plan.samples, chosen.plan.light)
            });
            let (_, error, ms) = same.context("one of the models")?;
            let best = fixed.iter().filter(|(_, error, _)| *error <= accepted).map(|(.., ms)| *ms);
            let best = best.min_by(f64::total_cmp);
            let ratio = best.map(|best| ms / best);
            let verdict = match (choice.doubt.is_some(), *error <= accepted, ratio) {
                (true, _, None) => {
                    told += 1;
                    "told"
                }
                (true, _, Some(_)) => {
                    over_told += 1;
                    "told, though one reaches it"
                }
                (false, false, _) => {
                    missed += 1;
                    "MISSED"
                }
                (false, true, ratio) => {
                    kept += 1;
                    let is_slow = ratio.is_some_and(|ratio| ratio > 1.5);
                    slow += usize::from(is_slow);
                    if is_slow { "kept, SLOW" } else { "kept" }
                }
            };
            println!(
                "{number:2} {name:10} {:10} {accepted:5}: {error:.4} {verdict}, {:.2} of the quickest; {}",
                file.unwrap_or("sky"),
                ratio.unwrap_or(f64::NAN),
                choice.summary()
            );
        }
    }
    println!(
        "{kept} kept (of them {slow} over 1.5 times the quickest), {told} told, {over_told} told in vain, {missed} missed in silence"
    );
    Ok(())
}
