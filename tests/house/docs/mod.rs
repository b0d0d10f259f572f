//! The documents: what they link to, name, show and quote is there, and is the program's.

mod figures;
mod keys;
mod links;
mod site;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use raindrops::environment::Environment;
use raindrops::measure::verdict::expect::Expectations;
use raindrops::plan::{Output, plan};
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

use crate::common::scene_keys;

/// A document, as its path below the package and its text without blocks of code.
fn documents() -> Vec<(PathBuf, String)> {
    let root = root();
    let mut paths: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(PathBuf::from).to_vec();
    for folder in ["docs", "docs/results"] {
        let entries = fs::read_dir(root.join(folder)).expect("a folder");
        let names =
            entries.map(|entry| Path::new(folder).join(entry.expect("an entry").file_name()));
        paths.extend(names.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    paths.into_iter().map(|path| (path.clone(), prose(&root.join(path)))).collect()
}

/// A document's lines outside of blocks of code.
fn prose(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a document");
    let parts = text.split("```").step_by(2);
    parts.collect()
}

/// What stands between `from` and `to`, each time.
fn between<'a>(text: &'a str, from: &str, to: char) -> Vec<&'a str> {
    text.split(from).skip(1).filter_map(|rest| rest.split(to).next()).collect()
}

/// A document's blocks of code.
fn blocks(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a document");
    text.split("```").skip(1).step_by(2).map(String::from).collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What the program says to `arguments` on stdout.
fn said(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_raindrops")).env_clear().args(arguments).output();
    String::from_utf8(output.expect("it starts").stdout).expect("text")
}

/// Every command with its short help.
fn helps() -> BTreeMap<String, String> {
    let help = said(&["--help"]);
    let lines = help.lines().take_while(|line| *line != "Options:");
    let names = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let names = names.filter(|name| *name != "help").map(String::from);
    names.map(|name| (name.clone(), said(&[&name, "-h"]))).collect()
}

/// Whether a help has an option, such as `--size`.
fn has(help: &str, option: &str) -> bool {
    help.split(|c: char| !c.is_alphanumeric() && c != '-').any(|word| word == option)
}

/// The options among words, such as `--size` of `--size=64x64`, up to what is another program's.
fn options(words: &str) -> Vec<&str> {
    let own = words.split(['|', '>', '#', ';']).next().unwrap_or_default();
    let words = own.split_whitespace().filter(|word| word.starts_with("--") && word.len() > 2);
    words.map(|word| word.split(['=', '…', ',', ')']).next().unwrap_or(word)).collect()
}

/// Scripts, and the command to which their options go.
const OF_BENCH: [&str; 4] =
    ["scripts/bench.sh", "scripts/verdict.sh", "scripts/against-baseline.sh", "scripts/results.sh"];

/// The command and its arguments, where a line of a shell runs the program or one of its scripts.
fn call(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    if let Some(script) = OF_BENCH.iter().find(|script| line.starts_with(**script)) {
        return Some(("bench", &line[script.len()..]));
    }
    let rest = match line.strip_prefix("raindrops ") {
        Some(rest) => rest,
        None => {
            let starts = ["run --release -- ", "; raindrops ", ":/work\" raindrops "];
            let start = starts.iter().find_map(|start| Some(line.find(start)? + start.len()));
            line[start?..].trim()
        }
    };
    // In what a command prints, a version follows the name.
    let is_call = rest.starts_with(|c: char| c.is_ascii_alphabetic());
    is_call.then(|| rest.split_once(' ').unwrap_or((rest, "")))
}

/// What is wrong with a call.
fn problem(helps: &BTreeMap<String, String>, (command, arguments): (&str, &str)) -> Option<String> {
    let Some(help) = helps.get(command) else {
        return Some(format!("there is no command {command}"));
    };
    let wrong = options(arguments).into_iter().find(|option| !has(help, option));
    wrong.map(|option| format!("{command} has no {option}"))
}

#[test]
fn every_command_and_option_that_is_shown_is_there() {
    let whole = said(&["--help"]);
    let helps = helps();
    assert!(helps.len() > 15, "{} commands", helps.len());
    let (mut calls, mut single, mut wrong) = (0, 0, Vec::new());
    for (path, text) in documents() {
        // The change log tells of options of earlier versions.
        if path.ends_with("CHANGELOG.md") {
            continue;
        }
        let place = path.display();
        let shell = blocks(&root().join(&path));
        let is_shell = |block: &&String| block.starts_with('\n') || block.starts_with("bash");
        for block in shell.iter().filter(is_shell) {
            for line in block.replace("\\\n", " ").lines() {
                let Some(call) = call(line.trim_start_matches("srun ")) else { continue };
                calls += 1;
                wrong.extend(problem(&helps, call).map(|problem| format!("{place}: {problem}")));
            }
        }
        for code in between(&text, "`", '`') {
            let code = code.strip_prefix("raindrops ").unwrap_or(code);
            let (command, rest) = code.split_once(' ').unwrap_or((code, ""));
            if helps.contains_key(command) && !rest.is_empty() {
                calls += 1;
                let found = problem(&helps, (command, rest));
                wrong.extend(found.map(|problem| format!("{place}: {problem}")));
            } else if let Some(option) = code.starts_with("--").then(|| options(code)) {
                single += 1;
                let is_known = |option: &&str| {
                    helps.values().chain([&whole]).any(|help| has(help, option))
                        || OTHERS.contains(option)
                };
                let unknown = option.into_iter().find(|option| !is_known(option));
                wrong.extend(unknown.map(|option| format!("{place}: no command has {option}")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(calls > 80 && single > 40, "{calls} calls, {single} options: are they looked for?");
}

/// Options of scripts and of other programs that the documents name.
const OTHERS: [&str; 4] = ["--deb", "--features", "--ignored", "--test"];

/// `docs/options.md` is the help of every command.
#[test]
fn the_help_is_in_the_reference() {
    let mut page = String::from(
        "# Options\n\nFor anyone who looks up an option: the short help of every command. `raindrops COMMAND --help` also \
         explains values.\nThis page is written by `RAINDROPS_WRITE_OPTIONS=1 scripts/test.sh --test house docs`.\n",
    );
    for (name, help) in helps() {
        page.push_str(&format!("\n## {name}\n\n```\n{}\n```\n", help.trim_end()));
    }
    let path = root().join("docs/options.md");
    if std::env::var_os("RAINDROPS_WRITE_OPTIONS").is_some() {
        fs::write(&path, &page).expect("a file");
    }
    let there = fs::read_to_string(&path).expect("the page");
    let differs = there.lines().zip(page.lines()).find(|(there, now)| there != now);
    assert!(
        there == page,
        "docs/options.md is stale; RAINDROPS_WRITE_OPTIONS=1 writes it: {differs:?}"
    );
}

#[test]
fn every_variable_that_is_named_is_read() {
    let mut sources = String::new();
    for folder in ["src", "tests", "scripts", "examples"] {
        let mut folders = vec![root().join(folder)];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    folders.push(path);
                } else if !path.ends_with("tests/house/docs/mod.rs") {
                    sources.push_str(&fs::read_to_string(path).unwrap_or_default());
                }
            }
        }
    }
    let own = fs::read_to_string(root().join("tests/house/docs/mod.rs")).expect("this file");
    let mut names = 0;
    for (path, text) in documents() {
        for (at, _) in text.match_indices("RAINDROPS_") {
            let end = text[at..].find(|c: char| !c.is_ascii_uppercase() && c != '_');
            let name = &text[at..at + end.unwrap_or(text.len() - at)];
            names += 1;
            let read = sources.contains(name) || own.contains(&format!("var_os(\"{name}\")"));
            assert!(read, "{}: nothing reads {name}", path.display());
        }
    }
    assert!(names > 5, "{names} names");
}

/// Names in the first column of the tables of a document, such as `a`, `b.c`, `d` as a, b.c, b.d.
fn documented_keys(path: &str) -> BTreeSet<String> {
    let text = fs::read_to_string(root().join(path)).expect("a document");
    let mut keys = BTreeSet::new();
    let rows = text
        .lines()
        .skip_while(|line| *line != "## General")
        .take_while(|line| *line != "## What a preset chooses");
    for line in rows.filter(|line| line.starts_with("| `")) {
        let mut table = "";
        for name in
            between(line.split(" | ").next().expect("a cell"), "`", '`').into_iter().step_by(2)
        {
            let key = name.split_once('.').map_or(name, |(of, key)| {
                table = of;
                key
            });
            keys.insert(if table.is_empty() { key.into() } else { format!("{table}.{key}") });
        }
    }
    keys
}

/// The program names its keys where it meets one that it does not know.
#[test]
fn the_scenes_keys_are_the_programs() {
    let tables = [
        "camera",
        "image",
        "environment",
        "water",
        "background",
        "rain",
        "particles",
        "shelter",
        "pane",
        "model",
        "tone_map",
        "film",
    ];
    let keys = scene_keys(&tables, &["drop", "pane.drop"]);
    assert_eq!(documented_keys("docs/scene.md"), keys, "left: docs/scene.md; right: the program");
}

/// Each block is a scene, a file for `--expect`, or of cargo.
#[test]
fn every_block_of_toml_is_read_by_the_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("expect.toml");
    let (mut scenes, mut expectations) = (0, 0);
    for (path, _) in documents() {
        for block in blocks(&root().join(&path)) {
            let Some(text) = block.strip_prefix("toml\n") else { continue };
            if text.starts_with("[dependencies]") || text.starts_with("[env]") {
                continue;
            } else if text.starts_with("[[device]]") {
                fs::write(&file, text).expect("a file");
                Expectations::load(&file).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                expectations += 1;
            } else {
                Scene::parse(text, "a scene").unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                scenes += 1;
            }
        }
    }
    assert!(scenes >= 5 && expectations > 0, "{scenes} scenes, {expectations} expectations");
}

/// `--example NAME` and the like, and options of `scripts/setup.sh`.
#[test]
fn every_target_and_option_of_setup_is_there() {
    let root = root();
    let setup = fs::read_to_string(root.join("scripts/setup.sh")).expect("the script");
    let mut found = 0;
    for (path, _) in documents() {
        let text = fs::read_to_string(root.join(&path)).expect("a document");
        for (option, folders) in [
            ("--example ", ["examples", "examples"]),
            ("--release -p ", ["examples", "examples"]),
            ("--bench ", ["benches", "benches"]),
            ("--test ", ["tests", "fuzz"]),
        ] {
            for rest in text.split(option).skip(1) {
                let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '-');
                let name = &rest[..end.unwrap_or(rest.len())];
                let is_there = |folder: &&str| {
                    let place = root.join(folder).join(name);
                    place.is_dir() || place.with_extension("rs").exists()
                };
                let is_any = folders.iter().any(is_there) || name == "NAME" || name.is_empty();
                assert!(is_any, "{}: there is no {option}{name}", path.display());
                found += 1;
            }
        }
        for rest in text.split("scripts/setup.sh ").skip(1) {
            for option in options(rest.split(['\n', '`']).next().unwrap_or_default()) {
                assert!(setup.contains(option), "{}: setup.sh has no {option}", path.display());
                found += 1;
            }
        }
    }
    assert!(found > 20, "{found} names: are they looked for?");
}

/// `-h` of each script prints the comment at its head, and does nothing else.
#[test]
fn every_script_says_what_it_is_for() {
    let mut scripts = 0;
    for entry in fs::read_dir(root().join("scripts")).expect("scripts") {
        let path = entry.expect("an entry").path();
        if path.ends_with("cargo.sh") || path.ends_with("setup.ps1") {
            continue; // all that it is given is cargo's; it is for Windows
        }
        let output = Command::new(&path).arg("-h").output().expect("it starts");
        let text = fs::read_to_string(&path).expect("a script");
        let head = text.lines().nth(1).and_then(|line| line.strip_prefix("# ")).expect("a comment");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.starts_with(head), "{}: {said}", path.display());
        scripts += 1;
    }
    assert!(scripts > 10, "{scripts} scripts");
}

