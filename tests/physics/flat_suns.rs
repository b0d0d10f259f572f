//! Suns in drops that are no spheres: images that are looked for, and the light that small drops of rain spread over their
//! disc, against what many rays meet by chance.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::picture::Picture;
use raindrops::picture::metrics::box_filter;
use raindrops::reference::Truth;
use raindrops::scene::model::DropShape;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::painted;
use crate::glints::{SEEDS, apart, by_seed, traced, with_disc};

fn pictures(scene: &Scene, environment: &Environment, truth: Truth) -> Vec<Picture> {
    by_seed(scene, environment, truth, SEEDS)
}

fn boxed(pictures: &[Picture]) -> Vec<Picture> {
    pictures.iter().map(box_filter).collect()
}

/// Unit vector at an elevation and an azimuth from -z, in degrees.
fn toward(elevation: f64, azimuth: f64) -> DVec3 {
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let azimuth = azimuth.to_radians();
    DVec3::new(cosine * azimuth.sin(), sine, -cosine * azimuth.cos())
}

/// A drop of 5 mm or a spheroid of 12 pixels of radius at an elevation, a small one over its rim, one that the picture's edge
/// cuts, and many smaller than a pixel.
fn drops(elevation: f64, shape: Option<DropShape>) -> Scene {
    let mut scene = Scene { rain: None, metres: 0.0025, ..Scene::default() };
    (scene.image.width, scene.image.height) = (40, 40);
    scene.camera.vertical_fov = 30.0;
    scene.camera.target = toward(elevation, 0.0);
    let view = scene.view();
    let mut add = |x: f64, y: f64, distance: f64, radius: f64| {
        let center = distance * view.ray(x, y);
        let axis_ratio = shape.is_none().then_some(0.7);
        scene.drops.push(PlacedDrop { center, radius, axis_ratio, shape, ..PlacedDrop::default() });
    };
    add(18.0, 19.0, 6.2, 1.0);
    add(28.0, 16.0, 5.0, 0.25);
    add(36.0, 38.0, 9.0, 1.0);
    for number in 0..8 {
        let at = f64::from(number);
        add((3.0 + 17.3 * at) % 40.0, (5.0 + 11.9 * at) % 40.0, 150.0 + at, 1.0);
    }
    scene
}

/// Whether the mean light and that of boxes is that by chance; with the control, that it is not without reflections on the outside.
fn assert_found(scene: &Scene, environment: &Environment, name: &str, control: bool) {
    assert_eq!(split(environment).expect("a disc").regions.len(), 1);
    let whole = Truth { samples: 48, ..Truth::default() };
    let met = pictures(scene, environment, Truth { samples: 192, glints: false, ..whole });
    let far_apart = |truth: Truth| {
        let found = pictures(scene, environment, truth);
        let ([pixels, mean], [boxes, _]) =
            (apart(&found, &met), apart(&boxed(&found), &boxed(&met)));
        println!("{name}: {pixels:.2} pixels, {boxes:.2} boxes, {mean:.2} mean");
        (pixels, boxes, mean)
    };
    let (pixels, boxes, mean) = far_apart(whole);
    // Some boxes hold most of the noise, so that it is known to a half or so.
    assert!((0.7..1.4).contains(&pixels) && (0.3..1.6).contains(&boxes) && mean < 3.0);
    if control {
        let (_, boxes, mean) = far_apart(Truth { reflection: false, ..whole });
        assert!(boxes > 2.0 && mean > 3.5);
    }
}

#[test]
fn glints_of_flat_drops_are_those_that_chance_meets() {
    for (elevation, shape, disc) in [
        (-40.0, Some(DropShape::Equilibrium), toward(10.0, 170.0)),
        (50.0, None, toward(50.0, 0.0)),
    ] {
        let scene = drops(elevation, shape);
        let name = format!("{elevation} {shape:?}");
        assert_found(&scene, &with_disc(512, disc, 4.0), &name, shape.is_some());
    }
}

