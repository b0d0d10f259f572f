//! What exposures cost and get wrong: the tables of docs/exposure.md. `cargo run --release --example exposure speed`; names
//! of several tables print these, none all: minutes on two cores. `RAINDROPS_DEVICE` names a device, as `--device` does.
//!
//! - `speed`: the paper's scene with a million drops by `fast`: an instant, streaks of so many pixels in the median, a lens;
//!   measured in turn.
//! - `control`: real rain of 25 mm/h in three environments, spheres and flattened drops, against the same picture with its
//!   medium alone: as `fast` parts drops from the medium, and with streaks of all drops from 0.05 pixels of radius on; half
//!   an hour.
//! - `flicker`: of assets/scenes/slow-motion.toml, what the model changes from frame to frame and the reference does not.
//!
//! Errors are products of the distances from two references, so that their noise is no error.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;
use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::measure::bench::{Effort, Variant, measure};
use raindrops::measure::statistics::median;
use raindrops::picture::metrics::box_filter;
use raindrops::picture::tone_map::{Exposure, display, exposure_of};
use raindrops::picture::{Picture, srgb_of_linear};
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::model::{DropShape, FarRain, Preset};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{RainSettings, Scene};

type Table = fn(&Arc<Device>) -> anyhow::Result<()>;

fn main() -> anyhow::Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let instance = Instance::new(Validation::Off)?;
    let name = std::env::var("RAINDROPS_DEVICE").ok();
    let device = &Device::open(&instance, instance.choose(name.as_deref())?)?;
    println!("{}", device.report.summary());
    let tables: [(&str, Table); 3] = [("speed", speed), ("control", control), ("flicker", flicker)];
    for (name, table) in tables {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            println!("{name}");
            table(device)?;
        }
    }
    Ok(())
}

/// Median way in pixels that a motion gives to drops of a box, of those in view.
fn median_way(scene: &Scene, motion: DVec3) -> f64 {
    let (view, rain) = (scene.view(), scene.rain().expect("drops in a box"));
    let mut ways = Vec::new();
    for number in 0..100_000_u32 {
        // Evenly over the box: by powers of the root of x⁴ = x + 1.
        let at = f64::from(number) * DVec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
        let place = (2.0 * at.fract() - 1.0) * rain.half_extent;
        if view.pixel(place).is_some() {
            ways.push(
                view.point(place - 0.5 * motion).0.distance(view.point(place + 0.5 * motion).0),
            );
        }
    }
    median(&ways)
}

fn speed(device: &Arc<Device>) -> anyhow::Result<()> {
    let mut scene = Scene::default();
    (scene.image.width, scene.image.height) = (1024, 1024);
    scene.model.preset = Preset::Fast;
    let environment = Environment::bundled()?;
    let velocity = scene.rain().expect("drops").velocity;
    let a_pixel = median_way(&scene, velocity).recip();
    let mut variants = vec![("an instant".to_string(), scene.clone())];
    for pixels in [2.0, 8.0, 64.0] {
        let mut exposed = scene.clone();
        exposed.camera.shutter = pixels * a_pixel;
        variants.push((format!("streaks of {pixels} px"), exposed));
    }
    let mut lens = scene.clone();
    (lens.camera.aperture, lens.camera.focus) = (4.0, 300.0);
    variants.push(("a lens".into(), lens));
    let plans = variants.iter().map(|(_, scene)| {
        Ok(Variant { scene: scene.clone(), plan: plan(scene, &environment, Output::Display)? })
    });
    let plans = plans.collect::<anyhow::Result<Vec<_>>>()?;
    let measured = measure(
        device,
        &environment,
        &plans,
        Effort { seconds: 3.0, frames: 12, stop: || false },
        &|_| (),
    )?;
    let first = median(&measured[0].samples_ms);
    for ((name, _), times) in variants.iter().zip(&measured) {
        let ms = median(&times.samples_ms);
        print!("    {name:20} {ms:7.1} ms, {:5.2} of the first:", ms / first);
        for (pass, ms) in times.passes_ms.iter().filter(|(_, ms)| median(ms) >= 1.0) {
            print!(" {pass} {:.1}", median(ms));
        }
        println!();
    }
    Ok(())
}

/// References of a scene, each with noise of its own.
fn references<const COUNT: usize>(
    scene: &Scene,
    environment: &Environment,
    samples: u32,
    rain_to: Option<f64>,
) -> [Picture; COUNT] {
    let truth = Truth { samples, rain_to, ..Truth::default() };
    let tracer = Tracer::new(scene, environment, truth);
    std::array::from_fn(|seed| tracer.with_seed(seed as u64).picture())
}

