//! Results in the formats of others, read by readers that nobody here wrote. Some of them are programs that a
//! machine may lack: `pip install junitparser OpenEXR numpy pillow` in a `python3 -m venv`; Debian's `libbenchmark-tools` with `python3-scipy`, and
//! `openimageio-tools`. Their tests then say so past the test harness, which would hide it.

#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use crate::common::stand_in::Bench;
use crate::common::{folder, outcome, raindrops};
use glam::Vec3;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use raindrops::picture::Picture;
use serde_json::Value;

/// google/benchmark's own comparison of two results, as Debian has it.
const COMPARE: &str = "/usr/share/benchmark/compare.py";

fn skip(what: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {what}");
}

/// A Python that has modules, such as `OpenEXR, numpy`; none if there is none.
fn python(modules: &str) -> Option<Command> {
    let program = std::env::var("RAINDROPS_TEST_PYTHON").unwrap_or("python3".into());
    let has = Command::new(&program).args(["-c", &format!("import {modules}")]).output();
    has.is_ok_and(|output| output.status.success()).then(|| Command::new(program))
}

/// What a program prints.
fn printed(command: &mut Command) -> String {
    let output = outcome(command);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn junit_is_read_by_junitparser() {
    const SCRIPT: &str = "
import sys, junitparser
for suite in junitparser.JUnitXml.fromfile(sys.argv[1]):
    for case in suite:
        what = [type(result).__name__ for result in case.result]
        print(suite.name, suite.tests, suite.failures, suite.skipped, case.name, what, case.result[0].message if what else '')
";
    let bench = Bench::new();
    let file = bench.path().join("j.xml");
    let read = |arguments: &[&str]| {
        bench.run(&[&["--rounds", "6", "--junit", "j.xml"], arguments].concat());
        Some(printed(python("junitparser")?.args(["-c", SCRIPT]).arg(&file)))
    };
    let Some(slower) = read(&["--b", "MS=12,NOTE='<&>'"]) else {
        return skip("the Python package junitparser is not there");
    };
    assert!(
        slower.contains(
            "MS=12 NOTE=<&> against program 1 1 0 1,000 drops, paper, 64 x 64 ['Failure']"
        ),
        "{slower}"
    );
    assert!(slower.contains("slower: B / A 1.200 (1.200 to 1.200), 6 rounds"), "{slower}");
    assert!(read(&[]).is_some_and(|same| same.contains(" 1 0 0 1,000 drops, paper, 64 x 64 []")));
    // What is known to fail does not fail again.
    let lists = "[[device]]\nmatch = \"V 1\"\nratio = 1.1\nfails = [\"paper\"]\n";
    fs::write(bench.path().join("e.toml"), lists).expect("a file");
    let known = read(&["--b", "MS=12", "--expect", "e.toml"]).expect("text");
    assert!(
        known.contains(" 1 0 1 1,000 drops") && known.contains("['Skipped'] ExpectedFail: "),
        "{known}"
    );
    let passes = read(&["--expect", "e.toml"]).expect("text");
    assert!(passes.contains("['Failure'] UnexpectedPass: take it from the fails"), "{passes}");
}

#[test]
fn google_benchmarks_own_tool_compares_our_results() {
    let folder = folder();
    let file = folder.path().join("g.json");
    let quick = ["--drops", "100", "--size", "32x32", "--seconds", "0.01", "--frames", "1"];
    let output = outcome(
        crate::common::raindrops()
            .args(["bench", "--preset", "paper", "--rounds", "3", "--google-benchmark"])
            .arg(&file)
            .args(quick),
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found = Command::new("/usr/bin/python3").args(["-c", "import scipy"]).output();
    if !Path::new(COMPARE).exists() || !found.is_ok_and(|output| output.status.success()) {
        return skip("google/benchmark's compare.py or its scipy is not there");
    }
    let compare = outcome(
        Command::new("/usr/bin/python3")
            .args([COMPARE, "--no-color", "benchmarks"])
            .args([&file, &file]),
    );
    let text = String::from_utf8_lossy(&compare.stdout);
    assert!(compare.status.success(), "{}", String::from_utf8_lossy(&compare.stderr));
    // A line a repetition and one of the medians, of the row with the tone map and of that without.
    let lines = |name: &str| text.lines().filter(|line| line.starts_with(name)).count();
    assert_eq!(lines("100 drops, paper, 32 x 32 "), 3, "{text}");
    assert_eq!(lines("100 drops, paper, 32 x 32, no tone map "), 3, "{text}");
    assert_eq!(lines("100 drops, paper, 32 x 32_median"), 1, "{text}");
    assert!(text.contains("+0.0000"), "{text}");
}

/// A benchmark's rows are the same as lines of CSV and as JSON.
#[test]
fn a_benchmark_as_csv_has_the_figures_of_its_json() {
    let folder = folder();
    let file = folder.path().join("b.json");
    let quick = ["--drops", "100", "--size", "32x32", "--seconds", "0.01", "--frames", "1"];
    let output =
        outcome(raindrops().args(["bench", "--format", "csv", "--json"]).arg(&file).args(quick));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(file).expect("figures");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let mut reader = csv::Reader::from_reader(output.stdout.as_slice());
    let header = reader.headers().expect("a header").clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 2);
    for (number, row) in rows.iter().enumerate() {
        for name in ["drops", "visible", "width", "median_ms", "p10_ms", "p90_ms", "fps"] {
            let at = header.iter().position(|other| other == name).expect(name);
            assert_eq!(row[at].parse::<f64>().ok(), json["rows"][number][name].as_f64(), "{name}");
        }
        assert_eq!(row[0], *json["device"]["name"].as_str().expect("a name"));
    }
}

#[test]
fn csv_is_read_by_the_csv_crate() {
    let bench = Bench::new();
    let output =
        bench.run(&["--rounds", "6", "--b", "MS=12", "--format", "csv", "--json", "v.json"]);
    let mut reader = csv::Reader::from_reader(output.stdout.as_slice());
    let header = reader.headers().expect("a header").clone();
    let rows: Vec<csv::StringRecord> =
        reader.records().map(|row| row.expect("as many cells as names")).collect();
    // The frame, and its two passes.
    assert_eq!(rows.len(), 3);
    let at = |name: &str| header.iter().position(|other| other == name).expect(name);
    let json = &bench.json("v.json")["rows"][0];
    for (row, of) in rows.iter().zip([json, &json["passes"]["drops"], &json["passes"]["sky"]]) {
        assert_eq!(Value::from(&row[at("verdict")]), of["verdict"]);
        for name in ["ratio", "ratio_low", "ratio_high", "median_ms_a", "median_ms_b"] {
            assert_eq!(row[at(name)].parse::<f64>().ok(), of[name].as_f64(), "{name}");
        }
    }
}

#[test]
fn markdown_is_a_table_for_commonmarks_readers() {
    let bench = Bench::new();
    let output = bench.run(&["--rounds", "6", "--b", "MS=12,NOTE='a|b'", "--format", "markdown"]);
    let text = String::from_utf8(output.stdout).expect("text");
    let (mut rows, mut items) = (Vec::new(), 0);
    for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::TableHead | Tag::TableRow) => rows.push(Vec::new()),
            Event::Start(Tag::TableCell) => rows.last_mut().expect("a row").push(String::new()),
            Event::Text(part) if !rows.is_empty() => {
                if let Some(cell) = rows.last_mut().and_then(|row| row.last_mut()) {
                    cell.push_str(&part);
                }
            }
            Event::End(TagEnd::Item) => items += 1,
            _ => {}
        }
    }
    assert!(rows.len() == 2 && rows[0].len() == rows[1].len(), "{rows:?}");
    assert_eq!((rows[0][0].as_str(), rows[0][1].as_str()), ("row", "verdict"));
    assert_eq!(
        (rows[1][0].as_str(), rows[1][1].as_str()),
        ("1,000 drops, paper, 64 x 64", "slower")
    );
    assert!(items >= 3, "who is compared, and how to read it: {text}");
}

