//! Comparisons in rounds of fresh processes, with a program in place of ours that takes the times it is
//! told to: verdicts, exit statuses, and processes that crash, hang or write rubbish.

#![cfg(target_os = "linux")]

mod again;
mod encodings;
mod kept;
mod missing;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::said::failure as error_line;
use crate::common::stand_in::Bench;
use raindrops::measure::bench::Report;
use raindrops::measure::verdict::looks::looks;
use raindrops::picture::Picture;
use serde_json::Value;

/// Ten rounds of the program as a file.
fn keep(bench: &Bench, name: &str, variables: &[(&str, &str)]) {
    let mut command = Command::new(bench.path().join("program"));
    command.env("HERE", bench.path()).envs(variables.iter().copied()).args(["--json", name]);
    assert!(command.current_dir(bench.path()).status().expect("it starts").success());
    let mut file = bench.json(name);
    let row = &mut file["rows"][0];
    let ms = row["median_ms"].as_f64().expect("a time");
    let round = |n: i32| serde_json::json!({ "median_ms": ms * (1.0 + 0.001 * f64::from(n)) });
    row["rounds"] = (-5..5).map(round).collect();
    fs::write(bench.path().join(name), file.to_string()).expect("a file");
}

#[test]
fn a_slower_side_is_slower_and_fails_the_gate() {
    let bench = Bench::new();
    let output = bench.run(&["--b", "MS=12,NOTE='a, b'", "--json", "v.json"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("note: without --fail-above"), "{stderr}");
    let report = bench.json("v.json");
    assert_eq!(report["schema"], "raindrops-verdict/1");
    let row = &report["rows"][0];
    assert_eq!(row["verdict"], "slower");
    for key in ["ratio", "ratio_low", "ratio_high"] {
        assert!((row[key].as_f64().expect(key) - 1.2).abs() < 1e-9, "{key}: {}", row[key]);
    }
    assert_eq!((row["threshold"].as_f64(), row["rounds"].as_u64()), (Some(0.05), Some(10)));
    assert_eq!((row["noise_floor"].as_f64(), row["flip_between"].as_f64()), (Some(0.0), Some(0.0)));
    assert_eq!(row["passes"]["drops"]["verdict"], "slower");
    assert_eq!(row["passes"]["sky"]["verdict"], "same");
    assert!(row["error_a"].is_null() && row["first_stage_that_differs"].is_null());

    let failed = bench.run(&["--b", "MS=12", "--fail-above", "5%", "--junit", "j.xml"]);
    let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
    assert!(xml.contains("pass drops: slower, ") && !xml.contains("pass sky"), "{xml}");
    assert!(error_line(&failed, 1).contains("1,000 drops, paper, 64 x 64 (slower)"));
    let accepted = bench.run(&["--b", "MS=12", "--fail-above", "25%"]);
    assert_eq!(accepted.status.code(), Some(0));
    let other_way = bench.run(&["--a", "MS=12", "--fail-above", "5%", "--format", "csv"]);
    assert_eq!(other_way.status.code(), Some(0));
    let csv = String::from_utf8_lossy(&other_way.stdout).into_owned();
    assert!(csv.contains("paper,1000,64,64,true,,faster,0.83"), "{csv}");
}

#[test]
fn another_picture_is_different_and_a_counter_is_told() {
    let bench = Bench::new();
    let output = bench.run(&["--b", "PICTURE=white,MS=5,VISIBLE=199", "--format", "markdown"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("| different |"), "{text}");
    assert!(text.contains("counter drops_in_view: 200 in A, 199 in B"), "{text}");
    // Threads decide it: other in each process, and no change.
    assert!(!text.contains("tiles_done_again"), "{text}");
    let line = |side: &str| text.lines().any(|line| line.starts_with(&format!("- {side}: ")));
    assert!(line("A") && line("B"), "a comment says what was compared: {text}");
    let failed = bench.run(&["--b", "PICTURE=white", "--fail-above", "5%", "--json", "-"]);
    assert!(error_line(&failed, 1).contains("(different)"));
    let report: Value = serde_json::from_slice(&failed.stdout).expect("nothing but JSON");
    assert!(report["rows"][0]["flip_between"].as_f64() > Some(0.01));
}

#[test]
fn a_process_that_fails_is_told_and_what_was_measured_is_kept() {
    for (fault, words) in [
        ("CRASH_AT=5", "raindrops: the device is lost"),
        ("HANG_AT=5", "it took longer than SECONDS s (--timeout)"),
        ("RUBBISH_AT=5", "ends in the middle, at line 1"),
    ] {
        let mut seconds = 1;
        let (bench, line, words) = loop {
            let bench = Bench::new();
            let timeout = format!("{seconds}s");
            let output = bench.run(&["--a", fault, "--timeout", &timeout, "--json", "v.json"]);
            let (line, words) =
                (error_line(&output, 2), words.replace("SECONDS", &seconds.to_string()));
            // The fifth process is A's in the third round. On a machine that stalls any may run out of time: then all
            // get more of it.
            if (line.contains(&words) && bench.started() == 5) || seconds > 100 {
                break (bench, line, words);
            }
            assert!(line.contains("(--timeout)"), "{fault}: {line}");
            seconds *= 5;
        };
        assert!(line.contains(&words) && line.contains(fault), "{fault}: {line}");
        let report = bench.json("v.json");
        assert_eq!(report["rows"][0]["rounds"], 2, "{fault}");
        assert_eq!(report["rows"][0]["verdict"], "undecided");
        assert!(report["stopped"].as_str().is_some_and(|why| why.contains(&words)), "{fault}");
        assert!(bench.all_have_ended(), "{fault}: a process is left");
    }
}

/// A B, B A: the third process is B's, the fourth is not.
#[test]
fn the_order_alternates() {
    for (fault, status) in [("CRASH_AT=3", 2), ("CRASH_AT=4", 0)] {
        let output = Bench::new().run(&["--b", fault, "--rounds", "2"]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{fault}: {stderr}");
    }
}

/// What it has when its time is over has an interval, too.
#[test]
fn a_comparison_ends_in_time() {
    let bench = Bench::new();
    // The time may be over just when a look at the rounds was planned; then it is tried again with another time.
    // On a busy machine it may be over before the first look: then it is tried again with more of it.
    let (row, rounds) = (0..12)
        .find_map(|attempt| {
            let time = format!("{:.0}ms", 3000.0 * 1.4f64.powi(attempt));
            let noisy =
                ["--a", "NOISY=1", "--b", "NOISY=1", "--rounds", "1000", "--max-time", &time];
            let output = bench.run(&[&noisy[..], &["--json", "v.json"]].concat());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let stderr = String::from_utf8_lossy(&output.stderr);
            let report = bench.json("v.json");
            if report["rows"][0]["rounds"].as_u64() < Some(10) {
                return None;
            }
            let undecided = " s: 1 of 1 row undecided\n   1,000 drops, paper, 64 x 64: ";
            assert!(stderr.contains(undecided), "{stderr}");
            let stopped = report["stopped"].as_str();
            assert!(stopped.is_some_and(|why| why.contains("--max-time")), "{report}");
            let row = report["rows"][0].clone();
            let rounds = row["rounds"].as_u64().expect("a number") as usize;
            let planned = looks(1000).iter().any(|look| look.rounds == rounds);
            (!planned).then_some((row, rounds))
        })
        .expect("a time between two looks");
    assert!((10..1000).contains(&rounds), "{rounds} rounds");
    assert!(row["ratio_low"].as_f64() < row["ratio_high"].as_f64(), "{row}");
    // A first round in which drivers compile says nothing of the next. There is time for one such round, and for others where
    // the machine lets them; if it does not, all get more time.
    let is_same = |seconds: u32| {
        let (cold, time) = (Bench::new(), format!("{}ms", 3500 * seconds));
        let variable = format!("COLD={seconds}");
        let six = ["--a", &variable, "--b", &variable, "--rounds", "6", "--max-time", &time];
        let output = cold.run(&[&six[..], &["--json", "v.json"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        cold.json("v.json")["rows"][0]["verdict"] == "same"
    };
    assert!([2, 6, 20, 60].into_iter().any(is_same));
    // A kept result likewise, and it says so.
    let alone =
        ["bench", "--drops", "100", "--size", "32x32", "--preset", "paper", "--seconds", "0.01"];
    let rounds = ["--frames", "1", "--rounds", "1000", "--max-time", "1s", "--json", "kept.json"];
    let output = bench.command(&[&alone[..], &rounds].concat()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(bench.json("kept.json")["warnings"].to_string().contains("of 1000 rounds"));
    let stray = bench.command(&["bench", "--drops", "100", "--max-time", "1s"]).output();
    assert!(error_line(&stray.expect("it starts"), 2).contains("--max-time is for rounds"));
    // What rounds of one side have nothing to do with.
    for (option, told) in [
        (["--fail-above", "5%"], "are for --baseline, --a"),
        (["--junit", "v.xml"], "are for --baseline, --a"),
        (["--max-flip", "0"], "--max-flip is for two sides"),
        (["--truth-samples", "4"], "--truth-samples is for two sides"),
    ] {
        let given = ["bench", "--drops", "100", "--rounds", "1", option[0], option[1]];
        let refused = bench.command(&given).output().expect("it starts");
        assert!(error_line(&refused, 2).contains(told), "{option:?}");
    }
}

/// A comparison that knows nothing says so last, and fails where that is asked for.
#[test]
fn undecided_rows_are_counted_and_may_fail() {
    let bench = Bench::new();
    let few = ["--rounds", "2", "--fail-above", "5%"];
    let output = bench.run(&few);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let last = text.lines().last().expect("lines");
    assert!(last.contains("rows: ") || last.contains("row: "), "{last}");
    assert!(last.ends_with("undecided"), "{last}");
    let failed = bench.run(&[&few[..], &["--fail-undecided"]].concat());
    assert!(error_line(&failed, 1).contains("(undecided)"));
    let decided = bench.run(&["--b", "MS=12", "--fail-undecided"]);
    let text = String::from_utf8_lossy(&decided.stdout).into_owned();
    assert_eq!(decided.status.code(), Some(0), "slower, but no bound was given: {text}");
    assert!(
        text.lines().last().is_some_and(|line| line.ends_with("1 slower; 1 pass is slower")),
        "{text}"
    );
}

/// Their pictures are of the film's first frame, and of real rain in place of the scene's own.
#[test]
fn a_film_and_a_box_of_drops_are_compared() {
    let bench = Bench::new();
    // In rain of a few metres a truth takes a second.
    for (rain, amount) in
        [("count = 500", ["--drops", "100"]), ("rate = 8\nextent = 4", ["--rain", "10"])]
    {
        let film = format!(
            "[image]\nwidth = 32\nheight = 24\n[rain]\n{rain}\n[film]\npace = [{{ at = 0, rate = 1.0 }}, \
             {{ at = 9, rate = 1.0 }}]\n"
        );
        fs::write(bench.path().join("film.toml"), film).expect("a scene");
        let sides = ["bench", "film.toml", "--a", "LP_NUM_THREADS=1", "--b", "LP_NUM_THREADS=2"];
        let few = ["--rounds", "1", "--frames", "1", "--seconds", "0", "--preset", "fast"];
        let found = ["--truth-samples", "1", "--json", "v.json"];
        let output = bench.command(&[&sides[..], &few, &amount, &found].concat()).output();
        let output = output.expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let row = &bench.json("v.json")["rows"][0];
        assert_eq!(row["flip_between"].as_f64(), Some(0.0), "{row}");
        assert!(row["error_a"].as_f64().is_some_and(|error| error < 0.1), "{row}");
    }
}

/// The 2nd and the 9th of ten rounds hold the median with 95 %.
#[test]
fn rounds_have_an_interval() {
    let bench = Bench::new();
    let mut report: Option<Report> = None;
    for number in [5, 9, 1, 7, 3, 10, 2, 8, 4, 6] {
        keep(&bench, "round.json", &[("MS", &number.to_string())]);
        let mut round: Report = serde_json::from_value(bench.json("round.json")).expect("a result");
        round.rows[0].rounds.truncate(1);
        round.rows[0].rounds[0].median_ms = f64::from(number);
        match &mut report {
            None => report = Some(round),
            Some(report) => report.extend(round),
        }
    }
    let row = &report.expect("a result").rows[0];
    assert_eq!((row.median_low_ms, row.median_ms, row.median_high_ms), (Some(2.0), 5.5, Some(9.0)));
}

/// The program itself, and one that draws other drops than it measures.
#[test]
fn the_first_stage_that_differs_is_named() {
    let bench = Bench::new();
    let real = env!("CARGO_BIN_EXE_raindrops");
    let wrapper = bench.path().join("wrapper");
    let text =
        format!("#!/bin/sh\n[ $1 = render ] && set -- \"$@\" --seed 2\nexec '{real}' \"$@\"\n");
    fs::write(&wrapper, text).expect("a program");
    fs::set_permissions(&wrapper, fs::Permissions::from_mode(0o755)).expect("its mode");
    let small = ["--drops", "2000", "--size", "48x48", "--preset", "fast", "--seconds", "0.01"];
    for (program, verdict, stage) in
        [("./wrapper", "different", Value::from("positions")), (real, "undecided", Value::Null)]
    {
        let both = ["bench", "--a-binary", real, "--b-binary", program, "--rounds", "1"];
        let more =
            ["--frames", "1", "--max-flip", "0.001", "--truth-samples", "64", "--json", "v.json"];
        let output =
            bench.command(&[&both[..], &small, &more].concat()).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let row = &bench.json("v.json")["rows"][0];
        assert_eq!(
            (&row["verdict"], &row["first_stage_that_differs"]),
            (&verdict.into(), &stage),
            "{row}"
        );
        // Other drops are farther from the truth; the same are as far.
        let errors = ["error_a", "error_b"].map(|key| row[key].as_f64().expect(key));
        let is_as_far = (errors[1] / errors[0] - 1.0).abs() < 1e-3;
        assert!(if stage.is_null() { is_as_far } else { errors[1] > 1.002 * errors[0] }, "{row}");
    }
}

#[test]
fn pictures_are_kept_and_shown() {
    let bench = Bench::new();
    let into = ["--rounds", "6", "--pictures", "seen", "--json", "v.json"];
    let output = bench.run(&[&into[..], &["--b", "PICTURE=white"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let pictures = bench.json("v.json")["rows"][0]["pictures"].clone();
    assert_eq!(pictures["b"], "seen/paper-1000-drops-b.png", "{pictures}");
    let pixel = |key: &str| {
        let path = bench.path().join(pictures[key].as_str().expect("a path"));
        Picture::read(&path).expect("a picture").pixels[0].x
    };
    assert!(pixel("a") < pixel("b") && pixel("difference") > 0.0);
    // One even picture is as far from the other everywhere.
    let row = &bench.json("v.json")["rows"][0];
    let largest = row["pictures"]["largest_flip"].as_f64().expect("an error");
    assert!((largest - row["flip_between"].as_f64().expect("a mean")).abs() < 1e-6, "{row}");
    // Both are moved together.
    let away = bench.path().join("away");
    fs::create_dir(&away).expect("a folder");
    for name in ["v.json", "seen"] {
        fs::rename(bench.path().join(name), away.join(name)).expect("moved");
    }
    let page = |out: &str| {
        let output = bench.command(&["report", "away/v.json", "-o", out]).output();
        assert_eq!(output.expect("it starts").status.code(), Some(0));
        fs::read_to_string(bench.path().join(out)).expect("a page")
    };
    let shown = page("page.html");
    assert_eq!(shown.matches("src=\"data:image/png;base64,iVBOR").count(), 3);
    assert!(shown.contains(&format!("in the mean, {largest:.3} at most")), "{shown}");
    fs::remove_dir_all(away.join("seen")).expect("removed");
    assert!(page("page.html").contains("paper-1000-drops-b.png: No such file"));
    let alone = bench.command(&["bench", "--rounds", "2", "--pictures", "seen"]).output();
    assert!(error_line(&alone.expect("it starts"), 2).contains("--pictures is for two sides"));
}

#[test]
fn what_is_no_benchmark_is_told() {
    let bench = Bench::new();
    let run = |arguments: &[&str]| {
        let all = [&["bench", "--drops", "1000"], arguments].concat();
        error_line(&bench.command(&all).output().expect("it starts"), 2)
    };
    let line = run(&["--b-binary", "/bin/true", "--a-binary", "/bin/true"]);
    assert!(line.contains("/true") && line.contains("without a result: it said nothing"), "{line}");
    assert!(run(&["--a-binary", "nowhere"]).contains("nowhere: there is no such program"));
    assert!(run(&["--a", "VK_DRIVER_FILES=/no.json"]).contains("there is no file '/no.json'"));
    assert!(run(&["--a", "A=1,A"]).contains("'A' is not NAME=VALUE"));
    assert!(run(&["--rounds", "0"]).contains("--rounds"));
    assert!(run(&["--baseline", "missing.json"]).contains("missing.json"));
    assert!(run(&["--fail-above", "5%"]).contains("--baseline"));
    let line = run(&["--a", "", "--google-benchmark", "g.json"]);
    assert!(line.contains("--google-benchmark writes one measurement"), "{line}");
}

#[test]
fn an_interrupt_leaves_nothing_behind() {
    let bench = Bench::new();
    let arguments = ["bench", "--a-binary", "program", "--drops", "9", "--json", "v.json"];
    let mut child = bench
        .command(&arguments)
        .args(["--b-binary", "program", "--a", "HANG_AT=5"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let start = Instant::now();
    let started = || fs::read_to_string(bench.path().join("started")).unwrap_or_default();
    while started().lines().count() < 5 && start.elapsed() < Duration::from_secs(600) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let number = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &number]).status().expect("kill");
    assert!(kill.success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    assert!(bench.all_have_ended());
    assert_eq!(bench.json("v.json")["stopped"], "interrupted");
}

/// deqp-runner's manner: what fails must be listed, what is listed must fail.
#[test]
fn expectations_hold_both_ways() {
    let bench = Bench::new();
    let expect = |lists: &str, more: &[&str]| {
        let text = format!("[[device]]\nmatch = \"V 1\"\nratio = 1.1\nflip = 0.01\n{lists}\n");
        fs::write(bench.path().join("e.toml"), text).expect("a file");
        let arguments =
            [&["--rounds", "6", "--expect", "e.toml", "--junit", "j.xml"], more].concat();
        let output = bench.run(&arguments);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (slow, noisy) = (["--b", "MS=12"], ["--a", "NOISY=1", "--b", "NOISY=1"]);
    let noisy_pass = ["--a", "NOISY_PASS=1", "--b", "NOISY_PASS=1"];
    let lenient = "[[device.row]]\nmatch = 'paper'\nratio = 9\n";
    let (slow_above, noisy_too) = (
        [&slow[..], &["--fail-above", "5%"]].concat(),
        [&noisy[..], &["--fail-undecided"]].concat(),
    );
    for (lists, more, status, words) in [
        ("", &[][..], 0, ""),
        ("", &slow, 1, "Fail: 1,000 drops, paper, 64 x 64: B / A is at least"),
        ("fails = ['paper']", &slow, 0, "ExpectedFail: "),
        ("fails = ['1,000 drops, paper']", &slow, 0, "ExpectedFail: "),
        ("fails = ['1000 drops, paper']", &slow, 0, "ExpectedFail: "),
        ("fails = ['paper']", &[], 1, "UnexpectedPass: "),
        // Too noisy to tell: neither a pass nor a failure, listed or not.
        ("fails = ['paper']", &noisy, 0, "Undecided: 1,000 drops, paper"),
        ("", &noisy, 0, "Undecided: 1,000 drops, paper"),
        ("flakes = ['paper']", &slow, 0, "KnownFlake: "),
        ("skips = ['paper']", &slow, 0, "Skip: "),
        // Undecided by the threshold, decided by the bound.
        ("[[device.row]]\nmatch = 'paper'\nratio = 99", &noisy_too, 0, ""),
        // A name in whole.
        ("skips = ['=1000 drops, paper, 64 x 64']", &slow, 0, "Skip: "),
        ("skips = ['=1,000 drops, paper']", &slow, 1, "no row's name is '1,000"),
        // The other options are for rows that are not listed.
        ("fails = ['paper']", &slow_above, 0, "ExpectedFail: "),
        ("skips = ['paper']", &slow_above, 0, "Skip: "),
        (lenient, &slow_above, 1, "raindrops: 1,000 drops, paper, 64 x 64 (slower)"),
        ("flakes = ['paper']", &noisy_too, 0, "Undecided: 1,000 drops, paper"),
        ("", &noisy_too, 1, "(undecided)"),
        ("[[device.row]]\nmatch = 'paper'\nratio = 1.3", &slow, 0, ""),
        // The frame is within its bound, and its pass is not.
        (
            &format!("{lenient}passes = {{ drops = 1.1 }}"),
            &slow,
            1,
            "pass drops: B / A is at least",
        ),
        (&format!("{lenient}passes = {{ drops = 1.3 }}"), &slow, 0, ""),
        (
            &format!("{lenient}passes = {{ drops = 1.1 }}"),
            &noisy,
            0,
            "Undecided: 1,000 drops, paper",
        ),
        (
            "passes = { drops = 1.1 }\n[[device.row]]\nmatch = 'paper'\nratio = 9\npasses = { drops = 1.3 }",
            &slow,
            0,
            "",
        ),
        ("passes = { drops = 1.1 }", &noisy_pass, 0, "Undecided: 1,000 drops, paper"),
        ("passes = { drips = 1.1 }", &[], 0, "no row has a pass 'drips'"),
        ("passes = { drops = nan }", &slow, 2, "NaN is no bound"),
        ("", &["--b", "MS=5"], 0, "Faster: "),
        ("fails = ['no such row']", &[], 0, "no row's name contains 'no such row'"),
        ("typo = 1", &[], 2, "e.toml:5: unknown field `typo`"),
        ("[[device.row]]\nmatch = 'paper'\nratio = nan", &slow, 2, "NaN is no bound"),
        ("error = -1", &[], 2, "-1 is no bound"),
    ] {
        let (code, stderr) = expect(lists, more);
        assert_eq!(code, Some(status), "{lists} {more:?}: {stderr}");
        assert!(stderr.contains(words), "{lists} {more:?}: {stderr}");
    }
    // A device that it does not know is told after a round, not after all.
    let other = Bench::new();
    fs::write(other.path().join("e.toml"), "[[device]]\nmatch = \"another\"\n").expect("a file");
    let output = other.run(&["--rounds", "6", "--expect", "e.toml"]);
    assert!(error_line(&output, 2).contains("no [[device]] matches"));
    assert_eq!(other.started(), 2);

    // A suite is called by its devices where they differ.
    expect("flakes = ['paper']", &["--a", "DRIVER=0"]);
    let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
    assert!(xml.contains("<testsuite name=\"D, V 1 against D, V 0\""), "{xml}");
    let (_, _) = expect("", &slow);
    let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
    let read = quick_junit::Report::deserialize_from_str(&xml).expect("JUnit");
    assert_eq!((read.tests, read.failures), (1, 1), "{xml}");
    // Nothing is known of an undecided row, listed or not.
    for lists in ["", "fails = ['paper']"] {
        expect(lists, &noisy);
        let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
        assert!(xml.contains("<skipped message=\"Undecided: neither passed nor failed"), "{xml}");
    }
    // The result has what JUnit has.
    let args = ["--rounds", "6", "--expect", "e.toml", "--json", "v.json"];
    bench.run(&[&args[..], &slow].concat());
    assert_eq!(bench.json("v.json")["rows"][0]["outcome"], "ExpectedFail");
    // What is known to fail is none, and what should have failed is one; what another option fails is one, too.
    let listed = "fails = ['paper']";
    for (lists, more, failures) in
        [(listed, &slow[..], 0), (listed, &[], 1), (lenient, &slow, 0), (lenient, &slow_above, 1)]
    {
        expect(lists, more);
        let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
        let read = quick_junit::Report::deserialize_from_str(&xml).expect("JUnit");
        assert_eq!((read.tests, read.failures), (1, failures), "{xml}");
    }
}

/// One after the other is written whole.
#[test]
fn two_runs_may_write_one_file() {
    let bench = Bench::new();
    let both = ["bench", "--a-binary", "program", "--b-binary", "program", "--drops", "1000"];
    let start = |note: &str| {
        let more = ["--rounds", "3", "--json", "v.json", "--a", note];
        let mut command = bench.command(&[&both[..], &more].concat());
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts")
    };
    let files = || fs::read_dir(bench.path()).expect("a folder").count();
    let before = files();
    for mut child in [start("N=1"), start("N=2")] {
        assert_eq!(child.wait().expect("it ends").code(), Some(0));
    }
    let label = bench.json("v.json")["a"]["label"].clone();
    assert!(["program N=1", "program N=2"].map(Value::from).contains(&label), "{label}");
    assert_eq!(files(), before + 2, "more than the result and the list of what was started");
}
