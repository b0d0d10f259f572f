//! What the documents show of measurements: figures are those of the result files, pictures say what made them, and the
//! passes and models in them are the program's.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use raindrops::measure::tradeoff::{models, models_of_rain};
use raindrops::plan::Output;
use raindrops::scene::model::Preset;
use serde_json::Value;

use super::{between, documents, passes, root};

/// The cells of a row of a Markdown table, without marks of type.
fn cells(line: &str) -> Vec<&str> {
    line.trim()
        .trim_matches('|')
        .split('|')
        .map(|cell| cell.trim().trim_matches(['*', '`']))
        .collect()
}

fn number(text: &str) -> Option<f64> {
    text.replace(',', "").parse().ok()
}

/// Whether a rate in frames a second is `milliseconds`' or that which stands there, as it is written.
fn is_rate(fps: f64, cell: f64) -> bool {
    (fps - cell).abs() < 1e-9 || (fps - 1000.0 / cell).abs() <= 0.051 + 50.0 / (cell * cell)
}

/// A link to a result among the README's text after `from`, and the commit that it names beside it.
fn result_after(readme: &str, from: &str, end: &str) -> (PathBuf, String) {
    let (_, rest) = readme.split_once(from).unwrap_or_else(|| panic!("no '{from}'"));
    let link = between(rest, "](", ')').into_iter().find(|link| link.contains("docs/results/"));
    let (_, commit) = rest.split_once("commit ").expect("a commit");
    let commit = commit.split(|c: char| !c.is_ascii_hexdigit()).next().expect("its digits");
    assert!(commit.len() >= 7, "{commit}");
    let path = root().join(link.expect("a link to a result"));
    (path.with_extension(end), commit.into())
}

#[test]
fn the_readmes_table_ii_is_in_the_results() {
    let readme = fs::read_to_string(root().join("README.md")).expect("README");
    let (path, commit) = result_after(&readme, "scripts/bench.sh --preset paper,fast", "md");
    let page = fs::read_to_string(&path).expect("the result");
    assert!(page.contains(&commit), "{}: no commit {commit}", path.display());
    let mut rows = 0;
    for line in readme.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [preset @ ("paper" | "fast"), drops, in_view, mapped, plain, ms] = words[..] else {
            continue;
        };
        let of_row = |line: &&str| {
            let cells = cells(line);
            let others = ["paper", "fast"].into_iter().filter(|other| *other != preset);
            [drops, in_view, ms].iter().all(|word| cells.contains(word))
                && !others.into_iter().any(|other| cells.contains(&other))
        };
        let found =
            page.lines().find(of_row).unwrap_or_else(|| panic!("{}: no '{line}'", path.display()));
        let rate = |text: &str| number(text).expect("a rate");
        assert!(is_rate(rate(mapped), rate(ms)), "{line}");
        let figures = cells(found).into_iter().filter_map(number);
        assert!(figures.into_iter().any(|cell| is_rate(rate(plain), cell)), "{line}: {found}");
        rows += 1;
    }
    assert!(rows >= 4, "{rows} rows");
}

/// The plot of the README says each preset's time and error, and the noise of the truth.
#[test]
fn the_readmes_plot_is_of_the_results() {
    let (_, result) = tradeoff();
    let svg = fs::read_to_string(root().join("docs/pictures/presets.svg")).expect("the plot");
    let texts = between(&svg, "<text", '<').into_iter().filter_map(|text| text.split_once('>'));
    let texts: Vec<&str> = texts.map(|(_, text)| text).collect();
    let rows = result["rows"].as_array().expect("rows");
    for preset in ["paper", "fast", "exact", "auto"] {
        let row = rows.iter().find(|row| row["scene"] == "far" && row["model"] == preset);
        let row = row.unwrap_or_else(|| panic!("no row of {preset}"));
        let figure = |key: &str| row[key].as_f64().expect("a figure");
        let start = format!("{preset}: ");
        let shown = texts.iter().find_map(|text| text.strip_prefix(&start));
        let shown = shown.unwrap_or_else(|| panic!("the plot does not show {preset}"));
        let (ms, rms) = shown.split_once(" ms, ").expect("a time and an error");
        assert_eq!(number(ms), Some(figure("median_ms").round()), "{preset}");
        assert_eq!(rms, format!("{:.1}", 255.0 * figure("rms")), "{preset}");
    }
    let noise = result["noise"].as_array().expect("noise").iter().find(|of| of["scene"] == "far");
    let noise = 255.0 * noise.expect("the scene's")["rms"].as_f64().expect("a figure");
    let shown = texts.iter().find_map(|text| text.strip_prefix("noise of the reference "));
    assert!(shown.is_some_and(|shown| shown.starts_with(&format!("{noise:.1}:"))), "{shown:?}");
    let built = result["build"]["commit"].as_str().expect("a commit");
    let device = format!("commit {}", &built[..7]);
    assert!(texts.iter().any(|text| text.ends_with(&device)), "{texts:?}");
}

