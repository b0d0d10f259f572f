//! Sequences by the command: a film's frames, what an interrupt leaves, and going on after it.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::common::said::said;
use crate::common::{folder, outcome};

const SCENE: &str = "
[rain]
count = 500
half_extent = [60, 60, 60]
[image]
width = 32
height = 24
[model]
preset = 'fast'
[film]
fps = 10.0
pace = [{ at = 0.1, rate = 1.0 }, { at = 0.2, rate = 0.0 }, { at = 0.5, rate = 0.0 }]
";

fn render(scene: &Path, output: &Path, options: &[&str]) -> Command {
    let mut command = crate::common::raindrops();
    command.arg("render").arg(scene).arg("-o").arg(output).args(options);
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        command.args(["--device", &device]);
    }
    command
}

fn frame(folder: &Path, number: u32) -> std::path::PathBuf {
    folder.join(format!("rain-{number:04}.png"))
}

fn changed(path: &Path) -> SystemTime {
    path.metadata().and_then(|data| data.modified()).expect("a file")
}

/// The film's six frames, the last four of them of rain that stands still; one is taken away and
/// comes back by `--resume`, which leaves the others alone, and refuses frames of another scene.
#[test]
fn a_film_is_rendered_and_resumed() {
    let folder = folder();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let done = outcome(&mut render(&scene, &output, &["--validate"]));
    assert!(done.status.success(), "{}", said(&done));
    assert!(said(&done).contains("6 frames to write: "), "{}", said(&done));
    let frames: Vec<_> = (0..6)
        .map(|number| std::fs::read(frame(folder.path(), number)).expect("a frame"))
        .collect();
    assert!(!frame(folder.path(), 6).exists(), "the film has six frames");
    assert!(frames[0] != frames[1] && frames[1] != frames[2], "the rain falls");
    assert!(frames[2..].windows(2).all(|pair| pair[0] == pair[1]), "the rain stands still");

    std::fs::remove_file(frame(folder.path(), 1)).expect("removed");
    let others = [0, 2, 5].map(|number| changed(&frame(folder.path(), number)));
    let done = outcome(&mut render(&scene, &output, &["--resume"]));
    assert!(done.status.success(), "{}", said(&done));
    assert!(std::fs::read(frame(folder.path(), 1)).expect("a frame") == frames[1]);
    assert_eq!(others, [0, 2, 5].map(|number| changed(&frame(folder.path(), number))));

    // One frame alone is that of the film.
    let alone = folder.path().join("alone.png");
    let done = outcome(&mut render(&scene, &alone, &["--frame", "2"]));
    assert!(done.status.success(), "{}", said(&done));
    assert!(std::fs::read(&alone).expect("a frame") == frames[2], "another frame");
    let refused = outcome(&mut render(
        &scene,
        &alone,
        &["--frame", "2", "--preset", "paper", "--simulation", "stored"],
    ));
    assert!(said(&refused).contains("--frame: stored positions"), "{}", said(&refused));

    let refused = outcome(&mut render(&scene, &output, &["--resume", "--drops", "501"]));
    let said = said(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("rain.frames.toml") && said.contains("count = 500"), "{said}");
}

/// Frames of an earlier scene under the same names are not taken for those of the next, which did not get to its end.
#[test]
fn an_earlier_sequence_is_not_gone_on_with() {
    let folder = folder();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let draw = |options: &[&str]| {
        let done = outcome(&mut render(&scene, &output, options));
        assert!(done.status.success(), "{}", said(&done));
    };
    let all = || (0..4).map(|number| std::fs::read(frame(folder.path(), number)).expect("a frame"));
    draw(&["--frames", "4"]);
    let earlier: Vec<_> = all().collect();
    draw(&["--frames", "2", "--seed", "5"]);
    // A preview leaves what it does not draw.
    assert!(all().skip(2).eq(earlier[2..].iter().cloned()));
    draw(&["--frames", "4", "--seed", "5", "--resume"]);
    assert!(all().zip(&earlier).all(|(frame, earlier)| frame != *earlier), "frames of both");
    let kept = [0, 3].map(|number| changed(&frame(folder.path(), number)));
    draw(&["--frames", "4", "--seed", "5", "--resume"]);
    assert_eq!(kept, [0, 3].map(|number| changed(&frame(folder.path(), number))));

    // An interrupt leaves the folder like this.
    draw(&["--frames", "4"]);
    std::fs::remove_file(frame(folder.path(), 0)).expect("removed");
    std::fs::remove_file(folder.path().join("rain.frames.toml")).expect("removed");
    let refused = outcome(&mut render(&scene, &output, &["--frames", "4", "--resume"]));
    assert!(said(&refused).contains("nothing says what the frames"), "{}", said(&refused));
}

