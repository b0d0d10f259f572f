//! `bench` in one process: rows by number and rate, what it writes, what it warns of, and what may not be asked.

use std::fs;
use std::process::{Child, Command, Output, Stdio};

use raindrops::measure::bench::{Timer, WarmUp};
use serde_json::{Value, json};

use crate::common::outcome;

fn raindrops(arguments: &[&str]) -> Output {
    crate::common::raindrops().args(arguments).output().expect("the command starts")
}

fn bench(arguments: &[&str]) -> Value {
    let quick = ["--size", "96x96", "--seconds", "0.02", "--frames", "1", "--json", "-"];
    let output = raindrops(&[&["bench"], arguments, &quick].concat());
    // Status 1 would be another count of drops by the CPU.
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON and nothing else")
}

#[test]
fn a_series_of_rates_has_a_row_each() {
    let report = bench(&["--rain", "1,25"]);
    assert_eq!(report["schema"], "raindrops-bench/1");
    let rows: Vec<&Value> = report["rows"].as_array().expect("rows").iter().collect();
    let rates: Vec<f64> = rows.iter().filter_map(|row| row["rate_mm_h"].as_f64()).collect();
    assert_eq!(rates, [1.0, 1.0, 25.0, 25.0]);
    assert!(
        rows.iter().all(|row| row["preset"] == "fast" && row["median_ms"].as_f64() > Some(0.0))
    );
    let seen = |row: usize| rows[row]["visible"].as_u64().expect("a number");
    // At one density of a pixel's drops the number goes as M3: 12.5 times as many in heavy rain.
    assert!(seen(0) > 0 && seen(2) > 5 * seen(0), "{} {}", seen(0), seen(2));
    let hash = |row: usize| rows[row]["scene"]["hash"].clone();
    assert!(hash(0) == hash(1) && hash(0) != hash(2));
}

/// Figures and plot of a small benchmark; both name the device, the plot the paper's machines too.
#[test]
fn a_benchmark_is_written_and_plotted() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = ["bench", "--drops", "500,2000", "--size", "32x32", "--preset", "paper,fast"];
    let files = ["--seconds", "0", "--frames", "2", "--json", "b.json", "--svg", "b.svg"];
    let mut command = crate::common::raindrops();
    command.current_dir(folder.path()).args(bench).args(files);
    let output = outcome(command.env("LP_NUM_THREADS", "1"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json = fs::read_to_string(folder.path().join("b.json")).expect("figures");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["schema"], "raindrops-bench/1");
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(8));
    // What decides on the driver's speed, where it is set.
    let variables = &json["host"]["variables"];
    assert_eq!((&variables["LP_NUM_THREADS"], variables.get("LP_PERF")), (&"1".into(), None));
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains(", LP_NUM_THREADS=1"), "{stdout}");
    let svg = fs::read_to_string(folder.path().join("b.svg")).expect("a plot");
    let device = json["device"]["name"].as_str().expect("a name");
    for name in ["GeForce GTX 280, 2011", "GeForce 7300 GT, 2011", "fast", "paper", device] {
        assert!(svg.contains(name), "no {name} in the plot");
    }
}

/// Ended when this goes.
struct Busy(Child);

