//! What a frame under way has for itself, beside its command buffer: timestamps, and counts for the CPU to read.

use std::sync::Arc;

use super::FrameReport;
use super::drawing::Drawing;
use crate::Result;
use crate::gpu::{Buffer, Device, Recorder, Timestamps, Use, copy_range, memory_barrier};
use crate::passes::counters::{self, Counts};
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::totals::{self, TileCounts};

/// Words of the drops' counts, of the tiles', and the number of the recording that wrote them.
const WORDS: usize = counters::WORDS + totals::COUNTS.1 + 1;

/// One of the frames that may be under way at once.
pub(super) struct Slot {
    pub timestamps: Timestamps,
    counters: Buffer,
    /// Number of what was recorded last; 0: nothing yet.
    pub recording: u32,
    /// Least radius in pixels of a drop of real rain that was drawn by itself, by what was recorded last.
    pub cutoff_px: Option<f32>,
    /// Ticket of a host's commands, until it says that the slot has retired.
    pub ticket: Option<u64>,
}

impl Slot {
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let mut counters = Buffer::readback(device, "counters read back", 4 * WORDS as u64)?;
        counters.write(0, &[0u32; WORDS]);
        let timestamps = Timestamps::new(device)?;
        Ok(Self { timestamps, counters, recording: 0, cutoff_px: None, ticket: None })
    }

    /// Records the copies of what the passes have counted, after all of them.
    pub fn record_counts(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        drawing: &Drawing,
        frame: &FrameBuffer,
    ) {
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
        // It tells whether the commands were ever executed.
        let number = [(&frame.buffer, Frame::RECORDING, 4 * (WORDS - 1) as u64, 1)];
        let of_drops = drawing.counters().map(|from| (from, 0, 0, counters::WORDS));
        let after_drops = 4 * counters::WORDS as u64;
        let of_tiles =
            drawing.totals().map(|from| (from, totals::COUNTS.0, after_drops, totals::COUNTS.1));
        for (from, first, to, words) in of_drops.into_iter().chain(of_tiles).chain(number) {
            let to = (&self.counters, to);
            copy_range(device, commands, (from, first), to, 4 * words as u64);
        }
        memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
    }

    /// What the frame that was recorded last counted and took; none if its commands were never executed. They must not
    /// be under way. `room`: of the view ([`FrameReport::room`]).
    pub fn report(&self, drawing: &Drawing, room: u32) -> Result<Option<FrameReport>> {
        let words: Vec<u32> = self.counters.read(WORDS);
        if self.recording == 0 || words[WORDS - 1] != self.recording {
            return Ok(None);
        }
        let (of_drops, of_tiles) = words.split_at(counters::WORDS);
        let counts = drawing.counters().map(|_| Counts::of(of_drops)).unwrap_or_default();
        let tiles = drawing.ray_piece().map(|piece| TileCounts::of(of_tiles, piece));
        let (cutoff_px, passes_ms) = (self.cutoff_px, self.timestamps.read_ms()?);
        Ok(Some(FrameReport { counts, tiles, cutoff_px, room, passes_ms }))
    }
}