/// The reference's frame is of the same instant, whatever the frames a second.
#[test]
fn the_references_frame_is_that_of_the_sequence() {
    let folder = tempfile::tempdir().expect("a folder");
    let trace = |name: &str, options: &[&str]| {
        let mut command = crate::common::raindrops();
        command.current_dir(folder.path()).args(["reference", "--drops", "300", "--size", "24x16"]);
        let done = outcome(command.args(["--samples", "1", "-o", name]).args(options));
        assert!(done.status.success(), "{}", said(&done));
        std::fs::read(folder.path().join(name)).expect("a picture")
    };
    let wanted = trace("wanted.exr", &["--time", "0.5"]);
    assert!(trace("frame.exr", &["--frame", "8", "--fps", "16"]) == wanted);
    assert!(trace("other.exr", &["--frame", "8"]) != wanted, "the control");
}

/// A sequence does not go on before another plate of the same name.
#[test]
fn a_sequence_keeps_its_background() {
    let folder = folder();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    fs_write(&scene, SCENE);
    // An environment of one colour would be guessed, and have another hash itself.
    let plate = folder.path().join("plate.exr");
    let paint = |far: f32| {
        let mut depth = raindrops::picture::layers::Layers::empty(32, 24);
        depth.depth.fill(far);
        depth.write_depth(&plate).expect("a plate");
    };
    let of = |options: &[&str]| {
        let mut all = vec!["--depth", plate.to_str().expect("a name")];
        all.extend_from_slice(options);
        outcome(&mut render(&scene, &output, &all))
    };
    paint(50.0);
    let done = of(&["--frames", "2"]);
    assert!(done.status.success(), "{}", said(&done));
    let done = of(&["--frames", "2", "--resume"]);
    assert!(done.status.success(), "{}", said(&done));
    paint(60.0);
    let refused = of(&["--frames", "2", "--resume"]);
    let said = said(&refused);
    assert!(refused.status.code() == Some(2) && said.contains("background_hash"), "{said}");
}

/// What `auto` took for a sequence stands beside it, and a frame that is missing is made by that, whatever
/// would be taken now.
#[test]
fn a_sequence_keeps_its_models() {
    let folder = folder();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    fs_write(&scene, &SCENE.replace("'fast'", "'auto'"));
    let done = outcome(&mut render(&scene, &output, &[]));
    assert!(done.status.success() && said(&done).contains("auto: "), "{}", said(&done));
    let first = std::fs::read(frame(folder.path(), 1)).expect("a frame");
    let manifest = folder.path().join("rain.frames.toml");
    let text = std::fs::read_to_string(&manifest).expect("a manifest");
    assert!(text.contains("[auto]") && text.contains("reflection = \"on\""), "{text}");

    let again = |text: &str| {
        fs_write(&manifest, text);
        std::fs::remove_file(frame(folder.path(), 1)).expect("removed");
        let done = outcome(&mut render(&scene, &output, &["--resume"]));
        assert!(done.status.success() && !said(&done).contains("auto: "), "{}", said(&done));
        std::fs::read(frame(folder.path(), 1)).expect("a frame")
    };
    assert!(again(&text) == first);
    assert!(again(&text.replace("reflection = \"on\"", "reflection = \"off\"")) != first);
}

fn fs_write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("written");
}

/// Frames of a sequence that does not get to its end.
#[cfg(unix)]
const FRAMES: u32 = 150;

