//! Would the tests notice? `mutants.toml` lists faults, each a text in the program and what is put in its place,
//! with the test that must fail.
//!
//! `scripts/mutants.sh` tries them all, or those that it is told: the sources are copied to `target/mutants/tree`,
//! faults in Rust are built in all at once, each behind a number that the environment chooses, and faults in
//! shaders are compiled here and handed to the tests. So that is one build, and then a run of one test for each;
//! but for faults in constants, which no number can choose.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::expression::may_be_expression;
use crate::replaced::{Compiled, compile};

/// A test has noticed that takes longer than so many times what it takes without the fault, and this besides.
const LIMIT: (u32, Duration) = (20, Duration::from_secs(300));

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    mutant: Vec<Mutant>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// What is wrong.
    name: String,
    file: PathBuf,
    /// Stands in the file exactly once. In Rust an expression, evaluated when the program runs, unless `put` has
    /// `MUTANT`.
    text: String,
    /// What stands there instead. In Rust `MUTANT` is whether the fault is chosen.
    put: String,
    /// The test that must fail: its program, and its path there.
    test: String,
    case: String,
    /// In Rust: the text is a constant's, or no expression; the fault is built by itself, last.
    #[serde(default)]
    alone: bool,
}

impl Mutant {
    fn is_shader(&self) -> bool {
        self.file.starts_with("glsl")
    }

    /// Whether one of the words is in its name, file or test.
    fn has(&self, words: &[String]) -> bool {
        let told = format!("{}\n{}\n{} {}", self.name, self.file.display(), self.test, self.case);
        words.is_empty() || words.iter().any(|word| told.contains(word.as_str()))
    }

