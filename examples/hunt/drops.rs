//! The drops of a random scene: placed one by one in the picture, equal ones in boxes, or rain by its rate; with the motion
//! and the lens that go with their size.

use glam::{DVec2, DVec3};
use raindrops::scene::camera::View;
use raindrops::scene::model::{DropShape, Sizes};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, Population, RainSettings, Scene};

use super::random::Random;
use super::scene::frame;

/// Least field of view of rain by its rate, in degrees.
const NARROWEST_RAIN: f64 = 20.0;

/// What falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subject {
    /// One to four drops of any size.
    Few,
    /// A row of drops, whose radius grows along it, or of equal ones.
    Row,
    /// Tens of drops, most of them small.
    Many,
    /// Rain in boxes.
    Box,
    /// Rain by its rate.
    RealRain,
}

impl Subject {
    /// One of them.
    pub fn pick(random: &mut Random) -> Self {
        let choices = [
            (0.25, Self::Few),
            (0.2, Self::Row),
            (0.13, Self::Many),
            (0.18, Self::Box),
            (0.24, Self::RealRain),
        ];
        random.pick(&choices)
    }

    /// About how far away drops are that one sees, in scene units.
    pub fn distance(self, scene: &Scene) -> f64 {
        let nearest = |drops: &[PlacedDrop]| {
            let at = frame(scene).camera.position;
            drops.iter().map(|drop| drop.center.distance(at)).fold(f64::INFINITY, f64::min)
        };
        match (self, &scene.rain) {
            (Self::RealRain, _) => 3.0 / scene.metres,
            (Self::Box, Some(rain)) => 0.3 * rain.half_extent.min_element(),
            _ => nearest(&scene.drops).clamp(1e-6, 1e6),
        }
    }
}

/// Adds what falls; the lens goes with its distance.
pub fn add_drops(scene: &mut Scene, subject: Subject, random: &mut Random) {
    match subject {
        Subject::Few | Subject::Row | Subject::Many => placed(scene, subject, random),
        Subject::Box => boxes(scene, random),
        Subject::RealRain => real_rain(scene, random),
    }
    if random.chance(0.35) {
        let distance = subject.distance(scene);
        lens(scene, distance, random);
    }
    // Placed drops before or in rain.
    if matches!(subject, Subject::Box | Subject::RealRain) && random.chance(0.15) {
        placed(scene, Subject::Few, random);
    }
    if random.chance(0.08) {
        scene.camera.near = subject.distance(scene) * random.log(0.02, 0.5);
        if random.chance(0.6) {
            scene.camera.near_fade = scene.camera.near * random.log(0.1, 3.0);
        }
    }
}

/// Out of focus by so many pixels at this distance.
fn lens(scene: &mut Scene, distance: f64, random: &mut Random) {
    let focal = scene.view().focal_px;
    let focus = distance * random.log(0.2, 20.0);
    let focus = if random.chance(0.15) { f64::INFINITY } else { focus };
    let per_unit = focal * (distance.recip() - focus.recip()).abs();
    let blur_px = random.log(0.3, 40.0);
    scene.camera.focus = focus;
    // What is far away is blurred by so many pixels at most; and a lens as wide as its distance from the drops would be all
    // that is seen.
    let of_far = if scene.real_rain().is_some() { 25.0 } else { 80.0 } * focus / focal;
    scene.camera.aperture = (blur_px / per_unit).min(0.5 * distance).min(of_far);
}

/// The motion of placed drops.
#[derive(Clone, Copy)]
enum Moves {
    Not,
    Across,
    Along,
    Falls,
}

