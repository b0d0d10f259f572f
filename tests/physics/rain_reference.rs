//! The reference of real rain: against the optical depth and the noise that the laws say, against itself where two
//! ways must agree. What is expected is written out here.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::optics::Shape;
use raindrops::picture::Picture;
use raindrops::picture::plate::{Depth, Plate};
use raindrops::rain::shape::Halves;
use raindrops::reference::{Traced, Tracer, Truth, Weights};
use raindrops::scene::background::DepthKind;
use raindrops::scene::camera::Camera;
use raindrops::scene::model::DropShape;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

/// Spheres of real rain to `extent` metres, seen level.
pub fn raining(rate: f64, extent: f64, edge: u32, vertical_fov: f64) -> Scene {
    let rain = RealRain { rate, extent, shape: DropShape::Sphere, ..RealRain::default() };
    Scene {
        rain: Some(RainSettings::of(rain)),
        image: ImageSize { width: edge, height: edge },
        camera: Camera { vertical_fov, ..Camera::default() },
        ..Scene::default()
    }
}

pub fn with_rain(mut scene: Scene, change: impl FnOnce(&mut RealRain)) -> Scene {
    let mut rain = scene.real_rain().expect("real rain");
    change(&mut rain);
    scene.rain = Some(RainSettings::of(rain));
    scene
}

pub fn traced(scene: &Scene, environment: &Environment, truth: Truth) -> Traced {
    scene.validate("test").expect("a valid scene");
    Tracer::new(scene, environment, truth).trace(&|_| ())
}

pub fn opacities(scene: &Scene, samples: u32, rain_to: Option<f64>, seed: u64) -> Vec<f64> {
    let truth = Truth { samples, rain_to, seed, internal_reflections: 0, ..Truth::default() };
    let white = Environment::constant(Vec3::ONE);
    traced(scene, &white, truth).opacity.iter().map(|&share| f64::from(share)).collect()
}

/// Mean and its standard error, of values that do not depend on each other.
fn mean(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.into_iter().collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (square / count / (count - 1.0)).sqrt())
}

/// Means over columns of pixels: streaks along the columns leave those independent.
fn columns(values: &[f64], edge: usize) -> Vec<f64> {
    let column = |x: usize| values.iter().skip(x).step_by(edge).sum::<f64>() / edge as f64;
    (0..edge).map(column).collect()
}

/// The rain takes away what its optical depth says, at any rate and field of view, by drops or as a medium.
#[test]
fn the_mean_opacity_is_that_of_the_optical_depth() {
    let [black, white] = [Vec3::ZERO, Vec3::ONE].map(Environment::constant);
    // Extinction a metre of the sizes from 0.25 to 6 mm. In a wide view fewer metres hold as many drops.
    for (rate, extinction, views) in [
        (5.0, 4.102e-4, &[(40.0, 30.0)][..]),
        (25.0, 1.208e-3, &[(100.0, 14.0)]),
        (100.0, 3.183e-3, &[(8.0, 30.0)]),
    ] {
        for &(fov, extent) in views {
            let scene = raining(rate, extent, 64, fov);
            let expected = 1.0 - (-extinction * extent).exp();
            for rain_to in [extent, 0.4 * extent] {
                let truth = Truth { samples: 6, rain_to: Some(rain_to), ..Truth::default() };
                let plate = Picture { width: 64, height: 64, pixels: vec![Vec3::ONE; 64 * 64] };
                let tracer = Tracer::new(&scene, &black, truth);
                let picture = tracer.before(Plate::new(Some(plate), None)).picture();
                let (opacity, error) = mean(picture.pixels.iter().map(|p| 1.0 - f64::from(p.x)));
                assert!(
                    (opacity - expected).abs() < 4.0 * error,
                    "{rate} mm/h, {fov} degrees, drops to {rain_to} m: {opacity} ± {error}, not {expected}"
                );
                assert!(error < 0.08 * expected, "{error}: nothing is told");
            }
            // Without a drop there is no noise: to the digits of the table.
            let medium = opacities(&scene, 1, Some(0.0), 0);
            assert!(medium.iter().all(|share| (share / expected - 1.0).abs() < 4e-4), "{rate}");
        }
    }
    // White before black: what is taken away comes back as the drops' light.
    let scene = raining(25.0, 30.0, 64, 8.0);
    let truth = Truth { samples: 16, rain_to: Some(12.0), ..Truth::default() };
    let plate = Picture { width: 64, height: 64, pixels: vec![Vec3::ZERO; 64 * 64] };
    let picture =
        Tracer::new(&scene, &white, truth).before(Plate::new(Some(plate), None)).picture();
    let (light, error) = mean(picture.pixels.iter().map(|p| f64::from(p.x)));
    assert!((light - 0.03559).abs() < 4.0 * error, "{light} ± {error}");
}

