//! Comparisons in rounds of fresh processes, with a program in place of ours that takes the times it is
//! told to: verdicts, exit statuses, and processes that crash, hang or write rubbish.

#![cfg(target_os = "linux")]

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use raindrops::picture::Picture;
use serde_json::Value;
use tempfile::TempDir;

/// A program that `bench` starts: its row takes MS milliseconds, on device DEVICE, at WIDTH pixels; `render`
/// copies PICTURE. Each start leaves its number in `started`.
const PROGRAM: &str = r#"#!/bin/sh
echo $$ >> "$HERE/started"
count=$(wc -l < "$HERE/started")
while [ $# -gt 0 ]; do
  case "$1" in --json|-o) file="$2";; render) picture=1;; esac
  shift
done
if [ -n "$picture" ]; then cp "$HERE/${PICTURE:-black}.exr" "$file"; exit 0; fi
[ "$count" = "$CRASH_AT" ] && { echo "raindrops: the device is lost" >&2; exit 2; }
[ "$count" = "$HANG_AT" ] && exec sleep 600
[ "$count" = "$RUBBISH_AT" ] && { printf '{"schema": "raindrops-' > "$file"; exit 0; }
cat > "$file" <<END
{"schema": "raindrops-bench/1", "environment": "sky",
 "device": {"name": "${DEVICE:-D}", "driver": "V", "driver_info": "${DRIVER:-1}", "api_version": "1.3.0", "type": "CPU"},
 "build": {"version": "0.1.0", "commit": "unknown"}, "host": {"cpu": "C", "cores": 2, "os": "O"},
 "rows": [{"preset": "paper", "optics": "mask", "primitive": "point", "order": "unsorted", "drops": 1000,
   "visible": ${VISIBLE:-200}, "width": ${WIDTH:-64}, "height": 64, "tone_map": true, "samples_ms": [${MS:-10}],
   "median_ms": ${MS:-10}, "p10_ms": 1, "p90_ms": 1, "fps": 1, "passes": {"drops": ${MS:-10}},
   "counters": {"drops_in_view": ${VISIBLE:-200}, "tiles_done_again": $$},
   "rounds": [{"median_ms": ${MS:-10}, "passes": {"drops": ${MS:-10}, "sky": 1}}]}]}
END
"#;

/// A folder with the program and two pictures, and `bench` in it.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("program");
        fs::write(&program, PROGRAM).expect("a program");
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("its mode");
        for (name, value) in [("black", 0.1), ("white", 5.0)] {
            let pixels = vec![glam::Vec3::splat(value); 64 * 64];
            let picture = Picture { width: 64, height: 64, pixels };
            picture.write_exr(&folder.path().join(name).with_extension("exr")).expect("a picture");
        }
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = common::raindrops();
        command.current_dir(self.path()).env("HERE", self.path()).args(arguments);
        command
    }

    /// `bench` with the program on both sides.
    fn run(&self, arguments: &[&str]) -> Output {
        let both = ["bench", "--a-binary", "program", "--b-binary", "program", "--drops", "1000"];
        self.command(&[&both, arguments].concat()).output().expect("it starts")
    }

    fn json(&self, name: &str) -> Value {
        let text = fs::read_to_string(self.path().join(name)).expect("a result");
        serde_json::from_str(&text).expect("JSON")
    }

    /// None of the processes that were started is alive.
    fn all_have_ended(&self) -> bool {
        let started = fs::read_to_string(self.path().join("started")).unwrap_or_default();
        started.lines().all(|number| !Path::new("/proc").join(number).exists())
    }
}

#[track_caller]
fn error_line(output: &Output, status: i32) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{stderr}");
    let line = stderr.lines().rfind(|line| line.starts_with("raindrops: "));
    line.unwrap_or_else(|| panic!("{stderr}")).to_string()
}

