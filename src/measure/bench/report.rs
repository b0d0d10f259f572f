//! The result file of a benchmark, schema `raindrops-bench/1`: what is written and, in `read.rs`, read.
//!
//! Keys are only ever added: a file of an older version lacks some, and is read all the same.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::measure::{Measured, Variant};
use super::over_time::OverTime;
use super::scene_head::SceneHead;
use crate::environment::Environment;
use crate::gpu::DeviceReport;
use crate::measure::Host;
use crate::measure::statistics::{median, quantile};
use crate::measure::system::load;
use crate::measure::verdict::looks::Look;
use crate::plan::Axes;
use crate::thousands::counted;

/// Name and version of the format.
pub const SCHEMA: &str = "raindrops-bench/1";

/// A benchmark of one device.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: String,
    /// The device.
    pub device: DeviceHead,
    /// The program.
    pub build: Build,
    /// The machine.
    pub host: Host,
    /// When the measurement began, UTC, as RFC 3339 has it.
    #[serde(default)]
    pub start: Option<String>,
    /// The command line, quoted as a shell needs it.
    #[serde(default)]
    pub command: Option<String>,
    /// What makes the figures doubtful, a line each.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// The environment's name.
    #[serde(default)]
    pub environment: String,
    /// Bytes of compiled pipelines that an earlier run had left; 0: none.
    #[serde(default)]
    pub pipeline_cache_bytes: usize,
    /// One row a variant.
    pub rows: Vec<Row>,
}

/// The device that was measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the words of Vulkan's own properties")]
pub struct DeviceHead {
    pub name: String,
    pub driver: String,
    pub driver_info: String,
    pub api_version: String,
    #[serde(rename = "type")]
    pub kind: String,
    /// PCI numbers, or those that Khronos gave to a driver without a PCI device.
    #[serde(default)]
    pub vendor_id: Option<u32>,
    #[serde(default)]
    pub device_id: Option<u32>,
    /// 32 hexadecimal digits.
    #[serde(default)]
    pub driver_uuid: Option<String>,
    #[serde(default)]
    pub pipeline_cache_uuid: Option<String>,
}

/// The program that measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Build {
    /// Version of the package.
    pub version: String,
    /// Commit, `unknown` outside of a repository.
    pub commit: String,
    /// `release` or `debug`.
    #[serde(default)]
    pub profile: String,
}

/// Milliseconds of each part, by name and in order.
pub type Parts = IndexMap<String, f64>;

/// What one fresh process measured of a row: the unit of every comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// When the process began to measure, UTC, as RFC 3339 has it.
    #[serde(default)]
    pub start: Option<String>,
    /// Load average of the last minute when the row was done, the program's own work included.
    #[serde(default)]
    pub load: Option<f64>,
    /// Median of its frames.
    pub median_ms: f64,
    /// Medians of their passes.
    #[serde(default)]
    pub passes: Parts,
}

/// One variant: what was drawn, by which models, how fast.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct Row {
    pub preset: String,
    pub optics: String,
    pub primitive: String,
    pub order: String,
    #[serde(default)]
    pub simulation: String,
    /// Every axis of the models, as drawn.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub axes: Map<String, Value>,
    /// Number of drops in boxes and placed ones; drops of real rain have no number.
    pub drops: u32,
    /// The rate of real rain, mm/h; none for other rain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_mm_h: Option<f64>,
    /// Least radius of a drop of real rain that is drawn by itself, pixels; none for other rain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoff_px: Option<f64>,
    pub visible: u64,
    pub width: u32,
    pub height: u32,
    pub tone_map: bool,
    #[serde(default)]
    pub scene: Option<SceneHead>,
    /// Deterministic, `tiles_done_again` apart: a change of them is no noise.
    #[serde(default)]
    pub counters: IndexMap<String, u64>,
    #[serde(default)]
    pub setup_ms: f64,
    #[serde(default)]
    pub setup: Parts,
    #[serde(default)]
    pub first_frame_ms: f64,
    pub samples_ms: Vec<f64>,
    pub median_ms: f64,
    /// 95 % interval of the median over the rounds; absent with fewer than six.
    #[serde(default)]
    pub median_low_ms: Option<f64>,
    #[serde(default)]
    pub median_high_ms: Option<f64>,
    pub p10_ms: f64,
    pub p90_ms: f64,
    pub fps: f64,
    #[serde(default)]
    pub passes: Parts,
    #[serde(default)]
    pub rounds: Vec<Round>,
    /// How the frame time changed; only a long measurement has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_time: Option<OverTime>,
}

