//! What a direction of the sky and a drop look like, in float32, by the formulas of
//! `glsl/include/environment.glsl` and `drop_light.glsl`, and pictures of far drops by direction.

use std::f32::consts::{FRAC_PI_2, LOG2_E, PI, TAU};

use glam::{Vec2, Vec3, Vec4};
use raindrops::environment::Environment;
use raindrops::environment::levels::levels;
use rayon::prelude::*;

/// Refractive index of water.
const WATER: f32 = 1.33;
/// Edge of the octahedral map of directions.
const DIRECTIONS: usize = 64;
/// Texels an edge of a far drop's picture.
pub const EDGE: usize = 8;
/// Samples along each edge of a texel of it.
const SAMPLES: usize = 3;
/// Most reflections inside a drop.
const INTERNAL_REFLECTIONS: usize = 2;

/// The environment's levels, four floats a texel, each row with a texel more on both sides.
pub struct Sky {
    levels: Vec<Level>,
    texel_angle: f32,
}

struct Level {
    size: Vec2,
    stride: usize,
    texels: Vec<Vec4>,
}

impl Sky {
    pub fn new(environment: &Environment) -> Self {
        let chain = levels(environment);
        let pad = |level: &raindrops::environment::levels::Level| {
            let rows = level.texels.chunks_exact(level.width as usize);
            let padded = rows.flat_map(|row| row.last().into_iter().chain(row).chain(row.first()));
            let texels: Vec<Vec4> = padded.map(|texel| texel.extend(0.0)).collect();
            let stride = level.width as usize + 2;
            // And a row more at both poles.
            let (top, bottom) =
                (texels[..stride].to_vec(), texels[texels.len() - stride..].to_vec());
            let texels = [top, texels, bottom].concat();
            Level { size: Vec2::new(level.width as f32, level.height as f32), stride, texels }
        };
        let texel_angle = PI / environment.height() as f32;
        Self { levels: chain.iter().map(pad).collect(), texel_angle }
    }

    /// The finest level: its size in texels, its row's length in memory, its texels.
    #[inline(always)]
    pub fn finest(&self) -> (Vec2, usize, &[Vec4]) {
        (self.levels[0].size, self.levels[0].stride, &self.levels[0].texels)
    }

    /// The level that averages over about `spread` radians.
    #[inline(always)]
    pub fn level(&self, spread: f32) -> f32 {
        let level = log2(spread.max(1e-9) / self.texel_angle);
        level.clamp(0.0, (self.levels.len() - 1) as f32)
    }

    /// Radiance at a place, u and v in 0 to 1, of a fractional level.
    #[inline(always)]
    pub fn trilinear(&self, u: f32, v: f32, level: f32) -> Vec4 {
        let fine = level as i32 as usize;
        let coarse = (fine + 1).min(self.levels.len() - 1);
        let (a, b) = (self.levels[fine].bilinear(u, v), self.levels[coarse].bilinear(u, v));
        a + (b - a) * (level - fine as f32)
    }
}

impl Level {
    #[inline(always)]
    fn bilinear(&self, u: f32, v: f32) -> Vec4 {
        // The margin of a texel makes both at least 0.5.
        let (x, y) = (u * self.size.x + 0.5, v * self.size.y + 0.5);
        let (left, top) = (x as i32, y as i32);
        let at = top as usize * self.stride + left as usize;
        mix(&self.texels, at, self.stride, x - left as f32, y - top as f32)
    }
}

/// Bilinear between four of `texels`: the one at `at`, the next, and those a row on.
#[inline(always)]
pub fn mix(texels: &[Vec4], at: usize, stride: usize, fx: f32, fy: f32) -> Vec4 {
    let block = &texels[at..at + stride + 2];
    let upper = block[0] + (block[1] - block[0]) * fx;
    let lower = block[stride] + (block[stride + 1] - block[stride]) * fx;
    upper + (lower - upper) * fy
}

