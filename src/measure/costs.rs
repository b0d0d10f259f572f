//! What a device takes for the parts of a frame, measured once and kept: three looks of one renderer, at
//! nothing, at many small drops, at one large one. Devices of one kind are ranked by the same figures.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::environment::Environment;
use crate::gpu::disk_cache::FiguresFile;
use crate::gpu::{Device, DeviceReport, Instance, Machine};
use crate::measure::bench::WarmUp;
use crate::plan::{Costs, Demand, Output, plan};
use crate::rain::cull::count_visible;
use crate::remark::Remark;
use crate::renderer::Renderer;
use crate::scene::model::Preset;
use crate::scene::{ModelChoice, PlacedDrop, RainSettings, Scene};

/// Edge of the picture in pixels.
const EDGE: u32 = 512;
/// Random drops, all of under a pixel of radius.
const DROPS: u32 = 1 << 16;
/// Half the edge of their box.
const EXTENT: f64 = 512.0;
/// Distance of the large drop, beyond all others.
const BEYOND: f64 = 2000.0;
/// The looks take turns for so long, once the pipelines are there, but at least …
const TIME: Duration = Duration::from_millis(250);
/// … so many times, and at most …
const FEWEST: usize = 3;
/// … so many.
const MOST: usize = 32;
/// A pixel that a drop covers takes so many fetches besides those of its ray.
const COVERED_IN_FETCHES: f64 = 1.0;
/// A drop whose rays are followed takes so many small ones, besides the rays.
const LARGE_IN_VISIBLE: f64 = 2.1;
/// … and one in or out of view this share of one.
const DROP_IN_VISIBLE: f64 = 1.0 / 190.0;

/// The figures of a device, as they are kept.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Version of the program that measured them; another version measures again.
    version: String,
    costs: Costs,
}

/// The scene of all looks, which differ by the camera's near plane alone.
fn scene() -> Scene {
    let mut scene = Scene {
        drops: vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, -BEYOND), 0.2 * BEYOND)],
        ..Scene::default()
    };
    let half_extent = DVec3::splat(EXTENT);
    scene.rain =
        Some(RainSettings { count: DROPS, half_extent, radius: 0.25, ..RainSettings::default() });
    scene.model = ModelChoice { preset: Preset::Fast, ..ModelChoice::default() };
    scene.camera.vertical_fov = 60.0;
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene
}

/// Measures `device`.
///
/// # Errors
/// See [`Renderer::new`], [`Renderer::submit`] and [`Renderer::finish`].
pub fn measure(device: &Arc<Device>) -> Result<Costs> {
    let small = Scene { drops: Vec::new(), ..scene() };
    let scene = scene();
    let grey = Environment::constant(glam::Vec3::ONE);
    let plan = plan(&scene, &grey, Output::Radiance)?;
    let mut renderer = Renderer::new(device, &scene, &grey, &plan)?;
    let mut look = |near: f64| -> Result<f64> {
        let mut scene = scene.clone();
        scene.camera.near = near;
        let before = Instant::now();
        renderer.draw(&scene)?;
        Ok(before.elapsed().as_secs_f64() * 1e9)
    };
    // Nothing; the large drop alone; all but the nearest drops, which would be large.
    let near = 0.25 * EXTENT;
    let looks = [10.0 * BEYOND, 0.5 * (BEYOND + EXTENT * 3.0f64.sqrt()), near];
    // The first of each compiles.
    for near in looks {
        look(near)?;
    }
    // A card at rest runs at a fraction of its clock.
    let mut warm_up = WarmUp::default();
    while device.report.machine == Machine::Gpu && warm_up.goes_on() {
        warm_up.take(1e-6 * look(near)?);
    }
    // The least of each: what else the machine does only adds.
    let mut least = [f64::INFINITY; 3];
    let start = Instant::now();
    for turn in 0..MOST {
        if turn >= FEWEST && start.elapsed() > TIME {
            break;
        }
        for (least, near) in least.iter_mut().zip(looks) {
            *least = least.min(look(near)?);
        }
    }
    let [nothing, large, all] = least;
    let mut seen = small;
    seen.camera.near = near;
    let visible = count_visible(&seen) as f64;
    let rays = Demand::of(&Scene { rain: None, ..scene.clone() }, 0.0);
    let covered: f64 = rays.classes.iter().map(|class| class.pixels).sum();

    // No figure is 0, however the clock jumps: a device for which everything is free would be offered all.
    let least = 1e-3;
    let pixel = nothing / f64::from(EDGE * EDGE);
    let visible = ((all - large) / visible).max(least);
    let fetches = 4.0 + COVERED_IN_FETCHES;
    let fetch = ((large - nothing) / covered / fetches).max(least);
    Ok(Costs {
        of: device.report.name.clone(),
        pixel: pixel.max(least),
        drop: DROP_IN_VISIBLE * visible,
        visible,
        covered: COVERED_IN_FETCHES * fetch,
        large: LARGE_IN_VISIBLE * visible,
        fetch,
    })
}

