//! Faults in Rust: all are built in at once, each behind a number that the environment chooses; those that do not build are set
//! aside and others taken.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::{Chosen, Fault, List, Part, shuffled};
use crate::mutants::root;

/// The faults of parts, in the tree: as many of each as it is to have, where they build. The number of a fault is its place
/// among them, from 1 on.
pub fn planted<'a>(tree: &Path, list: &'a List, parts: &[(&'a Part, usize)]) -> Vec<Chosen<'a>> {
    let (mut chosen, mut waiting) = (Vec::new(), Vec::new());
    for (part, count) in parts {
        let mut each = shuffled(list, part);
        waiting.push(each.split_off(*count.min(&each.len())).into_iter());
        chosen.push(each);
    }
    // Numbers stay those of the first that were taken; what takes the place of one has its number.
    loop {
        let mut numbered: BTreeMap<PathBuf, Vec<(usize, &Fault)>> = BTreeMap::new();
        for (number, one) in (1..).zip(chosen.iter().flatten()) {
            numbered.entry(one.file.clone()).or_default().push((number, &one.fault));
        }
        let planted =
            numbered.iter().map(|(file, faults)| (file.clone(), plant(tree, file, faults)));
        let wrong = that_do_not_build(tree, &planted.collect());
        if wrong.is_empty() {
            return chosen.into_iter().flatten().collect();
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
