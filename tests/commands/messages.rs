//! What the command says while it works: how much, in which colours, and to a reader that goes away.

use std::fs;
use std::process::Stdio;

use raindrops::picture::layers::Layers;

use crate::command_line::{SMALL, error_line, raindrops};
use crate::common::said::{FAILURE, lines, said};
use crate::common::{folder, outcome};

/// How much is said, and in which colours; which device, where no option says so.
#[test]
fn messages_are_as_they_are_asked_for() {
    let folder = folder();
    let said = |arguments: &[&str]| {
        let mut command = raindrops(folder.path(), &SMALL);
        if !arguments.contains(&"-o") {
            command.args(["-o", "a.png"]);
        }
        let output = outcome(command.args(arguments));
        (output.status.code(), String::from_utf8(output.stderr).expect("text"))
    };
    assert_eq!(said(&["--quiet", "--preset", "paper"]), (Some(0), String::new()));
    let (_, usual) = said(&["--preset", "paper"]);
    assert!(usual.contains("in view") && !usual.contains("pass simulate"), "{usual}");
    let (_, verbose) = said(&["-v", "--preset", "paper"]);
    for word in ["pass simulate: ", "preparing the renderer: done in", "in view"] {
        assert!(verbose.contains(word), "no '{word}' in {verbose}");
    }
    // Warnings and errors are printed in any case.
    let (_, warned) = said(&["-q", "--error", "0.0000001"]);
    assert!(warned.starts_with("warning: "), "{warned}");
    // Drops that nothing in the picture hides; layers are composited over what does.
    let mut depth = Layers::empty(32, 32);
    depth.depth.fill(100.0);
    depth.write_depth(&folder.path().join("depth.exr")).expect("a depth");
    let hidden = ["-q", "--preset", "fast", "--depth", "depth.exr"];
    let (status, warned) = said(&hidden);
    assert!(status == Some(0) && warned.contains("--background shows it"), "{warned}");
    let (_, warned) = said(&[&hidden[..], &["--layers", "-o", "a.exr"]].concat());
    assert_eq!(warned, "");
    // A photograph is as bright as it shall be shown.
    let photo = image::RgbImage::from_pixel(32, 32, image::Rgb([200, 150, 100]));
    photo.save(folder.path().join("photo.png")).expect("a photograph");
    let before = ["--preset", "fast", "--background", "photo.png"];
    let (_, noted) = said(&before);
    assert!(noted.contains("--tone-map none keeps its colours"), "{noted}");
    let (_, noted) = said(&[&before[..], &["--tone-map", "none"]].concat());
    assert!(!noted.contains("keeps its colours"), "{noted}");
    let (_, noted) = said(&[&before[..], &["-o", "a.exr"]].concat());
    assert!(!noted.contains("keeps its colours"), "{noted}");
    // No rain at all, of either kind.
    fs::write(folder.path().join("real.toml"), "[rain]\nrate = 25").expect("a scene");
    let real = ["render", "real.toml", "--drops", "0", "--size", "32x32", "-o", "a.png"];
    let dry = outcome(&mut raindrops(folder.path(), &real));
    assert!(String::from_utf8_lossy(&dry.stderr).contains("0 drops, 0 in view"));
    // What the parser says of a number below 0 has no words on how to pass it as something else.
    let refused =
        outcome(&mut raindrops(folder.path(), &["render", "--drops", "-5", "-o", "a.png"]));
    let refused = error_line(&refused);
    assert!(refused.contains("-5") && !refused.contains("-- -5"), "{refused}");
    let (status, plain) = said(&["-q", "--device", "none", "--color", "never"]);
    assert!(status == Some(2) && plain.starts_with("raindrops: "), "{plain}");
    let (_, colored) = said(&["--device", "none", "--color", "always"]);
    assert!(colored.starts_with("\u{1b}["), "{colored:?}");
    let (_, refused) = said(&["--color", "always", "--nonsense"]);
    assert!(refused.starts_with("\u{1b}["), "what the parser says, too: {refused:?}");
    let mut command = raindrops(folder.path(), &SMALL);
    let output = outcome(command.args(["-o", "a.png"]).env("RAINDROPS_DEVICE", "no-such-device"));
    assert!(error_line(&output).contains("no-such-device"));
}

/// On a terminal, by util-linux's `script`: colours, unless NO_COLOR is set.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_has_colours_unless_it_wants_none() {
    let line = format!("'{}' render --nonsense", env!("CARGO_BIN_EXE_raindrops"));
    let said = |variable: &str| {
        let mut command = crate::common::command("script");
        command.args(["-qec", &line, "/dev/null"]).env("TERM", "xterm");
        let output = outcome(command.env(variable, "1").stdin(Stdio::null()));
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let (usual, plain) = (said("OTHER"), said("NO_COLOR"));
    assert!(usual.contains("\u{1b}[") && usual.contains("--nonsense"), "{usual:?}");
    assert!(!plain.contains('\u{1b}') && plain.contains("--nonsense"), "{plain:?}");
}

/// A reader that goes away, as `head -1` does, is no error.
#[test]
fn a_closed_pipe_is_no_error() {
    let folder = folder();
    let probe = ["devices", "--probe", "--json", "a.json"];
    for arguments in [&["devices"][..], &["plan"], &probe] {
        let mut child = raindrops(folder.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("the command ends");
        assert!(lines(&said(&output), FAILURE).is_empty(), "{arguments:?}: {}", said(&output));
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    }
    assert!(
        folder.path().join("a.json").exists(),
        "what nobody reads kept the file from being written"
    );
}
