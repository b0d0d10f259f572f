//! One scene with every model: truth, times, errors.

use std::path::Path;
use std::sync::Arc;

use super::models::{BASES, Model};
use super::report::{Errors, Noise, Row};
use super::scenes::StudyScene;
use crate::Result;
use crate::gpu::Device;
use crate::measure::bench::{self, Variant, measure};
use crate::measure::statistics::median;
use crate::measure::{costs, resolve};
use crate::picture::metrics::{Comparison, compare};
use crate::picture::plate::Plate;
use crate::picture::tone_map::{Exposure, display, exposure_of};
use crate::picture::{Picture, srgb_of_linear, write_png};
use crate::plan::{Choice, Output, plan_by};
use crate::reference::{Traced, Tracer, Truth};
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::scene::model::Preset;

/// Models that are timed in turn with each other, the bases among them.
const GROUP: usize = 6;

/// How long to measure, and how finely to trace.
#[derive(Clone, Copy, Debug)]
pub struct Effort<'a> {
    /// How long each model's time is measured.
    pub time: bench::Effort,
    /// Samples a pixel of the truth.
    pub truth_samples: u32,
    /// A folder for the first frame's truth and every model's picture of it, tone mapped; none: they are not kept.
    pub pictures: Option<&'a Path>,
}

impl Effort<'_> {
    /// Keeps a picture of a scene, as PNG.
    fn keep(&self, scene: &StudyScene, name: &str, picture: &Picture, by: Exposure) -> Result<()> {
        let Some(folder) = self.pictures else { return Ok(()) };
        let name = format!("{} {name}.png", scene.name).replace([' ', '/'], "-");
        let Picture { width, height, .. } = *picture;
        write_png(&folder.join(name), width, height, &display(by, picture).srgb())
    }
}

/// What is known of the truth of a frame.
struct Known {
    traced: Traced,
    exposure: Exposure,
}

/// What is found of a scene.
#[derive(Default)]
pub struct Study {
    /// A row a model.
    pub rows: Vec<Row>,
    /// That of its truth.
    pub noise: Option<Noise>,
}

