//! Frame times of several variants of one scene, in turn.
//!
//! Machines are noisy and clocks drift, so variants that are compared run alternately in short
//! batches, and medians are reported. A sample is the wall-clock time between two frames that come
//! out of a queue kept two frames deep: the throughput that a frame rate means. The first frame
//! stands apart, because drivers compile late; the first two of a batch only fill the queue. On a GPU nothing counts
//! before its clock has settled (`believed.rs`); a CPU's is that of the whole machine, and its frames are long.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use super::believed::{Timer, WarmUp};
use crate::Result;
use crate::environment::Environment;
use crate::gpu::{Commands, Device, Machine};
use crate::measure::statistics::median;
use crate::plan::FramePlan;
use crate::renderer::{FrameReport, Renderer};
use crate::scene::Scene;

/// Frames that fill the queue at the start of a batch.
pub(super) const FILL: usize = 2;
/// Seconds of scene time a frame: the rain falls while it is measured, as in the paper.
pub(super) const STEP_SECONDS: f64 = 1.0 / 60.0;

/// A variant whose frames take very long is left with fewer of them.
const PATIENCE: f64 = 10.0;

/// A renderer's making and its first frame take about so many seconds, of which most are compiling.
const START_S: f64 = 0.6;

/// How long to measure a variant.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Go on until so much time is measured …
    pub seconds: f64,
    /// … and at least so many frames, but no longer than ten times the seconds.
    pub frames: usize,
    /// Asked between batches: true if what is measured has to do, although it is less.
    pub stop: fn() -> bool,
}

impl Effort {
    /// Seconds that a variant takes whose frames take `frame_ms`, its start included.
    pub fn expected_s(&self, frame_ms: f64) -> f64 {
        let frame = 1e-3 * frame_ms.max(1e-3);
        let wanted = (self.seconds / frame).max(self.frames as f64);
        let samples = wanted.min(PATIENCE * self.seconds / frame).max(1.0).ceil();
        // In a batch, as below.
        let of_batch = |least: f64, seconds: f64| (seconds / frame - FILL as f64).ceil().max(least);
        let short = of_batch(4.0, self.seconds / 6.0);
        let batch = short.min(of_batch(1.0, self.seconds));
        START_S + samples * frame * (batch + FILL as f64) / batch
    }
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The scene at its first frame.
    pub scene: Scene,
    /// Its plan.
    pub plan: FramePlan,
}

