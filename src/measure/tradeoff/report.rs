//! What a study says: rows as JSON of the schema `raindrops-tradeoff/1`.

use serde::Serialize;

use super::models::BASES;
use crate::measure::Host;
use crate::measure::bench::{Build, DeviceHead, Measured, Variant};
use crate::measure::statistics::{median, quantile};
use crate::plan::Axes;

/// Name and version of the format.
pub const SCHEMA: &str = "raindrops-tradeoff/1";

/// Every model of every scene on one device.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// The command line, quoted as a shell needs it.
    pub command: Option<String>,
    /// The device.
    pub device: DeviceHead,
    /// The program.
    pub build: Build,
    /// The machine.
    pub host: Host,
    /// Samples a pixel of the truths.
    pub truth_samples: u32,
    /// Why there are not all rows.
    pub stopped: Option<String>,
    /// That of each scene's truth.
    pub noise: Vec<Noise>,
    /// One row a scene and model.
    pub rows: Vec<Row>,
}

/// What a picture without any error would be off by from the truth of a scene's first frame, which has a limited number of
/// samples. The error of a model that is hardly above it says only that the model's own is smaller.
#[derive(Clone, Debug, Serialize)]
pub struct Noise {
    /// The scene's name.
    pub scene: String,
    /// RMS error by the noise, in the unit of a row's `rms`.
    pub rms: f64,
    /// FLIP by the noise, in the unit of a row's `flip`.
    pub flip: f64,
    /// FLIP of boxes by the noise, in the unit of a row's `box_flip`.
    pub box_flip: f64,
}

/// One model of one scene.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct Row {
    pub scene: String,
    pub model: String,
    /// The axes that were drawn, after the preset's or `auto`'s choice.
    #[serde(flatten)]
    pub axes: Axes,
    pub drops: u32,
    pub visible: u64,
    pub width: u32,
    pub height: u32,
    pub median_ms: f64,
    pub p10_ms: f64,
    pub p90_ms: f64,
    /// Times as fast as the first model, which ran in turn with it.
    pub speed: f64,
    /// Times as fast as the second model: `paper-compact`, which draws the drops in view alone; with real rain `exact`.
    pub speed_over_compact: f64,
    #[serde(flatten)]
    pub errors: Errors,
    pub pareto: bool,
    /// The rate of real rain, mm/h; none for other rain.
    pub rate_mm_h: Option<f64>,
}

/// How far a model is from the truth; means over frames.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Errors {
    /// Root of the mean squared error of sRGB values 0 to 1, tone mapped with the truth's exposure.
    pub rms: f64,
    /// Relative mean squared error of linear radiance, over the pixels that drops touch.
    pub rel_mse: f64,
    /// Peak signal-to-noise ratio by `rms`.
    pub psnr_db: f64,
    /// Mean FLIP error.
    pub flip: f64,
    /// Its 99th percentile.
    pub flip_p99: f64,
    /// Largest error of linear radiance over the pixels that drops touch.
    pub max_error: f64,
    /// `rel_mse` after an 8 x 8 box filter.
    pub box_rel_mse: f64,
    /// `flip` after an 8 x 8 box filter.
    pub box_flip: f64,
    /// In a movement: RMS of what the model changes between frames and the truth does not.
    pub flicker: Option<f64>,
}

impl Row {
    /// A row with its times; `base_ms`: the medians of `paper` and of `paper-compact` in the same run.
    pub(super) fn timed(
        scene: &str,
        model: &str,
        variant: &Variant,
        measured: &Measured,
        base_ms: [f64; BASES],
    ) -> Self {
        let median_ms = median(&measured.samples_ms);
        Self {
            scene: scene.into(),
            model: model.into(),
            axes: Axes::of(&variant.scene, &variant.plan),
            drops: variant.scene.drop_count(),
            rate_mm_h: variant.scene.real_rain().map(|rain| rain.rate),
            visible: measured.first.counts.visible,
            width: variant.scene.picture_size().0,
            height: variant.scene.picture_size().1,
            median_ms,
            p10_ms: quantile(&measured.samples_ms, 0.1),
            p90_ms: quantile(&measured.samples_ms, 0.9),
            speed: base_ms[0] / median_ms,
            speed_over_compact: base_ms[1] / median_ms,
            errors: Errors::default(),
            pareto: false,
        }
    }
}

/// Marks the rows of one scene than which no other is both quicker and truer (by `rms`).
pub(super) fn mark_front(rows: &mut [Row]) {
    let places: Vec<(f64, f64)> = rows.iter().map(|row| (row.speed, row.errors.rms)).collect();
    for (row, (speed, rms)) in rows.iter_mut().zip(&places) {
        let beats = |(s, r): &(f64, f64)| s >= speed && r <= rms && (s > speed || r < rms);
        row.pareto = !places.iter().any(beats);
    }
}