fn placed(scene: &mut Scene, subject: Subject, random: &mut Random) {
    let frame = frame(scene);
    let view = frame.view();
    let high = f64::from(view.height);
    let distance = match scene.rain {
        None => random.log(0.05, 300.0),
        Some(_) => Subject::distance(
            if scene.real_rain().is_some() { Subject::RealRain } else { Subject::Box },
            scene,
        ),
    };
    // A drop must be smaller than its distance: the camera is outside.
    let most_px = (0.9 * view.focal_px).min(0.6 * high);
    let radii: Vec<f64> = match subject {
        Subject::Row => {
            let (count, first) = (random.whole(4, 10), random.log(0.3, 16.0));
            let grows = random.log(1.1, 1.6);
            let ratio = random.pick(&[(0.4, 1.0), (0.6, grows)]);
            let radius = |number| (first * ratio.powi(number)).min(most_px);
            (0..count as i32).map(radius).collect()
        }
        Subject::Many => (0..random.whole(20, 150)).map(|_| random.log(0.05, 20.0)).collect(),
        _ => (0..random.whole(1, 4)).map(|_| random.log(0.5, most_px)).collect(),
    };
    let moves = random.pick(&[
        (0.4, Moves::Not),
        (0.27, Moves::Across),
        (0.18, Moves::Along),
        (0.15, Moves::Falls),
    ]);
    let moves_as_one = random.chance(0.6);
    let all_move = (random.direction(), random.log(0.2, 80.0), random.between(-0.6, 0.6));
    let shape_of_all = shape(random);
    let has_one_shape = random.chance(0.5);
    let row_angle = random.between(0.0, 3.0);
    let count = radii.len() as f64;
    for (number, radius_px) in (0..).map(f64::from).zip(radii) {
        let size = DVec2::new(view.width.into(), view.height.into());
        let at = match subject {
            Subject::Row => {
                let along = DVec2::from_angle(row_angle) * size.min_element() * 0.9;
                0.5 * size + ((number + 0.5) / count - 0.5) * along
            }
            Subject::Few => size * DVec2::new(random.between(0.1, 0.9), random.between(0.1, 0.9)),
            _ => size * DVec2::new(random.between(-0.05, 1.05), random.between(-0.05, 1.05)),
        };
        let away = match subject {
            Subject::Row => distance,
            _ => distance * random.log(0.6, 1.7),
        };
        let ray = view.ray(at.x, at.y);
        let depth = away * -ray.dot(view.back);
        let radius = (radius_px * depth / view.focal_px).min(0.9 * away);
        let own = (random.direction(), random.log(0.2, 80.0), random.between(-0.6, 0.6));
        let (toward, motion_px, closer) = if moves_as_one { all_move } else { own };
        let unit = depth / view.focal_px;
        let motion = match moves {
            Moves::Not => DVec3::ZERO,
            Moves::Across => motion_px * unit * (toward - toward.dot(ray) * ray),
            Moves::Along => closer * (away - radius) * ray,
            Moves::Falls => motion_px * unit * DVec3::NEG_Y,
        };
        scene.drops.push(moving(&frame, view, at, away, (radius, motion)));
        let shape = if has_one_shape { shape_of_all } else { shape(random) };
        if let Some(drop) = scene.drops.last_mut() {
            (drop.axis_ratio, drop.shape) = shape;
        }
    }
    // The equilibrium shape is that of millimetres.
    if scene.drops.iter().any(|drop| drop.shape == Some(DropShape::Equilibrium))
        && scene.rain.is_none()
    {
        let radius = scene.drops.iter().map(|drop| drop.radius).fold(0.0, f64::max);
        scene.metres = random.log(0.0007, 0.004) / radius;
    }
}

/// A drop that in the middle of the exposure stands at a place of the picture, and moves so far while it lasts.
fn moving(
    frame: &Scene,
    view: View,
    at: DVec2,
    away: f64,
    (radius, motion): (f64, DVec3),
) -> PlacedDrop {
    let exposed = frame.exposed();
    let middle = view.position + away * view.ray(at.x, at.y);
    // An instant shows no velocity; the drop has one all the same.
    let velocity = if exposed == 0.0 { motion } else { motion / exposed };
    let center = middle - velocity * (frame.time + 0.5 * exposed);
    PlacedDrop { velocity, ..PlacedDrop::sphere(center, radius) }
}

fn shape(random: &mut Random) -> (Option<f64>, Option<DropShape>) {
    match random.pick(&[(0.55, 0), (0.2, 1), (0.05, 2), (0.15, 3), (0.05, 4)]) {
        1 => (Some(random.between(0.3, 1.5)), None),
        2 => (Some(random.log(0.06, 15.0)), None),
        3 => (None, Some(DropShape::Equilibrium)),
        4 => (None, Some(DropShape::Sphere)),
        _ => (None, None),
    }
}

