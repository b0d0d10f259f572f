//! Where the reference sees the drops of real rain: against drops that are found here by walking through every cell.
//! It shares with the program what *is* the rain: which drops a cell holds.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::optics::Shape;
use raindrops::rain::law::Law;
use raindrops::rain::shape::Halves;
use raindrops::reference::{Drop, Drops, Eye, Population, Tracer, Truth, usual_bound};
use raindrops::scene::Scene;
use raindrops::scene::model::{DropShape, Sizes};
use raindrops::scene::water::Index;

use crate::rain_reference::{opacities, raining, traced, with_rain};

/// A drop that every cell was looked through for.
struct Found {
    center: DVec3,
    diameter_mm: f64,
    velocity: DVec3,
}

/// Every drop whose centre is nearer than `reach` metres to the camera at the scene's time.
fn walk(scene: &Scene, reach: f64) -> Vec<Found> {
    let rain = scene.real_rain().expect("real rain");
    let camera = scene.camera.position * scene.metres;
    let mut found = Vec::new();
    for lattice in rain.lattices(scene.seed) {
        let edge = lattice.edge();
        let moved = lattice.velocity * scene.time;
        let cells = (reach / edge).ceil() as i64 + 1;
        let middle = ((camera - moved) / edge).floor().to_array().map(|cell| cell as i64);
        for n in 0..(2 * cells + 1).pow(3) {
            let wide = 2 * cells + 1;
            let offset = [n % wide - cells, n / wide % wide - cells, n / wide / wide - cells];
            let cell = [0, 1, 2].map(|axis: usize| middle[axis] + offset[axis]);
            for drop in lattice.drops(cell) {
                let at = |axis: usize| {
                    let fraction = f64::from(drop.place.fraction[axis]) / 4_294_967_296.0;
                    (cell[axis] as f64 + fraction) * edge
                };
                let center = DVec3::new(at(0), at(1), at(2)) + moved - camera;
                if center.length() < reach {
                    let diameter_mm = f64::from(drop.diameter) / 1_048_576.0;
                    found.push(Found { center, diameter_mm, velocity: lattice.velocity });
                }
            }
        }
    }
    found
}

/// The rain as a list of drops in scene units, each with a population of its own.
fn as_list(scene: &Scene, reach: f64, is_flat: bool) -> Drops {
    let mut drops = Drops::default();
    let forward = (scene.camera.target - scene.camera.position).normalize();
    let may_be_seen =
        |center: DVec3| center.length() < 1.0 || center.dot(forward) > 0.5 * center.length();
    for found in walk(scene, reach) {
        let motion = found.velocity * scene.camera.shutter;
        if !may_be_seen(found.center) && !may_be_seen(found.center + motion) {
            continue;
        }
        let motion = motion / scene.metres;
        let shape = match Halves::of_diameter(found.diameter_mm) {
            Halves { joint, equatorial, top, bottom } if is_flat && found.diameter_mm >= 1.0 => {
                Shape::Halves { equatorial, top, bottom, joint }
            }
            _ => Shape::Sphere,
        };
        let population = drops.populations.len() as u32;
        drops.populations.push(Population { shape, motion, half_extent: None });
        let radius = 0.5e-3 * found.diameter_mm / scene.metres;
        drops.all.push(Drop { center: found.center / scene.metres, radius, population });
    }
    drops
}

/// A camera that has moved, at a time that is not 0, in rain that the wind drives, in units of 2 m.
fn weathered(edge: u32, extent: f64) -> Scene {
    let mut scene = raining(25.0, extent, edge, 60.0);
    scene = with_rain(scene, |rain| rain.wind = DVec3::new(3.0, 0.5, -2.0));
    scene.water.index = Some(Index::One(1.33));
    (scene.metres, scene.time) = (2.0, 3.25);
    scene.camera.position = DVec3::new(20.0, -7.0, 300.0);
    scene.camera.target = DVec3::new(21.0, -6.7, 298.0);
    scene
}

fn slope() -> Environment {
    crate::common::painted(64, |d| {
        Vec3::splat(1.0 + 0.5 * d.y as f32) + Vec3::X * (0.3 * d.x as f32)
    })
}

/// Sample for sample the picture of the drops in a list. A tile of 8 x 8 pixels holds more drops than are kept
/// in memory at a time.
#[test]
fn no_drop_of_the_cells_is_missed_or_misplaced() {
    let environment = slope();
    let truth = Truth { samples: 5, glints: false, ..Truth::default() };
    let instant = weathered(8, 6.0);
    let mut streaks = weathered(8, 3.0);
    streaks.camera.shutter = 0.08;
    let mut lens = weathered(24, 3.0);
    (lens.camera.aperture, lens.camera.focus, lens.camera.shutter) = (0.01, 1.0, 0.004);
    let mut flat = with_rain(weathered(24, 3.0), |rain| rain.shape = DropShape::Equilibrium);
    flat.camera.near = 0.1;
    for (scene, is_flat) in [(instant, false), (streaks, false), (lens, false), (flat, true)] {
        let expected = Tracer::of_drops(
            Eye::of_scene(&scene),
            as_list(&scene, scene.real_rain().expect("rain").extent, is_flat),
            &environment,
            truth,
        );
        let expected = expected.trace(&|_| ());
        let found = traced(&scene, &environment, truth);
        let sum: f32 = found.coverage.iter().sum();
        assert!(sum > 0.1, "nothing was seen: {sum}");
        // A sample on the very rim of a drop may fall to either side.
        let off = found.coverage.iter().zip(&expected.coverage).filter(|(a, b)| a != b).count();
        assert!(off <= 1, "{off} pixels are covered otherwise");
        let pixels = found.picture.pixels.iter().zip(&expected.picture.pixels);
        let worst = pixels.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
        assert!(off == 1 || worst < 1e-4, "{worst}");
    }
}