    /// What stands in the source that is built, for mutant `number`.
    fn switched(&self, number: usize) -> String {
        let chosen = format!("crate::mutant({number})");
        if self.put.contains("MUTANT") {
            self.put.replace("MUTANT", &chosen)
        } else {
            format!("(if {chosen} {{ {} }} else {{ {} }})", self.put, self.text)
        }
    }
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn mutants() -> Vec<Mutant> {
    let text = fs::read_to_string(root().join("tests/mutants.toml")).expect("the list");
    toml::from_str::<List>(&text).unwrap_or_else(|error| panic!("{error}")).mutant
}

/// Where a mutant's text is in its file, or what is wrong with it.
fn place(mutant: &Mutant, source: &str) -> Result<usize, String> {
    let mut places = source.match_indices(&mutant.text).map(|(at, _)| at);
    let (file, name) = (mutant.file.display(), &mutant.name);
    match (places.next(), places.next()) {
        (Some(at), None) => Ok(at),
        (None, _) => Err(format!("{file} no longer has the text of '{name}'")),
        _ => Err(format!("{file} has the text of '{name}' more than once")),
    }
}

/// Where the faults of a file stand that are built in together, and the number of each from 1 on; in order.
fn places_in(file: &Path, all: &[Mutant], source: &str) -> Vec<(Range<usize>, usize)> {
    let here = (1..)
        .zip(all)
        .filter(|(_, mutant)| !mutant.is_shader() && !mutant.alone && mutant.file == *file);
    let mut here: Vec<_> = here
        .filter_map(|(number, mutant)| {
            let at = place(mutant, source).ok()?;
            Some((at..at + mutant.text.len(), number))
        })
        .collect();
    here.sort_by_key(|(place, _)| place.start);
    here
}

#[test]
fn each_mutant_has_its_place_and_its_test() {
    let mut wrong = Vec::new();
    let mut names = BTreeSet::new();
    for mutant in mutants() {
        let source = fs::read_to_string(root().join(&mutant.file));
        wrong.extend(match source {
            Ok(source) => place(&mutant, &source).err(),
            Err(error) => Some(format!("{}: {error}", mutant.file.display())),
        });
        let mut modules: Vec<&str> = mutant.case.split("::").collect();
        let case = modules.pop().unwrap_or_default();
        let place = [&mutant.test[..]].into_iter().chain(modules).collect::<Vec<_>>().join("/");
        let files = ["/main.rs", ".rs", "/mod.rs"].map(|end| format!("tests/{place}{end}"));
        let test: String =
            files.iter().filter_map(|file| fs::read_to_string(root().join(file)).ok()).collect();
        if !test.contains(&format!("fn {case}()")) {
            wrong.push(format!("'{}': tests/{place} has no test {case}", mutant.name));
        }
        if mutant.put == mutant.text || !names.insert(mutant.name.clone()) {
            wrong.push(format!("'{}' changes nothing, or stands there twice", mutant.name));
        }
        let chosen = !mutant.is_shader() && !mutant.alone && !mutant.put.contains("MUTANT");
        if chosen && ![&mutant.text, &mutant.put].into_iter().all(|text| may_be_expression(text)) {
            wrong.push(format!("'{}' is no expression that a number can choose", mutant.name));
        }
    }
    let all = mutants();
    for file in all.iter().map(|mutant| &mutant.file).collect::<BTreeSet<_>>() {
        let source = fs::read_to_string(root().join(file)).unwrap_or_default();
        let here = places_in(file, &all, &source);
        let overlap = here.windows(2).any(|pair| pair[0].0.end > pair[1].0.start);
        wrong.extend(overlap.then(|| format!("two texts of {} overlap", file.display())));
    }
    assert!(wrong.is_empty(), "tests/mutants.toml:\n{}", wrong.join("\n"));
    assert!(names.len() >= 30, "{} mutants", names.len());
}

/// Writes a file unless it has that content already, so that what has not changed is not built again.
pub fn write(path: &Path, content: &[u8]) {
    if fs::read(path).is_ok_and(|there| there == content) {
        return;
    }
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    fs::write(path, content).expect("a file");
}

/// Copies the sources to `tree`, the faults in Rust among them, and removes what is there no longer.
pub fn copy_sources(tree: &Path, mutants: &[Mutant]) {
    let listed = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .current_dir(root())
        .output()
        .expect("git");
    let files: BTreeSet<PathBuf> = String::from_utf8(listed.stdout)
        .expect("names in UTF-8")
        .split_terminator('\0')
        .map(PathBuf::from)
        .filter(|file| root().join(file).is_file())
        .collect();
    assert!(files.contains(Path::new("src/lib.rs")), "git lists {} files", files.len());
    for file in &files {
        let mut content = fs::read(root().join(file)).expect("a source");
        // None of them is in a file that is no text.
        let here = places_in(file, mutants, std::str::from_utf8(&content).unwrap_or_default());
        for (place, number) in here.into_iter().rev() {
            content.splice(place, mutants[number - 1].switched(number).into_bytes());
        }
        if file == Path::new("src/lib.rs") {
            let allowed = b"#![allow(unused_parens, missing_docs)]\n".iter().copied();
            content.splice(0..0, allowed);
            content.extend_from_slice(SWITCH.as_bytes());
        }
        write(&tree.join(file), &content);
        // Scripts can be executed.
        let allowed = fs::metadata(root().join(file)).expect("a source").permissions();
        fs::set_permissions(tree.join(file), allowed).expect("its permissions");
    }
    remove_others(tree, tree, &files);
    for linked in [".setup", "assets/environments"] {
        let (from, to) = (root().join(linked), tree.join(linked));
        if from.exists() && !to.exists() {
            std::os::unix::fs::symlink(from, to).expect("a link");
        }
    }
}

/// Which fault is chosen, in the copied library.
const SWITCH: &str = r#"

pub(crate) fn mutant(number: u32) -> bool {
    static CHOSEN: std::sync::LazyLock<Option<u32>> =
        std::sync::LazyLock::new(|| std::env::var("RAINDROPS_MUTANT").ok()?.parse().ok());
    *CHOSEN == Some(number)
}
"#;

fn remove_others(tree: &Path, folder: &Path, files: &BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            remove_others(tree, &path, files);
        } else if !files.contains(path.strip_prefix(tree).expect("below the tree")) {
            fs::remove_file(path).expect("removed");
        }
    }
}

