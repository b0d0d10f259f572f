//! The window for real: in a virtual X server (Xvfb), under validation, with keys and resizes sent
//! as a keyboard and a window manager send them.

mod common;

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConfigureWindowAux, ConnectionExt as _, InputFocus, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// The window's size, and how often it is resized.
const SIZE: (u32, u32) = (160, 120);
const RESIZES: u32 = 200;

/// How long to wait for what must happen.
const PATIENCE: Duration = Duration::from_secs(60);

/// Key codes of X: those of evdev, and 8.
mod key {
    pub const ESCAPE: u8 = 9;
    pub const ONE: u8 = 10;
    pub const TWO: u8 = 11;
    pub const R: u8 = 27;
    pub const W: u8 = 25;
    pub const CONTROL: u8 = 37;
    pub const S: u8 = 39;
    pub const SHIFT: u8 = 50;
    pub const B: u8 = 56;
    pub const M: u8 = 58;
    pub const PERIOD: u8 = 60;
    pub const COMMA: u8 = 59;
    pub const SPACE: u8 = 65;
    pub const F12: u8 = 96;
}

/// A process that does not outlive the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits for something to be so.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what}: not after {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A virtual X server and its display.
fn x_server() -> (Running, String) {
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map(Running)
        .expect("this test needs Xvfb (scripts/test.sh installs it)");
    let mut number = String::new();
    let stdout = server.0.stdout.take().expect("a pipe");
    BufReader::new(stdout).read_line(&mut number).expect("Xvfb tells its display");
    (server, format!(":{}", number.trim()))
}

/// The open window, seen from outside.
struct Seen {
    x: RustConnection,
    root: Window,
    window: Window,
    folder: PathBuf,
    pictures: u32,
}

impl Seen {
    fn title(x: &RustConnection, window: Window) -> Option<String> {
        let name = x.intern_atom(false, b"_NET_WM_NAME").ok()?.reply().ok()?.atom;
        let title =
            x.get_property(false, window, name, AtomEnum::ANY, 0, 1024).ok()?.reply().ok()?;
        Some(String::from_utf8_lossy(&title.value).into_owned())
    }

    /// Waits for the window of `display`.
    fn open(display: &str, folder: &Path) -> Self {
        let (x, screen) = x11rb::connect(Some(display)).expect("the X server answers");
        let root = x.setup().roots[screen].root;
        let window = wait_for("a window", || {
            let windows = x.query_tree(root).ok()?.reply().ok()?.children;
            let is_ours = |w: &Window| Self::title(&x, *w).is_some_and(|t| t.contains(" x "));
            windows.into_iter().find(is_ours)
        });
        // There is no window manager to give it the keyboard.
        x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).expect("the focus");
        x.sync().expect("the X server answers");
        Self { x, root, window, folder: folder.into(), pictures: 0 }
    }

    fn wait_for_title(&self, what: &str, is_so: impl Fn(&str) -> bool) {
        wait_for(what, || Self::title(&self.x, self.window).filter(|title| is_so(title)));
    }

    fn key(&self, code: u8, is_down: bool) {
        let kind = if is_down { 2 } else { 3 }; // KeyPress, KeyRelease
        self.x.xtest_fake_input(kind, code, 0, self.root, 0, 0, 0).expect("a key");
        self.x.sync().expect("the X server answers");
    }

    /// Presses keys together and lets them go.
    fn press(&self, codes: &[u8]) {
        codes.iter().for_each(|code| self.key(*code, true));
        codes.iter().rev().for_each(|code| self.key(*code, false));
    }

    fn resize(&self, (width, height): (u32, u32)) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.x.configure_window(self.window, &size).expect("a resize");
        self.x.sync().expect("the X server answers");
        let shown = format!("{width} x {height}");
        self.wait_for_title(&shown, |title| title.contains(&shown));
    }

    /// Takes a screenshot by the keys and waits for its file.
    fn screenshot(&mut self, keys: &[u8]) -> Vec<u8> {
        self.pictures += 1;
        let path = self.folder.join(format!("raindrops-{:04}.png", self.pictures));
        self.press(keys);
        wait_for("a screenshot", || std::fs::read(&path).ok())
    }
}

trait Sync {
    fn sync(&self) -> Result<(), x11rb::errors::ReplyError>;
}

impl Sync for RustConnection {
    fn sync(&self) -> Result<(), x11rb::errors::ReplyError> {
        x11rb::protocol::xproto::ConnectionExt::get_input_focus(self)?.reply().map(drop)
    }
}

#[test]
fn a_window_in_use() {
    let (_server, display) = x_server();
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = common::raindrops();
    let size = format!("{}x{}", SIZE.0, SIZE.1);
    command
        .args(["view", "--paused", "--validate", "--preset", "fast", "--drops", "20000"])
        .args(["--size", &size, "--output"])
        .arg(folder.path())
        .env("DISPLAY", &display)
        .env_remove("WAYLAND_DISPLAY")
        .stderr(Stdio::piped());
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        command.args(["--device", &device]);
    }
    let mut viewer = Running(command.spawn().expect("the program starts"));
    let mut seen = Seen::open(&display, folder.path());
    seen.wait_for_title("it stands still", |title| title.ends_with("stopped"));

    // Stopped, two pictures are one, and the panel is no part of them.
    let first = seen.screenshot(&[key::F12]);
    assert!(first == seen.screenshot(&[key::F12]), "stopped, two screenshots differ");
    assert!(first != seen.screenshot(&[key::SHIFT, key::F12]), "the panel is not to be seen");

    // The scene file of what one sees gives the same picture.
    seen.press(&[key::CONTROL, key::S]);
    let scene = folder.path().join("raindrops-0001.toml");
    wait_for("a scene file", || scene.exists().then_some(()));
    let drawn = folder.path().join("drawn.png");
    let mut render = common::raindrops();
    render.arg("render").arg(&scene).arg("-o").arg(&drawn);
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        render.args(["--device", &device]);
    }
    assert!(render.output().expect("it renders").status.success());
    assert!(
        first == std::fs::read(&drawn).expect("a picture"),
        "the scene file is another picture"
    );

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

    seen.press(&[key::ESCAPE]);
    let status = wait_for("it closes", || viewer.0.try_wait().expect("a status"));
    let mut said = String::new();
    let stderr = viewer.0.stderr.as_mut().expect("a pipe");
    stderr.read_to_string(&mut said).expect("text");
    assert!(status.success(), "{status}: {said}");
}

/// Without a display: one line, exit status 2.
#[test]
fn no_display_is_told() {
    let output = common::raindrops()
        .arg("view")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot open a window") && said.trim().lines().count() == 1, "{said}");
}
