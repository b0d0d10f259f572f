//! The bow in real rain: where its ring is brightest, against Descartes' and Fresnel's formulas and the sun's disc.

use glam::{DVec3, Vec3};
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::model::DropShape;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, RainSettings, Scene};

use crate::common::bow::{DISC, INDEX, RING, bow_of_a_point, brightest, over_the_disc};

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