impl DeviceHead {
    /// The head of a device.
    pub fn of(report: &DeviceReport) -> Self {
        let hex = |uuid: [u8; 16]| format!("{:032x}", u128::from_be_bytes(uuid));
        Self {
            name: report.name.clone(),
            driver: report.driver.clone(),
            driver_info: report.driver_info.clone(),
            api_version: report.api_version.clone(),
            kind: report.kind.into(),
            vendor_id: Some(report.pipeline_key.vendor),
            device_id: Some(report.pipeline_key.device),
            driver_uuid: Some(hex(report.driver_uuid)),
            pipeline_cache_uuid: Some(hex(report.pipeline_key.uuid)),
        }
    }

    /// Device, driver and its version.
    pub fn summary(&self) -> String {
        format!("{}, {} {}", self.name, self.driver, self.driver_info).trim_end().into()
    }
}

impl Build {
    /// This program.
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: env!("RAINDROPS_COMMIT").into(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.into(),
        }
    }
}

impl Report {
    /// Takes down what other programs took of the processors while it was measured, the most of all rounds.
    pub fn ended(&mut self, others: Option<f64>) {
        let before = self.host.others_doubt();
        self.warnings.retain(|warning| before.as_ref() != Some(warning));
        self.host.others = self.host.others.into_iter().chain(others).reduce(f64::max);
        self.warnings.extend(self.host.others_doubt());
    }

    /// Adds the rounds of another process that measured the same rows. Its warning about the load is left out: by then
    /// it is that of the rounds before.
    pub fn extend(&mut self, other: Self) {
        self.ended(other.host.others);
        for row in other.rows {
            let is_same = |mine: &&mut Row| mine.name() == row.name();
            if let Some(mine) = self.rows.iter_mut().find(is_same) {
                mine.extend(row);
            }
        }
    }
}

/// Four decimals: a tenth of a microsecond.
fn rounded(ms: f64) -> f64 {
    (ms * 1e4).round() / 1e4
}

impl Row {
    /// The row of what was measured, of a process that began to measure at `start`.
    pub fn new(
        variant: &Variant,
        environment: &Environment,
        measured: &Measured,
        start: Option<String>,
    ) -> Self {
        let (scene, plan) = (&variant.scene, &variant.plan);
        let medians = measured.passes_ms.iter().filter(|(_, samples)| !samples.is_empty());
        let passes: Parts =
            medians.map(|(name, ms)| (name.to_string(), rounded(median(ms)))).collect();
        let setup = measured.setup_parts.iter();
        let mut row = Self {
            preset: plan.preset.name().into(),
            optics: plan.optics.name().into(),
            primitive: plan.primitive.name().into(),
            order: plan.order.name().into(),
            simulation: plan.simulation.name().into(),
            axes: Axes::of(scene, plan).values(),
            drops: scene.drop_count(),
            rate_mm_h: scene.real_rain().map(|rain| rain.rate),
            cutoff_px: plan.cutoff.as_ref().map(|cutoff| cutoff.px),
            visible: measured.first.counts.visible,
            width: scene.picture_size().0,
            height: scene.picture_size().1,
            tone_map: plan.tone_map.is_some(),
            scene: Some(SceneHead::of(scene, environment)),
            counters: counters(measured),
            setup_ms: rounded(measured.setup_ms),
            setup: setup.map(|(name, ms)| (name.to_string(), rounded(*ms))).collect(),
            first_frame_ms: rounded(measured.first_frame_ms),
            samples_ms: measured.samples_ms.iter().map(|ms| rounded(*ms)).collect(),
            median_ms: 0.0,
            median_low_ms: None,
            median_high_ms: None,
            p10_ms: 0.0,
            p90_ms: 0.0,
            fps: 0.0,
            passes: Parts::new(),
            rounds: vec![Round {
                start,
                load: load(),
                median_ms: rounded(median(&measured.samples_ms)),
                passes,
            }],
            over_time: None,
        };
        row.sum_up();
        row
    }

