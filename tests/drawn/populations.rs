//! Several populations of drops in boxes: each stands and falls as it would alone, on the GPU as on the CPU.

use std::sync::Arc;

use glam::DVec3;
use raindrops::gpu::Device;
use raindrops::rain::cull::{count_visible, drops_with_visibility};
use raindrops::rain::tick_of_seconds;
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, Population, RainSettings, Scene};

use crate::common::picture::{draw, renderer};
use crate::common::{by_paper, on_device, waves};
use crate::simulate::compare_records;

/// Three, of different speeds, sizes and boxes.
fn three() -> Scene {
    let second = Population {
        seed: Some(u64::MAX - 7),
        count: 20_001,
        half_extent: DVec3::new(700.0, 300.0, 900.0),
        radius: 0.5,
        velocity: DVec3::new(3.0, -4.0, 0.25),
    };
    let third = Population {
        seed: None,
        count: 9_999,
        half_extent: DVec3::splat(1500.0),
        radius: 2.0,
        velocity: DVec3::new(-0.1, -13.0, 1.0),
    };
    let rain = RainSettings {
        count: 30_001,
        others: [Some(second), Some(third), None],
        ..RainSettings::default()
    };
    Scene {
        seed: 0xfeed_0000_0bad,
        rain: Some(rain),
        image: ImageSize { width: 64, height: 48 },
        camera: Camera {
            position: DVec3::new(100.5, -20.25, 7.0),
            target: DVec3::new(101.5, -20.0, 5.0),
            ..Camera::default()
        },
        ..Scene::default()
    }
}

/// The scene with one of its populations alone.
fn alone(scene: &Scene, number: usize) -> Scene {
    let rain = scene.populations()[number];
    let (count, half_extent) = (rain.count, rain.half_extent);
    let (radius, velocity, seed) = (rain.radius, rain.velocity, Some(rain.seed));
    let rain = RainSettings { seed, count, half_extent, radius, velocity, ..Default::default() };
    Scene { rain: Some(rain), ..scene.clone() }
}

/// [`alone`], after populations that have no drops.
fn after_none(scene: &Scene, number: usize) -> Scene {
    let mut scene = alone(scene, number);
    let rain = scene.rain.expect("rain");
    let RainSettings { seed, count, half_extent, radius, velocity, .. } = rain;
    let population = Population { seed, count, half_extent, radius, velocity };
    let none = Population { count: 0, velocity: DVec3::ONE, ..population };
    let others = [Some(none), Some(population), None];
    scene.rain = Some(RainSettings { count: 0, others, ..RainSettings::default() });
    scene
}

#[test]
fn each_is_where_it_would_be_alone() {
    let mut scene = three();
    let seeds: Vec<u64> = scene.populations().iter().map(|rain| rain.seed).collect();
    assert_eq!(seeds, [0xfeed_0000_0bad, u64::MAX - 7, 0xfeed_0000_0baf]);
    for time in [0.0, 2.5, -2.5, 1e7, -1e7] {
        scene.time = time;
        let together: Vec<_> = drops_with_visibility(&scene).collect();
        let apart: Vec<_> = (0..3)
            .flat_map(|number| drops_with_visibility(&alone(&scene, number)).collect::<Vec<_>>())
            .collect();
        assert!(together == apart, "at {time} s");
        // By their own speeds, rounded to half a step of the box a second.
        for rain in scene.populations() {
            let [_, fallen, _] = rain.shift(tick_of_seconds(time));
            let boxes = rain.velocity.y * time / (2.0 * rain.half_extent.y);
            let exact = (boxes - boxes.floor()) * 4_294_967_296.0;
            let off = (f64::from(fallen) - exact).rem_euclid(4_294_967_296.0);
            assert!(off.min(4_294_967_296.0 - off) < 1.5 + 0.5 * time.abs(), "{time}: {off}");
        }
    }
}

#[test]
fn places_are_the_cpus_bit_for_bit() {
    on_device(|device| {
        let mut scene = by_paper(&three());
        scene.image = ImageSize { width: 16, height: 16 };
        let mut rain = renderer(device, &scene, &waves());
        let (_, limit) = raindrops::passes::drops::guard_band(device, 16, 16).expect("a limit");
        let mut compared = 0;
        for time in [0.0, 1.0, -1.0, 12_345.678, -12_345.678, 1e12, -1e12] {
            scene.time = time;
            compared += compare_records(&mut rain, &scene, limit.into());
        }
        assert_eq!(compared, 7 * 60_001);
    });
}

fn radiance(device: &Arc<Device>, scene: &Scene) -> raindrops::picture::Picture {
    let mut renderer = renderer(device, scene, &waves());
    let (picture, counts) = draw(&mut renderer, scene);
    assert_eq!(counts.visible, count_visible(scene));
    assert!(counts.visible > 1000);
    picture
}

#[test]
fn each_is_drawn_as_it_would_be_alone() {
    on_device(|device| {
        for (preset, time, shutter) in [
            (Preset::Paper, 0.3, 0.0),
            (Preset::Fast, 0.3, 0.0),
            (Preset::Fast, -70.0, 0.02),
            (Preset::Exact, -70.0, 0.02),
        ] {
            let mut scene = three();
            scene.model.take_preset(preset);
            scene.model.mask_size = 64;
            (scene.time, scene.camera.shutter) = (time, shutter);
            // All of them, in the order of their depths.
            let together = radiance(device, &scene);
            for number in 1..3 {
                let lone = radiance(device, &alone(&scene, number));
                let after = radiance(device, &after_none(&scene, number));
                assert!(lone == after, "{preset}, {number} at {time} s, {shutter} s exposed");
                assert!(lone != together);
            }
        }
    });
}
