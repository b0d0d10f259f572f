//! The scripts and recipes for continuous integration, with a program that takes the times it is told to.

#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use raindrops::picture::Picture;
use tempfile::TempDir;

/// `bench` of one side writes a round of MS milliseconds, with `--rounds` ten; `render` a black picture; all else is the
/// real program's.
const PROGRAM: &str = r#"#!/bin/bash
[[ "$1" = bench && "$*" != *--a-binary* || "$1" = render ]] || exec "$REAL" "$@"
command=$1 all=$*
while [ $# -gt 0 ]; do
  case "$1" in --json|-o) file=$2;; --google-benchmark) echo '{}' > "$2";; esac
  shift
done
[ $command = render ] && exec cp "$HERE/black.exr" "$file"
ms=@MS@
rounds=
[[ "$all" = *--rounds* ]] && rounds=$(for n in 1 2 3 4 5 6 7 8 9; do printf '{"median_ms": %s.%s},' "$ms" "$n"; done)
cat > "$file" <<END
{"schema": "raindrops-bench/1", "environment": "sky",
 "device": {"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"},
 "build": {"version": "0.1.0", "commit": "unknown"}, "host": {"cpu": "C", "cores": 2, "os": "O"},
 "rows": [{"preset": "paper", "optics": "mask", "primitive": "point", "order": "unsorted", "drops": 1000,
   "visible": 200, "width": 64, "height": 64, "tone_map": true, "samples_ms": [$ms], "median_ms": $ms,
   "p10_ms": 1, "p90_ms": 1, "fps": 1, "rounds": [$rounds {"median_ms": $ms.5}]}]}
END
"#;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn write_program(path: &Path, text: &str) {
    fs::write(path, text).expect("a program");
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("its mode");
}

/// A folder with a black picture.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let pixels = vec![glam::Vec3::splat(0.1); 64 * 64];
    let picture = Picture { width: 64, height: 64, pixels };
    picture.write_exr(&folder.path().join("black.exr")).expect("a picture");
    folder
}

fn run(command: &mut Command, folder: &Path) -> (Option<i32>, String) {
    command.current_dir(folder).env("HERE", folder).env("REAL", env!("CARGO_BIN_EXE_raindrops"));
    // What the tester may have set for the same scripts, and for the program.
    for name in
        ["FAIL_ABOVE", "VERDICT_FOLDER", "RAINDROPS_DEVICE", "CLICOLOR_FORCE", "CARGO_TARGET_DIR"]
    {
        command.env_remove(name);
    }
    let Output { status, stdout, stderr } = crate::common::outcome(command);
    let text = [stdout, stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (status.code(), text)
}

#[test]
fn a_baseline_is_made_and_kept_and_a_slower_run_fails() {
    let folder = folder();
    let against = |ms: &str| {
        write_program(&folder.path().join("program"), &PROGRAM.replace("@MS@", ms));
        let mut command = Command::new(root().join("scripts/against-baseline.sh"));
        command.args(["kept", "--drops", "1000"]).env("RAINDROPS", "./program");
        run(command.env("BASELINE_RUNS", "2"), folder.path())
    };
    let kept = |name: &str| fs::read_to_string(folder.path().join("kept").join(name));
    for number in [1, 2] {
        let (status, text) = against("100");
        assert_eq!(status, Some(0), "{text}");
        assert!(text.contains(&format!("kept as kept/base-{number}.json")), "{text}");
        assert!(kept("verdict.md").is_err());
    }
    let base = kept("base-1.json").expect("a baseline");
    let (status, text) = against("100");
    assert_eq!(status, Some(0), "{text}");
    assert!(kept("verdict.md").expect("a verdict").contains(" same |"), "{text}");
    let (status, text) = against("130");
    assert_eq!(status, Some(1), "{text}");
    let table = kept("verdict.md").expect("a verdict");
    assert!(
        table.contains(" slower |") && table.starts_with("- A: kept/base-1.json, kept/base-2.json"),
        "{table}"
    );
    assert!(kept("verdict.xml").is_ok_and(|xml| xml.contains("failures=\"1\"")));
    assert_eq!(kept("base-1.json").expect("a baseline"), base, "it changes no more");
    // A row that the run lacks fails, too.
    let mut lost: serde_json::Value = serde_json::from_str(&base).expect("JSON");
    let mut row = lost["rows"][0].clone();
    row["drops"] = 77.into();
    lost["rows"].as_array_mut().expect("rows").push(row);
    fs::write(folder.path().join("kept/base-1.json"), lost.to_string()).expect("a file");
    let (status, text) = against("100");
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("77 drops, paper, 64 x 64 (missing)"), "{text}");
    assert!(kept("verdict.xml").is_ok_and(|xml| xml.contains("failures=\"1\"")));
    // An error is no verdict: a program that cannot measure.
    let (status, text) = against("nothing");
    assert_eq!(status, Some(2), "{text}");
    assert!(kept("verdict.md").is_err(), "the verdict of an earlier run is left");
}

