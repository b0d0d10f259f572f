//! `raindrops survey`: its files, what it says of steps that fail, and what it refuses.

use std::io::Read as _;

use crate::common::{documented_keys, folder, outcome, raindrops};
use serde_json::Value;

/// What a survey came to.
struct Outcome {
    status: Option<i32>,
    said: String,
    written: Option<Written>,
}

/// Its result, and the names in its zip file.
struct Written {
    result: Value,
    names: Vec<String>,
}

/// Runs it in a folder that holds something else too.
fn survey(arguments: &[&str]) -> Outcome {
    let place = folder();
    let card = place.path().join("card");
    std::fs::create_dir(&card).expect("a folder");
    std::fs::write(card.join("mine.txt"), "not for others").expect("a file");
    let mut command = raindrops();
    command.current_dir(&card).args(["survey", "-o", "."]).args(arguments);
    if !arguments.contains(&"--max-time") {
        // The usual eight minutes may be over where the machine is busy.
        command.args(["--max-time", "1day"]);
    }
    let ran = outcome(&mut command);
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    let written = std::fs::read_to_string(card.join("survey.json")).ok().map(|text| {
        let file = std::fs::File::open(place.path().join("card.zip")).expect("a zip file");
        let mut packed = zip::ZipArchive::new(file).expect("a sound zip file");
        let mut kept = String::new();
        let mut inside = packed.by_name("survey.json").expect("the result is in it");
        inside.read_to_string(&mut kept).expect("text");
        drop(inside);
        assert_eq!(kept, text, "what is sent is what is kept");
        let names = packed.file_names().map(|name| name.expect("a name").into_owned()).collect();
        Written { result: serde_json::from_str(&text).expect("JSON"), names }
    });
    Outcome { status: ran.status.code(), said, written }
}

#[test]
fn pictures_are_as_true_as_they_should_be() {
    let Outcome { status, said, written } =
        survey(&["--only", "devices,drop-fast,box-paper,shower-exact"]);
    assert_eq!(status, Some(0), "{said}");
    let Written { result, names } = written.expect("a result");
    documented_keys("raindrops-survey/1", &[&result, &result["steps"][0], &result["pictures"][0]]);
    let steps = result["steps"].as_array().expect("steps");
    assert_eq!(steps.len(), 4, "{steps:?}");
    assert_eq!(result["pictures"].as_array().expect("pictures").len(), 3);
    for wanted in ["devices.json", "drop-fast.png", "drop-reference.png", "shower.toml"] {
        assert!(names.iter().any(|name| name == wanted), "{wanted} is not in {names:?}");
    }
    assert!(!names.iter().any(|name| name == "mine.txt"), "what others keep there is not sent");
}

/// What is not measured is said, in the result too, and is no success.
#[test]
fn steps_that_no_longer_fit_are_named() {
    let Outcome { status, said, written } =
        survey(&["--max-time", "1s", "--only", "table-2,drop-fast"]);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("warning: table-2: left out: --max-time 1s is over"), "{said}");
    let Written { result, .. } = written.expect("a result");
    let steps = result["steps"].as_array().expect("steps");
    assert!(steps.iter().all(|step| step["failed"].is_string()), "{steps:?}");
}

#[test]
fn a_step_that_there_is_not_is_refused() {
    let Outcome { status, said, written } = survey(&["--only", "table2"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("--only table2: there are devices, table-2, "), "{said}");
    assert!(written.is_none());
}

/// A step of which a process fails is named with what the process said.
#[test]
fn a_step_that_fails_is_named() {
    let place = folder();
    let ran =
        outcome(raindrops().current_dir(place.path()).env("RAINDROPS_MACHINE", "abacus").args([
            "survey",
            "-o",
            "card",
            "--only",
            "drop-fast",
        ]));
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(said.contains("RAINDROPS_MACHINE is abacus: cpu or gpu"), "{said}");
}

/// The steps are of the device that was asked for, not of that which they would choose.
#[test]
fn steps_draw_on_the_device_that_is_asked_for() {
    let Outcome { said, written, .. } = survey(&["--device", "llvmpipe", "--only", "drop-fast"]);
    assert!(written.is_some(), "{said}");
    let place = folder();
    let mut other = raindrops();
    other.env("RAINDROPS_DEVICE", "no such device").current_dir(place.path());
    let chosen = ["survey", "-o", "card", "--device", "0", "--only", "drop-fast"];
    let ran = outcome(other.args(chosen));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
}
