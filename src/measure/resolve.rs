//! What preset `auto` chose, held against the reference before a run: the error that was accepted is measured
//! on the scene itself, in some of its tiles, and the next model is tried where it is not kept.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Result;
use crate::environment::Environment;
use crate::gpu::Device;
use crate::picture::tone_map::{Exposure, apply, exposure_of};
use crate::picture::{Picture, srgb_of_linear};
use crate::plan::{Choice, Costs, Output, Prospect, choose, keep, pick, plan_by, prospects};
use crate::rain::pcg4d;
use crate::reference::{Tracer, Truth};
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::scene::background::Background;
use crate::scene::model::{Preset, Primitive};

/// Tiles of 8 x 8 pixels that are asked whether they show drops, at most.
const ASKED: u32 = 4096;
/// Tiles with drops that are traced, at most, and tiles without.
const WITH_DROPS: usize = 512;
const WITHOUT: usize = 64;
/// Samples a pixel of each of the two halves of the reference.
const SAMPLES: u32 = 32;
/// Models that are tried, at most.
const TRIALS: usize = 7;
/// One that keeps the error is not the last to be tried where another may take less than its time over this,
const WORTH: f64 = 1.5;
/// and is expected to be within the error times this.
const DOUBT: f64 = 1.2;

/// Like [`choose`]; with an accepted error what is chosen has been rendered once on `device` and held against
/// the reference. Takes as long as some frames and as tracing 30,000 pixels.
///
/// # Errors
/// See [`Renderer::new`], [`Renderer::submit`] and [`Renderer::read_radiance`].
pub fn resolve(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    costs: &Costs,
) -> Result<Option<Choice>> {
    let model = &scene.model;
    let expected = choose(scene, environment, costs);
    let (Some(chosen), Some(accepted), Preset::Auto) = (&expected, model.error, model.preset)
    else {
        return Ok(expected);
    };
    if chosen.primitive != Primitive::Tile || !model.overrides().is_empty() {
        return Ok(expected);
    }
    // The drops' error is the same before the environment.
    let scene = &Scene { background: Background::default(), ..scene.clone() };
    let pilot = Pilot::new(scene, environment);
    let prospects = prospects(scene, environment, costs);
    let mut measured: Vec<Option<f64>> = vec![None; prospects.len()];
    // What is expected of the others is off as what was measured last.
    let mut scale = 1.0;
    for _ in 0..TRIALS {
        let known: Vec<Prospect> = prospects
            .iter()
            .zip(&measured)
            .map(|(prospect, known)| prospect.with_error(known.unwrap_or(scale * prospect.error)))
            .collect();
        let Some(best) = pick(accepted, &known) else { break };
        let next = match measured[best] {
            None => Some(best),
            Some(error) if error <= accepted => quicker(accepted, &known, &measured, best),
            Some(_) => None,
        };
        let Some(next) = next else { break };
        let choice = keep(accepted, None, &known[next..=next], "expected");
        let error = pilot.error(&picture(device, scene, environment, &choice)?);
        scale = error / prospects[next].error.max(1e-6);
        measured[next] = Some(error);
    }
    let known: Vec<Prospect> = prospects
        .iter()
        .zip(measured)
        .filter_map(|(prospect, error)| Some(prospect.with_error(error?)))
        .collect();
    let chosen = keep(accepted, model.budget_ms, &known, "measured");
    let reason = format!("{} (times of {})", chosen.reason, costs.of);
    Ok(Some(Choice { reason, ..chosen }))
}

/// The slowest model that was not tried, takes at most `1 / WORTH` of the time of `best` and may keep the error all the same.
/// The slowest is chosen because it is the truest.
fn quicker(
    accepted: f64,
    known: &[Prospect],
    measured: &[Option<f64>],
    best: usize,
) -> Option<usize> {
    let most_ms = known[best].ms / WORTH;
    let may_do = |n: &usize| {
        measured[*n].is_none() && known[*n].ms <= most_ms && known[*n].error <= DOUBT * accepted
    };
    (0..known.len()).filter(may_do).max_by(|a, b| known[*a].ms.total_cmp(&known[*b].ms))
}

