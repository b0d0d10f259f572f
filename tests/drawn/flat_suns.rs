//! A bare sun in far rain whose drops are flattened (`src/rain/flat_suns.rs`), against rays that are traced here in float64
//! through drops of the law's sizes and counted by the cone that they leave in.

use glam::{DQuat, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::optics::{Shape, WATER, Walk};
use raindrops::plan::Output;
use raindrops::rain::law::Law;
use raindrops::rain::shape::Halves;
use raindrops::scene::model::{FarRain, Preset, ShapeModel};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, RainSettings, Scene};

use crate::common::picture::renderer_of;
use crate::common::{Random, on_device, painted};

const SKY: f64 = 0.02;
/// Cosine of half the angle of a cone of directions, 12°.
const CONE: f64 = 0.978;
const EDGE: u32 = 24;

/// Rain so deep that nothing is seen but its medium.
fn deep() -> Scene {
    let rain = RealRain { rate: 100.0, extent: 1e5, ..RealRain::default() };
    let mut scene = Scene {
        rain: Some(RainSettings::of(rain)),
        image: ImageSize { width: EDGE, height: EDGE },
        ..Scene::default()
    };
    scene.water.index = Some(Index::One(WATER));
    scene.camera.position = DVec3::ZERO;
    scene.camera.vertical_fov = 30.0;
    scene.model.preset = Preset::Fast;
    (scene.model.far_rain, scene.model.cutoff_px) = (Some(FarRain::Medium), Some(1.0));
    scene
}

fn shape_of(diameter_mm: f64) -> Shape {
    match Halves::of_diameter(diameter_mm) {
        Halves { joint, equatorial, top, bottom } if diameter_mm > 1.0 => {
            Shape::Halves { equatorial, top, bottom, joint }
        }
        _ => Shape::Sphere,
    }
}

/// Where rays of a direction through drops of a law that block as much as each other meet them: a sample of each.
fn meetings(law: &Law, d: DVec3) -> impl Iterator<Item = (Shape, DVec3)> {
    const RAYS: u32 = 120_000;
    let (u, v) = d.any_orthonormal_pair();
    let mut random = Random(3);
    (0..RAYS).filter_map(move |number| {
        let shape = shape_of(law.quantile(2.0, (f64::from(number) + 0.5) / f64::from(RAYS)));
        let mut at = || 2.6 * (random.unit() - 0.5);
        let to_ray = at() * u + at() * v;
        Some((shape, to_ray + shape.cross(to_ray, d)?.0 * d))
    })
}

/// Directions and shares of the light that leaves drops along each ray from a sun.
fn sent(law: &Law, toward: DVec3) -> Vec<(DVec3, f64)> {
    let mut all = Vec::new();
    for (shape, at) in meetings(law, -toward) {
        let (entry, inside) = Walk::enter(shape, at, -toward, WATER);
        all.push((entry.reflected, entry.reflectance));
        let exits = inside.into_iter().flat_map(|walk| walk.take(12).flatten());
        all.extend(exits.map(|exit| (exit.direction, exit.weight)));
    }
    all
}

/// Mean luminance of rain alone, in a cone about where the camera looks.
fn luminance(environment: &Environment, scene: &Scene) -> f64 {
    let (view, forward) = (scene.view(), scene.camera.target.normalize());
    let (mut sum, mut pixels) = (0.0, 0.0);
    on_device(|device| {
        let mut renderer = renderer_of(device, scene, environment, Output::Layers);
        renderer.draw(scene).expect("a frame");
        let rain = renderer.read_layers().expect("layers");
        for (number, color) in (0..).zip(&rain.color) {
            let at = [number % EDGE, number / EDGE].map(|at| f64::from(at) + 0.5);
            if view.ray(at[0], at[1]).dot(forward) > CONE {
                sum += color[1].to_f64() / color[3].to_f64();
                pixels += 1.0;
            }
        }
    });
    sum / pixels
}

/// A sun's place, a sky with it, its irradiance.
fn sun(elevation: f64) -> (DVec3, Environment, f64) {
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let toward = DVec3::new(0.0, sine, -cosine);
    let sky = painted(1024, |d| Vec3::splat(if d.dot(toward) > 0.9998 { 3e3 } else { SKY as f32 }));
    let irradiance = 4.0 * std::f64::consts::PI * (sky.mean_luminance() - SKY);
    (toward, sky, irradiance)
}

/// Mean luminance of a law's drops where the camera looks, by the light that they have `sent`.
fn expected(law: &Law, sent: &[(DVec3, f64)], irradiance: f64, target: DVec3) -> f64 {
    let d = target.normalize();
    let in_cone = sent.iter().filter(|(direction, _)| -direction.dot(d) > CONE);
    let share = in_cone.map(|(_, share)| share).sum::<f64>() / meetings(law, d).count() as f64;
    SKY + irradiance * share / (std::f64::consts::TAU * (1.0 - CONE))
}

