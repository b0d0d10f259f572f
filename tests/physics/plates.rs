//! Backgrounds of the reference: colour and depth behind the drops, and the files that they are read from.

use std::path::Path;

use exr::prelude::*;
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::picture::Picture;
use raindrops::picture::plate::{Depth, Plate};
use raindrops::reference::{Traced, Tracer, Truth};
use raindrops::scene::background::DepthKind;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::kept_folder;

/// A drop of some 14 pixels of radius in 48 x 48, `x` to the right.
fn scene(x: f64) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (48, 48);
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(x, 0.0, -3.0), 1.6)];
    scene
}

fn truth() -> Truth {
    Truth { samples: 64, ..Truth::default() }
}

/// One depth everywhere, but `left` in the left half.
fn depth(left: f64, right: f64, kind: DepthKind) -> Plate {
    let values = (0..48 * 48).map(|pixel| if pixel % 48 < 24 { left } else { right }).collect();
    Plate::new(None, Some(Depth { values, kind }))
}

fn traced(scene: &Scene, plate: Plate) -> Traced {
    let white = Environment::constant(Vec3::ONE);
    Tracer::new(scene, &white, truth()).before(plate).trace(&|_| ())
}

#[test]
fn colour_is_seen_where_drops_leave_it_free() {
    let colors: Vec<Vec3> = (0..48 * 48).map(|i| Vec3::new(i as f32, 0.5, 7.0)).collect();
    let color = Picture { width: 48, height: 48, pixels: colors.clone() };
    // The drop takes its light from the environment, which is black.
    let black = Environment::constant(Vec3::ZERO);
    let tracer = Tracer::new(&scene(0.0), &black, truth());
    let traced = tracer.before(Plate::new(Some(color), None)).trace(&|_| ());
    let mut covered = 0;
    for ((pixel, color), share) in traced.picture.pixels.iter().zip(&colors).zip(&traced.coverage) {
        let expected = *color * (1.0 - share);
        assert!((*pixel - expected).abs().max_element() < 1e-5 * color.max_element());
        covered += u32::from(*share > 0.0);
    }
    assert!(covered > 300);
}

#[test]
fn what_is_nearer_hides_drops() {
    let whole = traced(&scene(0.0), Plate::default());
    // The drop is met from depth 1.4 to 3: behind the left half's, before the right's.
    let half = traced(&scene(0.0), depth(1.0, 10.0, DepthKind::Planar));
    for (pixel, (half, whole)) in half.coverage.iter().zip(&whole.coverage).enumerate() {
        assert_eq!(*half, if pixel % 48 < 24 { 0.0 } else { *whole });
    }
    // Depth within the drop: its front shows through it, its rim is hidden.
    let within = traced(&scene(0.0), depth(1.7, 1.7, DepthKind::Planar));
    let at = |traced: &Traced, column: usize| traced.coverage[24 * 48 + column];
    assert_eq!((at(&within, 24), at(&whole, 24)), (1.0, 1.0));
    let rim = (0..48).rev().find(|&column| at(&whole, column) == 1.0).expect("the rim");
    assert!(at(&within, rim) < 0.1);
}

/// Where a ray meets the front of the drop, in closed form on the middle row, for both kinds of depth.
#[test]
fn depth_is_along_the_axis_or_along_the_ray() {
    // To the side, where the two are far apart.
    let scene = scene(2.0);
    let view = scene.view();
    let column = 38;
    let direction = view.ray(f64::from(column) + 0.5, 24.0);
    let center = DVec3::new(2.0, 0.0, -3.0);
    let along = center.dot(direction);
    let distance = along - (along * along - center.length_squared() + 1.6 * 1.6).sqrt();
    let planar = distance * -direction.z;
    assert!(distance > 1.1 * planar);
    for (kind, front) in [(DepthKind::Planar, planar), (DepthKind::Radial, distance)] {
        let covered = |depth_there: f64| {
            let picture = traced(&scene, depth(depth_there, depth_there, kind));
            picture.coverage[24 * 48 + column as usize]
        };
        // The front of the drop is deep by some percent within the pixel.
        assert_eq!((covered(0.95 * front), covered(1.05 * front)), (0.0, 1.0), "{kind:?}");
    }
}

#[test]
fn a_drop_that_moves_behind_an_edge_is_seen_until_it_is_there() {
    let mut scene = scene(3.0);
    scene.drops[0].radius = 0.4;
    scene.drops[0].velocity = DVec3::new(-6.0, 0.0, 0.0);
    scene.camera.shutter = 1.0;
    let free = traced(&scene, Plate::default());
    let half = traced(&scene, depth(1.0, 10.0, DepthKind::Planar));
    let mut left = 0.0;
    for (pixel, (half, free)) in half.coverage.iter().zip(&free.coverage).enumerate() {
        assert_eq!(*half, if pixel % 48 < 24 { 0.0 } else { *free });
        left += if pixel % 48 < 24 { *free } else { 0.0 };
    }
    assert!(left > 10.0, "it goes on to the left");
}

