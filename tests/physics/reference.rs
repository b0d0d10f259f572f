//! The ray tracer against scenes whose answer is known in closed form.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::reference::{Hit, Ray, Strata, Tracer, Truth, Weights, fade, of_scene};
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

fn scene_of(drops: &[(DVec3, f64)], edge: u32) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    scene.drops =
        drops.iter().map(|&(center, radius)| PlacedDrop::sphere(center, radius)).collect();
    (scene.image.width, scene.image.height) = (edge, edge);
    scene
}

fn rain(count: u32, edge: u32) -> Scene {
    let mut scene = Scene::default();
    // Dense enough that half of the rays meet a drop.
    let half_extent = DVec3::splat(100.0);
    scene.rain = Some(RainSettings { count, half_extent, ..RainSettings::default() });
    (scene.image.width, scene.image.height) = (edge, edge);
    scene
}

/// Top white, bottom black, bilinear between: not the same from everywhere, and known.
fn two_halves() -> Environment {
    let texels = [vec![Vec3::ONE; 4], vec![Vec3::ZERO; 4]].concat();
    Environment::from_texels("halves", 4, 2, texels).expect("a valid environment")
}

#[test]
fn a_white_furnace_stays_white() {
    let white = Environment::constant(Vec3::ONE);
    let scene = rain(20_000, 64);
    // What is left out, (1-F) F^(K+1), is at most 1/e/(K+2) of a ray's light: 0.9e-3 for K = 400.
    let truth = Truth { samples: 16, internal_reflections: 400, ..Truth::default() };
    let traced = Tracer::new(&scene, &white, truth).trace(&|_| ());
    let covered: f32 = traced.coverage.iter().sum::<f32>() / traced.coverage.len() as f32;
    assert!(covered > 0.3, "only {covered} covered: nothing was tested");
    for pixel in &traced.picture.pixels {
        assert!((*pixel - Vec3::ONE).abs().max_element() < 1e-3, "{pixel}");
    }
    // The paper's weights sum to one by themselves; light also passes on from drop to drop.
    for truth in [
        Truth { samples: 4, weights: Weights::Paper, ..truth },
        Truth { samples: 4, drops_see_drops: 2, ..truth },
    ] {
        for pixel in &Tracer::new(&scene, &white, truth).picture().pixels {
            assert!((*pixel - Vec3::ONE).abs().max_element() < 1e-3, "{truth:?} {pixel}");
        }
    }
}

/// A control for the furnace: with an order missing it must be darker, by the known amount.
#[test]
fn what_is_left_out_of_a_furnace_is_missing() {
    let white = Environment::constant(Vec3::ONE);
    // Far away, so that every point of the disc is equally likely, and it fills most of the view.
    let mut scene = scene_of(&[(DVec3::NEG_Z * 1000.0, 1.0)], 64);
    scene.camera.vertical_fov = 2.0 * (1.001e-3_f64).atan().to_degrees();
    for (internal_reflections, expected) in [(0, 0.066 + 0.882), (1, 0.066 + 0.882 + 0.044)] {
        let truth = Truth { samples: 64, internal_reflections, ..Truth::default() };
        let traced = Tracer::new(&scene, &white, truth).trace(&|_| ());
        let covered: f64 = traced.coverage.iter().map(|&c| f64::from(c)).sum();
        let missing: f64 = traced.picture.pixels.iter().map(|p| 1.0 - f64::from(p.x)).sum();
        let mean = 1.0 - missing / covered;
        assert!((mean - expected).abs() < 0.0015, "K = {internal_reflections}: {mean}");
    }
}

#[test]
fn noise_falls_as_stratified_sampling_predicts() {
    // Edges of drops that lack their reflection, before white: a step inside each edge pixel.
    let white = Environment::constant(Vec3::ONE);
    let scene =
        scene_of(&[(DVec3::new(0.2, 0.1, -2.0), 1.0), (DVec3::new(-1.5, 1.0, -3.0), 0.7)], 112);
    let noise = |samples: u32| {
        let picture = |seed| {
            let truth = Truth {
                samples,
                seed,
                reflection: false,
                internal_reflections: 0,
                ..Truth::default()
            };
            Tracer::new(&scene, &white, truth).trace(&|_| ())
        };
        let (a, b) = (picture(1), picture(2));
        let mut squares = (0.0, 0.0);
        for (((p, q), &covered), &covered_too) in
            a.picture.pixels.iter().zip(&b.picture.pixels).zip(&a.coverage).zip(&b.coverage)
        {
            let edge = (covered > 0.0 && covered < 1.0) || (covered_too > 0.0 && covered_too < 1.0);
            if edge {
                squares.0 += f64::from(p.x - q.x).powi(2);
                squares.1 += 1.0;
            }
        }
        assert!(squares.1 > 300.0, "too few edge pixels to tell");
        (squares.0 / squares.1).sqrt()
    };
    // N^(-3/4) at an edge: four times the samples, 4^(3/4) = 2.83 times less noise. With some 400
    // pixels the ratio itself is uncertain by about 5 %.
    let ratio = noise(256) / noise(1024);
    assert!((2.4..3.3).contains(&ratio), "{ratio}");
}