#[test]
fn every_picture_is_shown() {
    let all: String = documents().into_iter().map(|(_, text)| text).collect();
    for entry in fs::read_dir(root().join("docs/pictures")).expect("pictures") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        if name == "made.txt" {
            continue;
        }
        assert!(all.contains(&format!("pictures/{name})")), "no document shows {name}");
    }
}

/// What `docs/pictures/made.txt` says of each picture, and the passes that the window's picture shows.
fn made() -> (BTreeMap<String, String>, String) {
    let text = fs::read_to_string(root().join("docs/pictures/made.txt")).expect("made.txt");
    let (shown, lines): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with("passes of window.png: "));
    let lines = lines.into_iter().filter_map(|line| line.split_once(' '));
    let of_picture = lines.map(|(picture, by)| (picture.into(), by.trim().into())).collect();
    (of_picture, shown.concat().replace("passes of window.png: ", ""))
}

#[test]
fn every_picture_says_what_made_it() {
    let (made, _) = made();
    let mut there = BTreeSet::new();
    for entry in fs::read_dir(root().join("docs/pictures")).expect("pictures") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        if name == "made.txt" {
            continue;
        }
        let by =
            made.get(&name).unwrap_or_else(|| panic!("made.txt does not say what made {name}"));
        let script = by.split_whitespace().next().expect("a script");
        if script != "drawn" {
            let text = fs::read_to_string(root().join(script)).expect("a script");
            let step = by.split_whitespace().nth(1).filter(|_| script.ends_with("figures.sh"));
            let step = step.map(|step| format!("\n{}() {{", step.replace('-', "_")));
            assert!(
                step.is_none_or(|step| text.contains(&step)),
                "{name}: {script} has no such step"
            );
            let digits =
                |word: &&str| word.len() >= 12 && word[..12].chars().all(|c| c.is_ascii_hexdigit());
            assert!(by.split_whitespace().any(|word| digits(&word)), "{name}: by no commit: {by}");
        }
        there.insert(name);
    }
    let named: BTreeSet<String> = made.into_keys().collect();
    assert_eq!(named, there, "left: made.txt; right: docs/pictures");
}

#[test]
fn pictures_and_results_show_the_programs_passes() {
    let (_, window) = made();
    let fast = passes(Preset::Fast, Output::Display);
    assert_eq!(
        window.split(", ").collect::<Vec<_>>(),
        fast,
        "left: window.png; scripts/figures.sh window"
    );
    let known: BTreeSet<&str> = [Preset::Paper, Preset::PaperCompact, Preset::Fast, Preset::Exact]
        .into_iter()
        .flat_map(|preset| passes(preset, Output::Display))
        .collect();
    let svg = fs::read_to_string(root().join("docs/pictures/passes.svg")).expect("passes.svg");
    let texts = between(&svg, "<text", '<').into_iter().filter_map(|text| text.split_once('>'));
    let legend: Vec<&str> =
        texts.map(|(_, text)| text).take_while(|text| !text.contains("drops")).collect();
    assert!(legend.len() > 4, "{legend:?}");
    for name in legend {
        assert!(
            known.contains(name),
            "passes.svg shows a pass {name}; scripts/results.sh makes it"
        );
    }
    // Tables of results: each preset's passes.
    let mut columns = 0;
    for (path, text) in documents() {
        for line in
            text.lines().filter(|line| line.contains(": ms of ") && line.contains(" all drops "))
        {
            for name in cells(line).into_iter().skip_while(|name| *name != "all drops").skip(1) {
                assert!(known.contains(name), "{}: a pass {name}", path.display());
                columns += 1;
            }
        }
    }
    assert!(columns > 10, "{columns} columns");
}

/// The result that the README links to.
fn tradeoff() -> (PathBuf, Value) {
    let readme = fs::read_to_string(root().join("README.md")).expect("README");
    let (path, commit) = result_after(&readme, "## Time against error", "json");
    let text = fs::read_to_string(&path).expect("the result");
    let result: Value = serde_json::from_str(&text).expect("JSON");
    let built = result["build"]["commit"].as_str().expect("a commit");
    assert!(built.starts_with(&commit), "README: commit {commit}; {}: {built}", path.display());
    (path, result)
}

