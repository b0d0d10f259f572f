//! Drops that are no spheres, drawn: against the reference, in a white furnace, beside spheres, in motion.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::rel_mse;
use raindrops::plan::{FramePlan, Output, plan};
use raindrops::reference::{Traced, Tracer, Truth};
use raindrops::scene::model::{DropShape, Preset, ShapeModel, Weights};
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use crate::common::picture::picture_of;
use crate::common::{on_device, painted};

/// A few low waves in colour: no texel that rules all errors.
fn waves() -> Environment {
    painted(256, |d| {
        let wave =
            |k: f64, turn: f64| ((k * d.x + turn).sin() + (k * d.y).cos() + (k * d.z).sin()) as f32;
        Vec3::new(wave(3.0, 0.3), wave(4.0, 1.1), wave(5.0, 2.2)).exp()
    })
}

/// A drop of `pixels` of radius, 60 radii away, seen along a direction that rises by so many degrees; 2 mm a unit.
fn one(drop: PlacedDrop, elevation: f64, pixels: f64) -> Scene {
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let toward = DVec3::new(0.6 * cosine, sine, -0.8 * cosine);
    let edge = (2.6 * pixels).ceil() as u32 + 6;
    let mut scene = Scene { rain: None, metres: 0.002, ..Scene::default() };
    scene.image = ImageSize { width: edge, height: edge };
    scene.camera.position = DVec3::ZERO;
    scene.camera.target = toward;
    scene.camera.vertical_fov = 2.0 * (0.5 * f64::from(edge) / (60.0 * pixels)).atan().to_degrees();
    let view = scene.view();
    let center = 60.0 * drop.radius * toward + 0.3 * drop.radius * (view.right - 0.5 * view.up);
    scene.drops = vec![PlacedDrop { center, ..drop }];
    scene
}

fn spheroid(axis_ratio: f64) -> PlacedDrop {
    PlacedDrop { axis_ratio: Some(axis_ratio), ..PlacedDrop::default() }
}

/// In the equilibrium shape, of a diameter in mm.
fn falling(mm: f64) -> PlacedDrop {
    PlacedDrop { shape: Some(DropShape::Equilibrium), radius: mm / 4.0, ..PlacedDrop::default() }
}

fn planned(scene: &Scene, environment: &Environment) -> FramePlan {
    plan(scene, environment, Output::Radiance).expect("a plan")
}

fn reference(scene: &Scene, environment: &Environment) -> Traced {
    Tracer::new(scene, environment, Truth { samples: 64, ..Truth::default() }).trace(&|_| ())
}

/// relMSE over the pixels that drops are in.
fn error(expected: &Traced, found: &Picture) -> f64 {
    rel_mse(&expected.picture, found, Some(&expected.coverage))
}

#[test]
fn flat_drops_are_near_the_reference() {
    let sky = waves();
    on_device(|device| {
        for (drop, elevation, pixels) in [
            (spheroid(0.64), 0.0, 20.0),
            (spheroid(0.64), 45.0, 20.0),
            (spheroid(0.8), -60.0, 12.0),
            (spheroid(0.95), 10.0, 3.0),
            (spheroid(1.5), 20.0, 12.0),
            (falling(3.0), 0.0, 20.0),
            (falling(6.0), 50.0, 20.0),
            (falling(5.0), -70.0, 6.0),
            (falling(4.0), 0.0, 0.7),
        ] {
            let mut scene = one(drop, elevation, pixels);
            scene.model.preset = Preset::Exact;
            scene.model.samples = Some(64);
            let expected = reference(&scene, &sky);
            let found = error(&expected, &picture_of(device, &scene, &sky));
            // The control: drawn as a sphere.
            scene.model.shape = Some(ShapeModel::Sphere);
            let round = error(&expected, &picture_of(device, &scene, &sky));
            println!("{drop:?} {elevation}°, {pixels} px: {found:.5}, as a sphere {round:.4}");
            assert!(found < 5e-3, "{drop:?} {elevation}°, {pixels} px: {found}");
            assert!(round > 2.0 * found, "{drop:?} {elevation}°: a sphere is as near: {round}");
        }
    });
}

