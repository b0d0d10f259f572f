//! How long a study takes, known before it begins.

use std::time::Instant;

use rayon::prelude::*;

use super::models::Model;
use super::scenes::StudyScene;
use super::study::{Effort, tracer};
use crate::Result;
use crate::plan::{Costs, Output, expected_ms, plan};
use crate::scene::Scene;

/// Every so many of a picture's tiles are traced.
const EVERY: usize = 11;
/// Samples a pixel that tell what a sample takes.
const FEW: u32 = 9;
/// Pictures of all models, and what is made before them, over the time of timing them: measured.
const WITH_PICTURES: f64 = 1.5;

/// Seconds that `models` of a scene take: their times by what the device takes for the parts of a frame, the truth by
/// a part of the picture, which is traced for it.
///
/// # Errors
/// See [`crate::picture::plate::Plate::of`].
pub fn expected_s(
    scene: &StudyScene,
    models: &[Model],
    effort: &Effort<'_>,
    costs: &Costs,
) -> Result<f64> {
    let of_model = |model: &Model| {
        let first = Scene { model: model.choice, ..scene.frames[0].clone() };
        let plan = plan(&first, &scene.environment, Output::Display).ok()?;
        let ms = expected_ms(&first, &scene.environment, costs, &plan);
        Some(effort.time.expected_s(ms))
    };
    let times: f64 = models.iter().filter_map(of_model).sum();
    Ok(truth_s(scene, effort.truth_samples)? + WITH_PICTURES * times)
}

/// Seconds of the truths of all frames, and of the second one of the first.
fn truth_s(scene: &StudyScene, samples: u32) -> Result<f64> {
    let of = |samples: u32| -> Result<f64> {
        let start = Instant::now();
        let tracer = tracer(scene, &scene.frames[0], samples, || false)?;
        let set_up = start.elapsed();
        let tiles: Vec<u32> = (0..tracer.tiles()).step_by(EVERY).collect();
        tiles.par_iter().for_each(|tile| drop(tracer.trace_tile(*tile)));
        Ok((set_up + EVERY as u32 * (start.elapsed() - set_up)).as_secs_f64())
    };
    // What it takes whatever the samples, and what each of them adds.
    let (one, few) = (of(1)?, of(FEW)?);
    let each = (few - one).max(0.0) / f64::from(FEW - 1);
    let frames = 1.0 + scene.frames.len() as f64;
    Ok(frames * (one + each * (f64::from(samples) - 1.0)))
}
