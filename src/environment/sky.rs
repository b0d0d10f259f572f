//! The bundled environment: a clear sky by Hosek and Wilkie with a sun, clouds, hills and fields.
//!
//! Drops show the environment twice, upside down through their middle and bent around at the rim,
//! so that it must have structure: a horizon, clouds above it and darker ground below. The sky is
//! the published model (L. Hosek, A. Wilkie, *An Analytic Model for Full Spectral Sky-Dome
//! Radiance*, 2012; assets/LICENSE-hosek-wilkie is its data's licence); sun and ground get the
//! irradiance that goes with it; clouds, hills and fields only have to look right. All is
//! deterministic.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use rayon::prelude::*;

use super::LUMINANCE;
use super::levels::direction_of;
use crate::picture::Picture;

/// Texels across of the bundled sky.
pub const BUNDLED_WIDTH: u32 = 512;

/// Where the sun stands, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Height above the horizon.
    pub elevation: f64,
    /// From -z to the right.
    pub azimuth: f64,
}

/// Heights of the sun that the sky's model knows, in degrees; a lower sun is no disc.
pub const ELEVATIONS: std::ops::RangeInclusive<f64> = 1.0..=90.0;

/// The sun's angular radius in degrees, as seen from the earth.
const SUN_RADIUS_DEGREES: f64 = 0.2665;

/// Radiance of the disc of the bundled sky's sun: close below float16's 65 504. It sets the scale of everything
/// else.
const SUN_RADIANCE: DVec3 = DVec3::new(60_000.0, 54_000.0, 45_000.0);

/// Optical depth of the air straight up for red, green and blue: Rayleigh's for 611, 549 and 464 nm, and haze as
/// 0.05 λ^-1.3 with λ in µm. It reddens a sun that is lower than the bundled sky's.
const AIR: DVec3 = DVec3::new(0.157, 0.206, 0.324);

/// Irradiance by the sun on a surface that faces it, over that by the sky on level ground: about
/// 800 to 120 W/m² on a clear day with the sun at this height.
const SUN_TO_SKY: f64 = 6.5;

/// Haze of the air: 2 is very clear, 10 hazy.
const TURBIDITY: f64 = 3.0;

/// Mean albedo of the ground, which the sky reflects.
const GROUND_ALBEDO: DVec3 = DVec3::new(0.13, 0.14, 0.07);

/// Albedo of the fields, mixed by noise.
const FIELDS: [DVec3; 3] =
    [DVec3::new(0.05, 0.09, 0.03), DVec3::new(0.19, 0.16, 0.07), DVec3::new(0.13, 0.20, 0.05)];

/// Albedo of the hills' woods.
const WOODS: DVec3 = DVec3::new(0.06, 0.08, 0.04);

/// Samples around the horizon that show all that the noise has, and most along each edge of a texel.
const SAMPLES_AROUND: u32 = 8192;
const MOST_SAMPLES: u32 = 4;

/// Samples along each edge of a texel that the sun may touch.
const SUN_SAMPLES: u32 = 32;

/// The sky as a latitude-longitude picture, `width` x `width / 2`, linear radiance: clear sky and
/// ground are around 0.05 to 0.5, clouds around 1, the sun's disc up to 60 000. The sun's
/// irradiance is the same at every width, however few texels it has.
pub fn picture(width: u32, sun: Sun) -> Picture {
    let height = width / 2;
    let scenery = Scenery::new(sun);
    let texels = sun_texels(width, height, sun);
    let samples = (SAMPLES_AROUND / width).clamp(1, MOST_SAMPLES);
    let mut pixels: Vec<_> = (0..width * height)
        .into_par_iter()
        .map(|index| {
            let (column, row) = (f64::from(index % width), f64::from(index / width));
            let mut sum = DVec3::ZERO;
            for sample in 0..samples * samples {
                let x = column + (f64::from(sample % samples) + 0.5) / f64::from(samples);
                let y = row + (f64::from(sample / samples) + 0.5) / f64::from(samples);
                sum += scenery.radiance(direction_of(x / f64::from(width), y / f64::from(height)));
            }
            sum / f64::from(samples * samples)
        })
        .collect();
    for (index, coverage) in texels {
        pixels[index] += sun.radiance() * coverage;
    }
    Picture { width, height, pixels: pixels.iter().map(|pixel| pixel.as_vec3()).collect() }
}

