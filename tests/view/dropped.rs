//! Files dropped on the window, by the protocol that file managers use under X (XDND).

use std::path::Path;

use raindrops::picture::write_png;
use raindrops::scene::Scene;
use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_FROM_PARENT, CURRENT_TIME};

use crate::seen::{Opened, Seen, key, wait_for};

/// Drops a file on the window and returns when the program has taken it.
fn drop_file(seen: &Seen, path: &Path) {
    let (x, window) = (&seen.x, seen.window);
    let atom = |name: &str| {
        x.intern_atom(false, name.as_bytes()).expect("an atom").reply().expect("an atom").atom
    };
    let source = x.generate_id().expect("a name");
    let (class, aux) = (WindowClass::INPUT_ONLY, CreateWindowAux::new());
    x.create_window(0, source, seen.root, 0, 0, 1, 1, 0, class, COPY_FROM_PARENT, &aux)
        .expect("a window to drag from");
    let (selection, uris) = (atom("XdndSelection"), atom("text/uri-list"));
    x.set_selection_owner(source, selection, CURRENT_TIME).expect("the selection");
    let tell = |name: &str, data: [u32; 5]| {
        let message = ClientMessageEvent::new(32, window, atom(name), data);
        x.send_event(false, window, EventMask::NO_EVENT, message).expect("a message");
        x.flush().expect("the X server answers");
    };
    tell("XdndEnter", [source, 5 << 24, uris, 0, 0]);
    tell("XdndPosition", [source, 0, 0, CURRENT_TIME, atom("XdndActionCopy")]);
    // The window asks what is being dragged.
    let asked = wait_for("it asks for the files", || match x.poll_for_event().ok()?? {
        Event::SelectionRequest(asked) => Some(asked),
        _ => None,
    });
    let uri = format!("file://{}\r\n", path.display());
    x.change_property8(PropMode::REPLACE, asked.requestor, asked.property, uris, uri.as_bytes())
        .expect("the files");
    let told = SelectionNotifyEvent {
        response_type: SELECTION_NOTIFY_EVENT,
        sequence: 0,
        time: asked.time,
        requestor: asked.requestor,
        selection,
        target: asked.target,
        property: asked.property,
    };
    x.send_event(false, asked.requestor, EventMask::NO_EVENT, told).expect("a message");
    tell("XdndDrop", [source, 0, 0, 0, 0]);
    let finished = atom("XdndFinished");
    wait_for("it has the files", || match x.poll_for_event().ok()?? {
        Event::ClientMessage(message) if message.type_ == finished => Some(()),
        _ => None,
    });
    x.destroy_window(source).expect("the window to drag from goes");
}

#[test]
fn dropped_files() {
    let mut opened = Opened::new(|_| ());
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| std::fs::write(path(name), bytes).expect("a file");
    let first = opened.seen.screenshot(&[key::F12]);

    // An environment.
    let above_and_below = [vec![[250, 120, 30]; 64 * 16], vec![[10, 60, 200]; 64 * 16]].concat();
    write_png(&path("two.png"), 64, 32, above_and_below.as_flattened()).expect("a picture");
    drop_file(&opened.seen, &path("two.png"));
    let good = opened.seen.screenshot(&[key::F12]);
    assert!(good != first, "the environment is not seen");

    // What is none: told, and the last good one stays.
    let sky = std::fs::read("assets/sky.exr").expect("the bundled sky");
    write("cut.exr", &sky[..sky.len() / 2]);
    write("notes.txt", b"not a picture");
    write("scene.toml", b"[rain]\ncuont = 3\n");
    std::fs::create_dir(path("folder")).expect("a folder");
    for (name, problem) in [
        ("cut.exr", "is broken or cut off"),
        ("notes.txt", "is not an OpenEXR, Radiance HDR, PNG or JPEG image"),
        ("folder", "is a folder, not an image file"),
        ("scene.toml", "did you mean `count`?"),
    ] {
        drop_file(&opened.seen, &path(name));
        opened.hear(problem);
        let said = opened.said();
        let line = said.lines().find(|line| line.contains(problem)).expect("a line");
        assert!(line.contains(name), "which file? {line}");
        assert!(good == opened.seen.screenshot(&[key::F12]), "{name} changes the picture");
        // The window still does what it is asked for.
        opened.seen.press(&[key::ONE]);
        assert!(good != opened.seen.screenshot(&[key::F12]), "after {name} it heeds nothing");
        opened.seen.press(&[key::TWO]);
        assert!(good == opened.seen.screenshot(&[key::F12]), "after {name} it is another picture");
    }
    opened.seen.press(&[key::CONTROL, key::S]);
    let kept = opened.folder.path().join("raindrops-0001.toml");
    wait_for("a scene file", || kept.exists().then_some(()));
    let kept = Scene::load(&kept).expect("a scene");
    assert!(kept.environment.file.is_some_and(|file| file.ends_with("two.png")));

    // A scene; and one whose environment is not there, which has the one before.
    write("one.toml", b"[[drop]]\ncenter = [0, 0, -4]\n[environment]\nfile = \"two.png\"\n");
    drop_file(&opened.seen, &path("one.toml"));
    opened.seen.wait_for_title("the scene's name", |title| title.contains("one.toml"));
    let one = opened.seen.screenshot(&[key::F12]);
    assert!(one != good, "the scene is not seen");
    write("lacks.toml", b"[[drop]]\ncenter = [0, 0, -4]\n[environment]\nfile = \"none.exr\"\n");
    drop_file(&opened.seen, &path("lacks.toml"));
    opened.hear("none.exr");
    assert!(one == opened.seen.screenshot(&[key::F12]), "the last good environment is gone");
    opened.close();
}
