//! Pixels of the sky beside something much brighter, and drops that show it: however small a part of a pixel it is, it counts.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::picture::{against, picture_of, square, truth};
use crate::common::{on_device, painted};

const LAMP: f32 = 1e3;

/// Four lamps, a texel or two wide, one of them over the seam, before a sky that is a thousandth as bright.
fn lamps(width: u32) -> Environment {
    let texel = PI / f64::from(width / 2);
    let toward = [[0.05, 0.03], [-0.2, 0.1], [0.16, -0.17], [PI - 0.4 * texel, 0.02]];
    painted(width, |d| {
        let near = toward.iter().any(|[azimuth, elevation]| {
            let (x, y) = (d.x.atan2(-d.z) - azimuth, d.y.asin() - elevation);
            x.abs().min(2.0 * PI - x.abs()) < 0.6 * texel && y.abs() < 0.9 * texel
        });
        Vec3::new(0.5, 0.7, 1.0) * if near { LAMP } else { 1.0 }
    })
}

/// Looks at them, aslant, with pixels of so many texels; what it is for is the sky alone.
fn toward_lamps(pixels: f64, width: u32, backwards: bool) -> Scene {
    let mut scene = square(24);
    let texel = PI / f64::from(width / 2);
    let turned = if backwards { -1.0 } else { 1.0 };
    scene.camera.target = DVec3::new(0.03, 0.02, -turned);
    scene.camera.up = DVec3::new(0.35, 0.94, 0.0);
    scene.camera.vertical_fov = 2.0 * (12.0 * pixels * texel).atan().to_degrees();
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 9.0, 0.0), 0.1)];
    scene
}

/// The mean over `places` of each pixel of the sky, by float64.
fn mean_sky(scene: &Scene, environment: &Environment, places: &[DVec2]) -> Picture {
    let view = scene.view();
    let mean = |at: u32| {
        let corner = DVec2::new((at % view.width).into(), (at / view.width).into());
        let light =
            |place: &DVec2| environment.radiance(view.ray(corner.x + place.x, corner.y + place.y));
        (places.iter().map(light).sum::<DVec3>() / places.len() as f64).as_vec3()
    };
    let pixels = (0..view.width * view.height).map(mean).collect();
    Picture { width: view.width, height: view.height, pixels }
}

/// Largest error of a pixel, in levels of 255.
fn worst(expected: &Picture, found: &Picture) -> f32 {
    let level = |light: Vec3| 255.0 * (light / (light + 1.0)).powf(1.0 / 2.2);
    let pairs = expected.pixels.iter().zip(&found.pixels);
    pairs.map(|(a, b)| (level(*a) - level(*b)).abs().max_element()).fold(0.0, f32::max)
}

#[test]
fn a_lamps_edge_is_the_mean_of_each_pixel() {
    const FINE: u32 = 128;
    let place = |n: u32| DVec2::new((n % FINE).into(), (n / FINE).into());
    let places: Vec<DVec2> = (0..FINE * FINE).map(|n| (place(n) + 0.5) / f64::from(FINE)).collect();
    on_device(|device| {
        let mut worst_of = [0.0f32; 2];
        for (pixels, width, backwards) in [
            (0.05, 64, false),
            (0.3, 64, false),
            (0.3, 64, true),
            (0.6, 128, false),
            (1.2, 256, true),
        ] {
            let environment = lamps(width);
            let mut scene = toward_lamps(pixels, width, backwards);
            let expected = mean_sky(&scene, &environment, &places);
            assert!(expected.pixels.iter().any(|pixel| pixel.x > 0.1 * LAMP), "{pixels}");
            for (preset, worst_of) in [Preset::Fast, Preset::Exact].into_iter().zip(&mut worst_of) {
                scene.model.preset = preset;
                let error = worst(&expected, &picture_of(device, &scene, &environment));
                println!("{preset}, {pixels} texels: {error:.2}");
                *worst_of = worst_of.max(error);
            }
        }
        // Usually 2.1; by the few samples of `fast`, whose camera may move in each frame, 94.
        let [fast, exact] = worst_of;
        assert!(exact < 3.0 && fast > 30.0, "{exact}, fast {fast}");
    });
}

/// Flattened drops show the lamps in a hundredth of a pixel; where 64 rays do not tell their light, `exact` takes more.
#[test]
fn few_drops_have_the_rays_that_lamps_ask_for() {
    let environment = lamps(128);
    let mut scene = square(48);
    scene.camera.vertical_fov = 20.0;
    let drop = |number: u32| PlacedDrop {
        axis_ratio: Some(0.7 + 0.02 * f64::from(number)),
        ..PlacedDrop::sphere(
            DVec3::new(f64::from(number % 4) - 1.5, f64::from(number / 4) - 1.0, -10.0),
            0.4,
        )
    };
    scene.drops = (0..12).map(drop).collect();
    let truth = truth(&scene, &environment, 4096);
    on_device(|device| {
        let error = |samples: Option<u32>| {
            let mut scene = scene.clone();
            scene.model.preset = Preset::Exact;
            scene.model.samples = samples;
            against(&truth, &picture_of(device, &scene, &environment)).pixels.rms()
        };
        let (asked, own) = (error(Some(64)), error(None));
        println!("64 rays {asked:.5}, its own {own:.5}");
        assert!(own < 0.7 * asked, "{own}, 64 rays {asked}");
    });
}

/// Where none of a pixel's first 16 rays meets the lamp, no more follow, and it is a black dot in the lamp's bright disc. A number
/// of rays that is asked for is the control.
#[test]
fn a_few_drops_out_of_focus_have_no_dots() {
    let environment = lamps(128);
    let mut scene = square(48);
    scene.camera.vertical_fov = 12.0;
    (scene.camera.aperture, scene.camera.focus) = (0.5, 60.0);
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.1, 0.05, -9.0), 0.3)];
    let truth = truth(&scene, &environment, 4096);
    on_device(|device| {
        for (preset, samples) in [(Preset::Fast, 1), (Preset::Exact, 16)] {
            let error = |samples: Option<u32>| {
                let mut scene = scene.clone();
                scene.model.preset = preset;
                scene.model.samples = samples;
                against(&truth, &picture_of(device, &scene, &environment)).pixels.rms()
            };
            let (asked, own) = (error(Some(samples)), error(None));
            println!("{preset}: {samples} rays {asked:.5}, its own {own:.5}");
            assert!(own < 0.9 * asked, "{preset}: {own}, {samples} rays {asked}");
        }
    });
}
