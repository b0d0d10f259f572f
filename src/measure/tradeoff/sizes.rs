//! The error of each model by a drop's radius in pixels: one drop on the axis, seen from several
//! directions of several environments. What `plan` chooses by is made of these figures.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::environment::Environment;
use crate::environment::bright::split;
use crate::gpu::Device;
use crate::measure::statistics::median;
use crate::picture::flip::{PIXELS_PER_DEGREE, flip};
use crate::picture::tone_map::{Exposure, display, exposure_of};
use crate::picture::{Picture, srgb_of_linear};
use crate::plan::{Output, contrast, plan};
use crate::reference::{Traced, Tracer, Truth, Weights};
use crate::renderer::Renderer;
use crate::scene::model::{Lookup, Optics, Preset, Primitive};
use crate::scene::{ModelChoice, PlacedDrop, Scene, ToneMap};
use crate::thousands::counted;

/// Distance of the drop in radii: far enough that it looks as from infinity (0.4°).
const DISTANCE: f64 = 100.0;

/// Least focal length in pixels; smaller drops stand farther away. With a wider view the background
/// around them would vary within a pixel.
const FOCAL_PX: f64 = 50.0;

/// What is held against the truth.
#[derive(Clone, Copy, Debug)]
pub enum Candidate {
    /// A model of the renderer.
    Model(ModelChoice),
    /// A physics with something left out, traced as finely as the truth itself.
    Converged(Truth),
}

/// A model's error at one size: medians over environments of means over views.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SizeRow {
    /// The model's name.
    pub model: String,
    /// Radius of the drop in pixels.
    pub radius_px: f64,
    /// RMS error of sRGB values, 0 to 1, weighted by how far the drop covers a pixel.
    pub rms: f64,
    /// Mean FLIP error, likewise.
    pub flip: f64,
    /// `rms` over the environment's [`contrast`].
    pub rms_of_contrast: f64,
    /// Root of the squared errors' sum over the whole of each pixel that the drop is in, over the pixels
    /// that it covers: what its area adds to the error of a picture. Over `rms` for small drops.
    pub rms_of_area: f64,
}

/// What small bright sources add to a model's error at one size.
#[derive(Clone, Debug, Serialize)]
pub struct GlintRow {
    /// The model's name.
    pub model: String,
    /// Radius of the drop in pixels.
    pub radius_px: f64,
    /// RMS of sRGB values, 0 to 1, over the area of the drop and the root of the sources' light.
    pub rms: f64,
}

/// The models whose errors depend on a drop's size, by name.
pub fn candidates() -> Vec<(String, Candidate)> {
    let paper = ModelChoice { preset: Preset::Paper, ..ModelChoice::default() };
    // It draws the drop as in a crowd: a few it would draw by rays.
    let fast = ModelChoice { preset: Preset::Fast, samples: Some(1), ..paper };
    let finest = ModelChoice { lookup: Some(Lookup::Finest), ..paper };
    let closed = |samples| ModelChoice {
        optics: Some(Optics::ClosedForm),
        primitive: Some(Primitive::Tile),
        samples: Some(samples),
        internal_reflections: Some(2),
        ..paper
    };
    let mut all: Vec<(String, Candidate)> = vec![
        ("mask, finest look-up".into(), Candidate::Model(finest)),
        ("mask".into(), Candidate::Model(paper)),
    ];
    for samples in [1, 4, 16, 64] {
        let name = format!("closed form, {}", counted(samples.into(), "ray"));
        all.push((name, Candidate::Model(closed(samples))));
    }
    let far = ModelChoice { optics: Some(Optics::Far), internal_reflections: Some(2), ..paper };
    all.push(("far: one colour".into(), Candidate::Model(far)));
    all.push(("appearance (fast)".into(), Candidate::Model(fast)));
    let whole = Truth::default();
    for (name, truth) in [
        ("paper's weights", Truth { weights: Weights::Paper, ..whole }),
        ("no reflection", Truth { reflection: false, ..whole }),
        ("no internal reflection", Truth { internal_reflections: 0, ..whole }),
        ("one internal reflection", Truth { internal_reflections: 1, ..whole }),
    ] {
        all.push((format!("{name}, converged"), Candidate::Converged(truth)));
    }
    all
}

