//! The fast and the exact preset: the same on every run, every drop counted, near the truth.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::rel_mse;
use raindrops::rain::cull::count_visible;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::picture::{against, by_preset, truth};
use crate::common::{Random, on_device};

/// Samples a pixel of the truth that `exact` is held against.
const TRUTH_SAMPLES: u32 = 256;

/// Radiance of a few low waves, in colour, over two decades: no texel that rules all errors, so that
/// a truth of some samples is a truth.
fn waves() -> Environment {
    let (width, height) = (256u32, 128u32);
    let texels = (0..height).flat_map(|y| {
        (0..width).map(move |x| {
            let u = std::f32::consts::TAU * (x as f32 + 0.5) / width as f32;
            let v = std::f32::consts::PI * (y as f32 + 0.5) / height as f32;
            let wave = |k: f32, phase: f32| (k * u + phase).cos() * v.sin() + (k * v).cos();
            Vec3::new(wave(2.0, 0.3), wave(3.0, 1.1), wave(5.0, 2.2)).exp()
        })
    });
    Environment::from_texels("waves", width, height, texels.collect()).expect("a valid environment")
}

fn rain(count: u32, half_extent: f64, edge: u32) -> Scene {
    let mut scene = Scene::default();
    let half_extent = DVec3::splat(half_extent);
    scene.rain = Some(RainSettings { count, half_extent, ..RainSettings::default() });
    (scene.image.width, scene.image.height) = (edge, edge);
    scene
}

fn placed(drops: &[([f64; 3], f64)], edge: u32) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    let drop = |&(center, radius): &([f64; 3], f64)| PlacedDrop::sphere(center.into(), radius);
    scene.drops = drops.iter().map(drop).collect();
    (scene.image.width, scene.image.height) = (edge, edge);
    scene
}

#[test]
fn two_runs_give_the_same_bytes() {
    on_device(|device| {
        // Dense: lists of many drops, bands, big drops and rays all take part.
        let (scene, sky) = (rain(60_000, 120.0, 256), waves());
        for preset in [Preset::Fast, Preset::Exact] {
            let first = by_preset(device, &scene, &sky, preset).0;
            for _ in 0..3 {
                let again = by_preset(device, &scene, &sky, preset).0;
                assert!(again == first, "{preset}: another picture of the same scene");
            }
            let mut later = scene.clone();
            later.time = 1.0;
            let other = by_preset(device, &later, &sky, preset).0;
            assert!(other != first, "{preset}: the rain does not fall");
        }
        // Long lists on many cores: what a sort that is wrong on one driver shows first.
        let scene = rain(500_000, 1025.0, 1024);
        let first = by_preset(device, &scene, &sky, Preset::Fast).0;
        let again = by_preset(device, &scene, &sky, Preset::Fast).0;
        assert!(again == first, "500,000 drops: another picture of the same scene");
    });
}

#[test]
fn the_order_in_which_drops_come_does_not_show() {
    on_device(|device| {
        let sky = waves();
        // Drops before one another on few tiles, as many in each as no window holds; by twos and threes
        // larger ones. A drop that is moved and scaled from the eye covers the same pixels.
        const COUNT: usize = 240;
        let mut random = Random(11);
        let mut pixels = || 0.05 * (random.unit() - 0.5);
        let drops: Vec<([f64; 3], f64)> =
            (0..COUNT).map(|i| ([pixels(), pixels(), -1.0], [0.004, 0.004, 0.04][i % 3])).collect();
        let at = |place: usize, (center, radius): ([f64; 3], f64)| {
            let distance = 300.0 + place as f64;
            (center.map(|x| x * distance), radius * distance)
        };
        let picture = |drops: &[([f64; 3], f64)]| {
            let mut scene = placed(drops, 128);
            scene.camera.position = DVec3::ZERO;
            scene.camera.target = DVec3::NEG_Z;
            by_preset(device, &scene, &sky, Preset::Fast).0
        };
        let near_first: Vec<_> = (0..COUNT).map(|i| at(i, drops[i])).collect();
        let far_first: Vec<_> = near_first.iter().rev().copied().collect();
        let mixed: Vec<_> = (0..COUNT).map(|i| near_first[i * 89 % COUNT]).collect();
        let first = picture(&near_first);
        assert!(picture(&far_first) == first, "far drops first: another picture");
        assert!(picture(&mixed) == first, "drops in no order: another picture");
        let turned: Vec<_> = (0..COUNT).map(|i| at(COUNT - 1 - i, drops[i])).collect();
        assert!(picture(&turned) != first, "which drop is in front does not show");
    });
}

