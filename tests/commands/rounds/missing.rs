//! Rows that the new result lacks, and tests of JUnit that a page of continuous integration can tell apart. The files in
//! `tests/data` are of other people's runs.

use std::collections::BTreeSet;
use std::fs;

use quick_junit::{Report, TestCaseStatus};
use serde_json::Value;

use super::error_line;
use crate::common::said::said;
use crate::common::stand_in::Bench;

fn data(name: &str) -> String {
    format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn junit(bench: &Bench) -> Report {
    let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
    Report::deserialize_from_str(&xml).expect("JUnit")
}

/// Class and name of every test, and of those that fail.
fn tests(junit: &Report) -> (Vec<[String; 2]>, Vec<[String; 2]>) {
    let cases = junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let key = |case: &quick_junit::TestCase| {
        let class = case.classname.as_ref().expect("a class");
        [class.as_str().to_string(), case.name.as_str().to_string()]
    };
    let is_failure =
        |case: &&quick_junit::TestCase| matches!(case.status, TestCaseStatus::NonSuccess { .. });
    (cases.clone().map(key).collect(), cases.filter(is_failure).map(key).collect())
}

const ROWS: [&str; 2] = ["1,000 drops, fast, 64 x 64", "1,000 drops, fast, 64 x 64, no tone map"];

/// The second device is as fast as the first, the third 1.5 times as slow. Both suites have tests of the same names.
#[test]
fn tests_of_several_devices_are_told_apart() {
    let bench = Bench::new();
    let three = data("three-devices.json");
    let judged = |file: &str| {
        let output = bench.command(&["verdict", file, "--junit", "j.xml"]).output();
        assert_eq!(output.expect("it starts").status.code(), Some(0), "no bound was given");
        tests(&junit(&bench))
    };
    let (all, failures) = judged(&three);
    assert_eq!((all.len(), all.iter().collect::<BTreeSet<_>>().len()), (4, 4), "{all:?}");
    assert_eq!(failures.len(), 2, "{failures:?}");
    for (row, [class, name]) in ROWS.iter().zip(&failures) {
        assert!(class.starts_with("Other GPU C, ") && name == row, "{failures:?}");
    }
    // Two cards of one kind are told apart, too.
    let text = fs::read_to_string(&three).expect("a file");
    let alike = ["llvmpipe A", "SwiftShader B"]
        .iter()
        .fold(text, |text, name| text.replace(name, "Other GPU C"));
    fs::write(bench.path().join("alike.json"), alike).expect("a file");
    let (all, failures) = judged("alike.json");
    assert_eq!((all.iter().collect::<BTreeSet<_>>().len(), failures.len()), (4, 2), "{all:?}");
}

/// Two of four rows are gone.
#[test]
fn a_row_that_is_gone_fails_where_a_slower_one_would() {
    let bench = Bench::new();
    let (four, gone) = (data("four-rows.json"), data("two-rows-gone.json"));
    let verdict = |new: &str, more: &[&str]| {
        let files = ["verdict", &four, new, "--junit", "j.xml", "--json", "v.json"];
        bench.command(&[&files[..], more].concat()).output().expect("it starts")
    };
    let names = ROWS.map(|row| row.replace("1,000", "2,000"));
    let above = ["--fail-above", "5%"];

    let output = verdict(&gone, &[&above[..], &["--fail-undecided"]].concat());
    let line = error_line(&output, 1);
    assert_eq!(line, format!("{} (missing); {} (missing)", names[0], names[1]));
    let (all, failures) = tests(&junit(&bench));
    assert_eq!(all.len(), 4, "{all:?}");
    let failed: Vec<&String> = failures.iter().map(|[_, name]| name).collect();
    assert_eq!(failed, names.iter().collect::<Vec<_>>());
    let file = bench.json("v.json");
    let missing = file["missing"].as_array().expect("rows").clone();
    assert_eq!(missing.len(), 2);
    for (row, name) in missing.iter().zip(&names) {
        assert_eq!((&row["name"], &row["preset"]), (&name.as_str().into(), &"fast".into()));
        assert_eq!((&row["drops"], &row["median_ms_a"]), (&2000.into(), &115.0.into()));
    }
    assert_eq!(file["failed"].as_array().map(Vec::len), Some(2));
    let key = serde_json::json!({ "missing": [] });
    crate::common::documented_keys("raindrops-verdict/1", &[&key, &missing[0]]);

    // In every form that is printed.
    let printed = |format: &str| {
        let output = verdict(&gone, &["--format", format]);
        assert_eq!(output.status.code(), Some(0), "no bound was given");
        String::from_utf8(output.stdout).expect("text")
    };
    let rows_of = |text: &str, row: &str| text.lines().filter(|line| line.contains(row)).count();
    let markdown = printed("markdown");
    assert_eq!(rows_of(&markdown, "| missing |"), 2, "{markdown}");
    assert!(markdown.contains("B lacks 2 rows of A"), "{markdown}");
    let csv = printed("csv");
    assert_eq!(rows_of(&csv, "fast,2000,64,64,true,,missing,"), 1, "{csv}");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    assert!(reader.records().all(|row| row.is_ok()), "lines of other lengths: {csv}");
    let page = bench.command(&["report", "v.json", "-o", "page.html"]).output();
    assert!(page.expect("it starts").status.success());
    let page = fs::read_to_string(bench.path().join("page.html")).expect("a page");
    assert_eq!(page.matches("<td class=\"missing\">missing</td>").count(), 2, "{page}");

    // Asked for, and not.
    for (more, status, failures) in [
        (&[][..], 0, 0),
        (&["--fail-missing"], 1, 2),
        (&["--fail-missing=true"], 1, 2),
        (&["--fail-above", "5%", "--fail-missing=false"], 0, 0),
        (&["--fail-undecided"], 0, 0),
    ] {
        let output = verdict(&gone, more);
        assert_eq!(output.status.code(), Some(status), "{more:?}: {}", said(&output));
        assert_eq!(tests(&junit(&bench)).1.len(), failures, "{more:?}");
    }
    assert!(said(&verdict(&gone, &[])).contains("note: without --fail-missing a row that B lacks"));
    // What is there is judged; what is more in B is no loss.
    let output = verdict(&data("four-rows-faster.json"), &above);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let ratio = bench.json("v.json")["rows"][0]["ratio"].as_f64().expect("a ratio");
    assert!((ratio - 78.8 / 115.0).abs() < 1e-9, "{ratio}");
    let more = ["verdict", &gone, &four, "--fail-above", "5%"];
    assert_eq!(bench.command(&more).output().expect("it starts").status.code(), Some(0));
}

/// A row that a file of expectations lists is left to it, also where it is gone; what is kept is judged again.
#[test]
fn a_row_that_is_gone_may_be_expected() {
    let bench = Bench::new();
    let (four, gone) = (data("four-rows.json"), data("two-rows-gone.json"));
    let run = |arguments: &[&str]| {
        let output = bench.command(arguments).output().expect("it starts");
        (output.status.code(), said(&output))
    };
    let expect = |text: &str| {
        let text = format!("[[device]]\nmatch = 'llvmpipe'\n{text}\n");
        fs::write(bench.path().join("e.toml"), text).expect("a file");
        run(&["verdict", &four, &gone, "--fail-above", "5%", "--expect", "e.toml", "--fail-unused"])
    };
    let (status, said) = expect("skips = ['2,000 drops']");
    assert_eq!(status, Some(0), "{said}");
    let (status, said) = expect("skips = ['=2,000 drops, fast, 64 x 64']");
    assert!(status == Some(1) && said.contains("no tone map (missing)"), "{said}");

    let (status, said) = run(&["verdict", &four, &gone, "--json", "kept.json"]);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(run(&["verdict", "kept.json"]).0, Some(0));
    let (status, said) = run(&["verdict", "kept.json", "--fail-above", "5%"]);
    assert!(status == Some(1) && said.contains("(missing)"), "{said}");
    assert_eq!(
        run(&["verdict", "kept.json", "--fail-above", "5%", "--fail-missing=false"]).0,
        Some(0)
    );
    // A comparison of devices is no other.
    let kept = bench.json("kept.json");
    let text = fs::read_to_string(data("three-devices.json")).expect("a file");
    let mut devices: Value = serde_json::from_str(&text).expect("JSON");
    devices["verdicts"].as_array_mut().expect("verdicts").truncate(1);
    devices["devices"].as_array_mut().expect("devices").truncate(2);
    devices["verdicts"][0]["verdict"]["missing"] = kept["missing"].clone();
    fs::write(bench.path().join("two.json"), devices.to_string()).expect("a file");
    assert_eq!(run(&["verdict", "two.json"]).0, Some(0));
    let (status, said) = run(&["verdict", "two.json", "--fail-above", "5%"]);
    assert!(status == Some(1) && said.contains("(missing)"), "{said}");
}

/// Several results of a side: a row counts if any of them has it.
#[test]
fn a_row_is_gone_if_no_result_has_it() {
    let bench = Bench::new();
    let (four, gone) = (data("four-rows.json"), data("two-rows-gone.json"));
    let status = |a: &str, b: &str| {
        let arguments = ["verdict", a, b, "--fail-above", "5%", "--json", "v.json"];
        bench.command(&arguments).output().expect("it starts").status.code()
    };
    let both = format!("{gone},{four}");
    assert_eq!(status(&four, &both), Some(0));
    assert_eq!(bench.json("v.json")["rows"].as_array().map(Vec::len), Some(4));
    assert_eq!(status(&both, &gone), Some(1));
}

/// Rounds in turn and a baseline fail when a row is missing; a row that was not to be measured is not missed.
#[test]
fn measurements_that_lack_a_row_fail() {
    let bench = Bench::new();
    let few = ["--rounds", "6", "--fail-above", "5%", "--json", "v.json"];
    let turns =
        |side: &str, more: &[&str]| bench.run(&[&few[..], &[side, "MORE=1"], more].concat());
    let output = turns("--a", &[]);
    assert!(error_line(&output, 1).contains("2,000 drops, paper, 64 x 64 (missing)"));
    assert_eq!(bench.json("v.json")["missing"][0]["drops"], 2000);
    assert_eq!(turns("--a", &["--fail-missing=false"]).status.code(), Some(0));
    assert_eq!(turns("--b", &[]).status.code(), Some(0));
    let alone = bench.command(&["bench", "--drops", "9", "--fail-missing"]).output();
    assert!(error_line(&alone.expect("it starts"), 2).contains("are for --baseline"));

    let quick =
        ["bench", "--size", "16x16", "--mask-size", "16", "--seconds", "0", "--frames", "1"];
    let run = |more: &[&str]| {
        let output = bench.command(&[&quick, more].concat()).output().expect("it starts");
        (output.status.code(), said(&output))
    };
    let base = ["--drops", "50,60", "--preset", "paper", "--rounds", "2", "--json", "base.json"];
    assert_eq!(run(&base).0, Some(0));
    let against = |more: &[&str]| {
        let all = ["--baseline", "base.json", "--rounds", "1", "--fail-above", "1000%"];
        run(&[&all[..], more].concat())
    };
    assert_eq!(against(&[]).0, Some(0));
    let (status, said) = against(&["--drops", "50"]);
    assert_eq!(status, Some(0), "60 drops were not asked for: {said}");
    let mut more = bench.json("base.json");
    let mut row = more["rows"][0].clone();
    row["preset"] = "none".into();
    more["rows"].as_array_mut().expect("rows").push(row);
    fs::write(bench.path().join("base.json"), more.to_string()).expect("a file");
    let (status, said) = against(&["--drops", "50,60", "--preset", "paper"]);
    assert_eq!(status, Some(0), "preset none was not asked for: {said}");
    let mut more = bench.json("base.json");
    more["rows"][4]["preset"] = "paper".into();
    more["rows"][4]["rate_mm_h"] = 5.0.into();
    fs::write(bench.path().join("base.json"), more.to_string()).expect("a file");
    let (status, said) = against(&["--preset", "paper", "--drops", "50,60"]);
    assert_eq!(status, Some(0), "a rate was not asked for: {said}");
}