/// Builds test binaries in the tree; each one's path, or none if they do not build. `target` is a folder of its own:
/// beside the crate's, cargo would take the faulty build for the crate's own.
pub fn build(
    tree: &Path,
    target: &Path,
    tests: &BTreeSet<&str>,
) -> Option<BTreeMap<String, PathBuf>> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["test", "--no-run", "--message-format=json-render-diagnostics"]);
    for test in tests {
        match *test {
            "lib" => command.arg("--lib"),
            test => command.args(["--test", test]),
        };
    }
    let built = command
        .current_dir(tree)
        .env("CARGO_TARGET_DIR", target)
        .stderr(Stdio::inherit())
        .output()
        .expect("cargo");
    let executables = String::from_utf8_lossy(&built.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|message| {
            let executable = message["executable"].as_str()?;
            let target = &message["target"];
            let name = if target["kind"][0] == "lib" { "lib" } else { target["name"].as_str()? };
            Some((name.to_string(), executable.into()))
        })
        .collect();
    built.status.success().then_some(executables)
}

/// Whether a test passes; none if it does not end in time.
fn passes(
    executable: &Path,
    tree: &Path,
    case: &str,
    variable: Option<(&str, &str)>,
    time: Duration,
) -> Option<bool> {
    let mut command = Command::new(executable);
    command.args(["--exact", case, "--nocapture"]).envs(variable);
    ended_well(command, tree, time)
}

/// Whether all tests pass that have one of the words in their names, with a fault that a variable of the environment chooses;
/// none if they do not end in time. The first that fails ends the others.
pub fn run_until(
    executable: &Path,
    tree: &Path,
    words: &[&str],
    fault: Option<(&str, &str)>,
    time: Duration,
) -> Option<bool> {
    let mut command = Command::new(executable);
    command.args(words).envs(fault);
    ended_well(command, tree, time)
}

