//! Backgrounds on the GPU: colour and depth behind the drops, against the reference, which takes the same.

use std::path::PathBuf;
use std::sync::Arc;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, WritableImage};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::picture::plate::Plate;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::renderer::parts::{Grid, Parts, empty_picture, place};
use raindrops::scene::background::{Background, DepthKind};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::picture::{against, by_preset, renderer};
use crate::common::{Random, kept_folder, on_device, waves};

const EDGE: u32 = 96;

fn file(name: &str) -> PathBuf {
    kept_folder("plates-drawn").join(name)
}

/// A plate's depth, pixel by pixel, as an EXR of `EDGE` pixels an edge.
fn depth_file(name: &str, depth: impl Fn(u32, u32) -> f32) -> PathBuf {
    let values = (0..EDGE * EDGE).map(|at| depth(at % EDGE, at / EDGE)).collect();
    let channel = AnyChannel::new("Z", FlatSamples::F32(values));
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let edge = EDGE as usize;
    let layer = Layer::new((edge, edge), Default::default(), Encoding::SMALL_LOSSLESS, channels);
    let path = file(name);
    exr::prelude::Image::from_layer(layer).write().to_file(&path).expect("a file");
    path
}

/// Bright, in coarse squares, so that a pixel that is off shows.
fn color_file(name: &str) -> PathBuf {
    let pixel = |at: u32| {
        let (x, y) = (at % EDGE, at / EDGE);
        Vec3::new((x % 7) as f32, (y % 5) as f32, 2.0 + ((x / 8 + y / 8) % 2) as f32)
    };
    let picture =
        Picture { width: EDGE, height: EDGE, pixels: (0..EDGE * EDGE).map(pixel).collect() };
    let path = file(name);
    picture.write_exr(&path).expect("a file");
    path
}

/// Drops of all sizes, from half a pixel of radius to fifteen, between depth 2 and 10, none within another.
fn drops(count: usize) -> Scene {
    let mut random = Random(5);
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    while scene.drops.len() < count {
        let depth = 2.0 + 8.0 * random.unit();
        let mut across = || 1.9 * (random.unit() - 0.5) * depth;
        let center = DVec3::new(across(), across(), -depth);
        let pixels = 0.5 * 30f64.powf(random.unit());
        let radius = pixels * depth / f64::from(EDGE / 2);
        let is_free = |other: &PlacedDrop| center.distance(other.center) > radius + other.radius;
        if scene.drops.iter().all(is_free) {
            scene.drops.push(PlacedDrop::sphere(center, radius));
        }
    }
    scene
}

fn draw(device: &Arc<Device>, scene: &Scene, environment: &Environment, preset: Preset) -> Picture {
    by_preset(device, scene, environment, preset).0
}

fn truth(scene: &Scene, environment: &Environment, samples: u32, rain_to: Option<f64>) -> Picture {
    let truth = Truth { samples, rain_to, ..Truth::default() };
    let plate = Plate::of(scene).expect("a plate");
    Tracer::new(scene, environment, truth).before(plate).picture()
}

/// FLIP of pixels.
fn flip(truth: &Picture, picture: &Picture) -> f64 {
    against(truth, picture).pixels.flip
}

/// A slanted plane, through drops, and a step, along both kinds of depth: as near to the truth as without a depth, and
/// far nearer than where the depth is left out.
#[test]
fn drops_are_hidden_by_what_is_nearer() {
    let sky = waves();
    let base = drops(150);
    let slant = depth_file("slant.exr", |x, y| 2.5 + 5.0 * (x + y) as f32 / (2 * EDGE) as f32);
    let step = depth_file("step.exr", |x, _| if x < EDGE / 2 { 4.0 } else { 20.0 });
    let free = truth(&base, &sky, 64, None);
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let without = draw(device, &base, &sky, preset);
            let usual = flip(&free, &without);
            for (file, kind) in [
                (&slant, DepthKind::Planar),
                (&slant, DepthKind::Radial),
                (&step, DepthKind::Planar),
            ] {
                let mut scene = base.clone();
                scene.background.depth = Some(file.clone());
                scene.background.depth_kind = kind;
                let truth = truth(&scene, &sky, 64, None);
                let drawn = draw(device, &scene, &sky, preset);
                let (error, ignored) = (flip(&truth, &drawn), flip(&truth, &without));
                println!(
                    "{preset}, {}, {kind:?}: {error:.4}, without depth {ignored:.4}, free {usual:.4}",
                    file.display()
                );
                assert!(error < 1.1 * usual + 0.002, "{preset}, {kind:?}: {error}, not {usual}");
                assert!(ignored > 4.0 * error, "{preset}, {kind:?}: the depth does not show");
            }
        }
    });
}

