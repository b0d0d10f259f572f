//! The drops on a pane at any time, asked for in any order.
//!
//! Forwards, rain goes on from the last time that was asked for. Backwards, it goes on from a state that was kept on the way. States
//! are kept at even steps of time; when there are many, every second is let go, and steps are twice as long. So going back costs the
//! rain of one step: a sixteenth of all that has fallen, or four milliseconds.

use super::population::Population;

/// Most states that are kept.
const MOST: usize = 32;
/// Drops that arrive within a step at first, each of which costs up to a microsecond.
const ARRIVALS: f64 = 4096.0;

/// A pane in the rain.
#[derive(Clone, Debug)]
pub struct Keyframes {
    /// The wiped pane, then the pane after each step.
    kept: Vec<Population>,
    /// Seconds.
    step: f64,
    now: Population,
    age: f64,
}

impl Keyframes {
    /// A pane that was just wiped, on which so many drops arrive a second.
    pub fn new(wiped: Population, rate: f64) -> Self {
        let step = if rate > 0.0 { ARRIVALS / rate } else { f64::MAX };
        Self { kept: vec![wiped.clone()], step, now: wiped, age: 0.0 }
    }

    /// The pane so many seconds after it was wiped: to the bit what [`Population::go_on_to`] makes of the wiped pane.
    pub fn at(&mut self, age: f64) -> &Population {
        let before = ((age / self.step) as usize).min(self.kept.len() - 1);
        if age < self.age || self.age < before as f64 * self.step {
            self.now.clone_from(&self.kept[before]);
        }
        while self.kept.len() as f64 * self.step <= age {
            self.now.go_on_to(self.kept.len() as f64 * self.step);
            self.kept.push(self.now.clone());
            if self.kept.len() > MOST {
                self.kept = self.kept.drain(..).step_by(2).collect();
                self.step *= 2.0;
            }
        }
        self.now.go_on_to(age);
        self.age = age;
        &self.now
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::pane::arrivals::{Arrivals, Flux};
    use crate::pane::population::Surface;
    use crate::pane::retention::Retention;
    use crate::rain::law::{Law, marshall_palmer_slope};

    /// Going back costs the rain of a step at most.
    #[test]
    fn some_states_are_kept_and_a_step_is_a_sixteenth_of_the_time() {
        let slope = marshall_palmer_slope(50.0);
        let law = Law { intercept: 8000.0, mu: 0.0, slope, from: 0.25, to: 6.0 };
        let flux = Flux::new(law, 1.2, DVec3::Y, DVec3::ZERO);
        let surface = Surface {
            from: DVec2::ZERO,
            to: DVec2::splat(0.1),
            angle: 60.0,
            angle_spread: 0.0,
            retained: 1.0,
            trail: 0.0,
            retention: Retention::new(0.0, [50.0, 20.0]),
        };
        let (rate, arrivals) = (0.01 * flux.number(), Arrivals::new(&flux, 0.01, 1));
        let mut keyframes = Keyframes::new(Population::new(surface, arrivals, &[]), rate);
        for steps in 1..80 {
            let age = f64::from(steps) * ARRIVALS / rate;
            keyframes.at(age);
            let Keyframes { kept, step, .. } = &keyframes;
            assert!(kept.len() <= MOST && kept.len() > (steps as usize).min(MOST / 2));
            assert!(*step <= (age / 16.0).max(ARRIVALS / rate), "{step} s of {age} s");
            for (number, state) in kept.iter().enumerate() {
                let drops = number as f64 * step * rate;
                let found = state.tally.arrived as f64;
                assert!((found - drops).abs() < 6.0 * drops.sqrt() + 1.0, "{found} for {drops}");
            }
        }
    }
}