fn ended_well(mut command: Command, tree: &Path, time: Duration) -> Option<bool> {
    let path = tree.with_file_name("last.log");
    let log = fs::File::create(&path).expect("a log");
    let mut running: Child = command
        .current_dir(tree)
        .stdout(log.try_clone().expect("a log"))
        .stderr(log)
        .spawn()
        .expect("the test starts");
    let start = Instant::now();
    loop {
        if let Some(status) = running.try_wait().expect("a status") {
            return Some(status.success());
        }
        let has_failed = has_failed(&path);
        if has_failed || start.elapsed() > time {
            running.kill().expect("killed");
            running.wait().expect("ended");
            return has_failed.then_some(false);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Whether a test of many has failed, by what its program has printed.
fn has_failed(log: &Path) -> bool {
    let log = fs::read(log).unwrap_or_default();
    String::from_utf8_lossy(&log)
        .lines()
        .any(|line| line.starts_with("test ") && line.ends_with("... FAILED"))
}

/// The line of a failed test that says why.
fn reason(tree: &Path) -> String {
    let log = fs::read(tree.with_file_name("last.log")).unwrap_or_default();
    let log = String::from_utf8_lossy(&log).into_owned();
    let after = log.lines().skip_while(|line| !line.contains("panicked at")).nth(1);
    after.unwrap_or("it did not end well").chars().take(120).collect()
}

/// What became of a fault.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Outcome {
    Killed,
    Survived,
    /// The file no longer has its text, or the fault does not build or changes nothing.
    Stale,
    /// Its test fails without it, too.
    NotJudged,
}

/// The sources with all faults that a number chooses, and what was built of them.
struct Tree {
    path: PathBuf,
    executables: BTreeMap<String, PathBuf>,
    /// How long a test takes without a fault, or why it fails.
    taken: BTreeMap<(String, String), Result<Duration, String>>,
}

impl Tree {
    /// How long a mutant's test takes without it, or why it fails.
    fn time_without(&mut self, mutant: &Mutant) -> Result<Duration, String> {
        let of = (mutant.test.clone(), mutant.case.clone());
        if let Some(taken) = self.taken.get(&of) {
            return taken.clone();
        }
        let start = Instant::now();
        let executable = &self.executables[&mutant.test];
        let passed = passes(executable, &self.path, &mutant.case, None, Duration::MAX);
        let log = fs::read_to_string(self.path.with_file_name("last.log")).unwrap_or_default();
        let sound = passed == Some(true) && log.contains("1 passed");
        let taken = if sound { Ok(start.elapsed()) } else { Err(reason(&self.path)) };
        self.taken.entry(of).or_insert(taken).clone()
    }

    /// What becomes of mutant `number`, and why.
    fn outcome(&mut self, number: usize, mutant: &Mutant) -> (Outcome, String) {
        let file = self.path.join(&mutant.file);
        // The text is looked for in the tree itself: in a file that has faults already it may stand behind a number.
        if let Err(error) = fs::read_to_string(root().join(&mutant.file))
            .map_err(|error| error.to_string())
            .and_then(|source| place(mutant, &source))
        {
            return (Outcome::Stale, error);
        }
        let taken = match self.time_without(mutant) {
            Ok(taken) => taken,
            Err(reason) => return (Outcome::NotJudged, format!("without it: {reason}")),
        };
        let time = LIMIT.0 * taken + LIMIT.1;
        let run = |executable: &Path, variable| {
            passes(executable, &self.path, &mutant.case, variable, time)
        };
        let executable = &self.executables[&mutant.test];
        let passed = if mutant.is_shader() {
            let shaders = self.path.with_file_name("glsl");
            let file = root().join(&mutant.file);
            let source = fs::read_to_string(file).expect("it was read");
            let at = place(mutant, &source).expect("it was found");
            let text = at..at + mutant.text.len();
            let Compiled { changed, broken } =
                compile(&self.path, &shaders, &mutant.file, text, &mutant.put);
            // A shader that does not compile is noticed by `tests/house/abi.rs` alone.
            if changed == 0 && !(mutant.case.starts_with("abi::") && broken > 0) {
                return (Outcome::Stale, "it changes no shader, or does not compile".into());
            }
            let shaders = shaders.to_str().expect("a path in UTF-8");
            run(executable, Some(("RAINDROPS_TEST_GLSL", shaders)))
        } else if mutant.alone {
            let whole = fs::read_to_string(&file).expect("a source");
            let changed = whole.replacen(&mutant.text, &mutant.put, 1);
            write(&file, changed.as_bytes());
            let tests = BTreeSet::from([mutant.test.as_str()]);
            let built = build(&self.path, &self.path.with_file_name("build"), &tests);
            write(&file, whole.as_bytes());
            let Some(built) = built else {
                return (Outcome::Stale, "it does not build".into());
            };
            run(&built[&mutant.test], None)
        } else {
            run(executable, Some(("RAINDROPS_MUTANT", &number.to_string())))
        };
        match passed {
            Some(true) => (Outcome::Survived, format!("{}, {}", mutant.test, mutant.case)),
            Some(false) => (Outcome::Killed, reason(&self.path)),
            None => (Outcome::Killed, "it does not end".into()),
        }
    }
}

/// Tries each mutant, or those that have one of the words of `RAINDROPS_MUTANTS`, which `|` parts.
#[test]
#[ignore = "run by scripts/mutants.sh; minutes"]
fn every_mutant_is_killed() {
    let wanted = std::env::var("RAINDROPS_MUTANTS").unwrap_or_default();
    let words: Vec<String> =
        wanted.split('|').filter(|word| !word.is_empty()).map(str::to_string).collect();
    let all = mutants();
    let mut chosen: Vec<(usize, &Mutant)> =
        (1..).zip(&all).filter(|(_, mutant)| mutant.has(&words)).collect();
    chosen.sort_by_key(|(_, mutant)| mutant.alone);
    assert!(!chosen.is_empty(), "no mutant has any of {words:?}");
    let path = root().join("target/mutants/tree");
    copy_sources(&path, &all);
    let tests: BTreeSet<&str> = chosen.iter().map(|(_, mutant)| mutant.test.as_str()).collect();
    let executables =
        build(&path, &path.with_file_name("build"), &tests).expect("the mutants do not build");
    let mut tree = Tree { path, executables, taken: BTreeMap::new() };

    let mut outcomes: BTreeMap<Outcome, Vec<&str>> = BTreeMap::new();
    for (number, mutant) in chosen {
        let start = Instant::now();
        let (outcome, why) = tree.outcome(number, mutant);
        let seconds = start.elapsed().as_secs_f64();
        outcomes.entry(outcome).or_default().push(&mutant.name);
        println!("{:9} {seconds:5.1} s  {}: {why}", format!("{outcome:?}"), mutant.name);
    }
    for (outcome, names) in &outcomes {
        println!("{outcome:?}: {}", names.len());
    }
    outcomes.remove(&Outcome::Killed);
    assert!(outcomes.is_empty(), "not killed: {outcomes:#?}");
}
