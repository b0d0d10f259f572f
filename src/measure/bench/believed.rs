//! When a device's times may be believed: once its clock has settled, and where they are longer than what its timer tells
//! apart and than what a submission costs by itself. Pure functions of recorded times.
//!
//! A card at rest runs at a fraction of its clock, and takes tenths of a second to come to it. Frames until then would
//! count as slow ones of whatever is measured first.

use crate::measure::statistics::median;
use crate::thousands::thousands_of;

/// A stretch of the warm-up has so many frames and takes so long, milliseconds, at least.
const LEAST_FRAMES: usize = 4;
const STRETCH_MS: f64 = 100.0;
/// So many stretches whose medians differ by less than this part have settled.
const ALIKE: usize = 3;
const SETTLED: f64 = 0.03;
/// The warm-up ends after so long in any case, milliseconds.
const LONGEST_MS: f64 = 2000.0;
/// A time of fewer ticks is off by a tenth or more.
const LEAST_TICKS: f64 = 10.0;
/// A frame that takes less than so many empty submissions is not what is measured.
const LEAST_SUBMISSIONS: f64 = 2.0;

/// The frames before those that count.
#[derive(Clone, Debug, Default)]
pub struct WarmUp {
    stretches: Vec<f64>,
    frames: Vec<f64>,
    /// Time of all frames so far, milliseconds.
    spent: f64,
}

impl WarmUp {
    /// Takes the time of a frame, milliseconds.
    pub fn take(&mut self, ms: f64) {
        self.spent += ms;
        self.frames.push(ms);
        if self.frames.len() >= LEAST_FRAMES && self.frames.iter().sum::<f64>() >= STRETCH_MS {
            self.stretches.push(median(&self.frames));
            self.frames.clear();
        }
    }

    /// Whether the last stretches took equally long.
    pub fn has_settled(&self) -> bool {
        let last = &self.stretches[self.stretches.len().saturating_sub(ALIKE)..];
        let (least, most) = last
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(least, most), ms| (least.min(*ms), most.max(*ms)));
        last.len() == ALIKE && most - least <= SETTLED * least
    }

    /// Whether nothing counts yet.
    pub fn goes_on(&self) -> bool {
        !self.has_settled() && self.spent < LONGEST_MS
    }
}

/// What a device's timer tells apart, and what a submission costs.
#[derive(Clone, Copy, Debug)]
pub struct Timer {
    /// Nanoseconds a tick.
    pub tick_ns: f64,
    /// Bits that count; 0: there is no timer.
    pub bits: u32,
    /// Milliseconds of an empty submission, waited for.
    pub submission_ms: f64,
}

impl Timer {
    /// Why medians of a frame and of its passes, milliseconds, say little; nothing if they may be believed.
    pub fn doubts(&self, frame_ms: f64, passes: &[(&str, f64)], has_settled: bool) -> Vec<String> {
        let mut doubts = Vec::new();
        if !has_settled {
            let seconds = 1e-3 * LONGEST_MS;
            doubts.push(format!(
                "frame times had not settled after {seconds:.0} s of warm-up: the clock of the device may still change"
            ));
        }
        if frame_ms < LEAST_SUBMISSIONS * self.submission_ms {
            doubts.push(format!(
                "a frame takes {} ms and an empty submission {} ms: most of what is timed is no drawing",
                thousands_of(frame_ms, 3),
                thousands_of(self.submission_ms, 3)
            ));
        }
        let least_ms = LEAST_TICKS * 1e-6 * self.tick_ns;
        let short: Vec<&str> =
            passes.iter().filter(|(_, ms)| *ms < least_ms).map(|(name, _)| *name).collect();
        if self.bits > 0 && !short.is_empty() {
            doubts.push(format!(
                "{} under ten ticks of the timer, {} ns each: that is about what it tells apart",
                short.join(", "),
                thousands_of(self.tick_ns, 1)
            ));
        }
        let wraps_ms = 1e-6 * self.tick_ns * f64::from(self.bits).exp2();
        if self.bits > 0 && frame_ms >= wraps_ms {
            doubts.push(format!(
                "the timer begins again after {} ms, within a frame: its passes' times are wrong",
                thousands_of(wraps_ms, 0)
            ));
        }
        doubts
    }
}
