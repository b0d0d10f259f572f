//! The simulation on the GPU against the CPU: places bit for bit, counts exactly, and what time
//! does to them.

use std::sync::Arc;

use crate::common::Random;
use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::passes::counters::Counts;
use raindrops::passes::drops::guard_band;
use raindrops::plan::{Output, plan};
use raindrops::rain::TICKS_PER_SECOND;
use raindrops::rain::cull::{Visibility, drops_with_visibility};
use raindrops::renderer::{RainField, Renderer};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Simulation;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

fn renderer(device: &Arc<Device>, scene: &Scene) -> Renderer {
    let environment = Environment::constant(glam::Vec3::ONE);
    Renderer::new(
        device,
        scene,
        &environment,
        &plan(&crate::common::by_paper(scene), &environment, Output::Display).expect("a plan"),
    )
    .expect("a renderer")
}

/// Rain of `count` drops seen in a tiny picture: the simulation is what is looked at.
fn small(count: u32) -> Scene {
    Scene {
        rain: Some(RainSettings { count, ..RainSettings::default() }),
        image: ImageSize { width: 16, height: 16 },
        ..Scene::default()
    }
}

/// Renders a frame and compares every drop record with the CPU's; returns how many were.
pub fn compare_records(renderer: &mut Renderer, scene: &Scene, point_limit_px: f64) -> u64 {
    renderer.submit(scene).expect("a frame");
    let records = renderer.read_drops().expect("records");
    assert_eq!(records.len(), scene.drop_count() as usize);
    for (index, (record, (center, radius, visibility))) in
        records.iter().zip(drops_with_visibility(scene)).enumerate()
    {
        let bits = [record[0], record[1], record[2]].map(f32::to_bits);
        assert_eq!(
            bits,
            center.to_array().map(f32::to_bits),
            "drop {index}, seed {}, {} s: {record:?} is not {center:?}",
            scene.seed,
            scene.time,
        );
        let drawn = visibility == Visibility::Visible
            && diameter_px(scene, center.as_dvec3(), radius.into()) <= point_limit_px;
        if !is_borderline(scene, center.as_dvec3(), radius.into(), point_limit_px) {
            assert_eq!(record[3], if drawn { radius } else { 0.0 }, "drop {index}");
        }
    }
    records.len() as u64
}

/// Diameter of a drop's square, in pixels.
fn diameter_px(scene: &Scene, center: DVec3, radius: f64) -> f64 {
    let r2 = radius * radius;
    let flat2 = center.z * center.z - r2;
    2.0 * scene.view().focal_px * radius * (center.length_squared() - r2).powf(0.25)
        / flat2.powf(0.75)
}

/// Whether float32 roots may decide otherwise than float64 about the point limit.
fn is_borderline(scene: &Scene, center: DVec3, radius: f64, point_limit_px: f64) -> bool {
    (diameter_px(scene, center, radius) / point_limit_px - 1.0).abs() < 1e-5
}

fn point_limit_px(device: &std::sync::Arc<Device>, scene: &Scene) -> f64 {
    guard_band(device, scene.image.width, scene.image.height).expect("a limit").1.into()
}