/// However many devices there are, each is compared with each; with one alone there is nothing to compare.
#[test]
fn each_device_is_compared_with_each() {
    let folder = folder();
    let compare = |devices: &str| {
        let arguments =
            ["compare-devices", "--drops", "50", "--size", "32x24", "--mask-size", "64"];
        let quick = ["--seconds", "0", "--frames", "1", "--rounds", "1"];
        let more = ["--json", "a.json", "--max-flip", "0.05", "--pictures", "seen"];
        let mut command = raindrops();
        command.current_dir(folder.path()).args(arguments).args(quick).args(more);
        let output = outcome(command.env("RAINDROPS_DEVICE", devices));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let file = folder.path().join("a.json");
    let (status, said) = compare("0");
    let error = said.lines().last().unwrap_or_default();
    assert!(
        status == Some(2) && error.contains("is the only device that is there or selected, and"),
        "{said}"
    );
    assert!(!file.exists());
    let (status, said) = compare("0,00");
    assert!(status == Some(2) && said.contains("'0' and '00' are both"), "{said}");
    let (status, said) = compare("0,0,0");
    assert_eq!(status, Some(0), "{said}");
    // The page has all of it: the devices, the stages of each pair, the verdicts.
    let mut command = raindrops();
    command.current_dir(folder.path()).args(["report", "a.json", "-o", "page.html"]);
    printed(&mut command);
    let page = fs::read_to_string(folder.path().join("page.html")).expect("a page");
    let count_of = |text: &str| page.matches(text).count();
    assert_eq!((count_of("<h2>Verdict: "), count_of(", drawn by preset paper: no stage")), (2, 3));
    assert_eq!((count_of("<li>footprint "), count_of("<td>0.00000</td>")), (3, 9 + 4));
    // What was measured is judged again: a device is itself, and one round decides nothing.
    let judged = |file: &str, bounds: &[&str]| {
        let mut command = raindrops();
        command.current_dir(folder.path()).args(["verdict", file, "--json", "again.json"]);
        let output = outcome(command.args(bounds));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, said) = judged("a.json", &["--fail-above", "5%", "--fail-undecided"]);
    assert!(status == Some(1) && said.contains("(undecided)"), "{said}");
    assert_eq!(judged("a.json", &["--fail-above", "1000%", "--max-flip", "0"]).0, Some(0));
    let again = fs::read_to_string(folder.path().join("again.json")).expect("a file");
    let again: Value = serde_json::from_str(&again).expect("JSON");
    let figures = fs::read_to_string(file).expect("figures");
    let figures: Value = serde_json::from_str(&figures).expect("JSON");
    assert_eq!((&again["devices"], &again["pairs"]), (&figures["devices"], &figures["pairs"]));
    assert_eq!(again["verdicts"][1]["verdict"]["threshold"], 10.0);
    // The second and the third may be apart where neither is from the first.
    let mut apart = figures.clone();
    apart["devices"][1]["flip"][2] = 0.5.into();
    apart["devices"][1]["rel_mse"][2] = Value::Null;
    apart["verdicts"][1]["verdict"]["rows"][0]["flip_between"] = 0.5.into();
    fs::write(folder.path().join("apart.json"), apart.to_string()).expect("a file");
    let (status, said) = judged("apart.json", &["--max-flip", "0.4"]);
    assert!(status == Some(1) && said.contains("two drivers are FLIP 0.50000 apart"), "{said}");
    let note = "without --fail-above a different row does not change the exit status";
    assert!(!said.contains(note) && judged("apart.json", &[]).1.contains(note), "{said}");
    assert_eq!(judged("apart.json", &["--max-flip", "0.6"]).0, Some(0));
    // One that did not end is not judged.
    apart["verdicts"].as_array_mut().expect("verdicts").pop();
    fs::write(folder.path().join("apart.json"), apart.to_string()).expect("a file");
    let (status, said) = judged("apart.json", &[]);
    assert!(status == Some(2) && said.contains("1 of 2 devices have a verdict"), "{said}");
    let count = |key: &str| figures[key].as_array().map(Vec::len);
    // Each verdict compares a device with the first.
    assert_eq!((count("devices"), count("pairs"), count("verdicts")), (Some(3), Some(3), Some(2)));
    assert_eq!(figures["devices"][0]["flip"][0], 0.0);
    let of_second = &figures["verdicts"][1]["verdict"];
    let undecided = of_second["rows"].as_array().map(Vec::len);
    assert_eq!(of_second["counts"]["undecided"].as_u64().map(|n| n as usize), undecided);
    let pictures = &of_second["rows"][0]["pictures"];
    assert_eq!(pictures["b"], "seen/device-2-b.png", "{pictures}");
    for key in ["a", "b", "difference"] {
        let file = folder.path().join(pictures[key].as_str().expect("a file"));
        assert_eq!(Picture::read(&file).expect("a picture").width, 32);
    }
    assert!(figures["devices"][0]["median_ms"].as_f64() > Some(0.0));
}

/// A device with itself, named by a variable: a verdict on each row, the same as JSON and as CSV.
#[test]
fn devices_are_compared_as_csv_and_as_json() {
    let compared = |more: &[&str]| {
        let arguments =
            ["compare-devices", "--drops", "50", "--size", "32x24", "--mask-size", "64"];
        let quick = ["--seconds", "0", "--frames", "1", "--rounds", "1"];
        let mut command = raindrops();
        let output =
            outcome(command.args(arguments).args(quick).args(more).env("RAINDROPS_DEVICE", "0,0"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let json: Value =
        serde_json::from_slice(&compared(&["--json", "-"])).expect("nothing but JSON");
    assert_eq!(json["devices"].as_array().map(Vec::len), Some(2));
    let verdict = &json["verdicts"][0]["verdict"];
    assert_eq!(verdict["schema"], "raindrops-verdict/1");
    let rows = verdict["rows"].as_array().expect("rows");
    let is_same = |row: &Value| row["flip_between"].as_f64() < Some(1e-3);
    assert!(rows.len() == 2 && rows.iter().all(is_same), "{verdict}");
    let lines = compared(&["--format", "csv"]);
    let mut reader = csv::Reader::from_reader(lines.as_slice());
    let header = reader.headers().expect("a header").clone();
    let at = |name: &str| header.iter().position(|other| other == name).expect(name);
    let frames: Vec<csv::StringRecord> = reader
        .records()
        .map(|row| row.expect("a row"))
        .filter(|row| row[at("pass")].is_empty())
        .collect();
    assert_eq!(frames.len(), rows.len(), "{frames:?}");
    for (frame, row) in frames.iter().zip(rows) {
        assert!(
            frame[at("a")] == frame[at("b")] && row["verdict"] == frame[at("verdict")],
            "{frame:?}"
        );
    }
}

/// Layers have the channels that they say, and over their plate are the picture before it, by OpenImageIO's own tool.
#[test]
fn layers_are_composited_by_oiiotool() {
    if !Command::new("oiiotool").arg("--help").output().is_ok_and(|ran| ran.status.success()) {
        return skip("oiiotool (Debian's openimageio-tools) is not there");
    }
    let folder = folder();
    let folder = folder.path();
    let scene = "[image]\nwidth = 48\nheight = 32\n[camera]\nvertical_fov = 40.0\n[rain]\nrate = 100.0\nextent = 60.0\n\
                 [model]\npreset = \"fast\"\n[background]\ncolor = \"plate.exr\"\n[[drop]]\ncenter = [0.0, 0.0, -1.0]\nradius = 0.1\n";
    fs::write(folder.join("scene.toml"), scene).expect("a scene");
    let pixels = (0..48 * 32).map(|at| Vec3::new((at % 7) as f32, (at % 5) as f32, 2.0)).collect();
    let plate = Picture { width: 48, height: 32, pixels };
    plate.write_exr(&folder.join("plate.exr")).expect("a plate");
    let draw = |arguments: &[&str]| {
        let ran =
            outcome(raindrops().current_dir(folder).args(["render", "scene.toml"]).args(arguments));
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    };
    draw(&["-o", "before.exr"]);
    draw(&["--layers", "-o", "rain.exr"]);
    let oiiotool = |arguments: &str| {
        let ran = outcome(Command::new("oiiotool").current_dir(folder).args(arguments.split(' ')));
        (ran.status.success(), String::from_utf8(ran.stdout).expect("text"))
    };
    let (_, said) = oiiotool("--info -v rain.exr");
    let channels = "R (half), G (half), B (half), A (half), Z (float), count (uint), id (uint), id_high (uint), \
                    motion.X (half), motion.Y (half)";
    assert!(said.contains(channels), "{said}");
    // Three roundings to float16 of values up to 6.
    let is_alike = |picture: &str| {
        oiiotool(&format!("{picture} --ch R,G,B before.exr --ch R,G,B --fail 0.02 --diff"))
    };
    let over = "rain.exr --ch R,G,B,A plate.exr --ch R,G,B,A=1 --over";
    let (alike, said) = is_alike(over);
    println!("{said}");
    assert!(alike, "{said}");
    // The control: the plate alone.
    assert!(!is_alike("plate.exr").0);
}

/// The lines of docs/data-set.md that load a set, with a check after them in the loop: by OpenEXR's own binding and numpy.
#[test]
fn a_data_set_is_loaded_by_the_python_of_its_page() {
    let Some(mut python) = python("OpenEXR, numpy") else {
        return skip("the Python packages OpenEXR and numpy are not there");
    };
    const CHECK: &str = "
    assert image.shape == target.shape == (3, 32, 48), image.shape
    assert mask.shape == depth.shape == (32, 48) and motion.shape == (2, 32, 48)
    assert np.isfinite(depth[layers['id'] != 0]).all() and (depth[layers['id'] == 0] == np.inf).all()
    assert (motion[1, layers['id'] != 0] > 0).any()
    assert layers['id'].dtype == layers['count'].dtype == np.uint32
    over = np.stack([layers[c] for c in 'RGB']).astype(float) + (1 - layers['A'].astype(float)) * target
    assert np.abs(over - image).max() < 0.002 * image.max(), np.abs(over - image).max()
    print(view['view'], view['covered_pixels'] == np.count_nonzero(mask), mask.any())
";
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/data-set.md"));
    let page = page.expect("the page");
    let (_, script) = page.split_once("```python\n").expect("its lines of Python");
    let (script, _) = script.split_once("```").expect("their end");
    assert!(script.lines().filter(|line| !line.trim().is_empty()).count() <= 10, "{script}");
    let folder = folder();
    let folder = folder.path();
    let scene = "[image]\nwidth = 48\nheight = 32\n[camera]\nvertical_fov = 40.0\n[rain]\nrate = 100.0\nextent = 60.0\n\
                 [model]\npreset = \"fast\"\n[[drop]]\ncenter = [0.0, 0.0, -1.0]\nradius = 0.1\n\
                 velocity = [0.0, -1.0, 0.0]\n";
    fs::write(folder.join("plate.toml"), scene).expect("a scene");
    let dataset =
        ["dataset", "plate.toml", "--rates", "50,200", "--turn", "0", "--views", "2", "-o", "set"];
    printed(raindrops().current_dir(folder).args(dataset));
    let said = printed(python.current_dir(folder).args(["-c", &(script.to_string() + CHECK)]));
    assert_eq!(said, "0 True True\n1 True True\n");
}

/// The blocks of a language in a document.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let start = format!("```{language}\n");
    let starts = page.split(&start).skip(1);
    starts.map(|rest| rest.split_once("```").expect("its end").0.to_string()).collect()
}

/// Everything that docs/data-set.md and then docs/collection.md say in Python, one block after the other as its reader runs them, with its scene and
/// its commands for a mask, of one view.
#[test]
fn the_data_sets_page_is_run_from_top_to_bottom() {
    let Some(mut python) = python("OpenEXR, numpy, PIL") else {
        return skip("the Python packages OpenEXR, numpy and pillow are not there");
    };
    let pages = ["docs/data-set.md", "docs/collection.md"].map(|page| {
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(page)).expect("the page")
    });
    let page = pages.concat();
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("plate.toml"), &blocks(&page, "toml")[0]).expect("a scene");
    fs::create_dir(folder.join("photos")).expect("a folder");
    for photo in ["photo.exr", "place.exr", "photos/one.png", "photos/two.png"] {
        let dry = ["render", "plate.toml", "--drops", "0", "-o", photo];
        printed(raindrops().current_dir(folder).args(dry));
    }
    let program = Path::new(env!("CARGO_BIN_EXE_raindrops")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    for section in ["## A data set", "### A mask with a shutter"] {
        let (_, rest) = page.split_once(&format!("\n{section}\n")).expect("the section");
        let (_, commands) = rest.split_once("```\n").expect("its commands");
        let (commands, _) = commands.split_once("```").expect("their end");
        let commands = commands.replace("--views 10", "--views 1");
        let mut shell = Command::new("sh");
        printed(shell.current_dir(folder).env("PATH", &path).args(["-e", "-c", &commands]));
    }
    let [load, masks, photos, pictures, wide, depth, panorama] = &blocks(&page, "python")[..]
    else {
        panic!("the page has other blocks of Python");
    };
    const METRES: &str = "
metres = np.full((360, 640), 20.0)
metres[0] = np.inf
";
    const CHECK: &str = "
single = layers['count'] > 0
print(f'{rain.mean():.3f} {seen.mean():.3f} {(opacity < -0.05).mean():.3f} {single.mean():.3f}')
print(*sorted(path.name for path in pathlib.Path('sets/one').rglob('*.png')))
print(np.abs(np.array(Image.open('sets/one/plate/clean.png')).astype(int) - np.array(Image.open('photos/one.png'))).max())
print(np.array(Image.open('opacity-16.png')).max() == round(65535 * float(opacity.max())))
print(abs(read('panorama.exr')['R'].mean() / panorama['R'].mean() - factor) < 1e-3)
";
    let script = [load, masks, photos, pictures, wide, METRES, depth, panorama, CHECK].concat();
    let said = printed(python.current_dir(folder).env("PATH", &path).args(["-c", &script]));
    let all: Vec<&str> = said.lines().collect();
    let (told, lines) = all.split_at(all.len().saturating_sub(5));
    let shares: Vec<f64> = lines[0].split(' ').filter_map(|share| share.parse().ok()).collect();
    let [rain, seen, below, single] = shares[..] else { panic!("{said}") };
    assert!((0.01..0.3).contains(&rain) && seen > 0.0 && below == 0.0, "{said}");
    assert!(single < 0.1 * rain, "streaks of one colour have no count: {said}");
    assert_eq!(
        lines[1..],
        ["clean.png opacity.png rain.png rainy.png seen.png", "0", "True", "True"]
    );
    // The remark comes once for two photographs.
    assert_eq!(told.iter().filter(|line| line.contains("streaks and discs")).count(), 1, "{said}");
    for depth in [&["depth.exr"][..], &["depth.png", "--depth-scale", "0.01"]] {
        let arguments = ["render", "plate.toml", "--background", "photo.exr", "-o", "rainy.exr"];
        printed(raindrops().current_dir(folder).args(arguments).arg("--depth").args(depth));
    }
}
