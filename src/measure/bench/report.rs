//! What a benchmark says: the JSON of the schema `raindrops-bench/1`, and a table.

#[cfg(feature = "cli")]
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde::Serialize;

use super::measure::{Measured, Variant};
use crate::gpu::DeviceReport;
use crate::measure::Host;
use crate::measure::statistics::{median, quantile};

/// Name and version of the format.
pub const SCHEMA: &str = "raindrops-bench/1";

/// The paper's Table II, GeForce GTX 280: drops, frames a second with and without tone mapping.
#[cfg(feature = "cli")]
const GTX_280: [(u32, u32, u32); 6] = [
    (125_000, 595, 794),
    (250_000, 430, 540),
    (500_000, 250, 295),
    (1_000_000, 140, 157),
    (2_000_000, 74, 83),
    (4_000_000, 43, 46),
];

/// A benchmark of one device.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// The device.
    pub device: DeviceHead,
    /// The program.
    pub build: Build,
    /// The machine.
    pub host: Host,
    /// The environment's name.
    pub environment: String,
    /// Bytes of compiled pipelines that an earlier run had left; 0: none.
    pub pipeline_cache_bytes: usize,
    /// One row a variant.
    pub rows: Vec<Row>,
}

/// The device that was measured.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the words of Vulkan's own properties")]
pub struct DeviceHead {
    pub name: String,
    pub driver: String,
    pub driver_info: String,
    pub api_version: String,
    #[serde(rename = "type")]
    pub kind: &'static str,
}

/// The program that measured.
#[derive(Clone, Debug, Serialize)]
pub struct Build {
    /// Version of the package.
    pub version: &'static str,
    /// Commit, `unknown` outside of a repository.
    pub commit: &'static str,
    /// `release` or `debug`.
    pub profile: &'static str,
}

/// Milliseconds of each part, by name and in order; written as a JSON object.
#[derive(Clone, Debug, Default)]
pub struct Parts(pub Vec<(&'static str, f64)>);

impl Serialize for Parts {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

/// One variant: what was drawn, by which models, how fast.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/architecture.md")]
pub struct Row {
    pub preset: &'static str,
    pub optics: &'static str,
    pub primitive: &'static str,
    pub order: &'static str,
    pub simulation: &'static str,
    pub drops: u32,
    pub visible: u64,
    pub width: u32,
    pub height: u32,
    pub tone_map: bool,
    pub setup_ms: f64,
    pub setup: Parts,
    pub first_frame_ms: f64,
    pub samples_ms: Vec<f64>,
    pub median_ms: f64,
    pub p10_ms: f64,
    pub p90_ms: f64,
    pub fps: f64,
    pub passes: Parts,
}

impl DeviceHead {
    /// The head of a device.
    pub fn of(report: &DeviceReport) -> Self {
        Self {
            name: report.name.clone(),
            driver: report.driver.clone(),
            driver_info: report.driver_info.clone(),
            api_version: report.api_version.clone(),
            kind: report.kind,
        }
    }
}

impl Build {
    /// This program.
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: env!("RAINDROPS_COMMIT"),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" },
        }
    }
}

impl Row {
    /// The row of what was measured.
    pub fn new(variant: &Variant, measured: &Measured) -> Self {
        let (scene, plan) = (&variant.scene, &variant.plan);
        let median_ms = median(&measured.samples_ms);
        let round = |ms: &f64| (ms * 1e4).round() / 1e4;
        Self {
            preset: plan.preset.name(),
            optics: plan.optics.name(),
            primitive: plan.primitive.name(),
            order: plan.order.name(),
            simulation: plan.simulation.name(),
            drops: scene.drop_count(),
            visible: measured.first.counts.visible,
            width: scene.image.width,
            height: scene.image.height,
            tone_map: plan.tone_map.is_some(),
            setup_ms: round(&measured.setup_ms),
            setup: Parts(measured.setup_parts.iter().map(|(n, ms)| (*n, round(ms))).collect()),
            first_frame_ms: round(&measured.first_frame_ms),
            samples_ms: measured.samples_ms.iter().map(round).collect(),
            median_ms: round(&median_ms),
            p10_ms: round(&quantile(&measured.samples_ms, 0.1)),
            p90_ms: round(&quantile(&measured.samples_ms, 0.9)),
            fps: round(&(1e3 / median_ms)),
            passes: Parts(
                measured
                    .passes_ms
                    .iter()
                    .filter(|(_, samples)| !samples.is_empty())
                    .map(|(name, samples)| (*name, round(&median(samples))))
                    .collect(),
            ),
        }
    }

    /// Whether the GPU's times of the passes add up to the frame: some drivers book the work of one
    /// pass on another, or none at all.
    pub fn passes_add_up(&self) -> bool {
        let sum: f64 = self.passes.0.iter().map(|(_, ms)| ms).sum();
        (0.5..1.25).contains(&(sum / self.median_ms))
    }
}

/// The rows as the paper's Table II has them: a line a count and preset, frame rates with (-T) and
/// without tone mapping, then milliseconds. If the scene is the paper's, its own figures stand beside them.
#[cfg(feature = "cli")]
pub fn table(rows: &[Row], is_papers: bool) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_content_arrangement(ContentArrangement::Disabled);
    let passes: Vec<&str> = rows
        .iter()
        .map(|row| &row.passes.0)
        .max_by_key(|p| p.len())
        .map_or(Vec::new(), |passes| passes.iter().map(|(name, _)| *name).collect());
    let mut header: Vec<String> = ["drops", "in view", "preset", "FPS-T", "FPS", "ms-T", "p10-p90"]
        .map(String::from)
        .to_vec();
    header.push("ms".into());
    header.extend(passes.iter().map(|name| (*name).to_string()));
    header.extend(is_papers.then(|| "GTX 280, 2011".into()));
    table.set_header(header);
    for row in rows.iter().filter(|row| row.tone_map) {
        let without = rows.iter().find(|other| {
            !other.tone_map && other.drops == row.drops && other.preset == row.preset
        });
        let mut line = vec![
            thousands(row.drops.into()),
            thousands(row.visible),
            row.preset.into(),
            rate(row.fps),
            without.map_or("-".into(), |without| rate(without.fps)),
            format!("{:.2}", row.median_ms),
            format!("{:.2}-{:.2}", row.p10_ms, row.p90_ms),
            without.map_or("-".into(), |without| format!("{:.2}", without.median_ms)),
        ];
        for name in &passes {
            let ms = row.passes.0.iter().find(|(pass, _)| pass == name);
            line.push(ms.map_or("-".into(), |(_, ms)| format!("{ms:.2}")));
        }
        let published = GTX_280.iter().find(|(drops, ..)| is_papers && *drops == row.drops);
        line.extend(published.map(|(_, mapped, plain)| format!("{mapped} / {plain}")));
        table.add_row(line);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        if index != 2 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

#[cfg(feature = "cli")]
fn rate(fps: f64) -> String {
    if fps < 100.0 { format!("{fps:.1}") } else { format!("{fps:.0}") }
}

/// 4000000 to `4 000 000`.
#[cfg(any(feature = "cli", feature = "view"))]
pub(crate) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}
