//! What is found out about a driver by drawing, and that the renderer draws the same picture whatever
//! it is.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec2, Vec3};
use half::f16;
use raindrops::environment::Environment;
use raindrops::gpu::probe::points::{Mark, Shot, limit_of, limit_shots, off_screen_shots};
use raindrops::gpu::probe::{Findings, Rounding, halves::rounding, point_rules};
use raindrops::gpu::{Device, PointRules};
use raindrops::picture::Picture;
use raindrops::picture::metrics::compare;
use raindrops::picture::tone_map::exposure_of;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene, ToneMap};

use crate::common::{on_device, on_fresh_device};

#[test]
fn the_device_is_as_it_is_found() {
    on_device(|device| {
        let start = Instant::now();
        let rules = point_rules(device).expect("rules");
        println!("rules in {:?}: {rules:?}", start.elapsed());
        let found = Findings::of(device).expect("findings");
        println!("all in {:?}: {found:#?}", start.elapsed());
        let points = found.points.expect("a device with large points");
        assert_eq!((points.limit_px, points.draws_off_screen), {
            (rules.limit_px, rules.draws_off_screen)
        });
        // What the pictures rely on.
        assert!(rules.limit_px >= 64.0);
        assert_eq!(points.sub_pixel, [1, 1], "a drop's area is in its alpha");
        assert!(points.coordinate_error_px < 0.05);
        assert!(found.sampling.explicit_level_error < 1.0 / 128.0, "levels are given");
        assert!(found.sampling.blends_a_texel > 60 && found.sampling.blends_a_level > 15);
        assert_ne!(found.halves.written, Rounding::Other);
        assert_ne!(found.halves.packed, Rounding::Other);
        assert!(found.halves.keeps_denormals);
    });
}

/// A driver in a few lines: points are clamped to a size, and clipped or not by their centres.
struct Driver {
    clamp: f32,
    clips: bool,
    upside_down: bool,
}

