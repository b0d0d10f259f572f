//! The documents: every link leads somewhere, and every source file that they name is there.

use std::fs;
use std::path::{Path, PathBuf};

/// A document, as its path below the package and its text without blocks of code.
fn documents() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
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

/// The name by which GitHub links to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | ' '));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// What stands between `from` and `to`, each time.
fn between<'a>(text: &'a str, from: &str, to: char) -> Vec<&'a str> {
    text.split(from).skip(1).filter_map(|rest| rest.split(to).next()).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
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
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
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