fn picture(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    choice: &Choice,
) -> Result<Picture> {
    let plan = plan_by(scene, environment, Some(choice), Output::Radiance)?;
    let mut renderer = Renderer::new(device, scene, environment, &plan)?;
    renderer.draw(scene)?;
    renderer.read_radiance()
}

/// A part of the reference, traced twice so that its noise is not taken for an error.
struct Pilot<'a> {
    scene: &'a Scene,
    parts: Vec<Part>,
}

/// Tiles of one kind.
struct Part {
    /// Share of the picture that they stand for.
    share: f64,
    /// Share of them that was not traced.
    untraced: f64,
    traced: Vec<Traced>,
}

/// A tile's pixels with their numbers, twice.
type Traced = Vec<(u32, [DVec3; 2])>;

impl<'a> Pilot<'a> {
    fn new(scene: &'a Scene, environment: &Environment) -> Self {
        let truth = Truth { samples: SAMPLES, ..Truth::default() };
        let first = Tracer::new(scene, environment, truth);
        let halves = [first.with_seed(1), first];
        let count = halves[0].tiles();
        // One tile of each run of as many, so that they are spread over the picture.
        let asked = count.min(ASKED);
        let edge = |n: u32| (u64::from(n) * u64::from(count) / u64::from(asked)) as u32;
        let (with, without): (Vec<u32>, Vec<u32>) = (0..asked)
            .into_par_iter()
            .map(|n| edge(n) + pcg4d([n, 0, 0, 0])[0] % (edge(n + 1) - edge(n)))
            .partition(|tile| halves[0].shows_drops(*tile));
        let part = |tiles: Vec<u32>, most: usize| {
            let share = tiles.len() as f64 / f64::from(asked);
            let of_all = tiles.len().min(most) as f64 / (share * f64::from(count)).max(1.0);
            let traced = (0..tiles.len().min(most))
                .into_par_iter()
                .map(|n| {
                    let tile = tiles[n * tiles.len() / tiles.len().min(most)];
                    let [a, b] = halves.each_ref().map(|half| half.trace_tile(tile));
                    a.into_iter().zip(b).map(|((pixel, a), (_, b))| (pixel, [a, b])).collect()
                })
                .collect();
            Part { share, untraced: 1.0 - of_all.min(1.0), traced }
        };
        Self { scene, parts: vec![part(with, WITH_DROPS), part(without, WITHOUT)] }
    }

    /// RMS error of sRGB values of a picture of the scene, with two standard errors on top.
    fn error(&self, picture: &Picture) -> f64 {
        let exposure = exposure_of(&self.scene.tone_map, picture);
        let (mut mean, mut variance) = (0.0, 0.0);
        for Part { share, untraced, traced } in &self.parts {
            let count = traced.len().max(1) as f64;
            let squares: Vec<f64> =
                traced.iter().map(|tile| tile_square(tile, picture, exposure)).collect();
            let of_part = squares.iter().sum::<f64>() / count;
            let spread = squares.iter().map(|square| (square - of_part).powi(2)).sum::<f64>();
            mean += share * of_part;
            // A part that was traced whole leaves nothing to chance.
            variance += untraced * share * share * spread / (count * count);
        }
        (mean + 2.0 * variance.sqrt()).max(0.0).sqrt()
    }
}

/// Mean over a tile of the product of the picture's distances from both halves of the reference: their noise
/// has no part in it, as it is not the same in both.
fn tile_square(tile: &Traced, picture: &Picture, exposure: Exposure) -> f64 {
    let shown = |radiance: Vec3| apply(exposure, radiance).to_array().map(srgb_of_linear);
    let of_pixel = |(number, [a, b]): &(u32, [DVec3; 2])| {
        let c = shown(picture.pixels[*number as usize]);
        let (a, b) = (shown(a.as_vec3()), shown(b.as_vec3()));
        (0..3).map(|i| f64::from((c[i] - a[i]) * (c[i] - b[i]))).sum::<f64>() / 3.0
    };
    tile.iter().map(of_pixel).sum::<f64>() / tile.len() as f64
}
