//! Mutants of the other files that are read: scenes, and pictures to compare.

use glam::Vec3;
use raindrops::picture::depth::DecodedDepth;
use raindrops::picture::{Picture, write_png};
use raindrops::scene::Scene;
use raindrops::scene::background::Background;

use crate::broken::mutants;
use crate::files::{DWA, Folder, exr_half};

const SCENE: &str = r#"
seed = 7
time = -3.5e3
[camera]
position = [0.0, 2.0, 0.0]
target = [0.0, 2.0, -1.0]
vertical_fov = 60.0
near_fade = 1
[image]
width = 640
height = 480
[environment]
file = "sky.exr"
[rain]
count = 300_000
half_extent = [300.0, 300.0, 300.0]
velocity = [0.0, -9.0, 0.0]
[[drop]]
center = [0.0, 2.0, -4.0]
radius = 1.0
[model]
preset = "fast"
samples = 4
[tone_map]
key = 0.18
"#;

#[test]
fn mutants_of_a_scene_are_parsed_or_refused_in_one_line() {
    let read = |bytes: &[u8]| {
        let parsed = Scene::parse(&String::from_utf8_lossy(bytes), "scene.toml");
        parsed.inspect_err(|error| assert!(error.to_string().contains("scene.toml"), "{error}"))
    };
    // What is accepted can be planned or is refused there, and its camera is sound.
    let is_sound = |scene: &Scene| {
        let white = raindrops::environment::Environment::constant(glam::Vec3::ONE);
        let _ = raindrops::plan::plan(scene, &white, raindrops::plan::Output::Display);
        scene.view().focal_px.is_finite()
    };
    let (parsed, refused) = mutants("scenes", SCENE.as_bytes(), 77, 1 << 20, read, is_sound);
    assert!(parsed > 0 && refused > parsed / 10);
}

#[test]
fn mutants_of_pictures_are_read_or_refused() {
    let folder = Folder::new();
    let picture =
        Picture { width: 16, height: 8, pixels: (0..128).map(|n| Vec3::splat(n as f32)).collect() };
    let (exr, png) = (folder.path("a.exr"), folder.path("a.png"));
    picture.write_exr(&exr).expect("a picture");
    write_png(&png, 16, 8, &[100; 384]).expect("a picture");
    let [_, dwab] = DWA.map(|(name, bytes)| folder.write(name, bytes));
    // Its decoder panics on some, where overflow is checked.
    let b44 = folder.write("b44.exr", &exr_half(exr::prelude::Compression::B44));
    let kinds = [
        "05-cut-off-jpeg/plate-progressive-whole.jpg",
        "03-jpeg-cmyk-ycck/ycck-adobe.jpg",
        "08-layers-of-colour/multipart.exr",
        "04-colour-profile/display-p3.png",
        "02-hdr-header/orient3.hdr",
    ];
    let kinds = kinds.map(|name| {
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases").join(name)
    });
    for path in [exr, png, dwab, b44].into_iter().chain(kinds) {
        let bytes = std::fs::read(&path).expect("a picture");
        let read = |bytes: &[u8]| Picture::from_bytes(&path, bytes);
        let is_whole =
            |picture: &Picture| picture.pixels.len() as u32 == picture.width * picture.height;
        let name = path.display().to_string();
        let (_, refused) = mutants(&name, &bytes, 5, 1 << 30, read, is_whole);
        assert!(refused > 0);
    }
}

/// Depth of files that are changed at random is over 0, or refused in a line.
#[test]
fn mutants_of_depth_are_read_or_refused() {
    let cases = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases");
    let background =
        Background { depth_scale: Some(0.01), depth_invalid: Some(0.0), ..Background::default() };
    for name in ["07-depth-among-aovs/arnold.exr", "09-depth-as-tools-write-it/kitti.png"] {
        let path = cases.join(name);
        let bytes = std::fs::read(&path).expect("a file");
        let read = |bytes: &[u8]| DecodedDepth::from_bytes(&path, bytes, &background);
        let is_sound = |DecodedDepth { depth, width, height, .. }: &DecodedDepth| {
            depth.values.len() as u32 == width * height
                && depth.values.iter().all(|depth| depth.is_finite() && *depth > 0.0)
        };
        let (read, refused) = mutants(name, &bytes, 7, 1 << 30, read, is_sound);
        assert!(read > 0 && refused > 0);
    }
}

/// Halves end at 65,504: what is brighter is told, and no infinity.
#[test]
fn pictures_of_halves_have_no_infinity() {
    let folder = Folder::new();
    let path = folder.path("half.exr");
    for (radiance, is_told) in [(65504.0, false), (2e5, true), (1e30, true)] {
        let pixels = vec![Vec3::new(1.0, radiance, 0.25); 6];
        let picture = Picture { width: 3, height: 2, pixels };
        assert_eq!(picture.write_exr_f16(&path).expect("a picture"), is_told);
        let read = Picture::read(&path).expect("a picture");
        assert!(read.pixels.iter().all(|pixel| *pixel == Vec3::new(1.0, 65504.0, 0.25)));
    }
}

/// Sound files for the fuzzer to begin with, in the folders where it looks for them.
#[test]
#[ignore = "writes the seeds of the fuzz targets into fuzz/corpus"]
fn seeds() {
    let corpus = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    let mut files = vec![("scene", "scene.toml".to_string(), SCENE.as_bytes().to_vec())];
    let table = b"x,y,z,pscale,id\n1,2,3,0.1,7\n";
    let header = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
    let array = b"\x93NUMPY\x01\0\x43\0{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }       \n\0\0\0\0\0\0\0\0\0\0\0\0";
    for (name, bytes) in [("p.csv", &table[..]), ("p.ply", header), ("p.npy", array)] {
        files.push(("particles", name.into(), bytes.to_vec()));
    }
    for (name, bytes) in crate::files::all() {
        files.push(("environment", name.clone(), bytes.clone()));
        files.push(("depth", name.clone(), bytes.clone()));
        files.push(("picture", name, bytes));
    }
    for (target, name, bytes) in files {
        std::fs::create_dir_all(corpus.join(target)).expect("a folder");
        std::fs::write(corpus.join(target).join(name), bytes).expect("a seed");
    }
}