impl Drop for Busy {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// There are as many programs as processors, and they do nothing but work.
#[cfg(target_os = "linux")]
#[test]
fn the_work_of_others_is_warned_of() {
    let processors = fs::read_to_string("/proc/stat").expect("the system's counts");
    let processors = processors.lines().filter(|line| line.starts_with("cpu")).count() - 1;
    let busy = |_| {
        let mut command = Command::new("sh");
        command.args(["-c", "while :; do :; done"]).stdin(Stdio::null());
        Busy(command.spawn().expect("a shell"))
    };
    let busy: Vec<Busy> = (0..processors).map(busy).collect();
    let small = ["bench", "--drops", "1000", "--preset", "fast", "--size", "96x96"];
    let output = raindrops(&[&small[..], &["--seconds", "0.5", "--json", "-"]].concat());
    drop(busy);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let others = report["host"]["others"].as_f64().expect("a share");
    assert!((0.1..=1.0).contains(&others), "{others}");
    let warnings = report["warnings"].as_array().expect("warnings");
    let is_told = |warning: &Value| warning.to_string().contains("of the processors' time");
    assert!(warnings.iter().any(is_told), "{warnings:?}");
}

/// The count by the CPU is that of the row, not of the scene, which has a million.
#[test]
fn no_drops_are_none_in_view() {
    let report = bench(&["--drops", "0", "--preset", "paper"]);
    assert_eq!(
        (&report["rows"][0]["drops"], &report["rows"][0]["visible"]),
        (&json!(0), &json!(0))
    );
}

/// A scene is measured as it is; a series keeps what else it says of its rain.
#[test]
fn a_scene_of_real_rain_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rain.toml");
    fs::write(&path, "[rain]\nrate = 5.0\nextent = 2.0\n[model]\npreset = \"fast\"\n")
        .expect("written");
    let path = path.to_str().expect("UTF-8");
    let own = bench(&[path]);
    assert_eq!(own["rows"][0]["rate_mm_h"], 5.0);
    let series = bench(&[path, "--rain", "5"]);
    assert_eq!(own["rows"][0]["visible"], series["rows"][0]["visible"]);
    assert_eq!(own["rows"][0]["scene"]["hash"], series["rows"][0]["scene"]["hash"]);
    // A scene of one drop has that, and no random ones of Table II.
    let path = folder.path().join("drop.toml");
    fs::write(&path, "[rain]\ncount = 0\n[[drop]]\ncenter = [0.0, 0.0, -3.0]\n").expect("written");
    let one = bench(&[path.to_str().expect("UTF-8"), "--preset", "paper"]);
    let rows = one["rows"].as_array().expect("rows");
    assert!(rows.len() == 2 && rows.iter().all(|row| row["drops"] == 1), "{rows:?}");
    // The paper's drops have no rate.
    let papers = bench(&["--drops", "1000", "--preset", "paper"]);
    assert!(papers["rows"][0].get("rate_mm_h").is_none());
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    let cases: [(&[&str], &str); 5] = [
        (&["--rain", "0"], "rate = 0 is not within 0.001 to 2000 mm/h"),
        (&["--rain", "5,-1"], "rate = -1 is not within"),
        (&["--rain", "1e6"], "rate = 1000000 is not within"),
        (&["--rain", "5", "--drops", "7"], "cannot be used with"),
        (&["--rain", "5", "--preset", "paper"], "take preset fast, exact or auto"),
    ];
    for (arguments, expected) in cases {
        let output = raindrops(&[&["bench"], arguments].concat());
        let error = crate::common::said::failure(&output, 2);
        assert!(error.contains(expected), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty());
    }
}

