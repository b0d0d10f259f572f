//! A benchmark in the JSON of google/benchmark, which dashboards and `github-action-benchmark` read: an
//! iteration a round, then their median.
//!
//! `cpu_time` is the wall clock's too: the work is the device's, and the format has no word for it.

use serde_json::{Value, json};

use crate::measure::bench::{Report, Row};

/// The file.
pub(super) fn google_benchmark(report: &Report) -> Value {
    let host = &report.host;
    let rows = report.rows.iter().enumerate();
    json!({
        "context": {
            "date": report.start,
            "host_name": host.cpu,
            "executable": format!("raindrops {}", report.build.version),
            "num_cpus": host.cores,
            "mhz_per_cpu": 0,
            "cpu_scaling_enabled": false,
            "caches": [],
            "load_avg": host.load.into_iter().collect::<Vec<f64>>(),
            "library_build_type": report.build.profile,
            "device": report.device.summary(),
        },
        "benchmarks": rows.flat_map(|(family, row)| of_row(family, row)).collect::<Vec<_>>(),
    })
}

fn of_row(family: usize, row: &Row) -> Vec<Value> {
    let name = row.name();
    let repetitions = row.rounds.len();
    let frames = row.samples_ms.len() / repetitions.max(1);
    let entry = |more: Value, ms: f64, frames: usize, name: String| {
        let mut entry = json!({
            "name": name,
            "family_index": family,
            "per_family_instance_index": 0,
            "run_name": row.name(),
            "repetitions": repetitions,
            "threads": 1,
            "iterations": frames,
            "real_time": ms,
            "cpu_time": ms,
            "time_unit": "ms",
        });
        if let (Value::Object(entry), Value::Object(more)) = (&mut entry, more) {
            entry.extend(more);
        }
        entry
    };
    let rounds = row.rounds.iter().enumerate().map(|(number, round)| {
        let more = json!({ "run_type": "iteration", "repetition_index": number });
        entry(more, round.median_ms, frames, name.clone())
    });
    let median = json!({
        "run_type": "aggregate",
        "aggregate_name": "median",
        "aggregate_unit": "time",
    });
    let median = entry(median, row.median_ms, repetitions, format!("{name}_median"));
    rounds.chain([median]).collect()
}
