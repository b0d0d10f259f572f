//! A measurement of minutes or hours, stretch by stretch: when it becomes steady, and whether it drifts or
//! grows after that.
//!
//! Steady from where on is found by the marginal standard error rule (White 1997): of all beginnings up to
//! half of the run, that one is left out without which the mean of the rest is known best, by
//! `Σ (xᵢ - x̄)² / (n - d)²`. If that is the whole half, the run did not become steady.
//!
//! A trend is the median of the slopes between all pairs of stretches (Theil and Sen), and is distinguished from chance
//! by Mann and Kendall's test, ties counted. Neighbouring stretches are alike on busy machines, for which that
//! test is too sure of itself; so a trend counts only if it also comes to something.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF as _, Normal};

use crate::measure::statistics::median;

/// Fewer stretches show no trend.
const LEAST: usize = 8;
/// The chance by which a trend may be taken for one where there is none, but for its size.
const CHANCE: f64 = 0.01;
/// Frame times that change by less, as a part of 1, are steady.
const DRIFT: f64 = 0.05;
/// Memory that grows by less is steady, bytes.
const GROWTH: f64 = 1024.0 * 1024.0;

/// A long measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct OverTime {
    /// Asked for.
    pub duration_s: f64,
    pub stretches: Vec<Stretch>,
    /// Where the device's clock is read, or why not.
    pub clock: String,
    /// None: it did not become steady.
    pub steady_from_s: Option<f64>,
    /// Median of the stretches before that, and from there on.
    pub before_ms: Option<f64>,
    pub steady_ms: Option<f64>,
    /// Trend of the steady part, or of the whole where none is steady; absent with too few stretches.
    pub frame_time: Option<Trend>,
    pub memory: Option<Trend>,
}

/// Some of its frames, one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct Stretch {
    /// When it ended, since the first frame.
    pub to_s: f64,
    pub frames: usize,
    pub median_ms: f64,
    pub p10_ms: f64,
    pub p90_ms: f64,
    /// Memory of the process; absent where the system does not tell.
    pub resident_bytes: Option<u64>,
    /// Device memory that the program has allocated.
    pub device_bytes: u64,
    pub clock_mhz: Option<f64>,
    /// Load average of the last minute.
    pub load: Option<f64>,
}

/// Where a figure goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    /// Change an hour: a part of 1 of frame times, bytes of memory.
    pub per_hour: f64,
    /// Change from the first to the last stretch that were looked at, likewise.
    pub change: f64,
    /// The chance of one at least as clear where there is none.
    pub chance: f64,
    /// It is clear, and comes to something.
    pub counts: bool,
}

impl OverTime {
    /// What stretches come to.
    pub fn of(duration_s: f64, stretches: Vec<Stretch>, clock: String) -> Self {
        let logs: Vec<f64> = stretches.iter().map(|stretch| stretch.median_ms.ln()).collect();
        let first = steady_from(&logs);
        let rest = &stretches[first.unwrap_or(0)..];
        let medians = |of: &[Stretch]| -> Option<f64> {
            let all: Vec<f64> = of.iter().map(|stretch| stretch.median_ms).collect();
            (!all.is_empty()).then(|| median(&all))
        };
        let times = || rest.iter().map(|stretch| stretch.to_s / 3600.0);
        let of_log: Vec<_> = times().zip(logs[first.unwrap_or(0)..].iter().copied()).collect();
        let resident = |stretch: &Stretch| stretch.resident_bytes.map(|bytes| bytes as f64);
        let of_memory: Vec<_> =
            times().zip(rest).filter_map(|(at, stretch)| Some((at, resident(stretch)?))).collect();
        let as_part = |log: f64| log.exp() - 1.0;
        let frame_time = trend(&of_log).map(|found| {
            let change = as_part(found.change);
            let counts = found.chance < CHANCE && change.abs() > DRIFT;
            let per_hour = change * found.per_hour / found.change;
            // No change, and 0 over 0.
            let per_hour = if per_hour.is_finite() { per_hour } else { 0.0 };
            Trend { per_hour, change, counts, ..found }
        });
        let memory = trend(&of_memory)
            .map(|found| Trend { counts: found.chance < CHANCE && found.change > GROWTH, ..found });
        Self {
            duration_s,
            clock,
            steady_from_s: first.map(|first| match first {
                0 => 0.0,
                _ => stretches[first - 1].to_s,
            }),
            before_ms: medians(&stretches[..first.unwrap_or(0)]),
            steady_ms: first.and_then(|first| medians(&stretches[first..])),
            frame_time,
            memory,
            stretches,
        }
    }
}

/// The first of the values from which on they are steady.
fn steady_from(values: &[f64]) -> Option<usize> {
    let most = values.len() / 2;
    if values.len() < LEAST {
        return None;
    }
    let error = |first: usize| {
        let rest = &values[first..];
        let mean = rest.iter().sum::<f64>() / rest.len() as f64;
        let squares: f64 = rest.iter().map(|value| (value - mean).powi(2)).sum();
        squares / (rest.len() as f64).powi(2)
    };
    let best = (0..=most).min_by(|a, b| error(*a).total_cmp(&error(*b)))?;
    (best < most).then_some(best)
}

/// The trend of values over time; `counts` is the caller's to say.
fn trend(points: &[(f64, f64)]) -> Option<Trend> {
    if points.len() < LEAST {
        return None;
    }
    let (mut slopes, mut sum) = (Vec::new(), 0i64);
    for (number, (at, value)) in points.iter().enumerate() {
        for (before, earlier) in &points[..number] {
            slopes.push((value - earlier) / (at - before));
            sum += i64::from(value > earlier) - i64::from(value < earlier);
        }
    }
    let n = points.len() as f64;
    let spread = |n: f64| n * (n - 1.0) * (2.0 * n + 5.0);
    let mut values: Vec<f64> = points.iter().map(|point| point.1).collect();
    values.sort_by(f64::total_cmp);
    let ties: f64 = values.chunk_by(|a, b| a == b).map(|tie| spread(tie.len() as f64)).sum();
    let deviation = ((spread(n) - ties) / 18.0).sqrt();
    // One less, as the sum is a whole number.
    let z = (sum.abs() as f64 - 1.0).max(0.0) / deviation;
    let chance = if deviation > 0.0 { 2.0 * Normal::standard().sf(z) } else { 1.0 };
    let per_hour = median(&slopes);
    let (first, last) = (points.first()?.0, points.last()?.0);
    Some(Trend { per_hour, change: per_hour * (last - first), chance, counts: false })
}
