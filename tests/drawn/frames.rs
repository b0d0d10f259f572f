//! From frame to frame nothing is carried over: a frame is that of a renderer which has drawn no other,
//! whether those before it are waited for or still in flight.

use std::process::Command;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, PointRules};
use raindrops::passes::counters::Counts;
use raindrops::picture::Picture;
use raindrops::plan::Output;
use raindrops::renderer::Renderer;
use raindrops::scene::model::{Preset, Simulation};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

use crate::common::picture::renderer_of;

/// Another camera, time or key for a frame.
type Change = fn(&mut Scene);

/// Each leaves some of what a frame depends on as it was.
const CHANGES: [(&str, Change); 7] = [
    ("as it was", |_| ()),
    ("turned", |scene| scene.camera.target = DVec3::new(0.7, 0.2, -1.0)),
    ("rolled", |scene| scene.camera.up = DVec3::new(0.5, 1.0, 0.0)),
    ("zoomed", |scene| scene.camera.vertical_fov = 40.0),
    ("a step on", |scene| {
        scene.camera.position += DVec3::new(3.0, 1.0, -2.0);
        scene.camera.target += DVec3::new(3.0, 1.0, -2.0);
    }),
    ("later", |scene| scene.time += 1.5),
    ("another key", |scene| scene.tone_map.key = 0.5),
];

fn rain() -> Scene {
    Scene {
        rain: Some(RainSettings {
            count: 5000,
            half_extent: DVec3::splat(100.0),
            ..RainSettings::default()
        }),
        // Its last tiles are not whole.
        image: ImageSize { width: 101, height: 67 },
        ..Scene::default()
    }
}

fn renderer(device: &Arc<Device>, scene: &Scene, sky: &Environment) -> Renderer {
    renderer_of(device, scene, sky, Output::Display)
}

/// All that a frame leaves: its counts, radiance and display colours.
fn frame(renderer: &mut Renderer, scene: &Scene) -> (Counts, Picture, Vec<u8>) {
    renderer.submit(scene).expect("a frame");
    let counts = renderer.finish().expect("a report").counts;
    (counts, renderer.read_radiance().expect("radiance"), renderer.read_display().expect("display"))
}

/// What a renderer has drawn before does not show: neither the sky that it keeps, nor lists, counters or
/// sums, nor, where frames are submitted without waiting, a frame that is still under way.
#[test]
fn a_frame_is_that_of_a_fresh_renderer() {
    crate::common::on_device(|device| {
        let sky = Environment::bundled().expect("the sky");
        // With few drops `fast` draws the tiles alone that have some, or had in the frame before.
        for (preset, drops) in [(Preset::Paper, 5000), (Preset::Fast, 5000), (Preset::Fast, 800)] {
            let mut base = rain();
            base.model.preset = preset;
            base.rain.as_mut().expect("rain").count = drops;
            base.model.mask_size = 64;
            let changed = |change: Change| {
                let mut scene = base.clone();
                change(&mut scene);
                scene
            };
            let fresh = CHANGES
                .map(|(_, change)| frame(&mut renderer(device, &base, &sky), &changed(change)));
            let is_drawn = |pixel: &Vec3| pixel.min_element() > 0.0;
            assert!(fresh[0].1.pixels.iter().all(is_drawn), "{preset}: the sky is dark nowhere");
            let mut old = renderer(device, &base, &sky);
            for ((name, change), expected) in CHANGES.iter().zip(&fresh) {
                assert!(frame(&mut old, &base) == fresh[0], "{preset}, before '{name}'");
                assert!(frame(&mut old, &changed(*change)) == *expected, "{preset}, '{name}'");
            }
            for in_flight in 1..CHANGES.len() {
                for (number, (name, change)) in CHANGES[..in_flight].iter().enumerate() {
                    let report = old.submit(&changed(*change)).expect("a frame");
                    // That of the frame before the last.
                    if let Some(before) = number.checked_sub(2) {
                        let counts = report.map(|report| report.counts);
                        assert_eq!(counts, Some(fresh[before].0), "{preset}, '{name}'");
                    }
                }
                let (name, change) = CHANGES[in_flight];
                assert!(
                    frame(&mut old, &changed(change)) == fresh[in_flight],
                    "{preset}: {in_flight} frames under way before '{name}' change it"
                );
            }
            // The control: each change shows.
            for (number, (name, _)) in CHANGES.iter().enumerate().skip(1) {
                assert!(fresh[number] != fresh[0], "{preset}, '{name}' does not show");
            }
        }
    });
}

