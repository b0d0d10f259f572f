//! One variant drawn for minutes or hours without a break, watched stretch by stretch.
//!
//! The watching takes no more memory the longer it lasts, as memory is what is watched: of the frames it keeps
//! [`KEPT`] at most, evenly chosen.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::measure::{FILL, Measured, Run, STEP_SECONDS, Variant};
use super::over_time::Stretch;
use crate::Result;
use crate::environment::Environment;
use crate::gpu::Device;
use crate::measure::clocks::Clock;
use crate::measure::statistics::quantile;
use crate::measure::system::{load, resident_bytes};

/// Frames that are kept, at most; a power of two.
const KEPT: usize = 8192;
/// A stretch is a sixtieth of the whole, and a minute of what is longer than an hour. Of days it is longer, as
/// trends take the square of their number.
const STRETCHES: u32 = 60;
const MINUTE: Duration = Duration::from_secs(60);
const MOST_STRETCHES: u32 = 2000;

/// How long, and who gets the progress.
pub struct Watch<'a> {
    /// How long to draw.
    pub duration: Duration,
    /// Where the device's clock is read.
    pub clock: &'a Clock,
    /// Called after each stretch.
    pub tell: &'a mut dyn FnMut(&Stretch),
    /// Asked after each frame: whether to end before the time.
    pub stop: &'a dyn Fn() -> bool,
}

/// What was measured until the time was over, it was stopped, or a frame failed.
pub struct Watched {
    /// Without samples: those are to be chosen among `samples`.
    pub measured: Measured,
    /// Stretch by stretch.
    pub stretches: Vec<Stretch>,
    /// Times of frames, and of each pass, with the seconds at which they ended.
    pub samples: Samples,
    /// Times of each pass, by name, in the order of the frame.
    pub passes: Vec<(&'static str, Samples)>,
    /// What ended it too early.
    pub failed: Option<crate::Error>,
}

/// Evenly chosen values of a long series, with their times.
#[derive(Clone, Debug)]
pub struct Samples {
    kept: Vec<(f64, f64)>,
    /// Every so many are kept …
    stride: usize,
    /// … of so many.
    seen: usize,
}

impl Default for Samples {
    fn default() -> Self {
        // All of it at once, so that it does not grow while it is watched.
        Self { kept: Vec::with_capacity(KEPT), stride: 1, seen: 0 }
    }
}

impl Samples {
    fn push(&mut self, at_s: f64, value: f64) {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == KEPT {
                let mut number = 0;
                self.kept.retain(|_| {
                    number += 1;
                    number % 2 == 1
                });
                self.stride *= 2;
            }
            if self.seen.is_multiple_of(self.stride) {
                self.kept.push((at_s, value));
            }
        }
        self.seen += 1;
    }

    /// The values from a time on.
    pub fn since(&self, from_s: f64) -> Vec<f64> {
        self.kept.iter().filter(|(at, _)| *at > from_s).map(|(_, value)| *value).collect()
    }
}

/// Draws a variant for a long time.
///
/// # Errors
/// Like [`crate::renderer::Renderer::new`], and of the first frame. A later one's failure is among what was
/// measured.
pub fn watch(
    device: &Arc<Device>,
    environment: &Environment,
    variant: &Variant,
    watch: Watch<'_>,
) -> Result<Watched> {
    let mut run = Run::start(device, environment, variant)?;
    let (mut stretches, mut samples) = (Vec::new(), Samples::default());
    let mut passes: Vec<(&'static str, Samples)> =
        run.measured.passes_ms.iter().map(|(name, _)| (*name, Samples::default())).collect();
    let length = (watch.duration / STRETCHES).min(MINUTE);
    let length = length.max(watch.duration / MOST_STRETCHES).as_secs_f64();
    let (mut frames, mut end) = (Vec::new(), length);
    let start = Instant::now();
    let mut last = start;
    let mut failed = None;
    for number in 0.. {
        run.scene.time += STEP_SECONDS;
        let finished = match run.renderer.submit(&run.scene) {
            Ok(finished) => finished,
            Err(error) => {
                failed = Some(error);
                break;
            }
        };
        let now = Instant::now();
        let at = (now - start).as_secs_f64();
        if number >= FILL {
            let ms = (now - last).as_secs_f64() * 1e3;
            frames.push(ms);
            samples.push(at, ms);
            for (name, ms) in finished.map(|report| report.passes_ms).unwrap_or_default() {
                if let Some((_, all)) = passes.iter_mut().find(|(known, _)| *known == name) {
                    all.push(at, ms);
                }
            }
        }
        last = now;
        let is_stopped = (watch.stop)();
        let is_over = is_stopped || at >= watch.duration.as_secs_f64();
        if (is_over || at >= end) && !frames.is_empty() {
            let stretch = stretch(device, at, &frames, watch.clock);
            (watch.tell)(&stretch);
            stretches.push(stretch);
            frames.clear();
            end = length * (1.0 + (at / length).floor());
            // Asking the system is no frame's time.
            last = Instant::now();
        }
        if is_stopped || is_over && !stretches.is_empty() {
            break;
        }
    }
    if failed.is_none() {
        failed = run.renderer.finish().err();
    }
    Ok(Watched { measured: run.end(), stretches, samples, passes, failed })
}

fn stretch(device: &Arc<Device>, to_s: f64, frames: &[f64], clock: &Clock) -> Stretch {
    let part = |fraction| (quantile(frames, fraction) * 1e4).round() / 1e4;
    Stretch {
        to_s: (to_s * 1e3).round() / 1e3,
        frames: frames.len(),
        median_ms: part(0.5),
        p10_ms: part(0.1),
        p90_ms: part(0.9),
        resident_bytes: resident_bytes(),
        device_bytes: device.allocated_bytes(),
        clock_mhz: clock.mhz(),
        load: load(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_evenly_chosen_and_bounded() {
        let mut samples = Samples::default();
        for number in 0..100_000u32 {
            samples.push(f64::from(number), f64::from(number));
            assert!(samples.kept.len() <= KEPT);
        }
        let kept = samples.since(-1.0);
        assert!(kept.len() > KEPT / 2, "{}", kept.len());
        assert!(kept.windows(2).all(|two| two[1] - two[0] == kept[1] - kept[0]), "not even");
        assert_eq!(
            samples.since(50_000.0).first(),
            Some(&50_000.0f64.max(kept.iter().copied().find(|v| *v > 50_000.0).expect("one")))
        );
        assert_eq!(samples.kept.capacity(), KEPT, "it has grown");
    }
}