/// `scripts/test.sh` sums up what cargo and the test programs print, here as they did: one program passes, one has failures
/// and shows what a test said, one crashes, and the documentation's tests are in two groups.
#[test]
fn the_last_line_counts_the_tests_of_all_programs() {
    const SAID: &str = "   Compiling raindrops v0.1.0\n\
        \u{1b}[1m\u{1b}[32m     Running\u{1b}[0m unittests src/lib.rs (target/debug/deps/raindrops-1)\n\
        test result: ok. 90 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out; finished in 0.30s\n\
        \x20    Running tests/abi.rs (target/debug/deps/abi-2)\n---- a stdout ----\n\
        test result: ok. 5 passed; 7 failed; 9 ignored; 0 measured; 3 filtered out; finished in 0.30s\n\
        test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.30s\n\
        error: test failed, to rerun pass `--test abi`\n\
        \x20    Running tests/crash.rs (target/debug/deps/crash-2)\n\
        error: test failed, to rerun pass `--test crash`\n\
        \x20  Doc-tests raindrops\n\
        test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.30s\n\
        test result: ok. 1 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.30s\n";
    let folder = folder();
    let path = folder.path();
    fs::create_dir(path.join("scripts")).expect("a folder");
    let script = path.join("scripts/test.sh");
    fs::copy(root().join("scripts/test.sh"), &script).expect("a script");
    write_program(&path.join("scripts/setup.sh"), "#!/bin/sh\n");
    let cargo = "#!/bin/sh\n[ \"$1\" = test ] || exit 0\necho \"cargo $*\" >&2\ncat said\nexit \"$STATUS\"\n";
    write_program(&path.join("scripts/cargo.sh"), cargo);
    let tested = |said: &str, status: i32, options: &[&str]| {
        fs::write(path.join("said"), said).expect("a file");
        let mut command = Command::new(&script);
        let (found, text) = run(command.args(options).env("STATUS", status.to_string()), path);
        assert_eq!(found, Some(status), "{text}");
        let first = text.lines().next().expect("a line").to_string();
        (first, text.lines().last().expect("a line").to_string())
    };
    let some = ["--test", "abi", "a::", "--", "--ignored"];
    let (cargo, last) = tested(SAID, 101, &some);
    assert_eq!(cargo, "cargo test --no-fail-fast --test abi a:: -- --ignored");
    assert_eq!(last, "98 passed, 3 failed, 3 ignored");
    // The first program alone.
    let sound: String = SAID.split_inclusive('\n').take(3).collect();
    assert_eq!(tested(&sound, 0, &[]).1, "90 passed, 0 failed, 2 ignored");
    // What does not build runs nothing.
    let (cargo, last) = tested("error: could not compile\n", 101, &["--no-fail-fast"]);
    assert_eq!((&*cargo, &*last), ("cargo test --no-fail-fast", "0 passed, 1 failed, 0 ignored"));
}

#[test]
fn two_commits_are_built_and_compared() {
    let folder = folder();
    let path = folder.path();
    fs::create_dir_all(path.join("tree/scripts")).expect("a folder");
    fs::create_dir(path.join("tools")).expect("a folder");
    // A build writes the program with the time that the tree has in a file.
    let cargo = "#!/bin/sh\n[ -f ms ] || exit 101\nmkdir -p \"$CARGO_TARGET_DIR/release\"\n\
        sed \"s/@MS@/$(cat ms)/\" \"$HERE/template\" > \"$CARGO_TARGET_DIR/release/raindrops\"\n\
        chmod +x \"$CARGO_TARGET_DIR/release/raindrops\"\n";
    write_program(&path.join("tools/cargo"), cargo);
    fs::write(path.join("template"), PROGRAM).expect("a file");
    let tree = path.join("tree");
    write_program(&tree.join("scripts/setup.sh"), "#!/bin/sh\n");
    fs::copy(root().join("scripts/verdict.sh"), tree.join("scripts/verdict.sh")).expect("a script");
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        command.args(["-c", "user.name=n", "-c", "user.email=e@example.org"]).args(arguments);
        let (status, text) = run(&mut command, &tree);
        assert_eq!(status, Some(0), "{text}");
    };
    git(&["init", "-q"]);
    fs::write(tree.join(".gitignore"), "/target\n/out\n").expect("a file");
    git(&["add", "."]);
    git(&["commit", "-qm", "nothing to build"]);
    for ms in ["100", "130"] {
        fs::write(tree.join("ms"), ms).expect("a file");
        git(&["add", "."]);
        git(&["commit", "-qm", ms]);
    }
    let tools =
        format!("{}:{}", path.join("tools").display(), std::env::var("PATH").expect("a path"));
    let verdict = |arguments: &[&str]| {
        let mut command = Command::new("../tree/scripts/verdict.sh");
        command.args(arguments).env("PATH", &tools);
        let found = run(&mut command, &tree);
        assert!(!tree.join("target/verdict/base").exists(), "its tree is left: {}", found.1);
        found
    };
    // `HERE` is the folder above the tree.
    std::os::unix::fs::symlink(path.join("black.exr"), tree.join("black.exr")).expect("a link");
    std::os::unix::fs::symlink(path.join("template"), tree.join("template")).expect("a link");
    let (status, text) = verdict(&["HEAD~1", "--drops", "1000", "--fail-above", "10%"]);
    assert_eq!(status, Some(1), "{text}");
    for (name, words) in [
        ("md", " slower |"),
        ("json", "\"slower\""),
        ("xml", "failures=\"1\""),
        ("html", "</html>"),
    ] {
        let file = tree.join("out/verdict/verdict").with_extension(name);
        let found = fs::read_to_string(file).expect("a result");
        assert!(found.contains(words), "{name}: {found}");
    }
    let (status, text) = verdict(&["HEAD", "--drops", "1000", "--fail-above", "10%"]);
    assert_eq!(status, Some(0), "{text}");
    let (status, text) = verdict(&["HEAD~2"]);
    assert!(status == Some(2) && text.contains("base does not build"), "{text}");
    let (status, text) = verdict(&["nowhere"]);
    assert!(status == Some(2) && text.contains("no commit 'nowhere' here"), "{text}");
    let (status, text) = verdict(&[]);
    assert!(status == Some(2) && text.contains("scripts/verdict.sh origin/main"), "{text}");
}

