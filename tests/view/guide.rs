//! The guide's pictures of the window. `scripts/figures.sh window` runs this; it is no test by itself.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::seen::{Opened, key};

/// The pictures' size.
const SIZE: (u32, u32) = (1100, 700);

/// How long the rain falls before it is stopped: until the graph of frame times is full.
const FALLING: Duration = Duration::from_secs(8);

#[test]
#[ignore = "makes docs/pictures/window.png and split.png, with times of this machine"]
fn the_guides_pictures() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut opened = Opened::on((1280, 800), SIZE, |command| {
        command.arg(root.join("assets/scenes/rain.toml")).args(["--drops", "200000"]);
    });
    let seen = &mut opened.seen;
    seen.press(&[key::SPACE]);
    std::thread::sleep(FALLING);
    seen.press(&[key::SPACE]);
    seen.wait_for_title("it stands still", |title| title.ends_with("stopped"));
    std::thread::sleep(Duration::from_secs(2));
    let pictures = std::env::var_os("RAINDROPS_PICTURES")
        .map_or_else(|| root.join("docs/pictures"), PathBuf::from);
    let write = |name, picture: Vec<u8>| {
        std::fs::write(pictures.join(name), picture).expect("a picture");
    };
    write("window.png", seen.screenshot(&[key::SHIFT, key::F12]));

    // `paper` beside the model that a second one begins with, which is `exact`.
    seen.press(&[key::ONE]);
    seen.screenshot(&[key::F12]);
    seen.press(&[key::B]);
    std::thread::sleep(Duration::from_secs(10));
    write("split.png", seen.screenshot(&[key::F12]));
    opened.close();
}
