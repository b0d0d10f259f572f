//! The reference against another ray tracer, which stands here whole: every drop tried by its quadratic
//! equation in the world's space, Snell and Fresnel as vectors and angles, every sample by chance. It shares
//! nothing with the reference but the environment's pixels and the camera's frame.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::rel_mse;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::Random;

const INDEX: f64 = 1.33;

/// Semi-axes of a drop.
fn axes(drop: &PlacedDrop) -> DVec3 {
    let ratio = drop.axis_ratio.unwrap_or(1.0);
    // Equal volume: a² h = r³ with h = q a.
    let across = drop.radius / ratio.cbrt();
    DVec3::new(across, ratio * across, across)
}

/// Distances at which a line enters and leaves an ellipsoid around the origin.
fn roots(origin: DVec3, direction: DVec3, axes: DVec3) -> Option<(f64, f64)> {
    let (p, d) = (origin / axes, direction / axes);
    let (a, b, c) = (d.dot(d), p.dot(d), p.dot(p) - 1.0);
    let inside = b * b - a * c;
    (inside > 0.0).then(|| ((-b - inside.sqrt()) / a, (-b + inside.sqrt()) / a))
}

/// Reflectance by the angles; 1 under total reflection.
fn reflectance(incidence: f64, index: f64) -> f64 {
    let sine = incidence.sin() / index;
    if sine >= 1.0 {
        return 1.0;
    }
    let refraction = sine.asin();
    if incidence < 1e-6 {
        return ((index - 1.0) / (index + 1.0)).powi(2);
    }
    let s = (incidence - refraction).sin() / (incidence + refraction).sin();
    let p = (incidence - refraction).tan() / (incidence + refraction).tan();
    0.5 * (s * s + p * p)
}

fn refract(direction: DVec3, normal: DVec3, index: f64) -> DVec3 {
    let across = (direction - direction.dot(normal) * normal) / index;
    (across - (1.0 - across.length_squared()).max(0.0).sqrt() * normal).normalize()
}

/// What a drop around the origin sends back along a ray that meets it at `point`.
fn leaving(point: DVec3, direction: DVec3, axes: DVec3, environment: &Environment) -> DVec3 {
    let outward = |point: DVec3| (point / (axes * axes)).normalize();
    let mirror = |direction: DVec3, normal: DVec3| direction - 2.0 * direction.dot(normal) * normal;
    let normal = outward(point);
    let share = reflectance((-direction.dot(normal)).clamp(0.0, 1.0).acos(), INDEX);
    let mut light = share * environment.radiance(mirror(direction, normal));
    let (mut point, mut direction) = (point, refract(direction, normal, INDEX));
    let mut inside = 1.0 - share;
    for _ in 0..=8 {
        let Some((_, far)) = roots(point, direction, axes) else { break };
        point += far * direction;
        let normal = outward(point);
        let share = reflectance(direction.dot(normal).clamp(0.0, 1.0).acos(), 1.0 / INDEX);
        if share < 1.0 {
            let out = refract(direction, -normal, 1.0 / INDEX);
            light += inside * (1.0 - share) * environment.radiance(out);
        }
        inside *= share;
        direction = mirror(direction, normal).normalize();
    }
    light
}

