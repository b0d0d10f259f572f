//! Glints that are found against glints that are met by chance.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::environment::bright::split;
use raindrops::picture::Picture;
use raindrops::picture::metrics::{box_filter, mean_square};
use raindrops::picture::tone_map::{display, exposure_of};
use raindrops::reference::{Tracer, Truth, Weights};
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::{Random, painted, with_halo};

/// A grey slope with a disc of so many degrees of radius, 200 times as bright, so large that rays meet it.
pub fn with_disc(width: u32, toward: DVec3, degrees: f64) -> Environment {
    painted(width, |direction| {
        let is_lit = direction.angle_between(toward) < degrees.to_radians();
        let disc = if is_lit { Vec3::new(200.0, 180.0, 150.0) } else { Vec3::ZERO };
        disc + Vec3::splat(0.6 + 0.4 * direction.y as f32)
    })
}

/// Drops of 12 pixels of radius to a tenth, off the axis, one behind another's rim, one half faded in,
/// one that the picture's edge cuts.
fn drops() -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (64, 64);
    scene.camera.vertical_fov = 60.0;
    (scene.camera.near, scene.camera.near_fade) = (2.0, 4.0);
    let placed = |x, y, z, radius| PlacedDrop::sphere(DVec3::new(x, y, z), radius);
    scene.drops = vec![
        placed(-1.2, 0.9, -3.5, 0.7),
        placed(1.5, 0.4, -6.5, 0.8),
        placed(2.6, 0.9, -8.5, 0.9),
        placed(-1.0, -3.2, -5.6, 0.6),
    ];
    let mut random = Random(7);
    for _ in 0..60 {
        let mut at = |scale: f64| scale * (2.0 * random.unit() - 1.0);
        let center = DVec3::new(at(12.0), at(12.0), -24.0 + at(6.0));
        scene.drops.push(PlacedDrop::sphere(center, 0.1));
    }
    scene
}

pub fn traced(scene: &Scene, environment: &Environment, truth: Truth) -> Picture {
    Tracer::new(scene, environment, truth).picture()
}

/// Pictures that differ by their seed alone; drops and sources are sorted once.
pub fn by_seed(scene: &Scene, environment: &Environment, truth: Truth, seeds: u64) -> Vec<Picture> {
    let tracer = Tracer::new(scene, environment, truth);
    (0..seeds).map(|seed| tracer.with_seed(seed).picture()).collect()
}

fn mean(picture: &Picture) -> f64 {
    let sum: DVec3 = picture.pixels.iter().map(|pixel| pixel.as_dvec3()).sum();
    sum.element_sum() / (3.0 * picture.pixels.len() as f64)
}

/// How many seeds tell a picture's noise.
pub const SEEDS: u64 = 8;

/// How far the means of two sets of pictures are apart, over what their noise predicts: root mean square
/// over pixels; and the whole picture's mean. The pictures of a set differ by their seed.
pub fn apart(found: &[Picture], met: &[Picture]) -> [f64; 2] {
    let count = SEEDS as f64;
    // Mean and variance of the mean.
    let of = |values: &mut dyn Iterator<Item = DVec3>| {
        let (sum, squares) =
            values.fold((DVec3::ZERO, DVec3::ZERO), |(sum, squares), v| (sum + v, squares + v * v));
        (sum / count, (squares - sum * sum / count) / (count * (count - 1.0)))
    };
    let (mut difference, mut squares, mut variance) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for pixel in 0..found[0].pixels.len() {
        let [(a, of_a), (b, of_b)] = [found, met].map(|pictures| {
            of(&mut pictures.iter().map(|picture| picture.pixels[pixel].as_dvec3()))
        });
        difference += a - b;
        squares += (a - b).length_squared();
        variance += of_a + of_b;
    }
    let noise = variance.element_sum().sqrt();
    [squares.sqrt() / noise, difference.length() / noise]
}

