//! Which rows of two results belong together, and what may not differ between them.

use std::path::PathBuf;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Interval, MissingRow, PassRow, VerdictRow, judge, looks, paired, unpaired};
use crate::measure::Host;
use crate::measure::bench::{Build, DeviceHead, Report, Row};
use crate::measure::statistics::median;
use crate::{Error, Result};

/// One side of a comparison.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Side {
    /// A file's name, an environment, a device.
    pub label: String,
    /// What it ran on.
    pub device: DeviceHead,
    /// By which program.
    pub build: Build,
    /// On which machine.
    pub host: Host,
    /// When its first run began.
    pub start: Option<String>,
    /// What makes its times doubtful.
    pub warnings: Vec<String>,
}

impl Side {
    /// The side that a run stands for.
    pub fn of(label: &str, run: &Report) -> Self {
        Self {
            label: label.into(),
            device: run.device.clone(),
            build: run.build.clone(),
            host: run.host.clone(),
            start: run.start.clone(),
            warnings: run.warnings.clone(),
        }
    }
}

/// The one counter that is not the same on every run: in which order a driver's threads push a tile's drops
/// decides whether its list comes in order.
const NOT_EXACT: &str = "tiles_done_again";

/// How rounds of A and of B are held against each other.
#[derive(Clone, Copy)]
enum How {
    /// The n-th round of A ran beside the n-th of B: by the look that is due.
    Paired(looks::Look),
    /// Each run at its own time.
    Unpaired,
}

/// Rows of A and B that were measured in turn, as they stand at a look.
///
/// # Errors
/// [`Error::Scene`] if the two sides drew another scene.
pub fn in_turn(
    a: &Report,
    b: &Report,
    look: looks::Look,
    threshold: f64,
) -> Result<Vec<VerdictRow>> {
    same_rows(("A", a), ("B", b))?;
    let pairs = matched(a, b).into_iter();
    Ok(pairs.map(|(a, b)| row(&[a], &[b], How::Paired(look), threshold)).collect())
}

/// Rows of kept results: of each side one run a file, each at its own time.
///
/// # Errors
/// [`Error::Scene`], naming what differs: another scene, size or environment; among a side's own runs
/// another device too, and between the sides if `one_device`.
pub fn kept<'a>(
    a: &'a [(PathBuf, Report)],
    b: &'a [(PathBuf, Report)],
    one_device: bool,
    threshold: f64,
) -> Result<Vec<VerdictRow>> {
    let name = |path: &PathBuf| path.display().to_string();
    let (Some((first_path, first)), Some((_, new))) = (a.first(), b.first()) else {
        return Ok(Vec::new());
    };
    for (number, (path, run)) in a.iter().chain(b).enumerate().skip(1) {
        let (one, other) = ((name(first_path), first), (name(path), run));
        let (one, other) = ((one.0.as_str(), one.1), (other.0.as_str(), other.1));
        if number < a.len() || one_device {
            same_device(one, other)?;
        }
        same_rows(one, other)?;
    }
    for (path, run) in &b[1..] {
        same_device((&name(&b[0].0), new), (&name(path), run))?;
    }
    let mut rows = Vec::new();
    for like in all_rows(a.iter().map(|(_, run)| run)) {
        let of_run = |(path, run): &'a (PathBuf, Report)| {
            Some((name(path), run.rows.iter().find(|row| is_same(row, like))?))
        };
        let [a, b] = [a, b].map(|runs| runs.iter().filter_map(of_run).collect::<Vec<_>>());
        let mut pairs = a.iter().chain(&b);
        if let Some((first, one)) = pairs.next() {
            pairs.try_for_each(|(path, other)| same_row((first, one), (path, other)))?;
        }
        let [a, b] = [a, b].map(|found| found.into_iter().map(|(_, row)| row).collect::<Vec<_>>());
        if !b.is_empty() {
            rows.push(row(&a, &b, How::Unpaired, threshold));
        }
    }
    Ok(rows)
}

/// Whether two rows were asked for alike. What preset `auto` made of it may differ.
fn is_same(a: &Row, b: &Row) -> bool {
    let asked = |row: &Row| (row.preset.clone(), row.drops, row.rate_mm_h, row.tone_map);
    asked(a) == asked(b)
}

