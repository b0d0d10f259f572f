//! Sizes, distances, views, image shapes, and numbers of drops.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::metrics::rel_mse;
use raindrops::rain::cull::count_visible;
use raindrops::scene::model::Preset;
use raindrops::scene::{RainSettings, Scene};

use super::{PRESETS, black_ahead, draw, looking, placed, smooth, sum, truth};
use crate::common::{on_device, painted};

/// A drop of `pixels` across in the middle of an image of 48 x 48, by its distance or, beyond what
/// that allows, by the field of view.
fn sized(pixels: f64) -> Scene {
    const EDGE: f64 = 48.0;
    let distance = (EDGE / pixels).max(3.0);
    let mut scene = placed(&[(DVec3::new(0.0, 0.0, -distance), 1.0)], (48, 48));
    // Diameter = 2 f / √(d²-1) with f = 24 / tan(fov / 2).
    let focal = 0.5 * pixels * (distance * distance - 1.0).sqrt();
    scene.camera.vertical_fov = (2.0 * (0.5 * EDGE / focal).atan().to_degrees()).min(175.0);
    scene
}

#[test]
fn drops_of_a_thousandth_to_ten_thousand_pixels() {
    on_device(|device| {
        let black = black_ahead();
        for preset in PRESETS {
            let mut at_a_pixel = None;
            for pixels in [1.0, 0.5, 0.3, 0.1, 0.01, 1e-3] {
                let (picture, counts) = draw(device, &sized(pixels), &black, preset);
                assert_eq!(counts.visible, 1, "{preset}, {pixels} px");
                // The light of a drop goes by its area. The paper's single look-up changes its mind
                // between places of the mask, which is a matter of method.md; under 0.01 px a drop is
                // lost where the picture is kept, in float16.
                let found = sum(&picture) / (pixels * pixels);
                let share = found / *at_a_pixel.get_or_insert(found);
                println!("{preset}, {pixels} px: {share:.4} of the light that its area asks for");
                if preset != Preset::Paper && pixels >= 0.1 {
                    assert!((share - 1.0).abs() < 0.15, "{preset}, {pixels} px: {share}");
                }
            }
            let smooth = smooth();
            for pixels in [64.0, 500.0, 2e3, 1e4] {
                let scene = sized(pixels);
                let (picture, counts) = draw(device, &scene, &smooth, preset);
                assert_eq!((counts.visible, counts.overflow), (1, 0), "{preset}, {pixels} px");
                let off = rel_mse(&truth(&scene, &smooth, 16), &picture, None);
                println!("{preset}, {pixels} px: relMSE {off:.1e}");
                assert!(off < if preset == Preset::Paper { 2e-2 } else { 2e-3 });
            }
        }
    });
}

/// Far off the axis a drop's outline is long: longer, at 77 degrees, than what a splat holds.
#[test]
fn a_small_drop_far_off_the_axis_keeps_its_light() {
    on_device(|device| {
        let towards = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            DVec3::new(0.0, sine, -cosine)
        };
        for (degrees, distance) in [(60.0, 120.0), (70.0, 200.0), (77.0, 270.0)] {
            let mut scene = placed(&[(distance * towards(degrees), 1.0)], (64, 512));
            scene.camera.vertical_fov = 165.0;
            // Light from behind the camera alone: all that the image shows of it is in the drop.
            let behind = painted(256, |d| Vec3::splat(1e3 * d.z.max(0.0) as f32));
            let fast = sum(&draw(device, &scene, &behind, Preset::Fast).0);
            let expected = sum(&truth(&scene, &behind, 256));
            println!("{degrees} degrees: {fast:.1} for {expected:.1}");
            assert!((fast / expected - 1.0).abs() < 0.15, "{degrees}: {fast} for {expected}");
        }
    });
}

#[test]
fn from_inside_a_drop_to_a_million_radii() {
    on_device(|device| {
        let smooth = smooth();
        let at = |distance: f64| {
            let mut scene = placed(&[(DVec3::new(0.02, 0.01, -distance), 1.0)], (40, 40));
            // Beyond a few radii, close enough to be 20 px.
            if distance > 3.0 {
                scene.camera.vertical_fov = (2.0 * (2.0 / distance).atan().to_degrees()).max(0.01);
            }
            scene
        };
        let sky = draw(device, &placed(&[], (40, 40)), &smooth, Preset::Paper).0;
        for preset in PRESETS {
            for distance in [0.0, 0.999] {
                let (picture, counts) = draw(device, &at(distance), &smooth, preset);
                assert_eq!((counts.visible, counts.camera_inside), (0, 1), "{preset} {distance}");
                assert!(rel_mse(&sky, &picture, None) < 1e-6, "{preset}: not drawn from inside");
            }
            for distance in [1.01, 1.5, 3.0, 30.0, 1e4] {
                let scene = at(distance);
                let (picture, counts) = draw(device, &scene, &smooth, preset);
                assert_eq!(counts.visible + counts.beside_camera, 1, "{preset} {distance}");
                let off = rel_mse(&truth(&scene, &smooth, 16), &picture, None);
                println!("{preset}, {distance} radii: relMSE {off:.1e}");
                // The paper's square at less than a radius from the surface, see method.md.
                let bound = if preset == Preset::Paper { 0.05 } else { 3e-3 };
                assert!(off < bound, "{preset} {distance}: {off}");
            }
            assert_eq!(draw(device, &at(1e6), &smooth, preset).1.visible, 1);
        }
    });
}