/// What was measured of a variant.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// Milliseconds to make the renderer: mask, environment, pipelines, buffers.
    pub setup_ms: f64,
    /// Times of the parts that are made once, such as the mask, in milliseconds.
    pub setup_parts: Vec<(&'static str, f64)>,
    /// Milliseconds of the first frame.
    pub first_frame_ms: f64,
    /// The first frame's report.
    pub first: FrameReport,
    /// Bytes of device memory that the renderer took.
    pub bytes: u64,
    /// Wall-clock milliseconds a frame.
    pub samples_ms: Vec<f64>,
    /// GPU milliseconds of each pass, by name, in the order of the frame.
    pub passes_ms: Vec<(&'static str, Vec<f64>)>,
    /// Why its times say little, a line each.
    pub doubts: Vec<String>,
}

/// A variant that is drawn.
pub(super) struct Run {
    pub(super) renderer: Renderer,
    pub(super) scene: Scene,
    pub(super) measured: Measured,
    passes: BTreeMap<&'static str, Vec<f64>>,
    /// The last frames before those that count.
    warm_up: WarmUp,
}

/// Measures every variant, in turn; `tick` is called with the share done, from 0 to 1.
///
/// # Errors
/// Like [`Renderer::new`], [`Renderer::submit`] and [`Renderer::finish`], by the first variant that fails;
/// what was measured until then is lost.
pub fn measure(
    device: &Arc<Device>,
    environment: &Environment,
    variants: &[Variant],
    effort: Effort,
    tick: &dyn Fn(f64),
) -> Result<Vec<Measured>> {
    let mut runs = Vec::new();
    for variant in variants {
        runs.push(Run::start(device, environment, variant)?);
    }
    // Only now: what makes a renderer leaves a card at rest.
    for run in runs.iter_mut().filter(|_| device.report.machine == Machine::Gpu) {
        run.warm_up(effort)?;
    }
    let timer = timer(device)?;
    loop {
        let share = |run: &Run| -> f64 {
            let spent: f64 = run.measured.samples_ms.iter().sum::<f64>() * 1e-3;
            let frames = run.measured.samples_ms.len() as f64;
            let patience = spent / (PATIENCE * effort.seconds);
            (spent / effort.seconds).min(frames / effort.frames as f64).max(patience).min(1.0)
        };
        let done = runs.iter().map(share).sum::<f64>() / runs.len().max(1) as f64;
        tick(done);
        if done >= 1.0 {
            break;
        }
        for run in runs.iter_mut().filter(|run| share(run) < 1.0) {
            run.batch(effort)?;
        }
        if (effort.stop)() {
            break;
        }
    }
    let is_gpu = device.report.machine == Machine::Gpu;
    Ok(runs.into_iter().map(|run| run.doubted(&timer, is_gpu).end()).collect())
}

/// Empty submissions of which the least is taken: what else the machine does only adds.
const EMPTY: usize = 9;

/// What the device's timer tells apart, and what a submission costs.
fn timer(device: &Arc<Device>) -> Result<Timer> {
    let mut submission_ms = f64::INFINITY;
    let mut commands = Commands::new(device, "nothing")?;
    for _ in 0..EMPTY {
        commands.begin()?;
        let before = Instant::now();
        commands.submit()?;
        commands.wait()?;
        submission_ms = submission_ms.min(ms_since(before));
    }
    let (tick_ns, bits) = device.report.timer();
    Ok(Timer { tick_ns, bits, submission_ms })
}

impl Run {
    /// Makes its renderer and draws the first frame.
    pub(super) fn start(
        device: &Arc<Device>,
        environment: &Environment,
        variant: &Variant,
    ) -> Result<Self> {
        let bytes_before = device.allocated_bytes();
        let before = Instant::now();
        let mut renderer = Renderer::new(device, &variant.scene, environment, &variant.plan)?;
        let setup_ms = ms_since(before);
        let before = Instant::now();
        let first = renderer.draw(&variant.scene)?;
        let first_frame_ms = ms_since(before);
        let bytes = device.allocated_bytes() - bytes_before;
        let passes_ms = first.passes_ms.iter().map(|(name, _)| (*name, Vec::new())).collect();
        let measured = Measured {
            setup_ms,
            setup_parts: renderer.setup_ms(),
            first_frame_ms,
            first,
            bytes,
            samples_ms: Vec::new(),
            passes_ms,
            doubts: Vec::new(),
        };
        let scene = variant.scene.clone();
        let (passes, warm_up) = (BTreeMap::new(), WarmUp::default());
        Ok(Self { renderer, scene, measured, passes, warm_up })
    }

    /// Draws until successive frames take equally long, which does not count.
    fn warm_up(&mut self, effort: Effort) -> Result<()> {
        let mut last = Instant::now();
        while self.warm_up.goes_on() && !(effort.stop)() {
            self.scene.time += STEP_SECONDS;
            self.renderer.submit(&self.scene)?;
            let now = Instant::now();
            self.warm_up.take((now - last).as_secs_f64() * 1e3);
            last = now;
        }
        self.renderer.finish()?;
        Ok(())
    }

    /// Itself, with why its times say little.
    fn doubted(mut self, timer: &Timer, warms_up: bool) -> Self {
        let medians = self.passes.iter().map(|(name, ms)| (*name, median(ms)));
        let medians: Vec<(&str, f64)> = medians.collect();
        if !self.measured.samples_ms.is_empty() {
            let has_settled = !warms_up || self.warm_up.has_settled();
            let frame_ms = median(&self.measured.samples_ms);
            self.measured.doubts = timer.doubts(frame_ms, &medians, has_settled);
        }
        self
    }

    /// A few frames, or a sixth of the effort where frames are short.
    fn batch(&mut self, effort: Effort) -> Result<()> {
        let start = Instant::now();
        let mut last = start;
        let mut taken = 0;
        for number in 0.. {
            self.scene.time += STEP_SECONDS;
            let finished = self.renderer.submit(&self.scene)?;
            let now = Instant::now();
            if number >= FILL {
                self.measured.samples_ms.push((now - last).as_secs_f64() * 1e3);
                taken += 1;
                for (name, ms) in finished.map(|report| report.passes_ms).unwrap_or_default() {
                    self.passes.entry(name).or_default().push(ms);
                }
            }
            last = now;
            let elapsed = start.elapsed().as_secs_f64();
            if elapsed > effort.seconds / 6.0
                && (taken >= 4 || taken >= 1 && elapsed > effort.seconds)
            {
                break;
            }
        }
        self.renderer.finish()?;
        Ok(())
    }

    /// What was measured.
    pub(super) fn end(mut self) -> Measured {
        for (name, samples) in &mut self.measured.passes_ms {
            *samples = self.passes.remove(name).unwrap_or_default();
        }
        self.measured
    }
}

fn ms_since(before: Instant) -> f64 {
    before.elapsed().as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With [`Run::batch`]: short frames take the seconds, long ones the frames and those that fill the queue.
    #[test]
    fn long_frames_take_longer_than_the_seconds() {
        let effort = Effort { seconds: 2.0, frames: 12, stop: || false };
        let of = |frame_ms| effort.expected_s(frame_ms) - START_S;
        assert!((2.0..2.2).contains(&of(1.0)), "{}", of(1.0));
        // Frames of 1.5 s: a batch is one sample after two that fill the queue, and twelve are wanted.
        assert!((of(1500.0) - 54.0).abs() < 1e-6, "{}", of(1500.0));
        // Frames of 15 s get no more than twenty seconds of samples.
        assert!((of(15_000.0) - 90.0).abs() < 1e-6, "{}", of(15_000.0));
    }
}