fn independent(scene: &Scene, environment: &Environment, samples: u32) -> Picture {
    let (view, camera) = (scene.view(), &scene.camera);
    let (width, height) = (view.width, view.height);
    let mut random = Random(99);
    let mut pixel = |x: u32, y: u32| {
        let mut sum = DVec3::ZERO;
        for _ in 0..samples {
            let time = scene.time + random.unit() * camera.shutter;
            let through = view.ray(f64::from(x) + random.unit(), f64::from(y) + random.unit());
            let focused = through * (camera.focus / through.dot(-view.back));
            let lens = loop {
                let (a, b) = (2.0 * random.unit() - 1.0, 2.0 * random.unit() - 1.0);
                if a * a + b * b <= 1.0 {
                    break 0.5 * camera.aperture * (a * view.right + b * view.up);
                }
            };
            let direction = (focused - lens).normalize();
            let origin = camera.position + lens;
            let first = scene
                .drops
                .iter()
                .filter_map(|drop| {
                    let from = origin - (drop.center + drop.velocity * time);
                    let (near, _) = roots(from, direction, axes(drop))?;
                    (near > 0.0).then_some((near, from, axes(drop)))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            sum += match first {
                Some((near, from, axes)) => {
                    leaving(from + near * direction, direction, axes, environment)
                }
                None => environment.radiance(direction),
            };
        }
        (sum / f64::from(samples)).as_vec3()
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = places.map(|(x, y)| pixel(x, y)).collect();
    Picture { width, height, pixels }
}

/// Bright above, a bright band to one side, dark below: smooth, and different in every direction.
fn environment() -> Environment {
    let texels = (0..64 * 32).map(|index: u32| {
        let (u, v) = (f64::from(index % 64) / 64.0, f64::from(index / 64) / 32.0);
        let band = (-((u - 0.3) * 9.0).powi(2)).exp() * (-((v - 0.4) * 6.0).powi(2)).exp();
        let sky = 0.15 + 1.2 * (1.0 - v).powi(2);
        Vec3::new(sky as f32, (0.9 * sky + 3.0 * band) as f32, (0.8 * sky + band) as f32)
    });
    Environment::from_texels("band", 64, 32, texels.collect()).expect("valid")
}

fn drop(center: [f64; 3], radius: f64, axis_ratio: f64, velocity: [f64; 3]) -> PlacedDrop {
    PlacedDrop {
        axis_ratio: Some(axis_ratio),
        velocity: velocity.into(),
        ..PlacedDrop::sphere(center.into(), radius)
    }
}

fn scene(drops: Vec<PlacedDrop>) -> Scene {
    let mut scene = Scene { rain: None, drops, ..Scene::default() };
    (scene.image.width, scene.image.height) = (32, 24);
    scene.camera.vertical_fov = 50.0;
    scene.camera.position = DVec3::new(1.0, 2.0, 3.0);
    scene.camera.target = DVec3::new(1.3, 2.4, -3.0);
    scene
}

#[test]
fn another_tracer_draws_the_same_pictures() {
    let environment = environment();
    // Places as they are at time 0; the pictures are of time 2.
    let still = [
        drop([0.4, 2.6, -3.0], 0.9, 0.7, [0.0; 3]),
        drop([2.4, 1.6, -2.0], 0.8, 1.0, [0.0; 3]),
        drop([1.6, 3.4, -5.0], 1.2, 0.85, [0.0; 3]),
    ];
    let moving = [
        drop([0.4, 12.6, -3.0], 0.9, 1.0, [0.0, -5.0, 0.0]),
        drop([-6.0, 1.4, -2.0], 0.6, 0.8, [4.0, 0.5, 0.0]),
        drop([2.6, 3.0, -22.0], 0.7, 1.0, [0.0, 0.0, 8.0]),
    ];
    let streaks: Vec<PlacedDrop> = (0..30)
        .map(|number| {
            let place = |scale: f64, step: u32| f64::from(number * step % 30) / 30.0 * scale;
            drop([place(6.0, 7) - 2.0, place(5.0, 11) + 17.0, -4.0], 0.15, 0.9, [0.0, -8.0, 0.3])
        })
        .collect();
    let of = |drops: &[PlacedDrop], shutter: f64, aperture: f64, focus: f64| {
        let mut scene = scene(drops.to_vec());
        scene.time = 2.0;
        (scene.camera.shutter, scene.camera.aperture, scene.camera.focus) =
            (shutter, aperture, focus);
        scene
    };
    let all: Vec<PlacedDrop> = still.iter().chain(&moving).chain(&streaks).copied().collect();
    for (name, scene) in [
        ("spheroids", of(&still, 0.0, 0.0, 5.0)),
        ("in motion", of(&moving, 0.2, 0.0, 5.0)),
        ("streaks", of(&streaks, 0.3, 0.0, 5.0)),
        ("blurred", of(&still, 0.0, 0.8, 7.0)),
        ("all at once", of(&all, 0.2, 0.4, 9.0)),
    ] {
        let expected = independent(&scene, &environment, 512);
        let truth = Truth { samples: 256, ..Truth::default() };
        let apart = |scene: &Scene| {
            rel_mse(&Tracer::new(scene, &environment, truth).picture(), &expected, None)
        };
        let right = apart(&scene);
        println!("{name}: relMSE {right:.2e}");
        assert!(right < 1e-4, "{name}: {right}");
        // The controls: a little more of what the scene is about.
        let mut wrong = scene.clone();
        wrong.camera.shutter *= 1.3;
        wrong.camera.aperture *= 1.3;
        for drop in &mut wrong.drops {
            drop.axis_ratio =
                drop.axis_ratio.map(|ratio| if ratio == 1.0 { 1.0 } else { 0.93 * ratio });
        }
        let (wrong, without) =
            (apart(&wrong), apart(&Scene { drops: Vec::new(), ..scene.clone() }));
        println!("    control {wrong:.2e}, without drops {without:.2e}");
        // Streaks are so faint that only their absence shows.
        let control = if name == "streaks" { without } else { wrong };
        assert!(control > 3.0 * right, "{name}: {control}");
    }
}
