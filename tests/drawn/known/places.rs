//! Where the rain is: exact arithmetic in wide integers, and drops far from the world's origin.

use glam::DVec3;
use raindrops::rain::cull::drops_with_visibility;
use raindrops::rain::{Rain, start, tick_of_seconds};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{RainSettings, Scene};

use super::{draw, placed};
use crate::common::{Random, on_device, painted};

const TWO_32: i128 = 1 << 32;

fn rain(half_extent: f64, velocity: f64) -> Rain {
    let (half_extent, velocity) = (DVec3::splat(half_extent), DVec3::splat(velocity));
    Rain { seed: 1, count: 16, half_extent, radius: 1.0, velocity }
}

#[test]
fn a_time_is_the_nearest_tick() {
    let tick = 2f64.powi(-32);
    for (ticks, nearest) in [
        (0.0, 0),
        (0.25, 0),
        (0.75, 1),
        (-0.25, 0),
        (-0.75, -1),
        (-1.25, -1),
        (-1.75, -2),
        (7.0, 7),
        (-7.0, -7),
    ] {
        assert_eq!(tick_of_seconds(ticks * tick), nearest, "{ticks} ticks");
    }
    for (seconds, ticks) in [
        (1.0, TWO_32),
        (-1.0, -TWO_32),
        // 429,496,729.6 ticks.
        (0.1, 429_496_730),
        (-0.1, -429_496_730),
        // A year, and back.
        (31_557_600.0, 31_557_600 * TWO_32),
        (-31_557_600.0, -31_557_600 * TWO_32),
    ] {
        assert_eq!(tick_of_seconds(seconds), ticks, "{seconds} s");
    }
}

/// In a box of 1024 units that falls one a second, a tick is 2^-42 of the box: 1024 of them are one step.
#[test]
fn the_rain_moves_by_whole_steps_downwards_rounded() {
    for (tick, expected) in [
        (0, 0),
        (1, 0),
        (1023, 0),
        (1024, 1),
        (1025, 1),
        (-1, u32::MAX),
        (-1024, u32::MAX),
        (-1025, u32::MAX - 1),
        // A second is 1/1024 of the box, 1024 seconds are all of it.
        (TWO_32, 1 << 22),
        (-TWO_32, (1 << 22) * 1023),
        (TWO_32 * 1024, 0),
        (TWO_32 * 1024 * 1_000_003 + 2048, 2),
    ] {
        assert_eq!(rain(512.0, 1.0).shift(tick), [expected; 3], "tick {tick}");
    }
}

/// The rule for any velocity: floor(motion x tick / 2^32) modulo 2^32, with the motion of a tick rounded once.
#[test]
fn the_rain_moves_as_wide_integers_say() {
    let mut random = Random(77);
    // Whole numbers, so that the motion of a tick is the quotient of two integers.
    for (edge, velocity) in [(2050i128, -9i128), (3, 7), (1_000_003, -999_983), (640, 1)] {
        let numerator = velocity * TWO_32;
        // To the nearest; no half occurs.
        let motion = (2 * numerator + edge).div_euclid(2 * edge);
        let rain = rain(0.5 * edge as f64, velocity as f64);
        for exponent in 0..90 {
            let product = i128::from(random.bits() >> 1) * i128::from(random.bits() >> 1);
            let tick = product >> (126 - exponent);
            for tick in [tick, -tick] {
                let expected = (motion * tick).div_euclid(TWO_32).rem_euclid(TWO_32) as u32;
                assert_eq!(rain.shift(tick), [expected; 3], "{velocity}/{edge}, tick {tick}");
            }
        }
    }
}

/// The hash pcg4d, computed in Python's integers from its publication.
#[test]
fn drops_start_where_the_published_hash_says() {
    for (seed, index, expected) in [
        (0, 0, [0xf6bc_cb9e, 0x72c1_d612, 0x2e1d_dd8e]),
        (1, 7, [0x15bc_1799, 0x38b7_687f, 0xbd80_545f]),
        (0x0123_4567_89ab_cdef, 0xffff_fffe, [0x188d_2ff4, 0x2e57_556f, 0x7242_9d2c]),
        (1 << 32, 5, [0xceba_336d, 0x0141_ccab, 0x3d1d_4be7]),
        (u64::MAX, 123_456_789, [0xea6c_28e3, 0x7a60_1dae, 0xaa4a_9995]),
    ] {
        assert_eq!(start(seed, index), expected, "seed {seed}, drop {index}");
    }
}

