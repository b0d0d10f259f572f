//! Scene time under the viewer's hand: stopped, slowed, stepped, run backwards.
//!
//! Time is a count of ticks (2^-32 s), and every advance is a whole number of them; what has gone by
//! can therefore be taken back to the last tick, and the picture is the first one again.

use std::time::Duration;

use crate::rain::{TICKS_PER_SECOND, Tick, tick_of_seconds};

/// Rates of scene time against wall-clock time, as numerator and denominator.
const RATES: [(i128, i128); 9] =
    [(1, 1000), (1, 300), (1, 100), (1, 30), (1, 10), (1, 3), (1, 1), (3, 1), (10, 1)];
const REAL_TIME: usize = 6;

/// Steps a second of wall-clock time.
const STEPS_PER_SECOND: i128 = 60;

const TICKS: i128 = 1 << 32;
const _: () = assert!(TICKS as f64 == TICKS_PER_SECOND);

/// The clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    start: Tick,
    now: Tick,
    rate: usize,
    /// Whether it stands still.
    pub paused: bool,
    /// Whether it runs backwards.
    pub backwards: bool,
}

impl Clock {
    /// Stands at `seconds`, ready to run in real time.
    pub fn new(seconds: f64, paused: bool) -> Self {
        let start = tick_of_seconds(seconds);
        Self { start, now: start, rate: REAL_TIME, paused, backwards: false }
    }

    /// Scene time in seconds.
    pub fn seconds(&self) -> f64 {
        self.now as f64 / TICKS_PER_SECOND
    }

    /// Seconds of scene time a second of wall-clock time, without its sign.
    pub fn rate(&self) -> f64 {
        let (numerator, denominator) = RATES[self.rate];
        numerator as f64 / denominator as f64
    }

    /// Runs one rate faster or slower.
    pub fn change_rate(&mut self, faster: bool) {
        self.rate =
            if faster { (self.rate + 1).min(RATES.len() - 1) } else { self.rate.max(1) - 1 };
    }

    /// Lets `elapsed` of wall-clock time go by. Running backwards it stops at the start, to the tick.
    pub fn advance(&mut self, elapsed: Duration) {
        if self.paused {
            return;
        }
        let (numerator, denominator) = RATES[self.rate];
        let nanoseconds = elapsed.as_nanos() as i128;
        let ticks = nanoseconds * TICKS * numerator / (1_000_000_000 * denominator);
        if self.backwards && self.now > self.start && self.now - ticks <= self.start {
            self.rewound();
        } else {
            self.now += if self.backwards { -ticks } else { ticks };
        }
    }

    /// Stops, and goes one step on or back.
    pub fn step(&mut self, forward: bool) {
        self.paused = true;
        let (numerator, denominator) = RATES[self.rate];
        let ticks = TICKS * numerator / (STEPS_PER_SECOND * denominator);
        self.now += if forward { ticks } else { -ticks };
    }

    /// Goes back to the start at once, and stops.
    pub fn rewound(&mut self) {
        self.now = self.start;
        (self.paused, self.backwards) = (true, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_can_be_taken_back() {
        let first = Clock::new(1e-3, true);
        let mut clock = first.clone();
        for (count, forward) in [(137, true), (137, false)] {
            (0..count).for_each(|_| clock.step(forward));
            assert_eq!(clock == first, !forward);
        }
    }

    #[test]
    fn rewinding_stops_at_the_start_to_the_tick() {
        let mut clock = Clock::new(-7.25, false);
        for nanoseconds in [16_666_667, 1, 33_000_001] {
            clock.advance(Duration::from_nanos(nanoseconds));
        }
        clock.change_rate(false);
        clock.backwards = true;
        (0..20).for_each(|_| clock.advance(Duration::from_millis(10)));
        assert_eq!((clock.seconds(), clock.paused), (-7.25, true));
        // And from there on into the past.
        (clock.paused, clock.backwards) = (false, true);
        clock.advance(Duration::from_secs(3));
        assert!((clock.seconds() - -8.25).abs() < 1e-9, "a third of real time: {clock:?}");
    }

    #[test]
    fn slowest_motion_still_moves_in_every_frame() {
        let mut clock = Clock::new(0.0, false);
        (0..20).for_each(|_| clock.change_rate(false));
        assert_eq!(clock.rate(), 1e-3);
        clock.advance(Duration::from_micros(100));
        assert!(clock.seconds() > 0.0);
    }
}