#[test]
fn a_stretched_picture_is_nearer_than_a_sphere() {
    let sky = waves();
    on_device(|device| {
        for (preset, pixels) in [(Preset::Exact, 16.0), (Preset::Fast, 6.0)] {
            let mut scene = one(spheroid(0.8), 20.0, pixels);
            scene.model.preset = preset;
            let expected = reference(&scene, &sky);
            let [round, stretched] = [ShapeModel::Sphere, ShapeModel::Stretched].map(|model| {
                scene.model.shape = Some(model);
                error(&expected, &picture_of(device, &scene, &sky))
            });
            println!("{preset}, {pixels} px: stretched {stretched:.4}, sphere {round:.4}");
            assert!(stretched < 0.8 * round, "{preset}, {pixels} px: {stretched}, {round}");
        }
    });
}

#[test]
fn a_furnace_stays_white_at_every_axis_ratio() {
    let white = Environment::constant(Vec3::ONE);
    on_device(|device| {
        let ratios = [0.1, 0.3, 0.64, 0.9, 1.4, 5.0].map(spheroid);
        for drop in ratios.into_iter().chain([falling(3.0), falling(6.0)]) {
            for bubble in [false, true] {
                let mut scene = one(drop, 30.0, 12.0);
                if bubble {
                    scene.water.index = Some(Index::One(1.0));
                    scene.water.outside = 1.33;
                }
                scene.model.preset = Preset::Exact;
                scene.model.samples = Some(4);
                scene.model.weights = Some(Weights::Conserving);
                let found = picture_of(device, &scene, &white);
                let off = |pixel: &Vec3| (*pixel - Vec3::ONE).abs().max_element();
                let worst = found.pixels.iter().map(off).fold(0.0, f32::max);
                assert!(worst < 4e-3, "{drop:?}, bubble {bubble}: off white by {worst}");
            }
        }
        // The control: with one order and nothing after it light is missing.
        let mut scene = one(spheroid(0.64), 45.0, 12.0);
        scene.model.preset = Preset::Exact;
        scene.model.internal_reflections = Some(1);
        let found = picture_of(device, &scene, &white);
        let least = found.pixels.iter().map(|pixel| pixel.x).fold(1.0, f32::min);
        assert!(least < 0.95, "nothing is lost: {least}");
    });
}

/// Beside the camera no outline is an ellipse; within the reach of a flat drop, but outside of it, it is seen too.
#[test]
fn near_the_camera_rays_tell_where_a_drop_is() {
    let sky = waves();
    on_device(|device| {
        for (center, drop) in [
            ([0.9, -0.6, -0.4], spheroid(0.5)),
            ([0.2, -0.9, -0.3], falling(6.0)),
            ([0.6, 0.0, -0.35], spheroid(6.0)),
        ] {
            let mut scene = one(drop, 0.0, 8.0);
            scene.image = ImageSize { width: 48, height: 48 };
            scene.camera.target = DVec3::NEG_Z;
            scene.camera.vertical_fov = 90.0;
            scene.camera.near = 0.01;
            scene.drops = vec![PlacedDrop { center: center.into(), radius: 0.7, ..drop }];
            scene.model.preset = Preset::Exact;
            let expected = reference(&scene, &sky);
            let covered = expected.coverage.iter().filter(|covered| **covered > 0.5).count();
            assert!(covered > 100, "{drop:?}: {covered} pixels, too few to tell");
            let found = picture_of(device, &scene, &sky);
            let error = rel_mse(&expected.picture, &found, None);
            println!("{drop:?}: {error:.4}");
            assert!(error < 0.03, "{drop:?}: {error}");
        }
    });
}

#[test]
fn flat_drops_that_move_are_near_the_reference() {
    let sky = waves();
    on_device(|device| {
        for (drop, velocity) in [
            (falling(5.0), DVec3::new(0.0, -4.0, 0.0)),
            (spheroid(0.7), DVec3::new(2.0, 1.0, 0.0)),
            // Towards the camera, so that the outline does not move evenly.
            (falling(6.0), DVec3::new(-30.0, 0.0, 40.0)),
        ] {
            let mut scene = one(PlacedDrop { velocity, ..drop }, 0.0, 10.0);
            scene.camera.shutter = 0.6;
            scene.model.preset = Preset::Exact;
            scene.model.samples = Some(64);
            let expected = reference(&scene, &sky);
            let found = error(&expected, &picture_of(device, &scene, &sky));
            scene.model.shape = Some(ShapeModel::Sphere);
            let round = error(&expected, &picture_of(device, &scene, &sky));
            println!("{drop:?} {velocity}: {found:.5}, as a sphere {round:.4}");
            assert!(found < 5e-3 && round > 2.0 * found, "{drop:?} {velocity}: {found}, {round}");
        }
    });
}