/// The nearest drops are where their cell says, as large as it says, and what is covered is theirs.
#[test]
fn a_drop_is_seen_at_its_pixel() {
    let mut scene = raining(10.0, 1.5, 512, 40.0);
    scene.time = -12.75;
    scene.camera.position = DVec3::new(0.3, 100.0, 0.0);
    scene.camera.target = DVec3::new(0.3, 100.0, -1.0);
    let focal = 256.0 / 20_f64.to_radians().tan();
    let covered = opacities(&scene, 16, None, 0);
    let (mut least, mut most) = (0.0, 0.0);
    let mut explained = vec![false; covered.len()];
    let mut seen = 0;
    for drop in walk(&scene, 1.5) {
        let depth = -drop.center.z;
        let (x, y) = (256.0 + focal * drop.center.x / depth, 256.0 - focal * drop.center.y / depth);
        let radius = focal * 0.5e-3 * drop.diameter_mm / depth;
        let is_inside = |at: f64| (-radius..512.0 + radius).contains(&at);
        if depth <= 0.0 || !is_inside(x) || !is_inside(y) {
            continue;
        }
        for row in (y - radius - 1.0).max(0.0) as usize..=(y + radius + 1.0).min(511.0) as usize {
            for column in
                (x - radius - 1.0).max(0.0) as usize..=(x + radius + 1.0).min(511.0) as usize
            {
                explained[row * 512 + column] = true;
            }
        }
        let is_within = |at: f64| (radius..512.0 - radius).contains(&at);
        // Off the axis a sphere's outline is an ellipse.
        let area = PI * radius * radius * drop.center.length() / depth;
        most += area;
        if is_within(x) && is_within(y) {
            least += area;
            // A drop of 0.75 pixels around a pixel's corner covers 0.44 of the pixel.
            if radius > 0.75 {
                assert!(covered[y as usize * 512 + x as usize] > 0.3, "at {x}, {y}: {radius}");
                seen += 1;
            }
        }
    }
    assert!(seen >= 10, "{seen} drops");
    assert!(
        covered.iter().zip(&explained).all(|(covered, explained)| *covered == 0.0 || *explained)
    );
    let all: f64 = covered.iter().sum();
    // The picture's edge cuts some.
    let expected = 0.97 * least..1.03 * most;
    assert!(
        expected.contains(&all) && most < 1.6 * least,
        "{all} pixels are covered, not {expected:?}"
    );
}

/// D / (v T), whatever the distance: drops of 9 mm, 9.17 m/s.
#[test]
fn a_streak_is_as_opaque_as_its_drop_is_long_there() {
    let shutter = 1.0 / 250.0;
    let (mut seen, mut found, mut expected) = (0, 0.0, 0.0);
    for seed in 0..6 {
        let mut scene = with_rain(raining(20.0, 2.0, 256, 40.0), |rain| {
            (rain.sizes, rain.diameters) = (Sizes::Uniform, [9.0, 9.001]);
        });
        (scene.seed, scene.camera.shutter) = (seed, shutter);
        let focal = 128.0 / 20_f64.to_radians().tan();
        let covered = opacities(&scene, 64, None, 0);
        for drop in walk(&scene, 2.0) {
            let middle = drop.center + 0.5 * shutter * drop.velocity;
            let depth = -middle.z;
            let (x, y) = (128.0 + focal * middle.x / depth, 128.0 - focal * middle.y / depth);
            let radius = focal * 4.5e-3 / depth;
            if depth <= 0.0
                || !(3.0..253.0).contains(&x)
                || !(3.0..253.0).contains(&y)
                || radius < 0.8
            {
                continue;
            }
            // Across the streak all columns together hold its area: 2 r/ℓ times π r/2.
            let row = y as usize * 256;
            let around = (x - radius - 1.0) as usize..=(x + radius + 1.0) as usize;
            let sum: f64 = around.map(|column| covered[row + column]).sum();
            found += sum;
            expected += 0.5 * PI * radius * 9e-3 / (9.17 * shutter);
            seen += 1;
        }
    }
    assert!((found / expected - 1.0).abs() < 0.06, "{found}, not {expected}");
    assert!(seen >= 4, "{seen} streaks");
}

/// Where no bound is given the picture holds thirty million drops, at any field of view.
#[test]
fn the_usual_bound_holds_so_many_drops() {
    let law: Law = raining(25.0, 1e3, 8, 60.0).real_rain().expect("rain").law();
    // Solid angle of a square picture: the integral of 1/(1 + x² + y²)^(3/2).
    let solid_angle = |tan: f64| {
        let steps = 1000;
        let at = |n: i32| tan * (2.0 * (f64::from(n) + 0.5) / f64::from(steps) - 1.0);
        let cell = (2.0 * tan / f64::from(steps)).powi(2);
        let of = |n: i32| (1.0 + at(n % steps).powi(2) + at(n / steps).powi(2)).powf(-1.5) * cell;
        (0..steps * steps).map(of).sum::<f64>()
    };
    for fov in [10.0, 60.0, 150.0] {
        let scene = raining(25.0, 1e3, 256, fov);
        let bound = usual_bound(&scene).expect("rain");
        let drops =
            law.number() * solid_angle((0.5 * fov).to_radians().tan()) * bound.powi(3) / 3.0;
        assert!((drops / 3e7 - 1.0).abs() < 0.01, "{fov}: {drops}");
    }
    assert_eq!(usual_bound(&raining(25.0, 7.0, 256, 60.0)), Some(7.0));
    assert_eq!(usual_bound(&Scene::default()), None);
}