/// The costs that are kept of a device. `say` gets what is wrong with their file, which is no reason to
/// fail.
pub fn kept(report: &DeviceReport, folder: Option<&Path>, say: fn(&Remark)) -> Option<Costs> {
    let text = FiguresFile::new(folder?, &report.pipeline_key).read().unwrap_or_else(|problem| {
        say(&Remark::note(problem.to_string()));
        None
    });
    let kept = toml::from_str::<Kept>(&text?).ok()?;
    (kept.version == env!("CARGO_PKG_VERSION")).then_some(kept.costs)
}

/// The costs of a device: those that are kept, or measured now and kept.
///
/// # Errors
/// See [`measure`].
pub fn costs(device: &Arc<Device>, folder: Option<&Path>, say: fn(&Remark)) -> Result<Costs> {
    if let Some(costs) = kept(&device.report, folder, say) {
        return Ok(costs);
    }
    let kept = Kept { version: env!("CARGO_PKG_VERSION").into(), costs: measure(device)? };
    if let (Some(folder), Ok(text)) = (folder, toml::to_string(&kept))
        && let Err(problem) = FiguresFile::new(folder, &device.report.pipeline_key).write(&text)
    {
        say(&Remark::warning(format!("the device's times are not kept: {problem}")));
    }
    Ok(kept.costs)
}

/// A device, and its place among those of its kind.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// What it says of itself.
    pub report: DeviceReport,
    /// Milliseconds that a frame of the paper's scene is expected to take by preset `fast`; none where the
    /// device has no rival of its kind, and so was not measured.
    pub frame_ms: Option<f64>,
}

/// Every device, fittest first; where several of the fittest kind will do, by their [`costs`]. One that fails
/// while it is measured comes last of them, and is reported.
///
/// # Errors
/// See [`Instance::devices`].
pub fn ranked(
    instance: &Arc<Instance>,
    folder: Option<&Path>,
    say: fn(&Remark),
) -> Result<Vec<Ranked>> {
    let devices = instance.devices()?;
    let is_rival = |d: &DeviceReport| d.missing.is_empty() && d.is_as_fit_as(&devices[0]);
    let has_rivals = devices.iter().filter(|device| is_rival(device)).count() > 1;
    let of = |report: &DeviceReport| match kept(report, folder, say) {
        Some(costs) => Ok(costs),
        None => {
            let what = format!("finding out how fast {} is, once: some seconds", report.name);
            say(&Remark::note(what));
            costs(&Device::open(instance, report.clone())?, folder, say)
        }
    };
    let rank = |report: &DeviceReport| {
        let measured = (has_rivals && is_rival(report)).then(|| of(report));
        let frame_ms = measured.map(|costs| {
            costs.map_or_else(
                |problem| {
                    say(&Remark::note(format!("{} is not measured: {problem}", report.name)));
                    f64::INFINITY
                },
                |costs| frame_ms(&costs),
            )
        });
        Ranked { report: report.clone(), frame_ms }
    };
    let mut all: Vec<Ranked> = devices.iter().map(rank).collect();
    // Rivals come first already.
    all.sort_by(|a, b| match (a.frame_ms, b.frame_ms) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        _ => b.frame_ms.is_some().cmp(&a.frame_ms.is_some()),
    });
    Ok(all)
}

/// A frame of the paper's scene by preset `fast`.
fn frame_ms(costs: &Costs) -> f64 {
    costs.frame_ms(&Demand::of(&Scene::default(), 0.0), |_| None)
}
