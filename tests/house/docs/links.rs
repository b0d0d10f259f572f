//! What documents link to and name is there: files, headings, sources; and the table of files has every source.

use std::collections::BTreeSet;
use std::fs;

use super::{between, documents, prose, root};

/// The name by which GitHub links to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | ' '));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let root = root();
    let mut links = 0;
    for (path, text) in documents() {
        let here = root.join(&path);
        for link in between(&text, "](", ')') {
            if link.starts_with("http") {
                continue;
            }
            links += 1;
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => here.clone(),
                file => here.parent().expect("a folder").join(file),
            };
            assert!(target.exists(), "{}: {link}: there is no such file", path.display());
            if !heading.is_empty() {
                let text = prose(&target);
                let headings = text.lines().filter(|line| line.starts_with('#'));
                let found =
                    headings.map(|line| anchor(line.trim_start_matches('#'))).any(|a| a == heading);
                assert!(found, "{}: {link}: there is no such heading", path.display());
            }
        }
    }
    assert!(links > 100, "{links} links: are they looked for?");
}

#[test]
fn every_source_that_is_named_is_there() {
    let root = root();
    let mut names = 0;
    for (path, text) in documents() {
        for name in between(&text, "`", '`') {
            let is_path = ["src/", "glsl/", "tests/", "scripts/", "examples/", "benches/"]
                .iter()
                .any(|folder| name.starts_with(folder) && name.len() > folder.len());
            if !is_path || name.contains([' ', '*', '…']) || name.contains("NAME") {
                continue;
            }
            names += 1;
            assert!(root.join(name).exists(), "{}: there is no {name}", path.display());
        }
    }
    assert!(names > 100, "{names} names: are they looked for?");
}

/// The table of files names what is there, and every source has a row: its own, or that of a folder.
#[test]
fn every_source_has_a_row_in_the_table_of_files() {
    let text = fs::read_to_string(root().join("docs/architecture.md")).expect("a document");
    let table = text.split("\n## Files").nth(1).expect("the table");
    let table = table.split("\n## ").next().expect("its part");
    let mut rows: BTreeSet<String> = BTreeSet::new();
    for row in table.lines().filter(|line| line.starts_with("| `")) {
        let mut folder = String::new();
        let cell = row.split(" | ").next().expect("a cell");
        for name in between(cell, "`", '`').into_iter().step_by(2) {
            // Only the first has its whole path; the others may be in the same folder.
            let path = match root().join(name).exists() || name.contains('*') {
                true => name.to_string(),
                false => format!("{folder}{name}"),
            };
            assert!(name.contains('*') || root().join(&path).exists(), "there is no {path}");
            folder = path
                .trim_end_matches('/')
                .rsplit_once('/')
                .map_or(String::new(), |(of, _)| format!("{of}/"));
            rows.insert(path);
        }
    }
    let mut folders =
        ["src", "benches", "examples", "python/src", "scripts"].map(String::from).to_vec();
    let (mut sources, mut without) = (0, Vec::new());
    while let Some(folder) = folders.pop() {
        if rows.contains(&format!("{folder}/")) {
            continue;
        }
        for entry in fs::read_dir(root().join(&folder)).expect("a folder") {
            let entry = entry.expect("an entry");
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                folders.push(path);
            } else {
                sources += 1;
                if !rows.contains(&path) && !rows.contains(&format!("{folder}/*.rs")) {
                    without.push(path);
                }
            }
        }
    }
    assert!(without.is_empty(), "docs/architecture.md has no row for {without:?}");
    assert!(sources > 150, "{sources} sources: are they looked for?");
}