#[test]
fn found_glints_are_those_that_chance_meets() {
    let scene = drops();
    let toward = |number: usize| scene.drops[number].center.normalize();
    let all = |environment: &Environment, truth| by_seed(&scene, environment, truth, SEEDS);
    let boxed = |pictures: &[Picture]| pictures.iter().map(box_filter).collect::<Vec<_>>();
    let whole = Truth { samples: 64, ..Truth::default() };
    // Beside the picture; straight behind a drop, where its image is a ring; straight behind the camera
    // as another drop sees it, likewise.
    for (disc, truth, control) in [
        (DVec3::new(0.8, 0.4, -0.5).normalize(), whole, true),
        (toward(1), Truth { weights: Weights::Paper, ..whole }, false),
        (-toward(0), Truth { internal_reflections: 1, ..whole }, false),
    ] {
        let environment = with_disc(256, disc, 4.0);
        assert_eq!(split(&environment).expect("a disc").regions.len(), 1);
        let met = all(&environment, Truth { samples: 256, glints: false, ..truth });
        let far_apart = |truth: Truth| {
            let found = all(&environment, truth);
            let ([pixels, mean], [boxes, _]) =
                (apart(&found, &met), apart(&boxed(&found), &boxed(&met)));
            println!("{pixels:.2} pixels, {boxes:.2} boxes, {mean:.2} mean, {truth:?}");
            (pixels, boxes, mean)
        };
        // Some tens of bright pixels make most of the noise: it is known to a fifth or so.
        let (pixels, boxes, mean) = far_apart(truth);
        assert!((0.7..1.4).contains(&pixels) && (0.5..1.6).contains(&boxes) && mean < 3.0);
        if control {
            // With a way of the light left out they are apart.
            let (_, boxes, mean) = far_apart(Truth { reflection: false, ..truth });
            assert!(boxes > 2.0 && mean > 6.0);
        }
    }
}

#[test]
fn under_a_bare_sun_the_truth_converges() {
    let sky = Environment::bundled().expect("the sky");
    let rest = split(&sky).expect("a sun").rest;
    let mut scene = Scene::default();
    (scene.image.width, scene.image.height) = (96, 96);
    scene.rain = Some(RainSettings { count: 50_000, ..RainSettings::default() });
    let truth = Truth { samples: 256, ..Truth::default() };
    let found = by_seed(&scene, &sky, truth, 2);
    let met = by_seed(&scene, &sky, Truth { glints: false, ..truth }, 8);
    let without = by_seed(&scene, &rest, truth, 2);

    let exposure = exposure_of(&scene.tone_map, &found[0]);
    let shown = |picture: &Picture| display(exposure, picture);
    let differ = |of: &[Picture]| mean_square(&shown(&of[0]), &shown(&of[1])).sqrt();
    let [of_found, of_met, of_rest] = [&found, &met, &without].map(|of| differ(of));
    println!("two seeds differ by {of_found:.4} RMS, by chance {of_met:.4}, no sun {of_rest:.4}");
    // Not much beyond the noise of edges, which has nothing to do with the sun: usual 1.5 times.
    assert!(of_found < 1.7 * of_rest);
    // The control: by chance it is, usual 7 times.
    assert!(of_met > 4.0 * of_rest);

    // The light is equal: eight pictures by chance have a mean, and an error of it.
    let means: Vec<f64> = met.iter().map(mean).collect();
    let middle = means.iter().sum::<f64>() / 8.0;
    let spread = means.iter().map(|mean| (mean - middle).powi(2)).sum::<f64>() / 7.0;
    let error = (spread / 8.0).sqrt();
    let without = mean(&without[0]);
    let [a, b] = [mean(&found[0]), mean(&found[1])];
    println!("means: found {a:.5} and {b:.5}, met {middle:.5} ± {error:.5}, no sun {without:.5}");
    assert!((a - b).abs() < 0.2 * error);
    assert!((a - middle).abs() < 3.0 * error);
    // The control: the sun is more than that.
    assert!(a - without > 4.0 * error);
}

#[test]
fn glints_do_not_depend_on_the_threads_and_without_a_source_there_are_none() {
    let scene = drops();
    let environment = with_disc(256, DVec3::new(0.8, 0.4, -0.5).normalize(), 4.0);
    let truth = Truth { samples: 4, ..Truth::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| traced(&scene, &environment, truth))
    };
    assert_eq!(on(1), on(3));
    // Nothing to look for, or nothing looked for: the same to the bit.
    let by_chance = Truth { glints: false, ..truth };
    let rest = split(&environment).expect("a disc").rest;
    assert_eq!(traced(&scene, &rest, truth), traced(&scene, &rest, by_chance));
    assert_ne!(traced(&scene, &environment, truth), traced(&scene, &environment, by_chance));
    let [seeing, by_chance] = [truth, by_chance].map(|truth| Truth { drops_see_drops: 1, ..truth });
    assert_eq!(traced(&scene, &environment, seeing), traced(&scene, &environment, by_chance));
}