/// Tries `models` on a scene; `say` is called with a model's name, or why it is left out, and the share
/// of the work that is done. The others' speeds are ratios to the first [`BASES`] models. If `effort.time.stop` says so,
/// it ends early with the models whose errors are known by then.
///
/// # Errors
/// See [`crate::plan::plan`], [`Renderer::new`], [`Renderer::submit`] and
/// [`Renderer::read_radiance`], for the first model that fails.
pub fn study(
    device: &Arc<Device>,
    scene: &StudyScene,
    models: &[Model],
    effort: Effort<'_>,
    say: &(dyn Fn(&str, f64) + Sync),
) -> Result<Study> {
    // A third of the time goes into the truth, a third into times, a third into pictures: about.
    let share_truth = |share: f64| say("truth", share / 3.0);
    let count = scene.frames.len() as f64;
    let (mut truths, mut noise) = (Vec::new(), None);
    // The first frame is traced twice.
    let part = |done: usize, share: f64| share_truth((done as f64 + share) / (count + 1.0));
    for (number, frame) in scene.frames.iter().enumerate() {
        let tracer = tracer(scene, frame, effort.truth_samples, effort.time.stop)?;
        let done = if number == 0 { 0 } else { number + 1 };
        let traced = tracer.trace(&|share| part(done, share));
        let exposure = exposure_of(&frame.tone_map, &traced.picture);
        let known = Known { traced, exposure };
        if number == 0 && !(effort.time.stop)() {
            effort.keep(scene, "truth", &known.traced.picture, exposure)?;
            let seed = Truth::default().seed + 1;
            let again = tracer.with_seed(seed).trace(&|share| part(1, share));
            noise = Some(of_noise(&scene.name, &known, &again.picture));
        }
        if (effort.time.stop)() {
            return Ok(Study::default());
        }
        truths.push(known);
    }

    let (mut variants, mut choices, mut costs) = (Vec::new(), Vec::new(), None);
    for model in models {
        let mut first = scene.frames[0].clone();
        first.model = model.choice;
        let choice = match first.model.preset {
            Preset::Auto => {
                let known = match costs.take() {
                    Some(known) => known,
                    None => costs::measure(device)?,
                };
                resolve(device, &first, &scene.environment, costs.insert(known))?
            }
            _ => None,
        };
        let plan = plan_by(&first, &scene.environment, choice.as_ref(), Output::Display)?;
        choices.push(choice);
        variants.push(Variant { scene: first, plan });
    }
    let Some((bases, others)) = variants.split_at_checked(BASES) else {
        return Ok(Study::default());
    };
    let mut rows = Vec::new();
    let groups = others.len().div_ceil(GROUP - BASES).max(1);
    for number in 0..groups {
        let from = number * (GROUP - BASES);
        let group = &others[from..(from + GROUP - BASES).min(others.len())];
        let together: Vec<Variant> = bases.iter().chain(group).cloned().collect();
        let done = |share: f64| {
            say("times", (1.0 + (number as f64 + share) / groups as f64) / 3.0);
        };
        let measured = measure(device, &scene.environment, &together, effort.time, &done)?;
        if (effort.time.stop)() {
            return Ok(Study::default());
        }
        let base_ms = std::array::from_fn(|base| median(&measured[base].samples_ms));
        // The bases are rows of the first group alone.
        for (index, (variant, measured)) in together.iter().zip(&measured).enumerate() {
            if index >= BASES || number == 0 {
                let name = &models[if index < BASES { index } else { from + index }].name;
                rows.push(Row::timed(&scene.name, name, variant, measured, base_ms));
            }
        }
    }
    let mut known = 0;
    for (number, (row, variant)) in rows.iter_mut().zip(&variants).enumerate() {
        if (effort.time.stop)() {
            break;
        }
        let choice = choices[number].as_ref();
        say(&row.model, (2.0 + number as f64 / variants.len() as f64) / 3.0);
        let first = |picture: &Picture| effort.keep(scene, &row.model, picture, truths[0].exposure);
        row.errors = errors(device, scene, variant, choice, &truths, &first)?;
        known += 1;
    }
    rows.truncate(known);
    super::report::mark_front(&mut rows);
    Ok(Study { rows, noise })
}

/// A frame of a scene, made ready for its truth.
pub(super) fn tracer<'a>(
    scene: &'a StudyScene,
    frame: &Scene,
    samples: u32,
    stop: fn() -> bool,
) -> Result<Tracer<'a>> {
    let truth = Truth { samples, ..Truth::default() };
    Ok(Tracer::new_until(frame, &scene.environment, truth, stop).before(Plate::of(frame)?))
}

/// What a picture without any error is off by from a truth, given another truth of other samples. Both have the same
/// variance, so their difference has twice that of one: over the root of two it is like the difference from the mean.
fn of_noise(scene: &str, known: &Known, again: &Picture) -> Noise {
    let truth = &known.traced.picture;
    let pairs = truth.pixels.iter().zip(&again.pixels);
    let pixels = pairs.map(|(a, b)| a + (b - a) * std::f32::consts::FRAC_1_SQRT_2).collect();
    let found = compare(truth, &Picture { pixels, ..*truth }, None, known.exposure);
    let (rms, flip, box_flip) = (found.pixels.rms(), found.pixels.flip, found.boxes.flip);
    Noise { scene: scene.into(), rms, flip, box_flip }
}