#[test]
fn the_picture_does_not_depend_on_the_threads() {
    let environment = two_halves();
    let scene = rain(20_000, 61);
    let truth = Truth { samples: 5, ..Truth::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| Tracer::new(&scene, &environment, truth).trace(&|_| ()))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
    // The control: another seed is another picture.
    let other = Truth { seed: 1, ..truth };
    assert_ne!(one, Tracer::new(&scene, &environment, other).trace(&|_| ()));
}

#[test]
fn an_off_axis_drop_covers_its_ellipse() {
    let white = Environment::constant(Vec3::ONE);
    let edge = 256;
    for degrees in [0.0_f64, 30.0, 45.0, 60.0] {
        let g = degrees.to_radians();
        let distance = 8.0_f64;
        let a = (1.0 / distance).asin();
        let mut scene = scene_of(&[(DVec3::new(g.sin(), 0.0, -g.cos()) * distance, 1.0)], edge);
        // Wide enough for 60° and the drop's own 7.2°.
        scene.camera.vertical_fov = 140.0;
        let truth = Truth { samples: 256, ..Truth::default() };
        let traced = Tracer::new(&scene, &white, truth).trace(&|_| ());
        let covered: f64 = traced.coverage.iter().map(|&c| f64::from(c)).sum();
        let squeeze = g.cos().powi(2) - a.sin().powi(2);
        let (radial, across) = (a.sin() * a.cos() / squeeze, a.sin() / squeeze.sqrt());
        let expected = PI * radial * across * scene.view().focal_px.powi(2);
        // Each of the perimeter's pixels errs by about 256^(-3/4) / 2 = 0.8 %, independently.
        let perimeter = 2.0 * PI * radial.max(across) * scene.view().focal_px;
        let sigma = 0.008 * perimeter.sqrt();
        assert!(
            (covered - expected).abs() < 5.0 * sigma,
            "{degrees}°: {covered} px for {expected}, σ {sigma}"
        );
    }
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let environment = two_halves();
    let mut scene = rain(3_000, 40);
    // A ray in nine meets one of these; overlapping, huge, tiny, and two exactly alike.
    for center in [DVec3::new(0.0, 3.0, -9.0), DVec3::new(0.5, 3.0, -9.0), DVec3::X * 50.0] {
        scene.drops.push(PlacedDrop::sphere(center, 2.0));
        scene.drops.push(PlacedDrop::sphere(center, 2.0));
        scene.drops.push(PlacedDrop::sphere(center * 0.5, 1e-3));
    }
    let tracer = Tracer::new(&scene, &environment, Truth { samples: 1, ..Truth::default() });
    let drops = of_scene(&scene).all;
    let view = scene.view();
    let mut candidates = Vec::new();
    let mut met = 0;
    for tile in 0..25 {
        let (left, upper) = (f64::from(tile % 5 * 8), f64::from(tile / 5 * 8));
        let corner = |x: f64, y: f64| view.ray(left + x, upper + y);
        let pyramid = raindrops::reference::Pyramid::between([
            corner(0.0, 0.0),
            corner(8.0, 0.0),
            corner(8.0, 8.0),
            corner(0.0, 8.0),
        ]);
        tracer.tree().within(&pyramid, f64::INFINITY, &mut candidates);
        for step in 0..400 {
            let direction = corner(f64::from(step % 20) * 0.421, f64::from(step / 20) * 0.421);
            let mut after = Hit::START;
            for _ in 0..3 {
                let brute = drops
                    .iter()
                    .zip(0..)
                    .filter_map(|(drop, number)| {
                        let along = drop.center.dot(direction);
                        let beside2 = drop.center.cross(direction).length_squared();
                        let depth2 = drop.radius.powi(2) - beside2;
                        (along > 0.0 && depth2 >= 0.0)
                            .then(|| Hit { distance: along - depth2.sqrt(), drop: number })
                    })
                    .filter(|hit| hit.distance > after.distance + 1e-9 || after == Hit::START)
                    .fold(Hit::NONE, |a, b| if b < a { b } else { a });
                let found = tracer.tree().first_hit(&Ray::along(direction), after, None);
                let in_tile =
                    tracer.tree().first_hit_of(&candidates, &Ray::along(direction), after);
                assert_eq!(found, in_tile);
                assert!(
                    found == brute || (found.distance - brute.distance).abs() < 1e-6,
                    "{found:?} is not {brute:?}"
                );
                if found == Hit::NONE {
                    break;
                }
                met += 1;
                // Past every drop at the same place, as the brute force does.
                after = Hit { distance: found.distance, drop: u32::MAX };
            }
        }
    }
    assert!(met > 1000, "only {met} hits: nothing was tested");
}

