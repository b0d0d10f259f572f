//! The command on bad input: one clear line on stderr, exit status 2, and nothing half written.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use glam::{DVec3, Vec3};
use raindrops::Error;
use raindrops::environment::Environment;
use raindrops::gpu::probe::Findings;
use raindrops::gpu::{Device, DeviceReport, Instance, Validation};
use raindrops::picture::Picture;
use raindrops::plan::{self, plan, requirements};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;

use crate::common::said::{WARNING, failure, lines, said};
use crate::common::{folder, outcome};

/// The command, run in `folder`.
pub fn raindrops(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = crate::common::raindrops();
    command.current_dir(folder).args(arguments);
    command
}

/// The one line of an error.
#[track_caller]
pub fn error_line(output: &Output) -> String {
    let line = failure(output, 2);
    assert!(output.stdout.is_empty(), "an error says nothing on stdout");
    line
}

/// Every file below a folder, with its size.
fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry"))
        .map(|entry| {
            let size = entry.metadata().expect("metadata").len();
            format!("{} {size}", entry.file_name().to_string_lossy())
        })
        .collect();
    names.sort();
    names
}

/// A small picture that is quickly rendered if nothing is wrong.
pub const SMALL: [&str; 5] = ["render", "--size", "32x32", "--drops", "100"];

/// Runs `render` of a small picture with more arguments; it must fail with a line that holds all of
/// `words`, and leave the folder as it was.
#[track_caller]
fn render_fails(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = files(folder);
    let line = error_line(&outcome(raindrops(folder, &SMALL).args(arguments)));
    for word in words {
        assert!(line.contains(word), "'{line}' does not say '{word}'");
    }
    assert_eq!(files(folder), before, "{line}");
}

#[test]
fn a_sound_render_succeeds() {
    let folder = folder();
    for name in ["a.png", "a.exr"] {
        let mut command = raindrops(folder.path(), &SMALL);
        let output = outcome(command.args(["--validate", "-o", name]));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let stderr = said(&output);
        let is_named = |line: &str| line.starts_with("device: ");
        assert!(stderr.lines().any(is_named), "the device is not named: {stderr}");
        assert!(folder.path().join(name).exists());
    }
    assert_eq!(files(folder.path()).len(), 2, "and nothing else is left behind");
}

/// Every shell's completions know the commands.
#[test]
fn shells_complete() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish"] {
        let output = outcome(&mut raindrops(folder.path(), &["completions", shell]));
        let script = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && script.contains("resume"), "{shell}: {script}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn no_loader() {
    let folder = folder();
    let library = folder.path().join("libvulkan.so.1");
    fs::write(&library, "not a library").expect("a file");
    let mut command = raindrops(folder.path(), &["devices"]);
    let line = error_line(&outcome(command.env("LD_LIBRARY_PATH", folder.path())));
    assert!(line.contains("no Vulkan loader") && line.contains("libvulkan1"), "{line}");
}

#[test]
fn no_driver() {
    let folder = folder();
    for arguments in [&["devices"][..], &["render", "-o", "a.png"], &["mask", "-o", "masks"]] {
        let mut command = raindrops(folder.path(), arguments);
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        let line = error_line(&outcome(&mut command));
        assert!(line.contains("no Vulkan device") && line.contains("VK_DRIVER_FILES"), "{line}");
    }
    assert!(files(folder.path()).is_empty());
}

#[test]
fn no_such_device() {
    let folder = folder();
    for wanted in ["no such device", "999"] {
        let words = ["no Vulkan device matches", wanted, "there are: 0: "];
        render_fails(folder.path(), &["-o", "a.png", "--device", wanted], &words);
    }
}

/// A device that lacks features is refused by their names. None here does, so its report is changed.
#[test]
fn a_missing_feature_is_named() {
    let instance = Instance::new(Validation::Off).expect("Vulkan");
    let mut report = crate::common::chosen(&instance);
    report.missing = vec!["largePoints", "synchronization2"];
    let name = report.name.clone();
    // SAFETY: less is said of the device than it takes.
    let opened = unsafe { Device::open_as(&instance, report, &[]) };
    let Err(error) = opened else { panic!("it was opened") };
    assert!(matches!(error, Error::DeviceLacks { .. }));
    let line = error.to_string();
    assert!(line.starts_with(&format!("{name} lacks largePoints, synchronization2: ")), "{line}");
}