impl Default for Sun {
    /// The bundled sky's: just outside a 90° view along -z, so that it does not blow the picture out and yet
    /// sparkles in the drops.
    fn default() -> Self {
        Self { elevation: 35.0, azimuth: 62.0 }
    }
}

impl Sun {
    /// The unit vector towards it.
    pub fn direction(&self) -> DVec3 {
        let (elevation, azimuth) = (self.elevation.to_radians(), self.azimuth.to_radians());
        let level = elevation.cos();
        DVec3::new(azimuth.sin() * level, elevation.sin(), -azimuth.cos() * level)
    }

    /// Radiance of its disc.
    fn radiance(&self) -> DVec3 {
        let more = (self.air_mass() - Self::default().air_mass()) * AIR;
        SUN_RADIANCE * (-more.max(DVec3::ZERO)).exp()
    }

    /// Air that its light comes through, over that straight up (Kasten and Young 1989).
    fn air_mass(&self) -> f64 {
        let elevation = self.elevation;
        (elevation.to_radians().sin() + 0.50572 * (elevation + 6.07995).powf(-1.6364)).recip()
    }

    /// Its irradiance on a surface that faces it.
    pub fn irradiance(&self) -> DVec3 {
        self.radiance() * sun_solid_angle()
    }
}

/// The solid angle of the sun's disc in steradians.
fn sun_solid_angle() -> f64 {
    2.0 * PI * (1.0 - SUN_RADIUS_DEGREES.to_radians().cos())
}

/// The texels that the sun touches and the part of each that it covers. Sampling finds the shape;
/// the sum is then scaled so that it holds the disc's solid angle exactly.
fn sun_texels(width: u32, height: u32, sun: Sun) -> Vec<(usize, f64)> {
    let sun = sun.direction();
    let nearest = (SUN_RADIUS_DEGREES.to_radians()).cos();
    let texel_angle = 2.0 * PI / f64::from(width);
    let reach = (SUN_RADIUS_DEGREES.to_radians() + texel_angle).cos();
    let mut texels = Vec::new();
    let mut solid_angle = 0.0;
    for index in 0..width * height {
        let (column, row) = (f64::from(index % width), f64::from(index / width));
        let at = |x: f64, y: f64| {
            direction_of((column + x) / f64::from(width), (row + y) / f64::from(height))
        };
        if at(0.5, 0.5).dot(sun) < reach {
            continue;
        }
        let samples = f64::from(SUN_SAMPLES);
        let hits = (0..SUN_SAMPLES * SUN_SAMPLES)
            .filter(|sample| {
                let x = (f64::from(sample % SUN_SAMPLES) + 0.5) / samples;
                let y = (f64::from(sample / SUN_SAMPLES) + 0.5) / samples;
                at(x, y).dot(sun) >= nearest
            })
            .count();
        let coverage = hits as f64 / (samples * samples);
        texels.push((index as usize, coverage));
        solid_angle += coverage * texel_solid_angle(width, height, index / width);
    }
    let correction = sun_solid_angle() / solid_angle;
    texels.retain(|(_, coverage)| *coverage > 0.0);
    texels.iter_mut().for_each(|(_, coverage)| *coverage *= correction);
    texels
}

/// The solid angle of each texel in a row, in steradians.
fn texel_solid_angle(width: u32, height: u32, row: u32) -> f64 {
    let edge = |row: u32| (PI * f64::from(row) / f64::from(height)).cos();
    2.0 * PI / f64::from(width) * (edge(row) - edge(row + 1))
}

/// Everything but the sun's disc.
struct Scenery {
    sky: SkyState,
    sun: DVec3,
    /// Irradiance by the sun on a surface that faces it.
    sun_irradiance: DVec3,
    /// From the model's units to ours.
    scale: f64,
    /// Irradiance by the sky alone on level ground.
    sky_irradiance: DVec3,
    /// Irradiance by sun and sky on level ground.
    ground_irradiance: DVec3,
}