#[test]
fn the_tradeoffs_page_is_of_its_result_and_of_models_that_are_there() {
    let (path, result) = tradeoff();
    let rows = result["rows"].as_array().expect("rows");
    let known: BTreeSet<String> =
        models().into_iter().chain(models_of_rain()).map(|model| model.name).collect();
    let page = fs::read_to_string(path.with_extension("md")).expect("the page");
    let (mut scenes, mut found) = (Vec::new(), 0);
    for line in page.lines().filter(|line| line.starts_with('|')) {
        let row = cells(line);
        if row[0] == "speed / rms" {
            scenes = row[1..].to_vec();
        } else if row.len() == scenes.len() + 1 && row[0] == "noise" {
            for (scene, cell) in scenes.iter().zip(&row[1..]) {
                let all = result["noise"].as_array().expect("noise");
                let of = all.iter().find(|of| of["scene"] == *scene).expect("the scene's");
                let rms = 255.0 * of["rms"].as_f64().expect("a figure");
                assert_eq!(*cell, format!("/ {rms:.2}"), "noise in {scene}");
            }
        } else if row.len() == scenes.len() + 1 && !row[0].starts_with('-') {
            assert!(known.contains(row[0]), "the program has no model {}", row[0]);
            for (scene, cell) in scenes.iter().zip(&row[1..]) {
                let of = rows.iter().find(|of| of["scene"] == *scene && of["model"] == row[0]);
                let of = of.unwrap_or_else(|| panic!("no row of {} in {scene}", row[0]));
                let figure = |key: &str| of[key].as_f64().expect("a figure");
                let is = format!("{:.2} / {:.2}", figure("speed"), 255.0 * figure("rms"));
                assert_eq!(*cell, is, "{} in {scene}", row[0]);
                found += 1;
            }
        }
    }
    assert_eq!(found, rows.iter().filter(|row| row["speed"].is_number()).count());
    let built = result["build"]["commit"].as_str().expect("a commit");
    for notes in page.lines().filter_map(|line| line.strip_prefix("## Notes on commit ")) {
        assert!(built.starts_with(notes), "notes on {notes}, the result is of {built}");
    }
}

/// What `docs/method.md` ("What the trade-off shows") and `docs/paper.md` say of it.
#[test]
fn what_is_said_of_the_tradeoff_holds() {
    let (_, result) = tradeoff();
    let rows = result["rows"].as_array().expect("rows");
    let of = |scene: &str, model: &str| -> (f64, f64) {
        let row = rows.iter().find(|row| row["scene"] == scene && row["model"] == model);
        let row = row.unwrap_or_else(|| panic!("no row of {model} in {scene}"));
        let figure = |key: &str| row[key].as_f64().expect("a figure");
        (figure("speed"), 255.0 * figure("rms"))
    };
    for scene in ["close-up", "near", "far", "sun", "low range", "pan"] {
        let (_, paper) = of(scene, "paper");
        for model in ["paper mask-f32", "paper mask-snorm16", "paper fresnel schlick"] {
            assert!(
                (of(scene, model).1 - paper).abs() < 0.1,
                "{scene}: {model} is another picture"
            );
        }
        let (fast, exact) = (of(scene, "fast"), of(scene, "exact"));
        assert!(exact.1 < fast.1 || scene == "sun", "{scene}: exact is truer than fast");
        assert!(exact.1 < 1.1 * fast.1, "{scene}: exact is not a tenth worse than fast");
        assert!(exact.0 < 1.0 / 7.0, "{scene}: exact takes at least seven times as long as paper");
        let (least, most_error) = match scene {
            "far" => (30.0, 0.5),
            "sun" | "low range" => (12.5, 0.7),
            "pan" => (1.5, 0.5),
            _ => (1.0, 0.5),
        };
        assert!(fast.0 > least, "{scene}: fast is {least} times as fast");
        assert!(fast.1 < most_error * paper, "{scene}: fast has {most_error} of the error");
    }
    let (near, far) = (of("close-up", "paper closed-form"), of("far", "paper closed-form"));
    assert!(
        near.0 > 1.2 && near.1 < 1.05 * of("close-up", "paper").1,
        "close up it is faster and as true"
    );
    assert!(
        far.0 < 1.1 && far.1 > of("far", "paper").1,
        "of small drops it is no faster, and less true"
    );
}

/// In sentences and tables numbers of five digits and more have commas, as what the program prints.
#[test]
fn thousands_have_commas() {
    for (path, text) in documents() {
        // What is typed, and keys of files, stand in backticks.
        let spoken: String = text.split('`').step_by(2).collect();
        let words = spoken.split(|c: char| c.is_whitespace() || "|()[]*;:".contains(c));
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        for pair in words.windows(2) {
            let word = pair[1].trim_end_matches(['.', ',', '?']);
            let is_plain = word.len() >= 5 && word.chars().all(|c| c.is_ascii_digit());
            assert!(!is_plain || pair[0] == "commit", "{}: {word} has no comma", path.display());
        }
    }
}