#[test]
fn places_are_the_cpus_bit_for_bit() {
    crate::common::on_device(|device| {
        let mut random = Random(2011);
        let mut compared = 0;
        let mut scene = small(65_536);
        let limit = point_limit_px(device, &scene);
        let mut rain = renderer(device, &scene);
        let white = Environment::constant(glam::Vec3::ONE);
        let plan = plan(&crate::common::by_paper(&scene), &white, Output::Display).expect("a plan");
        let powers = |exponent: i32| 2f64.powi(exponent);
        // The edges of every integer on the way: 2^31, 2^32, 2^63, 2^64 ticks and far beyond.
        let mut ticks = vec![0.0, 1.0, -1.0];
        for exponent in [31, 32, 62, 63, 64, 65, 100, 126] {
            for tick in [powers(exponent), powers(exponent) - powers(exponent - 52).max(1.0)] {
                ticks.extend([tick, -tick]);
            }
        }
        ticks.extend(
            (0..16).map(|_| (random.unit() - 0.5) * powers(2 + (random.bits() % 90) as i32)),
        );
        for tick in ticks {
            scene.seed = random.bits();
            scene.time = tick / TICKS_PER_SECOND;
            let drops = Arc::new(RainField::new(device, &scene));
            rain = Renderer::of(rain.lighting(), &drops, &scene, &plan).expect("a renderer");
            compared += compare_records(&mut rain, &scene, limit);
        }
        drop(rain);

        // Large indices, an odd box, odd velocities, a camera that is turned and far away.
        let mut scene = small(1_500_000);
        scene.seed = u64::MAX;
        scene.time = 12_345.678;
        scene.rain = scene.rain.map(|rain| RainSettings {
            half_extent: DVec3::new(3.7, 111.0, 5000.1),
            radius: 0.01,
            velocity: DVec3::new(-3.3, 1e5, 1e-7),
            ..rain
        });
        scene.camera = Camera {
            position: DVec3::new(1e7, -2e6, 3.3),
            target: DVec3::new(1e7 + 1.0, -2e6 - 2.0, 3.0),
            ..Camera::default()
        };
        compared += compare_records(&mut renderer(device, &scene), &scene, limit);
        println!("{compared} places equal bit for bit");
        assert!(compared >= 1_000_000);
    });
}

/// The control: the CPU with another seed, or a tick later, must not agree.
#[test]
fn places_of_another_seed_or_tick_differ() {
    let places =
        |scene: &Scene| -> Vec<_> { drops_with_visibility(scene).map(|(v, ..)| v).collect() };
    let scene = small(1000);
    let same =
        |other: &Scene| places(&scene).iter().zip(places(other)).filter(|(a, b)| **a == *b).count();
    assert_eq!(same(&scene), 1000);
    assert_eq!(same(&Scene { seed: 2, ..scene.clone() }), 0);
    // 0.1 ms: 0.9 thousandths of a radius, some steps of float32 at 1000 radii.
    assert_eq!(same(&Scene { time: 1e-4, ..scene.clone() }), 0);
}

/// What the CPU counts; `large` as a range, since roots may round differently.
fn cpu_counts(scene: &Scene, point_limit_px: f64) -> (Counts, std::ops::RangeInclusive<u64>) {
    let mut counts = Counts::default();
    let mut unsure = 0;
    for (center, radius, visibility) in drops_with_visibility(scene) {
        match visibility {
            Visibility::Visible => {
                counts.visible += 1;
                let (center, radius) = (center.as_dvec3(), f64::from(radius));
                if is_borderline(scene, center, radius, point_limit_px) {
                    unsure += 1;
                } else if diameter_px(scene, center, radius) > point_limit_px {
                    counts.large += 1;
                }
            }
            Visibility::CameraInside => counts.camera_inside += 1,
            Visibility::BesideCamera => counts.beside_camera += 1,
            Visibility::OutOfView => {}
        }
    }
    let large = counts.large..=counts.large + unsure;
    (counts, large)
}

fn check_counts(device: &Arc<Device>, name: &str, scene: &Scene) -> Counts {
    scene.validate(name).expect("a valid scene");
    let mut rain = renderer(device, scene);
    rain.submit(scene).expect("a frame");
    let found = rain.finish().expect("a report").counts;
    let (cpu, large) = cpu_counts(scene, point_limit_px(device, scene));
    println!("{name}: {found:?}");
    assert!(large.contains(&found.large), "{name}: {} large, not {large:?}", found.large);
    assert_eq!(Counts { large: cpu.large, ..found }, cpu, "{name}");
    found
}