/// A view finds the pictures of all far drops that it shows, those at its edges too, though it makes no others.
#[test]
fn a_narrow_view_is_that_of_one_who_has_looked_everywhere() {
    crate::common::on_device(|device| {
        let sky = Environment::bundled().expect("the sky");
        let mut wide = rain();
        wide.model.preset = Preset::Fast;
        wide.camera.vertical_fov = 120.0;
        let settings = wide.rain.as_mut().expect("rain");
        (settings.count, settings.half_extent) = (200_000, DVec3::splat(150.0));
        let looks = |scene: &Scene, target, fov| {
            let mut scene = scene.clone();
            (scene.camera.target, scene.camera.vertical_fov) = (target, fov);
            scene
        };
        let mut old = renderer(device, &wide, &sky);
        for axis in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z] {
            for up in [0.9, -0.9] {
                frame(&mut old, &looks(&wide, axis + up * DVec3::Y, 120.0));
            }
        }
        for (target, fov) in
            [(DVec3::new(0.3, 0.2, -1.0), 30.0), (DVec3::new(1.0, -0.4, 0.2), 50.0)]
        {
            let narrow = looks(&wide, target, fov);
            let fresh = frame(&mut renderer(device, &wide, &sky), &narrow);
            assert!(frame(&mut old, &narrow) == fresh, "a view of {fov}° to {target}");
        }
    });
}

/// Nor does it where drops are streaks, or real rain out of focus, in any of the lists that only these have.
#[test]
fn other_models_carry_nothing_over_either() {
    type Model = (&'static str, fn(&mut Scene));
    const MODELS: [Model; 2] = [
        ("streaks", |scene| {
            scene.camera.shutter = 0.2;
            let drop = PlacedDrop::sphere(DVec3::new(0.5, 0.2, -9.0), 1.0);
            scene.drops = vec![PlacedDrop { velocity: DVec3::new(2.0, 1.0, -1.0), ..drop }];
        }),
        ("real rain out of focus", |scene| {
            let rain = RealRain { rate: 100.0, extent: 40.0, ..RealRain::default() };
            scene.rain = Some(RainSettings::of(rain));
            (scene.camera.aperture, scene.camera.focus) = (0.02, 1.0);
        }),
    ];
    crate::common::on_device(|device| {
        let sky = Environment::bundled().expect("the sky");
        for (model, make) in MODELS {
            let mut base = rain();
            base.model.preset = Preset::Fast;
            make(&mut base);
            let scenes = [0, 1, 5].map(|number: usize| {
                let mut scene = base.clone();
                CHANGES[number].1(&mut scene);
                scene
            });
            let fresh =
                scenes.clone().map(|scene| frame(&mut renderer(device, &base, &sky), &scene));
            let mut old = renderer(device, &base, &sky);
            for number in [0, 1, 2, 0] {
                assert!(frame(&mut old, &scenes[number]) == fresh[number], "{model}, {number}");
            }
            // The control: each change shows.
            assert!(fresh.windows(2).all(|pair| pair[0] != pair[1]), "{model}");
        }
    });
}

/// Makes the layer check hazards between submissions, which it does not do unless told so.
const ACROSS_SUBMISSIONS: (&str, &str) =
    ("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT");

/// Frames alone, without a read-back between them: the layer does not understand that the CPU's wait
/// for a timeline semaphore makes memory free for another use, and would call that a hazard. (So it does for the
/// uploads of the tiles' clusters: their frames' commands are held together by `tests/recorded.rs`.)
#[test]
#[ignore = "run by `no_hazard_between_frames`, in an environment of its own"]
fn frames_without_waiting() {
    crate::common::on_device(|device| {
        // Whoever finds them out draws and waits.
        let rules = PointRules { limit_px: 64.0, draws_off_screen: true };
        device.point_rules.set(rules).expect("not yet probed");
        let mut scene = Scene {
            rain: Some(RainSettings { count: 1000, ..RainSettings::default() }),
            image: ImageSize { width: 64, height: 64 },
            ..Scene::default()
        };
        let white = Environment::constant(glam::Vec3::ONE);
        scene.model.preset = Preset::Paper;
        for simulation in [Simulation::Integer, Simulation::Stored] {
            scene.model.simulation = Some(simulation);
            let mut renderer = renderer(device, &scene, &white);
            for _ in 0..6 {
                scene.time += 0.1;
                scene.camera.target.x += 0.1;
                renderer.submit(&scene).expect("a frame");
            }
            renderer.finish().expect("a report");
        }
    });
}

#[test]
fn no_hazard_between_frames() {
    let (name, value) = ACROSS_SUBMISSIONS;
    let output = Command::new(std::env::current_exe().expect("this test"))
        .args(["--ignored", "--exact", "frames::frames_without_waiting"])
        .env(name, value)
        .output()
        .expect("this test starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("1 passed"), "it ran: {said}");
}