/// A white drop that comes out of a black wall: where it does, pixels have the part of it that is before the wall.
#[test]
fn a_surface_cuts_a_drop_as_softly_as_its_outline() {
    let white = Environment::constant(Vec3::ONE);
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, -4.0), 2.0)];
    scene.background.color = Some(file("black.exr"));
    scene.background.depth = Some(depth_file("wall.exr", |_, _| 2.5));
    let black =
        Picture { width: EDGE, height: EDGE, pixels: vec![Vec3::ZERO; (EDGE * EDGE) as usize] };
    black.write_exr(&file("black.exr")).expect("a file");
    let truth = truth(&scene, &white, 64, None);
    let partly = |picture: &Picture| {
        picture.pixels.iter().filter(|pixel| (0.1..0.9).contains(&pixel.x)).count()
    };
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let drawn = draw(device, &scene, &white, preset);
            let apart = truth.pixels.iter().zip(&drawn.pixels).map(|(a, b)| (a.x - b.x).abs());
            let (most, sum) = apart.fold((0.0, 0.0), |(most, sum), by| (by.max(most), sum + by));
            let (in_truth, in_drawn) = (partly(&truth), partly(&drawn));
            println!(
                "{preset}: {most} apart, {sum} in all; {in_drawn} pixels partly, not {in_truth}"
            );
            assert!(in_drawn > in_truth / 2, "{preset}: {in_drawn} pixels in part, not {in_truth}");
            assert!(most < 0.4, "{preset}: {most} apart");
        }
    });
}

/// Rays at the edge of a wide picture: along the axis and along the ray are two depths, and a drop that is between them
/// is hidden by one alone.
#[test]
fn depth_is_along_the_axis_or_along_the_ray() {
    let white = Environment::constant(Vec3::ONE);
    // At 45 degrees; the front is met at depth 3.5 to 4, along the ray from 5 on.
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene.camera.vertical_fov = 110.0;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(4.0, 0.0, -4.0), 0.4)];
    scene.background.color = Some(color_file("kinds.exr"));
    let shows =
        |picture: &Picture| picture.pixels.iter().filter(|pixel| **pixel == Vec3::ONE).count();
    on_device(|device| {
        for (kind, depth, is_seen) in [
            (DepthKind::Planar, 4.5, true),
            (DepthKind::Radial, 4.5, false),
            (DepthKind::Planar, 3.3, false),
            (DepthKind::Radial, 6.2, true),
        ] {
            scene.background.depth = Some(depth_file("kind.exr", |_, _| depth));
            scene.background.depth_kind = kind;
            let drawn = draw(device, &scene, &white, Preset::Fast);
            assert_eq!(shows(&drawn) > 10, is_seen, "{kind:?} {depth}");
        }
    });
}