#[test]
fn nothing_shows_in_a_white_furnace() {
    let white = Environment::constant(Vec3::ONE);
    let mut scene = with_rain(raining(100.0, 200.0, 24, 60.0), |rain| {
        rain.shape = DropShape::Equilibrium;
    });
    scene.camera.shutter = 1.0 / 250.0;
    let truth =
        Truth { samples: 64, rain_to: Some(6.0), weights: Weights::Conserving, ..Truth::default() };
    let found = traced(&scene, &white, truth);
    let worst = |traced: &Traced| {
        let pixels = traced.picture.pixels.iter();
        pixels.map(|pixel| (*pixel - Vec3::ONE).abs().max_element()).fold(0.0, f32::max)
    };
    let drops = opacities(&with_rain(scene.clone(), |rain| rain.extent = 6.0), 64, None, 0);
    assert!(found.opacity.iter().all(|share| *share > 0.3) && drops.iter().any(|d| *d > 0.0));
    assert!(worst(&found) < 1e-6, "{}", worst(&found));
    // The control: what leaves after more than no internal reflections is missed.
    let physical = Truth { weights: Weights::Physical, internal_reflections: 0, ..truth };
    assert!(worst(&traced(&scene, &white, physical)) > 0.01);
}

/// Number of drops of an equal share of the law, by a sum: Marshall and Palmer's N(D) at 25 mm/h.
fn over_sizes(of_diameter: impl Fn(f64) -> f64) -> f64 {
    let (slope, steps) = (4.1 * 25_f64.powf(-0.21), 2000);
    let intercept = 8000.0 * 0.886_302;
    let width = (6.0 - 0.25) / f64::from(steps);
    (0..steps)
        .map(|step| 0.25 + (f64::from(step) + 0.5) * width)
        .map(|d| intercept * (-slope * d).exp() * of_diameter(d) * width)
        .sum()
}

/// The variance is of a pixel's opacity; the two pictures of other seeds share the rain, but no sample.
#[test]
fn a_pixel_is_as_noisy_as_its_drops_make_it() {
    const EDGE: u32 = 128;
    let focal = 886.81;
    let fov = 2.0 * (0.5 * f64::from(EDGE) / focal).atan().to_degrees();
    let (near, far) = (10.0, 40.0);
    // By size and depth: g for the streak, the last factors for the drop's own width and height.
    let formula = |shutter: f64| {
        let variance = over_sizes(|d| {
            let speed = raindrops::rain::fall::terminal_speed(d, 1.2);
            let steps = 400;
            let width = (far - near) / f64::from(steps);
            (0..steps)
                .map(|step| {
                    let z = near + (f64::from(step) + 0.5) * width;
                    let (r, streak) = (focal * 0.5e-3 * d / z, focal * speed * shutter / z);
                    let g = if streak <= 1.0 {
                        1.0 - streak / 3.0
                    } else {
                        1.0 / streak - 1.0 / (3.0 * streak * streak)
                    };
                    let size = PI.sqrt() * r / 3.0;
                    let share = PI * r * r;
                    let volume = (z / focal).powi(2) * width;
                    share * share * g * (1.0 - size) * (1.0 - size / streak.max(1.0)) * volume
                })
                .sum()
        });
        variance.sqrt() * (-1.208e-3 * far).exp()
    };
    for shutter in [0.0, 1.0 / 60.0] {
        let mut scene = raining(25.0, far, EDGE, fov);
        (scene.camera.near, scene.camera.shutter) = (near, shutter);
        let (mut product, mut sum, mut count) = (0.0, 0.0, 0.0);
        for rain in 0..2 {
            let scene = Scene { seed: 11 + rain, ..scene.clone() };
            let [a, b] = [0, 1].map(|seed| opacities(&scene, 64, None, seed));
            product += a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>();
            sum += a.iter().chain(&b).sum::<f64>() / 2.0;
            count += a.len() as f64;
        }
        let found = (product / count - (sum / count).powi(2)).sqrt();
        let expected = formula(shutter);
        println!("shutter {shutter}: {found}, by the formula {expected}");
        assert!((found / expected - 1.0).abs() < 0.05, "{found}, not {expected}");
    }
}