/// What each row of a picture has more of, in all, than that of another.
fn more_by_row(picture: &Picture, other: &Picture) -> Vec<f64> {
    let width = picture.width as usize;
    let rows = picture.pixels.chunks(width).zip(other.pixels.chunks(width));
    rows.map(|(a, b)| a.iter().zip(b).map(|(a, b)| f64::from(a.y - b.y)).sum()).collect()
}

/// A drop of 8 pixels of radius in a high picture, seen for 1.5 seconds along a direction that rises by so many degrees.
fn exposed(drop: PlacedDrop, elevation: f64) -> Scene {
    let mut scene = one(drop, elevation, 8.0);
    scene.camera.vertical_fov *= 4.0;
    scene.image.height *= 4;
    scene.camera.shutter = 1.5;
    scene
}

#[test]
fn a_lamp_draws_a_line_along_a_flat_drop_that_moves() {
    let toward = DVec3::new(0.85, 0.1, -0.5);
    let lamp = |light: f32| {
        painted(256, |d| Vec3::splat(if d.angle_between(toward) < 0.03 { light } else { 0.1 }))
    };
    let (lit, dark) = (lamp(300.0), lamp(0.1));
    let falling = PlacedDrop { velocity: DVec3::new(0.3, -4.0, 0.4), ..falling(5.0) };
    let mut scene = exposed(falling, 0.0);
    // Rows in which all of the drop is seen for a part of the exposure.
    let whole = 62..86;
    let count = whole.len() as f64;
    on_device(|device| {
        for blur in [0.0, 1.0, 4.0] {
            // A point at half the distance in focus is a disc of f A / 4z pixels of radius; f is 480 pixels.
            let depth = scene.drops[0].center.length();
            (scene.camera.aperture, scene.camera.focus) = (blur * depth / 120.0, 2.0 * depth);
            // With 64 samples a pixel the lamp's light in those rows was off by a quarter.
            let truth = Truth { samples: 1_500, ..Truth::default() };
            let traced = Tracer::new(&scene, &lit, truth).trace(&|_| ()).picture;
            for preset in [Preset::Fast, Preset::Exact] {
                scene.model.preset = preset;
                let [with, without] = [&lit, &dark].map(|sky| picture_of(device, &scene, sky));
                let found = &more_by_row(&with, &without)[whole.clone()];
                let mean = found.iter().sum::<f64>() / count;
                let expected =
                    more_by_row(&traced, &without)[whole.clone()].iter().sum::<f64>() / count;
                let squares = found.iter().map(|row| (row - mean).powi(2)).sum::<f64>();
                let spread = (squares / count).sqrt();
                let case = format!("{preset:?}, blur {blur}: {mean:.3} +- {spread:.3}");
                println!("{case}, traced {expected:.3}");
                assert!((mean / expected - 1.0).abs() < 0.2, "{case}, traced {expected}");
                assert!(spread < 0.45 * mean, "{case}: dots, {found:.2?}");
            }
        }
    });
}

/// Where light is on the mean, by what each row or column has of it, and how far it is spread around that; pixels.
fn moments(parts: &[f64]) -> [f64; 2] {
    let sum = |power: i32, from: f64| -> f64 {
        (0..).zip(parts).map(|(i, part)| (f64::from(i) - from).powi(power) * part).sum()
    };
    let middle = sum(1, 0.0) / sum(0, 0.0);
    [middle, (sum(2, middle) / sum(0, 0.0)).max(0.0).sqrt()]
}

/// What each column of a picture has more of, in all, than that of another.
fn more_by_column(picture: &Picture, other: &Picture) -> Vec<f64> {
    let mut sums = vec![0.0; picture.width as usize];
    for (i, (a, b)) in picture.pixels.iter().zip(&other.pixels).enumerate() {
        sums[i % picture.width as usize] += f64::from(a.y - b.y);
    }
    sums
}

/// The reference's mean of a drop that stands still at so many moments of the exposure: in each it finds the sun's images.
fn by_moments(scene: &Scene, sky: &Environment, moments: u32) -> Picture {
    let mut sum: Option<Picture> = None;
    for moment in 0..moments {
        let mut still = scene.clone();
        let time = scene.camera.shutter * ((f64::from(moment) + 0.5) / f64::from(moments));
        still.drops[0].center += time * scene.drops[0].velocity;
        still.drops[0].velocity = DVec3::ZERO;
        let truth = Truth { samples: 16, ..Truth::default() };
        let picture = Tracer::new(&still, sky, truth).trace(&|_| ()).picture;
        let sum = sum.get_or_insert_with(|| Picture {
            pixels: vec![Vec3::ZERO; picture.pixels.len()],
            ..picture.clone()
        });
        for (sum, pixel) in sum.pixels.iter_mut().zip(&picture.pixels) {
            *sum += *pixel / moments as f32;
        }
    }
    sum.expect("a moment")
}