/// What a recipe runs is there, and takes the options that it gives.
#[test]
fn recipes_name_what_there_is() {
    let help = crate::common::raindrops().args(["bench", "--help"]).output();
    let help = String::from_utf8(help.expect("it starts").stdout).expect("text");
    let (mut recipes, mut checked): (Vec<PathBuf>, usize) = (vec![root().join("Containerfile")], 0);
    for folder in [".github/workflows", "docs/ci"] {
        let entries = fs::read_dir(root().join(folder)).expect(folder);
        recipes.extend(entries.map(|entry| entry.expect("an entry").path()));
    }
    for path in recipes {
        let text = fs::read_to_string(&path).expect("a recipe");
        let place = path.display();
        let words: Vec<&str> = text.split_whitespace().collect();
        for word in words.iter().filter(|word| word.starts_with("scripts/") || **word == ".ci/run")
        {
            let mode = fs::metadata(root().join(word)).map(|found| found.permissions().mode());
            assert!(
                mode.is_ok_and(|mode| word.ends_with(".ps1") || mode & 0o111 != 0),
                "{place}: there is no program {word}"
            );
            checked += 1;
        }
        // From the command to the end of its lines.
        for command in ["scripts/verdict.sh ", "--entrypoint against-baseline ", "raindrops bench "]
        {
            for (at, _) in text.match_indices(command) {
                let indent = |line: &str| line.len() - line.trim_start().len();
                let first = text[..at].rfind('\n').map_or(0, |end| end + 1);
                let mut lines = text[first..].lines();
                let depth = lines.next().map(indent).expect("a line");
                let rest =
                    lines.take_while(|line| indent(line) == depth && line.trim().starts_with("--"));
                let own = text[at + command.len()..].lines().next().expect("a line");
                for option in std::iter::once(own)
                    .chain(rest.skip_while(|line| line.contains(command)))
                    .flat_map(str::split_whitespace)
                    .filter(|word| word.starts_with("--"))
                {
                    assert!(help.contains(&format!("{option} ")), "{place}: bench has no {option}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 15, "only {checked} words were looked at");
}

/// The recipes that split a data set over machines, as they stand on their page: each task asks for its own of all shards, by the
/// schedulers' variables and `srun` as they set them. What shards come to is tried in `data_sets`.
#[test]
fn the_shards_of_the_recipes_are_the_whole() {
    let page = fs::read_to_string(root().join("docs/collection.md")).expect("the page");
    let block = |kind: &str, words: &str| {
        let start = format!("```{kind}\n");
        let mut blocks = page.split(&start).skip(1);
        let block = blocks.find_map(|rest| rest.split("```").next().filter(|b| b.contains(words)));
        block.unwrap_or_else(|| panic!("no {kind} with {words}")).to_string()
    };
    let after = |text: &str, from: &str, to: &str| {
        let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from} in {text}"));
        rest.split_once(to).expect("its end").0.to_string()
    };
    let slurm = block("bash", "#SBATCH --array");
    let last: u32 = after(&slurm, "--array=1-", "\n").parse().expect("a number");
    let job = block("yaml", "kind: Job");
    let count: u32 = after(&job, "completions: ", "\n").parse().expect("a number");
    // A flow sequence whose third item is in single quotes.
    let in_job = after(&job, "command: [sh, -c, '", "']");
    let array: Vec<_> = (1..=last)
        .map(|number| [("SLURM_ARRAY_TASK_ID", number), ("SLURM_ARRAY_TASK_COUNT", last)])
        .collect();
    let indices: Vec<_> =
        (0..count).map(|number| [("JOB_COMPLETION_INDEX", number), ("UNUSED", 0)]).collect();

    let folder = folder();
    let path = folder.path();
    fs::create_dir(path.join("tools")).expect("a folder");
    write_program(&path.join("tools/srun"), "#!/bin/sh\nexec \"$@\"\n");
    write_program(&path.join("tools/raindrops"), "#!/bin/sh\necho \"$*\" >>asked\n");
    let tools =
        format!("{}:{}", path.join("tools").display(), std::env::var("PATH").expect("a path"));
    let asked = |script: &str, tasks: &[[(&str, u32); 2]]| {
        let _ = fs::remove_file(path.join("asked"));
        for (number, task) in tasks.iter().enumerate() {
            let mut command = Command::new("bash");
            command.args(["-euc", script]).env("PATH", &tools);
            command.envs(task.map(|(name, value)| (name, value.to_string())));
            let (status, text) = run(&mut command, path);
            assert_eq!(status, Some(0), "task {number}: {text}");
        }
        fs::read_to_string(path.join("asked")).expect("what was asked")
    };
    let shards = |scene: &str, set: &str, count: u32| -> String {
        let line = |n| {
            format!("dataset {scene} --preset fast --views 1000 -o {set} --shard {n}/{count}\n")
        };
        (1..=count).map(line).collect()
    };
    assert_eq!(asked(&slurm, &array), shards("plate.toml", "/shared/set", last));
    assert_eq!(asked(&in_job, &indices), shards("/data/plate.toml", "/data/set", count));
}

/// What the trials of the verdict change in the benchmark stands there once.
#[test]
fn the_change_of_the_trials_fits() {
    let script = fs::read_to_string(root().join("scripts/verdict-trials.sh")).expect("a script");
    let value = |name: &str, end: char| {
        let rest = script.split(name).nth(1).expect("a value");
        rest.split(end).next().expect("its end").to_string()
    };
    let source = fs::read_to_string(root().join(value("\nfile=", '\n'))).expect("a source");
    assert_eq!(source.matches(&value("\ntext='", '\'')).count(), 1);
}

/// A release runs from its own folder, and names every crate that it holds.
#[test]
fn a_release_is_whole() {
    let folder = folder();
    let mut command = Command::new(root().join("scripts/release.sh"));
    command.arg("release").env("RAINDROPS", env!("CARGO_BIN_EXE_raindrops"));
    let (status, text) = run(&mut command, folder.path());
    assert_eq!(status, Some(0), "{text}");
    let mut archives = fs::read_dir(folder.path().join("release")).expect("a folder");
    let archive = archives.next().expect("an archive").expect("an entry").path();
    let (status, text) = run(Command::new("tar").arg("xzf").arg(&archive), folder.path());
    assert_eq!(status, Some(0), "{text}");
    let name = archive.file_name().and_then(|name| name.to_str()).expect("a name");
    let tree = folder.path().join(name.trim_end_matches(".tar.gz"));
    let read =
        |file: &str| fs::read_to_string(tree.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let (status, text) = run(Command::new(tree.join("bin/raindrops")).arg("--version"), &tree);
    assert!(status == Some(0) && text.contains(env!("CARGO_PKG_VERSION")), "{text}");
    for entry in fs::read_dir(tree.join("assets/scenes")).expect("scenes") {
        let scene = entry.expect("an entry").path();
        let (status, text) =
            run(Command::new(tree.join("bin/raindrops")).arg("plan").arg(&scene), &tree);
        assert_eq!(status, Some(0), "{}: {text}", scene.display());
    }
    for page in ["raindrops", "raindrops-render", "raindrops-compare-devices"] {
        assert!(read(&format!("man/man1/{page}.1")).contains(".SH SYNOPSIS"), "{page}");
    }
    for shell in ["bash", "zsh", "fish"] {
        assert!(read(&format!("completions/raindrops.{shell}")).contains("resume"), "{shell}");
    }
    let licences = read("licences/crates.txt");
    // With its text; of the fonts in the window; and none of what only builds.
    for words in
        ["\nash 0.38", "Permission is hereby granted", "SIL OPEN FONT LICENSE", "\nclap 4."]
    {
        assert!(licences.contains(words), "no '{words}'");
    }
    assert!(!licences.contains("\nshaderc "), "the shader compiler is not in the program");
    assert!(read("INSTALL.txt").contains("libc.so.6"));
}
