//! What the tests on a device share: a device under validation, and small scenes.
//!
//! `RAINDROPS_TEST_DEVICE`, a part of a device's name, chooses the device. Where there is none, or
//! no validation layer, the tests fail: a test that skips itself proves nothing and looks the same.
//!
//! `RAINDROPS_TEST_GLSL`, a folder of shaders' sources and of what they were compiled to, replaces the shaders
//! that the program was built with: `tests/house/mutants.rs` tries faults in them without a build for each.

#![allow(dead_code, reason = "every test file is a crate of its own and uses a part of this")]

pub mod bow;
pub mod hooks;
pub mod layer;
pub mod picture;
pub mod said;
#[cfg(target_os = "linux")]
pub mod stand_in;

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, Mutex, PoisonError};

use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, ReadChannels, ReadLayers};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, DeviceReport, Instance, ReplacedShaders, Validation, shaders};
use raindrops::plan;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};
use tempfile::TempDir;

/// The variables that a program under test gets from the tester: where programs, libraries and temporary files are, and which
/// drivers there are.
const KEPT_VARIABLES: [&str; 12] = [
    // Which planted fault is chosen (tests/house/mutants.rs).
    "RAINDROPS_MUTANT",
    "PATH",
    "LD_LIBRARY_PATH",
    "DYLD_LIBRARY_PATH",
    "TMPDIR",
    "VK_DRIVER_FILES",
    "VK_ICD_FILENAMES",
    "VK_ADD_DRIVER_FILES",
    "VK_LOADER_DRIVERS_SELECT",
    "VK_LOADER_DRIVERS_DISABLE",
    "VK_LAYER_PATH",
    "VK_ADD_LAYER_PATH",
];

/// A program that gets no more of the tester's environment than it needs: what it says must not depend on colours, languages,
/// a terminal's width, layers, or files of the home folder. What it keeps goes among the build's files.
pub fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    let kept = KEPT_VARIABLES.iter().filter_map(|name| Some((name, std::env::var_os(name)?)));
    command.env_clear().envs(kept).env("VK_LOADER_LAYERS_DISABLE", "~implicit~");
    command.env("HOME", kept_folder("home")).env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command
}

/// The command.
pub fn raindrops() -> Command {
    command(env!("CARGO_BIN_EXE_raindrops"))
}

/// Most tests that draw on one device, one after the other. Pipelines are compiled once a device, which takes longer than
/// most tests; but what a test did not free the layer tells only as the device goes.
const TESTS_A_DEVICE: u32 = 12;

/// Devices on which no test draws, and how many did.
static IDLE: Mutex<Vec<(Arc<Device>, u32)>> = Mutex::new(Vec::new());

/// Runs `test` on a device under validation with synchronization checks, and fails if the layer says anything.
pub fn on_device(test: impl FnOnce(&Arc<Device>)) {
    let idle = || IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = idle().pop();
    let (device, tests) = kept.unwrap_or_else(|| (opened(|_| {}), 0));
    {
        let _beside = layer::beside();
        test(&device);
    }
    assert_alone(&device);
    match tests + 1 < TESTS_A_DEVICE {
        true => {
            assert_silent(device.instance(), &device.report.name);
            idle().push((device, tests + 1));
        }
        false => end(device),
    }
}

/// Like [`on_device`], on a device of its own.
pub fn on_fresh_device(test: impl FnOnce(&Arc<Device>)) {
    on_adjusted_device(|_| {}, test);
}

/// Like [`on_fresh_device`], on a device whose report is changed before it is opened, so that limits of other devices
/// can be tried.
pub fn on_adjusted_device(adjust: impl FnOnce(&mut DeviceReport), test: impl FnOnce(&Arc<Device>)) {
    let device = opened(adjust);
    {
        let _beside = layer::beside();
        test(&device);
    }
    assert_alone(&device);
    end(device);
}

fn opened(adjust: impl FnOnce(&mut DeviceReport)) -> Arc<Device> {
    let _alone = layer::alone();
    let instance = validated_instance();
    let mut report = chosen(&instance);
    adjust(&mut report);
    // SAFETY: tests take from the device, and say no more of it than it takes.
    let device = unsafe { Device::open_as(&instance, report, &[]) }
        .unwrap_or_else(|error| panic!("the device does not open: {error}"));
    // SAFETY: the compiler made them; a fault that is put in changes no interface.
    unsafe { device.replace_shaders(replaced_shaders()) };
    device
}