#[test]
fn a_single_ray_has_the_radiance_of_the_formula() {
    let environment = two_halves();
    let scene = scene_of(&[(DVec3::new(0.0, 0.4, -3.0), 1.0)], 16);
    let ray =
        raindrops::optics::Intersection::of_ray(DVec3::NEG_Z, DVec3::new(0.0, 0.4, -3.0), 1.0)
            .expect("a hit");
    let reflectance = ray.reflectance();
    let radiance = |truth| Tracer::new(&scene, &environment, truth).radiance_along(DVec3::NEG_Z);
    let physical = Truth { internal_reflections: 1, ..Truth::default() };
    let reflected = reflectance * environment.radiance(ray.reflected());
    let expected = reflected
        + (1.0 - reflectance).powi(2) * environment.radiance(ray.transmitted())
        + (1.0 - reflectance).powi(2)
            * reflectance
            * environment.radiance(ray.after_internal_reflections(1));
    assert!((radiance(physical) - expected).length() < 1e-14);
    let paper = Truth { weights: Weights::Paper, ..physical };
    let expected = reflected + (1.0 - reflectance) * environment.radiance(ray.transmitted());
    assert!((radiance(paper) - expected).length() < 1e-14);
    let without = Truth { reflection: false, ..paper };
    assert!((radiance(without) - (expected - reflected)).length() < 1e-14);
}

#[test]
fn drops_near_the_camera_fade_and_vanish() {
    assert_eq!([fade(0.9, 1.0, 2.0), fade(2.0, 1.0, 2.0), fade(3.0, 1.0, 2.0)], [0.0, 0.5, 1.0]);
    assert_eq!([fade(0.9, 1.0, 0.0), fade(1.0, 1.0, 0.0)], [0.0, 1.0]);

    let white = Environment::constant(Vec3::ONE);
    let truth = Truth { internal_reflections: 0, ..Truth::default() };
    let radiance = |scene: &Scene| Tracer::new(scene, &white, truth).radiance_along(DVec3::NEG_Z).x;
    let (front, back) = ((DVec3::NEG_Z * 2.0, 0.5), (DVec3::NEG_Z * 9.0, 0.5));
    let drop = radiance(&scene_of(&[front], 8));
    assert!(drop < 0.99, "a drop without its internal reflections is darker");
    // Within the drop, or nearer than `near`: not drawn.
    assert_eq!(radiance(&scene_of(&[(DVec3::NEG_Z * 0.4, 0.5)], 8)), 1.0);
    let mut scene = scene_of(&[front], 8);
    scene.camera.near = 2.1;
    assert_eq!(radiance(&scene), 1.0);
    // Half faded in: half of it, and half of what is behind.
    let mut scene = scene_of(&[front, back], 8);
    (scene.camera.near, scene.camera.near_fade) = (1.0, 2.0);
    assert!((radiance(&scene) - drop).abs() < 1e-12);
    scene.drops.pop();
    assert!((radiance(&scene) - 0.5 * (1.0 + drop)).abs() < 1e-12);
}

#[test]
fn a_drop_behind_a_drop_is_seen_only_when_asked_for() {
    let environment = two_halves();
    // The axial ray goes straight through the first into the second, which lies off the axis.
    let scene = scene_of(&[(DVec3::NEG_Z * 3.0, 1.0), (DVec3::new(0.0, -0.7, -6.0), 1.0)], 8);
    let radiance = |drops_see_drops| {
        let truth = Truth { drops_see_drops, ..Truth::default() };
        Tracer::new(&scene, &environment, truth).radiance_along(DVec3::NEG_Z)
    };
    // Straight on and straight back see the horizon, 1/2; the second drop bends that upwards or
    // downwards.
    assert!((radiance(0).x - 0.5).abs() < 1e-6);
    assert!((radiance(1).x - 0.5).abs() > 0.05, "{}", radiance(1));
}

#[test]
fn strata_fill_the_pixel_evenly_for_any_number() {
    for samples in [1, 2, 3, 7, 16, 30, 64, 97, 256] {
        let strata = Strata::new(samples, 9);
        let places: Vec<_> = strata.places(5).collect();
        assert_eq!(places.len(), samples as usize);
        assert!(places.iter().all(|&(x, y)| x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0));
        // Unbiased: the mean over many pixels is the middle. σ of a uniform is 0.29.
        let count = 4096 * samples;
        let sum = (0..4096)
            .flat_map(|pixel| strata.places(pixel).collect::<Vec<_>>())
            .fold((0.0, 0.0), |sum, place| (sum.0 + place.0, sum.1 + place.1));
        for mean in [sum.0, sum.1].map(|sum| sum / f64::from(count)) {
            assert!((mean - 0.5).abs() < 5.0 * 0.29 / f64::from(count).sqrt(), "{samples} {mean}");
        }
    }
}