/// A device without what only the paper's presets need draws by the others, under validation.
#[test]
fn a_preset_asks_for_what_it_needs_alone() {
    let adjust = |report: &mut DeviceReport| {
        report.features.large_points = false;
        report.features.shader_storage_image_write_without_format = false;
    };
    crate::common::on_adjusted_device(adjust, |device| {
        for preset in [Preset::Fast, Preset::Exact, Preset::Auto] {
            let picture = crate::common::frame(device, preset, (32, 24));
            assert!(picture.iter().any(|byte| *byte > 0), "{} draws", preset.name());
        }
        for preset in [Preset::Paper, Preset::PaperCompact] {
            let lacks = device.report.lacks(&requirements(preset));
            assert_eq!(lacks, ["largePoints", "shaderStorageImageWriteWithoutFormat"]);
        }
        let mut scene = crate::common::one_drop(DVec3::new(0.0, 0.0, -5.0), 1.0);
        scene.model.preset = Preset::Paper;
        let white = Environment::constant(Vec3::ONE);
        let plan = plan(&scene, &white, plan::Output::Radiance).expect("a plan");
        let Err(error) = Renderer::new(device, &scene, &white, &plan) else {
            panic!("it is drawn")
        };
        let line = error.to_string();
        let lacks = " lacks largePoints, shaderStorageImageWriteWithoutFormat: ";
        assert!(line.contains(lacks), "{line}");
        assert_eq!(Findings::of(device).expect("findings").points, None);
    });
}

#[test]
fn bad_environments() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let sky = include_bytes!("../../assets/sky.exr");
    fs::write(at("truncated.exr"), &sky[..sky.len() / 2]).expect("a file");
    fs::write(at("empty.exr"), "").expect("a file");
    fs::write(at("text.exr"), "not an image").expect("a file");
    let picture = |width, height, value: f32| Picture {
        width,
        height,
        pixels: vec![Vec3::splat(value); (width * height) as usize],
    };
    picture(3, 3, 1.0).write_exr(&at("square.exr")).expect("a file");
    picture(4, 2, f32::NAN).write_exr(&at("nan.exr")).expect("a file");
    fs::create_dir(at("folder.exr")).expect("a folder");
    for (name, word) in [
        ("missing.exr", "No such file"),
        ("missing.exr", "/missing.exr: a scene's paths are relative to the scene's folder"),
        ("truncated.exr", "broken or cut off"),
        ("empty.exr", "empty"),
        ("text.exr", "not an OpenEXR"),
        ("square.exr", "twice as wide"),
        ("nan.exr", "no texel is finite"),
        ("folder.exr", "folder"),
    ] {
        render_fails(folder.path(), &["-o", "a.png", "--environment", name], &[name, word]);
    }
}

#[test]
fn bad_scenes() {
    let folder = folder();
    let cases: [(&str, &[&str]); 25] = [
        // Unknown names: file, line, the name and the nearest known one.
        ("seed = 1\n[rain]\ncuont = 4", &["scene.toml:3", "`cuont`", "did you mean `count`"]),
        ("[camra]\n", &["scene.toml:1", "`camra`", "did you mean `camera`"]),
        // None is near.
        ("[rain]\nwibble = 4", &["scene.toml:2", "`wibble`, expected one of `seed`, `count`"]),
        (
            "\n\n[[drop]]\ncentre = [0, 0, -3]",
            &["scene.toml:4", "`centre`", "did you mean `center`"],
        ),
        ("[model]\noptics = 'masks'", &["scene.toml:2", "`masks`", "did you mean `mask`"]),
        // Not TOML, not the type.
        ("seed = ", &["scene.toml:1"]),
        ("seed = 'one'", &["scene.toml:1", "seed: invalid type"]),
        ("[rain]\nradius = [1, 2]", &["scene.toml:2", "radius: invalid type"]),
        ("[[drop]]\nradius = 1\ncenter = [0, 'x', 1]", &["scene.toml:3", "center: invalid type"]),
        ("[film]\npace = [{ at = 1.0, rate = 'x' }]", &["scene.toml:2", "rate: invalid type"]),
        ("[[drop]]\nradius = 1", &["scene.toml:1", "center"]),
        // Values out of range.
        ("time = nan", &["time = NaN"]),
        ("time = inf", &["time = inf"]),
        ("[camera]\nvertical_fov = 0", &["vertical_fov = 0", "0.01 to 175"]),
        ("[camera]\nvertical_fov = 180", &["vertical_fov = 180"]),
        ("[camera]\ntarget = [0, 0, 0]", &["the same point"]),
        ("[camera]\nup = [0, 0, 0]", &["up"]),
        ("[camera]\nnear = -1", &["near"]),
        ("[image]\nwidth = 0", &["width = 0 is not within 1 to 32768 px"]),
        ("[environment]\nradiance = [1, -1, 1]", &["radiance"]),
        ("[environment]\nradiance = [1, 1, 1]\nfile = 'a.exr'", &["not both"]),
        ("[rain]\nradius = -1", &["radius"]),
        ("[rain]\nhalf_extent = [1, 0, 1]", &["half_extent"]),
        ("[[drop]]\ncenter = [0, 0, -3]\nradius = 0", &["drop 1", "radius"]),
        ("[model]\nmask_size = 100", &["mask_size = 100", "power of two"]),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("scene.toml"), text).expect("a file");
        for arguments in [&["render", "scene.toml", "-o", "a.png"][..], &["plan", "scene.toml"]] {
            let line = error_line(&outcome(&mut raindrops(folder.path(), arguments)));
            for word in ["scene.toml"].iter().chain(words) {
                assert!(line.contains(word), "{text:?}: '{line}' does not say '{word}'");
            }
            assert!(!line.contains("wibble") || !line.contains("did you mean"), "{line}");
        }
    }
    let line = error_line(&outcome(&mut raindrops(folder.path(), &["plan", "nowhere.toml"])));
    assert!(line.contains("cannot read nowhere.toml"), "{line}");
    assert_eq!(files(folder.path()).len(), 1, "nothing beside the scene");
}

