//! A score that nobody chose: faults made by rule, taken at random by seed, and how many the tests notice.
//!
//! `scripts/mutants.sh --generated` tries those of `tests/generated.toml`. All are built in at once, each behind a number
//! that the environment chooses; those that do not build are set aside and others taken. What became of each is kept in
//! `target/generated/results.tsv`, so that a run goes on where the one before ended.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::io::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;

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

/// SplitMix64 (Steele, Lea and Flood 2014).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The faults of a part in random order, none within another.
fn shuffled(part: &Part, seed: u64) -> Vec<(PathBuf, Fault)> {
    let listed = Command::new("git").args(["ls-files", "src"]).current_dir(root()).output();
    let listed = String::from_utf8(listed.expect("git").stdout).expect("names in UTF-8");
    let files = listed.lines().filter(|file| {
        file.ends_with(".rs") && part.files.iter().any(|start| file.starts_with(start))
    });
    let mut all: Vec<(PathBuf, Fault)> = files
        .flat_map(|file| faults(file).into_iter().map(move |fault| (PathBuf::from(file), fault)))
        .collect();
    assert!(!all.is_empty(), "{}: no file has a fault", part.name);
    let mut state = part.name.bytes().fold(seed, |state, byte| state ^ u64::from(byte) << 7);
    for last in (1..all.len()).rev() {
        all.swap(last, (random(&mut state) % (last as u64 + 1)) as usize);
    }
    let mut taken: HashMap<PathBuf, Vec<Range<usize>>> = HashMap::new();
    all.retain(|(file, fault)| {
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

/// Writes a file's faults into the tree, each behind its number; where each then stands.
fn plant(tree: &Path, file: &Path, faults: &[(usize, &Fault)]) -> Vec<(Range<usize>, usize)> {
    let source = fs::read_to_string(root().join(file)).expect("a source");
    let mut sorted = faults.to_vec();
    sorted.sort_by_key(|(_, fault)| fault.place.start);
    let (mut text, mut at, mut places) = (String::new(), 0, Vec::new());
    for (number, fault) in sorted {
        text.push_str(&source[at..fault.place.start]);
        let start = text.len();
        let own = &source[fault.place.clone()];
        text.push_str(&format!(
            "(if crate::mutant({number}) {{ {} }} else {{ {own} }})",
            fault.put
        ));
        places.push((start..text.len(), number));
        at = fault.place.end;
    }
    text.push_str(&source[at..]);
    fs::write(tree.join(file), text).expect("a source");
    places
}

/// Numbers of the faults that do not build.
fn that_do_not_build(
    tree: &Path,
    places: &BTreeMap<PathBuf, Vec<(Range<usize>, usize)>>,
) -> BTreeSet<usize> {
    let checked = Command::new(env!("CARGO"))
        .args(["check", "--lib", "--message-format=json"])
        .current_dir(tree)
        .env("CARGO_TARGET_DIR", root().join("target/generated/build"))
        .stderr(Stdio::null())
        .output()
        .expect("cargo");
    let mut wrong = BTreeSet::new();
    let mut elsewhere = Vec::new();
    for line in String::from_utf8_lossy(&checked.stdout).lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        if message["message"]["level"] != "error" {
            continue;
        }
        let spans = message["message"]["spans"].as_array().cloned().unwrap_or_default();
        let before = wrong.len();
        for span in &spans {
            let file = PathBuf::from(span["file_name"].as_str().unwrap_or_default());
            let at = span["byte_start"].as_u64().unwrap_or_default() as usize;
            let here = places.get(&file).into_iter().flatten();
            wrong.extend(here.filter(|(place, _)| place.contains(&at)).map(|(_, number)| number));
        }
        if wrong.len() == before && !spans.is_empty() {
            elsewhere.push(message["message"]["rendered"].to_string());
        }
    }
    assert!(checked.status.success() || !wrong.is_empty(), "{elsewhere:#?}");
    wrong
}

/// What is kept of earlier runs, by fault.
fn kept(path: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(path).unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split_once('\t'));
    lines.map(|(outcome, key)| (key.to_string(), outcome.to_string())).collect()
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
    let mut chosen = Vec::new();
    let mut waiting = Vec::new();
    for part in parts {
        let count = (part.faults as f64 * share).ceil() as usize;
        let of = shuffled(part, list.seed);
        let each = of.into_iter().map(|(file, fault)| Chosen { part, file, fault });
        let mut each: Vec<_> = each.collect();
        waiting.push(each.split_off(count.min(each.len())).into_iter());
        chosen.push(each);
    }
    // Numbers stay those of the first that were taken; what takes the place of one has its number.
    loop {
        let mut numbered: BTreeMap<PathBuf, Vec<(usize, &Fault)>> = BTreeMap::new();
        for (number, one) in (1..).zip(chosen.iter().flatten()) {
            numbered.entry(one.file.clone()).or_default().push((number, &one.fault));
        }
        let planted =
            numbered.iter().map(|(file, faults)| (file.clone(), plant(&tree, file, faults)));
        let wrong = that_do_not_build(&tree, &planted.collect());
        if wrong.is_empty() {
            break;
        }
        println!("{} do not build", wrong.len());
        let mut number = 0;
        for (chosen, waiting) in chosen.iter_mut().zip(&mut waiting) {
            chosen.retain_mut(|one| {
                number += 1;
                if !wrong.contains(&number) {
                    return true;
                }
                let file = root().join(&one.file);
                let next = waiting.next();
                fs::copy(file, tree.join(&one.file)).expect("a source");
                next.map(|next| *one = next).is_some()
            });
        }
    }

    let mut tests: BTreeSet<&str> = BTreeSet::new();
    tests.extend(
        chosen.iter().flatten().flat_map(|one| &one.part.tests).map(|test| program(test).0),
    );
    let executables = build(&tree, &folder.join("build"), &tests).expect("what was checked builds");
    let results = folder.join("results.tsv");
    let known = kept(&results);
    let mut file = fs::File::options().append(true).create(true).open(&results).expect("results");
    let mut taken: HashMap<&str, Duration> = HashMap::new();
    let (mut noticed, mut all) = (BTreeMap::new(), BTreeMap::new());
    let mut survivors = Vec::new();
    for (number, one) in (1..).zip(chosen.iter().flatten()) {
        let key = one.key();
        let start = Instant::now();
        let outcome = known.get(&key).cloned().unwrap_or_else(|| {
            let notices = one.part.tests.iter().find(|test| {
                let (name, words) = program(test);
                let run = |fault: Option<usize>, time| {
                    run_until(&executables[name], &tree, &words, fault, time)
                };
                let usual = *taken.entry(test.as_str()).or_insert_with(|| {
                    let start = Instant::now();
                    assert_eq!(
                        run(None, Duration::MAX),
                        Some(true),
                        "{test} fails without a fault"
                    );
                    start.elapsed()
                });
                run(Some(number), 10 * usual + Duration::from_secs(120)) != Some(true)
            });
            let outcome = notices.map_or("survived".into(), |test| format!("noticed by {test}"));
            writeln!(file, "{outcome}\t{key}").expect("results");
            outcome
        });
        println!("{:5.1} s  {outcome}: {key}", start.elapsed().as_secs_f64());
        *all.entry(&one.part.name).or_insert(0) += 1;
        match outcome == "survived" {
            true => survivors.push(key),
            false => *noticed.entry(&one.part.name).or_insert(0) += 1,
        }
    }
    for (part, all) in &all {
        println!("| {part} | {} of {all} |", noticed.get(part).unwrap_or(&0));
    }
    println!("survived:\n{}", survivors.join("\n"));
    let (noticed, all): (i32, i32) = (noticed.values().sum(), all.values().sum());
    assert!(10 * noticed >= 9 * all, "{noticed} of {all} are noticed");
}

/// A test's program, and the words in its tests' names.
fn program(test: &str) -> (&str, Vec<&str>) {
    let mut words = test.split_whitespace();
    (words.next().expect("a program"), words.collect())
}