#[test]
fn counts_are_the_cpus() {
    const YEAR: f64 = 365.25 * 86_400.0;
    crate::common::on_device(|device| {
        let image = ImageSize { width: 64, height: 64 };
        let million = Scene { image, ..Scene::default() };
        let found = check_counts(device, "the benchmark", &million);
        assert!(found.visible > 160_000, "a sixth of the box is in view: {found:?}");

        let base = Scene { rain: small(200_000).rain, ..million.clone() };
        for (name, time) in [("a year on", YEAR), ("a year ago", -YEAR)] {
            check_counts(device, name, &Scene { time, ..base.clone() });
        }
        for vertical_fov in [1.0, 30.0, 120.0, 170.0] {
            let camera = Camera { vertical_fov, ..Camera::default() };
            let image = ImageSize { width: 96, height: 32 };
            check_counts(
                device,
                &format!("{vertical_fov}°"),
                &Scene { camera, image, ..base.clone() },
            );
        }
        let turned = Camera {
            position: DVec3::new(1.0e6 / 3.0, -777.7, 5.0e8),
            target: DVec3::new(1.0e6 / 3.0 + 3.0, -776.6, 5.0e8 + 1.0),
            up: DVec3::new(0.3, 1.0, -0.2),
            ..Camera::default()
        };
        check_counts(device, "turned, far away", &Scene { camera: turned, ..base.clone() });

        // A downpour of large drops: inside, beside, larger than a point, near plane.
        let dense = Scene {
            rain: Some(RainSettings {
                count: 100_000,
                half_extent: DVec3::splat(20.0),
                ..RainSettings::default()
            }),
            // Few pixels, so that they cost little, but points over every limit.
            image: ImageSize { width: 8, height: 8 },
            camera: Camera { vertical_fov: 1.0, near: 0.5, ..Camera::default() },
            ..Scene::default()
        };
        let found = check_counts(device, "dense", &dense);
        assert!(found.camera_inside > 0 && found.large > 0, "{found:?}");
        let wide = Camera { vertical_fov: 170.0, near: 0.5, ..Camera::default() };
        let found = check_counts(device, "dense, wide", &Scene { camera: wide, ..dense.clone() });
        assert!(found.beside_camera > 3, "{found:?}");

        // Placed drops far from the origin, where float32 alone would lose them.
        let place = DVec3::new(1e7, 2e7, -3e7);
        let mut random = Random(5);
        let drops = (0..1000).map(|_| {
            let center = place + 20.0 * random.unit() * random.direction();
            PlacedDrop::sphere(center, 0.01 + 2.0 * random.unit())
        });
        let camera = Camera { position: place, target: place + DVec3::new(1.0, 1.0, 0.3), ..wide };
        let placed =
            Scene { rain: None, drops: drops.collect(), camera, image, ..Scene::default() };
        let found = check_counts(device, "placed", &placed);
        assert!(found.visible > 100 && found.camera_inside > 0 && found.beside_camera > 0);
        let both = Scene { rain: base.rain, ..placed };
        check_counts(device, "rain and placed", &both);
    });
}

/// Largest distance of the stored positions in view space from the exact ones, the short way around
/// the box.
fn drift(renderer: &Renderer, scene: &Scene) -> f64 {
    let box_edge = 2.0 * scene.rain.expect("rain").half_extent;
    let records = renderer.read_drops().expect("records");
    let mut most = 0f64;
    for (record, (exact, ..)) in records.iter().zip(drops_with_visibility(scene)) {
        let off =
            DVec3::new(record[0].into(), record[1].into(), record[2].into()) - exact.as_dvec3();
        most = most.max((off - (off / box_edge).round() * box_edge).length());
    }
    most
}

