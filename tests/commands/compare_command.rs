//! `raindrops reference` and `raindrops compare` as their users call them: files, figures, exit
//! status. Neither needs a GPU.

use std::path::Path;
use std::process::Output;

use glam::Vec3;
use raindrops::picture::{Picture, write_png};

fn raindrops(folder: &Path, arguments: &[&str]) -> Output {
    crate::common::raindrops()
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the command runs")
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("not killed")
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const SCENE: &str = "
    image = { width = 40, height = 24 }
    environment = { radiance = [1.0, 0.5, 0.25] }
    [[drop]]
    center = [0.0, 0.0, -3.0]
";

#[test]
fn the_truth_is_written_and_compares_with_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("scene.toml"), SCENE).expect("written");
    for (name, extra) in
        [("a.exr", "--samples=64"), ("b.exr", "--samples=16"), ("c.png", "--samples=4")]
    {
        let made = raindrops(
            at,
            &[
                "reference",
                "scene.toml",
                "-o",
                name,
                extra,
                "--internal-reflections",
                "0",
                "--coverage",
                "m.exr",
            ],
        );
        assert_eq!(status(&made), 0, "{}", complaint(&made));
    }
    let truth = Picture::read(&at.join("a.exr")).expect("readable");
    assert_eq!((truth.width, truth.height), (40, 24));
    assert_eq!(truth.pixels[0], Vec3::new(1.0, 0.5, 0.25));

    let same = raindrops(
        at,
        &["compare", "a.exr", "a.exr", "--max-flip", "0", "--max-error", "0", "--min-psnr", "200"],
    );
    assert_eq!(status(&same), 0, "{}", complaint(&same));

    let arguments = [
        "compare",
        "a.exr",
        "b.exr",
        "--json",
        "f.json",
        "--difference",
        "d.png",
        "--mask",
        "m.exr",
    ];
    let compared = raindrops(at, &arguments);
    assert_eq!(status(&compared), 0, "{}", complaint(&compared));
    assert!(String::from_utf8_lossy(&compared.stdout).contains("relMSE"));
    let text = std::fs::read_to_string(at.join("f.json")).expect("written");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    // To stdout: the same, and nothing else there.
    let shown = raindrops(at, &["compare", "a.exr", "b.exr", "--mask", "m.exr", "--json", "-"]);
    assert_eq!(status(&shown), 0, "{}", complaint(&shown));
    assert!(
        serde_json::from_slice::<serde_json::Value>(&shown.stdout)
            .is_ok_and(|of| of["flip"] == json["flip"])
    );
    assert!(complaint(&shown).is_empty() && !at.join("-").exists(), "in place of the table");
    for key in ["rel_mse", "psnr_db", "flip", "flip_p99", "max_error", "mean_a", "mean_b"] {
        assert!(json[key].as_f64().is_some_and(|value| value > 0.0), "{key}: {}", json[key]);
    }
    assert!(Picture::is_display(&at.join("d.png")).expect("written"));

    // Colours are evenly spaced over the error's square root: from black to violet (linear 0.12, 0.01, 0.35) at 1/16.
    for (name, gray) in [("even.exr", 0.2), ("lighter.exr", 0.205)] {
        let pixels = vec![Vec3::splat(gray); 32 * 32];
        let even = Picture { width: 32, height: 32, pixels };
        even.write_exr(&at.join(name)).expect("a picture");
    }
    let arguments =
        ["compare", "even.exr", "lighter.exr", "--json", "e.json", "--difference", "e.png"];
    assert_eq!(status(&raindrops(at, &arguments)), 0);
    let text = std::fs::read_to_string(at.join("e.json")).expect("written");
    let even: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let flip = even["flip"].as_f64().expect("an error") as f32;
    let color = Picture::read(&at.join("e.png")).expect("written").pixels[32 * 16 + 16];
    let expected = 4.0 * flip.sqrt() * Vec3::new(0.12, 0.01, 0.35);
    assert!(
        flip > 0.002 && flip < 0.0625 && color.distance(expected) < 0.01,
        "{flip}: {color}, not {expected}"
    );

    // Over no pixel any two pictures are alike.
    let none = Picture { pixels: vec![Vec3::ZERO; truth.pixels.len()], ..truth.clone() };
    none.write_exr(&at.join("none.exr")).expect("a mask");
    let refused = raindrops(at, &["compare", "a.exr", "b.exr", "--mask", "none.exr"]);
    assert_eq!(status(&refused), 2);
    assert!(complaint(&refused).contains("none.exr: it has no pixel over 0"));

    // Every bound can fail, and says so.
    for bound in
        ["--max-flip=0", "--max-rel-mse=0", "--min-psnr=200", "--max-error=0", "--max-flip=nan"]
    {
        let failed = raindrops(at, &["compare", "a.exr", "b.exr", bound]);
        assert_eq!(status(&failed), 1, "{bound}");
        assert!(complaint(&failed).contains("the bound"), "{}", complaint(&failed));
    }
}

#[test]
fn what_cannot_be_compared_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let grey = |width, height| {
        let pixels = vec![Vec3::splat(0.5); (width * height) as usize];
        Picture { width, height, pixels }
    };
    grey(4, 4).write_exr(&at.join("a.exr")).expect("written");
    grey(5, 4).write_exr(&at.join("wider.exr")).expect("written");
    write_png(&at.join("p.png"), 4, 4, &[9; 48]).expect("written");
    std::fs::write(at.join("bad.exr"), [0x76, 0x2f, 0x31, 0x01]).expect("written");
    std::fs::write(at.join("text.png"), "no picture").expect("written");
    for (b, word) in [
        ("wider.exr", "sizes"),
        ("p.png", "radiance"),
        ("bad.exr", "bad.exr"),
        ("text.png", "text.png"),
        ("none.exr", "none.exr"),
    ] {
        let failed = raindrops(at, &["compare", "a.exr", b]);
        assert_eq!(status(&failed), 2, "{b}");
        let said = complaint(&failed);
        assert!(said.contains(word) && said.trim_end().lines().count() == 1, "{said}");
    }
    let equal = raindrops(at, &["compare", "p.png", "p.png", "--max-flip", "0"]);
    assert_eq!(status(&equal), 0, "{}", complaint(&equal));
    for output in ["x.jpg", "none/x.exr"] {
        let failed = raindrops(at, &["reference", "-o", output]);
        assert_eq!(status(&failed), 2);
        assert_eq!(complaint(&failed).trim_end().lines().count(), 1, "{}", complaint(&failed));
    }
}