/// Drops to 8 m and the medium from there show on the mean what drops to 24 m show.
#[test]
fn the_medium_stands_for_the_drops() {
    // Behind the rain it is darker than what drops gather.
    let environment = crate::common::painted(64, |d| Vec3::splat(1.0 + 0.9 * d.z as f32));
    let mut scene = with_rain(raining(100.0, 24.0, 64, 25.0), |rain| {
        rain.shape = DropShape::Equilibrium;
    });
    for target in [DVec3::NEG_Z, DVec3::new(0.0, 0.7, -0.7)] {
        scene.camera.target = target;
        let picture = |scene: &Scene, rain_to: f64| {
            let truth = Truth { samples: 8, rain_to: Some(rain_to), ..Truth::default() };
            traced(scene, &environment, truth).picture
        };
        let [by_drops, by_medium] = [24.0, 8.0].map(|bound| picture(&scene, bound));
        let nearer = picture(&with_rain(scene.clone(), |rain| rain.extent = 8.0), 8.0);
        // Two thirds of the rain against none, and how far the pictures are apart by chance.
        let difference = |a: &Picture, b: &Picture| {
            let values = a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from((*a - *b).y));
            mean(columns(&values.collect::<Vec<_>>(), 64))
        };
        let (off, error) = difference(&by_medium, &by_drops);
        assert!(off.abs() < 4.0 * error, "{off} ± {error}");
        let (missing, _) = difference(&nearer, &by_drops);
        assert!(missing.abs() > 12.0 * error, "{missing} against {error}: nothing is told");
    }
}

/// A mask has the drops that are traced one by one, and not the medium that is everywhere.
#[test]
fn the_medium_covers_nothing() {
    let white = Environment::constant(Vec3::ONE);
    let rainy = |extent, rain_to| {
        let truth = Truth { samples: 16, rain_to: Some(rain_to), ..Truth::default() };
        traced(&raining(25.0, extent, 64, 8.0), &white, truth)
    };
    let (with, without, medium) = (rainy(30.0, 8.0), rainy(8.0, 8.0), rainy(30.0, 0.0));
    assert_eq!(with.coverage, without.coverage);
    assert!(with.coverage.iter().any(|&share| share > 0.0), "no drop is seen");
    assert!(with.opacity.iter().zip(&with.coverage).all(|(opacity, share)| opacity > share));
    assert!(medium.coverage.iter().all(|&share| share == 0.0));
    assert!(medium.opacity.iter().all(|&share| share > 0.03));
    assert_eq!(without.opacity, without.coverage);
}

