//! A score that nobody chose: faults made by rule, taken at random by seed, and how many the tests notice.
//!
//! `scripts/mutants.sh --generated` tries those of `tests/generated.toml`. What became of each is kept in
//! `target/generated/results.tsv`, so that a run goes on where the one before ended.

mod compiled;
mod planted;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::io::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::common::Random;
use crate::mutants::{build, copy_sources, root, run_until};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    /// Chooses the faults.
    seed: u64,
    part: Vec<Part>,
}

/// Files, and the tests that are theirs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    name: String,
    /// Beginnings of paths.
    files: Vec<String>,
    /// How many faults.
    faults: usize,
    /// Each a test program, and what its tests' names have in them; in the order in which they are tried.
    tests: Vec<String>,
}

impl Part {
    fn is_of_shaders(&self) -> bool {
        self.files.iter().all(|start| start.starts_with("glsl"))
    }
}

/// What stands in a place of a source instead.
#[derive(Clone, Deserialize)]
struct Fault {
    place: Range<usize>,
    put: String,
    line: usize,
}

/// Every fault of a file, by the generator, which is a package of its own.
fn faults(file: &str) -> Vec<Fault> {
    let printed = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--manifest-path", "tests/generator/Cargo.toml", "--", file])
        .current_dir(root())
        .env("CARGO_TARGET_DIR", root().join("target/generated/generator"))
        .stderr(Stdio::inherit())
        .output()
        .expect("cargo");
    assert!(printed.status.success(), "{file}: no faults");
    serde_json::from_slice(&printed.stdout).expect("the faults")
}

/// A fault that is tried.
struct Chosen<'a> {
    part: &'a Part,
    file: PathBuf,
    fault: Fault,
}

impl Chosen<'_> {
    fn key(&self) -> String {
        let put = self.fault.put.split_whitespace().collect::<Vec<_>>().join(" ");
        format!("{}:{}: {put}", self.file.display(), self.fault.line)
    }
}

/// The faults of a part in random order, none within another. A file is of the first part that names it.
fn shuffled<'a>(list: &'a List, part: &'a Part) -> Vec<Chosen<'a>> {
    let listed = Command::new("git").args(["ls-files", "src", "glsl"]).current_dir(root()).output();
    let listed = String::from_utf8(listed.expect("git").stdout).expect("names in UTF-8");
    let ends = [".rs", ".glsl", ".comp", ".vert", ".frag"];
    let has = |part: &Part, file: &str| part.files.iter().any(|start| file.starts_with(start));
    let files = listed.lines().filter(|file| {
        let first = list.part.iter().find(|part| has(part, file));
        ends.iter().any(|end| file.ends_with(end))
            && first.is_some_and(|first| std::ptr::eq(first, part))
    });
    let mut all: Vec<Chosen> = files
        .flat_map(|file| faults(file).into_iter().map(move |fault| (PathBuf::from(file), fault)))
        .map(|(file, fault)| Chosen { part, file, fault })
        .collect();
    assert!(!all.is_empty(), "{}: no file has a fault", part.name);
    let mut random =
        Random(part.name.bytes().fold(list.seed, |state, byte| state ^ u64::from(byte) << 7));
    for last in (1..all.len()).rev() {
        all.swap(last, (random.bits() % (last as u64 + 1)) as usize);
    }
    let mut taken: HashMap<PathBuf, Vec<Range<usize>>> = HashMap::new();
    all.retain(|Chosen { file, fault, .. }| {
        let taken = taken.entry(file.clone()).or_default();
        let is_free = taken
            .iter()
            .all(|other| other.end <= fault.place.start || fault.place.end <= other.start);
        if is_free {
            taken.push(fault.place.clone());
        }
        is_free
    });
    all
}

/// What became of faults, of earlier runs too, by fault.
struct Results {
    known: BTreeMap<String, String>,
    file: fs::File,
}

impl Results {
    fn of(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_default();
        let lines = text.lines().filter_map(|line| line.split_once('\t'));
        let known = lines.map(|(outcome, key)| (key.to_string(), outcome.to_string())).collect();
        let file = fs::File::options().append(true).create(true).open(path).expect("results");
        Self { known, file }
    }

    /// What became of a fault, found out unless an earlier run has.
    fn outcome(&mut self, key: &str, find: impl FnOnce() -> String) -> String {
        let start = Instant::now();
        let outcome = self.known.get(key).cloned().unwrap_or_else(|| {
            let outcome = find();
            writeln!(self.file, "{outcome}\t{key}").expect("results");
            outcome
        });
        println!("{:5.1} s  {outcome}: {key}", start.elapsed().as_secs_f64());
        outcome
    }
}

