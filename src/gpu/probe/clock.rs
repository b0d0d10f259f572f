//! Timestamps: whether they agree with the CPU's clock, and whether they book work where it is done.

use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use serde::Serialize;

use super::canvas::Canvas;
use crate::Result;
use crate::gpu::{
    Bindings, Commands, Device, GraphicsPipeline, GraphicsState, Timestamps, shaders,
};

const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// Steps of the heavy pass at first; ten times more until it takes long enough to be timed.
const STEPS: u32 = 1000;
const MOST_STEPS: u32 = 1_000_000;
/// Long enough that a submission's own cost does not matter.
const ENOUGH_MS: f64 = 10.0;

/// What a device's timestamps are worth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clock {
    /// Time between first and last timestamp, over the time that the CPU waited.
    pub share_of_wall: f64,
    /// The part of that time which is booked on the pass that did all but a thousandth of the work.
    pub share_of_heavy: f64,
}

impl Clock {
    /// Whether the times of single passes may be believed.
    pub fn is_sound(&self) -> bool {
        (0.5..1.1).contains(&self.share_of_wall) && self.share_of_heavy > 0.9
    }

    /// Probes a device; none without timestamps.
    pub(super) fn of(device: &Arc<Device>) -> Result<Option<Self>> {
        let bindings = Bindings::of(device, "probe clock", &[])?;
        let stages = [shaders::FULLSCREEN_VERT, shaders::PROBE_WORK_FRAG];
        let state = GraphicsState::triangles(FORMAT);
        let pipeline = GraphicsPipeline::new(device, stages, &bindings, 4, &[], &state)?;
        let canvas = || Canvas::new(device, (64, 64), FORMAT);
        let canvases = [canvas()?, canvas()?, canvas()?];
        let mut timestamps = Timestamps::new(device)?;
        let mut commands = Commands::new(device, "probe clock")?;
        let mut steps = STEPS;
        loop {
            let recorded = commands.begin()?;
            timestamps.reset();
            for (canvas, steps) in canvases.iter().zip([1, steps, 1]) {
                timestamps.time(recorded, "probe", || {
                    canvas.record(recorded, || {
                        pipeline.draw_triangle(recorded, &bindings, bytemuck::bytes_of(&steps));
                    });
                });
            }
            let start = Instant::now();
            commands.submit()?;
            commands.wait()?;
            let wall_ms = start.elapsed().as_secs_f64() * 1e3;
            // The first round compiles.
            if steps == STEPS || (wall_ms < ENOUGH_MS && steps < MOST_STEPS) {
                steps *= 10;
                continue;
            }
            // Without timestamps the queue gives none.
            let passes: Vec<f64> = timestamps.read_ms()?.iter().map(|(_, ms)| *ms).collect();
            let [_, heavy, _] = passes[..] else { return Ok(None) };
            let sum: f64 = passes.iter().sum();
            let share_of_heavy = if sum > 0.0 { heavy / sum } else { 0.0 };
            return Ok(Some(Self { share_of_wall: sum / wall_ms, share_of_heavy }));
        }
    }
}