/// The medium's light goes on evenly from one pixel to the next, within a tile and across its edges.
#[test]
fn a_narrow_tile_has_the_light_of_its_pixels() {
    let environment = crate::common::painted(64, |d| Vec3::splat(1.0 + 0.9 * d.x as f32));
    let scene = raining(25.0, 1e5, 64, 6.0);
    let truth = Truth { samples: 64, rain_to: Some(0.0), ..Truth::default() };
    let picture = traced(&scene, &environment, truth).picture;
    let light: Vec<f64> = picture.pixels.iter().map(|pixel| f64::from(pixel.x)).collect();
    let columns = columns(&light, 64);
    let step = |from: usize| (columns[from + 7] - columns[from]) / 7.0;
    let within = (0..8).map(|tile| step(8 * tile)).sum::<f64>() / 8.0;
    let tile = |number: usize| columns[8 * number..8 * number + 8].iter().sum::<f64>() / 8.0;
    let from_tile_to_tile = (tile(7) - tile(0)) / 56.0;
    assert!(from_tile_to_tile > 2e-4, "{from_tile_to_tile}");
    assert!((within / from_tile_to_tile - 1.0).abs() < 0.3, "{within} {from_tile_to_tile}");
}

/// The medium's outline against one that is counted in rays, and its optical depth against a sum over sizes.
#[test]
fn flat_drops_block_what_they_cover() {
    let outline = |diameter: f64, toward: DVec3| {
        let Halves { joint, equatorial, top, bottom } = Halves::of_diameter(diameter);
        let shape = Shape::Halves { equatorial, top, bottom, joint };
        let (u, v) = toward.any_orthonormal_pair();
        let steps = 300;
        let at = |step: i32| 1.5 * (2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0);
        let met = (0..steps * steps)
            .filter(|n| shape.cross(at(n % steps) * u + at(n / steps) * v, toward).is_some())
            .count();
        9.0 * met as f64 / f64::from(steps * steps) / PI
    };
    for sine in [0.0_f64, 0.5, -0.9, 1.0] {
        let toward = DVec3::new((1.0 - sine * sine).sqrt(), sine, 0.0);
        for diameter in [1.5, 3.0, 5.5] {
            let found = Halves::of_diameter(diameter).outline_area(sine);
            let expected = outline(diameter, toward);
            assert!((found / expected - 1.0).abs() < 2e-3, "{diameter} {sine}: {found} {expected}");
        }
    }
    for target in [DVec3::NEG_Z, DVec3::Y, DVec3::new(0.0, -0.7, -0.7)] {
        let mut scene = with_rain(raining(25.0, 100.0, 1, 0.1), |rain| {
            rain.shape = DropShape::Equilibrium;
        });
        scene.camera.target = target;
        let found = -(1.0 - opacities(&scene, 1, Some(0.0), 0)[0]).ln() / 100.0;
        let toward = target.normalize();
        let rows: Vec<f64> =
            (0..24).map(|d| outline(0.25 * f64::from(d) + 0.125, toward)).collect();
        let expected = over_sizes(|d| {
            0.25e-6 * PI * d * d * if d < 1.0 { 1.0 } else { rows[(4.0 * d) as usize] }
        });
        assert!((found / expected - 1.0).abs() < 3e-3, "{target}: {found}, not {expected}");
    }
}

/// A background ends the rain before it: drops and medium.
#[test]
fn a_plate_ends_the_rain_at_its_depth() {
    let white = Environment::constant(Vec3::ONE);
    let scene = raining(25.0, 100.0, 64, 40.0);
    for (kind, rain_to) in
        [(DepthKind::Radial, 40.0), (DepthKind::Radial, 8.0), (DepthKind::Planar, 8.0)]
    {
        let plate = Plate::new(None, Some(Depth { values: vec![20.0; 64 * 64], kind }));
        let truth = Truth { samples: 16, rain_to: Some(rain_to), ..Truth::default() };
        let found = Tracer::new(&scene, &white, truth).before(plate).trace(&|_| ());
        let (opacity, error) = mean(found.opacity.iter().map(|&share| f64::from(share)));
        let expected = match kind {
            DepthKind::Radial => 1.0 - (-1.208e-3 * 20.0_f64).exp(),
            // The mean of 20 / cos over the picture's pixels.
            DepthKind::Planar => {
                let edge = |n: i32| (f64::from(n) + 0.5 - 32.0) / 32.0 * 20_f64.to_radians().tan();
                let pixel = |n: i32| (1.0 + edge(n % 64).powi(2) + edge(n / 64).powi(2)).sqrt();
                let sum: f64 = (0..4096).map(|n| 1.0 - (-1.208e-3 * 20.0 * pixel(n)).exp()).sum();
                sum / 4096.0
            }
        };
        assert!((opacity - expected).abs() < 4.0 * error, "{opacity} ± {error}, not {expected}");
        assert!(error < 0.05 * expected);
    }
}