/// Fractions of a box of 1024 units, and back to units: the short way around the box.
#[test]
fn the_box_wraps_around_the_camera() {
    let rain = rain(512.0, 0.0);
    for (position, place) in [
        (0.0, 0),
        (256.0, 1 << 30),
        (-256.0, 3 << 30),
        (1024.25, 1 << 20),
        (-1024.25, u32::MAX - (1 << 20) + 1),
        (1e6 * 1024.0 + 512.0, 1 << 31),
    ] {
        assert_eq!(rain.camera_place(DVec3::splat(position)), [place; 3], "at {position}");
    }
    for (place, camera, apart) in [
        (1 << 30, 0, 256.0),
        (3 << 30, 0, -256.0),
        (0, 1 << 30, -256.0),
        (1 << 20, u32::MAX - (1 << 20) + 1, 0.5),
    ] {
        let relative = rain.relative([place; 3], [camera; 3]);
        assert_eq!(relative.to_array(), [apart; 3], "{place} from {camera}");
    }
}

/// A drop's centre as the camera sees it, from its start, its fall and the camera's position.
#[test]
fn drops_are_where_they_have_fallen_to() {
    let camera = Camera {
        position: DVec3::new(100.5, -2000.25, 7.0),
        target: DVec3::new(100.5, -2000.25, 6.0),
        ..Camera::default()
    };
    for time in [0.0, 2.5, -2.5, 86_400.0, -1e6] {
        let mut scene = Scene { seed: 0xfeed_0000_0bad, time, camera, ..Scene::default() };
        let settings = RainSettings { count: 500, ..RainSettings::default() };
        scene.rain = Some(settings);
        let edge = 2.0 * settings.half_extent;
        for (index, (center, ..)) in (0..).zip(drops_with_visibility(&scene)) {
            let at = start(scene.seed, index).map(|place| f64::from(place) / TWO_32 as f64);
            let fallen = DVec3::from(at) * edge + settings.velocity * time - camera.position;
            let near = fallen - (fallen / edge).round() * edge;
            let mut off = near - center.as_dvec3();
            off -= (off / edge).round() * edge;
            // float32 at 1025 units; the motion of a tick is rounded, by 3e-8 of the way.
            let bound = 4e-4 + 3e-8 * (settings.velocity * time).length();
            assert!(off.length() < bound, "drop {index} at {time} s: {off} off");
        }
    }
}

/// Drops and camera moved by the same, as far as float64 tells it exactly: the same bytes.
#[test]
fn far_from_the_origin_nothing_changes() {
    on_device(|device| {
        let mut random = Random(8);
        // Multiples of 1/64.
        let mut dyadic = |most: f64| (64.0 * most * (2.0 * random.unit() - 1.0)).round() / 64.0;
        let drops: Vec<_> = (0..60)
            .map(|_| (DVec3::new(dyadic(9.0), dyadic(9.0), -10.0 + dyadic(8.0)), 0.25))
            .collect();
        let eye = DVec3::new(0.265_625, -0.140_625, 0.375);
        let sky = painted(64, |d| (2.0 * d).as_vec3().exp());
        let moved = |by: DVec3| {
            let mut scene = placed(drops.iter().map(|(center, r)| (*center + by, *r)), 48);
            scene.camera.position = eye + by;
            scene.camera.target = eye + by - DVec3::new(0.125, 0.25, 1.0);
            scene
        };
        for preset in [Preset::Paper, Preset::Fast] {
            let origin = draw(device, &moved(DVec3::ZERO), &sky, preset);
            for by in [DVec3::new(1e7, -2e7, 3e7), DVec3::splat(-16_777_217.0)] {
                let far = draw(device, &moved(by), &sky, preset);
                assert!(far == origin, "{preset}: another picture at {by}");
            }
            // The control: a sixty-fourth of a unit is seen.
            let mut scene = moved(DVec3::ZERO);
            scene.camera.position.x += 1.0 / 64.0;
            assert!(draw(device, &scene, &sky, preset) != origin, "{preset}");
        }
    });
}
