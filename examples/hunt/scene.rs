//! A random scene: a pure function of a seed and a number. Each part (camera, drops, light, …) has a stream of random
//! numbers of its own. Sizes and blurs are chosen in pixels first, so that each of them occurs at every distance.

use glam::{DQuat, DVec3, Vec3};
use raindrops::picture::Picture;
use raindrops::scene::background::DepthKind;
use raindrops::scene::camera::Camera;
use raindrops::scene::film::{CameraKey, PaceKey};
use raindrops::scene::model::Operator;
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, Scene};

use super::drops::{Subject, add_drops};
use super::random::Random;
use super::skies::{Sky, plate};
use super::text;

/// Stands in a scene's text for the folder of the photographs that `scripts/setup.sh` fetches.
pub const PHOTOGRAPHS: &str = "ENVIRONMENTS";

const PHOTOGRAPH_NAMES: [&str; 8] =
    ["city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset"];

/// A file beside a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Beside {
    /// Surroundings, and the numbers that they are painted by.
    Sky(Sky, Random),
    /// What is behind the drops.
    Radiance(Picture),
    /// Depth of each pixel, in scene units over the scale: as channel Z of an EXR, or as a PNG of 16 bits.
    Depth([u32; 2], Vec<f32>),
}

/// A scene as it is drawn from a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// The scene file.
    pub text: String,
    /// The files that it names, by name.
    pub files: Vec<(String, Beside)>,
}

/// Scene `number` of `seed`.
pub fn make(seed: u64, number: u64) -> Made {
    let part = |name| Random::of(seed, number, name);
    // A whole number of a TOML file has 63 bits.
    let mut scene = Scene { rain: None, seed: part("seed").bits() >> 12, ..Scene::default() };
    let mut random = part("subject");
    let subject = Subject::pick(&mut random);
    image(&mut scene, &mut part("image"));
    camera(&mut scene, &mut part("camera"));
    film(&mut scene, &mut part("film"));
    shutter(&mut scene, &mut part("shutter"), subject);
    add_drops(&mut scene, subject, &mut part("drops"));
    water(&mut scene, &mut part("water"), subject);
    let mut files = Vec::new();
    light(&mut scene, &mut part("light"), &mut files);
    background(&mut scene, &mut part("background"), subject, &mut files);
    tone_map(&mut scene, &mut part("tone map"));
    accepted(&mut scene, &mut part("model"));
    Made { text: text::of(&scene), files }
}

/// The frame that is drawn of a scene: the first of its film.
pub fn frame(scene: &Scene) -> Scene {
    scene.film.frame(scene, 0)
}

fn image(scene: &mut Scene, random: &mut Random) {
    let edge = |random: &mut Random| random.whole(96, 192);
    scene.image = match random.pick(&[(0.72, 0), (0.16, 1), (0.12, 2)]) {
        0 => ImageSize { width: 96, height: 96 },
        1 => ImageSize { width: edge(random), height: edge(random) },
        _ => {
            // A window of it is drawn, at pixels' edges.
            let image = ImageSize { width: random.whole(130, 400), height: random.whole(130, 300) };
            let part = |random: &mut Random, pixels: u32| {
                let drawn = random.whole(96, 128);
                let low = random.whole(0, pixels - drawn);
                [low, low + drawn].map(|at| f64::from(at) / f64::from(pixels))
            };
            let (across, down) = (part(random, image.width), part(random, image.height));
            scene.camera.window = [across[0], down[0], across[1], down[1]];
            image
        }
    };
    if random.chance(0.1) {
        scene.camera.principal = [random.between(0.2, 0.8), random.between(-0.3, 1.3)];
    }
}

fn camera(scene: &mut Scene, random: &mut Random) {
    let camera = &mut scene.camera;
    if random.chance(0.3) {
        camera.position = random.log(0.1, 100.0) * random.direction();
    }
    let elevation: f64 = match random.pick(&[(0.45, 0), (0.17, 1), (0.17, 2), (0.03, 3), (0.18, 4)])
    {
        0 => random.between(-8.0, 8.0),
        1 => random.between(15.0, 88.0),
        2 => random.between(-88.0, -15.0),
        3 => random.pick(&[(0.5, -90.0), (0.5, 90.0)]),
        _ => random.between(-60.0, 60.0),
    };
    let (azimuth, elevation) = (random.between(-180.0, 180.0).to_radians(), elevation.to_radians());
    let level = DVec3::new(azimuth.sin(), 0.0, -azimuth.cos());
    let toward = elevation.cos() * level + elevation.sin() * DVec3::Y;
    camera.target = camera.position + toward;
    if random.chance(0.3) {
        camera.up = DQuat::from_axis_angle(toward, random.between(-3.1, 3.1)) * DVec3::Y;
    }
    camera.vertical_fov = match random.pick(&[(0.55, 0), (0.25, 1), (0.15, 2), (0.05, 3)]) {
        0 => random.between(30.0, 75.0),
        1 => random.log(2.0, 30.0),
        2 => random.between(75.0, 130.0),
        _ => random.between(130.0, 165.0),
    };
}