/// The environment's texels as a picture.
fn of_environment(environment: &Environment) -> Picture {
    let (width, height) = (environment.width(), environment.height());
    Picture { width, height, pixels: environment.texels().to_vec() }
}

/// Views of drops of `radius_px` pixels: one in the middle of each, the others out of sight. All hold
/// the same drops, so that one renderer serves for all.
fn scenes(radius_px: f64, views: u32) -> Vec<Scene> {
    let mut scene = Scene { rain: None, ..Scene::default() };
    let edge = (2.0 * radius_px).ceil() as u32 + 8;
    (scene.image.width, scene.image.height) = (edge, edge);
    let distance = DISTANCE.max(FOCAL_PX / radius_px);
    let focal = radius_px * (distance * distance - 1.0).sqrt();
    scene.camera.vertical_fov = 2.0 * (0.5 * f64::from(edge) / focal).atan().to_degrees();
    let mut cameras = Vec::new();
    for number in 0..views {
        // Directions a golden angle apart, near the horizon, where environments vary most; each drop
        // at another place between pixels.
        let angle = f64::from(number) * 2.4;
        let forward = DVec3::new(angle.sin(), 0.25 * (1.7 * angle).sin(), -angle.cos()).normalize();
        scene.camera.target = scene.camera.position + forward;
        cameras.push(scene.camera);
        let view = scene.view();
        let phase = |step: f64| (f64::from(number + 1) * step).fract() - 0.5;
        let (x, y) = (phase(0.754_877_666_2), phase(0.569_840_291));
        let aside = (x * view.right + y * view.up) / focal;
        let center = scene.camera.position + distance * (forward + aside).normalize();
        scene.drops.push(PlacedDrop::sphere(center, 1.0));
    }
    cameras.into_iter().map(|camera| Scene { camera, ..scene.clone() }).collect()
}

/// Every candidate at every radius.
///
/// # Errors
/// See [`crate::plan::plan`], [`Renderer::new`], [`Renderer::submit`] and
/// [`Renderer::read_radiance`], for the first model that fails.
pub fn by_size(
    device: &Arc<Device>,
    environments: &[Environment],
    candidates: &[(String, Candidate)],
    radii_px: &[f64],
    views: u32,
    say: &dyn Fn(f64),
) -> Result<Vec<SizeRow>> {
    let mut rows = Vec::new();
    let steps = (radii_px.len() * environments.len()) as f64;
    for (number, &radius_px) in radii_px.iter().enumerate() {
        let mut found = vec![Vec::new(); candidates.len()];
        for (index, environment) in environments.iter().enumerate() {
            say((number * environments.len() + index) as f64 / steps);
            // A drop gets the same number of samples whatever its size, and a pixel at least 64.
            let samples = ((200_000.0 / (radius_px * radius_px)) as u32).clamp(64, 4096);
            let picture = of_environment(environment);
            let exposure = exposure_of(&ToneMap::default(), &picture);
            let scenes = scenes(radius_px, views);
            let trace = |truth: Truth| -> Vec<Traced> {
                let truth = Truth { samples, ..truth };
                let trace = |scene| Tracer::new(scene, environment, truth).trace(&|_| ());
                scenes.iter().map(trace).collect()
            };
            let truths = trace(Truth::default());
            let contrast = contrast(environment);
            for ((_, candidate), found) in candidates.iter().zip(&mut found) {
                let pictures = match candidate {
                    Candidate::Model(choice) => render(device, environment, &scenes, *choice)?,
                    Candidate::Converged(truth) => {
                        trace(*truth).into_iter().map(|traced| traced.picture).collect()
                    }
                };
                let errors: Vec<[f64; 3]> = truths
                    .iter()
                    .zip(&pictures)
                    .map(|(truth, picture)| errors(truth, picture, exposure))
                    .collect();
                let mean = |which: usize| {
                    errors.iter().map(|error| error[which]).sum::<f64>() / errors.len() as f64
                };
                let rms = mean(0).sqrt();
                found.push([rms, mean(1), rms / contrast.max(1e-6), mean(2).sqrt()]);
            }
        }
        rows.extend(candidates.iter().zip(found).map(|((model, _), found)| {
            let pick = |which: usize| {
                median(&found.iter().map(|figures| figures[which]).collect::<Vec<f64>>())
            };
            SizeRow {
                model: model.clone(),
                radius_px,
                rms: pick(0),
                flip: pick(1),
                rms_of_contrast: pick(2),
                rms_of_area: pick(3),
            }
        }));
    }
    Ok(rows)
}