/// Where no drop is, the picture is the plate, but for float16; its parts are the whole to the byte.
#[test]
fn colour_is_behind_the_drops_in_every_part() {
    let sky = waves();
    let mut scene = drops(60);
    scene.background.color = Some(color_file("color.exr"));
    scene.background.depth = Some(depth_file("part.exr", |x, _| 3.0 + x as f32 / 12.0));
    scene.model.take_preset(Preset::Fast);
    let plate =
        Picture::read(scene.background.color.as_deref().expect("named")).expect("a picture");
    let plan = plan(&scene, &sky, Output::Radiance).expect("a plan");
    on_device(|device| {
        let mut empty = Scene { drops: Vec::new(), ..scene.clone() };
        let behind = draw(device, &empty, &sky, Preset::Fast);
        empty.background.depth = None;
        assert!(
            draw(device, &empty, &sky, Preset::Fast) == behind,
            "colour without a depth is another"
        );
        for (drawn, plate) in behind.pixels.iter().zip(&plate.pixels) {
            assert!(
                (*drawn - *plate).abs().cmple(plate.abs() / 2048.0).all(),
                "{drawn}, not {plate}"
            );
        }
        let whole = draw(device, &scene, &sky, Preset::Fast);
        let close = flip(&truth(&scene, &sky, 64, None), &whole);
        println!("over the plate: {close:.4}");
        assert!(close < 0.02, "{close}");
        let mut parts = Parts::new(device, &sky, &plan);
        let mut together = empty_picture(scene.image);
        parts
            .draw_all(&scene, Grid { columns: 3, rows: 2 }, &mut |origin, renderer, _| {
                let part = renderer.read_radiance()?;
                place(&mut together.pixels, EDGE, origin, &part.pixels, part.width);
                Ok(())
            })
            .expect("parts");
        assert!(together == whole, "the parts are not the whole");
    });
}

/// A plate in memory is the plate of its files, also in parts, and stands in place of what the scene names.
#[test]
fn a_plate_in_memory_is_that_of_its_files() {
    let sky = waves();
    let mut scene = drops(60);
    scene.background.color = Some(color_file("memory.exr"));
    scene.background.depth = Some(depth_file("memory-depth.exr", |x, _| 3.0 + x as f32 / 12.0));
    scene.background.depth_kind = DepthKind::Radial;
    scene.model.take_preset(Preset::Fast);
    let color = Picture::read(scene.background.color.as_deref().expect("named")).expect("read");
    let depth: Vec<f64> =
        (0..EDGE * EDGE).map(|at| f64::from(3.0 + (at % EDGE) as f32 / 12.0)).collect();
    let size = (EDGE, EDGE);
    let plate = Plate::from_pixels(size, Some(color), Some(depth), &scene.background);
    let plate = plate.expect("a plate");
    let of_files = Plate::of(&scene).expect("a plate");
    assert!(plate.color() == of_files.color() && plate.depth() == of_files.depth());
    let plan = plan(&scene, &sky, Output::Radiance).expect("a plan");
    on_device(|device| {
        let (of_files, _) = Parts::new(device, &sky, &plan).radiance(&scene).expect("drawn");
        let mut bare = scene.clone();
        bare.background = Default::default();
        let mut parts = Parts::new(device, &sky, &plan).before(&plate);
        let (whole, _) = parts.radiance(&bare).expect("drawn");
        assert!(whole == of_files, "a plate in memory is another");
        let (together, _) = parts.radiance_by(&bare, Grid { columns: 2, rows: 2 }).expect("drawn");
        assert!(together == of_files, "its parts are others");
        let (nothing, _) = Parts::new(device, &sky, &plan).radiance(&bare).expect("drawn");
        assert!(nothing != of_files, "the plate is not seen");
    });
}

