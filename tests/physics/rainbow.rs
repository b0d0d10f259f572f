//! The bow in real rain: where its ring is brightest, against Descartes' and Fresnel's formulas and the sun's disc,
//! written out here.

use glam::{DVec3, Vec3};
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::model::DropShape;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, RainSettings, Scene};

const INDEX: f64 = 1.3343;
/// Angular radius of the sun's disc, degrees.
const DISC: f64 = 0.27;
/// Degrees of a ring.
const RING: f64 = 0.05;

/// Light of a sphere, for each unit of solid angle, by the angle from the point opposite to the sun in rings: once
/// reflected inside, from a sun without extent.
fn bow_of_a_point() -> Vec<f64> {
    let mut light = vec![0.0; (60.0 / RING) as usize];
    let steps = 2_000_000;
    for step in 0..steps {
        let square = (f64::from(step) + 0.5) / f64::from(steps);
        let incidence = square.sqrt().asin();
        let refraction = (square.sqrt() / INDEX).asin();
        let (sum, difference) = (incidence + refraction, incidence - refraction);
        let across = (difference.sin() / sum.sin()).powi(2);
        let along = (difference.tan() / sum.tan()).powi(2);
        let reflected = 0.5 * (across + along);
        let angle = (4.0 * refraction - 2.0 * incidence).to_degrees();
        if let Some(ring) = light.get_mut((angle / RING) as usize) {
            *ring += (1.0 - reflected).powi(2) * reflected;
        }
    }
    let solid_angle = |ring: usize| ((ring as f64 + 0.5) * RING).to_radians().sin();
    light.iter().enumerate().map(|(ring, light)| light / solid_angle(ring)).collect()
}

/// The mean over a disc, each of whose strips along the ring sees one angle.
fn over_the_disc(light: &[f64]) -> Vec<f64> {
    let reach = (DISC / RING).ceil() as i64;
    let strips: Vec<(i64, f64)> = (-reach..=reach)
        .map(|strip| (strip, (DISC.powi(2) - (strip as f64 * RING).powi(2)).max(0.0).sqrt()))
        .collect();
    let at = |ring: i64| light.get(ring as usize).copied().unwrap_or(0.0);
    (0..light.len() as i64)
        .map(|ring| strips.iter().map(|(strip, length)| length * at(ring + strip)).sum())
        .collect()
}

/// Degrees of the brightest ring, between rings by the parabola through it and its neighbours.
fn brightest(rings: &[f64]) -> f64 {
    let top = (1..rings.len() - 1).max_by(|a, b| rings[*a].total_cmp(&rings[*b])).expect("rings");
    let [before, peak, after] = [rings[top - 1], rings[top], rings[top + 1]];
    let offset = 0.5 * (before - after) / (before - 2.0 * peak + after);
    (top as f64 + 0.5 + offset) * RING
}

#[test]
fn the_bow_stands_where_descartes_says() {
    let point = bow_of_a_point();
    let expected = brightest(&over_the_disc(&point));
    // A point source would make it 41.89 degrees; the disc takes it inwards.
    assert!((brightest(&point) - 41.85).abs() < 0.06, "{}", brightest(&point));
    assert!((0.1..0.3).contains(&(41.89 - expected)), "{expected}");

    let sun = DVec3::new(0.0, 10_f64.to_radians().sin(), 10_f64.to_radians().cos());
    let environment = crate::common::painted(3072, |d| {
        let disc = if d.angle_between(sun) < DISC.to_radians() { 20_000.0 } else { 0.0 };
        Vec3::splat(0.2 + disc)
    });
    let rain = RealRain { extent: 500.0, shape: DropShape::Sphere, ..RealRain::default() };
    let mut scene = Scene {
        rain: Some(RainSettings::of(rain)),
        image: ImageSize { width: 160, height: 160 },
        ..Scene::default()
    };
    scene.water.index = Some(Index::One(INDEX));
    scene.camera.vertical_fov = 8.0;
    scene.camera.target = DVec3::new(0.0, 32_f64.to_radians().tan(), -1.0);
    let truth = Truth { samples: 16, rain_to: Some(12.0), ..Truth::default() };
    let picture = Tracer::new(&scene, &environment, truth).picture();
    let view = scene.view();
    let mut rings = vec![(0.0, 0.0); (60.0 / RING) as usize];
    for (number, pixel) in (0_u32..).zip(&picture.pixels) {
        let (x, y) = (f64::from(number % 160) + 0.5, f64::from(number / 160) + 0.5);
        let angle = view.ray(x, y).angle_between(-sun).to_degrees();
        let ring = &mut rings[(angle / RING) as usize];
        *ring = (ring.0 + f64::from(pixel.y), ring.1 + 1.0);
    }
    // Rings that the picture's corners cut are few pixels.
    let means: Vec<f64> =
        rings.iter().map(|(sum, count)| if *count > 60.0 { sum / count } else { 0.0 }).collect();
    let found = brightest(&means);
    println!("brightest at {found} degrees, expected {expected}");
    assert!((found - expected).abs() < 0.1, "{found}, not {expected}");
    // Inside of the bow it is brighter than between the two bows.
    let at = |degrees: f64| means[(degrees / RING) as usize];
    assert!(at(39.5) > at(44.0) && at(expected) > 1.3 * at(44.0), "{} {}", at(39.5), at(44.0));
}
