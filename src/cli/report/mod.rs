//! `raindrops report`: result files of any kind as one self-contained page.

mod over_time;
mod page;
mod plots;

use std::path::{Path, PathBuf};

use clap::Args;
use maud::Markup;
use serde::Deserialize;
use serde_json::Value;

use super::Answer;
use crate::Error;
use crate::files::write_whole;
use crate::measure::Host;
use crate::measure::bench::{self, Build, DeviceHead, of_schema, of_value, read_json};
use crate::measure::{drivers, verdict};

/// Write result files as one page of tables and plots
///
/// Results of bench, verdict, tradeoff and compare-devices. The page needs no network and no other file. Results of several machines stand side by side.
#[derive(Args)]
pub struct ReportArgs {
    /// Result files, as `--json` wrote them
    #[arg(value_name = "RESULT.json", required = true)]
    results: Vec<PathBuf>,
    /// Page to write; FILE.svg: only the passes of the first benchmark's last preset, with tone mapping, as stacked bars
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
}

/// What a file holds.
pub(super) enum Content {
    /// A benchmark of one device.
    Bench(bench::Report),
    /// Two results held against each other.
    Verdict(Box<verdict::Report>),
    /// One scene on several devices.
    Drivers(Box<drivers::Report>),
    /// Models by time and error.
    Tradeoff(Tradeoff),
}

/// A result, and the file that it is from.
pub(super) struct Entry {
    /// The file's name.
    file: String,
    /// Its folder, to which the paths in it are relative.
    folder: PathBuf,
    content: Content,
}

/// What the page needs of `raindrops-tradeoff/1`.
#[derive(Deserialize)]
pub(super) struct Tradeoff {
    device: DeviceHead,
    build: Build,
    host: Host,
    #[serde(default)]
    command: Option<String>,
    #[serde(default)]
    stopped: Option<String>,
    rows: Vec<TradeoffRow>,
}

/// One model of one scene.
#[derive(Deserialize)]
pub(super) struct TradeoffRow {
    scene: String,
    model: String,
    preset: String,
    median_ms: f64,
    rms: f64,
    flip: f64,
    pareto: bool,
}

/// Runs the command.
pub fn run(args: &ReportArgs) -> anyhow::Result<Answer> {
    super::check_folder(&args.output)?;
    let mut entries = Vec::new();
    for path in &args.results {
        entries.extend(load(path)?);
    }
    let written = match args.output.extension().is_some_and(|extension| extension == "svg") {
        true => page::without_variables(bars(&entries)?.into_string()),
        false => page::page(&entries).into_string(),
    };
    write_whole(&args.output, written.as_bytes())?;
    Ok(Answer::Yes)
}

/// The passes of the last preset of the first benchmark.
fn bars(entries: &[Entry]) -> anyhow::Result<Markup> {
    let first = entries.iter().find_map(|entry| match &entry.content {
        Content::Bench(report) => Some(&report.rows),
        _ => None,
    });
    // Presets take times of several magnitudes.
    let last = first.and_then(|rows| rows.last()).map(|row| row.preset.as_str());
    let is_shown = |row: &&bench::Row| row.tone_map && Some(row.preset.as_str()) == last;
    let rows: Vec<_> = first.into_iter().flatten().filter(is_shown).cloned().collect();
    match rows.iter().all(|row| row.passes.is_empty()) {
        true => anyhow::bail!("no benchmark with times of passes is among the results"),
        false => Ok(plots::passes(&rows, Some(page::ALONE))),
    }
}

/// The results in a file.
fn load(path: &Path) -> anyhow::Result<Vec<Entry>> {
    let values = match read_json(path)? {
        Value::Array(values) if !values.is_empty() => values,
        one => vec![one],
    };
    let mut entries = Vec::new();
    for value in values {
        let schema = value.get("schema").and_then(Value::as_str).unwrap_or_default().to_string();
        let content = match schema.as_str() {
            bench::SCHEMA => Content::Bench(of_value(path, value)?),
            verdict::SCHEMA => Content::Verdict(Box::new(of_schema(path, value, verdict::SCHEMA)?)),
            drivers::SCHEMA => Content::Drivers(Box::new(of_schema(path, value, drivers::SCHEMA)?)),
            "raindrops-tradeoff/1" => Content::Tradeoff(of_schema(path, value, &schema)?),
            other => {
                let problem = match other {
                    "" => "it is no result of raindrops: it names no schema".into(),
                    _ => format!("there is no page for the schema {other}"),
                };
                return Err(Error::read(path, problem).into());
            }
        };
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        entries.push(Entry { file, folder, content });
    }
    Ok(entries)
}