#[test]
fn glints_of_moving_flat_drops_are_those_that_chance_meets() {
    let mut scene = drops(0.0, Some(DropShape::Equilibrium));
    scene.camera.shutter = 1.0;
    for drop in &mut scene.drops {
        drop.velocity = DVec3::new(0.3, -1.5, 0.4);
    }
    assert_found(&scene, &with_disc(512, toward(20.0, 50.0), 4.0), "moving", false);
}

/// What is looked for has less noise than what chance meets, by far.
#[test]
fn under_a_sun_a_flat_drop_converges() {
    let scene = drops(0.0, Some(DropShape::Equilibrium));
    let sun = painted(512, |direction| {
        let is_lit = direction.angle_between(toward(20.0, 50.0)) < 0.01;
        Vec3::splat(if is_lit { 3e4 } else { 0.5 })
    });
    let rest = split(&sun).expect("a sun").rest;
    let noise = |environment: &Environment, glints: bool| {
        let truth = Truth { samples: 64, glints, ..Truth::default() };
        let [a, b] = [1, 2].map(|seed| traced(&scene, environment, Truth { seed, ..truth }));
        let pairs = a.pixels.iter().zip(&b.pixels);
        // Shown: no brighter than white.
        let squares = pairs.map(|(a, b)| (a.min(Vec3::ONE) - b.min(Vec3::ONE)).length_squared());
        (squares.sum::<f32>() / a.pixels.len() as f32).sqrt()
    };
    let [found, met, without] =
        [(&sun, true), (&sun, false), (&rest, true)].map(|(e, g)| noise(e, g));
    println!("noise: found {found:.4}, met {met:.4}, without the sun {without:.4}");
    assert!(found < 2.0 * without && met > 3.0 * found);
}

/// Rain of flattened drops alone, each under half a pixel, and the medium behind them.
fn rain(elevation: f64, shutter: f64, extent: f64) -> Scene {
    let rain = RealRain { rate: 150.0, diameters: [2.5, 6.0], extent, ..RealRain::default() };
    let mut scene = Scene { rain: Some(RainSettings::of(rain)), ..Scene::default() };
    (scene.image.width, scene.image.height) = (24, 24);
    (scene.camera.vertical_fov, scene.camera.shutter) = (12.0, shutter);
    scene.camera.target = toward(elevation, 0.0);
    scene
}

#[test]
fn small_flat_drops_show_as_much_of_a_sun_as_chance_meets() {
    // In the last case most of the light is the medium's.
    for (elevation, shutter, extent, disc) in [
        (0.0, 0.0, 20.0, toward(25.0, 30.0)),
        (45.0, 0.004, 20.0, toward(20.0, 30.0)),
        (-30.0, 0.0, 100.0, toward(30.0, 30.0)),
    ] {
        let (scene, environment) = (rain(elevation, shutter, extent), with_disc(512, disc, 8.0));
        let truth = Truth { rain_to: Some(extent.min(20.0)), ..Truth::default() };
        let found = pictures(&scene, &environment, Truth { samples: 64, ..truth });
        let by_chance = |samples| Truth { samples, glints: false, ..truth };
        let met = pictures(&scene, &environment, by_chance(256));
        let rest = split(&environment).expect("a disc").rest;
        let without = pictures(&scene, &rest, by_chance(64));
        let light = |pictures: &[Picture]| {
            let sum =
                |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>();
            pictures.iter().map(sum).sum::<f64>() / SEEDS as f64
        };
        let sun = light(&met) - light(&without);
        let off = (light(&found) - light(&met)) / sun;
        let ([_, mean], [boxes, _]) = (apart(&found, &met), apart(&boxed(&found), &boxed(&met)));
        println!(
            "{elevation}: off by {off:.3} of the sun's light; {boxes:.2} boxes, {mean:.2} mean"
        );
        assert!(off.abs() < 0.12 && boxes < 1.6 && mean < 3.5);
    }
}
