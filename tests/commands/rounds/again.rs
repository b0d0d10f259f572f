//! A comparison that was kept, judged again by other bounds.

use std::fs;

use super::error_line;
use crate::common::stand_in::Bench;

#[test]
fn a_comparison_is_judged_again() {
    let bench = Bench::new();
    let output = bench.run(&[
        "--b",
        "MS=12,PICTURE=white",
        "--threshold",
        "10%",
        "--pictures",
        "seen",
        "--json",
        "v.json",
    ]);
    assert_eq!(output.status.code(), Some(0));
    let measured = bench.json("v.json");
    fs::create_dir(bench.path().join("sub")).expect("a folder");
    let again = |arguments: &[&str]| {
        let all = [&["verdict", "v.json", "--json", "sub/again.json"], arguments].concat();
        let output = bench.command(&all).output().expect("it starts");
        let said = [&output.stdout[..], &output.stderr].concat();
        (output.status.code(), String::from_utf8_lossy(&said).into_owned())
    };
    let expect = |text: &str| {
        let text = format!("[[device]]\nmatch = 'V 1'\n{text}\n");
        fs::write(bench.path().join("e.toml"), text).expect("a file");
        again(&["--expect", "e.toml"])
    };

    // With the bounds of the measurement nothing is lost, and nothing runs.
    let started = bench.started();
    assert_eq!(again(&[]).0, Some(0));
    let file = bench.json("sub/again.json");
    for key in ["ratio", "ratio_low", "ratio_high", "flip_between", "rounds_ms_b", "threshold"] {
        assert_eq!(file["rows"][0][key], measured["rows"][0][key], "{key}");
    }
    assert_eq!(file["rows"][0]["verdict"], "different");
    assert_eq!(
        (&file["command"], &file["method"]),
        (&measured["command"], &"paired".into()),
        "how it was measured"
    );
    let notes = file["notes"].to_string();
    assert!(notes.contains("judged again by ") && notes.contains("sub/again.json"), "{notes}");
    // The file is elsewhere, its pictures are not.
    let picture = file["rows"][0]["pictures"]["a"].as_str().expect("a path");
    assert!(bench.path().join("sub").join(picture).exists(), "{picture}");

    // By other bounds: 1.2 times as slow, and FLIP of white before black.
    for (arguments, verdict, pass, status) in [
        (&["--max-flip", "1"][..], "slower", "slower", 0),
        (&["--max-flip", "1", "--fail-above", "5%"], "slower", "slower", 1),
        (&["--max-flip", "1", "--fail-above", "25%"], "same", "same", 0),
        (&["--fail-above", "25%"], "different", "same", 1),
    ] {
        assert_eq!(again(arguments).0, Some(status), "{arguments:?}");
        let file = bench.json("sub/again.json");
        assert_eq!(file["rows"][0]["verdict"], verdict, "{arguments:?}");
        assert_eq!(file["counts"][verdict], 1, "{arguments:?}");
        assert_eq!(file["rows"][0]["passes"]["drops"]["verdict"], pass, "{arguments:?}");
    }
    let (status, said) = expect("ratio = 1.1\nflip = 1");
    assert!(status == Some(1) && said.contains("B / A is at least 1.2"), "{said}");
    let bounds = "beyond the bounds of --expect: B / A 1.1, FLIP 1\n";
    assert!(said.contains(bounds), "{said}");
    let (status, said) = expect("ratio = 1.3\nflip = 0.01");
    assert!(status == Some(1) && said.contains("FLIP is "), "{said}");
    let own = "[[device.row]]\nmatch = 'paper'\nratio = 1.3\npasses = { drops = 1.25 }";
    let (status, said) = expect(&format!("ratio = 1.1\n{own}"));
    assert_eq!(status, Some(0), "{said}");
    let bounds = "--expect: B / A 1.1; of rows with 'paper': B / A 1.3, pass drops 1.25\n";
    assert!(said.contains(bounds), "{said}");
    assert_eq!(bench.started(), started);

    // One that was judged again is judged again as well, and says so once.
    fs::copy(bench.path().join("sub/again.json"), bench.path().join("v.json")).expect("a copy");
    assert_eq!(again(&["--max-flip", "1"]).0, Some(0));
    let file = bench.json("sub/again.json");
    assert_eq!(file["rows"][0]["outcome"], serde_json::Value::Null, "of another file");
    assert_eq!(file["notes"].to_string().matches("judged again").count(), 1);
}

