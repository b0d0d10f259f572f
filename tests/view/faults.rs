//! What a driver may say of a window at any time: its surface is out of date, has no area, is lost; the
//! device is lost.

use std::path::Path;
use std::process::Command;

use ash::vk::Result as R;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

use crate::common::said::{FAILURE, lines};
use crate::seen::{Opened, SIZE, key, wait_for};

const LAYER: &str = "VK_LAYER_RAINDROPS_fault";

/// Compiles `fault_layer.rs` into `folder`, with the manifest by which the loader finds it.
fn compile_layer(folder: &Path) {
    let compiled = Command::new("rustc")
        .args(["--edition", "2024", "--crate-type", "cdylib", "-o"])
        .arg(folder.join("fault.so"))
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/view/fault_layer.rs"))
        .status();
    assert!(compiled.expect("rustc").success(), "the layer does not compile");
    let manifest = serde_json::json!({ "file_format_version": "1.1.2", "layer": {
        "name": LAYER, "type": "GLOBAL", "library_path": "./fault.so",
        "api_version": "1.3.0", "implementation_version": "1", "description": "a call fails" } });
    std::fs::write(folder.join("fault.json"), manifest.to_string()).expect("a manifest");
}

/// A window whose driver fails, or keeps the program waiting, on demand.
pub struct Failing {
    pub opened: Opened,
    layer: tempfile::TempDir,
}

impl Failing {
    fn open() -> Self {
        Self::open_told("")
    }

    /// Opens the window with a driver that has been told something already.
    pub fn open_told(told: &str) -> Self {
        let layer = tempfile::tempdir().expect("a folder");
        compile_layer(layer.path());
        let fault = layer.path().join("fault");
        if !told.is_empty() {
            std::fs::write(&fault, told).expect("a file");
        }
        let opened = Opened::new(|command| {
            command.env("VK_ADD_LAYER_PATH", layer.path()).env("VK_INSTANCE_LAYERS", LAYER);
            command.env("RAINDROPS_FAULT", fault);
        });
        Self { opened, layer }
    }

    /// Tells the driver something.
    pub fn tell(&self, told: &str) {
        let [aside, place] = ["aside", "fault"].map(|name| self.layer.path().join(name));
        std::fs::write(&aside, told).expect("a file");
        std::fs::rename(aside, place).expect("a file");
    }

    /// Waits until a call waits, as the driver was told.
    pub fn wait_until_held(&self) {
        let held = self.layer.path().join("fault.held");
        wait_for("a call is held", || std::fs::remove_file(&held).ok());
    }

    /// Lets the call that waits go on.
    pub fn release(&self) {
        std::fs::remove_file(self.layer.path().join("fault")).expect("a call was held");
    }

    /// Lets the next call of a function return this.
    fn arm(&self, function: &str, result: R) {
        self.tell(&format!("{function} {}", result.as_raw()));
    }

    /// Waits until the call has failed.
    fn wait(&self) {
        let place = self.layer.path().join("fault");
        wait_for("the fault", || (!place.exists()).then_some(()));
    }

    fn fail(&self, function: &str, result: R) {
        self.arm(function, result);
        self.wait();
    }
}

#[test]
fn a_surface_that_changes_or_is_lost() {
    let mut failing = Failing::open();
    let first = failing.opened.seen.screenshot(&[key::F12]);
    let (stale, lost) = (R::ERROR_OUT_OF_DATE_KHR, R::ERROR_SURFACE_LOST_KHR);
    for (function, result) in [
        ("vkQueuePresentKHR", stale),
        ("vkQueuePresentKHR", R::SUBOPTIMAL_KHR),
        ("vkAcquireNextImageKHR", stale),
        ("vkAcquireNextImageKHR", R::TIMEOUT),
    ] {
        failing.fail(function, result);
        let again = failing.opened.seen.screenshot(&[key::F12]);
        assert!(first == again, "after {function}: {result:?} it is another picture");
    }
    // No area, as of a minimised window; then it has one again.
    let capabilities = "vkGetPhysicalDeviceSurfaceCapabilitiesKHR";
    failing.opened.seen.resize((100, 90));
    failing.arm(capabilities, R::SUCCESS);
    failing.opened.seen.resize(SIZE);
    failing.wait();
    assert!(first == failing.opened.seen.screenshot(&[key::F12]), "it does not come back");
    assert!(!failing.opened.said().contains("opened again"), "{}", failing.opened.said());

    failing.fail("vkAcquireNextImageKHR", lost);
    failing.opened.hear("opened again");
    assert!(first == failing.opened.seen.screenshot(&[key::F12]), "the surface stays lost");
    failing.opened.close();
}

#[test]
fn a_lost_device_is_opened_again_once() {
    let mut failing = Failing::open();
    // Not what the program began with: what was changed since must come back.
    failing.opened.seen.press(&[key::ONE]);
    failing.opened.seen.press(&[key::PERIOD]);
    let first = failing.opened.seen.screenshot(&[key::F12]);
    failing.fail("vkQueueSubmit2", R::ERROR_DEVICE_LOST);
    failing.opened.hear("opened again");
    assert!(first == failing.opened.seen.screenshot(&[key::F12]), "it is another picture");
    // So is the panel.
    assert!(first != failing.opened.seen.screenshot(&[key::SHIFT, key::F12]), "no panel");

    // Where the machine took over a minute since then, it is opened again once more.
    let opened = |failing: &Failing| failing.opened.said().matches("opened again").count();
    for _ in 0..5 {
        let before = opened(&failing);
        failing.fail("vkQueuePresentKHR", R::ERROR_DEVICE_LOST);
        let is_over = |failing: &mut Failing| {
            let is_over = !failing.opened.is_running();
            (is_over || opened(failing) > before).then_some(is_over)
        };
        if wait_for("it ends, or goes on", || is_over(&mut failing)) {
            break;
        }
    }
    let status = failing.opened.end();
    let said = failing.opened.said();
    assert_eq!(status.code(), Some(2), "{said}");
    let [error] = &lines(&said, FAILURE)[..] else { panic!("not one error: {said}") };
    assert!(error.starts_with("vkQueuePresentKHR failed"), "{said}");
    assert!(error.contains("lost") && !said.contains("panicked"), "{said}");
    // What one saw is kept.
    let kept = failing.opened.folder.path().join("raindrops-0001.toml");
    assert!(said.contains(&format!("kept as {}", kept.display())), "{said}");
    let kept = Scene::load(&kept).expect("a scene");
    assert!(kept.model.preset == Preset::Paper && kept.time > 0.0, "{kept:?}");
}
