//! The unsafe surface: every file that has any stands in `docs/stability.md`, with its reason.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_unsafe_file_is_listed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let listed = std::fs::read_to_string(root.join("docs/stability.md")).expect("the list");
    let mut files = Vec::new();
    sources(&root.join("src"), &mut files);
    let mut blocks = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source");
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let count: usize = code
            .map(|line| line.matches("unsafe {").count() + line.matches("unsafe fn").count())
            .sum();
        let name = file.strip_prefix(root).expect("below the root").display().to_string();
        let is_listed = listed.contains(&format!("`{name}`"));
        assert_eq!(count > 0, is_listed, "{name}: {count} unsafe blocks, listed: {is_listed}");
        blocks += count;
    }
    println!("{blocks} unsafe blocks");
    assert!(blocks > 10, "the count itself is wrong");
}