/// The tests, built from the tree.
struct Tests {
    tree: PathBuf,
    executables: BTreeMap<String, PathBuf>,
    /// How long each takes without a fault.
    usual: HashMap<String, Duration>,
}

impl Tests {
    /// The first test that fails or does not end with a fault, which a variable of the environment chooses.
    fn that_notices<'a>(
        &mut self,
        tests: &'a [String],
        (name, value): (&str, &str),
    ) -> Option<&'a str> {
        tests.iter().map(String::as_str).find(|test| {
            let (program, words) = program(test);
            let executable = &self.executables[program];
            let usual = *self.usual.entry(test.to_string()).or_insert_with(|| {
                let start = Instant::now();
                let passed = run_until(executable, &self.tree, &words, None, Duration::MAX);
                assert_eq!(passed, Some(true), "{test} fails without a fault");
                start.elapsed()
            });
            let time = 10 * usual + Duration::from_secs(120);
            run_until(executable, &self.tree, &words, Some((name, value)), time) != Some(true)
        })
    }
}

#[test]
#[ignore = "run by scripts/mutants.sh --generated; hours"]
fn most_generated_faults_are_noticed() {
    let text = fs::read_to_string(root().join("tests/generated.toml")).expect("the list");
    let list: List = toml::from_str(&text).unwrap_or_else(|error| panic!("{error}"));
    let word = std::env::var("RAINDROPS_MUTANTS").unwrap_or_default();
    let share =
        std::env::var("RAINDROPS_SHARE").map_or(1.0, |share| share.parse().expect("a number"));
    let folder = root().join("target/generated");
    let tree = folder.join("tree");
    fs::create_dir_all(&tree).expect("a folder");
    copy_sources(&tree, &[]);

    let parts = list.part.iter().filter(|part| part.name.contains(&word));
    let parts = parts.map(|part| (part, (part.faults as f64 * share).ceil() as usize));
    let (of_shaders, of_rust): (Vec<_>, Vec<_>) = parts.partition(|(part, _)| part.is_of_shaders());
    let chosen = planted::planted(&tree, &list, &of_rust);

    let named = of_rust.iter().chain(&of_shaders).flat_map(|(part, _)| &part.tests);
    let mut tests: BTreeSet<&str> = named.map(|test| program(test).0).collect();
    if !of_shaders.is_empty() {
        tests.insert(compiled::PICTURES.0);
    }
    let executables = build(&tree, &folder.join("build"), &tests).expect("what was checked builds");
    let mut tests = Tests { tree, executables, usual: HashMap::new() };
    let mut results = Results::of(&folder.join("results.tsv"));
    let mut outcomes: Vec<(&str, String, String)> = Vec::new();
    for (number, one) in (1..).zip(&chosen) {
        let key = one.key();
        let outcome = results.outcome(&key, || {
            let number: usize = number;
            let variable = ("RAINDROPS_MUTANT", number.to_string());
            let notices = tests.that_notices(&one.part.tests, (variable.0, &variable.1));
            notices.map_or("survived".into(), |test| format!("noticed by {test}"))
        });
        outcomes.push((&one.part.name, outcome, key));
    }
    for (part, count) in &of_shaders {
        let of_part = compiled::outcomes(&list, part, *count, &mut tests, &mut results);
        outcomes.extend(of_part.into_iter().map(|(outcome, key)| (&*part.name, outcome, key)));
    }
    report(&outcomes);
}

/// Prints how many faults of each part were noticed, and those that were not.
///
/// # Panics
/// If more than a tenth were not.
fn report(outcomes: &[(&str, String, String)]) {
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (part, outcome, _) in outcomes {
        let [noticed, all] = counts.entry(part).or_default();
        *noticed += usize::from(outcome != "survived");
        *all += 1;
    }
    for (part, [noticed, all]) in &counts {
        println!("| {part} | {noticed} of {all} |");
    }
    let survivors = outcomes.iter().filter(|(_, outcome, _)| outcome == "survived");
    let keys: Vec<&str> = survivors.map(|(_, _, key)| key.as_str()).collect();
    println!("survived:\n{}", keys.join("\n"));
    let (all, noticed) = (outcomes.len(), outcomes.len() - keys.len());
    assert!(10 * noticed >= 9 * all, "{noticed} of {all} are noticed");
}

/// A test's program, and the words in its tests' names.
fn program(test: &str) -> (&str, Vec<&str>) {
    let mut words = test.split_whitespace();
    (words.next().expect("a program"), words.collect())
}
