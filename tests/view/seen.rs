//! A window of the program in a virtual X server, seen and used from outside.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConfigureWindowAux, ConnectionExt as _, ImageFormat, InputFocus, MapState, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use crate::common;

/// The window's size.
pub const SIZE: (u32, u32) = (160, 120);

/// How long to wait for what must happen.
const PATIENCE: Duration = Duration::from_secs(600);

/// Key codes of X: those of evdev, and 8.
pub mod key {
    pub const ESCAPE: u8 = 9;
    pub const X: u8 = 53;
    pub const ONE: u8 = 10;
    pub const TWO: u8 = 11;
    pub const R: u8 = 27;
    pub const W: u8 = 25;
    pub const H: u8 = 43;
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
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits for something to be so.
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what}: not after {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A virtual X server with a screen of that size, and its display.
fn x_server(screen: (u32, u32)) -> (Running, String) {
    let screen = format!("{}x{}x24", screen.0, screen.1);
    let mut server = common::command("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp"])
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
pub struct Seen {
    pub x: RustConnection,
    pub root: Window,
    pub window: Window,
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
        let focus = || x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
        wait_for("the window has the keyboard", || focus().ok()?.check().ok());
        Self { x, root, window, folder: folder.into(), pictures: 0 }
    }

    pub fn wait_for_title(&self, what: &str, is_so: impl Fn(&str) -> bool) {
        wait_for(what, || {
            let title = Self::title(&self.x, self.window).expect("the window is open");
            Some(title).filter(|title| is_so(title))
        });
    }

    pub fn key(&self, code: u8, is_down: bool) {
        let kind = if is_down { 2 } else { 3 }; // KeyPress, KeyRelease
        self.x.xtest_fake_input(kind, code, 0, self.root, 0, 0, 0).expect("a key");
        self.x.sync().expect("the X server answers");
    }

    /// Presses keys together and lets them go.
    pub fn press(&self, codes: &[u8]) {
        codes.iter().for_each(|code| self.key(*code, true));
        codes.iter().rev().for_each(|code| self.key(*code, false));
    }

    /// The upper rows of what the screen shows of the window, where the panel is hidden: no line of the
    /// overlay is there.
    pub fn upper_rows(&self) -> Vec<u8> {
        let (width, height) = (SIZE.0 as u16, SIZE.1 as u16 / 3);
        let image = self.x.get_image(ImageFormat::Z_PIXMAP, self.window, 0, 0, width, height, !0);
        image.expect("an image").reply().expect("the window is shown").data
    }

    /// Whether the window is on the screen.
    pub fn is_shown(&self) -> bool {
        let attributes = self.x.get_window_attributes(self.window).expect("attributes").reply();
        attributes.is_ok_and(|attributes| attributes.map_state == MapState::VIEWABLE)
    }

    pub fn resize(&self, (width, height): (u32, u32)) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.x.configure_window(self.window, &size).expect("a resize");
        self.x.sync().expect("the X server answers");
        let shown = format!("{width} x {height}");
        self.wait_for_title(&shown, |title| title.contains(&shown));
    }

    /// Holds a key for so long that the X server repeats it, after 0.66 seconds.
    pub fn hold(&self, code: u8) {
        self.key(code, true);
        std::thread::sleep(Duration::from_millis(1000));
        self.key(code, false);
    }

    /// Takes a screenshot by the keys and waits for its file.
    pub fn screenshot(&mut self, keys: &[u8]) -> Vec<u8> {
        self.press(keys);
        self.next_screenshot()
    }

    /// Waits for the file of the next screenshot.
    pub fn next_screenshot(&mut self) -> Vec<u8> {
        self.pictures += 1;
        let path = self.folder.join(format!("raindrops-{:04}.png", self.pictures));
        wait_for("a screenshot", || {
            let picture = std::fs::read(&path).ok();
            // Without its window no program writes one.
            let is_open = picture.is_some() || Self::title(&self.x, self.window).is_some();
            assert!(is_open, "the window closed before there was a screenshot");
            picture
        })
    }
}

/// The program with its window, an X server for it, and a folder for what it keeps.
pub struct Opened {
    pub seen: Seen,
    pub folder: TempDir,
    viewer: Running,
    _server: Running,
}

/// A test that waits for what does not happen shows what there was instead.
impl Drop for Opened {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let Seen { x, window, .. } = &self.seen;
            let focus = x.get_input_focus().ok().and_then(|focus| focus.reply().ok());
            eprintln!("the title: {:?}", Seen::title(x, *window));
            eprintln!("the keyboard: {:?}, the window: {window}", focus.map(|reply| reply.focus));
            eprintln!(
                "the program's end: {:?}, and it said: {}",
                self.viewer.0.try_wait(),
                self.said()
            );
        }
    }
}

impl Opened {
    /// Opens the window on rain that stands still, under validation; `adjust` may change the command.
    pub fn new(adjust: impl FnOnce(&mut Command)) -> Self {
        Self::on((640, 480), SIZE, |command| {
            command.args(["--validate", "--drops", "20000"]);
            adjust(command);
        })
    }

    /// Opens the window with that size, on a screen of another, on rain that stands still.
    pub fn on(screen: (u32, u32), size: (u32, u32), adjust: impl FnOnce(&mut Command)) -> Self {
        let (server, display) = x_server(screen);
        let folder = tempfile::tempdir().expect("a folder");
        let said = File::create(folder.path().join("said")).expect("a file");
        let mut command = common::raindrops();
        let size = format!("{}x{}", size.0, size.1);
        command
            .args(["view", "--paused", "--preset", "fast", "--size", &size, "--output"])
            .arg(folder.path())
            .env("DISPLAY", &display)
            .stderr(said);
        if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
            command.args(["--device", &device]);
        }
        adjust(&mut command);
        let viewer = Running(command.spawn().expect("the program starts"));
        let seen = Seen::open(&display, folder.path());
        seen.wait_for_title("it stands still", |title| title.ends_with("stopped"));
        Self { seen, folder, viewer, _server: server }
    }

    /// All that the program has said on stderr.
    pub fn said(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("said")).expect("text")
    }

    /// Waits until the program has said something.
    pub fn hear(&self, what: &str) {
        wait_for(what, || self.said().contains(what).then_some(()));
    }

    /// Processor time of the program so far, of all its threads, in seconds.
    pub fn processor_seconds(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.viewer.0.id()));
        let stat = stat.expect("a process of Linux");
        // After the name, which is in parentheses, fields 3 and further; a hundred ticks are a second.
        let fields = stat.rsplit(") ").next().expect("fields").split(' ');
        fields.skip(11).take(2).map(|ticks| ticks.parse::<f64>().expect("ticks")).sum::<f64>()
            / 100.0
    }

    /// Whether the program is still at work.
    pub fn is_running(&mut self) -> bool {
        self.viewer.0.try_wait().expect("a status").is_none()
    }

    /// Waits for the program's end.
    pub fn end(&mut self) -> ExitStatus {
        wait_for("it ends", || self.viewer.0.try_wait().expect("a status"))
    }

    /// Closes the window, which must end well: validation had nothing to say either.
    pub fn close(mut self) {
        self.seen.press(&[key::ESCAPE]);
        let status = self.end();
        assert!(status.success(), "{status}: {}", self.said());
    }
}