/// The rows that any of a side's runs has, each once.
fn all_rows<'a>(runs: impl Iterator<Item = &'a Report>) -> Vec<&'a Row> {
    let mut all: Vec<&Row> = Vec::new();
    for row in runs.flat_map(|run| &run.rows) {
        if !all.iter().any(|known| is_same(known, row)) {
            all.push(row);
        }
    }
    all
}

/// The rows of a side's runs that no run of the other side has.
pub fn missing<'a>(
    a: impl Iterator<Item = &'a Report>,
    b: impl Iterator<Item = &'a Report>,
) -> Vec<MissingRow> {
    let of_b = all_rows(b);
    let is_alone = |row: &&Row| !of_b.iter().any(|other| is_same(row, other));
    let missing = |row: &Row| MissingRow {
        name: row.name(),
        preset: row.preset.clone(),
        drops: row.drops,
        rate_mm_h: row.rate_mm_h,
        width: row.width,
        height: row.height,
        tone_map: row.tone_map,
        median_ms_a: row.median_ms,
    };
    all_rows(a).into_iter().filter(is_alone).map(missing).collect()
}

fn matched<'a>(a: &'a Report, b: &'a Report) -> Vec<(&'a Row, &'a Row)> {
    let other = |row: &'a Row| Some((row, b.rows.iter().find(|other| is_same(row, other))?));
    a.rows.iter().filter_map(other).collect()
}

fn refused(problem: String) -> Error {
    Error::Scene { place: "these results cannot be compared".into(), problem }
}

fn same_device(a: (&str, &Report), b: (&str, &Report)) -> Result<()> {
    let (one, other) = (&a.1.device, &b.1.device);
    let numbers = |head: &DeviceHead| Some((head.vendor_id?, head.device_id?));
    // Files of the first version have no numbers.
    let same = match (numbers(one), numbers(other)) {
        (Some(one), Some(other)) => one == other,
        _ => one.name == other.name,
    };
    if same {
        return Ok(());
    }
    Err(refused(format!("the device is {} in {}, {} in {}", one.name, a.0, other.name, b.0)))
}

fn same_rows(a: (&str, &Report), b: (&str, &Report)) -> Result<()> {
    if a.1.environment != b.1.environment {
        return differ("the environment", (a.0, &a.1.environment), (b.0, &b.1.environment));
    }
    let rows = matched(a.1, b.1);
    if rows.is_empty() {
        let names = |report: &Report| report.rows.first().map(Row::name).unwrap_or_default();
        return Err(refused(format!(
            "no row is in both: {} has {} …, {} has {} …",
            a.0,
            names(a.1),
            b.0,
            names(b.1)
        )));
    }
    rows.into_iter().try_for_each(|(one, other)| same_row((a.0, one), (b.0, other)))
}

/// Fails unless two rows that were asked for alike are of one scene.
fn same_row(a: (&str, &Row), b: (&str, &Row)) -> Result<()> {
    if (a.1.width, a.1.height) != (b.1.width, b.1.height) {
        let size = |row: &Row| format!("{} x {}", row.width, row.height);
        return differ("the size", (a.0, &size(a.1)), (b.0, &size(b.1)));
    }
    if let (Some(one), Some(other)) = (&a.1.scene, &b.1.scene)
        && let Some((key, one, other)) = one.difference(other)
    {
        return differ(&format!("the scene's {key}"), (a.0, &one), (b.0, &other));
    }
    Ok(())
}

/// That something is not the same in two files.
fn differ(what: &str, a: (&str, &str), b: (&str, &str)) -> Result<()> {
    Err(refused(format!("{what} is {} in {}, {} in {}", a.1, a.0, b.1, b.0)))
}

/// Times of a row's rounds.
fn rounds(row: &Row) -> Vec<f64> {
    row.rounds.iter().map(|round| round.median_ms).collect()
}

