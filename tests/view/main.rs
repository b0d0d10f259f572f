//! The window for real: in a virtual X server (Xvfb), under validation, with keys, resizes and dropped
//! files sent as a keyboard, a window manager and a file manager send them, and with a driver that fails
//! or is slow.

#[path = "../common/mod.rs"]
mod common;

mod dropped;
mod faults;
mod guide;
mod seen;
mod waits;

use std::path::Path;
use std::time::Duration;

use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, InputFocus, PropMode};
use x11rb::wrapper::ConnectionExt as _;

use seen::{Opened, SIZE, Seen, key, wait_for};

/// For how long a window is watched that should rest.
const REST: Duration = Duration::from_secs(2);

/// How often the window is resized.
const RESIZES: u32 = 200;

/// The scene file of what one sees gives the same picture.
fn assert_kept_is(folder: &Path, seen: &Seen, picture: &[u8]) {
    seen.press(&[key::CONTROL, key::S]);
    let scene = folder.join("raindrops-0001.toml");
    wait_for("a scene file", || scene.exists().then_some(()));
    let drawn = folder.join("drawn.png");
    let mut render = common::raindrops();
    render.arg("render").arg(&scene).arg("-o").arg(&drawn);
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        render.args(["--device", &device]);
    }
    assert!(render.output().expect("it renders").status.success());
    assert!(
        picture == std::fs::read(&drawn).expect("a picture"),
        "the scene file is another picture"
    );
}

#[test]
fn a_window_in_use() {
    let mut opened = Opened::new(|_| ());
    let (seen, folder) = (&mut opened.seen, &opened.folder);

    // Stopped, two pictures are one, and the panel is no part of them.
    let first = seen.screenshot(&[key::F12]);
    assert!(first == seen.screenshot(&[key::F12]), "stopped, two screenshots differ");
    assert!(first != seen.screenshot(&[key::SHIFT, key::F12]), "the panel is not to be seen");

    // A key that is held asks once: the next picture is that of the next key.
    seen.hold(key::F12);
    assert!(first == seen.next_screenshot());
    assert!(first != seen.screenshot(&[key::SHIFT, key::F12]), "F12 was held, and asked again");

    assert_kept_is(folder.path(), seen, &first);

    // A step on and a step back; time runs, is turned, and stops where it began.
    seen.press(&[key::PERIOD]);
    assert!(first != seen.screenshot(&[key::F12]), "after a step it is the same picture");
    seen.press(&[key::COMMA]);
    assert!(first == seen.screenshot(&[key::F12]), "a step on and back is another picture");
    seen.press(&[key::SPACE]);
    seen.wait_for_title("it runs", |title| !title.ends_with("stopped"));
    assert!(first != seen.screenshot(&[key::F12]), "time does not run");
    seen.press(&[key::R]);
    seen.wait_for_title("it is back", |title| title.ends_with("stopped"));
    assert!(first == seen.screenshot(&[key::F12]), "rewound, the first picture is not back");

    // Another preset is another picture; back to the first it is the same.
    seen.press(&[key::ONE]);
    assert!(first != seen.screenshot(&[key::F12]), "the paper's picture is that of `fast`");
    seen.press(&[key::TWO]);
    assert!(first == seen.screenshot(&[key::F12]), "`fast` again, it is another picture");

    for number in 0..RESIZES {
        seen.resize((40 + (number * 61) % 400, 30 + (number * 37) % 300));
    }
    seen.resize(SIZE);
    assert!(first == seen.screenshot(&[key::F12]), "resized and back, it is another picture");

    // Minimised and back.
    seen.x.unmap_window(seen.window).expect("unmapped");
    seen.x.map_window(seen.window).expect("mapped");
    seen.x.sync().expect("the X server answers");
    let window = seen.window;
    let focus = || seen.x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
    wait_for("the window is back", || focus().ok()?.check().ok());

    // Two models side by side, measured; then flying, until the picture has changed.
    seen.press(&[key::B]);
    let split = seen.screenshot(&[key::F12]);
    assert!(first != split, "the split view is not to be seen");
    seen.press(&[key::M]);
    seen.key(key::W, true);
    wait_for("it flies", || (split != seen.screenshot(&[key::F12])).then_some(()));
    seen.key(key::W, false);

    opened.close();
}

/// A windscreen in the rain: wiped, it gathers drops again as time goes by, and a kept scene has what is seen.
#[test]
fn a_pane_in_a_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "[pane]\ndistance = 0.3\nrate = 50.0\nvelocity = [0, 0, -14]\nage = 5.0\nextent = [0.4, 0.3]\nsimulation = \"running\"\n";
    let path = folder.path().join("pane.toml");
    std::fs::write(&path, scene).expect("a scene");
    let mut opened = Opened::on((640, 480), SIZE, |command| {
        command.arg("--validate").arg(&path);
    });
    let seen = &mut opened.seen;
    let rained = seen.screenshot(&[key::F12]);
    seen.press(&[key::X]);
    let wiped = seen.screenshot(&[key::F12]);
    assert!(wiped != rained, "it is not wiped");
    seen.press(&[key::SPACE]);
    seen.wait_for_title("it runs", |title| !title.ends_with("stopped"));
    wait_for("drops arrive", || (wiped != seen.screenshot(&[key::F12])).then_some(()));
    seen.press(&[key::SPACE]);
    seen.wait_for_title("it stands still", |title| title.ends_with("stopped"));
    let later = seen.screenshot(&[key::F12]);
    assert_kept_is(opened.folder.path(), seen, &later);
    opened.close();
}

/// A window in which nothing changes looks four times a second whether something has, and leaves the processor alone.
#[test]
fn a_window_at_rest() {
    let mut opened = Opened::new(|_| ());
    opened.seen.screenshot(&[key::F12]);
    wait_for("the message about the screenshot goes, and the window rests", || {
        let before = opened.processor_seconds();
        std::thread::sleep(REST);
        (opened.processor_seconds() - before < 0.3 * REST.as_secs_f64()).then_some(())
    });
    opened.close();
}

/// Without a display: one line, exit status 2.
#[test]
fn no_display_is_told() {
    let output = common::raindrops().arg("view").output().expect("the program starts");
    let line = common::said::failure(&output, 2);
    assert!(line.contains("cannot open a window"), "{line}");
    assert!(line.contains("`raindrops render`") && !line.contains(".rs:"), "{line}");
}

/// A screen of twice as many dots an inch asks for a window of twice as many pixels.
#[test]
fn another_scale_factor() {
    let mut opened = Opened::new(|_| ());
    let seen = &mut opened.seen;
    let first = seen.screenshot(&[key::F12]);
    for (dots_an_inch, scale) in [(192, 2), (96, 1)] {
        let resources = format!("Xft.dpi:\t{dots_an_inch}\n");
        let (replace, name) = (PropMode::REPLACE, AtomEnum::RESOURCE_MANAGER);
        // The screen has it, and by the window winit hears of it.
        for window in [seen.root, seen.window] {
            seen.x
                .change_property8(replace, window, name, AtomEnum::STRING, resources.as_bytes())
                .expect("a resource");
        }
        seen.x.sync().expect("the X server answers");
        let size = format!("{} x {}", scale * SIZE.0, scale * SIZE.1);
        seen.wait_for_title(&size, |title| title.contains(&size));
        let is_first = first == seen.screenshot(&[key::F12]);
        assert_eq!(is_first, scale == 1, "at {dots_an_inch} dots an inch");
    }
    opened.close();
}