/// Renders a long sequence into a folder, `rain`, in which another has left a frame, and as soon as three frames are there does `harm` to
/// the process; what it said and how it ended. A limit on the size of files does not kill it.
#[cfg(unix)]
fn harmed(folder: &Path, harm: impl FnOnce(u32)) -> Output {
    let (scene, rain) = (folder.join("scene.toml"), folder.join("rain"));
    std::fs::write(&scene, SCENE).expect("a scene");
    std::fs::create_dir_all(&rain).expect("a folder");
    // The frame is of an earlier scene; the sequence does not come so far.
    image::GrayImage::new(1, 1).save(frame(&rain, FRAMES - 1)).expect("a frame");
    let program = render(&scene, &rain.join("rain.png"), &["--frames", &FRAMES.to_string()]);
    let mut command = crate::common::command("sh");
    command.args(["-c", "trap '' XFSZ; exec \"$@\"", "sh"]).arg(program.get_program());
    command.args(program.get_args());
    let running = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    let start = Instant::now();
    while !frame(&rain, 2).exists() {
        assert!(start.elapsed() < Duration::from_secs(600), "no frame after ten minutes");
        std::thread::sleep(Duration::from_millis(1));
    }
    harm(running.id());
    running.wait_with_output().expect("it ends")
}

/// Asserts a status, an error in one line that says `word`, and whole frames, some but not all, in the folder.
#[cfg(unix)]
#[track_caller]
fn ended_whole(ended: &Output, status: i32, word: &str, folder: &Path) {
    let error = crate::common::said::failure(ended, status);
    assert!(error.contains(word), "{error}");
    let pictures = (0..FRAMES).filter(|number| frame(folder, *number).exists()).count();
    assert!((3..FRAMES as usize).contains(&pictures), "{pictures} frames");
    let files = folder.read_dir().expect("a folder").count();
    assert_eq!(files, pictures + 1, "frames and manifest; nothing half written");
    for number in 0..pictures as u32 {
        raindrops::picture::Picture::read(&frame(folder, number)).expect("a whole frame");
    }
}

/// All frames come by `--resume`, as they would have come in one go.
#[cfg(unix)]
#[track_caller]
fn resumes(folder: &Path) {
    let rain = folder.join("rain");
    let output = rain.join("rain.png");
    let options = ["--resume", "--frames", &FRAMES.to_string()];
    let kept = changed(&frame(&rain, 1));
    let done = outcome(&mut render(&folder.join("scene.toml"), &output, &options));
    assert!(done.status.success(), "{}", said(&done));
    assert!((0..FRAMES).all(|number| frame(&rain, number).exists()));
    assert_eq!(changed(&frame(&rain, 1)), kept, "a frame that was there was rendered again");
    // The rain stands still from the third frame on.
    let read = |number| std::fs::read(frame(&rain, number)).expect("a frame");
    assert!(read(2) == read(FRAMES - 1));
}

#[cfg(unix)]
fn signal(name: &str, process: u32) {
    let sent = Command::new("kill").args([name, &process.to_string()]).status();
    assert!(sent.expect("kill").success());
}

/// An interrupt leaves whole frames and a status that says so; the rest comes by `--resume`.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_whole_frames() {
    for name in ["-INT", "-TERM"] {
        let folder = folder();
        let ended = harmed(folder.path(), |process| signal(name, process));
        ended_whole(&ended, 130, "--resume goes on", &folder.path().join("rain"));
        if name == "-INT" {
            resumes(folder.path());
        }
    }
}

/// A second interrupt ends it at once, and yet leaves nothing half written.
#[test]
#[cfg(unix)]
fn two_interrupts_leave_whole_frames() {
    let folder = folder();
    let ended = harmed(folder.path(), |process| {
        signal("-INT", process);
        // It may have ended by the first one.
        let _ = Command::new("kill").args(["-INT", &process.to_string()]).output();
    });
    assert_eq!(ended.status.code(), Some(130), "{}: {}", ended.status, said(&ended));
    let files = folder.path().join("rain").read_dir().expect("a folder");
    for path in files.map(|entry| entry.expect("an entry").path()) {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(name.starts_with("rain"), "{name} was left");
        if name.ends_with("png") {
            raindrops::picture::Picture::read(&path).expect("a whole frame");
        }
    }
}