#[test]
fn every_drop_in_view_is_counted_and_none_is_lost() {
    on_device(|device| {
        let sky = Environment::constant(Vec3::ONE);
        let looking = |position: [f64; 3], target: [f64; 3], vertical_fov: f64| Camera {
            position: position.into(),
            target: target.into(),
            vertical_fov,
            ..Camera::default()
        };
        let cameras = [
            Camera::default(),
            looking([1e5, -3e4, 77.0], [1e5 + 1.0, -3e4 + 2.0, 76.0], 60.0),
            looking([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 150.0),
            looking([900.0, 10.0, -900.0], [0.0, 0.0, 0.0], 3.0),
        ];
        for (number, camera) in cameras.into_iter().enumerate() {
            let mut scene = rain(300_000, 1025.0, 128);
            scene.camera = camera;
            scene.time = [0.0, 3.2e7, -1e4, 0.5][number];
            scene.drops = vec![
                PlacedDrop::sphere(camera.position + 40.0 * camera.forward(), 2.0),
                PlacedDrop::sphere(camera.position - 40.0 * camera.forward(), 2.0),
            ];
            let (_, counts) = by_preset(device, &scene, &sky, Preset::Fast);
            assert_eq!(counts.visible, count_visible(&scene), "camera {number}");
            assert_eq!(counts.overflow, 0, "camera {number}");
        }
    });
}

#[test]
fn a_white_furnace_stays_white() {
    on_device(|device| {
        let white = Environment::constant(Vec3::ONE);
        let mut scene = rain(50_000, 150.0, 128);
        scene.drops = vec![PlacedDrop::sphere(DVec3::new(1.0, 0.5, -3.0), 1.0)];
        for preset in [Preset::Fast, Preset::Exact] {
            let (picture, _) = by_preset(device, &scene, &white, preset);
            let worst = picture
                .pixels
                .iter()
                .map(|pixel| (*pixel - Vec3::ONE).abs().max_element())
                .fold(0.0, f32::max);
            println!("{preset}: off white by {worst}");
            // A colour is a word of three 9-bit mantissas and the sum four halves.
            assert!(worst < 3e-3, "{preset}: off white by {worst}");
        }
    });
}

/// Scenes of one to fifty drops in which the outline, the order and the edges matter.
fn few() -> Vec<(&'static str, Scene)> {
    let mut up = placed(&[([0.3, 4.0, -0.2], 1.0), ([-3.0, 9.0, 2.0], 1.0)], 128);
    up.camera.target = DVec3::Y;
    let off_axis = placed(&[([6.0, 5.0, -7.0], 1.0), ([-9.0, -2.0, -9.5], 2.0)], 128);
    let at_edge = placed(&[([3.0, 0.0, -3.1], 0.8), ([0.0, -5.0, -5.0], 1.0)], 128);
    let behind_a_rim = placed(&[([0.0, 0.0, -3.0], 2.0), ([2.03, 0.0, -2.09], 0.2)], 128);
    vec![
        ("one in the middle", placed(&[([0.2, -0.1, -3.0], 1.0)], 128)),
        ("two off the axis", off_axis),
        ("two cut by the edge", at_edge),
        ("two straight up", up),
        ("fifty over one another", placed(&fifty(), 128)),
        // Its centre is nearer than that of the drop that covers it.
        ("one behind another's rim", behind_a_rim),
    ]
}

/// Fifty drops of half a pixel to 25 of radius, over one another and over the edge of the picture. No
/// two touch: they would be one.
fn fifty() -> Vec<([f64; 3], f64)> {
    let mut random = Random(50);
    let mut drops: Vec<(DVec3, f64)> = Vec::new();
    while drops.len() < 50 {
        let depth = 3.0 * 6f64.powf(random.unit());
        let [x, y] = [0, 1].map(|_| 1.1 * depth * (2.0 * random.unit() - 1.0));
        let (center, radius) = (DVec3::new(x, y, -depth), 0.15 * 10f64.powf(random.unit()));
        if drops.iter().all(|(other, size)| other.distance(center) > size + radius) {
            drops.push((center, radius));
        }
    }
    drops.iter().map(|(center, radius)| (center.to_array(), *radius)).collect()
}

#[test]
fn exact_agrees_with_the_truth() {
    on_device(|device| {
        let sky = waves();
        for (name, mut scene) in few() {
            let traced = |samples, seed| {
                let truth = Truth { samples, seed, ..Truth::default() };
                Tracer::new(&scene, &sky, truth).trace(&|_| ())
            };
            let truth = traced(TRUTH_SAMPLES, 0);
            // The sky is the easy part: only the pixels that hold a part of a drop count.
            let error = |picture: &Picture| rel_mse(&truth.picture, picture, Some(&truth.coverage));
            let noise = error(&traced(TRUTH_SAMPLES / 4, 1).picture);
            let mut found = |preset, samples| {
                scene.model.samples = samples;
                error(&by_preset(device, &scene, &sky, preset).0)
            };
            let [few, many] = [16, 64].map(|samples| found(Preset::Exact, Some(samples)));
            let square = found(Preset::Paper, None);
            println!(
                "{name}: relMSE {few:.2e} with 16 samples, {many:.2e} with 64; paper {square:.2e}; \
                 a truth of a quarter of the samples {noise:.1e}"
            );
            assert!(few < 3e-3 && many < 1e-3, "{name}: {few}, {many}");
            assert!(noise < 1e-4, "{name}: the truth is too noisy to tell: {noise}");
            // The control: what is not exact must not pass.
            assert!(square > 3e-3, "{name}: the bound means nothing: {square}");
        }
    });
}

/// From every side, before the camera and behind it: none of its bounds cuts off what is seen of it.
#[test]
fn a_drop_beside_the_camera_is_drawn() {
    on_device(|device| {
        let sky = waves();
        for center in [
            [1.3, 0.2, -0.6],
            [-1.1, 0.3, -0.1],
            [0.3, 1.2, -0.9],
            [0.9, -0.9, 0.2],
            [-0.2, 1.01, 0.0],
            [-1.5, -1.2, -0.97],
            [0.9, 0.8, 0.4],
            [0.5, 0.0, -1.0],
            // Beyond its radius by so little that float32 cannot tell its ellipse.
            [1.5, 0.2, -1.0000001],
            [1.4, 0.1, -1.00001],
            [-0.2, 1.5, -1.0001],
            [0.0, 1.2, -1.0099],
            [1.5, 0.0, -1.0101],
        ] {
            let scene = placed(&[(center, 1.0)], 128);
            let truth = truth(&scene, &sky, 24);
            let (picture, counts) = by_preset(device, &scene, &sky, Preset::Exact);
            let found = against(&truth, &picture).pixels;
            println!("{center:?}: relMSE {:.2e}, FLIP {:.4}", found.rel_mse, found.flip);
            assert_eq!((counts.overflow, counts.camera_inside), (0, 0));
            assert!(found.rel_mse < 1e-2, "{center:?}: {}", found.rel_mse);
            // The paper's billboard has no shape for it, and says so.
            let (_, counts) = by_preset(device, &scene, &sky, Preset::Paper);
            let beside = u64::from(center[2] >= -1.0);
            assert_eq!((counts.visible, counts.beside_camera), (1 - beside, beside), "{center:?}");
        }
    });
}

#[test]
fn fast_is_nearer_to_the_truth_than_paper() {
    on_device(|device| {
        let sky = waves();
        // Small drops, and drops of some pixels.
        for (count, half_extent) in [(60_000, 500.0), (3_000, 60.0)] {
            let scene = rain(count, half_extent, 192);
            let truth = truth(&scene, &sky, 256);
            let [paper, fast, exact] = [Preset::Paper, Preset::Fast, Preset::Exact].map(|preset| {
                let found = against(&truth, &by_preset(device, &scene, &sky, preset).0);
                println!(
                    "{count} drops, {preset}: relMSE {:.2e}, FLIP {:.4}; boxes {:.2e}, {:.4}",
                    found.pixels.rel_mse, found.pixels.flip, found.boxes.rel_mse, found.boxes.flip
                );
                found
            });
            for better in [&fast, &exact] {
                assert!(better.pixels.rel_mse < 0.25 * paper.pixels.rel_mse);
                assert!(better.pixels.flip < 0.75 * paper.pixels.flip);
                assert!(better.boxes.rel_mse < 0.25 * paper.boxes.rel_mse);
                assert!(better.boxes.flip < 0.75 * paper.boxes.flip);
            }
        }
    });
}
