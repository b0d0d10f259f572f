//! Exposures drawn by the GPU: light, coverage and order of drops that move while the shutter is open, against closed
//! forms and the reference.

use glam::{DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::metrics::compare;
use raindrops::picture::tone_map::{display, exposure_of};
use raindrops::picture::{Picture, srgb_of_linear};
use raindrops::rain::cull::count_visible;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::model::{Motion, Preset};
use raindrops::scene::{PlacedDrop, RainSettings, Scene, ToneMap};

use crate::common::picture::{black, draw, light_rain, moving, renderer, square, sum, truth};
use crate::common::{on_device, painted, waves};

/// A white drop before black, of some pixels of radius, that moves by up to 300 pixels.
#[test]
fn a_streak_has_the_light_of_the_drop_at_rest() {
    const EDGE: u32 = 384;
    let white = Environment::constant(Vec3::ONE);
    let plate = black("streaks", EDGE);
    on_device(|device| {
        let mut worst = 0.0_f64;
        for preset in [Preset::Fast, Preset::Exact] {
            for radius in [
                0.05, 0.3, 0.9, 1.3, 1.4, 1.52, 1.6, 1.7, 1.85, 2.0, 2.3, 2.7, 3.0, 4.5, 8.0, 14.0,
                30.0,
            ] {
                // Exact draws an entry a tile: fewer.
                if preset == Preset::Exact && ![0.3, 1.6, 14.0].contains(&radius) {
                    continue;
                }
                let mut scene = square(EDGE);
                scene.model.preset = preset;
                scene.background.color = Some(plate.clone());
                scene.camera.vertical_fov = 10.0;
                scene.camera.shutter = 1.0;
                let pixel = 1.0 / scene.view().focal_px;
                let turn = 0.7_f64 + radius;
                let direction = DVec3::new(turn.sin(), turn.cos(), 0.0);
                scene.drops = vec![PlacedDrop {
                    velocity: direction * pixel,
                    ..PlacedDrop::sphere(DVec3::new(3.3 * pixel, 1.8 * pixel, -1.0), radius * pixel)
                }];
                let mut renderer = renderer(device, &scene, &white);
                let mut of_way = |way: f64| {
                    let mut frame = scene.clone();
                    frame.camera.shutter = way;
                    frame.time = -0.5 * way;
                    sum(&draw(&mut renderer, &frame).0)
                };
                // A splat's sides are told in 1/512 pixel: of the smallest that is some of their light. Of some pixels of
                // radius the edge at rest is a ramp, whose light depends on where the pixels' middles fall.
                let disc = std::f64::consts::PI * radius * radius;
                let at_rest = of_way(0.0) / disc;
                let bound = if radius < 0.2 || (1.5..3.0).contains(&radius) { 0.04 } else { 0.01 };
                assert!((at_rest - 1.0).abs() < bound, "radius {radius} at rest: {at_rest}");
                for way in [
                    0.02, 0.1, 0.4, 0.9, 1.1, 1.4, 1.7, 2.1, 2.5, 2.9, 3.4, 3.9, 4.1, 5.0, 6.0,
                    7.0, 9.0, 13.0, 18.0, 30.0, 80.0, 300.0,
                ] {
                    if radius < 0.2 && way < 1.0 {
                        continue;
                    }
                    let ratio = of_way(way) / disc;
                    if (ratio - 1.0).abs() > worst {
                        worst = (ratio - 1.0).abs();
                        println!("{preset}: radius {radius}, way {way}: {ratio}");
                    }
                    assert!(
                        (ratio - 1.0).abs() < 0.008,
                        "{preset}: radius {radius}, way {way}: {ratio} of the light"
                    );
                }
            }
        }
        println!("off by {worst:.5} at most");
    });
}

/// A white drop before black, three radii from the camera, that moves by half of its breadth: its outline is another ellipse
/// at every moment. The mean over moments of where rays hit it is the truth.
#[test]
fn a_near_drop_covers_what_it_moves_over() {
    const EDGE: u32 = 64;
    const SAMPLES: u32 = 256;
    let white = Environment::constant(Vec3::ONE);
    let mut scene = square(EDGE);
    scene.background.color = Some(black("near-drop", EDGE));
    scene.camera.vertical_fov = 60.0;
    scene.camera.shutter = 1.0;
    scene.time = -0.5;
    let (center, radius) = (DVec3::new(0.1, -0.4, -3.0), 0.9);
    let focal = scene.view().focal_px;
    on_device(|device| {
        for velocity in [DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.7, 0.6, 0.0)] {
            for preset in [Preset::Fast, Preset::Exact] {
                scene.model.preset = preset;
                scene.drops = vec![PlacedDrop { velocity, ..PlacedDrop::sphere(center, radius) }];
                let (picture, _) = draw(&mut renderer(device, &scene, &white), &scene);
                let mut worst = 0.0_f64;
                for (block_x, block_y) in (0..64).map(|at| (8 * (at % 8), 8 * (at / 8))) {
                    let mut off = 0.0;
                    for (x, y) in (0..64).map(|at| (block_x + at % 8, block_y + at / 8)) {
                        // Places in the pixel and moments that fill both evenly.
                        let hits = |number: &u32| {
                            let number = f64::from(*number) + 0.5;
                            let place = DVec2::new(0.75487767, 0.56984029) * number;
                            let place =
                                place.fract() + DVec2::new(f64::from(x), f64::from(y)) - 32.0;
                            let ray = DVec3::new(place.x, -place.y, -focal).normalize();
                            let moment = number / f64::from(SAMPLES) - 0.5;
                            (center + velocity * moment).cross(ray).length() < radius
                        };
                        let covered = (0..SAMPLES).filter(hits).count() as f64 / f64::from(SAMPLES);
                        off += f64::from(picture.pixels[(y * EDGE + x) as usize].y) - covered;
                    }
                    worst = worst.max((off / 64.0).abs());
                }
                println!("{preset}, {velocity}: {worst:.4}");
                assert!(
                    worst < 0.006,
                    "{preset}, {velocity}: off by {worst} of a white drop's light"
                );
            }
        }
    });
}

