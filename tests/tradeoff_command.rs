//! `tradeoff`: what an interrupt leaves.
#![cfg(unix)]

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Stdio};

use serde_json::Value;

#[test]
fn an_interrupt_keeps_the_rows_that_are_finished() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = common::raindrops()
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
    assert!(said.ends_with(&format!("raindrops: {stopped}\n")), "{said}");
    assert_eq!(rows[0]["scene"], "close-up");
    assert!(rows.len() >= 3 && rows.iter().all(|row| row["scene"] != "lens"), "{stopped}");
    // Times without errors are no rows.
    assert!(rows.iter().all(|row| row["rms"].as_f64() > Some(0.0)), "{rows:?}");
    let csv = fs::read_to_string(folder.path().join("kept.csv")).expect("a table");
    assert_eq!(csv.lines().count(), 1 + rows.len());
}
