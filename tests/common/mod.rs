//! What the tests on a device share: a device under validation, and small scenes.
//!
//! `RAINDROPS_TEST_DEVICE`, a part of a device's name, chooses the device. Where there is none, or
//! no validation layer, the tests fail: a test that skips itself proves nothing and looks the same.

#![allow(dead_code, reason = "every test file is a crate of its own and uses a part of this")]

use std::process::Command;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, DeviceReport, Instance, Validation};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

/// The command, which keeps compiled pipelines among the build's files instead of the user's cache.
pub fn raindrops() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raindrops"));
    command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command
}

/// Runs `test` on a device of its own under validation with synchronization checks, and fails if
/// the layer says anything by the time that everything is freed.
pub fn on_device(test: impl FnOnce(&Arc<Device>)) {
    on_adjusted_device(|_| {}, test);
}

/// As [`on_device`], on a device whose report was changed before it was opened, so that limits of
/// other devices can be tried.
pub fn on_adjusted_device(adjust: impl FnOnce(&mut DeviceReport), test: impl FnOnce(&Arc<Device>)) {
    let instance = validated_instance();
    let mut report = chosen(&instance);
    adjust(&mut report);
    let name = report.name.clone();
    let device = Device::open(&instance, report)
        .unwrap_or_else(|error| panic!("the device does not open: {error}"));
    test(&device);
    assert_eq!(Arc::strong_count(&device), 1, "something made on {name} outlives its test");
    drop(device);
    instance.expect_silence().unwrap_or_else(|error| panic!("on {name}: {error}"));
}

/// An instance that validation watches.
pub fn validated_instance() -> Arc<Instance> {
    Instance::new(Validation::On).unwrap_or_else(|error| {
        panic!("these tests need Vulkan with its validation layer: {error}")
    })
}

/// The device that `RAINDROPS_TEST_DEVICE` names, or the fittest.
pub fn chosen(instance: &Instance) -> DeviceReport {
    let wanted = std::env::var("RAINDROPS_TEST_DEVICE").ok();
    instance
        .choose(wanted.as_deref())
        .unwrap_or_else(|error| panic!("these tests need a Vulkan device: {error}"))
}

/// A scene without rain, of one drop.
pub fn one_drop(center: DVec3, radius: f64) -> Scene {
    Scene { rain: None, drops: vec![PlacedDrop { center, radius }], ..Scene::default() }
}

/// A small frame in white surroundings, as it is shown.
pub fn frame(device: &Arc<Device>, preset: Preset) -> Vec<u8> {
    let mut scene = Scene { image: ImageSize { width: 32, height: 24 }, ..Scene::default() };
    scene.model.preset = preset;
    scene.model.mask_size = 16;
    scene.rain.get_or_insert_default().count = 1000;
    let white = Environment::constant(Vec3::ONE);
    let plan = plan(&scene, &white, Output::Display).expect("a plan");
    let mut renderer = Renderer::new(device, &scene, &white, &plan).expect("a renderer");
    renderer.submit(&scene).expect("a frame");
    renderer.read_display().expect("a picture")
}

/// A small generator (splitmix64), so that "random" is the same on every run.
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform over the sphere of directions.
    pub fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.unit() - 1.0, std::f64::consts::TAU * self.unit());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    }
}

/// The same scene by the paper's method.
#[allow(dead_code, reason = "not every test draws by it")]
pub fn by_paper(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.model.preset = Preset::Paper;
    scene
}
