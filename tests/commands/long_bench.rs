//! `bench --duration`: what long measurements come to, and the command.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use raindrops::measure::bench::{OverTime, Stretch};
use serde_json::Value;

const MIB: f64 = 1024.0 * 1024.0;

/// Sixty stretches of a minute, of a noise of 2 % that is the same in each test.
fn run(ms: impl Fn(f64) -> f64, mib: impl Fn(f64) -> f64) -> OverTime {
    let mut random = crate::common::Random(5);
    let stretches = (1..=60).map(|minute| {
        let noise = 1.0 + 0.02 * (random.unit() - 0.5);
        let share = f64::from(minute) / 60.0;
        let median_ms = ms(share) * noise;
        Stretch {
            to_s: 60.0 * f64::from(minute),
            frames: 100,
            median_ms,
            p10_ms: median_ms,
            p90_ms: median_ms,
            resident_bytes: Some((mib(share) * MIB) as u64),
            device_bytes: 0,
            clock_mhz: None,
            load: None,
        }
    });
    OverTime::of(3600.0, stretches.collect(), "not told".into())
}

#[test]
fn what_stays_is_steady_from_the_beginning() {
    let found = run(|_| 10.0, |_| 100.0);
    assert!(found.steady_from_s.is_some_and(|from| from < 600.0), "{found:?}");
    assert!(!found.frame_time.expect("a trend").counts);
    let memory = found.memory.expect("a trend");
    assert_eq!((memory.per_hour, memory.chance, memory.counts), (0.0, 1.0, false));
}

#[test]
fn a_warm_up_and_a_throttle_are_left_out_and_told() {
    let near = |value: Option<f64>, of: f64| value.is_some_and(|ms| (ms / of - 1.0).abs() < 0.01);
    for (before, after, until) in [(14.0, 10.0, 0.2), (10.0, 13.0, 0.3)] {
        let found = run(|share| if share <= until { before } else { after }, |_| 100.0);
        assert_eq!(found.steady_from_s, Some(3600.0 * until), "{before} to {after}");
        assert!(near(found.before_ms, before) && near(found.steady_ms, after), "{found:?}");
        assert!(!found.frame_time.expect("a trend").counts, "{:?}", found.frame_time);
    }
}

#[test]
fn a_slow_decline_and_a_leak_are_trends() {
    let found = run(|share| 10.0 * (1.0 + 0.2 * share), |share| 100.0 + 30.0 * share);
    let time = found.frame_time.expect("a trend");
    assert!(time.counts && time.change > 0.05, "{time:?}");
    let memory = found.memory.expect("a trend");
    assert!(memory.counts && (memory.per_hour / MIB - 30.0).abs() < 0.1, "{memory:?}");
    // One step is no leak, nor is less than a mebibyte.
    let step = run(|_| 10.0, |share| if share < 0.75 { 100.0 } else { 140.0 });
    assert!(!step.memory.expect("a trend").counts, "{:?}", step.memory);
    let little = run(|_| 10.0, |share| 100.0 + 0.5 * share);
    assert!(!little.memory.expect("a trend").counts, "{:?}", little.memory);
}

#[test]
fn a_short_run_says_nothing_of_trends() {
    let whole = run(|_| 10.0, |_| 100.0);
    let found = OverTime::of(3600.0, whole.stretches[..7].to_vec(), "not told".into());
    assert_eq!((found.steady_from_s, found.frame_time, found.memory), (None, None, None));
    assert_eq!(OverTime::of(1.0, vec![], "not told".into()).steady_ms, None);
}

const SMALL: [&str; 7] = ["bench", "--drops", "1000", "--size", "64x64", "--preset", "paper"];

fn bench(folder: &tempfile::TempDir, arguments: &[&str]) -> Command {
    let mut command = crate::common::raindrops();
    command.current_dir(folder.path()).args(SMALL).args(arguments);
    command
}