#[test]
fn a_slower_side_is_slower_and_fails_the_gate() {
    let bench = Bench::new();
    let output = bench.run(&["--b", "MS=12,NOTE='a, b'", "--json", "v.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
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

    let failed = bench.run(&["--b", "MS=12", "--fail-above", "5%"]);
    assert!(error_line(&failed, 1).contains("1000 drops, paper, 64 x 64 (slower)"));
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
        ("HANG_AT=5", "it took longer than 1 s (--timeout)"),
        ("RUBBISH_AT=5", "ends in the middle, at line 1"),
    ] {
        let bench = Bench::new();
        // The fifth process is A's in the third round.
        let output = bench.run(&["--a", fault, "--timeout", "1s", "--json", "v.json"]);
        let line = error_line(&output, 2);
        assert!(line.contains(words) && line.contains(fault), "{fault}: {line}");
        let report = bench.json("v.json");
        assert_eq!(report["rows"][0]["rounds"], 2, "{fault}");
        assert_eq!(report["rows"][0]["verdict"], "undecided");
        assert!(report["stopped"].as_str().is_some_and(|why| why.contains(words)), "{fault}");
        assert!(bench.all_have_ended(), "{fault}: a process is left");
    }
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
    while started().lines().count() < 5 && start.elapsed() < Duration::from_secs(60) {
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
    let slow = ["--b", "MS=12"];
    for (lists, more, status, words) in [
        ("", &[][..], 0, ""),
        ("", &slow, 1, "Fail: 1000 drops, paper, 64 x 64: the least ratio"),
        ("fails = ['paper']", &slow, 0, "ExpectedFail: "),
        ("fails = ['paper']", &[], 1, "UnexpectedPass: "),
        ("flakes = ['paper']", &slow, 0, "KnownFlake: "),
        ("skips = ['paper']", &slow, 0, "Skip: "),
        ("[[device.row]]\nmatch = 'paper'\nratio = 1.3", &slow, 0, ""),
        ("", &["--b", "MS=5"], 0, "Faster: "),
        ("fails = ['no such row']", &[], 0, "no row's name contains 'no such row'"),
        ("typo = 1", &[], 2, "e.toml:5: unknown field `typo`"),
    ] {
        let (code, stderr) = expect(lists, more);
        assert_eq!(code, Some(status), "{lists} {more:?}: {stderr}");
        assert!(stderr.contains(words), "{lists} {more:?}: {stderr}");
    }
    let (_, _) = expect("", &slow);
    let xml = fs::read_to_string(bench.path().join("j.xml")).expect("a file");
    let read = quick_junit::Report::deserialize_from_str(&xml).expect("JUnit");
    assert_eq!((read.tests, read.failures), (1, 1), "{xml}");
}

/// Ten rounds of the program as a file.
fn kept(bench: &Bench, name: &str, variables: &[(&str, &str)]) {
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
fn kept_results_are_compared() {
    let bench = Bench::new();
    kept(&bench, "base.json", &[]);
    kept(&bench, "slow.json", &[("MS", "12"), ("DEVICE", "E"), ("DRIVER", "2")]);
    kept(&bench, "wide.json", &[("WIDTH", "65")]);
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
    assert!(report["notes"].to_string().contains("the driver is V 1 in A, V 2 in B"));
    let output = verdict(&["base.json", "base.json", "--fail-above", "5%"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).contains("same"));
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
    let line = error_line(&verdict(&["base.json", "wide.json"]), 2);
    assert!(line.contains("the size is 64 x 64 in base.json, 65 x 64 in wide.json"), "{line}");
    // Runs of one side are of one device.
    let line = error_line(&verdict(&["base.json,slow.json", "base.json"]), 2);
    assert!(line.contains("the device is D in base.json, E in slow.json"), "{line}");
    fs::write(bench.path().join("empty.json"), "").expect("a file");
    let line = error_line(&verdict(&["base.json", "empty.json"]), 2);
    assert!(line.contains("empty.json: it is empty"), "{line}");
}