impl Scenery {
    fn new(sun: Sun) -> Self {
        let sky = SkyState::new(&SkyParams {
            elevation: sun.elevation.to_radians() as f32,
            turbidity: TURBIDITY as f32,
            albedo: GROUND_ALBEDO.as_vec3().to_array(),
        })
        .expect("the constants are within the model's range");
        let mut scenery = Self {
            sky,
            sun: sun.direction(),
            sun_irradiance: sun.irradiance(),
            scale: 1.0,
            sky_irradiance: DVec3::ZERO,
            ground_irradiance: DVec3::ZERO,
        };
        // Midpoint rule over the upper half of a coarse picture; a per mille is good enough.
        let (width, height) = (256, 128);
        let mut irradiance = DVec3::ZERO;
        for row in 0..height / 2 {
            let solid_angle = texel_solid_angle(width, height, row);
            for column in 0..width {
                let toward = direction_of(
                    (f64::from(column) + 0.5) / f64::from(width),
                    (f64::from(row) + 0.5) / f64::from(height),
                );
                irradiance += scenery.clear_sky(toward) * toward.y * solid_angle;
            }
        }
        scenery.scale =
            scenery.sun_irradiance.dot(LUMINANCE) / SUN_TO_SKY / irradiance.dot(LUMINANCE);
        scenery.sky_irradiance = irradiance * scenery.scale;
        scenery.ground_irradiance = scenery.sky_irradiance + scenery.sun_irradiance * scenery.sun.y;
        scenery
    }

    /// Radiance from a direction, without the sun's disc.
    fn radiance(&self, toward: DVec3) -> DVec3 {
        let elevation = toward.y.clamp(-1.0, 1.0).asin().to_degrees();
        let heading = DVec2::new(toward.x, toward.z).normalize_or_zero();
        // Two ranges of hills, the farther one higher and lost in haze.
        for (range, height, haze) in [(0.0, 2.0, 0.3), (1.0, 4.5, 0.6)] {
            let place = heading * (4.0 + 2.0 * range);
            let ridge = height * (0.15 + 1.3 * fbm(place.extend(7.0 + range), 5));
            if (0.0..ridge).contains(&elevation) {
                let woods = WOODS * (0.7 + 0.6 * fbm((place * 9.0).extend(elevation), 3));
                let lit = woods * self.ground_irradiance / PI;
                return lit.lerp(self.haze(toward), haze);
            }
        }
        if toward.y < 0.0 { self.ground(toward) } else { self.clouded_sky(toward) }
    }

    /// Radiance of the model's sky; `toward` is at or above the horizon.
    fn clear_sky(&self, toward: DVec3) -> DVec3 {
        let theta = toward.y.clamp(0.0, 1.0).acos() as f32;
        let gamma = toward.dot(self.sun).clamp(-1.0, 1.0).acos() as f32;
        let radiance = [Channel::R, Channel::G, Channel::B]
            .map(|channel| f64::from(self.sky.radiance(theta, gamma, channel)));
        DVec3::from(radiance).max(DVec3::ZERO) * self.scale
    }

    /// What far things fade into: the sky a little above the horizon there.
    fn haze(&self, toward: DVec3) -> DVec3 {
        self.clear_sky(DVec3::new(toward.x, 0.05, toward.z).normalize()) * 0.85
    }

    /// Sky behind a layer of broken clouds.
    fn clouded_sky(&self, toward: DVec3) -> DVec3 {
        // Distance to a shell 1.5 km above a round earth, in km: clouds end at a horizon.
        let (earth, height) = (6371.0, 1.5);
        let rise = earth * toward.y;
        let distance = (rise * rise + 2.0 * earth * height + height * height).sqrt() - rise;
        let place = DVec2::new(toward.x, toward.z) * distance;
        let sky = self.clear_sky(toward);
        // A gap around the sun, which is drawn unclouded.
        let ahead = toward.dot(self.sun).max(0.0);
        let thickness = cloud(place) * smooth_step(6.0, 28.0, ahead.min(1.0).acos().to_degrees());
        if thickness <= 0.0 {
            return sky;
        }
        // What lies between this place and the sun shades it.
        let sunward = DVec2::new(self.sun.x, self.sun.z);
        let shade = 0.6 * cloud(place + 0.35 * sunward) + 0.4 * cloud(place + 0.8 * sunward);
        let direct = self.sun_irradiance * (-2.2 * shade).exp();
        // Water scatters forwards: edges near the sun shine.
        let silver = 1.0 + 1.5 * ahead.powi(12) * (-1.5 * thickness).exp();
        let lit = (direct * 1.1 * silver + self.sky_irradiance) / PI;
        let opacity = 1.0 - (-3.5 * thickness).exp();
        let clouded = sky.lerp(lit, opacity);
        let fade = (-distance / 45.0).exp();
        self.haze(toward).lerp(clouded, fade).lerp(sky, (1.0 - fade) * 0.5)
    }

