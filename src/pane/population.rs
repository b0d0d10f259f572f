//! The drops on a pane some time after it was wiped.
//!
//! Drops arrive one after the other. One that touches others becomes one with them: volumes add up, in the centre of mass,
//! again until it touches none. One that is heavier than its rim holds slides down at once, taking with it what it touches,
//! leaving beads on its way if there is a trail. Over the lower edge it is gone. Nothing dries.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::arrivals::{Arrival, Arrivals};
use super::discs::Discs;
use super::retention::Retention;
use super::{Resting, cube_root, settled};

/// What is needed of a pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Least u and v in metres.
    pub from: DVec2,
    /// Largest u and v in metres.
    pub to: DVec2,
    /// Contact angle in degrees, and its standard deviation from drop to drop.
    pub angle: f64,
    /// See `angle`.
    pub angle_spread: f64,
    /// Share of an arriving drop's water that stays.
    pub retained: f64,
    /// λ: water left behind by a sliding drop, its volume per width² and length.
    pub trail: f64,
    /// Which drops slide.
    pub retention: Retention,
}

/// Contact angles that scattered ones are clamped to, degrees.
const ANGLES: [f64; 2] = [5.0, 170.0];

/// Steps of a drop that leaves a trail, in radii.
const STEP: f64 = 0.5;

/// Share of its distance by which a bead is farther from its drop than they would touch.
const APART: f64 = 1e-6;

/// The drops on a pane, as time goes on.
#[derive(Clone, Debug)]
pub struct Population {
    surface: Surface,
    arrivals: std::iter::Peekable<Arrivals>,
    discs: Discs,
    /// Volume over radius cubed where all angles are the same.
    factor: f64,
    waiting: VecDeque<Resting>,
    /// What has happened so far.
    pub tally: Tally,
}

/// What has happened on a pane since it was wiped; volumes in m³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Drops that arrived.
    pub arrived: u64,
    /// Water that arrived and stayed, or was there.
    pub water_in: f64,
    /// Water that has left over the lower edge.
    pub water_out: f64,
    /// When the first drop slid, seconds.
    pub first_slide: Option<f64>,
}

impl Population {
    /// A clean pane, but for drops that are `placed` on it.
    pub fn new(surface: Surface, arrivals: Arrivals, placed: &[Resting]) -> Self {
        let discs = Discs::new(surface.from.to_array(), surface.to.to_array());
        let factor = volume_factor(surface.angle);
        let mut population = Self {
            surface,
            arrivals: arrivals.peekable(),
            discs,
            factor,
            waiting: VecDeque::new(),
            tally: Tally::default(),
        };
        for drop in placed {
            population.tally.water_in += drop.volume;
            population.settle(*drop, 0.0);
        }
        population
    }

    /// Goes on until so many seconds after the pane was wiped; backwards is no way.
    pub fn go_on_to(&mut self, age: f64) {
        while let Some(arrival) = self.arrivals.next_if(|arrival| arrival.time <= age) {
            let volume = self.surface.retained * arrival.volume;
            self.tally.arrived += 1;
            self.tally.water_in += volume;
            let angle = self.angle(&arrival);
            let at = self.surface.from + arrival.at * (self.surface.to - self.surface.from);
            if volume > 0.0 {
                self.settle(self.drop(at, volume, angle), arrival.time);
            }
        }
    }

    /// The drops, in an order that depends on nothing but them.
    pub fn drops(&self) -> Vec<Resting> {
        self.discs.iter().copied().collect()
    }

    /// Share of the pane that discs cover.
    pub fn cover(&self) -> f64 {
        let area = (self.surface.to - self.surface.from).element_product();
        self.discs.iter().map(|drop| PI * drop.radius * drop.radius).sum::<f64>() / area
    }

    /// The contact angle of a drop that arrives: normally distributed, by Box and Muller.
    fn angle(&self, arrival: &Arrival) -> f64 {
        let Surface { angle, angle_spread, .. } = self.surface;
        if angle_spread == 0.0 {
            return angle;
        }
        let [first, second] = arrival.chance;
        let normal = settled((-2.0 * first.ln()).sqrt() * (TAU * second).cos());
        (angle + angle_spread * normal).clamp(ANGLES[0], ANGLES[1])
    }

    fn drop(&self, at: DVec2, volume: f64, angle: f64) -> Resting {
        let is_usual = angle == self.surface.angle;
        let factor = if is_usual { self.factor } else { volume_factor(angle) };
        Resting { at, radius: cube_root(volume / factor), angle, volume }
    }

    /// Two drops as one.
    fn merged(&self, one: &Resting, other: &Resting) -> Resting {
        let volume = one.volume + other.volume;
        let part = other.volume / volume;
        let angle = one.angle + part * (other.angle - one.angle);
        self.drop(one.at + part * (other.at - one.at), volume, angle)
    }

    /// Puts a drop on the pane, with all that follows from it.
    fn settle(&mut self, drop: Resting, time: f64) {
        self.waiting.push_back(drop);
        while let Some(mut drop) = self.waiting.pop_front() {
            loop {
                while let Some(place) = self.discs.touching(&drop) {
                    let other = self.discs.remove(place);
                    drop = self.merged(&drop, &other);
                }
                if !self.surface.retention.slides(drop.volume, drop.radius) {
                    self.discs.insert(drop);
                    break;
                }
                self.tally.first_slide.get_or_insert(time);
                match self.slide(drop) {
                    Some(lower) => drop = lower,
                    None => break,
                }
            }
        }
    }

    /// Moves a drop down to the next that it touches, with which it becomes one, or by a step of its trail; `None` if it
    /// leaves the pane.
    fn slide(&mut self, mut drop: Resting) -> Option<Resting> {
        let lower_edge = self.surface.from.y;
        let has_trail = self.surface.trail > 0.0;
        let step = if has_trail { STEP * drop.radius } else { f64::INFINITY };
        let lowest = (drop.at.y - step).max(lower_edge);
        let met = self.discs.below(&drop, lowest);
        let v = met.map_or(lowest, |(v, _)| v);
        let way = drop.at.y - v;
        drop.at.y = v;
        if has_trail && way > 0.0 {
            drop = self.leave_bead(drop, way);
        }
        if let Some((_, place)) = met {
            let other = self.discs.remove(place);
            return Some(self.merged(&drop, &other));
        }
        if v <= lower_edge {
            self.tally.water_out += drop.volume;
            return None;
        }
        Some(drop)
    }

    /// Leaves a bead of the trail behind a drop that has come down by `way`.
    fn leave_bead(&mut self, drop: Resting, way: f64) -> Resting {
        let width = 2.0 * drop.radius;
        let volume = (self.surface.trail * width * width * way).min(0.5 * drop.volume);
        let left = self.drop(drop.at, drop.volume - volume, drop.angle);
        let mut bead = self.drop(drop.at, volume, drop.angle);
        bead.at.y += (1.0 + APART) * (left.radius + bead.radius);
        self.waiting.push_back(bead);
        left
    }
}

/// Volume over radius cubed, the same on every machine.
fn volume_factor(angle: f64) -> f64 {
    settled(crate::optics::Cap::volume_factor(angle))
}
