//! The drops placed by hand, as the passes that draw them read them (`Placed` in `glsl/include/rain.glsl`).
//!
//! A drop in motion has another place in each frame. It is found here, in float64, so that it is exact however far
//! the scene's time is, and written into the command buffer: frames in flight need no copies.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;

use crate::Result;
use crate::gpu::{Buffer, Device, Memory, Recorder, update_buffer};
use crate::rain::cull::split;
use crate::scene::{PlacedDrop, Scene};

/// Centre in float32 and radius; what float32 lost of the centre, and the number. Words, as a number may be no float.
type Record = [u32; 8];

/// The buffers, and whether they change from frame to frame.
pub(super) struct PlacedDrops {
    pub buffer: Buffer,
    /// How far each moves while the shutter is open; of no use where none does.
    pub motions: Buffer,
    moves: bool,
    is_exposed: bool,
}

impl PlacedDrops {
    /// The drops of `scene` at its time.
    ///
    /// # Errors
    /// Those of [`Buffer::new`].
    pub fn new(device: &Arc<Device>, scene: &Scene, is_exposed: bool) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        // While the shutter is open the camera may move, too.
        let moves = is_exposed || scene.placed().any(|drop| drop.velocity != DVec3::ZERO);
        let usage = Usage::STORAGE_BUFFER;
        let buffer = if moves {
            let bytes = size_of::<Record>() * scene.placed_count() as usize;
            let usage = usage | Usage::TRANSFER_DST;
            Buffer::new(device, "placed drops", bytes as u64, usage, Memory::Device)?
        } else {
            Buffer::upload(device, "placed drops", &records(scene), usage)?
        };
        let count = if is_exposed { scene.placed_count().max(1) as usize } else { 1 };
        let bytes = (size_of::<[f32; 4]>() * count) as u64;
        let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_DST;
        let motions = Buffer::new(device, "motions of placed drops", bytes, usage, Memory::Device)?;
        Ok(Self { buffer, motions, moves, is_exposed })
    }

    /// Records the places in this frame, where they change; a barrier to compute must follow.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if self.moves {
            let records = records(scene);
            update_buffer(device, commands, &self.buffer, 0, bytemuck::cast_slice(&records));
        }
        if self.is_exposed && scene.placed_count() > 0 {
            let motion = |drop: &PlacedDrop| {
                scene.drawn_motion_of(drop.velocity).as_vec3().extend(0.0).to_array()
            };
            let motions: Vec<[f32; 4]> = scene.placed().map(motion).collect();
            update_buffer(device, commands, &self.motions, 0, bytemuck::cast_slice(&motions));
        }
    }
}

fn records(scene: &Scene) -> Vec<Record> {
    let record = |(place, drop): (u32, &PlacedDrop)| {
        let [high, low] =
            split(scene.drawn_center(drop)).map(|part| part.to_array().map(f32::to_bits));
        let ([x, y, z], [dx, dy, dz]) = (high, low);
        [x, y, z, (drop.radius as f32).to_bits(), dx, dy, dz, scene.number_of(drop, place)]
    };
    (0..).zip(scene.placed()).map(record).collect()
}