#[test]
fn a_sun_is_a_point_in_a_flat_drop_and_a_line_if_that_moves() {
    let toward = DVec3::new(0.85, 0.3, -0.6);
    let sun = |light: f32| {
        painted(512, |d| Vec3::splat(if d.angle_between(toward) < 0.009 { light } else { 0.1 }))
    };
    let (lit, dark) = (sun(3e4), sun(0.1));
    let falls = DVec3::new(0.6, -4.0, 0.4);
    on_device(|device| {
        for (drop, velocity) in [
            (falling(3.0), DVec3::ZERO),
            (falling(3.0), falls),
            (spheroid(0.7), falls),
            (spheroid(1.4), DVec3::ZERO),
        ] {
            let scene = exposed(PlacedDrop { velocity, ..drop }, 20.0);
            let moments_of = if velocity == DVec3::ZERO { 1 } else { 96 };
            let [traced, plain] = [&lit, &dark].map(|sky| by_moments(&scene, sky, moments_of));
            let expected = [more_by_row(&traced, &plain), more_by_column(&traced, &plain)];
            let light: f64 = expected[0].iter().sum();
            // Out of focus, a point at half the distance in focus is a disc of f A / 4z pixels of radius; f is 480.
            let mut blurred = scene.clone();
            let depth = scene.drops[0].center.length();
            (blurred.camera.aperture, blurred.camera.focus) = (depth / 30.0, 2.0 * depth);
            for preset in [Preset::Fast, Preset::Exact] {
                let drawn = |scene: &Scene| {
                    let mut scene = scene.clone();
                    scene.model.preset = preset;
                    let [with, without] = [&lit, &dark].map(|sky| picture_of(device, &scene, sky));
                    [more_by_row(&with, &without), more_by_column(&with, &without)]
                };
                let (found, spread) = (drawn(&scene), drawn(&blurred));
                let all = found[0].iter().sum::<f64>() / light;
                let all_spread = spread[0].iter().sum::<f64>() / light;
                let apart = |i: usize| {
                    let [a, b] = [&found[i], &expected[i]].map(|parts| moments(parts));
                    [a[0] - b[0], a[1] - b[1]]
                };
                let [rows, columns] = [apart(0), apart(1)];
                let disc = moments(&spread[1])[1].powi(2) - moments(&found[1])[1].powi(2);
                let case = format!(
                    "{drop:?} {velocity} {preset:?}: {all:.3}, rows {rows:.2?}, columns {columns:.2?}; blurred {all_spread:.3}, {disc:.2}"
                );
                println!("{case}");
                // Usually within 0.012, 0.2 pixels and 0.005; the point itself is 4 square pixels wide.
                assert!((all - 1.0).abs() < 0.03, "{case}");
                assert!(rows.iter().chain(&columns).all(|apart| apart.abs() < 0.5), "{case}");
                assert!(
                    (all_spread / all - 1.0).abs() < 0.015 && (3.5..5.5).contains(&disc),
                    "{case}"
                );
            }
        }
    });
}

/// Rain of large drops, whose shapes follow from their diameters.
fn downpour() -> Scene {
    let text = "[camera]\nvertical_fov = 1.2\ntarget = [0, 0.3, -1]\nposition = [0, 2, 0]\n[image]\nwidth = 56\nheight = 56\n\
                [rain]\nrate = 2000.0\ndiameters = [4.0, 6.0]\nsizes = \"uniform\"\nextent = 8.0";
    Scene::parse(text, "downpour").expect("a scene")
}

#[test]
fn falling_drops_have_the_shape_of_their_size() {
    let sky = waves();
    on_device(|device| {
        let mut scene = downpour();
        scene.model.preset = Preset::Exact;
        scene.model.samples = Some(64);
        let expected = reference(&scene, &sky);
        let covered = expected.coverage.iter().filter(|covered| **covered > 0.5).count();
        assert!(covered > 60, "{covered} pixels, too few to tell");
        let found = error(&expected, &picture_of(device, &scene, &sky));
        scene.model.shape = Some(ShapeModel::Sphere);
        let round = error(&expected, &picture_of(device, &scene, &sky));
        println!("{found:.5}, as spheres {round:.4}");
        assert!(found < 5e-3 && round > 4.0 * found, "{found}, {round}");
    });
}