/// What is wrong with pixels in memory is said by the rules for files.
#[test]
fn pixels_in_memory_are_checked() {
    let background = Background { depth_invalid: Some(0.0), ..Background::default() };
    let of = |color: Vec<Vec3>, depth: Vec<f64>| {
        let color = Picture { width: 2, height: 1, pixels: color };
        Plate::from_pixels((2, 1), Some(color), Some(depth), &background)
    };
    let said =
        |color: Vec<Vec3>, depth: Vec<f64>| of(color, depth).expect_err("refused").to_string();
    let white = vec![Vec3::ONE; 2];
    assert!(said(vec![Vec3::ONE], vec![1.0; 2]).contains("colour: is not 2 x 1 pixels"));
    assert!(said(white.clone(), vec![1.0]).contains("depth: is not 2 x 1 pixels"));
    assert!(said(vec![Vec3::NAN; 2], vec![1.0; 2]).contains("is full of NaN"));
    assert!(said(white.clone(), vec![1.0, f64::NAN]).contains("column 1, row 0 is NaN"));
    assert!(said(white, vec![1.0, -2.0]).contains("column 1, row 0 is -2"));
    let plate = of(vec![Vec3::NAN, Vec3::ONE], vec![0.0, 3.0]).expect("mended");
    assert_eq!(plate.color().expect("a colour").pixels, [Vec3::ONE; 2]);
    assert_eq!(plate.depth().expect("a depth").values, [3.0; 2]);
    assert_eq!(plate.remarks().len(), 2);
}

/// Real rain before a wall: its drops and its medium end there.
#[test]
fn real_rain_ends_at_the_plate() {
    let grey = Environment::constant(Vec3::splat(0.2));
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene.camera.vertical_fov = 40.0;
    let real = RealRain { rate: 100.0, extent: 400.0, ..RealRain::default() };
    scene.rain = Some(RainSettings::of(real));
    scene.background.color = Some(color_file("behind rain.exr"));
    let mean = |picture: &Picture| {
        let sum: Vec3 = picture.pixels.iter().sum();
        f64::from(sum.element_sum()) / f64::from(3 * EDGE * EDGE)
    };
    on_device(|device| {
        let mut dimmed = Vec::new();
        let plate =
            mean(&Picture::read(scene.background.color.as_deref().expect("named")).expect("read"));
        for depth in [40.0, 200.0] {
            scene.background.depth = Some(depth_file("wall.exr", |_, _| depth));
            let drawn = mean(&draw(device, &scene, &grey, Preset::Fast));
            // Drops take light from the grey around them.
            let law = scene.real_rain().expect("rain").law();
            let through = |depth: f64| (-law.extinction() * depth).exp();
            let expected = 0.2 + (plate - 0.2) * through(f64::from(depth));
            println!("{depth} m: {drawn:.4}, expected about {expected:.4}");
            assert!(
                (drawn - expected).abs() < 0.2 * (plate - expected),
                "{depth}: {drawn}, {expected}"
            );
            dimmed.push(plate - drawn);
        }
        assert!(dimmed[1] > 3.0 * dimmed[0], "the rain goes on behind the wall: {dimmed:?}");
    });
}

/// The sky, which is kept from frame to frame, holds the medium before it: that of so many metres, which are others in a scene of
/// other metres.
#[test]
fn the_medium_is_not_that_of_frames_before() {
    on_device(|device| {
        let sky = Environment::bundled().expect("the sky");
        let keys = ["rain.rate=50", "model.shape=sphere", "model.preset=fast"].map(String::from);
        let mut scene = Scene::load_edited(None, &keys).expect("a scene");
        (scene.image.width, scene.image.height) = (EDGE, EDGE);
        scene.background.color = Some(color_file("before-rain.exr"));
        scene.background.depth = Some(depth_file("far.exr", |_, _| 30.0));
        let larger = Scene { metres: 3.0, ..scene.clone() };
        let drawn = |renderer: &mut Renderer, scene: &Scene| {
            renderer.submit(scene).expect("a frame");
            renderer.read_radiance().expect("radiance")
        };
        let [fresh, other] =
            [&larger, &scene].map(|then| drawn(&mut renderer(device, &scene, &sky), then));
        let mut old = renderer(device, &scene, &sky);
        drawn(&mut old, &scene);
        assert!(drawn(&mut old, &larger) == fresh, "the medium of the frame before");
        let darkest = fresh.pixels.iter().zip(&other.pixels).map(|(far, near)| far.z / near.z);
        let darkest = darkest.fold(1.0, f32::min);
        println!("{darkest}");
        assert!(darkest < 0.95, "the control: through 90 metres of rain comes {darkest}");
    });
}