impl Driver {
    fn marks(&self, shots: &[Shot]) -> Vec<Vec<Mark>> {
        let marks = |shot: &Shot| {
            let [.., width, height] = shot.cell.at;
            let size = shot.size.min(self.clamp);
            let end = Vec2::new(width as f32, height as f32);
            let inside =
                shot.center.min_element() >= 0.0 && (end - shot.center).min_element() > 0.0;
            let pixel = |x, y| {
                let from = Vec2::new(x as f32, y as f32) + 0.5 - shot.center;
                let hit = from.abs().max_element() < 0.5 * size && (inside || !self.clips);
                let mut at = from / size + 0.5;
                if self.upside_down {
                    at.y = 1.0 - at.y;
                }
                hit.then_some(at)
            };
            (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect()
        };
        shots.iter().map(marks).collect()
    }

    fn rules(&self, claimed: f32) -> PointRules {
        let shots = limit_shots(claimed);
        let limit_px = limit_of(&shots, &self.marks(&shots));
        let shots = off_screen_shots(limit_px.max(1.0));
        let mut pairs = shots.iter().zip(self.marks(&shots));
        let draws_off_screen = pairs.all(|(shot, marks)| shot.error_px(&marks) < 0.5);
        PointRules { limit_px, draws_off_screen }
    }
}

/// The control of the probe: drivers that lie are found out.
#[test]
fn a_driver_that_lies_is_found_out() {
    let honest = Driver { clamp: 255.0, clips: false, upside_down: false };
    assert_eq!(honest.rules(255.0), PointRules { limit_px: 255.0, draws_off_screen: true });
    let clips = Driver { clips: true, ..honest };
    assert_eq!(clips.rules(255.0), PointRules { limit_px: 255.0, draws_off_screen: false });
    let clamps = Driver { clamp: 100.0, ..honest };
    assert_eq!(clamps.rules(255.0).limit_px, 63.75);
    let clamps = Driver { clamp: 254.0, ..honest };
    assert_eq!(clamps.rules(255.0).limit_px, 191.25);
    let upside_down = Driver { upside_down: true, ..honest };
    assert!(!upside_down.rules(255.0).draws_off_screen);
}

#[test]
fn rounding_rules_are_told_apart() {
    let values: Vec<f32> = (0..100).map(|n| 1.0 + n as f32 * 1.3e-4).collect();
    let nearest: Vec<f16> = values.iter().map(|value| f16::from_f32(*value)).collect();
    assert_eq!(rounding(&values, &nearest), Rounding::Nearest);
    let down = |value: &f32| f16::from_f32((value * 1024.0).floor() / 1024.0);
    let down: Vec<f16> = values.iter().map(down).collect();
    assert_eq!(rounding(&values, &down), Rounding::TowardZero);
    assert_eq!(rounding(&values, &[f16::ONE; 100]), Rounding::Other);
}

fn render(device: &Arc<Device>, scene: &Scene) -> Picture {
    let texels =
        (0..64 * 32).map(|index| Vec3::new(index as f32 / 2048.0, 0.3, (index % 64) as f32 / 32.0));
    let environment =
        Environment::from_texels("ramps", 64, 32, texels.collect()).expect("an image");
    let plan =
        plan(&crate::common::by_paper(scene), &environment, Output::Radiance).expect("a plan");
    let mut renderer = Renderer::new(device, scene, &environment, &plan).expect("a renderer");
    renderer.submit(scene).expect("a frame");
    assert_eq!(renderer.finish().expect("a report").counts.overflow, 0);
    renderer.read_radiance().expect("radiance")
}

/// Drops over every edge and corner, their centres outside, over small rain.
fn edges() -> Scene {
    let mut scene = Scene {
        image: ImageSize { width: 160, height: 96 },
        rain: Some(RainSettings {
            count: 400,
            half_extent: DVec3::splat(40.0),
            ..Default::default()
        }),
        ..Scene::default()
    };
    scene.model.mask_size = 128;
    for (x, y) in [(-1.0, 0.2), (1.0, -0.1), (0.1, 1.0), (-0.2, -1.0), (1.0, 1.0), (-1.0, -1.0)] {
        let center = DVec3::new(x * 11.0, y * 6.9, -6.4);
        scene.drops.push(PlacedDrop::sphere(center, 2.0));
    }
    scene
}

#[test]
fn the_picture_does_not_depend_on_the_rules() {
    let scene = edges();
    let with = |rules: Option<PointRules>| {
        let mut picture = None;
        on_fresh_device(|device| {
            if let Some(rules) = rules {
                device.point_rules.set(rules).expect("not yet probed");
            }
            picture = Some(render(device, &scene));
        });
        picture.expect("a picture")
    };
    let against =
        |a: &Picture, b: &Picture| compare(a, b, None, exposure_of(&ToneMap::default(), a)).pixels;
    let found = with(None);
    let rules = |limit_px, draws_off_screen| Some(PointRules { limit_px, draws_off_screen });
    for (what, rules) in [
        ("a guard band", rules(250.0, false)),
        ("points to 16 px, without a band", rules(16.0, true)),
        ("points to 16 px, in a band", rules(16.0, false)),
        ("no points at all", rules(0.0, false)),
    ] {
        let found = against(&found, &with(rules));
        println!("{what}: relMSE {:.1e}, FLIP {:.5}", found.rel_mse, found.flip);
        assert!(found.flip < 2e-3 && found.rel_mse < 1e-3, "{what}");
    }
    // The control: the drops over the edges left out.
    let mut without = edges();
    without.drops.clear();
    on_device(|device| {
        let other = render(device, &without);
        let off = against(&found, &other);
        println!("without: relMSE {:.1e}, FLIP {:.5}", off.rel_mse, off.flip);
        assert!(off.flip > 0.01);
    });
}
