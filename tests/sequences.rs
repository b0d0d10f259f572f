//! Sequences by the command: a film's frames, what an interrupt leaves, and going on after it.

mod common;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

const SCENE: &str = "
[rain]
count = 500
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
    let mut command = common::raindrops();
    command.arg("render").arg(scene).arg("-o").arg(output).args(options);
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        command.args(["--device", &device]);
    }
    command
}

fn run(command: &mut Command) -> Output {
    command.output().expect("the program starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
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
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let done = run(&mut render(&scene, &output, &["--validate"]));
    assert!(done.status.success(), "{}", said(&done));
    let frames: Vec<_> = (0..6)
        .map(|number| std::fs::read(frame(folder.path(), number)).expect("a frame"))
        .collect();
    assert!(!frame(folder.path(), 6).exists(), "the film has six frames");
    assert!(frames[0] != frames[1] && frames[1] != frames[2], "the rain falls");
    assert!(frames[2..].windows(2).all(|pair| pair[0] == pair[1]), "the rain stands still");

    std::fs::remove_file(frame(folder.path(), 1)).expect("removed");
    let others = [0, 2, 5].map(|number| changed(&frame(folder.path(), number)));
    let done = run(&mut render(&scene, &output, &["--resume"]));
    assert!(done.status.success(), "{}", said(&done));
    assert!(std::fs::read(frame(folder.path(), 1)).expect("a frame") == frames[1]);
    assert_eq!(others, [0, 2, 5].map(|number| changed(&frame(folder.path(), number))));

    let refused = run(&mut render(&scene, &output, &["--resume", "--drops", "501"]));
    let said = said(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("rain.frames.toml") && said.contains("count = 500"), "{said}");
}

/// An interrupt leaves whole frames and a status that says so; the rest comes by `--resume`.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_whole_frames() {
    const FRAMES: u32 = 150;
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("rain.png"));
    std::fs::write(&scene, SCENE).expect("a scene");
    let count = FRAMES.to_string();
    let running = render(&scene, &output, &["--frames", &count])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while !frame(folder.path(), 2).exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no frame after a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
    let interrupt = Command::new("kill").args(["-INT", &running.id().to_string()]).status();
    assert!(interrupt.expect("kill").success());
    let ended = running.wait_with_output().expect("it ends");
    assert_eq!(ended.status.code(), Some(2), "{}", said(&ended));
    assert!(said(&ended).contains("--resume goes on"), "{}", said(&ended));

    let there =
        |folder: &Path| (0..FRAMES).filter(|number| frame(folder, *number).exists()).count();
    let pictures = there(folder.path());
    assert!((3..FRAMES as usize).contains(&pictures), "{pictures} frames");
    let files = folder.path().read_dir().expect("a folder").count();
    assert_eq!(files, pictures + 2, "frames, scene and manifest; nothing half written");
    for number in 0..pictures as u32 {
        raindrops::picture::Picture::read(&frame(folder.path(), number)).expect("a whole frame");
    }
    let done = run(&mut render(&scene, &output, &["--resume", "--frames", &count]));
    assert!(done.status.success(), "{}", said(&done));
    assert_eq!(there(folder.path()), FRAMES as usize);
}

#[test]
fn mistakes_in_a_film_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
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
        let refused = run(&mut render(&scene, &output, &[]));
        let said = said(&refused);
        assert_eq!(refused.status.code(), Some(2), "{text}: {said}");
        assert!(said.contains(expected) && said.trim().lines().count() == 1, "{text}: {said}");
    }
    std::fs::write(&scene, SCENE).expect("a scene");
    let stored = ["--preset", "paper", "--simulation", "stored", "--resume"];
    let refused = run(&mut render(&scene, &output, &stored));
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("stored positions"), "{}", said(&refused));
}