fn result(folder: &tempfile::TempDir) -> Value {
    let text = fs::read_to_string(folder.path().join("long.json")).expect("a result");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_run_has_its_figures_over_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--duration", "3s", "--json", "long.json", "--svg", "long.svg"];
    let output = bench(&folder, &arguments).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = result(&folder);
    assert_eq!(report["schema"], "raindrops-bench/1");
    assert!(report["command"].as_str().is_some_and(|line| line.contains("--duration 3s")));
    let row = &report["rows"][0];
    assert_eq!(report["rows"].as_array().map(Vec::len), Some(1));
    assert!(
        row["rounds"].as_array().map(Vec::len) == Some(1) && row["median_ms"].as_f64() > Some(0.0)
    );
    let over_time = &row["over_time"];
    let stretches = over_time["stretches"].as_array().expect("stretches");
    let times: Vec<f64> = stretches.iter().filter_map(|s| s["to_s"].as_f64()).collect();
    assert!(times.len() > 3 && times.is_sorted(), "{times:?}");
    assert!(times.last().is_some_and(|last| *last >= 3.0), "{times:?}");
    let told = |key: &str| stretches.iter().all(|stretch| stretch[key].as_f64() > Some(0.0));
    assert!(["frames", "median_ms", "device_bytes"].into_iter().all(told), "{stretches:?}");
    #[cfg(target_os = "linux")]
    assert!(told("resident_bytes"));
    assert!(over_time["clock"].as_str().is_some_and(|source| !source.is_empty()));
    let svg = fs::read_to_string(folder.path().join("long.svg")).expect("a plot");
    for words in ["ms a frame", "MiB", "memory of the process", "</svg>"] {
        assert!(svg.contains(words), "{words}");
    }
    let page = crate::common::raindrops()
        .current_dir(folder.path())
        .args(["report", "long.json", "-o", "page.html"])
        .status();
    assert!(page.expect("it starts").success());
    let page = fs::read_to_string(folder.path().join("page.html")).expect("a page");
    assert!(
        page.contains("Over time: 1,000 drops, paper, 64 x 64") && page.contains("--duration 3s")
    );
}

#[test]
#[cfg(unix)]
fn an_interrupt_keeps_what_was_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = bench(&folder, &["--duration", "60s", "--json", "long.json"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    // The first of ten lines of how it goes.
    let told = lines.find(|line| line.as_ref().is_ok_and(|line| line.contains("ms a frame")));
    assert!(told.is_some(), "it says how it goes");
    let number = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &number]).status().expect("kill").success());
    assert!(lines.any(|line| line.is_ok_and(|line| line == "raindrops: interrupted")));
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let stretches = &result(&folder)["rows"][0]["over_time"]["stretches"];
    let to_s = stretches.as_array().and_then(|all| all.last()?["to_s"].as_f64());
    assert!(to_s.is_some_and(|to_s| (6.0..60.0).contains(&to_s)), "{to_s:?}");
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, words) in [
        (&["--duration", "0"][..], "'0' is not within 1s to 30days"),
        (&["--duration", "-5s"], "'-5s' is not a time"),
        (&["--duration", "soon"], "'soon' is not a time such as 90s, 15m or 1h"),
        (&["--duration", "5s", "--preset", "fast"], "one preset"),
        (&["--duration", "5s", "--drops", "7"], "one number of drops"),
        (&["--duration", "5s", "--rounds", "3"], "cannot be used with"),
        (&["--duration", "5s", "--b", "A=1"], "cannot be used with"),
        (&["--duration", "5s", "--device", "all"], "one device"),
        (&["--duration", "5s", "--junit", "j.xml"], "--junit and --expect are for"),
        (&["--duration", "5s", "--svg", "nowhere/x.svg"], "there is no folder nowhere"),
    ] {
        let output = bench(&folder, arguments).output().expect("it starts");
        let error = crate::common::said::failure(&output, 2);
        assert!(error.contains(words), "{arguments:?}: {error}");
        assert_eq!(folder.path().read_dir().expect("a folder").count(), 0);
    }
}
