//! The site of `scripts/site.sh`: every page of `docs/` is in its contents, and no link leads out of the folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::{between, documents, root};

const CONTENTS: &str = "docs/SUMMARY.md";

/// A link of a page, as a path below the package, without its heading. Outside of the package it is as it was.
fn resolved(page: &Path, link: &str) -> PathBuf {
    let mut path = page.parent().expect("a folder").to_path_buf();
    for part in Path::new(link.split('#').next().unwrap_or_default()).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            part => path.push(part),
        }
    }
    path
}

#[test]
fn every_page_is_in_the_contents_once() {
    let text = fs::read_to_string(root().join(CONTENTS)).expect("the contents");
    let links = between(&text, "](", ')').into_iter().filter(|link| !link.is_empty());
    let mut listed: Vec<PathBuf> = links.map(|link| resolved(Path::new(CONTENTS), link)).collect();
    listed.sort();
    let pages = documents().into_iter().map(|(path, _)| path);
    let pages: BTreeSet<PathBuf> =
        pages.filter(|path| path.starts_with("docs") && path != Path::new(CONTENTS)).collect();
    assert!(pages.len() > 20, "{} pages: are they looked for?", pages.len());
    assert_eq!(listed, Vec::from_iter(pages), "left: {CONTENTS}; right: the pages of docs/");
}

/// On the site there is nothing but the folder.
#[test]
fn no_link_of_a_page_leaves_the_folder() {
    let mut links = 0;
    for (page, text) in documents().into_iter().filter(|(page, _)| page.starts_with("docs")) {
        for link in between(&text, "](", ')') {
            if link.starts_with("http") || link.starts_with('#') {
                continue;
            }
            links += 1;
            let target = resolved(&page, link);
            assert!(target.starts_with("docs"), "{}: {link} leaves docs/", page.display());
        }
    }
    assert!(links > 100, "{links} links: are they looked for?");
}

/// What people read from top to bottom. Pages below "Understand" are for whoever changes the program.
#[test]
fn pages_for_users_are_short() {
    const MOST_WORDS: usize = 2500;
    let text = fs::read_to_string(root().join(CONTENTS)).expect("the contents");
    let (for_users, _) = text.split_once("# Understand").expect("the developers' part");
    let mut pages = vec![PathBuf::from("README.md")];
    let links = between(for_users, "](", ')').into_iter().filter(|link| !link.is_empty());
    pages.extend(links.map(|link| resolved(Path::new(CONTENTS), link)));
    // The help of every command, the tables of the schema, and measured ones.
    let is_looked_up = |page: &Path| page.ends_with("options.md") || page.ends_with("scene.md");
    pages.retain(|page| !is_looked_up(page) && !page.starts_with("docs/results"));
    assert!(pages.len() > 15, "{} pages: are they looked for?", pages.len());
    for page in pages {
        let words =
            fs::read_to_string(root().join(&page)).expect("a page").split_whitespace().count();
        assert!(words <= MOST_WORDS, "{}: {words} words, {MOST_WORDS} at most", page.display());
    }
}
