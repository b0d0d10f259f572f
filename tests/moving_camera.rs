//! A camera that moves while the shutter is open: its picture is that of a camera at rest with every velocity, wind
//! included, less the camera's.

mod common;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::film::{CameraKey, PaceKey};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use common::picture::{light_rain, moving, square};
use common::{on_device, waves};

const VELOCITY: DVec3 = DVec3::new(3.0, 0.7, -13.9);

fn by_camera(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera.velocity = Some(VELOCITY);
    scene
}

/// The same seen from a camera at rest in the air that comes towards it: at the scene's time it is where the moving one is,
/// from where the air was at time 0.
fn by_air(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera = scene.camera.moved_by(-VELOCITY * scene.time);
    scene.drops.iter_mut().for_each(|drop| drop.velocity -= VELOCITY);
    if let Some(rain) = &mut scene.rain {
        rain.velocity -= VELOCITY;
        rain.real.iter_mut().for_each(|rain| rain.wind -= VELOCITY * scene.metres);
    }
    scene
}

fn exposed(preset: Preset) -> Scene {
    let mut scene = square(48);
    scene.model.take_preset(preset);
    scene.camera.shutter = 1.0 / 60.0;
    scene.camera.position = DVec3::new(0.3, 1.7, 0.1);
    scene.camera.target = DVec3::new(0.9, 1.5, -5.0);
    scene.camera.vertical_fov = 50.0;
    scene
}

/// Small, large and flat ones, at rest and in motion.
fn placed(preset: Preset) -> Scene {
    let mut scene = exposed(preset);
    let at = |number: u32, step: f64| (f64::from(number) * step).fract() - 0.5;
    scene.drops = (1..60)
        .map(|number| PlacedDrop {
            axis_ratio: (number % 3 == 0).then_some(0.8),
            ..moving(
                [
                    6.0 * at(number, 0.618),
                    1.7 + 5.0 * at(number, 0.414),
                    -3.0 - f64::from(number % 7),
                ],
                [at(number, 0.3), -9.0 * f64::from(number % 2), at(number, 0.7)],
                0.004 * f64::from(1 + number % 40),
            )
        })
        .collect();
    scene
}

fn weather(preset: Preset) -> Scene {
    let mut scene = exposed(preset);
    (scene.time, scene.metres) = (2.5, 0.5);
    let wind = DVec3::new(3.0, 0.0, 1.0);
    let rain = RealRain { rate: 60.0, extent: 6.0, wind, ..RealRain::default() };
    scene.rain = Some(RainSettings::of(rain));
    scene
}

fn boxed(preset: Preset) -> Scene {
    let time = 2.5;
    Scene { time, rain: Some(light_rain()), ..exposed(preset) }
}

fn drawn(device: &Arc<Device>, scene: &Scene) -> (Layers, Picture) {
    let sky = waves();
    let of = |output| {
        let plan = plan(scene, &sky, output).expect("a plan");
        let mut renderer = Renderer::new(device, scene, &sky, &plan).expect("a renderer");
        let camera = scene.camera.moved_by(scene.camera_motion());
        let until = Scene { time: scene.time + scene.exposed(), camera, ..scene.clone() };
        renderer.draw_until(scene, &until).expect("a frame");
        renderer
    };
    let layers = of(Output::Layers).read_layers().expect("layers");
    (layers, of(Output::Radiance).read_radiance().expect("a picture"))
}

fn traced(scene: &Scene, samples: u32) -> Picture {
    Tracer::new(scene, &waves(), Truth { samples, ..Truth::default() }).picture()
}

/// Root of the mean squared difference, over the mean.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).length_squared());
    let mean: Vec3 = a.pixels.iter().sum();
    (squares.sum::<f32>() / a.pixels.len() as f32).sqrt() * a.pixels.len() as f32 / mean.length()
}

#[test]
fn placed_drops_at_time_0_are_the_same_to_the_byte() {
    let scene = placed(Preset::Fast);
    assert_eq!(traced(&by_camera(&scene), 1), traced(&by_air(&scene), 1));
    assert_ne!(traced(&scene, 1), traced(&by_air(&scene), 1));
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let scene = placed(preset);
            let (by_camera, by_air) =
                (drawn(device, &by_camera(&scene)), drawn(device, &by_air(&scene)));
            assert!(by_camera == by_air, "{preset}");
            assert!(by_camera.0.id.iter().any(|id| *id != 0), "{preset}: no drops");
            assert!(drawn(device, &scene) != by_air, "{preset}: the camera's motion does nothing");
        }
    });
}

