//! Where every drop of the rain is at any time: exact integers, the same as `glsl/simulate.comp`.
//!
//! A drop's place in the rain box is three `u32` fractions of the box, so wrapping around is what
//! the integers do by themselves: `place(t) = start(seed, index) + shift(t)`. The start is a hash;
//! nothing is stored. All drops fall alike, so the shift is computed once a frame, here, in 64-bit
//! fractions of the box: exact for any time, forwards or backwards, the same on every driver, and
//! free of the drift that float32 accumulates (hundreds of radii in a day of slow motion).

pub mod cells;
pub mod classes;
pub mod clusters;
pub mod cull;
pub mod fall;
pub mod field;
pub mod flat_sizes;
pub mod flat_suns;
pub mod grain;
mod last;
pub mod law;
pub mod medium;
pub mod pairs;
mod pyramid;
pub mod shape;
pub mod shelter;
pub mod thinned;
pub mod visibility;

use glam::{DVec3, Vec3};

/// Ticks a second. Scene time is an integer count of ticks; at 2^-32 s a tick, slow motion down to
/// 10⁻⁶ still moves every frame, and every float64 time of at least a microsecond is exact to 2^-32 s.
pub const TICKS_PER_SECOND: f64 = 4_294_967_296.0;

/// Scene time in ticks. 128 bits hold 10⁶ years (10²³ ticks) with room to spare.
pub type Tick = i128;

/// Seconds to ticks, to the nearest.
pub fn tick_of_seconds(seconds: f64) -> Tick {
    (seconds * TICKS_PER_SECOND).round() as Tick
}

/// Random drops in a box that wraps around; a pure function of (seed, index, tick).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rain {
    /// Chooses the drops' starting places.
    pub seed: u64,
    /// Number of drops.
    pub count: u32,
    /// Half the box's edges, in scene units; the box is centred on the camera.
    pub half_extent: DVec3,
    /// Every drop's radius, in scene units.
    pub radius: f64,
    /// Every drop's velocity, in scene units a second.
    pub velocity: DVec3,
}

impl Rain {
    /// How far every drop has moved at `tick`, as fractions of the box in units of 2^-32.
    ///
    /// The motion a tick is rounded once to 2^-64 of the box (a relative error of the velocity of
    /// 3e-8 for the paper's rain); from there on the product is exact modulo the box.
    pub fn shift(&self, tick: Tick) -> [u32; 3] {
        (self.velocity / (2.0 * self.half_extent)).to_array().map(|boxes_per_second| {
            // 2^64 / TICKS_PER_SECOND = 2^32.
            let motion = (boxes_per_second * 4_294_967_296.0).round() as i128;
            (motion.wrapping_mul(tick) as u64 >> 32) as u32
        })
    }

    /// Place of drop `index` in the box, in units of 2^-32 of the box, given `shift` at that tick.
    pub fn place(&self, index: u32, shift: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = start(self.seed, index);
        [x.wrapping_add(shift[0]), y.wrapping_add(shift[1]), z.wrapping_add(shift[2])]
    }

    /// The camera's place, from which all others are seen: the box wraps around it.
    pub fn camera_place(&self, position: DVec3) -> [u32; 3] {
        (position / (2.0 * self.half_extent)).to_array().map(|boxes| {
            let fraction = boxes - boxes.floor();
            (fraction * 4_294_967_296.0).round() as u64 as u32
        })
    }

    /// Factors that turn a difference of places, read as signed, into scene units.
    pub fn units(&self) -> Vec3 {
        (self.half_extent / 2_147_483_648.0).as_vec3()
    }

    /// The drops as a camera sees them at a time.
    pub fn seen_from(&self, position: DVec3, tick: Tick) -> SeenRain {
        SeenRain { rain: *self, shift: self.shift(tick), camera: self.camera_place(position) }
    }

    /// Centre of the drop at `place` relative to the camera at `camera_place`, in scene units along
    /// the world's axes. Bit for bit what the GPU computes: one conversion and one product each.
    pub fn relative(&self, place: [u32; 3], camera_place: [u32; 3]) -> Vec3 {
        let units = self.units();
        let along = |axis: usize| place[axis].wrapping_sub(camera_place[axis]) as i32 as f32;
        Vec3::new(along(0) * units.x, along(1) * units.y, along(2) * units.z)
    }
}

/// The drops of a population as a camera sees them at a time.
#[derive(Clone, Copy, Debug)]
pub struct SeenRain {
    rain: Rain,
    shift: [u32; 3],
    camera: [u32; 3],
}

impl SeenRain {
    /// Centre of drop `index` relative to the camera, in scene units along the world's axes: `drop_at` in
    /// `glsl/include/rain.glsl`.
    pub fn drop_at(&self, index: u32) -> Vec3 {
        self.rain.relative(self.rain.place(index, self.shift), self.camera)
    }
}

/// Place of drop `index` at tick 0: the hash `pcg4d` of Jarzynski and Olano 2020 ("Hash functions
/// for GPU rendering"), of index, both halves of the seed and a constant.
pub fn start(seed: u64, index: u32) -> [u32; 3] {
    const SALT: u32 = 0x7261_696e; // "rain"
    let [x, y, z, _] = pcg4d([index, seed as u32, (seed >> 32) as u32, SALT]);
    [x, y, z]
}

/// The hash `pcg4d` of Jarzynski and Olano 2020: four well-mixed numbers from four.
pub(crate) fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}

/// The middle of one of 2^32 intervals from 0 to 1, so never an end.
pub(crate) fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) / 4_294_967_296.0
}