/// Lamps on the seam, over a pole, and two that touch by their interpolation alone.
#[test]
fn the_parts_of_an_environment_add_up() {
    let (width, height) = (128_u32, 64_u32);
    let mut random = Random(3);
    let mut texels: Vec<Vec3> = (0..width * height)
        .map(|_| Vec3::new(random.unit() as f32, random.unit() as f32, random.unit() as f32))
        .collect();
    let mut lamp = |column: u32, row: u32, radiance: Vec3| {
        texels[(row * width + column) as usize] = radiance;
    };
    lamp(127, 20, Vec3::new(1e3, 2e3, 0.5));
    lamp(0, 21, Vec3::splat(3e3));
    lamp(40, 0, Vec3::splat(9e4));
    lamp(70, 40, Vec3::splat(5e3));
    lamp(72, 41, Vec3::splat(5e3));
    let environment = Environment::from_texels("lamps", width, height, texels).expect("valid");
    let parts = split(&environment).expect("lamps");
    assert_eq!(parts.regions.len(), 4);
    let mut lit = 0;
    for number in 0..200_000 {
        // Half of them near a lamp.
        let region = &parts.regions[number % 4];
        let scatter = if number % 2 == 0 { 2.0 } else { 0.1 };
        let direction = (region.direction + scatter * random.direction()).normalize();
        let mut sum = parts.rest.radiance(direction);
        for region in &parts.regions {
            let excess = region.radiance(direction);
            sum += excess;
            let is_within = direction.angle_between(region.direction) <= region.radius;
            assert!(is_within || excess == DVec3::ZERO, "{direction} is lit beyond the cap");
            lit += u32::from(excess != DVec3::ZERO);
        }
        let whole = environment.radiance(direction);
        assert!((sum - whole).abs().max_element() < 1e-6 * whole.max_element(), "{direction}");
    }
    assert!(lit > 10_000, "only {lit} lit: nothing was tested");
}

#[test]
fn the_layers_of_a_sun_in_its_halo_add_up() {
    let toward = DVec3::new(0.8, 0.4, -0.5).normalize();
    let environment = with_halo(toward);
    let whole = split(&environment).expect("a sun");
    assert_eq!(whole.regions.len(), 1);
    let parts = whole.clone().in_layers(&environment);
    let radii: Vec<f64> = parts.regions.iter().map(|layer| layer.radius.to_degrees()).collect();
    println!("radii of the layers in degrees: {radii:.2?}");
    assert!(radii.len() > 1 && radii.windows(2).all(|pair| pair[1] <= 0.5 * pair[0]), "{radii:?}");
    assert!((parts.strength() / whole.strength() - 1.0).abs() < 1e-6);
    let mut random = Random(5);
    for _ in 0..100_000 {
        let direction = (toward + 0.2 * random.unit() * random.direction()).normalize();
        let sum: DVec3 = parts.regions.iter().map(|layer| layer.radiance(direction)).sum();
        let expected = whole.regions[0].radiance(direction);
        assert!(
            (sum - expected).abs().max_element() <= 1e-5 * expected.max_element(),
            "{direction}"
        );
    }
}

/// A sun takes a hundredth of its halo's cap: samples spread over the cap would miss it in small drops.
#[test]
fn in_a_halo_the_truth_converges() {
    let environment = with_halo(DVec3::new(0.8, 0.4, -0.5).normalize());
    let rest = split(&environment).expect("a sun").rest;
    let scene = drops();
    let pictures = |environment: &Environment| {
        let truth = Truth { samples: 64, ..Truth::default() };
        [0, 1].map(|seed| traced(&scene, environment, Truth { seed, ..truth }))
    };
    let found = pictures(&environment);
    let exposure = exposure_of(&scene.tone_map, &found[0]);
    let differ = |of: [Picture; 2]| {
        let [a, b] = of.map(|picture| display(exposure, &picture));
        mean_square(&a, &b).sqrt()
    };
    let (of_found, of_rest) = (differ(found), differ(pictures(&rest)));
    println!("two seeds differ by {of_found:.4} RMS, without the sun by {of_rest:.4}");
    assert!(of_found < 1.5 * of_rest);
}
