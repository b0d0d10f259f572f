//! What a compositor needs beside the light of the rain (`glsl/layers.comp`): for each pixel the nearest drop that covers
//! a part of it, with its depth, its motion and its number, and how many drops do.
//!
//! The tiles' lists hold each drop once a tile, so one walk along a list tells both; order does not matter. It is
//! recorded before `composite`, which puts some lists in order and thereby takes them from their heads. A drop's place
//! is found again from its index, as `gather` found it: nothing is kept for it.
//!
//! Motion is that of a drop's centre, from the frame's time to another that the caller gives, each seen by its own camera:
//! so it holds for drops that fall and for a camera that moves. It is told by velocity and not by a second look
//! at the cells, so a drop that leaves its box, or is shown no longer by then, has one too.
//! Error: float16, 2⁻¹¹ of itself.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;

use super::frame::FrameBuffer;
use super::tiles::Tiles;
use crate::Result;
use crate::abi::Motion;
use crate::gpu::sets::layers as slot;
use crate::gpu::{Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, shaders};
use crate::scene::Scene;
use crate::scene::projection::View;

/// Bytes that one `vkCmdUpdateBuffer` takes.
const MOST_AT_ONCE: usize = 65_536;
/// Workgroups of a dispatch along an axis, on any device.
const MOST_GROUPS: u32 = 65_535;

/// The pass and what it writes.
pub struct LayersPass {
    /// Four words a pixel, all 0 where no drop is: planar depth as bits; motion as two halves; the number's low and high
    /// word.
    pub nearest: Buffer,
    /// A word a pixel: drops that cover a part of it.
    pub counts: Buffer,
    motion: Buffer,
    groups: [u32; 3],
    bindings: Bindings,
    pass: ComputePipeline,
}

impl LayersPass {
    /// The pass over `tiles`, for a picture of this size.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the picture does not fit in one binding; [`crate::Error::Memory`] if the device has no
    /// room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        tiles: &Tiles,
        (width, height): (u32, u32),
        scene: &Scene,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let pixels = u64::from(width) * u64::from(height);
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let read = Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let nearest = make("nearest drops", 16 * pixels, read)?;
        let counts = make("drops a pixel", 4 * pixels, read)?;
        let moved = size_of::<Motion>() + 16 * scene.drops.len().max(1);
        let motion = make("motion", moved as u64, Usage::TRANSFER_DST)?;
        let nodes = tiles.texels.as_ref().map(|texels| &texels.nodes);
        let slots = [
            (slot::CONSTANTS, &frame.buffer),
            (slot::RAIN_FIELD, tiles.field_or(&counts)),
            (slot::NODES, &tiles.lists.nodes),
            (slot::HEADS, &tiles.lists.heads),
            (slot::PLACED_DROPS, tiles.placed()),
            // Without a depth no shader reads it.
            (slot::REACH, tiles.reach.as_ref().unwrap_or(&counts)),
            (slot::NEAREST, &nearest),
            (slot::COUNTS, &counts),
            (slot::MOTION, &motion),
        ];
        let slots = slots.map(|(slot, buffer)| (slot, Resource::Buffer(buffer)));
        let nodes_slot = nodes.map(|nodes| (slot::NODE_TEXELS, Resource::Texels(nodes)));
        let slots: Vec<_> = slots.into_iter().chain(nodes_slot).collect();
        let bindings = Bindings::of(device, "layers", &slots)?;
        let shader = match (tiles.has_cells(), nodes.is_some()) {
            (true, true) => shaders::LAYERS_COMP_CELLS_TEXELS,
            (true, false) => shaders::LAYERS_COMP_CELLS,
            (false, true) => shaders::LAYERS_COMP_TEXELS,
            (false, false) => shaders::LAYERS_COMP,
        };
        let pass = ComputePipeline::new(device, shader, &bindings, 0, &tiles.constants)?;
        let groups = tiles.count.div_ceil(64);
        let rows = groups.div_ceil(MOST_GROUPS);
        let groups = [groups.div_ceil(rows), rows, 1];
        Ok(Self { nearest, counts, motion, groups, bindings, pass })
    }

    /// Records the motion from `scene` to what `then` shows so many `seconds` later, and that there is nothing yet; a
    /// barrier to compute must follow.
    pub fn record_motion(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        (then, seconds): (&View, f64),
    ) {
        // Most pixels have no drop, and CPU drivers take their time to write each word.
        for empty in [&self.nearest, &self.counts] {
            // SAFETY: recorded outside of rendering.
            unsafe {
                device.raw().cmd_fill_buffer(commands.raw(), empty.raw(), 0, vk::WHOLE_SIZE, 0);
            }
        }
        let now = scene.camera.position;
        let with = |v: DVec3, w: f64| v.as_vec3().extend(w as f32).to_array();
        let mut motion = Motion {
            right: with(then.right, 0.0),
            up: with(then.up, 0.0),
            back: with(then.back, 0.0),
            shift: with(now - then.position, then.focal_px),
            ..Motion::default()
        };
        let [column, row] = then.origin.map(f64::from);
        motion.principal = with(then.principal.extend(0.0) + DVec3::new(column, row, 0.0), 0.0);
        for (moved, rain) in motion.rain.iter_mut().zip(scene.populations()) {
            *moved = with(rain.velocity * seconds, 0.0);
        }
        if let Some(rain) = scene.real_rain() {
            let lattices = rain.lattices(scene.seed);
            for (moved, lattice) in motion.classes.iter_mut().zip(&lattices) {
                *moved = with(lattice.velocity * (seconds / scene.metres), 0.0);
            }
        }
        let of_drop = |velocity: DVec3| -> [f32; 4] { with(velocity * seconds, 0.0) };
        let placed: Vec<_> = scene.drops.iter().map(|drop| of_drop(drop.velocity)).collect();
        let parts = [bytemuck::bytes_of(&motion), bytemuck::cast_slice(&placed)];
        for (first, bytes) in [0, size_of::<Motion>()].into_iter().zip(parts) {
            for (number, part) in bytes.chunks(MOST_AT_ONCE).enumerate() {
                let at = (first + number * MOST_AT_ONCE) as u64;
                let raw = self.motion.raw();
                // SAFETY: recorded outside of rendering; the buffer holds the bytes, which are copied now.
                unsafe { device.raw().cmd_update_buffer(commands.raw(), raw, at, part) };
            }
        }
    }

    /// Records it, when the lists are whole and a barrier has followed.
    pub fn record(&self, commands: Recorder<'_>) {
        self.pass.dispatch(commands, &self.bindings, 0, &[], self.groups);
    }
}