/// Glints are found on a way of their own, and are hidden all the same.
#[test]
fn hidden_drops_have_no_glints() {
    let mut texels = vec![Vec3::splat(0.1); 128 * 64];
    texels[20 * 128 + 20] = Vec3::splat(3e4);
    let sun = Environment::from_texels("sun", 128, 64, texels).expect("valid");
    assert!(split(&sun).is_some());
    let picture = |plate| Tracer::new(&scene(0.0), &sun, truth()).before(plate).picture();
    let (free, hidden) = (picture(Plate::default()), picture(depth(1.0, 1.0, DepthKind::Planar)));
    let brightest =
        |picture: &Picture| picture.pixels.iter().map(|pixel| pixel.x).fold(0.0, f32::max);
    assert!(brightest(&free) > 10.0 * brightest(&hidden));
    assert!(hidden.pixels.iter().all(|pixel| pixel.abs_diff_eq(Vec3::splat(0.1), 1e-6)));
}

/// An EXR of 8 x 8 with one channel.
fn write_channel(path: &Path, name: &str, value: impl Fn(usize) -> f32) {
    let samples = FlatSamples::F32((0..64).map(value).collect());
    let channel = AnyChannel::new(name, samples);
    let layer = Layer::new(
        (8, 8),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort([channel].into_iter().collect()),
    );
    Image::from_layer(layer).write().to_file(path).expect("a file");
}

fn write_png(path: &Path, value: impl Fn(u32) -> u16) {
    let pixel = |x: u32, y: u32| image::Luma([value(8 * y + x)]);
    image::ImageBuffer::from_fn(8, 8, pixel).save(path).expect("a file");
}

/// Runs `reference` on a drop at depth 2 to 4, 8 x 8: what the drop covers, or the problem.
fn reference(arguments: &[&str]) -> std::result::Result<Picture, String> {
    // The folder is this call's own: tests run side by side, and a file that another rewrites is empty for a moment.
    let folder = tempfile::tempdir().expect("a folder");
    let [scene, coverage, picture] =
        ["drop.toml", "coverage.exr", "picture.exr"].map(|name| folder.path().join(name));
    let toml = "[image]\nwidth = 8\nheight = 8\n[[drop]]\ncenter = [0, 0, -3]\n";
    std::fs::write(&scene, toml).expect("a file");
    let ran = crate::common::raindrops()
        .arg("reference")
        .arg(&scene)
        .args(["--samples", "4", "--coverage"])
        .arg(&coverage)
        .arg("-o")
        .arg(&picture)
        .args(arguments)
        .output()
        .expect("it runs");
    if !ran.status.success() {
        return Err(String::from_utf8_lossy(&ran.stderr).into_owned());
    }
    Ok(Picture::read(&coverage).expect("coverage"))
}

#[test]
fn depth_is_read_from_exr_and_png() {
    let folder = kept_folder("plates");
    let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (near, far, layered, png) = (path("n.exr"), path("f.exr"), path("l.exr"), path("d.png"));
    write_channel(Path::new(&near), "Z", |_| 1.0);
    write_channel(Path::new(&far), "Z", |_| 9.0);
    write_channel(Path::new(&layered), "Depth.Z", |_| 1.0);
    write_png(Path::new(&png), |_| 1000);
    for (arguments, is_seen) in [
        (vec!["--depth", &near], false),
        (vec!["--depth", &far], true),
        (vec!["--depth", &near, "--depth-scale", "9"], true),
        (vec!["--depth", &layered], false),
        (vec!["--depth", &png, "--depth-scale", "0.001"], false),
        (vec!["--depth", &png, "--depth-scale", "0.009"], true),
    ] {
        let coverage = reference(&arguments).expect("coverage");
        assert_eq!(coverage.pixels[8 * 4 + 4].x > 0.0, is_seen, "{arguments:?}");
    }
}

