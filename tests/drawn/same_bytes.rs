//! A picture does not depend on the order in which a driver's threads come to the drops, on how many turns of its loops
//! a driver allows, nor on how many invocations a subgroup has.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command};

use glam::DVec3;
use raindrops::gpu::{Device, Instance, Reconvergence, Validation};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
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

/// What a width draws: how drops are drawn and what rain, each as `--set` has it. All presets; real rain at rest, exposed and out
/// of focus: glints, streaks, their lines, discs. The first two are the paper's.
const DRAWN: [&[&str]; 7] = [
    &["model.preset=paper", "rain.count=20000"],
    &["model.preset=paper-compact", "rain.count=20000"],
    &["model.preset=fast", "rain.count=60000"],
    &["model.preset=exact", "rain.count=5000"],
    &["model.preset=fast", "rain.rate=100", "rain.extent=80"],
    &["model.preset=fast", "rain.rate=100", "rain.extent=80", "camera.shutter=0.02"],
    &[
        "model.preset=fast",
        "rain.rate=100",
        "rain.extent=40",
        "camera.aperture=0.05",
        "camera.focus=3",
    ],
];
const PAPERS: usize = 2;
/// The variables that tell a process of its own what to draw, and how its lanes come together.
const WIDTH: &str = "RAINDROPS_TEST_WIDTH";
const OPEN: &str = "RAINDROPS_TEST_OPEN";
const TO: &str = "RAINDROPS_TEST_TO";

/// In a process of its own, as llvmpipe reads its width once.
#[test]
#[ignore = "run by `subgroups_of_every_size_draw_the_same`, in an environment of its own"]
fn draw_all() {
    let (width, to) =
        (std::env::var(WIDTH).expect("a width"), std::env::var(TO).expect("a folder"));
    let instance = Instance::new(Validation::Off).expect("Vulkan");
    let mut report = crate::common::chosen(&instance);
    let is_llvmpipe = report.driver == "llvmpipe";
    assert!(!is_llvmpipe || report.name.contains(&format!("{width} bits")), "{}", report.name);
    if std::env::var_os(OPEN).is_some() {
        report.promises.reconvergence = Reconvergence::Open;
    }
    // SAFETY: a driver may run invocations apart, but need not.
    let device = unsafe { Device::open_as(&instance, report, &[]) }.expect("a device");
    // SAFETY: the compiler made them; a fault that is put in changes no interface.
    unsafe { device.replace_shaders(crate::common::replaced_shaders()) };
    let light = crate::common::with_halo(DVec3::new(0.1, 0.2, -1.0).normalize());
    // Both releases of Mesa that were tried end in LLVM where points are drawn by vectors of 512 bits.
    let first = if width == "512" { PAPERS } else { 0 };
    for (number, settings) in DRAWN.iter().enumerate().skip(first) {
        let edits =
            settings.iter().chain(&["image.width=96", "image.height=64", "model.mask_size=64"]);
        let edits: Vec<String> = edits.map(|edit| edit.to_string()).collect();
        let scene = Scene::load_edited(None, &edits).expect("a scene");
        let plan = plan(&scene, &light, Output::Radiance).expect("a plan");
        let mut renderer = Renderer::new(&device, &scene, &light, &plan).expect("a renderer");
        let report = renderer.draw(&scene).expect("a frame");
        assert_eq!(report.counts.overflow, 0, "{settings:?}");
        assert!(report.counts.visible > 20, "{settings:?} show {} drops", report.counts.visible);
        let picture = renderer.read_radiance().expect("a picture");
        let bytes: Vec<u8> = picture
            .pixels
            .iter()
            .flat_map(|p| p.to_array().map(f32::to_le_bytes))
            .flatten()
            .collect();
        std::fs::write(Path::new(&to).join(format!("{number}")), bytes).expect("written");
    }
}

/// Draws all with vectors of so many bits, to a folder. `is_open`: as if nothing promised that invocations come together again.
fn start(width: &str, is_open: bool, to: &Path) -> Child {
    let mut command = Command::new(std::env::current_exe().expect("this test"));
    command.args(["--ignored", "--exact", "same_bytes::draw_all"]);
    command.env("LP_NATIVE_VECTOR_WIDTH", width).env(WIDTH, width).env(TO, to);
    // Mesa's cache does not tell widths apart.
    command.env("MESA_SHADER_CACHE_DIR", crate::common::kept_folder(&format!("mesa-{width}")));
    if is_open {
        command.env(OPEN, "1");
    }
    command.spawn().expect("this test starts")
}

/// Also where no invocation counts on another to come together with it again after a branch.
#[test]
fn subgroups_of_every_size_draw_the_same() {
    let folder = crate::common::folder();
    let of = |width, is_open| {
        let to = folder.path().join(format!("{width}-{is_open}"));
        std::fs::create_dir(&to).expect("a folder");
        (start(width, is_open, &to), to)
    };
    let all = [of("256", false), of("128", false), of("512", false), of("128", true)];
    let all = all.map(|(mut child, to)| {
        assert!(child.wait().expect("it ends").success(), "{}", to.display());
        to
    });
    for (number, settings) in DRAWN.iter().enumerate() {
        let bytes = |to: &Path| std::fs::read(to.join(format!("{number}"))).ok();
        let first = bytes(&all[0]).expect("a picture");
        for other in &all[1..] {
            let Some(other_bytes) = bytes(other) else {
                assert!(
                    number < PAPERS && other.ends_with("512-false"),
                    "{} in {}",
                    number,
                    other.display()
                );
                continue;
            };
            assert!(other_bytes == first, "{settings:?}: {} differs", other.display());
        }
    }
}