#[test]
fn flattened_far_drops_send_a_suns_light_where_they_should() {
    let mut scene = deep();
    let law = scene.real_rain().expect("rain").law();
    let mut worst_of_spheres = 0.0_f64;
    for elevation in [15.0, 60.0] {
        let (toward, sky, irradiance) = sun(elevation);
        let sent = sent(&law, toward);
        for target in [
            DVec3::new(0.8, 0.0, -0.6),
            DVec3::X,
            DVec3::Z,
            DVec3::new(0.5, 0.8, 0.3),
            DVec3::new(0.4, -0.85, -0.3),
        ] {
            scene.camera.target = target;
            let expected = expected(&law, &sent, irradiance, target);
            let mut off = |shape| {
                scene.model.shape = shape;
                luminance(&sky, &scene) / expected - 1.0
            };
            let (flat, sphere) = (off(None), off(Some(ShapeModel::Sphere)));
            println!("sun {elevation}, {target}: {expected:.4} {flat:.3}; of spheres {sphere:.3}");
            assert!(flat.abs() < 0.13, "sun {elevation}, towards {target}: off by {flat}");
            worst_of_spheres = worst_of_spheres.max(sphere.abs());
        }
    }
    assert!(worst_of_spheres > 0.2, "spheres send as much, {worst_of_spheres}: nothing was shown");
}

/// Streaks of all drops, and of the larger ones before the others as a medium, are as bright together as drops are.
#[test]
fn streaks_and_medium_share_the_light_of_flattened_drops() {
    let mut scene = deep();
    let rain = RealRain { rate: 100.0, extent: 12.0, ..RealRain::default() };
    scene.rain = Some(RainSettings::of(rain));
    scene.camera.shutter = 0.25;
    scene.camera.target = DVec3::new(0.8, 0.0, -0.6);
    let law = rain.law();
    let (toward, sky, irradiance) = sun(60.0);
    let sent = sent(&law, toward);
    let expected = expected(&law, &sent, irradiance, scene.camera.target);
    for (far_rain, cutoff_px) in
        [(FarRain::Drops, None), (FarRain::Medium, Some(0.012)), (FarRain::Medium, Some(0.004))]
    {
        (scene.model.far_rain, scene.model.cutoff_px) = (Some(far_rain), cutoff_px);
        let off = luminance(&sky, &scene) / expected - 1.0;
        println!("{far_rain:?} {cutoff_px:?}: {expected:.4} {off:.3}");
        assert!(off.abs() < 0.065, "{far_rain:?} {cutoff_px:?}: off by {off}");
    }
}

/// A window in a dark room, seen through the rain at angles that leave drops near their rims too.
#[test]
fn flattened_far_drops_show_as_much_of_a_window_as_their_rays() {
    let mut scene = deep();
    scene.camera.vertical_fov = 4.0;
    let law = scene.real_rain().expect("rain").law();
    for toward in [DVec3::new(0.0, 0.2, -1.0), DVec3::new(0.0, 1.5, -1.0)].map(DVec3::normalize) {
        let (u, v) = toward.any_orthonormal_pair();
        let window = |d: DVec3| {
            let [x, y, z] = [u, v, toward].map(|axis| d.dot(axis));
            f64::from(u8::from(z > 0.0 && x.abs().max(y.abs()) < 0.105 * z))
        };
        let room = painted(1024, |d| Vec3::splat(window(d) as f32));
        for aside in [20.0f64, 40.0, 75.0, 90.0, 150.0] {
            for around in [DVec3::X, DVec3::Y] {
                let axis = around.reject_from(toward).normalize();
                let d = DQuat::from_axis_angle(axis, aside.to_radians()) * toward;
                let shown = |(shape, at)| {
                    let (entry, inside) = Walk::enter(shape, at, d, WATER);
                    let exits = inside.into_iter().flat_map(|walk| walk.take(12).flatten());
                    entry.reflectance * window(entry.reflected)
                        + exits.map(|exit| exit.weight * window(exit.direction)).sum::<f64>()
                };
                let rays: Vec<f64> = meetings(&law, d).map(shown).collect();
                let expected = rays.iter().sum::<f64>() / rays.len() as f64;
                scene.camera.target = d;
                let off = luminance(&room, &scene) - expected;
                println!("{toward:.2}, {aside}° around {around}: {expected:.5}, off {off:+.5}");
                assert!(off.abs() < 0.09 * expected + 2.3e-4, "{aside}° around {around}: {off}");
            }
        }
    }
}