#[test]
fn bad_plates_are_refused_in_one_line() {
    let folder = kept_folder("plates");
    let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let mut wrong = Vec::new();
    for (name, value, told) in [
        ("nan.exr", f32::NAN, "column 3, row 2 is NaN"),
        ("infinite.exr", f32::NEG_INFINITY, "column 3, row 2 is -inf"),
        ("negative.exr", -1.0, "column 3, row 2 is -1"),
        ("zero.exr", 0.0, "column 3, row 2 is 0"),
    ] {
        let file = path(name);
        write_channel(Path::new(&file), "Z", |index| if index == 19 { value } else { 5.0 });
        wrong.push((vec!["--depth".to_string(), file], told));
    }
    let (alpha, png) = (path("alpha.exr"), path("16.png"));
    write_channel(Path::new(&alpha), "A", |_| 1.0);
    write_png(Path::new(&png), |_| 9);
    let eight = path("8.png");
    image::GrayImage::from_pixel(8, 8, image::Luma([9])).save(&eight).expect("a file");
    let small = path("small.png");
    image::GrayImage::from_pixel(4, 8, image::Luma([9])).save(&small).expect("a file");
    let text = path("text.exr");
    std::fs::write(&text, "not a picture").expect("a file");
    let nan = path("nan-color.exr");
    let color = Picture { width: 8, height: 8, pixels: vec![Vec3::NAN; 64] };
    color.write_exr(Path::new(&nan)).expect("a file");
    let of = |list: &[&str]| list.iter().map(|text| text.to_string()).collect::<Vec<_>>();
    wrong.extend([
        (of(&["--depth", &alpha]), "no depth, such as a channel Z or Depth.Z; it has A"),
        (of(&["--depth", &png]), "needs a scale"),
        (of(&["--depth", &eight, "--depth-scale", "1"]), "depth in a PNG has 16 bits"),
        (of(&["--depth", &png, "--depth-scale", "0"]), "depth_scale = 0 is not"),
        (of(&["--depth", &png, "--depth-scale", "nan"]), "depth_scale = NaN is not"),
        (of(&["--depth-scale", "2"]), "but no depth"),
        (of(&["--depth", &text]), "text.exr"),
        (of(&["--background", &text]), "text.exr"),
        (of(&["--background", &alpha]), "no channels R, G, B, nor Y; it has A"),
        (of(&["--background", &small]), "it is 4 x 8, the picture 8 x 8"),
        (of(&["--background", &nan]), "is full of NaN"),
        (of(&["--background", &path("none.exr")]), "none.exr"),
        (of(&["--background", "none.exr"]), "; looked for as /"),
    ]);
    for (arguments, told) in wrong {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let problem = reference(&arguments).expect_err("a refusal");
        assert!(problem.contains(told), "{arguments:?}: {problem}");
        assert_eq!(problem.lines().count(), 1, "{problem}");
    }
}

/// Every command that takes a plate, and what it would write stays unwritten.
#[test]
fn a_bad_plate_stops_every_command_before_it_writes() {
    let kept = tempfile::tempdir().expect("a folder");
    let path = |name: &str| kept.path().join(name).to_string_lossy().into_owned();
    let toml = "[image]\nwidth = 8\nheight = 8\n[model]\npreset = \"fast\"\n[[drop]]\ncenter = [0, 0, -3]\n";
    std::fs::write(path("drop.toml"), toml).expect("a file");
    write_channel(Path::new(&path("nan.exr")), "Z", |_| f32::NAN);
    write_channel(Path::new(&path("alpha.exr")), "A", |_| 1.0);
    write_png(Path::new(&path("16.png")), |_| 9);
    let picture = |width: u32| image::ImageBuffer::from_pixel(width, 8, image::Luma([9u16]));
    picture(4).save(path("small.png")).expect("a file");
    let commands: [&[&str]; 5] = [
        &["reference", "--samples", "4", "-o", "x.exr", "--coverage", "y.exr"],
        &["render", "-o", "x.png"],
        &["render", "--layers", "-o", "x.exr"],
        &["render", "--frames", "2", "-o", "x.png"],
        &["dataset", "--views", "1", "-o", "set"],
    ];
    for command in commands {
        for (file, options, words) in [
            ("nan.exr", vec!["--depth"], "column 0, row 0 is NaN"),
            ("alpha.exr", vec!["--depth"], "it has no depth"),
            ("16.png", vec!["--depth"], "needs a scale"),
            ("small.png", vec!["--depth-scale", "1", "--depth"], "it is 4 x 8, the picture 8 x 8"),
            ("small.png", vec!["--background"], "it is 4 x 8, the picture 8 x 8"),
        ] {
            let written = tempfile::tempdir().expect("a folder");
            let ran = crate::common::raindrops()
                .current_dir(written.path())
                .args(&command[..1])
                .arg(path("drop.toml"))
                .args(&command[1..])
                .args(&options)
                .arg(path(file))
                .output()
                .expect("it runs");
            let said = String::from_utf8_lossy(&ran.stderr);
            assert_eq!(ran.status.code(), Some(2), "{command:?}, {file}: {said}");
            let problems = said.lines().filter(|line| line.starts_with("raindrops: "));
            assert!(problems.count() == 1 && said.contains(words), "{command:?}, {file}: {said}");
            let files = written.path().read_dir().expect("a folder").count();
            assert_eq!(files, 0, "{command:?}, {file}: something is written");
        }
    }
}