    /// Fields seen from a small rise, fading into the haze.
    fn ground(&self, toward: DVec3) -> DVec3 {
        // In eye heights, from right below outwards.
        let distance = 1.0 / (-toward.y).max(1e-4);
        let place = DVec2::new(toward.x, toward.z) * distance;
        // Noise finer than a texel would only flicker.
        let octaves = (7.0 - distance.log2() * 0.8).clamp(1.0, 7.0) as u32;
        let grain = 0.5 + fbm((place * 1.1).extend(23.0), octaves);
        // A crooked quilt of fields, darker along the hedges between them.
        let bend =
            DVec2::new(fbm((place * 0.12).extend(3.0), 2), fbm((place * 0.12).extend(13.0), 2));
        let quilt = DVec2::from_angle(0.5).rotate(place + 4.0 * bend) * DVec2::new(0.42, 0.23);
        let (field, within) = (quilt.floor(), quilt - quilt.floor());
        let edge = within.min(1.0 - within).min_element();
        let hedge = 0.45 + 0.55 * smooth_step(0.02, 0.10, edge);
        let (ripe, green) = (hash(field.extend(3.0)), hash(field.extend(5.0)));
        let albedo = FIELDS[0].lerp(FIELDS[1], ripe).lerp(FIELDS[2], green * green) * grain * hedge;
        let albedo = GROUND_ALBEDO.lerp(albedo, (-distance / 40.0).exp());
        let lit = albedo * self.ground_irradiance / PI;
        self.haze(toward).lerp(lit, 0.25 + 0.75 * (-distance / 60.0).exp())
    }
}

/// How thick the clouds are at a place in km, 0 to about 1; 0 between them.
fn cloud(place: DVec2) -> f64 {
    let swirl = DVec2::new(fbm((place * 0.3).extend(31.0), 3), fbm((place * 0.3).extend(47.0), 3));
    let density = fbm((place * 0.55 + swirl * 0.9).extend(5.0), 6);
    smooth_step(0.50, 0.78, density)
}

/// Value noise summed over octaves, about 0 to 1.
fn fbm(place: DVec3, octaves: u32) -> f64 {
    let (mut sum, mut weights, mut weight, mut place) = (0.0, 0.0, 0.5, place);
    for _ in 0..octaves {
        sum += weight * noise(place);
        weights += weight;
        weight *= 0.5;
        // Not quite 2, so that the lattices of the octaves do not line up.
        place = place * 2.03 + DVec3::new(17.3, 9.1, 5.7);
    }
    sum / weights
}

/// Value noise in 0 to 1: a hash at each whole place, smooth between them.
fn noise(place: DVec3) -> f64 {
    let cell = place.floor();
    let within = place - cell;
    let weight = within * within * (3.0 - 2.0 * within);
    let corner = |x: f64, y: f64, z: f64| hash(cell + DVec3::new(x, y, z));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let edge = |y, z| mix(corner(0.0, y, z), corner(1.0, y, z), weight.x);
    let face = |z| mix(edge(0.0, z), edge(1.0, z), weight.y);
    mix(face(0.0), face(1.0), weight.z)
}

/// A number in 0 to 1 for a whole place.
fn hash(place: DVec3) -> f64 {
    let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
    for component in place.to_array() {
        bits = (bits ^ (component as i64 as u64)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits ^= bits >> 29;
    }
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

fn smooth_step(from: f64, to: f64, value: f64) -> f64 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