/// Bright parts spread over small drops and over the medium are as much light as samples meet by chance.
#[test]
fn a_sun_shines_as_much_as_by_chance() {
    let toward = DVec3::new(0.3, 0.5, 0.8).normalize();
    let environment = crate::common::painted(256, |d| {
        let disc = if d.angle_between(toward) < 4_f64.to_radians() { 300.0 } else { 0.0 };
        Vec3::new(disc, 0.8 * disc, 0.5 * disc) + Vec3::splat(1.0 + 0.5 * d.y as f32)
    });
    assert!(split(&environment).is_some());
    let mut scene = raining(25.0, 2000.0, 48, 90.0);
    scene.camera.target = DVec3::new(0.0, -0.3, -1.0);
    for (rain_to, extent) in [(0.0, 2000.0), (5.0, 5.0)] {
        let scene = with_rain(scene.clone(), |rain| rain.extent = extent);
        let picture = |glints: bool, samples: u32, seed: u64| {
            let truth = Truth { glints, samples, seed, rain_to: Some(rain_to), ..Truth::default() };
            traced(&scene, &environment, truth).picture
        };
        let [sure, chance] = [picture(true, 64, 0), picture(false, 1024, 1)];
        // By quarters of the picture, so that light in a wrong place would be seen.
        for quarter in 0..4 {
            let of = |picture: &Picture| {
                let pixels = picture.pixels.iter().enumerate();
                let own = pixels.filter(|(n, _)| n / 48 / 24 * 2 + n % 48 / 24 == quarter);
                mean(own.map(|(_, pixel)| f64::from(pixel.x)))
            };
            let ((a, of_a), (b, of_b)) = (of(&sure), of(&chance));
            println!("to {rain_to} m: {a} ± {of_a}, by chance {b} ± {of_b}");
            let difference = sure.pixels.iter().zip(&chance.pixels).enumerate();
            let own = difference.filter(|(n, _)| n / 48 / 24 * 2 + n % 48 / 24 == quarter);
            let (off, error) = mean(own.map(|(_, (a, b))| f64::from(a.x - b.x)));
            assert!(off.abs() < 4.0 * error, "quarter {quarter}: {off} ± {error}");
        }
    }
}

/// Drops placed by hand are in the rain, and the rain is before and behind them.
#[test]
fn placed_drops_stand_in_the_rain() {
    let white = Environment::constant(Vec3::ONE);
    let mut scene = raining(100.0, 12.0, 32, 40.0);
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, -6.0), 0.8)];
    let found = traced(&scene, &white, Truth { samples: 16, ..Truth::default() });
    assert_eq!(found.coverage[16 * 32 + 16], 1.0);
    assert!(found.coverage[33] < 0.5);
    // The drop without its internal reflections is darker; the rain before it is darker again by its share.
    let truth =
        Truth { samples: 16, internal_reflections: 0, reflection: false, ..Truth::default() };
    let dark =
        |scene: &Scene| f64::from(traced(scene, &white, truth).picture.pixels[16 * 32 + 16].x);
    let alone = Scene { rain: None, ..scene.clone() };
    assert!((dark(&scene) - dark(&alone)).abs() < 0.05);
}