#[test]
fn spheres_are_the_same_beside_flat_drops() {
    let sky = waves();
    on_device(|device| {
        let mut alone = one(PlacedDrop::default(), 0.0, 14.0);
        alone.model.preset = Preset::Exact;
        alone.model.weights = Some(Weights::Physical);
        let mut both = alone.clone();
        let behind = PlacedDrop { center: -alone.drops[0].center, ..spheroid(0.5) };
        both.drops.push(behind);
        // A ratio of 1 is traced as a spheroid, too.
        both.drops[0].axis_ratio = Some(1.0);
        assert_eq!(planned(&alone, &sky).shape.model, ShapeModel::Sphere);
        assert_eq!(planned(&both, &sky).shape.model, ShapeModel::Equilibrium);
        let off =
            rel_mse(&picture_of(device, &alone, &sky), &picture_of(device, &both, &sky), None);
        assert!(off < 1e-9, "{off}");
    });
}

#[test]
fn the_plan_takes_the_shape_that_shows() {
    let sky = waves();
    let shape = |scene: &Scene| planned(scene, &sky).shape;
    let mut scene = downpour();
    for (preset, shutter, expected) in [
        (Preset::Exact, 0.0, ShapeModel::Equilibrium),
        (Preset::Exact, 0.02, ShapeModel::Equilibrium),
        (Preset::Fast, 0.0, ShapeModel::Equilibrium),
        (Preset::Fast, 0.001, ShapeModel::Equilibrium),
        (Preset::Fast, 0.004, ShapeModel::Stretched),
    ] {
        scene.model.preset = preset;
        scene.camera.shutter = shutter;
        let found = shape(&scene);
        assert_eq!(found.model, expected, "{preset}, {shutter} s: {}", found.why);
    }
    // A placed drop may be at rest however long the shutter is open.
    scene.drops = vec![spheroid(0.9)];
    assert_eq!(shape(&scene).model, ShapeModel::Equilibrium);
    // Drops under a millimetre are spheres.
    let drizzle = "[rain]\nrate = 1.0\ndiameters = [0.2, 0.9]\nextent = 8.0";
    let mut drizzle = Scene::parse(drizzle, "drizzle").expect("a scene");
    drizzle.model.preset = Preset::Exact;
    assert_eq!(shape(&drizzle).model, ShapeModel::Sphere);
    // Billboards are spheres, and say so.
    let mut billboard = one(spheroid(0.9), 0.0, 8.0);
    billboard.model.preset = Preset::Paper;
    let refused = plan(&billboard, &sky, Output::Display).expect_err("a point").to_string();
    assert!(refused.contains("drop 1: axis_ratio") && refused.contains("fast"), "{refused}");
    billboard.model.shape = Some(ShapeModel::Sphere);
    assert_eq!(shape(&billboard).model, ShapeModel::Sphere);
}

/// A needle is a few pixels long and a part of one wide, aslant in the picture: no upright box.
#[test]
fn a_needle_is_drawn_along_its_axis() {
    let environment = waves();
    on_device(|device| {
        for pixels in [0.3, 0.45, 0.7] {
            let mut scene = one(spheroid(13.0), 10.0, pixels);
            scene.image = ImageSize { width: 16, height: 16 };
            scene.camera.up = DVec3::new(0.4, 0.9, 0.3);
            scene.camera.vertical_fov = 2.0 * (8.0 / (60.0 * pixels)).atan().to_degrees();
            scene.model.preset = Preset::Exact;
            let samples = Truth { samples: 1024, ..Truth::default() };
            let traced = |scene: &Scene| Tracer::new(scene, &environment, samples).picture();
            let (truth, empty) =
                (traced(&scene), traced(&Scene { drops: Vec::new(), ..scene.clone() }));
            let apart = |a: &Picture, b: &Picture| {
                let pairs = a.pixels.iter().zip(&b.pixels);
                pairs.map(|(a, b)| (*a - *b).length_squared()).sum::<f32>().sqrt()
            };
            let off =
                apart(&picture_of(device, &scene, &environment), &truth) / apart(&empty, &truth);
            println!("{pixels} px: {off:.3}");
            // Usually 0.7 at most, by how few of a pixel's rays meet it; as a box 3.3.
            assert!(off < 1.0, "{pixels} px: off by {off} of what it changes");
        }
    });
}