fn drawn(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> anyhow::Result<Picture> {
    let mut renderer =
        Renderer::new(device, scene, environment, &plan(scene, environment, Output::Radiance)?)?;
    renderer.draw(scene)?;
    Ok(renderer.read_radiance()?)
}

/// A picture as it is shown, in sRGB values.
fn shown(exposure: Exposure, picture: &Picture) -> Vec<f64> {
    let shown = display(exposure, picture);
    shown.pixels.iter().flat_map(|p| p.to_array()).map(|v| f64::from(srgb_of_linear(v))).collect()
}

/// Mean square error of a picture against two references.
fn mean_square(picture: &[f64], [a, b]: [&[f64]; 2]) -> f64 {
    let products = picture.iter().zip(a.iter().zip(b)).map(|(p, (a, b))| (p - a) * (p - b));
    products.sum::<f64>() / picture.len() as f64
}

/// An error, by all pairs of the references, and its noise: the standard error of pairs that share none.
struct Estimate {
    mean: f64,
    noise: f64,
}

impl Estimate {
    fn of(picture: &[f64], references: &[Vec<f64>]) -> Self {
        let of_pair = |a: usize, b: usize| mean_square(picture, [&references[a], &references[b]]);
        let count = references.len();
        let all: Vec<f64> = (0..count)
            .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
            .map(|(a, b)| of_pair(a, b))
            .collect();
        let apart: Vec<f64> = (0..count / 2).map(|pair| of_pair(2 * pair, 2 * pair + 1)).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let squares = apart.iter().map(|value| (value - mean(&apart)).powi(2)).sum::<f64>();
        let pairs = apart.len() as f64;
        Self { mean: mean(&all), noise: (squares / (pairs - 1.0) / pairs).sqrt() }
    }
}

/// A narrow view: a box of the filter is 2.5 cm wide at 1 m, so that one streak shows in it. Seen by 40° at 160 pixels the
/// medium's own error was within the noise of references of 64 samples.
fn control(device: &Arc<Device>) -> anyhow::Result<()> {
    const SAMPLES: u32 = 512;
    for shape in [DropShape::Sphere, DropShape::Equilibrium] {
        for name in ["city", "forest", "courtyard"] {
            let image = format!("assets/environments/{name}.exr");
            let environment = Environment::load(image.as_ref())?;
            for shutter in [1.0 / 60.0, 1.0 / 250.0, 1e-3] {
                let mut scene = Scene::default();
                (scene.image.width, scene.image.height) = (96, 96);
                let extent = 20.0;
                let rain = RealRain { extent, shape, ..RealRain::default() };
                scene.rain = Some(RainSettings::of(rain));
                (scene.camera.vertical_fov, scene.camera.shutter) = (12.0, shutter);
                scene.camera.target = DVec3::new(0.0, 0.12, -1.0);
                scene.model.preset = Preset::Fast;
                let references: [_; 8] = references(&scene, &environment, SAMPLES, Some(extent));
                let exposure = exposure_of(&scene.tone_map, &references[0]);
                let boxed = references.each_ref().map(|one| shown(exposure, &box_filter(one)));
                let error = |cutoff_px: Option<f64>| -> anyhow::Result<Estimate> {
                    let mut scene = scene.clone();
                    scene.model.far_rain = cutoff_px.map(|_| FarRain::Medium);
                    scene.model.cutoff_px = cutoff_px;
                    let picture = box_filter(&drawn(device, &scene, &environment)?);
                    Ok(Estimate::of(&shown(exposure, &picture), &boxed))
                };
                let medium = error(Some(1.0))?;
                print!(
                    "    {shape:?} {name:9} 1/{:<4.0} s: the medium {:.1e} ± {:.0e}",
                    shutter.recip(),
                    medium.mean,
                    medium.noise
                );
                for (what, cutoff_px) in [("streaks", None), ("from 0.05 px on", Some(0.05))] {
                    let Estimate { mean, noise } = error(cutoff_px)?;
                    print!("; {what} {mean:.1e} ± {noise:.0e}, {:.2} of it", mean / medium.mean);
                }
                println!();
            }
        }
    }
    Ok(())
}

fn flicker(device: &Arc<Device>) -> anyhow::Result<()> {
    const PAIRS: u32 = 12;
    let mut scene = Scene::load(Path::new("assets/scenes/slow-motion.toml"))?;
    (scene.image.width, scene.image.height) = (160, 90);
    let rain = RealRain { extent: 15.0, ..scene.real_rain().context("real rain")? };
    scene.rain = Some(RainSettings::of(rain));
    let environment = Environment::bundled()?;
    let plan = plan(&scene, &environment, Output::Radiance)?;
    let mut renderer = Renderer::new(device, &scene, &environment, &plan)?;
    let mut sums = [0.0; 2];
    for pair in 0..PAIRS {
        let first = pair * (scene.film.frames() - 2) / (PAIRS - 1);
        let mut shown_of = |number: u32| -> anyhow::Result<[Vec<f64>; 3]> {
            let frame = scene.film.frame(&scene, number);
            let [a, b] = references(&frame, &environment, 32, Some(rain.extent));
            let exposure = exposure_of(&scene.tone_map, &a);
            renderer.draw(&frame)?;
            Ok([renderer.read_radiance()?, a, b].map(|picture| shown(exposure, &picture)))
        };
        let (before, after) = (shown_of(first)?, shown_of(first + 1)?);
        let change = |of: usize, at: usize| after[of][at] - before[of][at];
        let count = before[0].len();
        let mean = |f: &dyn Fn(usize) -> f64| (0..count).map(f).sum::<f64>() / count as f64;
        let own = mean(&|at| (change(0, at) - change(1, at)) * (change(0, at) - change(2, at)));
        let all = mean(&|at| change(1, at) * change(2, at));
        let pace = scene.film.frame(&scene, first).pace;
        println!(
            "    frame {first:3}, pace {pace:.4}: {:.5} of {:.5}",
            own.max(0.0).sqrt(),
            all.max(0.0).sqrt()
        );
        sums = [sums[0] + own, sums[1] + all];
    }
    let [own, all] = sums.map(|sum| (sum / f64::from(PAIRS)).max(0.0).sqrt());
    println!("    RMS {own:.5} that the reference does not change; it changes {all:.5}");
    Ok(())
}