/// Light rain in a small box, and placed drops on all kinds of ways: over the edges of the screen, towards the camera,
/// through its plane, close by; some at rest.
fn busy() -> Scene {
    let mut scene = square(64);
    scene.camera.vertical_fov = 70.0;
    scene.rain = Some(light_rain());
    scene.drops = vec![
        moving([-4.0, 1.0, -6.0], [3.0, -2.0, 0.0], 0.5),
        moving([0.4, 3.2, -9.0], [0.0, 0.5, 6.0], 0.4),
        moving([1.5, -0.5, -4.0], [-1.0, 1.0, 6.0], 0.2),
        moving([0.5, -1.0, -1.0], [0.1, 0.3, 4.0], 0.3),
        moving([-0.3, -1.5, -0.2], [0.0, 4.0, 0.0], 0.1),
        moving([2.0, 2.0, -5.0], [0.0, 0.0, 0.0], 0.8),
    ];
    scene
}

#[test]
fn moving_drops_are_near_the_reference() {
    let environment = waves();
    on_device(|device| {
        for shutter in [0.05, 0.4] {
            let mut exposed = busy();
            exposed.camera.shutter = shutter;
            let truth = truth(&exposed, &environment, 64);
            for (preset, bound) in [(Preset::Fast, 0.003), (Preset::Exact, 0.002)] {
                let mut scene = exposed.clone();
                scene.model.preset = preset;
                let exposure = exposure_of(&ToneMap::default(), &truth);
                let (picture, counts) = draw(&mut renderer(device, &scene, &environment), &scene);
                assert_eq!(counts.visible, count_visible(&scene));
                let error = compare(&truth, &picture, None, exposure).boxes.rms();
                // The control: the instant.
                scene.model.motion = Some(Motion::Instant);
                let (instant, _) = draw(&mut renderer(device, &scene, &environment), &scene);
                let control = compare(&truth, &instant, None, exposure).boxes.rms();
                let light = sum(&picture) / sum(&truth);
                println!("{preset} {shutter}: {error:.4}, instant {control:.4}, light {light:.4}");
                assert!(error < bound && error < 0.4 * control && (light - 1.0).abs() < 0.01);
            }
        }
    });
}

