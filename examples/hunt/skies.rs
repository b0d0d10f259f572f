//! Surroundings that are made up: suns over a plain sky, the lamps of a street at night, a dark room with windows, clouds.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use raindrops::picture::Picture;

use super::random::Random;

const WIDTH: u32 = 256;

/// What surroundings are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sky {
    /// One to six suns.
    Suns,
    /// Ten to three hundred lamps at night.
    Lamps,
    /// A dark room.
    Room,
    /// Clouds, with or without a sun among them.
    Clouds,
}

impl Sky {
    /// A picture of such surroundings.
    pub fn picture(self, random: &mut Random) -> Picture {
        match self {
            Self::Suns => suns(random),
            Self::Lamps => lamps(random),
            Self::Room => room(random),
            Self::Clouds => clouds(random),
        }
    }
}

/// Radiance by direction.
fn painted(radiance: impl Fn(DVec3) -> DVec3) -> Picture {
    let (width, height) = (WIDTH, WIDTH / 2);
    let texel = |at: u32| {
        let longitude = TAU * ((f64::from(at % width) + 0.5) / f64::from(width) - 0.5);
        let polar = PI * (f64::from(at / width) + 0.5) / f64::from(height);
        let (sine, cosine) = polar.sin_cos();
        let light = radiance(DVec3::new(sine * longitude.sin(), cosine, -sine * longitude.cos()));
        light.as_vec3().max(Vec3::ZERO)
    };
    Picture { width, height, pixels: (0..width * height).map(texel).collect() }
}

fn color(random: &mut Random, spread: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| random.between(1.0 - spread, 1.0 + spread)))
}

/// Sky above, ground below, without anything bright.
fn plain(random: &mut Random) -> impl Fn(DVec3) -> DVec3 + use<> {
    let zenith = random.log(0.1, 0.6) * DVec3::new(0.5, 0.7, 1.0);
    let horizon = random.log(0.3, 1.2) * color(random, 0.2);
    let ground = random.log(0.02, 0.4) * color(random, 0.4);
    move |direction: DVec3| {
        let up = direction.y;
        match up > 0.0 {
            true => horizon.lerp(zenith, up.sqrt()),
            false => ground * (1.0 + 0.5 * up),
        }
    }
}

/// A bright disc: where it is, how wide, how bright.
struct Disc {
    toward: DVec3,
    radius: f64,
    light: DVec3,
}

fn with_discs(behind: impl Fn(DVec3) -> DVec3, discs: &[Disc]) -> Picture {
    painted(|direction| {
        let near =
            discs.iter().filter(|disc| direction.dot(disc.toward) > (1.5 * disc.radius).cos());
        let of_discs = near.map(|disc| {
            let off = direction.dot(disc.toward).clamp(-1.0, 1.0).acos() / disc.radius;
            // A soft edge, so that a disc has about the same light wherever it is among the texels.
            disc.light * (1.5 - off).clamp(0.0, 1.0)
        });
        behind(direction) + of_discs.sum::<DVec3>()
    })
}

fn suns(random: &mut Random) -> Picture {
    let behind = plain(random);
    let discs: Vec<Disc> = (0..random.whole(1, 6))
        .map(|_| {
            let mut toward = random.direction();
            toward.y = toward.y.abs();
            let radius = random.log(0.9, 2.5).to_radians();
            Disc { toward, radius, light: random.log(3e2, 5e4) * color(random, 0.7) }
        })
        .collect();
    with_discs(behind, &discs)
}

fn lamps(random: &mut Random) -> Picture {
    let night = random.log(0.003, 0.1) * DVec3::new(0.6, 0.7, 1.0);
    let discs: Vec<Disc> = (0..random.log(10.0, 301.0) as u32)
        .map(|_| {
            let azimuth = random.between(0.0, TAU);
            let elevation = random.between(-0.35, 0.5);
            let toward = DVec3::new(azimuth.sin(), elevation, -azimuth.cos()).normalize();
            let light = random.log(30.0, 3e3) * DVec3::new(1.0, 0.8, 0.5) * color(random, 0.5);
            Disc { toward, radius: random.log(0.9, 1.6).to_radians(), light }
        })
        .collect();
    with_discs(|direction| night * (1.0 + 0.5 * direction.y), &discs)
}