    /// Adds the rounds and samples of the same row, measured by another process.
    pub fn extend(&mut self, other: Self) {
        self.samples_ms.extend(other.samples_ms);
        self.rounds.extend(other.rounds);
        self.sum_up();
    }

    /// Median, percentiles and passes from samples and rounds.
    fn sum_up(&mut self) {
        let of_rounds: Vec<f64> = self.rounds.iter().map(|round| round.median_ms).collect();
        self.median_ms = rounded(median(&of_rounds));
        let interval = interval_of_median(&of_rounds);
        self.median_low_ms = interval.map(|(low, _)| low);
        self.median_high_ms = interval.map(|(_, high)| high);
        self.p10_ms = rounded(quantile(&self.samples_ms, 0.1));
        self.p90_ms = rounded(quantile(&self.samples_ms, 0.9));
        self.fps = rounded(1e3 / self.median_ms);
        let names = self.rounds.iter().max_by_key(|round| round.passes.len());
        let names: Vec<String> =
            names.map(|round| round.passes.keys().cloned().collect()).unwrap_or_default();
        self.passes = names
            .into_iter()
            .map(|name| {
                let of_pass = self.rounds.iter().filter_map(|round| round.passes.get(&name));
                let of_pass: Vec<f64> = of_pass.copied().collect();
                (name, rounded(median(&of_pass)))
            })
            .collect();
    }

    /// Whether the GPU's times of the passes add up to the frame: some drivers book the work of one
    /// pass on another, or none at all.
    pub fn passes_add_up(&self) -> bool {
        let sum: f64 = self.passes.values().sum();
        (0.5..1.25).contains(&(sum / self.median_ms))
    }

    /// What was asked for, in a few words: the same in every file that may be compared with this one.
    pub fn name(&self) -> String {
        let tone_map = if self.tone_map { "" } else { ", no tone map" };
        let amount = match self.rate_mm_h {
            Some(rate) => format!("rain of {rate} mm/h"),
            None => counted(self.drops.into(), "drop"),
        };
        format!("{amount}, {}, {} x {}{tone_map}", self.preset, self.width, self.height)
    }
}

/// The 95 % interval of the median of independent values, from order statistics; none of fewer than six.
fn interval_of_median(values: &[f64]) -> Option<(f64, f64)> {
    let rank = Look::single(values.len()).rank;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (rank > 0).then(|| (sorted[rank - 1], sorted[sorted.len() - rank]))
}

/// What the first frame counted, by name.
fn counters(measured: &Measured) -> IndexMap<String, u64> {
    let counts = &measured.first.counts;
    let mut all = vec![
        ("drops_in_view", counts.visible),
        ("drops_not_drawn", counts.overflow + counts.camera_inside + counts.beside_camera),
    ];
    match &measured.first.tiles {
        None => all.push(("large_drops", counts.large)),
        Some(tiles) => all.extend([
            ("clusters_in_view", tiles.clusters),
            ("large_drops", tiles.large),
            // A splat is one entry, a larger drop one for each of its fragments.
            ("list_entries", counts.visible.saturating_sub(tiles.large) + tiles.fragments),
            ("fragments", tiles.fragments),
            ("ray_fragments", tiles.ray_fragments),
            ("ray_fragments_a_dispatch", tiles.ray_fragments_a_dispatch),
            ("long_tiles", tiles.long_tiles),
            ("tiles_done_again", tiles.tiles_again),
        ]),
    }
    all.push(("bytes", measured.bytes));
    all.into_iter().map(|(name, count)| (name.to_string(), count)).collect()
}