#[test]
fn what_is_no_comparison_is_refused() {
    let bench = Bench::new();
    super::keep(&bench, "base.json", &[]);
    fs::write(bench.path().join("none.json"), "{\"schema\": \"raindrops-rain/1\"}")
        .expect("a file");
    for (arguments, words) in [
        (&["base.json"][..], "base.json: it is one side of a comparison: name the result"),
        (&["none.json"], "none.json: its schema is 'raindrops-rain/1'; a comparison is needed"),
        (&["a.json,b.json"], "a comparison is one file"),
    ] {
        let output = bench.command(&[&["verdict"], arguments].concat()).output();
        let line = error_line(&output.expect("it starts"), 2);
        assert!(line.contains(words), "{line}");
    }
}

/// A bound of pictures is none where there are none.
#[test]
fn pictures_that_were_not_compared_are_not_judged() {
    let bench = Bench::new();
    super::keep(&bench, "base.json", &[]);
    let run = |arguments: &[&str]| {
        let output = bench.command(arguments).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, said) = run(&["verdict", "base.json", "base.json", "--json", "kept.json"]);
    assert_eq!(status, Some(0), "{said}");
    let (status, said) = run(&["verdict", "kept.json", "--max-flip", "0.1"]);
    assert!(status == Some(2) && said.contains("no pictures were compared"), "{said}");
    let text =
        "[[device]]\nmatch = 'V 1'\nflip = 0.1\n[[device.row]]\nmatch = 'paper'\nerror = 0.1\n";
    fs::write(bench.path().join("e.toml"), text).expect("a file");
    let judged = ["verdict", "kept.json", "--expect", "e.toml"];
    let (status, said) = run(&judged);
    assert_eq!(status, Some(0), "{said}");
    for words in ["flip holds for no row: no pictures", "error holds for no row: it needs"] {
        assert!(said.contains(&format!("note: e.toml: {words}")), "{said}");
    }
    assert_eq!(run(&[&judged[..], &["--fail-unused"]].concat()).0, Some(1));
}

/// What a file of expectations names, and no row has, is a note; it fails where that is asked for.
#[test]
fn names_of_no_row_fail_if_asked() {
    let bench = Bench::new();
    let run = |text: &str, more: &[&str]| {
        let text = format!("[[device]]\nmatch = 'V 1'\n{text}\n");
        fs::write(bench.path().join("e.toml"), text).expect("a file");
        let arguments = ["--rounds", "6", "--expect", "e.toml", "--json", "v.json"];
        let output = bench.run(&[&arguments[..], more].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let own = "[[device.row]]\nmatch = 'paper'\npasses = { skyy = 2 }";
    for (text, words) in [
        (
            "skips = ['papre']",
            "no row's name contains 'papre'; one is '1,000 drops, paper, 64 x 64'",
        ),
        ("skips = ['=paper']", "no row's name is 'paper'"),
        ("passes = { drips = 2 }", "no row has a pass 'drips'; 1,000 drops, paper, 64 x 64 has "),
        (own, "no row has a pass 'skyy'"),
        ("[[device.row]]\nmatch = 'papre'\nratio = 2", "no row's name contains 'papre'"),
        (
            "[[device.row]]\nmatch = 'paper'\nratio = 2\n[[device.row]]\nmatch = '1,000'\nratio = 3",
            "a [[device.row]] before it takes all rows of '1,000'",
        ),
    ] {
        let (status, said) = run(text, &[]);
        assert_eq!(status, Some(0), "{said}");
        assert!(said.contains(&format!("note: e.toml: {words}")), "{said}");
        let (status, said) = run(text, &["--fail-unused", "--junit", "j.xml"]);
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains(&format!("raindrops: e.toml: {words}")), "{said}");
        let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
        let read = quick_junit::Report::deserialize_from_str(&xml).expect("JUnit");
        assert_eq!((read.tests, read.failures), (2, 1), "{xml}");
        assert!(bench.json("v.json")["failed"][0].as_str().is_some_and(|why| why.contains(words)));
    }
    let used = "skips = ['=1,000 drops, paper, 64 x 64']\npasses = { drops = 2 }";
    assert_eq!(run(used, &["--fail-unused"]).0, Some(0));
    assert!(error_line(&bench.run(&["--fail-unused"]), 2).contains("--expect"));
}