/// Rows of one preset are told apart by their rate.
#[test]
fn a_verdict_is_of_rows_of_one_rate() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, rows: &[(f64, f64)]| {
        let row = |(rate, ms): &(f64, f64)| {
            json!({
                "preset": "fast", "optics": "appearance", "primitive": "tile", "order": "sorted", "drops": 0,
                "rate_mm_h": rate, "visible": 1, "width": 4, "height": 4, "tone_map": true, "samples_ms": [ms],
                "median_ms": ms, "p10_ms": ms, "p90_ms": ms, "fps": 1000.0 / ms,
                "rounds": vec![json!({ "median_ms": ms }); 10],
            })
        };
        let file = json!({
            "schema": "raindrops-bench/1",
            "device": { "name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU" },
            "build": { "version": "0.1.0", "commit": "unknown" },
            "host": { "cpu": "C", "cores": 2, "os": "O" },
            "rows": rows.iter().map(row).collect::<Vec<_>>(),
        });
        let path = folder.path().join(name);
        fs::write(&path, file.to_string()).expect("written");
        path.to_str().expect("UTF-8").to_string()
    };
    let (a, b) =
        (write("a.json", &[(1.0, 2.0), (25.0, 8.0)]), write("b.json", &[(25.0, 8.0), (1.0, 4.0)]));
    let output = raindrops(&["verdict", &a, &b, "--json", "-"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let ratio = |rate: f64| {
        let rows = report["rows"].as_array().expect("rows");
        let row = rows.iter().find(|row| row["rate_mm_h"] == rate).expect("a row of the rate");
        row["median_ms_b"].as_f64().expect("ms") / row["median_ms_a"].as_f64().expect("ms")
    };
    assert_eq!([ratio(1.0), ratio(25.0)], [2.0, 1.0]);
    // CSV has both rates, too.
    let output = raindrops(&["verdict", &a, &b, "--format", "csv"]);
    let mut reader = csv::Reader::from_reader(output.stdout.as_slice());
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    let rates: Vec<&str> = rows.iter().filter_map(|row| row.iter().next_back()).collect();
    assert_eq!(rates, ["1", "25"]);
}

/// Warms up by frames of these times; how many it took, and whether they settled.
fn warmed(time: impl Fn(f64) -> f64) -> (f64, f64, bool) {
    let (mut warm_up, mut at, mut last) = (WarmUp::default(), 0.0, 0.0);
    while warm_up.goes_on() {
        last = time(at);
        at += last;
        warm_up.take(last);
    }
    (at, last, warm_up.has_settled())
}

#[test]
fn nothing_counts_before_the_clock_has_settled() {
    // From 300 MHz to 1,980 MHz within 0.6 s, of frames that take 0.4 ms in the end.
    let ramp = |at: f64| 0.4 * 1980.0 / (300.0 + 1680.0 * (at / 600.0).min(1.0));
    let (spent, last, has_settled) = warmed(ramp);
    assert!(has_settled && (600.0..1200.0).contains(&spent), "{spent} ms");
    assert!((last - 0.4).abs() < 1e-9, "{last}");
    // At its clock from the first frame on.
    let (spent, _, has_settled) = warmed(|_| 0.4);
    assert!(has_settled && spent < 310.0, "{spent} ms");
    // Frames longer than a stretch.
    let (spent, _, has_settled) = warmed(|_| 60.0);
    assert!(has_settled && spent < 800.0, "{spent} ms");
    // Never: it ends all the same, and says so.
    let (spent, _, has_settled) = warmed(|at| 1.0 + (at / 500.0).fract());
    assert!(!has_settled && (2000.0..2010.0).contains(&spent), "{spent} ms");
    let (spent, _, has_settled) = warmed(|_| 1500.0);
    assert!(!has_settled && spent == 3000.0, "{spent} ms");
}

const CARD: Timer = Timer { tick_ns: 83.3, bits: 36, submission_ms: 0.03 };

#[test]
fn short_times_are_said_to_be_short() {
    let passes = [("gather", 0.1), ("rays", 0.0005), ("glints", 0.0)];
    let doubts = CARD.doubts(0.3, &passes, true);
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    assert!(doubts[0].starts_with("rays, glints under ten ticks"), "{doubts:?}");
    let doubts = CARD.doubts(0.05, &passes[..1], true);
    assert!(doubts.len() == 1 && doubts[0].contains("an empty submission 0.030 ms"), "{doubts:?}");
    let doubts = CARD.doubts(0.3, &passes[..1], false);
    assert!(doubts.len() == 1 && doubts[0].contains("not settled after 2 s"), "{doubts:?}");
    assert_eq!(CARD.doubts(0.3, &passes[..1], true), Vec::<String>::new());
}

#[test]
fn a_timer_that_begins_again_is_said() {
    let short = Timer { tick_ns: 1.0, bits: 24, submission_ms: 0.0 };
    assert!(short.doubts(17.0, &[], true)[0].starts_with("the timer begins again after 17 ms"));
    assert!(short.doubts(16.0, &[], true).is_empty());
    // Without a timer there are no times of passes to doubt.
    let none = Timer { bits: 0, ..short };
    assert!(none.doubts(17.0, &[("rays", 0.0)], true).is_empty());
}