/// The errors of a model over all frames: means, and the largest; `first` gets its picture of the first.
fn errors(
    device: &Arc<Device>,
    scene: &StudyScene,
    variant: &Variant,
    choice: Option<&Choice>,
    truths: &[Known],
    first: &dyn Fn(&Picture) -> Result<()>,
) -> Result<Errors> {
    let plan = plan_by(&variant.scene, &scene.environment, choice, Output::Radiance)?;
    let mut renderer = Renderer::new(device, &variant.scene, &scene.environment, &plan)?;
    let mut comparisons = Vec::new();
    let mut pictures = Vec::new();
    for (frame, known) in scene.frames.iter().zip(truths) {
        let frame = Scene { model: variant.scene.model, ..frame.clone() };
        renderer.draw(&frame)?;
        let picture = renderer.read_radiance()?;
        let Traced { picture: truth, opacity, .. } = &known.traced;
        comparisons.push(compare(truth, &picture, Some(opacity), known.exposure));
        pictures.push(picture);
    }
    pictures.first().map_or(Ok(()), first)?;
    let mean = |figure: &dyn Fn(&Comparison) -> f64| {
        comparisons.iter().map(figure).sum::<f64>() / comparisons.len() as f64
    };
    let rms = mean(&|c| 10f64.powf(-c.pixels.psnr_db / 10.0)).sqrt();
    Ok(Errors {
        rms,
        rel_mse: mean(&|c| c.pixels.rel_mse),
        psnr_db: -20.0 * rms.log10(),
        flip: mean(&|c| c.pixels.flip),
        flip_p99: mean(&|c| c.pixels.flip_p99),
        max_error: comparisons.iter().map(|c| c.pixels.max_error).fold(0.0, f64::max),
        box_rel_mse: mean(&|c| c.boxes.rel_mse),
        box_flip: mean(&|c| c.boxes.flip),
        flicker: (pictures.len() > 1).then(|| flicker(truths, &pictures)),
    })
}

/// RMS over pixels, channels and pairs of frames of what the model changes from one frame to the
/// next and the truth does not, on sRGB values 0 to 1.
fn flicker(truths: &[Known], pictures: &[Picture]) -> f64 {
    let shown = |picture: &Picture, exposure| -> Vec<f32> {
        let pixels = display(exposure, picture).pixels;
        pixels.iter().flat_map(|pixel| pixel.to_array().map(srgb_of_linear)).collect()
    };
    // One exposure for all frames: it is no flicker of the drops.
    let exposure = truths[0].exposure;
    let errors: Vec<Vec<f32>> = truths
        .iter()
        .zip(pictures)
        .map(|(known, picture)| {
            let (truth, found) = (shown(&known.traced.picture, exposure), shown(picture, exposure));
            found.iter().zip(&truth).map(|(a, b)| a - b).collect()
        })
        .collect();
    let steps = errors.windows(2).flat_map(|pair| {
        pair[0].iter().zip(&pair[1]).map(|(before, after)| f64::from(after - before).powi(2))
    });
    let (sum, count) = steps.fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
    (sum / count).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// Two truths of a picture that is known: its error against the first is what their difference foretells.
    #[test]
    fn noise_is_the_error_of_a_picture_without_any() {
        let (width, height) = (96, 96);
        let mut bits = 1u32;
        let mut uniform = || {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (bits >> 8) as f32 / (1 << 24) as f32
        };
        // Each value is the mean of four samples, so that FLIP is far from proportional to them.
        let mut truth = || -> Vec<Vec3> {
            let mut sample = || (0..4).map(|_| 0.25 * uniform()).sum::<f32>();
            (0..width * height).map(|_| Vec3::new(sample(), sample(), sample())).collect()
        };
        let picture = |pixels| Picture { width, height, pixels };
        let (first, again) = (picture(truth()), picture(truth()));
        let mean = picture(vec![Vec3::splat(0.5); first.pixels.len()]);
        let exposure = Exposure::Clipped(1.0);
        let error = compare(&first, &mean, None, exposure);
        let shares = vec![1.0; first.pixels.len()];
        let (coverage, opacity, on_pane) = (shares.clone(), shares, Vec::new());
        let traced = Traced { picture: first, coverage, opacity, on_pane };
        let noise = of_noise("", &Known { traced, exposure }, &again);
        let off = |found: f64, wanted: f64| (found / wanted - 1.0).abs();
        assert!(off(noise.rms, error.pixels.rms()) < 0.03, "{noise:?} {}", error.pixels.rms());
        // FLIP is not linear, and this noise is large.
        assert!(off(noise.flip, error.pixels.flip) < 0.1, "{noise:?} {}", error.pixels.flip);
    }
}
