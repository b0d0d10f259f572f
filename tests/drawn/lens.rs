//! Lenses drawn by the GPU: light, coverage and colours of drops out of focus, against closed forms and the reference.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::rain::cull::count_visible;
use raindrops::rain::field::Field;
use raindrops::scene::model::{Lens, Preset, ShapeModel};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::picture::{
    against, black, draw, light_rain, moving, picture_of, renderer, square, sum, truth,
};
use crate::common::{on_device, painted, waves};

/// RMS error of boxes, in display values from 0 to 1.
fn boxed_error(truth: &Picture, picture: &Picture) -> f64 {
    against(truth, picture).boxes.rms()
}

/// A drop of some pixels of radius before black, focused at infinity.
fn before_black(edge: u32, radius: f64, preset: Preset) -> Scene {
    let mut scene = square(edge);
    scene.model.preset = preset;
    scene.background.color = Some(black("lens", edge));
    (scene.camera.vertical_fov, scene.camera.focus, scene.camera.aperture) =
        (10.0, f64::INFINITY, 1e-3);
    let pixel = 1.0 / scene.view().focal_px;
    let at = DVec3::new(3.3 * pixel, 1.8 * pixel, -1.0);
    scene.drops = vec![PlacedDrop::sphere(at, radius * pixel)];
    scene
}

/// The lens that makes a disc of so many pixels of radius of a point at depth 1.
fn aperture(scene: &Scene, blur: f64) -> f64 {
    2.0 * blur / scene.view().focal_px
}

#[test]
fn a_drop_out_of_focus_has_the_light_of_one_in_focus() {
    const EDGE: u32 = 128;
    let white = Environment::constant(Vec3::ONE);
    on_device(|device| {
        let mut worst = 0.0_f64;
        for preset in [Preset::Fast, Preset::Exact] {
            for radius in [0.05, 0.3, 1.4, 3.0, 25.0] {
                if preset == Preset::Exact && [0.05, 1.4].contains(&radius) {
                    continue;
                }
                let mut scene = before_black(EDGE, radius, preset);
                let mut renderer = renderer(device, &scene, &white);
                for blur in [0.55, 1.1, 3.3, 20.0] {
                    scene.camera.aperture = aperture(&scene, blur);
                    let disc = std::f64::consts::PI * radius * radius;
                    let light = sum(&draw(&mut renderer, &scene).0) / disc;
                    worst = worst.max((light - 1.0).abs());
                    assert!(
                        (light - 1.0).abs() < 0.01,
                        "{preset}: radius {radius}, disc {blur}: {light} of the light"
                    );
                }
            }
        }
        println!("off by {worst:.5} at most");
    });
}

/// A disc of radius R has a variance of R²/4 along each axis; the light of a drop that is spread has those of both.
#[test]
fn a_disc_is_as_wide_as_the_lens_makes_it() {
    const EDGE: u32 = 128;
    let white = Environment::constant(Vec3::ONE);
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            for (radius, blur) in [(0.4, 12.0), (0.4, 30.0), (3.0, 20.0), (20.0, 20.0)] {
                let mut scene = before_black(EDGE, radius, preset);
                scene.camera.aperture = aperture(&scene, blur);
                let picture = draw(&mut renderer(device, &scene, &white), &scene).0;
                let moment = |power: i32| -> f64 {
                    let light = picture.pixels.iter().zip(0..).map(|(pixel, at)| {
                        let x = f64::from(at % EDGE) + 0.5 - 0.5 * f64::from(EDGE);
                        f64::from(pixel.y) * x.powi(power)
                    });
                    light.sum::<f64>() / sum(&picture)
                };
                let variance = moment(2) - moment(1).powi(2);
                let ratio = variance / (0.25 * (radius * radius + blur * blur) + 1.0 / 12.0);
                println!("{preset}: radius {radius}, disc {blur}: variance {ratio:.4}");
                assert!((ratio - 1.0).abs() < 0.02, "{preset}, {radius}, {blur}: {ratio}");
            }
        }
    });
}

/// A drop of so many pixels of radius, its disc so many times as large, before the focus or beyond it.
fn alone(radius_px: f64, ratio: f64) -> Scene {
    let mut scene = square(48);
    (scene.camera.vertical_fov, scene.camera.focus, scene.camera.aperture) = (50.0, 4.0, 0.1);
    let f = scene.view().focal_px;
    let inverse = ratio * radius_px / (f * 0.5 * scene.camera.aperture);
    let behind = 0.25 - inverse;
    let depth = if behind > 0.02 { behind.recip() } else { (0.25 + inverse).recip() };
    let center = depth * DVec3::new(0.11, 0.07, -1.0);
    scene.drops = vec![PlacedDrop::sphere(center, radius_px * depth / f)];
    scene
}

