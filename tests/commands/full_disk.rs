//! Every command that writes a file, where the disk takes no more: one line, exit status 2, what was
//! there before still there, and nothing beside it.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use raindrops::picture::Picture;

use crate::common::said::failure;
use crate::common::{folder, outcome};
use crate::data_sets::files;

/// Bytes that a file may have; the kernel then fails writes as it does where a disk is full.
const ROOM: &str = "--fsize=64";

/// A command that a limit on the size of files fails and does not kill.
fn limited(folder: &Path, limit: Option<&str>, arguments: &[&str]) -> Command {
    let program = crate::common::raindrops();
    let mut command = crate::common::command("sh");
    command.args(["-c", "trap '' XFSZ; exec \"$@\"", "sh"]);
    if let Some(limit) = limit {
        command.args(["prlimit", limit, "--"]);
    }
    command.arg(program.get_program()).args(arguments).current_dir(folder);
    command
}

const SCENE: [&str; 6] = ["--drops", "20", "--size", "16x16", "--preset", "paper"];
const BRIEF: [&str; 4] = ["--seconds", "0", "--frames", "1"];

/// Each command, and the file that it writes last; `null.*` lead to a device and take all.
fn commands() -> Vec<(Vec<&'static str>, &'static str)> {
    let with = |parts: &[&[&'static str]]| parts.concat();
    let (all, few) = (&SCENE[..], &SCENE[..4]);
    let reference = ["reference", "--samples", "1"];
    let tradeoff =
        ["tradeoff", "--truth-samples", "1", "--models", "snorm16", "--json", "null.json"];
    vec![
        (with(&[&["render"], all, &["-o"]]), "a.png"),
        (with(&[&["render"], all, &["-o"]]), "a.exr"),
        // The manifest comes first.
        (with(&[&["render"], all, &["--frames", "2", "-o", "b.png"]]), "b.frames.toml"),
        (with(&[&reference, few, &["-o"]]), "a.exr"),
        (with(&[&reference, few, &["-o", "null.png", "--coverage"]]), "a.exr"),
        (vec!["sky", "--width", "16", "-o"], "a.exr"),
        (vec!["sky", "--width", "16", "-o"], "a.png"),
        (vec!["compare", "one.exr", "one.exr", "--json"], "a.json"),
        (vec!["compare", "one.exr", "one.exr", "--difference"], "a.png"),
        (with(&[&["bench"], all, &BRIEF, &["--json"]]), "a.json"),
        (with(&[&["bench"], all, &BRIEF, &["--json", "null.json", "--svg"]]), "a.svg"),
        (with(&[&tradeoff[..], few, &BRIEF, &["--csv"]]), "a.csv"),
        (with(&[&tradeoff[..], few, &BRIEF, &["--csv", "null.csv", "--svg"]]), "a.svg"),
        (vec!["devices", "--probe", "--json"], "a.json"),
        (vec!["mask", "--mask-size", "4", "-o"], "masks/level-00-reflected.exr"),
    ]
}

/// Runs each command with its output at `name`, or in `name`'s folder where it wants a folder.
#[test]
fn a_full_disk_is_one_line_and_leaves_the_old_files() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let pixels = vec![glam::Vec3::ONE; 256];
    Picture { width: 16, height: 16, pixels }.write_exr(&at("one.exr")).expect("a picture");
    for name in ["null.png", "null.json", "null.csv"] {
        symlink("/dev/null", at(name)).expect("a link");
    }
    fs::create_dir(at("masks")).expect("a folder");
    for (mut arguments, name) in commands() {
        fs::write(at(name), "the old file").expect("a file");
        match name.split_once('/') {
            Some((folder, _)) => arguments.push(folder),
            None if arguments.contains(&"b.png") => {}
            None => arguments.push(name),
        }
        let before = files(folder.path());
        let line = failure(&outcome(&mut limited(folder.path(), Some(ROOM), &arguments)), 2);
        assert!(line.contains(&format!("cannot write {name}: File too large")), "{line}");
        let after = files(folder.path());
        assert!(after == before, "{arguments:?} left something behind");
    }
}

/// A device without room, as an output and as stdout; it is never replaced by a file.
#[test]
fn a_full_device_is_told_and_stays_a_device() {
    let folder = folder();
    let path = folder.path().join("full.png");
    symlink("/dev/full", &path).expect("a link");
    let sky = ["sky", "--width", "16", "-o", "full.png"];
    let line = failure(&outcome(&mut limited(folder.path(), None, &sky)), 2);
    assert!(line.contains("cannot write full.png: No space left on device"), "{line}");
    assert!(path.is_symlink() && path.metadata().is_ok_and(|there| !there.is_file()));

    sky_at(&folder.path().join("one.exr"));
    let compare = ["compare", "one.exr", "one.exr"];
    for arguments in [&["devices"][..], &["plan"], &["completions", "bash"], &compare] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let output = outcome(limited(folder.path(), None, arguments).stdout(full));
        let line = failure(&output, 2);
        assert!(line.contains("cannot write stdout: No space left"), "{arguments:?}: {line}");
    }
}

/// A file is written through a link, which stays.
#[test]
fn a_link_leads_to_the_new_file() {
    let folder = folder();
    let (link, target) = (folder.path().join("link.exr"), folder.path().join("target.exr"));
    fs::write(&target, "the old file").expect("a file");
    symlink("target.exr", &link).expect("a link");
    sky_at(&link);
    assert!(link.is_symlink());
    Picture::read(&target).expect("the new file");
    assert_eq!(files(folder.path()).len(), 2);
}

fn sky_at(path: &Path) {
    let output = crate::common::raindrops().args(["sky", "--width", "16", "-o"]).arg(path).output();
    assert!(output.expect("the command starts").status.success());
}

/// The sources of the program that have one of some words, by their place in `src`.
fn sources_with(words: &[&str]) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = fs::read_to_string(&path).expect("a source");
            if words.iter().any(|word| text.contains(word)) {
                let place = path.strip_prefix(&root).expect("a place in it");
                found.push(place.to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    found
}

/// That nothing is half written is one function's promise, so no other may write files.
#[test]
fn one_function_writes_files() {
    let ways = ["fs::write", "File::create", "OpenOptions::", "fs::copy", ".persist("];
    assert_eq!(sources_with(&ways), ["files.rs"]);
}

/// One function knows how other programs encode text. What else reads text reads the kernel's, or the shaders that
/// the program's own build reads, too.
#[test]
fn one_function_reads_text() {
    let kernels = ["measure/clocks.rs", "measure/others.rs", "measure/system.rs"];
    let ways = [
        "read_to_string",
        "serde_json::from_slice",
        "serde_json::from_reader",
        ".lines().map_while",
    ];
    assert_eq!(sources_with(&ways), [&["gpu/glsl.rs"][..], &kernels].concat());
    // Bytes that are text to nobody: pictures, pipelines, stages, particles, what is packed.
    let others = [
        "cli/report/page.rs",
        "cli/rounds/stages.rs",
        "cli/survey/mod.rs",
        "gpu/disk_cache.rs",
        "picture/mod.rs",
        "picture/read/mod.rs",
        "scene/particles/mod.rs",
    ];
    let found = sources_with(&["fs::read(", "File::open("]);
    let unknown: Vec<_> = found.iter().filter(|place| !others.contains(&place.as_str())).collect();
    assert_eq!(unknown, ["files.rs"]);
}