#[test]
fn along_every_axis_and_along_up() {
    on_device(|device| {
        let smooth = smooth();
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for direction in [axis, -axis] {
                for up in [DVec3::Y, direction] {
                    let aside = direction.any_orthonormal_vector();
                    let mut scene = placed(&[(3.0 * direction + 0.3 * aside, 1.0)], (40, 40));
                    scene.camera = looking(direction, up, 60.0);
                    for preset in PRESETS {
                        let (picture, counts) = draw(device, &scene, &smooth, preset);
                        assert_eq!(counts.visible, 1, "{preset}, along {direction}, up {up}");
                        let off = rel_mse(&truth(&scene, &smooth, 16), &picture, None);
                        let bound = if preset == Preset::Paper { 0.02 } else { 2e-3 };
                        assert!(off < bound, "{preset}, along {direction}, up {up}: {off}");
                    }
                }
            }
        }
    });
}

/// The counts are the CPU's, the pictures finite, in every shape, at every field of view, and for
/// the least and greatest seeds.
#[test]
fn every_shape_of_image() {
    on_device(|device| {
        let most = device.report.limits.max_image_dimension2_d.min(32_768);
        let sky = smooth();
        let mut scene = Scene::default();
        let half_extent = DVec3::splat(60.0);
        scene.rain = Some(RainSettings { count: 20_000, half_extent, ..Default::default() });
        scene.model.mask_size = 64;
        for (size, fov, seed) in [
            ((1, 1), 90.0, 0),
            ((1, 1), 1.0, u64::MAX),
            ((3, 2), 170.0, 0),
            ((300, 1), 1.0, u64::MAX),
            ((1, 300), 170.0, 1),
            ((most, 1), 90.0, 1),
            ((1, most), 20.0, 1),
        ] {
            (scene.image.width, scene.image.height) = size;
            (scene.camera.vertical_fov, scene.seed) = (fov, seed);
            for preset in [Preset::Paper, Preset::Fast] {
                let counts = draw(device, &scene, &sky, preset).1;
                println!("{preset}, {size:?}, {fov}°, seed {seed}: {counts:?}");
                assert_eq!(counts.visible, count_visible(&scene), "{preset} {size:?} {fov}");
                // The lists of drops over the point limit have an end, which is said.
                assert!(counts.overflow == 0 || size.0.max(size.1) == most, "{preset} {size:?}");
            }
        }
    });
}

#[test]
fn no_drop_and_one() {
    on_device(|device| {
        let smooth = smooth();
        let none = Scene {
            rain: Some(RainSettings { count: 0, ..Default::default() }),
            ..placed(&[], (24, 24))
        };
        let one =
            Scene { rain: Some(RainSettings { count: 1, ..Default::default() }), ..none.clone() };
        for preset in PRESETS {
            let (picture, counts) = draw(device, &none, &smooth, preset);
            assert_eq!(counts.visible, 0);
            let off = rel_mse(&truth(&none, &smooth, 16), &picture, None);
            assert!(off < 1e-5, "{preset}: not the sky: {off:.1e}");
            assert_eq!(draw(device, &one, &smooth, preset).1.visible, count_visible(&one));
        }
    });
}

/// 8.4 and 20 million drops: as many as one binding holds, and more. Minutes, and 1 GB.
#[test]
#[ignore = "takes a minute and a gigabyte"]
fn twenty_million_drops() {
    on_device(|device| {
        let sky = Environment::constant(glam::Vec3::ONE);
        for count in [8_388_608, 8_388_609, 20_000_000] {
            let mut scene = Scene::default();
            scene.rain.get_or_insert_default().count = count;
            (scene.image.width, scene.image.height) = (256, 256);
            scene.model.mask_size = 64;
            let expected = count_visible(&scene);
            for preset in [Preset::Paper, Preset::Fast] {
                let counts = draw(device, &scene, &sky, preset).1;
                assert_eq!((counts.visible, counts.overflow), (expected, 0), "{preset}, {count}");
            }
        }
    });
}