#[test]
fn bad_values_on_the_command_line() {
    let folder = folder();
    let output = ["-o", "a.png"];
    for (arguments, word) in [
        (["--size", "0x5"], "width = 0"),
        (["--drops", "4000000000"], "4000000000"),
        (["--time", "nan"], "NaN"),
        (["--fps", "0"], "fps = 0"),
        (["--mask-size", "3"], "mask_size = 3"),
    ] {
        let mut all = vec!["render"];
        all.extend(output.iter().chain(&arguments));
        let line = error_line(&outcome(&mut raindrops(folder.path(), &all)));
        assert!(line.contains(word), "{line}");
    }
    // What the parser itself refuses.
    for (arguments, words) in [
        (
            &["render"][..],
            ["required", "--output <FILE>; name the picture to write, such as -o rain.png"],
        ),
        (&["report", "a.json"], ["required", "name the page to write, such as -o report.html"]),
        (&["mask"], ["required", "name the folder to write into, such as -o out"]),
        (&["render", "--size", "12"], ["'12' is not a size", "--size <WxH>"]),
        (&["render", "--nonsense"], ["unexpected argument", "--nonsense"]),
        (&["render", "--preset", "papr", "-o", "a.png"], ["papr", "'paper'"]),
        (&["rendr"], ["unrecognized subcommand", "'render'"]),
        (&["bench", "--drops", "1,x"], ["'x'", "such as 125000, 125k or 4M"]),
        (&["bench", "--drops", "125,000"], ["'000' for '--drops <N,…>'", "without commas"]),
        (&["plan", "--drops", "1e4"], ["'1e4' for '--drops <N>'", "such as 125000, 125k or 4M"]),
        (&["bench", "--seconds", "inf"], ["'inf'", "--seconds"]),
        (&["tradeoff", "--seconds=-1"], ["'-1'", "--seconds"]),
        (&["tradeoff", "--models", "nonesuch"], ["nonesuch", "--models"]),
        (&["compare", "a.exr", "b.exr", "--difference", "d.exr"], ["d.exr", "as .png"]),
    ] {
        let line = error_line(&outcome(&mut raindrops(folder.path(), arguments)));
        for word in words {
            assert!(line.contains(word), "'{line}' does not say '{word}'");
        }
    }
    // Without a command, which: the list of them.
    assert_eq!(outcome(&mut raindrops(folder.path(), &[])).status.code(), Some(2));
    assert!(files(folder.path()).is_empty());
}

#[test]
fn bad_outputs() {
    let folder = folder();
    fs::write(folder.path().join("file"), "content").expect("a file");
    fs::create_dir(folder.path().join("folder.png")).expect("a folder");
    for (output, words) in [
        ("nowhere/a.png", ["cannot write", "there is no folder nowhere"]),
        ("file/a.exr", ["cannot write", "there is no folder file"]),
        ("a.tga", ["a.tga", ".exr or .png"]),
        ("a", ["a:", ".exr or .png"]),
        ("folder.png", ["cannot write folder.png", "directory"]),
    ] {
        render_fails(folder.path(), &["-o", output], &words);
    }
    // A folder that takes no files; root is refused there too.
    #[cfg(target_os = "linux")]
    render_fails(folder.path(), &["-o", "/proc/a.png"], &["cannot write /proc/a.png"]);

    let output =
        outcome(&mut raindrops(folder.path(), &["mask", "--mask-size", "4", "-o", "file"]));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("cannot write file"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.path().join("file")).expect("the file"), "content");
}