/// Where in a latitude-longitude image a unit direction lies.
#[inline(always)]
pub fn place(d: Vec3) -> [f32; 2] {
    let around = arc_tangent(d.x, -d.z);
    let down = arc_tangent((d.x * d.x + d.z * d.z).sqrt(), d.y);
    [(0.5 + around / TAU).clamp(0.0, 1.0), (down / PI).clamp(0.0, 1.0)]
}

/// atan2 by a polynomial, within 10⁻⁵ radians; free of branches, so that a loop of it vectorises.
#[inline(always)]
fn arc_tangent(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (high, low) = (ax.max(ay), ax.min(ay));
    let t = low / high.max(1e-30);
    let s = t * t;
    let p = -0.013_480_47 * s + 0.057_477_314;
    let p = ((p * s - 0.121_239_07) * s + 0.195_635_93) * s - 0.332_994_6;
    let angle = (p * s + 0.999_995_63) * t;
    let angle = if ay > ax { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

/// Within 2·10⁻⁵, for positive numbers; free of branches, so that a loop of it vectorises.
#[inline(always)]
pub fn log2(value: f32) -> f32 {
    let bits = value.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
    // ln m = 2 artanh((m-1) / (m+1)).
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let artanh = s * (1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 / 7.0)));
    exponent as f32 + 2.0 * LOG2_E * artanh
}

/// Reflection, refraction, internal reflections.
pub const ORDERS: usize = 2 + INTERNAL_REFLECTIONS;

/// Where the light comes from that leaves a drop along unit direction `d` at the place `offset`
/// (over the radius, perpendicular to `d`, at most 1 long): direction, spread in radians and weight.
/// `step` is the impact parameter's change over one sample. Free of branches.
#[inline(always)]
pub fn drop_rays(d: Vec3, offset: Vec3, step: f32) -> [(Vec3, f32, f32); ORDERS] {
    let b = offset.length().min(1.0);
    // At the middle all deviations are along `d`, and no perpendicular is needed.
    let o = offset * (1.0 / b.max(1e-6));
    let (ci, st) = ((1.0 - b * b).max(0.0).sqrt(), b / WATER);
    let ct = (1.0 - st * st).sqrt();
    let (s, p) = ((ci - WATER * ct) / (ci + WATER * ct), (WATER * ci - ct) / (WATER * ci + ct));
    let f = 0.5 * (s * s + p * p);
    let held = (ci * ci).max(step.min(1.0)).sqrt();
    let (rate_in, rate_turn) = (2.0 / held, 2.0 / (WATER * ct));
    let outside = ((1.0 - 2.0 * ci * ci) * d + 2.0 * b * ci * o, 2.0 * step, f);
    let mut rays = [outside; ORDERS];
    let (c, s) = (ci * ct + b * st, b * ct - ci * st);
    let (mut cosine, mut sine) = (c * c - s * s, 2.0 * c * s);
    let (turn_cosine, turn_sine) = (st * st - ct * ct, 2.0 * st * ct);
    let (mut rate, mut weight) = (rate_in - rate_turn, (1.0 - f) * (1.0 - f));
    for k in 0..=INTERNAL_REFLECTIONS {
        // The last order takes what those beyond it carry.
        let share = if k == INTERNAL_REFLECTIONS { weight / (1.0 - f).max(1e-6) } else { weight };
        let spread = (rate * sine / b.max(1e-3)).abs().sqrt() * step;
        rays[k + 1] = (cosine * d - sine * o, spread, share);
        (cosine, sine) =
            (cosine * turn_cosine - sine * turn_sine, sine * turn_cosine + cosine * turn_sine);
        rate -= rate_turn;
        weight *= f;
    }
    rays
}

/// The radiance of [`drop_rays`].
fn drop_light(sky: &Sky, d: Vec3, offset: Vec3, step: f32) -> Vec4 {
    let rays = drop_rays(d, offset, step).into_iter();
    rays.map(|(d, spread, weight)| {
        let [u, v] = place(d);
        weight * sky.trilinear(u, v, sky.level(spread))
    })
    .sum()
}

/// Pictures of a far drop from each of 64 x 64 directions.
pub struct Pictures {
    means: Vec<Vec4>,
    pictures: Vec<[Vec4; EDGE * EDGE]>,
    bases: Vec<[Vec3; 2]>,
}