#[test]
fn drops_out_of_focus_are_near_the_reference() {
    let environment = waves();
    on_device(|device| {
        for (radius, ratio, shows) in [
            (0.3, 3.0, false),
            (1.2, 1.0, true),
            (2.5, 3.0, true),
            (5.0, 10.0, true),
            (10.0, 1.0, true),
            (20.0, 0.3, true),
            (30.0, 0.1, true),
        ] {
            let mut scene = alone(radius, ratio);
            let truth = truth(&scene, &environment, 128);
            scene.model.preset = Preset::Exact;
            scene.model.lens = Some(Lens::Pinhole);
            let sharp = draw(&mut renderer(device, &scene, &environment), &scene).0;
            let control = against(&truth, &sharp).pixels.rel_mse;
            scene.model.lens = None;
            for (preset, bound) in [(Preset::Exact, 0.0009), (Preset::Fast, 0.0023)] {
                scene.model.preset = preset;
                let (picture, counts) = draw(&mut renderer(device, &scene, &environment), &scene);
                assert_eq!(counts.visible, count_visible(&scene));
                let error = boxed_error(&truth, &picture);
                let rel_mse = against(&truth, &picture).pixels.rel_mse;
                println!(
                    "{preset} {radius} {ratio}: {error:.5}, relMSE {rel_mse:.6}, pinhole {control:.6}"
                );
                assert!(
                    error < bound && rel_mse < 1.5e-3,
                    "{preset}: radius {radius}, ratio {ratio}"
                );
                assert!(
                    !shows || rel_mse < 0.5 * control,
                    "{preset}: radius {radius}, ratio {ratio}: as sharp"
                );
            }
        }
    });
}

/// A flat drop is spread as it is, not as the sphere around it.
#[test]
fn flat_drops_out_of_focus_are_near_the_reference() {
    let environment = waves();
    on_device(|device| {
        for (radius, ratio) in [(5.0, 0.5), (12.0, 0.3)] {
            let mut scene = alone(radius, ratio);
            scene.drops[0].axis_ratio = Some(0.6);
            let truth = truth(&scene, &environment, 128);
            for preset in [Preset::Exact, Preset::Fast] {
                scene.model.preset = preset;
                scene.model.shape = Some(ShapeModel::Sphere);
                let round = draw(&mut renderer(device, &scene, &environment), &scene).0;
                let control = against(&truth, &round).pixels.rel_mse;
                scene.model.shape = None;
                let flat = draw(&mut renderer(device, &scene, &environment), &scene).0;
                let rel_mse = against(&truth, &flat).pixels.rel_mse;
                println!(
                    "{preset} {radius} {ratio}: relMSE {rel_mse:.5}, as a sphere {control:.5}"
                );
                assert!(rel_mse < 4e-3 && rel_mse < 0.3 * control, "{preset}: {rel_mse}");
            }
        }
    });
}

/// Light rain in a small box, in front of the focus and beyond it, and drops near the lens.
fn busy(preset: Preset) -> Scene {
    let mut scene = square(64);
    (scene.camera.vertical_fov, scene.camera.focus, scene.camera.aperture) = (70.0, 6.0, 0.3);
    scene.model.preset = preset;
    scene.rain = Some(light_rain());
    scene.drops = vec![
        moving([-4.0, 1.0, -6.0], [3.0, -2.0, 0.0], 0.5),
        moving([0.4, 3.2, -9.0], [0.0, 0.5, 6.0], 0.4),
        moving([0.3, -0.2, -0.8], [-1.0, 1.0, 2.0], 0.08),
        moving([0.3, -1.0, -0.25], [0.0, 2.0, 0.0], 0.2),
        moving([2.0, 2.0, -5.0], [0.0, 0.0, 0.0], 0.8),
    ];
    scene
}

#[test]
fn rain_out_of_focus_is_near_the_reference() {
    let environment = waves();
    on_device(|device| {
        for shutter in [0.0, 0.1] {
            let mut exposed = busy(Preset::Exact);
            exposed.camera.shutter = shutter;
            let truth = truth(&exposed, &environment, 32);
            for (preset, bound) in [(Preset::Exact, 0.002), (Preset::Fast, 0.004)] {
                let mut scene = exposed.clone();
                scene.model.preset = preset;
                let (picture, counts) = draw(&mut renderer(device, &scene, &environment), &scene);
                assert_eq!(counts.visible, count_visible(&scene));
                let error = boxed_error(&truth, &picture);
                let light = sum(&picture) / sum(&truth);
                println!("{preset} {shutter}: {error:.5}, light {light:.5}");
                assert!(error < bound && (light - 1.0).abs() < 0.004);
            }
        }
    });
}

