//! A picture does not depend on the order in which a driver's threads come to the drops, on how many turns of its loops
//! a driver allows, nor on how many invocations a subgroup has.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::Arc;

use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Instance, Reconvergence, Validation};
use raindrops::scene::Scene;

/// Bytes of a picture that a process of its own draws with so many threads of llvmpipe, and what it says.
fn drawn(scene: &Path, threads: &str, to: &Path) -> (Vec<u8>, String) {
    let mut command = crate::common::raindrops();
    command.arg("render").arg(scene).args(["--preset", "fast", "-o"]).arg(to);
    let output = command.env("LP_NUM_THREADS", threads).output().expect("a process");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (std::fs::read(to).expect("a picture"), said)
}

/// Draws a scene of `tests/data` three times, with one thread and with two, and asks for the same bytes and that nothing is lost.
fn is_the_same_in_every_run(name: &str) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let folder = crate::common::folder();
    let mut all = BTreeSet::new();
    for (run, threads) in ["1", "2", "2"].into_iter().enumerate() {
        let to = folder.path().join(format!("{run}.exr"));
        let (bytes, said) = drawn(&scene, threads, &to);
        assert!(!said.contains("not drawn"), "{said}");
        all.insert(bytes);
    }
    assert_eq!(all.len(), 1, "three runs gave {} pictures", all.len());
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

/// What a width draws, each as `--set` has it. All presets; real rain, exposed and out of focus: streaks, their lines, discs,
/// glints.
const DRAWN: [&[&str]; 5] = [
    &["model.preset=paper", "rain.count=20000"],
    &["model.preset=paper-compact", "rain.count=20000"],
    &["model.preset=fast", "rain.count=60000"],
    &["model.preset=exact", "rain.count=5000"],
    &[
        "model.preset=fast",
        "rain.rate=100",
        "rain.extent=80",
        "camera.shutter=0.02",
        "camera.aperture=0.02",
        "camera.focus=3",
    ],
];
const COMPACTED: usize = 1;
/// From here on also with 512 bits.
const WIDEST: usize = 2;
/// The variables that tell a process of its own what to draw, and where to.
const WIDTH: &str = "RAINDROPS_TEST_WIDTH";
const TO: &str = "RAINDROPS_TEST_TO";

/// A device whose invocations come together again after a branch, or of which nobody promises that.
fn opened(instance: &Arc<Instance>, reconvergence: Option<Reconvergence>) -> Arc<Device> {
    let mut report = crate::common::chosen(instance);
    report.promises.reconvergence = reconvergence.unwrap_or(report.promises.reconvergence);
    // SAFETY: no more is said of the device than it takes.
    let device = unsafe { Device::open_as(instance, report, &[]) }.expect("a device");
    // SAFETY: the compiler made them; a fault that is put in changes no interface.
    unsafe { device.replace_shaders(crate::common::replaced_shaders()) };
    device
}

/// Draws one of [`DRAWN`] to a file.
fn draw(device: &Arc<Device>, light: &Environment, number: usize, to: &Path) {
    let settings = DRAWN[number];
    let size = ["image.width=96", "image.height=64", "model.mask_size=64"];
    let edits: Vec<String> = settings.iter().chain(&size).map(|edit| edit.to_string()).collect();
    let scene = Scene::load_edited(None, &edits).expect("a scene");
    let mut renderer = crate::common::picture::renderer(device, &scene, light);
    let counts = renderer.draw(&scene).expect("a frame").counts;
    assert_eq!(counts.overflow, 0, "{settings:?}");
    assert!(counts.visible > 20, "{settings:?} show {} drops", counts.visible);
    let pixels = renderer.read_radiance().expect("a picture").pixels;
    let words = pixels.iter().flat_map(|pixel| pixel.to_array().map(f32::to_le_bytes));
    std::fs::write(to, words.flatten().collect::<Vec<u8>>()).expect("written");
}

/// In a process of its own, as llvmpipe reads its width once.
#[test]
#[ignore = "run by `subgroups_of_every_size_draw_the_same`, in an environment of its own"]
fn draw_all() {
    let (width, to) =
        (std::env::var(WIDTH).expect("a width"), std::env::var_os(TO).expect("a folder"));
    let to = |name: String| Path::new(&to).join(name);
    let instance = Instance::new(Validation::Off).expect("Vulkan");
    // Both releases of Mesa that were tried end in LLVM where points are drawn by vectors of 512 bits.
    let is_widest = width == "512";
    let device = opened(&instance, is_widest.then_some(Reconvergence::Open));
    let report = &device.report;
    let is_wide = report.name.contains(&format!("{width} bits"));
    assert!(is_wide || report.driver != "llvmpipe", "{}", report.name);
    let light = crate::common::with_halo(DVec3::new(0.1, 0.2, -1.0).normalize());
    for number in if is_widest { WIDEST } else { 0 }..DRAWN.len() {
        draw(&device, &light, number, &to(number.to_string()));
    }
    if width == "128" {
        let device = opened(&instance, Some(Reconvergence::Open));
        draw(&device, &light, COMPACTED, &to("open".into()));
    }
}

/// Draws all with vectors of so many bits, to a folder.
fn start(width: &str, to: &Path) -> Child {
    let mut command = Command::new(std::env::current_exe().expect("this test"));
    command.args(["--ignored", "--exact", "same_bytes::draw_all"]);
    command.env("LP_NATIVE_VECTOR_WIDTH", width).env(WIDTH, width).env(TO, to);
    // Mesa's cache does not tell widths apart.
    command.env("MESA_SHADER_CACHE_DIR", crate::common::kept_folder(&format!("mesa-{width}")));
    command.spawn().expect("this test starts")
}

/// Also with 512 bits and of `paper-compact` where no invocation counts on another to come together with it again after a
/// branch.
#[test]
fn subgroups_of_every_size_draw_the_same() {
    let folder = crate::common::folder();
    let all = ["256", "128", "512"].map(|width| {
        let to = folder.path().join(width);
        std::fs::create_dir(&to).expect("a folder");
        (start(width, &to), to)
    });
    let [of_256, of_128, of_512] = all.map(|(mut child, to)| {
        assert!(child.wait().expect("it ends").success(), "{}", to.display());
        to
    });
    let bytes = |to: &Path, name: &str| std::fs::read(to.join(name)).expect("a picture");
    for (number, settings) in DRAWN.iter().enumerate() {
        let (name, others) = (number.to_string(), [&of_128, &of_512]);
        let first = bytes(&of_256, &name);
        for other in &others[..if number < WIDEST { 1 } else { 2 }] {
            assert!(bytes(other, &name) == first, "{settings:?}: {} differs", other.display());
        }
    }
    assert!(bytes(&of_128, "open") == bytes(&of_256, &COMPACTED.to_string()), "compacted apart");
}