impl Pictures {
    pub fn new(sky: &Sky) -> Self {
        let one = |texel: usize| picture(sky, texel_direction(texel));
        let all: Vec<_> = (0..DIRECTIONS * DIRECTIONS).into_par_iter().map(one).collect();
        Self {
            means: all.iter().map(|(_, mean)| *mean).collect(),
            pictures: all.iter().map(|(picture, _)| *picture).collect(),
            bases: (0..DIRECTIONS * DIRECTIONS)
                .map(|texel| basis(texel_direction(texel)))
                .collect(),
        }
    }

    /// The mean colour of a drop seen in direction `d`.
    #[inline(always)]
    pub fn mean(&self, d: Vec3) -> Vec4 {
        self.means[direction_texel(d)]
    }

    /// The picture of a drop seen in direction `d`, and the axes of its columns and rows.
    #[inline(always)]
    pub fn picture(&self, d: Vec3) -> (&[Vec4; EDGE * EDGE], [Vec3; 2]) {
        let texel = direction_texel(d);
        (&self.pictures[texel], self.bases[texel])
    }
}

/// A drop's picture, and its mean over the disc.
fn picture(sky: &Sky, d: Vec3) -> ([Vec4; EDGE * EDGE], Vec4) {
    let [u, v] = basis(d);
    let step = 2.0 / (EDGE * SAMPLES) as f32;
    let (mut all, mut count) = (Vec4::ZERO, 0.0);
    let mut texels = [Vec4::ZERO; EDGE * EDGE];
    for (index, texel) in texels.iter_mut().enumerate() {
        let (mut sum, mut inside) = (Vec4::ZERO, 0.0);
        let place =
            |cell: usize, sample: usize| ((cell * SAMPLES + sample) as f32 + 0.5) * step - 1.0;
        for sample in 0..SAMPLES * SAMPLES {
            let (s, t) =
                (place(index % EDGE, sample % SAMPLES), place(index / EDGE, sample / SAMPLES));
            let r = s.hypot(t);
            if r < 1.0 {
                let light = drop_light(sky, d, s * u + t * v, step);
                (sum, inside) = (sum + light, inside + 1.0);
            }
        }
        (all, count) = (all + sum, count + inside);
        *texel = if inside > 0.0 {
            sum / inside
        } else {
            // Beyond the rim: what the rim shows.
            let middle = SAMPLES / 2;
            let (s, t) = (place(index % EDGE, middle), place(index / EDGE, middle));
            drop_light(sky, d, (s * u + t * v).normalize() * 0.98, step)
        };
    }
    (texels, all / count)
}

/// Number of the octahedral map's texel that holds unit direction `d`.
#[inline(always)]
fn direction_texel(d: Vec3) -> usize {
    let scale = 1.0 / (d.x.abs() + d.y.abs() + d.z.abs());
    let (x, y) = (d.x * scale, d.y * scale);
    let folded = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
    let (x, y) = if d.z < 0.0 { folded } else { (x, y) };
    let at = |p: f32| ((0.5 * p + 0.5) * DIRECTIONS as f32).clamp(0.0, DIRECTIONS as f32 - 1.0);
    at(y) as i32 as usize * DIRECTIONS + at(x) as i32 as usize
}

/// Unit direction at the middle of a texel.
fn texel_direction(texel: usize) -> Vec3 {
    let at = |index: usize| (index as f32 + 0.5) * (2.0 / DIRECTIONS as f32) - 1.0;
    let (x, y) = (at(texel % DIRECTIONS), at(texel / DIRECTIONS));
    let z = 1.0 - x.abs() - y.abs();
    let folded = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
    let (x, y) = if z < 0.0 { folded } else { (x, y) };
    Vec3::new(x, y, z).normalize()
}

/// Two unit vectors perpendicular to `n` and each other (Duff et al. 2017).
fn basis(n: Vec3) -> [Vec3; 2] {
    let (u, v) = n.any_orthonormal_pair();
    [u, v]
}