#[test]
fn the_sky_is_seen_through_the_lens() {
    let environment = waves();
    let mut scene = square(48);
    (scene.camera.vertical_fov, scene.camera.focus, scene.camera.aperture) = (60.0, 1.0, 0.8);
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, 9.0), 0.1)];
    let truth = truth(&scene, &environment, 256);
    on_device(|device| {
        let mut renderer = renderer(device, &scene, &environment);
        let (picture, _) = draw(&mut renderer, &scene);
        let mut sharp = scene.clone();
        sharp.camera.aperture = 0.0;
        let (sharp, _) = draw(&mut renderer, &sharp);
        let (error, control) = (boxed_error(&truth, &picture), boxed_error(&truth, &sharp));
        println!("{error:.5}, pinhole {control:.5}");
        assert!(error < 0.0015 && control > 10.0 * error);
    });
}

#[test]
fn without_a_lens_a_frame_is_the_pinholes_to_the_byte() {
    let environment = waves();
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            {
                let scene = busy(preset);
                let pinhole = Scene {
                    camera: raindrops::scene::camera::Camera { aperture: 0.0, ..scene.camera },
                    ..scene.clone()
                };
                let sharp = draw(&mut renderer(device, &pinhole, &environment), &pinhole).0;
                let mut lens = renderer(device, &scene, &environment);
                let blurred = draw(&mut lens, &scene).0;
                assert!(blurred != sharp, "the control: {preset} draws no lens");
                assert!(
                    draw(&mut lens, &scene).0 == blurred,
                    "{preset}: another picture of the same scene"
                );
                assert!(draw(&mut lens, &pinhole).0 == sharp, "{preset}: aperture 0");
                let mut asked = scene.clone();
                asked.model.lens = Some(Lens::Pinhole);
                assert!(
                    draw(&mut renderer(device, &asked, &environment), &asked).0 == sharp,
                    "{preset}: asked for"
                );
                // A lens so small that no disc is as wide as a pixel.
                let mut little = scene.clone();
                (little.camera.aperture, little.drops) = (1e-5, scene.drops[..2].to_vec());
                let wide = draw(&mut renderer(device, &little, &environment), &little).0;
                let none = Scene {
                    camera: raindrops::scene::camera::Camera { aperture: 0.0, ..little.camera },
                    ..little
                };
                assert!(
                    draw(&mut renderer(device, &none, &environment), &none).0 == wide,
                    "{preset}: a tiny lens"
                );
            }
        }
        let mut paper = busy(Preset::Paper);
        (paper.model.lens, paper.model.mask_size) = (Some(Lens::Pinhole), 64);
        let mut pinhole = paper.clone();
        pinhole.camera.aperture = 0.0;
        let pictures = [&paper, &pinhole]
            .map(|scene| draw(&mut renderer(device, scene, &environment), scene).0);
        assert!(pictures[0] == pictures[1]);
    });
}

/// Drops beyond the edges of a part are drawn as far as the lens spreads them into it.
#[test]
fn a_part_through_a_lens_is_that_of_the_whole() {
    let environment = waves();
    on_device(|device| {
        let mut real = square(64);
        real.rain =
            Some(RainSettings::of(RealRain { extent: 6.0, rate: 100.0, ..RealRain::default() }));
        (real.camera.aperture, real.camera.focus, real.model.cutoff_px) = (0.02, 1.5, Some(0.2));
        for preset in [Preset::Fast, Preset::Exact] {
            for scene in [busy(preset), real.clone()] {
                let mut scene = scene;
                scene.model.preset = preset;
                let whole = draw(&mut renderer(device, &scene, &environment), &scene).0;
                scene.camera.window = [0.25, 0.375, 0.75, 0.625];
                let part = draw(&mut renderer(device, &scene, &environment), &scene).0;
                let row = |y: usize| &whole.pixels[(y + 24) * 64 + 16..(y + 24) * 64 + 48];
                let same = (0..16).all(|y| part.pixels[y * 32..(y + 1) * 32] == *row(y));
                assert!(same, "{preset}, real rain: {}", scene.real_rain().is_some());
            }
        }
    });
}