/// What small bright sources add to each candidate's error: of an environment and of the same without
/// them, the difference of the squared [`SizeRow::rms_of_area`], over the sources' light
/// ([`Bright::strength`]); its root. `None` for an environment without such sources.
///
/// # Errors
/// See [`by_size`].
///
/// [`Bright::strength`]: crate::environment::bright::Bright::strength
pub fn glints_by_size(
    device: &Arc<Device>,
    environment: &Environment,
    candidates: &[(String, Candidate)],
    radii_px: &[f64],
    views: u32,
    say: &dyn Fn(f64),
) -> Result<Option<Vec<GlintRow>>> {
    let Some(bright) = split(environment) else { return Ok(None) };
    let rows = |environment: &Environment, from: f64| {
        let say = |share: f64| say(from + 0.5 * share);
        by_size(device, std::slice::from_ref(environment), candidates, radii_px, views, &say)
    };
    let (whole, rest) = (rows(environment, 0.0)?, rows(&bright.rest, 0.5)?);
    let strength = bright.strength();
    let row = |(whole, rest): (SizeRow, SizeRow)| {
        let squares = whole.rms_of_area.powi(2) - rest.rms_of_area.powi(2);
        let rms = (squares.max(0.0) / strength).sqrt();
        GlintRow { model: whole.model, radius_px: whole.radius_px, rms }
    };
    Ok(Some(whole.into_iter().zip(rest).map(row).collect()))
}

fn render(
    device: &Arc<Device>,
    environment: &Environment,
    scenes: &[Scene],
    choice: ModelChoice,
) -> Result<Vec<Picture>> {
    let with_model = |scene: &Scene| Scene { model: choice, ..scene.clone() };
    let first = with_model(&scenes[0]);
    let plan = plan(&first, environment, Output::Radiance)?;
    let mut renderer = Renderer::new(device, &first, environment, &plan)?;
    let mut frame = |scene: &Scene| {
        renderer.draw(&with_model(scene))?;
        renderer.read_radiance()
    };
    scenes.iter().map(&mut frame).collect()
}

/// Mean squared error and mean FLIP, weighted by the drop's coverage; and the squared error of the
/// pixels that the drop is in over the pixels that it covers.
fn errors(truth: &Traced, picture: &Picture, exposure: Exposure) -> [f64; 3] {
    let (a, b) = (display(exposure, &truth.picture), display(exposure, picture));
    let map = flip(&a, &b, PIXELS_PER_DEGREE);
    let (mut square, mut perceived, mut whole, mut total) = (0.0, 0.0, 0.0, 0.0);
    for (((a, b), flip), &coverage) in a.pixels.iter().zip(&b.pixels).zip(map).zip(&truth.coverage)
    {
        let weight = f64::from(coverage);
        let channels = a.to_array().into_iter().zip(b.to_array());
        let error: f64 =
            channels.map(|(a, b)| f64::from(srgb_of_linear(a) - srgb_of_linear(b)).powi(2)).sum();
        square += weight * error / 3.0;
        whole += if coverage > 0.0 { error / 3.0 } else { 0.0 };
        perceived += weight * flip;
        total += weight;
    }
    [square / total, perceived / total, whole / total]
}