#[test]
fn stored_positions_move_and_drift() {
    crate::common::on_device(|device| {
        let mut scene = small(256);
        scene.image = ImageSize { width: 1, height: 1 };
        scene.model.simulation = Some(Simulation::Stored);
        let mut rain = renderer(device, &scene);
        // float32 at 1025 radii has a step of 6.1e-5 to 1.2e-4.
        rain.submit(&scene).expect("a frame");
        let first = drift(&rain, &scene);
        assert!(first < 5e-4, "{first} radii apart at the first frame");

        // Large steps, forwards, over the box's edge, and back again. (Not too large: the integers'
        // velocity is rounded to a part in 3e7, which is another rain after 10⁶ s, not drift.)
        for time in [1.0, 100.0, 1e4, -1e4, 0.0] {
            scene.time = time;
            rain.submit(&scene).expect("a frame");
            let off = drift(&rain, &scene);
            assert!(off < 3e-3, "{off} radii apart at {time} s");
        }
        let standing: Vec<_> = rain.read_drops().expect("records");
        rain.submit(&scene).expect("a frame");
        assert_eq!(standing, rain.read_drops().expect("records"), "time stands still");

        // Slow motion: 2,000 steps of 10 µs, 9e-5 radii each, about one step of float32.
        for step in 1..=2_000 {
            scene.time = 1e-5 * f64::from(step);
            rain.submit(&scene).expect("a frame");
        }
        let off = drift(&rain, &scene);
        println!(
            "stored positions: {first:.1e} radii off at first, {off:.3} after 2,000 steps of 10 µs, \
             in which the rain fell 0.18"
        );
        assert!(off > 0.002, "it is said to drift, but is {off} radii off");
        // Each step rounds by half a unit in the last place, 6.1e-5, at most.
        assert!(off < 0.2, "{off} radii is more than rounding explains");
    });
}

#[test]
fn integer_positions_do_not_drift() {
    crate::common::on_device(|device| {
        let mut scene = small(256);
        scene.image = ImageSize { width: 1, height: 1 };
        let limit = point_limit_px(device, &scene);
        let mut rain = renderer(device, &scene);
        for step in 1..=1_000 {
            scene.time = 1e-5 * f64::from(step);
            rain.submit(&scene).expect("a frame");
        }
        compare_records(&mut rain, &scene, limit);
    });
}

#[test]
fn a_moment_always_looks_the_same() {
    crate::common::on_device(|device| {
        let mut scene = Scene { rain: small(100_000).rain, ..Scene::default() };
        scene.image = ImageSize { width: 256, height: 256 };
        scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.3, 0.2, -1.5), 1.0); 2];
        // Not the furnace of the other tests, in which every moment looks the same.
        let sky = Environment::bundled().expect("the sky");
        let mut rain = Renderer::new(
            device,
            &scene,
            &sky,
            &plan(&crate::common::by_paper(&scene), &sky, Output::Display).expect("a plan"),
        )
        .expect("a renderer");
        let mut picture = |time: f64| {
            scene.time = time;
            rain.submit(&scene).expect("a frame");
            let display = rain.read_display().expect("display");
            (display, rain.read_radiance().expect("radiance"))
        };
        let start = picture(7.25);
        assert!(start == picture(7.25), "time stands still");
        let later = picture(1e9 + 0.1);
        assert!(start != later, "the control: another moment looks different");
        picture(-1e12);
        assert!(start == picture(7.25), "after a rewind");
    });
}

#[test]
fn chunks_change_nothing() {
    let mut scene = small(10_000);
    scene.image = ImageSize { width: 64, height: 64 };
    let mut random = Random(9);
    scene.drops = (0..3000)
        .map(|_| PlacedDrop::sphere(40.0 * random.direction() * random.unit(), 0.3))
        .collect();
    for simulation in [Simulation::Integer, Simulation::Stored] {
        scene.model.simulation = Some(simulation);
        let frames = |device: &Arc<Device>| {
            let mut rain = renderer(device, &scene);
            let mut scene = scene.clone();
            [0.0, 1.5].map(|time| {
                scene.time = time;
                rain.submit(&scene).expect("a frame");
                (
                    rain.finish().expect("a report").counts,
                    rain.read_drops().expect("records"),
                    rain.read_display().expect("display"),
                )
            })
        };
        let (mut whole, mut chunked) = (None, None);
        crate::common::on_device(|device| whole = Some(frames(device)));
        // 3 workgroups a chunk: 17 chunks, the last of a part, one of both kinds of drops.
        let three_groups = |report: &mut raindrops::gpu::DeviceReport| {
            report.limits.max_compute_work_group_count[0] = 3;
        };
        crate::common::on_adjusted_device(three_groups, |device| chunked = Some(frames(device)));
        assert!(whole == chunked, "{simulation}: chunks change the picture");
    }
}