/// One row, of all runs of A and of B.
fn row(a: &[&Row], b: &[&Row], how: How, threshold: f64) -> VerdictRow {
    let times = |runs: &[&Row]| -> Vec<Vec<f64>> { runs.iter().map(|run| rounds(run)).collect() };
    let (times_a, times_b) = (times(a), times(b));
    let (interval, noise_floor) = compare(&times_a, &times_b, how);
    let count = |times: &[Vec<f64>]| times.iter().map(Vec::len).sum::<usize>();
    let (first, new) = (a[0], b[0]);
    let exact = first.counters.iter().filter(|(name, _)| *name != NOT_EXACT);
    let changed = exact.filter_map(|(name, one)| {
        let other = new.counters.get(name)?;
        (one != other).then(|| (name.clone(), (*one, *other)))
    });
    let mut counters: IndexMap<String, (u64, u64)> = changed.collect();
    if first.visible != new.visible && !counters.contains_key("drops_in_view") {
        counters.insert("drops_in_view".into(), (first.visible, new.visible));
    }
    VerdictRow {
        name: new.name(),
        preset: new.preset.clone(),
        drops: new.drops,
        rate_mm_h: new.rate_mm_h,
        width: new.width,
        height: new.height,
        tone_map: new.tone_map,
        verdict: judge(interval, threshold),
        ratio: interval.map(|found| found.ratio),
        ratio_low: interval.map(|found| found.low),
        ratio_high: interval.map(|found| found.high),
        threshold,
        rounds: count(&times_a).min(count(&times_b)),
        noise_floor,
        median_ms_a: median(&times_a.concat()),
        median_ms_b: median(&times_b.concat()),
        rounds_ms_a: times_a.concat(),
        rounds_ms_b: times_b.concat(),
        flip_between: None,
        error_a: None,
        error_b: None,
        first_stage_that_differs: None,
        outcome: None,
        pictures: None,
        counters,
        passes: passes(a, b, how, threshold),
        notes: other_models(first, new).into_iter().collect(),
    }
}

/// What is drawn otherwise in B, if anything: by all axes of the models, or by those that older results have.
fn other_models(a: &Row, b: &Row) -> Option<String> {
    let models = |row: &Row| [&row.optics, &row.primitive, &row.order].map(String::clone).join(" ");
    if a.axes.is_empty() || b.axes.is_empty() {
        let differ = models(a) != models(b);
        return differ.then(|| format!("drawn by {} in A, by {} in B", models(a), models(b)));
    }
    let differing = a.axes.iter().filter_map(|(axis, of_a)| {
        let of_b = b.axes.get(axis)?;
        let plain = |value: &Value| value.as_str().map_or(value.to_string(), String::from);
        (of_a != of_b).then(|| format!("{axis} {} in A, {} in B", plain(of_a), plain(of_b)))
    });
    let differing: Vec<String> = differing.collect();
    (!differing.is_empty()).then(|| format!("drawn with {}", differing.join("; ")))
}

/// Interval and noise floor of runs' times.
fn compare(a: &[Vec<f64>], b: &[Vec<f64>], how: How) -> (Option<Interval>, Option<f64>) {
    match how {
        How::Unpaired => (unpaired::interval(a, b), unpaired::noise_floor(a, b)),
        How::Paired(look) => {
            let pairs: Vec<paired::Pair> =
                a[0].iter().copied().zip(b[0].iter().copied()).take(look.rounds).collect();
            (paired::interval(&pairs, &look), paired::noise_floor(&pairs))
        }
    }
}

/// The passes that both sides have in every round.
fn passes(a: &[&Row], b: &[&Row], how: How, threshold: f64) -> IndexMap<String, PassRow> {
    let times = |runs: &[&Row], name: &str| -> Option<Vec<Vec<f64>>> {
        let of_run = |run: &&Row| -> Option<Vec<f64>> {
            let times: Option<Vec<f64>> =
                run.rounds.iter().map(|round| round.passes.get(name).copied()).collect();
            times.filter(|times| times.iter().all(|ms| *ms > 0.0))
        };
        runs.iter().map(of_run).collect()
    };
    let of_pass = |name: &String| {
        let (a, b) = (times(a, name)?, times(b, name)?);
        let (interval, _) = compare(&a, &b, how);
        let row = PassRow {
            verdict: judge(interval, threshold),
            ratio: interval.map(|found| found.ratio),
            ratio_low: interval.map(|found| found.low),
            ratio_high: interval.map(|found| found.high),
            median_ms_a: median(&a.concat()),
            median_ms_b: median(&b.concat()),
        };
        Some((name.clone(), row))
    };
    b[0].passes.keys().filter_map(of_pass).collect()
}
