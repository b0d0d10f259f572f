//! A picture does not depend on the order in which a driver's threads come to the drops, nor on how many turns of its loops
//! a driver allows.

use std::collections::BTreeSet;
use std::path::Path;

/// Bytes of a picture that a process of its own draws with so many threads of llvmpipe, and what it says.
fn drawn(scene: &Path, threads: &str, to: &Path) -> (Vec<u8>, String) {
    let mut command = crate::common::raindrops();
    command.arg("render").arg(scene).args(["--preset", "fast", "-o"]).arg(to);
    let output = command.env("LP_NUM_THREADS", threads).output().expect("a process");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (std::fs::read(to).expect("a picture"), said)
}

/// Draws a scene of `tests/data` four times, with one thread and with two, and asks for the same bytes and that nothing is lost.
fn is_the_same_in_every_run(name: &str) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let folder = crate::common::folder();
    let mut all = BTreeSet::new();
    for (run, threads) in ["1", "2", "2", "2"].into_iter().enumerate() {
        let to = folder.path().join(format!("{run}.exr"));
        let (bytes, said) = drawn(&scene, threads, &to);
        assert!(!said.contains("not drawn"), "{said}");
        all.insert(bytes);
    }
    assert_eq!(all.len(), 1, "four runs gave {} pictures", all.len());
}

#[test]
fn glints_of_blurred_drops_are_the_same_in_every_run() {
    is_the_same_in_every_run("lamps-lens.toml");
}

/// Larger drops are streaks over hundreds of tiles each.
#[test]
fn rain_towards_the_camera_is_the_same_in_every_run() {
    is_the_same_in_every_run("towards.toml");
}