/// Images of a bare sun become discs; none of their light is lost.
#[test]
fn glints_out_of_focus_keep_their_light() {
    let mut texels = vec![Vec3::splat(0.1); 256 * 128];
    texels[40 * 256 + 90] = Vec3::splat(5e4);
    let sun = Environment::from_texels("sun", 256, 128, texels).expect("an image");
    on_device(|device| {
        for (preset, edge, radius) in [
            (Preset::Fast, 128, 3.0),
            (Preset::Fast, 128, 16.0),
            (Preset::Exact, 128, 1.0),
            (Preset::Exact, 128, 8.0),
            (Preset::Exact, 384, 110.0), // whose sun of many pixels becomes discs of thousands
        ] {
            let mut scene = before_black(edge, radius, preset);
            let mut renderer = renderer(device, &scene, &sun);
            let mut of_blur = |blur: f64| {
                scene.camera.aperture = aperture(&scene, blur);
                sum(&draw(&mut renderer, &scene).0)
            };
            let sharp = of_blur(0.0);
            for blur in [0.6, 0.9, 1.4, 12.0, 0.4 * radius] {
                let light = of_blur(blur) / sharp;
                println!("{preset} {radius} {blur}: {light:.3}");
                assert!(
                    (light - 1.0).abs() < 0.04,
                    "{preset}: radius {radius}, disc {blur}: {light}"
                );
            }
        }
    });
}

/// The rays of a sun's image in a near drop come from another depth than the drop; some places of a wide lens see images that its
/// middle does not; and a drop that moves by a quarter of its radius keeps them apart.
#[test]
fn a_sun_in_a_near_drop_is_as_wide_as_its_rays_make_it() {
    let toward = DVec3::new(0.5, 0.5, -0.7).normalize();
    let sun = painted(512, |d| Vec3::splat(if d.dot(toward) > 0.9997 { 1e3 } else { 0.1 }));
    on_device(|device| {
        // If an image is as deep as its drop, the first has 0.0063 and the last but one 0.0093; from the lens's middle the second
        // has 0.021; spread evenly the third 0.13; as bright on one side as on the other the last has 0.0056.
        let large = PlacedDrop::sphere(DVec3::new(0.4, -0.6, -5.5), 2.0);
        let by_the_sun = PlacedDrop::sphere(DVec3::new(1.6, 1.2, -3.5), 0.9);
        for (drop, aperture, focus, moved, usual) in [
            (large, 0.5, 3.0, 0.0, 0.0032),
            (large, 2.0, 60.0, 0.0, 0.0032),
            (large, 0.5, 60.0, 0.5, 0.0048),
            (by_the_sun, 0.7, 60.0, 0.0, 0.0008),
        ] {
            let mut scene = square(48);
            scene.camera.vertical_fov = 60.0;
            (scene.camera.aperture, scene.camera.focus) = (aperture, focus);
            scene.camera.shutter = 0.01;
            scene.drops =
                vec![PlacedDrop { velocity: DVec3::new(100.0, 0.0, 0.0) * moved, ..drop }];
            let truth = truth(&scene, &sun, 3072);
            for preset in [Preset::Fast, Preset::Exact] {
                scene.model.preset = preset;
                let error = boxed_error(&truth, &picture_of(device, &scene, &sun));
                println!("{preset}, aperture {aperture}, moved {moved}: {error:.4}");
                assert!(error < 1.6 * usual, "{preset}, aperture {aperture}, {moved}: {error}");
            }
        }
    });
}

/// Drops are found as far beside the view as a wide lens sees them.
#[test]
fn every_drop_that_the_lens_sees_is_found() {
    let environment = Environment::constant(Vec3::ONE);
    on_device(|device| {
        let mut boxed = busy(Preset::Fast);
        boxed.rain = boxed.rain.map(|rain| RainSettings { count: 20_000, radius: 0.01, ..rain });
        boxed.drops.clear();
        boxed.camera.aperture = 4.0;
        let mut real = square(64);
        let rain = RealRain { extent: 6.0, rate: 50.0, ..RealRain::default() };
        real.rain = Some(RainSettings::of(rain));
        (real.camera.aperture, real.camera.focus, real.model.cutoff_px) = (1.0, 1.5, Some(0.05));
        for scene in [boxed, real] {
            let plan = plan(&scene, &environment, Output::Radiance).expect("a plan");
            let found = draw(&mut renderer(device, &scene, &environment), &scene).1.visible;
            let count = |scene: &Scene| match (Field::of(scene), &plan.cutoff) {
                (Some(field), Some(cutoff)) => field.count_visible(scene, cutoff.px),
                _ => count_visible(scene),
            };
            let mut pinhole = scene.clone();
            pinhole.camera.aperture = 0.0;
            println!("{found}, through a pinhole {}", count(&pinhole));
            assert_eq!(found, count(&scene));
            assert!(found > count(&pinhole) * 11 / 10, "the control: the lens sees no more");
        }
    });
}
