//! Drops that fall on a pane: how many of which size a second, and each by its number.
//!
//! A pane that moves with a velocity c through rain meets drops of diameter D at N(D) (w + v(D) n_y) a square metre and
//! second, where w = (c - wind) · n and n is the normal, outside. Where that is under 0, drops move away from the wet face
//! and none arrives. Speeds are linear between measured sizes, so every moment is a sum of the law's.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::settled;
use crate::optics::Cap;
use crate::rain::law::Law;
use crate::rain::{fall, pcg4d, unit};

/// Intervals of the table of diameters: 0.006 mm each where the law goes to 6 mm.
const INTERVALS: usize = 1024;

/// What arrives on a square metre.
#[derive(Clone, Debug, PartialEq)]
pub struct Flux {
    law: Law,
    /// Stretches of diameters in mm on which the speed of arrival is `at_zero + slope · D`, m/s, and over 0.
    pieces: Vec<fall::Piece>,
}

impl Flux {
    /// On a pane of this unit normal, which moves through the rain with `velocity`, that of the wind taken off; m/s.
    pub fn new(law: Law, air_density: f64, normal: DVec3, velocity: DVec3) -> Self {
        let (factor, towards) = (fall::density_factor(air_density), velocity.dot(normal));
        let piece = |piece: fall::Piece| {
            let at_zero = towards + factor * normal.y * piece.at_zero;
            let slope = factor * normal.y * piece.slope;
            let speed = |diameter: f64| at_zero + slope * diameter;
            let turn = -at_zero / slope;
            let (from, to) = match (speed(piece.from) > 0.0, speed(piece.to) > 0.0) {
                (false, false) => return None,
                (true, true) => (piece.from, piece.to),
                (true, false) => (piece.from, turn),
                (false, true) => (turn, piece.to),
            };
            Some(fall::Piece { from, to, at_zero, slope })
        };
        Self { law, pieces: fall::pieces(law.from, law.to).filter_map(piece).collect() }
    }

    /// ∫ N u D^k dD over the diameters up to `to`, in mm^k m⁻² s⁻¹.
    fn moment_to(&self, k: f64, to: f64) -> f64 {
        let moment = |piece: &fall::Piece| {
            let between = |k: f64| self.law.moment_between(k, piece.from, piece.to.min(to));
            piece.at_zero * between(k) + piece.slope * between(k + 1.0)
        };
        self.pieces.iter().filter(|piece| piece.from < to).map(moment).sum()
    }

    fn moment(&self, k: f64) -> f64 {
        self.moment_to(k, self.law.to)
    }

    /// Drops a square metre and second.
    pub fn number(&self) -> f64 {
        self.moment(0.0)
    }

    /// Water in mm/h.
    pub fn water(&self) -> f64 {
        // mm³ m⁻² s⁻¹ are 10⁻⁶ mm/s.
        PI / 6.0 * 1e-6 * 3600.0 * self.moment(3.0)
    }

    /// κ: contact area that arrives per area, 1/s, of drops of this contact angle.
    pub fn cover(&self, angle: f64) -> f64 {
        PI * 1e-6 * Cap::spread(angle).powi(2) * self.moment(2.0)
    }
}

/// A drop that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Seconds since the pane was wiped.
    pub time: f64,
    /// Place as shares of the pane's extent, 0 to 1.
    pub at: DVec2,
    /// Its volume, m³.
    pub volume: f64,
    /// Two further numbers in 0 to 1.
    pub chance: [f64; 2],
}

/// All arrivals on a pane, one after the other; it never ends where any arrive.
#[derive(Clone, Debug)]
pub struct Arrivals {
    seed: u64,
    number: u64,
    time: f64,
    /// Arrivals a second.
    rate: f64,
    /// Share of drops below each diameter of the table, of 2³².
    shares: Vec<u32>,
    /// Least diameter and length of an interval, mm.
    from: f64,
    step: f64,
}

impl Arrivals {
    /// The arrivals by a flux on so many square metres.
    pub fn new(flux: &Flux, area: f64, seed: u64) -> Self {
        let (number, law) = (flux.number(), flux.law);
        let step = settled((law.to - law.from) / INTERVALS as f64);
        let share = |interval: usize| {
            let part = flux.moment_to(0.0, law.from + step * interval as f64) / number;
            (part * 4_294_967_296.0).round() as u32
        };
        let shares = if number > 0.0 { (1..INTERVALS).map(share).collect() } else { Vec::new() };
        Self {
            seed,
            number: 0,
            time: 0.0,
            rate: settled(number * area),
            shares,
            from: law.from,
            step,
        }
    }

    /// Arrivals a second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Diameter in mm of a drop with a random number.
    fn diameter(&self, bits: u32) -> f64 {
        let interval = self.shares.partition_point(|share| *share <= bits);
        let lower = if interval == 0 { 0.0 } else { f64::from(self.shares[interval - 1]) };
        let upper = self.shares.get(interval).map_or(4_294_967_296.0, |share| f64::from(*share));
        let part = (f64::from(bits) + 0.5 - lower) / (upper - lower).max(1.0);
        self.from + self.step * (interval as f64 + part)
    }
}

impl Iterator for Arrivals {
    type Item = Arrival;

    fn next(&mut self) -> Option<Arrival> {
        const SALT: u32 = 0x676c_6173; // "glas"
        if self.rate <= 0.0 {
            return None;
        }
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        let [of_number, beyond] = [self.number as u32, (self.number >> 32) as u32];
        let [gap, u, v, size] = pcg4d([of_number, low, high, SALT ^ beyond]);
        let [first, second, ..] = pcg4d([of_number, low, high, !SALT ^ beyond]);
        self.number += 1;
        // Gaps between events that know nothing of one another are exponential.
        self.time -= settled(unit(gap).ln()) / self.rate;
        let diameter = 1e-3 * self.diameter(size);
        Some(Arrival {
            time: self.time,
            at: DVec2::new(unit(u), unit(v)),
            volume: PI / 6.0 * diameter * diameter * diameter,
            chance: [unit(first), unit(second)],
        })
    }
}