/// The first frame of a film: from a key of the camera, at a pace.
fn film(scene: &mut Scene, random: &mut Random) {
    if !random.chance(0.08) {
        return;
    }
    scene.film.fps = random.pick(&[(0.4, 24.0), (0.4, 60.0), (0.2, -25.0)]);
    if random.chance(0.6) {
        let rate = random.pick(&[(0.6, 1.0), (0.4, -1.0)]) * random.log(0.02, 2.0);
        scene.film.pace =
            vec![PaceKey { at: 0.0, rate }, PaceKey { at: 2.0, rate: random.between(0.0, 1.0) }];
    }
    if random.chance(0.5) {
        let Camera { position, target, vertical_fov, .. } = scene.camera;
        let fov = random.chance(0.5).then_some(vertical_fov);
        let (first, last) = (random.direction(), random.direction());
        let key = |at, by: DVec3| CameraKey {
            at,
            position: position + 1e-3 * by,
            target,
            vertical_fov: fov,
        };
        scene.film.camera = vec![key(0.0, first), key(1.0, last)];
    }
}

/// How long it is exposed; by a lens out of focus where there is one is decided with the drops.
fn shutter(scene: &mut Scene, random: &mut Random, subject: Subject) {
    if random.chance(0.25) {
        scene.time = random.pick(&[(0.8, 1.0), (0.2, -1.0)]) * random.log(0.01, 1e4);
    }
    let seconds = match subject {
        Subject::RealRain => random.log(1e-4, 0.1),
        _ => random.log(1e-3, 0.5),
    };
    if random.chance(0.5) {
        scene.camera.shutter = seconds;
        if random.chance(0.12) {
            let angle = 360.0 * seconds * scene.film.fps.abs();
            (scene.camera.shutter, scene.camera.shutter_angle) = (0.0, Some(angle.min(360.0)));
        }
    }
}

fn water(scene: &mut Scene, random: &mut Random, subject: Subject) {
    let usual = if subject == Subject::RealRain { 0.8 } else { 0.55 };
    let rest = 1.0 - usual;
    match random.pick(&[(usual, 0), (0.55 * rest, 1), (0.25 * rest, 2), (0.2 * rest, 3)]) {
        0 => {}
        1 => scene.water.index = Some(Index::One(random.between(1.02, 2.4))),
        2 => {
            let (green, spread) = (random.between(1.1, 2.3), random.log(0.002, 0.06));
            scene.water.index = Some(Index::Colors([green - spread, green, green + spread]));
        }
        _ => {
            // Bubbles, and drops in something else.
            scene.water.outside = random.between(1.1, 1.7);
            scene.water.index = Some(Index::One(random.pick(&[(0.6, 1.0), (0.4, 1.5)])));
        }
    }
}

fn light(scene: &mut Scene, random: &mut Random, files: &mut Vec<(String, Beside)>) {
    let made = match random.pick(&[
        (0.3, 0),
        (0.08, 1),
        (0.04, 2),
        (0.16, 3),
        (0.14, 4),
        (0.13, 5),
        (0.15, 6),
    ]) {
        0 => {
            let name = PHOTOGRAPH_NAMES[random.whole(0, 7) as usize];
            scene.environment.file = Some(format!("{PHOTOGRAPHS}/{name}.exr").into());
            return;
        }
        1 => return, // the bundled sky
        2 => {
            let radiance = [(); 3].map(|()| random.log(0.1, 3.0) as f32);
            scene.environment.radiance = Some(Vec3::from_array(radiance));
            return;
        }
        3 => Sky::Suns,
        4 => Sky::Lamps,
        5 => Sky::Room,
        _ => Sky::Clouds,
    };
    files.push(("sky.exr".into(), Beside::Sky(made, random.clone())));
    scene.environment.file = Some("sky.exr".into());
}

/// Walls that drops come out of.
fn background(
    scene: &mut Scene,
    random: &mut Random,
    subject: Subject,
    files: &mut Vec<(String, Beside)>,
) {
    if !random.chance(0.14) {
        return;
    }
    let ImageSize { width, height } = scene.image;
    let (color, mut depth) = plate(random, [width, height], subject.distance(scene));
    if random.chance(0.85) {
        files.push(("plate.exr".into(), Beside::Radiance(color)));
        scene.background.color = Some("plate.exr".into());
    }
    if scene.background.color.is_none() || random.chance(0.85) {
        let mut name = "depth.exr";
        if random.chance(0.3) {
            scene.background.depth_kind = DepthKind::Radial;
        }
        if random.chance(0.3) {
            name = random.pick(&[(0.5, "depth.exr"), (0.5, "depth.png")]);
            let nearest = depth.iter().copied().fold(f32::INFINITY, f32::min);
            let scale = f64::from(nearest) / 1000.0;
            scene.background.depth_scale = Some(scale);
            depth.iter_mut().for_each(|z| *z = (f64::from(*z) / scale) as f32);
        }
        files.push((name.into(), Beside::Depth([width, height], depth)));
        scene.background.depth = Some(name.into());
    }
}

fn tone_map(scene: &mut Scene, random: &mut Random) {
    let tone_map = &mut scene.tone_map;
    match random.pick(&[(0.8, 0), (0.08, 1), (0.06, 2), (0.06, 3)]) {
        1 => tone_map.key = random.log(0.06, 0.5),
        2 => tone_map.exposure = Some(random.log(0.1, 4.0)),
        3 => {
            tone_map.operator = Operator::None;
            tone_map.exposure = random.chance(0.6).then(|| random.log(0.2, 2.0));
        }
        _ => {}
    }
}

/// What preset `auto` is asked for.
fn accepted(scene: &mut Scene, random: &mut Random) {
    match random.pick(&[(0.85, 0), (0.1, 1), (0.05, 2)]) {
        1 => scene.model.error = Some(random.log(0.004, 0.05)),
        2 => scene.model.budget_ms = Some(random.log(2.0, 500.0)),
        _ => {}
    }
}