fn assert_alone(device: &Arc<Device>) {
    let name = &device.report.name;
    assert_eq!(Arc::strong_count(device), 1, "something made on {name} outlives its test");
}

fn assert_silent(instance: &Instance, name: &str) {
    instance.expect_silence().unwrap_or_else(|error| panic!("on {name}: {error}"));
}

/// Frees a device, and fails if the layer says anything by the time that it is gone.
fn end(device: Arc<Device>) {
    let _alone = layer::alone();
    let (instance, name) = (device.instance().clone(), device.report.name.clone());
    drop(device);
    assert_silent(&instance, &name);
}

/// Where the shaders' sources are.
pub fn glsl() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
    std::env::var_os("RAINDROPS_TEST_GLSL").map_or(own, PathBuf::from)
}

/// The SPIR-V in the folder that `RAINDROPS_TEST_GLSL` names, by shader and variant.
pub fn replaced_shaders() -> ReplacedShaders {
    let Some(folder) = std::env::var_os("RAINDROPS_TEST_GLSL").map(PathBuf::from) else {
        return ReplacedShaders::default();
    };
    let read = |shader: &&raindrops::gpu::Shader| {
        let bytes = std::fs::read(folder.join(shader_file(shader.name, shader.define))).ok()?;
        let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        Some(((shader.name, shader.define), words.collect()))
    };
    shaders::ALL.iter().filter_map(read).collect()
}

/// Name of the file that holds a shader's variant, compiled.
pub fn shader_file(name: &str, define: Option<&str>) -> String {
    format!("{name}.{}.spv", define.unwrap_or_default())
}

/// The path of a photograph among `assets/environments`; none where the tester has said that there are none.
///
/// # Panics
/// Where it is missing and nobody has said so.
pub fn photograph(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments").join(name);
    if path.exists() {
        return Some(path);
    }
    let without = std::env::var_os("RAINDROPS_TEST_WITHOUT_PHOTOGRAPHS").is_some();
    assert!(
        without,
        "there is no {}; scripts/setup.sh fetches it on Debian and Ubuntu, elsewhere \
         RAINDROPS_TEST_WITHOUT_PHOTOGRAPHS=1 leaves the tests out that need it",
        path.display()
    );
    None
}

/// An instance that validation watches, for whoever is [`layer::alone`].
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

/// Grey, with a sun of a degree of radius in a halo that is seen as far as some nine degrees from it.
pub fn with_halo(toward: DVec3) -> Environment {
    painted(512, |direction| {
        let off = direction.angle_between(toward).to_degrees();
        let sun = if off < 1.0 { 3e4 } else { 0.0 };
        Vec3::splat((sun + 150.0 * (-off / 5.0).exp() + 0.5) as f32)
    })
}

/// Writes real rain of 48 x 32 pixels as `scene.toml` in a folder.
pub fn write_scene(folder: &Path) {
    let toml = "seed = 3\n[image]\nwidth = 48\nheight = 32\n[rain]\nrate = 25.0\nextent = 60.0\n[model]\npreset = \"fast\"\n";
    std::fs::write(folder.join("scene.toml"), toml).expect("a scene");
}

/// A folder that goes with the value.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// A folder among the build's files, which stays.
pub fn kept_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// [`kept_folder`], without what an earlier run left in it.
pub fn emptied_folder(name: &str) -> PathBuf {
    let _ = std::fs::remove_dir_all(kept_folder(name));
    kept_folder(name)
}

/// Runs any command to its end.
pub fn outcome(command: &mut Command) -> Output {
    command.output().expect("the command starts")
}

/// Runs the command in a folder; whether it is done, and what it says.
pub fn run(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let ran = outcome(raindrops().current_dir(folder).args(arguments));
    (ran.status.success(), String::from_utf8_lossy(&ran.stderr).into_owned())
}

