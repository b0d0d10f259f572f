//! `tradeoff`: which scenes and models it takes, and what an interrupt leaves.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Stdio};

use raindrops::picture::Picture;
use raindrops::picture::metrics::compare;
use raindrops::picture::tone_map::Exposure;
use serde_json::Value;

#[test]
fn an_interrupt_keeps_the_rows_that_are_finished() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = crate::common::raindrops()
        .current_dir(folder.path())
        .args(["tradeoff", "--truth-samples", "1", "--models", "snorm16", "--seconds", "0"])
        .args(["--min-frames", "1", "--json", "kept.json", "--csv", "kept.csv"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    // The table of the first of eight scenes.
    assert!(lines.any(|line| line.is_ok_and(|line| line.contains("snorm16"))));
    let number = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &number]).status().expect("kill").success());
    lines.for_each(drop);
    let mut said = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut said).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{said}");

    let text = fs::read_to_string(folder.path().join("kept.json")).expect("a result");
    let result: Value = serde_json::from_str(&text).expect("JSON");
    let rows = result["rows"].as_array().expect("rows");
    let stopped = result["stopped"].as_str().expect("a reason");
    let left = format!("{} of ", rows.len());
    assert!(stopped.starts_with(&left) && stopped.ends_with(": interrupted"), "{stopped}");
    assert_eq!(
        crate::common::said::lines(&said, crate::common::said::FAILURE),
        [stopped],
        "{said}"
    );
    assert_eq!(rows[0]["scene"], "close-up");
    assert!(rows.len() >= 3 && rows.iter().all(|row| row["scene"] != "lens"), "{stopped}");
    // Times without errors are no rows.
    assert!(rows.iter().all(|row| row["rms"].as_f64() > Some(0.0)), "{rows:?}");
    let csv = fs::read_to_string(folder.path().join("kept.csv")).expect("a table");
    assert_eq!(csv.lines().count(), 1 + rows.len());
}

/// Which models a row is of, axis by axis: real rain, exposed and out of focus, by `exact`, `fast` and with spheres for its drops.
/// Three rows and no more: their pipelines are most of what the test takes.
#[test]
fn every_axis_of_a_row_is_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "[image]\nwidth = 16\nheight = 12\n[camera]\nshutter = 0.002\naperture = 0.01\nfocus = 2.0\n\
        [rain]\nrate = 25.0\nextent = 4.0\n";
    fs::write(folder.path().join("a.toml"), scene).expect("a scene");
    let mut command = crate::common::raindrops();
    command.current_dir(folder.path()).args(["tradeoff", "a.toml", "--truth-samples", "1"]);
    command.args(["--models", "fast shape sphere"]);
    command.args(["--seconds", "0", "--min-frames", "1", "--json", "a.json", "--csv", "a.csv"]);
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", crate::common::said::said(&output));
    let text = fs::read_to_string(folder.path().join("a.json")).expect("a result");
    let result: Value = serde_json::from_str(&text).expect("JSON");
    let rows = result["rows"].as_array().expect("rows");
    crate::common::documented_keys("raindrops-tradeoff/1", &[&rows[0]]);
    // The keys of a scene's models are those of a row.
    let schema = serde_json::to_value(raindrops::scene::ModelChoice::default()).expect("JSON");
    for axis in schema.as_object().expect("an object").keys() {
        assert!(rows.iter().all(|row| row.get(axis).is_some()), "{axis} is not recorded");
    }
    let mut csv = csv::Reader::from_path(folder.path().join("a.csv")).expect("a table");
    let header = csv.headers().expect("names").clone();
    let lines: Vec<csv::StringRecord> = csv.records().map(|row| row.expect("a row")).collect();
    let drawn = |model: &str| -> [String; 3] {
        let at = rows.iter().position(|row| row["model"] == model).expect("a row");
        ["motion", "lens", "shape"].map(|axis| {
            let column = header.iter().position(|name| name == axis).expect("a column");
            let value = rows[at][axis].as_str().expect("a name").to_string();
            assert_eq!(lines[at][column], value, "{model}: {axis}");
            value
        })
    };
    assert_eq!(&header[2], "preset", "columns of earlier versions stay where they were");
    assert_eq!(&header[35], "far_rain");
    assert_eq!(drawn("exact"), ["sampled", "sampled", "equilibrium"]);
    assert_eq!(drawn("fast"), ["streak", "disc", "equilibrium"]);
    assert_eq!(drawn("fast shape sphere"), ["streak", "disc", "sphere"]);
    let table = String::from_utf8(output.stdout).expect("text");
    let line = table.lines().find(|line| line.contains("fast shape sphere")).expect("a row");
    let words: Vec<&str> = line.split_whitespace().collect();
    assert!(words.ends_with(&["streak", "disc", "sphere"]), "{table}");
}

/// A name in full is one model, a part of names all that have it; a scene of the study is taken by its name.
#[test]
fn scenes_and_models_are_chosen_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| {
        let mut command = crate::common::raindrops();
        let quick = ["--truth-samples", "1", "--seconds", "0", "--min-frames", "1", "--json", "-"];
        command.current_dir(folder.path()).arg("tradeoff").args(quick).args(arguments);
        let output = command.output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (serde_json::from_slice::<Value>(&output.stdout).ok(), said)
    };
    let chosen = |models: &str| -> Vec<(String, String)> {
        let (result, said) = run(&["--scenes", "close-up", "--models", models]);
        let result = result.unwrap_or_else(|| panic!("{said}"));
        let text = |value: &Value| value.as_str().expect("a name").to_string();
        let rows = result["rows"].as_array().expect("rows").iter();
        rows.map(|row| (text(&row["scene"]), text(&row["model"]))).collect()
    };
    // With one sample the truth's noise is large: nearly all of the error of a true model, and never more than that.
    let near = ["--scenes", "near", "--models", "fast", "--pictures", "seen"];
    let (result, said) = run(&near);
    let result = result.unwrap_or_else(|| panic!("{said}"));
    let noise = result["noise"][0]["rms"].as_f64().expect("noise");
    let fast = result["rows"][2]["rms"].as_f64().expect("an error");
    assert!(result["noise"][0]["scene"] == "near" && result["rows"][2]["model"] == "fast");
    assert!(noise > 0.005 && (0.8..1.03).contains(&(noise / fast)), "{noise} {fast}");
    let seen = |name: &str| {
        let path = folder.path().join("seen").join(name);
        Picture::read(&path).unwrap_or_else(|error| panic!("{error}"))
    };
    let [truth, paper, fast] = ["near-truth.png", "near-paper.png", "near-fast.png"].map(seen);
    let apart =
        |picture: &Picture| compare(&truth, picture, None, Exposure::Clipped(1.0)).pixels.flip;
    assert!(
        apart(&fast) < apart(&paper) && apart(&fast) > 0.0,
        "pictures are those of their models"
    );
    let of = |model: &str| ("close-up".to_string(), model.to_string());
    assert_eq!(chosen("fast"), ["paper", "paper-compact", "fast"].map(of));
    let all = chosen("fast reflection");
    assert!(all.len() > 2 && !all.contains(&of("fast")), "{all:?}");
    for (arguments, words) in [
        (&["--scenes", "nowhere"][..], "--scenes nowhere: there are close-up, near, far"),
        (&["--scenes", "far", "--drops", "9"], "leave out one or the other"),
        (&["--models", "nobody"], "no model's name contains that"),
    ] {
        let (result, said) = run(arguments);
        assert!(result.is_none() && said.contains(words), "{arguments:?}: {said}");
    }
}