/// What a failed run would have replaced is still there, whole.
#[test]
fn a_failed_run_leaves_the_old_picture() {
    let folder = folder();
    let old = folder.path().join("a.png");
    fs::write(&old, "the old picture").expect("a file");
    render_fails(folder.path(), &["-o", "a.png", "--device", "none"], &["none"]);
    render_fails(folder.path(), &["-o", "a.png", "--environment", "no.exr"], &["no.exr"]);
    assert_eq!(fs::read_to_string(&old).expect("the file"), "the old picture");
}

/// Names of the commands, as `--help` lists them.
fn commands() -> Vec<String> {
    let output = outcome(&mut raindrops(Path::new("."), &["--help"]));
    let help = String::from_utf8(output.stdout).expect("text");
    help.lines()
        .take_while(|line| !line.starts_with("Options:"))
        .filter_map(|line| Some(line.strip_prefix("  ")?.split(' ').next()?.to_string()))
        .filter(|name| name != "help")
        .collect()
}

#[test]
fn every_command_has_help() {
    let commands = commands();
    assert!(commands.len() >= 5 && commands.contains(&"render".into()), "{commands:?}");
    for command in commands {
        let output = outcome(&mut raindrops(Path::new("."), &[&command, "--help"]));
        assert_eq!(output.status.code(), Some(0), "{command}");
        let help = String::from_utf8_lossy(&output.stdout);
        assert!(help.contains("Usage: raindrops"), "{command}: {help}");
    }
}

/// `std::env::args` ends the program at a word that is no text.
#[test]
fn a_path_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt as _;
    let name = std::ffi::OsStr::from_bytes(b"no-\xff-scene.toml");
    let output = outcome(raindrops(folder().path(), &["plan"]).arg(name));
    assert!(error_line(&output).contains("-scene.toml"));
}

#[test]
fn plan_prints_passes_with_reasons() {
    let output = outcome(&mut raindrops(Path::new("."), &["plan", "--preset", "paper"]));
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8_lossy(&output.stdout);
    for word in ["paper", "mask", "simulate", "sky", "drops", "tone map", "moves 1,000,000 drops"] {
        assert!(text.contains(word), "'{word}' is not in {text}");
    }
    // Every axis that a scene can choose has its line.
    let schema = serde_json::to_value(raindrops::scene::ModelChoice::default()).expect("JSON");
    for axis in schema.as_object().expect("an object").keys() {
        let is_line = |line: &str| line.split(' ').next() == Some(axis);
        assert!(text.lines().any(is_line), "'{axis}' is not in {text}");
    }
    for line in [
        "motion                instant",
        "lens                  pinhole",
        "error                 -",
    ] {
        assert!(text.lines().any(|found| found == line), "'{line}' is not in {text}");
    }
    let of = |drops| {
        outcome(&mut raindrops(Path::new("."), &["plan", "--preset", "paper", "--drops", drops]))
    };
    assert!(String::from_utf8_lossy(&of("125k").stdout).contains("moves 125,000 drops"));
    let without = of("0");
    let text = String::from_utf8_lossy(&without.stdout);
    assert!(!text.contains("simulate"), "no drops, no simulation: {text}");
}

/// What `auto` cannot promise is said, and an accepted error is `auto`'s alone.
#[test]
fn an_error_that_is_not_promised_is_said() {
    let folder = folder();
    fs::write(folder.path().join("a.toml"), "[model]\nerror = 0.1\n").expect("a file");
    for (arguments, word) in [
        (&[][..], None),
        (&["--preset", "paper"], None),
        (&["--samples", "1"], Some("samples")),
        (&["--optics", "mask"], Some("optics")),
        (&["--optics", "closed-form", "--simulation", "stored"], Some("out of reach")),
        (&["--error", "0.0000001"], Some("out of reach")),
    ] {
        let all = [&["plan", "a.toml"], arguments].concat();
        let output = outcome(&mut raindrops(folder.path(), &all));
        let said = said(&output);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
        match word {
            Some(word) => {
                assert!(said.contains("warning: error 0") && said.contains(word), "{said}")
            }
            None => assert!(lines(&said, WARNING).is_empty(), "{arguments:?}: {said}"),
        }
    }
}