/// Rain of one size and drops of many, seen by a long lens: of 0.2 to 16 pixels of radius.
fn many_sizes() -> Scene {
    let mut scene = square(96);
    scene.camera.vertical_fov = 6.0;
    scene.rain = Some(RainSettings {
        count: 20_000,
        half_extent: DVec3::new(1.0, 1.5, 4.0),
        radius: 0.001,
        velocity: DVec3::new(1.0, -6.5, 0.3),
        ..RainSettings::default()
    });
    let pixel = scene.view().focal_px.recip();
    scene.drops = (0..12)
        .map(|number| {
            let part = |by: f64| (f64::from(number + 1) * by).fract() - 0.5;
            let across = 86.0 * pixel;
            let center = DVec3::new(across * part(0.819), across * part(0.671), -1.0);
            let fall = -3.0 - 0.4 * f64::from(number);
            let velocity = DVec3::new(2.0 * part(0.55), fall, part(0.37));
            let radius = 0.6 * 1.35_f64.powi(number) * pixel;
            PlacedDrop { velocity, ..PlacedDrop::sphere(center, radius) }
        })
        .collect();
    scene
}

/// From drops that stand to streaks beyond the picture no shutter is the first at which something is wrong. Errors are
/// products of the distances from two references, so that their noise is none. Errors of less than a grey level are no break.
#[test]
fn drops_become_streaks_without_a_break() {
    const STEPS: i32 = 40;
    let environment = waves();
    let scene = many_sizes();
    let exposure = exposure_of(&ToneMap::default(), &truth(&scene, &environment, 4));
    let shown = |picture: &Picture| -> Vec<f64> {
        let shown = display(exposure, picture).pixels;
        shown.iter().flat_map(|p| p.to_array()).map(|v| srgb_of_linear(v).into()).collect()
    };
    on_device(|device| {
        let (mut last, mut rise) = (f64::INFINITY, 0.0_f64);
        for step in 0..STEPS {
            let mut frame = scene.clone();
            frame.camera.shutter = 1e-6 * 1e5_f64.powf(f64::from(step) / f64::from(STEPS - 1));
            // Drops are in the same place at the middle of each exposure.
            frame.time = -0.5 * frame.camera.shutter;
            let truths = [0, 1].map(|seed| {
                let truth = Truth { samples: 8, seed, ..Truth::default() };
                Tracer::new(&frame, &environment, truth).picture()
            });
            let (picture, _) = draw(&mut renderer(device, &frame, &environment), &frame);
            let ([a, b], found) = (truths.each_ref().map(&shown), shown(&picture));
            let squares = found.iter().zip(a.iter().zip(&b)).map(|(p, (a, b))| (p - a) * (p - b));
            let rms = (squares.sum::<f64>() / found.len() as f64).max(0.0).sqrt();
            let light = 2.0 * sum(&picture) / truths.iter().map(sum).sum::<f64>();
            let shutter = frame.camera.shutter;
            println!(
                "{shutter:9.3e} s: RMS {rms:.5}, {:.2} of the last; light {light:.4}",
                rms / last
            );
            rise = rise.max(rms / last.max(0.8 / 255.0));
            assert!((light - 1.0).abs() < 0.01, "{shutter} s: {light} of the light");
            last = rms;
        }
        assert!(rise <= 1.5, "the error rises by {rise}");
    });
}

/// Radiance across a way through the picture's middle: means over two thirds of the picture along it, by half pixels.
fn across(picture: &Picture, way: DVec3) -> Vec<f64> {
    const BINS: f64 = 40.0;
    let (mut sums, mut counts) = (vec![0.0; BINS as usize], vec![0.0; BINS as usize]);
    let middle = 0.5 * f64::from(picture.width);
    for (number, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (number as u32 % picture.width, number as u32 / picture.width);
        let at = DVec3::new(f64::from(x) + 0.5 - middle, middle - f64::from(y) - 0.5, 0.0);
        let bin = 2.0 * at.cross(way).z + 0.5 * BINS;
        if at.dot(way).abs() < middle / 1.5 && (0.0..BINS).contains(&bin) {
            sums[bin as usize] += f64::from(pixel.y);
            counts[bin as usize] += 1.0;
        }
    }
    sums.iter().zip(&counts).filter(|(_, count)| **count > 0.0).map(|(s, c)| s / c).collect()
}

