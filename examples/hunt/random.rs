//! Chance that is the same on every run: splitmix64, a stream of its own for each part of each scene, so that a new key in
//! one part changes no other part of any scene.

use std::f64::consts::TAU;

use glam::DVec3;

/// A stream of random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Random(u64);

impl Random {
    /// The stream of a part of scene `number` of `seed`.
    pub fn of(seed: u64, number: u64, part: &str) -> Self {
        let mut stream = Self(seed);
        for word in [number, u64::from(crc32fast::hash(part.as_bytes()))] {
            stream.0 = stream.bits() ^ word;
        }
        stream
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between two numbers over 0, uniform in the logarithm.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A whole number, both ends included.
    pub fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.unit() * f64::from(high - low + 1)) as u32
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of several, by their weights.
    pub fn pick<T: Copy>(&mut self, choices: &[(f64, T)]) -> T {
        let mut left = self.unit() * choices.iter().map(|(weight, _)| weight).sum::<f64>();
        for (weight, choice) in choices {
            left -= weight;
            if left < 0.0 {
                return *choice;
            }
        }
        choices[choices.len() - 1].1
    }

    /// Uniform over the sphere of directions.
    pub fn direction(&mut self) -> DVec3 {
        let (y, angle) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * angle.cos(), y, r * angle.sin())
    }
}