/// Names of the passes of a scene's plan, in order.
fn passes(preset: Preset, output: Output) -> Vec<&'static str> {
    let mut scene = Scene::default();
    scene.model.take_preset(preset);
    let plan = plan(&scene, &Environment::bundled().expect("the sky"), output).expect("a plan");
    plan.passes.iter().map(|(name, _)| *name).collect()
}

#[test]
fn the_passes_that_are_shown_are_the_plans() {
    let text = fs::read_to_string(root().join("docs/method.md")).expect("the page");
    let (_, rest) = text.split_once("<!-- passes").expect("the drawing of the passes");
    let drawing = rest.split("```").nth(1).expect("its block");
    let mut lines = drawing.lines().filter(|line| line.contains('►')).map(|line| -> Vec<&str> {
        let (_, passes) = line.split_once(':').expect("a preset");
        let names = passes.split("─►").map(|name| name.trim_matches([' ', '─', '┐', '┴']));
        names.filter(|name| !name.is_empty()).collect()
    });
    let (paper, tiles) = (lines.next().expect("paper"), lines.next().expect("fast"));
    let paper = [&paper[..], &tiles[tiles.len() - 2..]].concat();
    assert_eq!(paper, passes(Preset::Paper, Output::Display));
    assert_eq!(tiles, passes(Preset::Fast, Output::Display));
    assert_eq!(tiles, passes(Preset::Exact, Output::Display));
    // The table below the drawing.
    let table = rest.split("| pass | does |").nth(1).expect("a table");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let named: BTreeSet<&str> = rows
        .flat_map(|row| {
            between(row.split(" | ").next().expect("a cell"), "`", '`').into_iter().step_by(2)
        })
        .collect();
    let mut all: BTreeSet<&str> = paper.into_iter().chain(tiles).collect();
    all.extend(passes(Preset::PaperCompact, Output::Display));
    all.extend(passes(Preset::Fast, Output::Layers));
    assert_eq!(named, all);
}

/// The front page of the library compiles what the pages on embedding show.
#[test]
fn what_embedding_shows_is_compiled() {
    let library = fs::read_to_string(root().join("src/lib.rs")).expect("the library");
    let compiled: BTreeSet<&str> =
        library.lines().filter_map(|line| line.strip_prefix("//! ")).map(str::trim).collect();
    let mut lines = 0;
    for page in ["docs/embedding.md", "docs/embedding-more.md"] {
        for block in blocks(&root().join(page)) {
            let Some(text) = block.strip_prefix("rust\n") else { continue };
            for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
                assert!(compiled.contains(line), "{page}: src/lib.rs does not have '{line}'");
                lines += 1;
            }
        }
    }
    assert!(lines > 15, "{lines} lines");
}