/// Fails unless docs/result-files.md names every key of these objects under a format.
#[track_caller]
pub fn documented_keys(format: &str, objects: &[&serde_json::Value]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/result-files.md");
    let text = std::fs::read_to_string(path).expect("a document");
    let part = text.split("\n## ").find(|part| part.starts_with(&format!("`{format}`")));
    let part = part.unwrap_or_else(|| panic!("docs/result-files.md has no {format}"));
    for object in objects {
        for key in object.as_object().expect("an object").keys() {
            let is_told = ["", "[]"].iter().any(|end| part.contains(&format!("`{key}{end}`")));
            assert!(is_told, "{format}: {key} is not documented");
        }
    }
}

/// Keys of a scene and of these tables and lists of tables in it, as the program names them where it meets one that it
/// does not know.
pub fn scene_keys(tables: &[&str], lists: &[&str]) -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    for table in [""].iter().chain(tables).chain(lists) {
        let (head, start) = match *table {
            "" => (String::new(), String::new()),
            list if lists.contains(&list) => (format!("[[{list}]]\n"), format!("{list}.")),
            table => (format!("[{table}]\n"), format!("{table}.")),
        };
        let problem = Scene::parse(&format!("{head}no_such_key = 1"), "a scene");
        let problem = problem.expect_err("a wrong key").to_string();
        let (_, known) = problem.split_once("expected").unwrap_or_else(|| panic!("{problem}"));
        let known = known.split('`').skip(1).step_by(2).map(|key| format!("{start}{key}"));
        keys.extend(known.filter(|key| !tables.iter().chain(lists).any(|table| *table == key)));
    }
    keys
}

/// A scene without rain, of one drop.
pub fn one_drop(center: DVec3, radius: f64) -> Scene {
    Scene { rain: None, drops: vec![PlacedDrop::sphere(center, radius)], ..Scene::default() }
}

/// A small frame in white surroundings, as it is shown.
pub fn frame(device: &Arc<Device>, preset: Preset, (width, height): (u32, u32)) -> Vec<u8> {
    let mut scene = Scene { image: ImageSize { width, height }, ..Scene::default() };
    scene.model.preset = preset;
    scene.model.mask_size = 16;
    scene.rain.get_or_insert_default().count = 1000;
    let white = Environment::constant(Vec3::ONE);
    let mut renderer = picture::renderer_of(device, &scene, &white, plan::Output::Display);
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

/// This scene by the paper's method.
pub fn by_paper(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.model.preset = Preset::Paper;
    scene
}

/// An environment whose texel at a direction is `radiance` of it.
pub fn painted(width: u32, radiance: impl Fn(DVec3) -> Vec3) -> Environment {
    use std::f64::consts::{PI, TAU};
    let height = width / 2;
    let texels = (0..width * height).map(|index| {
        let longitude = TAU * ((f64::from(index % width) + 0.5) / f64::from(width) - 0.5);
        let polar = PI * (f64::from(index / width) + 0.5) / f64::from(height);
        let (sine, cosine) = polar.sin_cos();
        radiance(DVec3::new(sine * longitude.sin(), cosine, -sine * longitude.cos()))
    });
    Environment::from_texels("painted", width, height, texels.collect()).expect("an image")
}

/// Radiance of a few low waves over a decade.
pub fn waves() -> Environment {
    let texel = |at: u32| {
        let (u, v) = ((at % 128) as f32 / 20.4, (at / 128) as f32 / 20.4);
        Vec3::new((2.0 * u).cos() * v.sin(), (3.0 * u + v).sin(), (2.0 * v).cos()).exp()
    };
    Environment::from_texels("waves", 128, 64, (0..128 * 64).map(texel).collect())
        .expect("an image")
}

/// White but for a dark hole about -z of this half-angle in degrees: a picture of less shows drops alone, and they
/// are white but for the little that comes through their middle.
pub fn hole(half_angle: f64, white: Vec3) -> Environment {
    let inside = half_angle.to_radians().cos();
    painted(1024, move |d| if -d.z > inside { Vec3::ZERO } else { white })
}

/// The first layer of an EXR file, with all of its channels, as another program reads them.
pub fn exr_layer(path: &Path) -> Image<Layer<AnyChannels<FlatSamples>>> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .expect("an EXR")
}
