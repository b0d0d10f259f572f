//! The drops placed by hand, as the passes that draw them read them (`Placed` in `glsl/include/rain.glsl`).
//!
//! A drop in motion has another place in each frame. It is found here, in float64, so that it is exact however far
//! the scene's time is, and written into the command buffer: frames in flight need no copies.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::gpu::{Buffer, Device, Memory, Recorder};
use crate::rain::cull::split;
use crate::scene::{PlacedDrop, Scene};

/// Bytes that one `vkCmdUpdateBuffer` takes.
const MOST_AT_ONCE: usize = 65_536;

/// Centre in float32 and radius; what float32 lost of the centre.
type Record = [[f32; 4]; 2];

/// The buffer, and whether it changes from frame to frame.
pub(super) struct PlacedDrops {
    pub buffer: Buffer,
    moves: bool,
}

impl PlacedDrops {
    /// The drops of `scene` at its time.
    ///
    /// # Errors
    /// Those of [`Buffer::new`].
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let moves = scene.drops.iter().any(|drop| drop.velocity != glam::DVec3::ZERO);
        let usage = Usage::STORAGE_BUFFER;
        let buffer = if moves {
            let bytes = size_of::<Record>() * scene.drops.len();
            let usage = usage | Usage::TRANSFER_DST;
            Buffer::new(device, "placed drops", bytes as u64, usage, Memory::Device)?
        } else {
            Buffer::upload(device, "placed drops", &records(scene), usage)?
        };
        Ok(Self { buffer, moves })
    }

    /// Records the places in this frame, where they change; a barrier to compute must follow.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if !self.moves {
            return;
        }
        let records = records(scene);
        let bytes: &[u8] = bytemuck::cast_slice(&records);
        for (part, at) in bytes.chunks(MOST_AT_ONCE).zip((0..).step_by(MOST_AT_ONCE)) {
            let raw = self.buffer.raw();
            // SAFETY: recorded outside of rendering; the buffer holds the bytes, which are copied now.
            unsafe { device.raw().cmd_update_buffer(commands.raw(), raw, at, part) };
        }
    }
}

fn records(scene: &Scene) -> Vec<Record> {
    let record = |drop: &PlacedDrop| {
        let [high, low] = split(drop.center_at(scene.time));
        [high.extend(drop.radius as f32), low.extend(0.0)].map(Into::into)
    };
    scene.drops.iter().map(record).collect()
}