fn boxes(scene: &mut Scene, random: &mut Random) {
    let other_unit = random.log(0.01, 10.0);
    let unit = random.pick(&[(0.7, 1.0), (0.3, other_unit)]);
    let exposed = frame(scene).exposed().abs();
    let populations = random.pick(&[(0.8, 1), (0.1, 2), (0.06, 3), (0.04, 4)]);
    let each: Vec<Population> = (0..populations)
        .map(|_| {
            let half = random.log(15.0, 700.0);
            let other = random.log(0.2, 3.0);
            let radius = unit * random.pick(&[(0.6, 1.0), (0.4, other)]);
            let half_extent = if random.chance(0.7) {
                DVec3::splat(half * unit)
            } else {
                let mut edge = || half * unit * random.between(0.6, 1.4);
                DVec3::new(edge(), edge(), edge())
            };
            // So many that a quarter of the picture, or all of it several times, is covered.
            let volume = 8.0 * half.powi(3);
            let most = (volume / 60.0).min(120_000.0);
            let count = random.log(200.0, most.max(400.0)) as u32;
            let aslant = random.direction();
            let toward = random.pick(&[(0.6, DVec3::NEG_Y), (0.4, aslant)]);
            let pixel = 0.3 * half_extent.min_element() / scene.view().focal_px;
            let moved = (random.log(0.3, 60.0) * pixel).min(0.3 * half_extent.min_element());
            let speed = if exposed > 0.0 { moved / exposed } else { 9.0 };
            let seed = random.chance(0.2).then(|| random.bits() >> 12);
            Population { seed, count, half_extent, radius, velocity: speed * toward }
        })
        .collect();
    let Population { seed, count, half_extent, radius, velocity } = each[0];
    let mut rain =
        RainSettings { seed, count, half_extent, radius, velocity, ..RainSettings::default() };
    for (place, population) in rain.others.iter_mut().zip(&each[1..]) {
        *place = Some(*population);
    }
    scene.rain = Some(rain);
    if random.chance(0.6) {
        scene.camera.near = unit * random.log(1.2, 12.0);
    }
}

fn real_rain(scene: &mut Scene, random: &mut Random) {
    if random.chance(0.12) {
        let (metres, forward) = (random.log(0.01, 20.0), scene.camera.forward());
        scene.camera.position /= metres;
        scene.camera.target = scene.camera.position + forward;
        scene.metres = metres;
    }
    // Through a narrower view a reference takes minutes: rays go far through many cells.
    let narrow = |fov: &mut f64| *fov = fov.max(NARROWEST_RAIN);
    narrow(&mut scene.camera.vertical_fov);
    scene.film.camera.iter_mut().filter_map(|key| key.vertical_fov.as_mut()).for_each(narrow);
    let other = random.log(3.0, 3000.0);
    let extent = random.pick(&[(0.3, f64::INFINITY), (0.3, 300.0), (0.4, other)]);
    let sizes =
        random.pick(&[(0.75, Sizes::MarshallPalmer), (0.15, Sizes::Gamma), (0.1, Sizes::Uniform)]);
    let mut rain = RealRain { rate: random.log(0.5, 500.0), sizes, extent, ..RealRain::default() };
    if sizes == Sizes::Gamma {
        rain.mu = random.between(-0.5, 8.0);
    }
    if random.chance(0.15) {
        let from = random.log(0.15, 2.0);
        rain.diameters = [from, (from * random.log(1.2, 6.0)).min(8.0)];
        // Between narrow diameters Ulbrich's law makes no heavy rain.
        let [from, to] = rain.diameters;
        rain.median_diameter = (sizes == Sizes::Gamma).then(|| (from * to).sqrt());
    }
    if random.chance(0.1) {
        rain.air_density = random.between(0.4, 2.0);
    }
    if random.chance(0.4) {
        rain.wind = random.log(0.5, 25.0) * random.direction() * DVec3::new(1.0, 0.2, 1.0);
    }
    if random.chance(0.15) {
        rain.shape = DropShape::Sphere;
    }
    scene.rain = Some(RainSettings::of(rain));
}