/// The disk fills up: as a limit on the size of files, which the kernel reports alike.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_fills_up_leaves_whole_frames() {
    let folder = folder();
    let ended = harmed(folder.path(), |process| {
        let process = process.to_string();
        let limited = Command::new("prlimit").args(["--fsize=64", "--pid", &process]).status();
        assert!(limited.expect("prlimit").success());
    });
    ended_whole(&ended, 2, "File too large", &folder.path().join("rain"));
    resumes(folder.path());
}

/// The folder goes away, and so does one in whose place there is a file.
#[test]
#[cfg(unix)]
fn a_folder_that_goes_away_keeps_whole_frames() {
    for file_instead in [false, true] {
        let folder = folder();
        let (rain, away) = (folder.path().join("rain"), folder.path().join("away"));
        let ended = harmed(folder.path(), |_| {
            std::fs::rename(&rain, &away).expect("it is moved away");
            if file_instead {
                std::fs::write(&rain, "a file").expect("a file");
            }
        });
        ended_whole(&ended, 2, "there is no folder", &away);
        assert_eq!(rain.exists(), file_instead, "the folder was made again");
    }
}

#[test]
fn mistakes_in_a_film_are_told() {
    let folder = folder();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    for (text, expected) in [
        ("[film]\nfsp = 3", "did you mean `fps`"),
        ("[film]\ncamera = [{ at = 0, position = [0, 0, 0], targt = [0, 0, 1] }]", "`target`"),
        ("[film]\npace = [{ at = 1, rate = 0 }, { at = 1, rate = 1 }]", "later time"),
        ("[film]\nfps = nan", "fps = NaN"),
        (
            "[[film.camera]]\nat = 0.5\nposition = [0, 0, 0]\ntarget = [0, 0, 0]",
            "camera key at 0.5: position and target",
        ),
    ] {
        std::fs::write(&scene, text).expect("a scene");
        let refused = outcome(&mut render(&scene, &output, &[]));
        let said = said(&refused);
        assert_eq!(refused.status.code(), Some(2), "{text}: {said}");
        assert!(said.contains(expected) && said.trim().lines().count() == 1, "{text}: {said}");
    }
    std::fs::write(&scene, SCENE).expect("a scene");
    let stored = ["--preset", "paper", "--simulation", "stored", "--resume"];
    let refused = outcome(&mut render(&scene, &output, &stored));
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("stored positions"), "{}", said(&refused));
}

/// A frame that was cut off from outside, as by a full disk under a copy, is drawn again, and said.
#[test]
fn a_frame_that_is_cut_off_is_drawn_again() {
    let folder = folder();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).expect("a scene");
    for extension in ["png", "exr"] {
        let output = folder.path().join(format!("rain.{extension}"));
        let done = outcome(&mut render(&scene, &output, &["--frames", "3"]));
        assert!(done.status.success(), "{}", said(&done));
        let frame = |number| folder.path().join(format!("rain-{number:04}.{extension}"));
        let whole = std::fs::read(frame(1)).expect("a frame");
        let untouched = changed(&frame(2));
        for left in [whole.len() - 1, whole.len() / 2, 3, 0] {
            std::fs::write(frame(1), &whole[..left]).expect("it is cut");
            let resumed = outcome(&mut render(&scene, &output, &["--frames", "3", "--resume"]));
            assert!(resumed.status.success(), "{}", said(&resumed));
            let name = format!("rain-0001.{extension} is cut off");
            assert!(said(&resumed).contains(&name), "{left} bytes: {}", said(&resumed));
            assert!(std::fs::read(frame(1)).expect("a frame") == whole, "{left} bytes stay");
            assert_eq!(changed(&frame(2)), untouched, "a whole frame is drawn again");
        }
    }
}