#[test]
fn rain_is_the_same_but_for_rounding() {
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            for (name, scene) in [("real", weather(preset)), ("in a box", boxed(preset))] {
                let (a, b) = (drawn(device, &by_camera(&scene)), drawn(device, &by_air(&scene)));
                let at_rest = drawn(device, &scene);
                let same = a.0.id.iter().zip(&b.0.id).filter(|(a, b)| a == b).count();
                let moved = a.0.motion.iter().zip(&b.0.motion).filter(|(a, b)| {
                    [0, 1].iter().any(|&i| (a[i].to_f32() - b[i].to_f32()).abs() > 0.02)
                });
                let (far, control) = (apart(&a.1, &b.1), apart(&at_rest.1, &b.1));
                let moved = moved.count();
                println!(
                    "{preset} {name}: {far:.5}, at rest {control:.5}; {same} the same, {moved} off"
                );
                assert!(far < 0.05 * control, "{preset} {name}: {far}, {control}");
                let all = a.0.id.len();
                assert!(
                    same > all * 98 / 100 && moved < all / 50,
                    "{preset} {name}: {same} {moved}"
                );
            }
        }
    });
    for (name, scene) in [("real", weather(Preset::Fast)), ("in a box", boxed(Preset::Fast))] {
        let of = |scene: &Scene| {
            let mut small = scene.clone();
            (small.image.width, small.image.height) = (16, 16);
            traced(&small, 4)
        };
        let b = of(&by_air(&scene));
        let (far, control) = (apart(&of(&by_camera(&scene)), &b), apart(&of(&scene), &b));
        println!("reference, {name}: {far:.6}, at rest {control:.5}");
        assert!(far < 0.02 * control, "reference, {name}: {far}, {control}");
    }
}

/// Cars are filmed so: the streaks spread from where it drives to, as the motion in its layers.
fn drive() -> Scene {
    let mut scene = Scene { seed: 3, ..Scene::default() };
    (scene.image.width, scene.image.height) = (160, 120);
    (scene.camera.vertical_fov, scene.camera.near) = (40.0, 1.0);
    scene.camera.shutter = 0.01;
    scene.rain =
        Some(RainSettings::of(RealRain { rate: 50.0, extent: 8.0, ..RealRain::default() }));
    scene.film.fps = 10.0;
    let key = |at: f64, z: f64| CameraKey {
        at,
        position: DVec3::new(0.0, 1.7, z),
        target: DVec3::new(0.0, 1.7, z - 100.0),
        vertical_fov: None,
    };
    scene.film.camera = vec![key(0.0, 0.0), key(10.0, -139.0)];
    scene
}

#[test]
fn streaks_spread_from_where_a_car_drives_to() {
    let scene = drive();
    // A path of two keys goes as 3 t^2 - 2 t^3, whose slope at a fifth is 24/25.
    let frame = scene.film.frame(&scene, 20);
    let way = -0.96 * 13.9 * 0.01;
    let moves = frame.camera_motion();
    assert!((moves - DVec3::Z * way).length() < 1e-12, "{moves}");
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let mut frame = frame.clone();
            frame.model.take_preset(preset);
            let (layers, _) = drawn(device, &frame);
            let mut sides = [(0.0, 0); 2];
            for (at, id) in layers.id.iter().enumerate().filter(|(_, id)| **id != 0) {
                let (column, depth) = (at % 160, f64::from(layers.depth[at]));
                let x = column as f64 + 0.5 - 80.0;
                // From the middle of the exposure on for as long as it lasts; the pixel is on the streak, not in its middle.
                let right = -x * way / (depth + way);
                let found = f64::from(layers.motion[at][0].to_f32());
                let apart = (found - right).abs();
                assert!(apart < 0.6 + 0.5 * right.abs(), "{preset} {id}: {found}, not {right}");
                if !(8..152).contains(&column) {
                    let side = &mut sides[usize::from(x > 0.0)];
                    *side = (side.0 + found, side.1 + 1);
                }
            }
            let [left, right] = sides.map(|(sum, count)| sum / f64::from(count));
            println!("{preset}: {left:.2} px at the left edge, {right:.2} at the right one");
            assert!((-6.0..=-2.0).contains(&left) && (2.0..=6.0).contains(&right));
        }
    });
}

/// While the pace is 0 the drops stand, and the camera goes on.
#[test]
fn a_camera_moves_through_drops_that_stand() {
    let mut scene = placed(Preset::Fast);
    scene.film.pace = vec![PaceKey { at: 0.0, rate: 0.0 }];
    let frame = scene.film.frame(&by_camera(&scene), 5);
    let mut stopped = by_camera(&scene);
    stopped.film = Default::default();
    stopped.drops.iter_mut().for_each(|drop| drop.velocity = DVec3::ZERO);
    assert_eq!(traced(&frame, 1), traced(&stopped, 1));
    on_device(|device| {
        // The same models: those of a film, whose drops may stand.
        stopped.film = scene.film.clone();
        assert!(drawn(device, &frame) == drawn(device, &stopped));
    });
}