/// A drop of seven pixels before grey, lit by a bare sun beside the picture, moves by ten radii. The truth is the mean of
/// instants, in which the reference finds the sun's images.
#[test]
fn a_bare_sun_draws_lines_along_streaks() {
    const INSTANTS: u32 = 70;
    let lit = |sun: DVec3| {
        let sun = sun.normalize();
        painted(1024, move |d| Vec3::splat(if d.dot(sun) > 0.9999 { 3000.0 } else { 0.2 }))
    };
    // Beside, and just out of view, where a drop's images move by a tenth of its radius along its way.
    let [beside, near] = [(0.55, 0.45, -0.7), (0.2, -0.1, -1.0)].map(|sun| lit(sun.into()));
    on_device(|device| {
        // The wider the view, the nearer the drop: lines are those of a far one.
        for (angle, degrees, environment) in
            [(1.7_f64, 5.0, &beside), (0.4, 5.0, &beside), (1.7, 12.0, &beside), (1.7, 12.0, &near)]
        {
            let way = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let mut scene = square(64);
            (scene.camera.vertical_fov, scene.model.preset) = (degrees, Preset::Fast);
            let pixel = scene.view().focal_px.recip();
            let velocity = 70.0 * pixel * way;
            let center = DVec3::new(0.0, 0.0, -1.0) - 0.5 * velocity;
            scene.drops = vec![PlacedDrop { velocity, ..PlacedDrop::sphere(center, 7.0 * pixel) }];
            let mut truths = vec![0.0; 2 * 20];
            for instant in 0..INSTANTS {
                scene.time = (f64::from(instant) + 0.5) / f64::from(INSTANTS);
                let profile = across(&truth(&scene, environment, 64), way);
                for (sum, value) in truths.iter_mut().zip(profile) {
                    *sum += value / f64::from(INSTANTS);
                }
            }
            (scene.time, scene.camera.shutter) = (0.0, 1.0);
            let (picture, _) = draw(&mut renderer(device, &scene, environment), &scene);
            let found = across(&picture, way);
            let highest = truths.iter().fold(0.0_f64, |most, value| most.max(*value)) - 0.2;
            let worst = truths.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let light = |all: &[f64]| all.iter().map(|value| value - 0.2).sum::<f64>();
            let light = light(&found) / light(&truths);
            println!("{angle}: highest {highest:.3}, off by {worst:.3}, light {light:.3}");
            assert!(highest > 0.3, "the control: no line in the reference");
            assert!(worst < 0.01 * degrees * highest, "{angle}: off by {worst} of {highest}");
            // 2.5 % at an angle of 0.4 and five degrees.
            assert!((light - 1.0).abs() < 0.006 * degrees, "{angle}: {light} of the light");
        }
    });
}

#[test]
fn without_time_a_frame_is_the_instants_to_the_byte() {
    let environment = waves();
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let mut scene = busy();
            scene.model.preset = preset;
            let instant = draw(&mut renderer(device, &scene, &environment), &scene).0;
            let mut exposed = scene.clone();
            exposed.camera.shutter = 0.1;
            let mut renderer = renderer(device, &exposed, &environment);
            let streaks = draw(&mut renderer, &exposed).0;
            assert!(streaks != instant, "the control: {preset} draws no exposure");
            assert!(
                draw(&mut renderer, &exposed).0 == streaks,
                "{preset}: another picture of the same scene"
            );
            // The rain stands; the shutter does not open.
            assert!(draw(&mut renderer, &Scene { pace: 0.0, ..exposed.clone() }).0 == instant);
            assert!(draw(&mut renderer, &scene).0 == instant, "{preset}: shutter 0");
        }
    });
}
