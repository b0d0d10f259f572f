//! Results that are kept in files: held against each other, measured again as a baseline, whole after an interrupt.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{error_line, keep};
use crate::common::stand_in::Bench;

#[test]
fn kept_results_are_compared() {
    let bench = Bench::new();
    keep(&bench, "base.json", &[]);
    keep(&bench, "slow.json", &[("MS", "12"), ("DEVICE", "E"), ("DRIVER", "2")]);
    keep(&bench, "wide.json", &[("WIDTH", "65")]);
    let verdict = |arguments: &[&str]| {
        let all = [&["verdict"], arguments].concat();
        bench.command(&all).output().expect("it starts")
    };
    let output = verdict(&["base.json", "slow.json", "--json", "v.json", "--fail-above", "0.05"]);
    assert!(error_line(&output, 1).contains("(slower)"));
    let report = bench.json("v.json");
    assert_eq!(
        (&report["method"], &report["rows"][0]["verdict"]),
        (&"unpaired".into(), &"slower".into())
    );
    // Worked by hand: the rounds of a run are 0.5, 1.5 ... 4.5 thousandths off their middle; t(4, 97.5 %) = 2.7764.
    let spread = 1.4826 * (10f64 / 9.0).sqrt() * 0.0025;
    let half = 2.776_445 * spread * 2f64.sqrt();
    let expected = [("noise_floor", half.exp() - 1.0), ("ratio_high", 1.2 * half.exp())];
    for (key, expected) in expected {
        let found = report["rows"][0][key].as_f64().expect(key);
        assert!((found / expected - 1.0).abs() < 1e-3, "{key}: {found}, not {expected}");
    }
    assert!(report["notes"].to_string().contains("the driver is V 1 in A, V 2 in B"));
    assert_eq!((&report["counts"]["slower"], &report["counts"]["same"]), (&1.into(), &0.into()));
    assert_eq!(report["failed"], serde_json::json!(["1,000 drops, paper, 64 x 64 (slower)"]));
    let output = verdict(&["base.json", "base.json", "--fail-above", "5%"]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("same") && !said.contains("only in") && !said.contains("too few"));

    // A row more in A, and one round only.
    let mut more = bench.json("base.json");
    let mut row = more["rows"][0].clone();
    row["drops"] = 77.into();
    more["rows"].as_array_mut().expect("rows").push(row);
    more["rows"][0]["rounds"] = serde_json::json!([]);
    fs::write(bench.path().join("more.json"), more.to_string()).expect("a file");
    let output = verdict(&["more.json", "base.json"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("only in A, so not compared: 77 drops"), "{said}");
    assert!(!said.contains("only in B") && !said.contains("fewer than the six"), "{said}");
    let output = verdict(&["more.json", "more.json"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!said.contains("only in") && said.contains("fewer than the six"), "{said}");
    let output = bench
        .command(&["report", "base.json", "v.json", "-o", "page.html"])
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(bench.path().join("page.html")).expect("a page");
    assert!(
        page.contains("<td class=\"slower\">slower</td>") && page.ends_with("</html>"),
        "{page}"
    );
    assert!(!page.contains("http"), "it needs no network");
    let report = |from: &str| bench.command(&["report", from, "-o", "bars.svg"]).output();
    assert_eq!(report("base.json").expect("it starts").status.code(), Some(0));
    let bars = fs::read_to_string(bench.path().join("bars.svg")).expect("a picture");
    assert!(bars.starts_with("<svg xmlns=") && bars.contains(">drops: 10 ms</title>"), "{bars}");
    assert!(!bars.contains("var("), "{bars}");
    let line = error_line(&report("v.json").expect("it starts"), 2);
    assert!(line.contains("no benchmark with times of passes"), "{line}");
    let line = error_line(&verdict(&["base.json", "wide.json"]), 2);
    assert!(line.contains("the size is 64 x 64 in base.json, 65 x 64 in wide.json"), "{line}");
    let line = error_line(&verdict(&["base.json", "slow.json", "--same-device"]), 2);
    assert!(line.contains("the device is D in base.json, E in slow.json"), "{line}");
    // Runs of one side are of one device.
    let line = error_line(&verdict(&["base.json,slow.json", "base.json"]), 2);
    assert!(line.contains("the device is D in base.json, E in slow.json"), "{line}");
    fs::write(bench.path().join("empty.json"), "").expect("a file");
    let line = error_line(&verdict(&["base.json", "empty.json"]), 2);
    assert!(line.contains("empty.json: it is empty"), "{line}");
    let mut bare = bench.json("base.json");
    bare["rows"] = Value::Array(vec![]);
    fs::write(bench.path().join("bare.json"), bare.to_string()).expect("a file");
    let line = error_line(&report("bare.json").expect("it starts"), 2);
    assert!(line.contains("bare.json: it has no rows"), "{line}");
}

const QUICK: [&str; 9] =
    ["bench", "--size", "32x32", "--mask-size", "64", "--seconds", "0.01", "--frames", "1"];

/// The program itself: what the baseline has is measured again; one that does not fit is refused after a round.
#[test]
fn a_baseline_is_measured_again() {
    let bench = Bench::new();
    let run = |more: &[&str]| bench.command(&[&QUICK, more].concat()).output().expect("it starts");
    let what = ["--drops", "100,200", "--preset", "paper", "--rounds", "6", "--json", "base.json"];
    assert_eq!(run(&what).status.code(), Some(0));
    let against = ["--baseline", "base.json", "--rounds", "6", "--json", "v.json"];
    let output = run(&against);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let (base, report) = (bench.json("base.json"), bench.json("v.json"));
    let names = |file: &Value, key: &str| -> Vec<String> {
        let rows = file["rows"].as_array().expect("rows");
        rows.iter().map(|row| format!("{} {}", row[key], row["tone_map"])).collect()
    };
    assert_eq!(names(&report, "drops"), names(&base, "drops"));
    assert_eq!((&report["method"], &report["rows"][0]["rounds"]), (&"unpaired".into(), &6.into()));
    assert!(report["rows"][0]["ratio_low"].as_f64() > Some(0.0), "{report}");

    // What tells it from another: the scene, its start, the load.
    let row = &base["rows"][0];
    assert!(base["start"].is_string() && base["host"]["load"].is_number(), "{base}");
    for key in ["hash", "seed", "time", "camera", "half_extent", "radius", "velocity"] {
        assert!(!row["scene"][key].is_null(), "{key}: {row}");
    }
    let round = &row["rounds"][5];
    assert!(round["start"].is_string() && round["load"].is_number(), "{round}");
    let mut other = base.clone();
    other["rows"][0]["scene"]["seed"] = 2.into();
    fs::write(bench.path().join("seed.json"), other.to_string()).expect("a file");
    let kept = bench.command(&["verdict", "base.json", "seed.json"]).output().expect("it starts");
    assert!(error_line(&kept, 2).contains("the scene's seed is 1 in base.json, 2 in seed.json"));

    let mut other = base.clone();
    other["device"]["device_id"] = 4711.into();
    other["device"]["name"] = "another".into();
    fs::write(bench.path().join("base.json"), other.to_string()).expect("a file");
    // All rounds would take an hour; the time here guards against that alone.
    let against = ["--baseline", "base.json", "--rounds", "1000", "--max-time", "1h"];
    let slow = QUICK.map(|word| if word == "0.01" { "0.5" } else { word });
    let mut command = bench.command(&[&slow[..], &against].concat());
    let mut child = command.stderr(Stdio::piped()).spawn().expect("it starts");
    let start = Instant::now();
    while child.try_wait().expect("a status").is_none() {
        if start.elapsed() > Duration::from_secs(600) {
            child.kill().expect("it ends");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let line = error_line(&child.wait_with_output().expect("its words"), 2);
    assert!(line.contains("the device is another in base.json"), "{line}");
}

/// Without rounds, too.
#[test]
fn an_interrupt_keeps_the_rows_that_are_done() {
    let bench = Bench::new();
    let drops: Vec<String> = (1..200).map(|n| n.to_string()).collect();
    let mut child = bench
        .command(&QUICK)
        .args(["--drops", &drops.join(","), "--preset", "paper", "--json", "kept.json"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    assert!(lines.any(|line| line.is_ok_and(|line| line.contains("199 measurements, each"))));
    let number = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &number]).status().expect("kill").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let rows = bench.json("kept.json")["rows"].as_array().map(Vec::len);
    assert!(rows.is_some_and(|rows| (2..398).contains(&rows)), "{rows:?}");
}