fn room(random: &mut Random) -> Picture {
    let wall = random.log(0.003, 0.05) * color(random, 0.3);
    let windows: Vec<([f64; 4], DVec3)> = (0..random.whole(1, 3))
        .map(|_| {
            let (azimuth, elevation) = (random.between(-PI, PI), random.between(-0.2, 0.5));
            let (wide, high) = (random.log(0.05, 0.5), random.log(0.05, 0.4));
            ([azimuth, elevation, wide, high], random.log(1.0, 40.0) * color(random, 0.2))
        })
        .collect();
    let has_bars = random.chance(0.5);
    painted(|direction| {
        let (azimuth, elevation) = (direction.x.atan2(-direction.z), direction.y.asin());
        let shaded = wall * (1.0 + 0.5 * direction.y);
        let mut light = shaded;
        for ([middle, height, wide, high], of_window) in &windows {
            let off = (azimuth - middle + PI).rem_euclid(TAU) - PI;
            let (x, y) = (off / wide, (elevation - height) / high);
            let is_bar = has_bars && (x.abs() < 0.06 || y.abs() < 0.06);
            if x.abs() < 1.0 && y.abs() < 1.0 && !is_bar {
                light = *of_window;
            }
        }
        light
    })
}

/// Waves of several lengths in space, 0 on the mean.
fn noise(random: &mut Random) -> impl Fn(DVec3) -> f64 + use<> {
    let waves: Vec<(DVec3, f64, f64)> = (0..24)
        .map(|number| {
            let frequency = 2.0 * 1.19_f64.powi(number);
            let wave = frequency * random.direction();
            (wave, random.between(0.0, TAU), frequency.powf(-0.7))
        })
        .collect();
    move |at| waves.iter().map(|(wave, phase, size)| size * (wave.dot(at) + phase).sin()).sum()
}

fn clouds(random: &mut Random) -> Picture {
    let (behind, height) = (plain(random), noise(random));
    let bright = random.log(0.5, 3.0) * color(random, 0.1);
    let cover = random.between(-0.8, 0.8);
    let has_sun = random.chance(0.4);
    let toward = DVec3::new(random.between(-1.0, 1.0), random.between(0.1, 1.0), -0.6).normalize();
    let sun = random.log(3e2, 3e4);
    painted(|direction| {
        let clear = behind(direction);
        let off = direction.dot(toward).clamp(-1.0, 1.0).acos().to_degrees();
        let disc = if has_sun && off < 1.2 { sun } else { 0.0 };
        if direction.y <= 0.0 {
            return clear;
        }
        let thick = (height(2.5 * direction) + cover).clamp(0.0, 1.0);
        let shade = 1.0 - 0.6 * thick * (1.0 - direction.y);
        (clear + DVec3::splat(disc)).lerp(bright * shade, thick)
    })
}

/// A plate: walls before a far ground, a radiance and a depth for every pixel; `nearest`: of the walls.
pub fn plate(random: &mut Random, [width, height]: [u32; 2], nearest: f64) -> (Picture, Vec<f32>) {
    let far = random.pick(&[(0.5, 1e10), (0.5, 40.0 * nearest)]);
    let mut pixels = vec![Vec3::ZERO; (width * height) as usize];
    let mut depth = vec![far as f32; pixels.len()];
    let (top, bottom) = (random.log(0.2, 1.5) * color(random, 0.3), 0.2 * color(random, 0.3));
    let ripple = random.between(0.0, 0.3);
    for (at, pixel) in pixels.iter_mut().enumerate() {
        let (x, y) = (at as u32 % width, at as u32 / width);
        let down = f64::from(y) / f64::from(height);
        let wave = 1.0 + ripple * (0.4 * f64::from(x) + 0.23 * f64::from(y)).sin();
        *pixel = (wave * top.lerp(bottom, down)).as_vec3();
    }
    for _ in 0..random.whole(1, 4) {
        let of_wall = random.log(0.02, 1.0) * color(random, 0.4);
        let z = nearest * random.log(0.5, 6.0);
        let left = random.between(-0.2, 0.9) * f64::from(width);
        let right = left + random.between(0.1, 0.6) * f64::from(width);
        let upper = random.between(-0.1, 0.8) * f64::from(height);
        for at in 0..pixels.len() {
            let (x, y) = (f64::from(at as u32 % width), f64::from(at as u32 / width));
            if (left..right).contains(&x) && y >= upper && z < f64::from(depth[at]) {
                pixels[at] = of_wall.as_vec3();
                depth[at] = z as f32;
            }
        }
    }
    (Picture { width, height, pixels }, depth)
}
