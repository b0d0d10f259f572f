//! The paper's section 4, simulation: every drop's place at the frame's time, and whether it is in
//! view (`glsl/simulate.comp`); then the order of those too large for a point
//! (`glsl/order_large.comp`).
//!
//! Each drop becomes a record of 16 bytes, centre in view space and radius, which the draw reads as
//! a vertex. Positions come from a hash and exact integers (`src/rain/mod.rs`), or, as the paper has it,
//! from a stored buffer that each frame moves on; that one costs 16 bytes more a drop, read and
//! written, and drifts.
//!
//! The buffer of records may be longer than a storage binding may be: it is processed in chunks.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::gpu::sets::{constant, group, order_large, simulate as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, fill_buffer,
    memory_barrier, shaders,
};
use crate::passes::counters;
use crate::passes::frame::FrameBuffer;
use crate::passes::placed::{PlacedDrops, part_of};
use crate::scene::Scene;
use crate::scene::model::Simulation;

/// Most drops drawn as quads because they are larger than a point may be, fewer where a binding holds
/// fewer; those beyond it are counted and reported, not drawn. Each covers over 65,000 pixels, so no frame
/// gets near it.
pub const MAX_LARGE: u32 = 65_536;

/// Bytes of a drop record: centre in view space, radius.
pub(super) const RECORD: u64 = 16;
/// Invocations a workgroup.
const GROUP: u32 = group::SIMULATE_COMP[0];
/// Workgroups that put the large drops in order; each invocation takes every 1024th.
const ORDER_GROUPS: u32 = 16;

/// The pass and its buffers.
pub struct Simulate {
    /// One record a drop; radius 0: nothing to draw.
    pub drops: Buffer,
    /// Records of the large drops, back to front.
    pub ordered: Buffer,
    /// Arguments of their draw.
    pub arguments: Buffer,
    /// What was counted.
    pub counters: Buffer,
    chunk: u32,
    count: u32,
    bindings: Bindings,
    pipeline: ComputePipeline,
    order_bindings: Bindings,
    order_pipeline: ComputePipeline,
    placed: PlacedDrops,
}

impl Simulate {
    /// Buffers and pipelines for the drops of `scene`.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the placed drops do not fit in one binding; [`crate::Error::Memory`] if
    /// the device has no room for the drops; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        scene: &Scene,
        simulation: Simulation,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let count = scene.drop_count();
        let random = scene.rain.map_or(0, |rain| rain.count);
        let limit = u64::from(device.report.limits.max_storage_buffer_range) / RECORD;
        let groups = device.report.limits.max_compute_work_group_count[0];
        let most = limit.min(u64::from(groups) * u64::from(GROUP)) / u64::from(GROUP);
        let chunk = (most * u64::from(GROUP)).min(1 << 31) as u32;
        let max_large = MAX_LARGE.min(limit as u32);

        let storage = Usage::STORAGE_BUFFER;
        let make = |name, bytes, usage| Buffer::new(device, name, bytes, usage, Memory::Device);
        let drops = make(
            "drops",
            RECORD * u64::from(count),
            storage | Usage::VERTEX_BUFFER | Usage::TRANSFER_SRC,
        )?;
        let stored_count = if simulation == Simulation::Stored { random } else { 0 };
        let stored = make("stored positions", RECORD * u64::from(stored_count), storage)?;
        let large = make("large drops", RECORD * u64::from(max_large), storage)?;
        let large_index = make("large drops' indices", 4 * u64::from(max_large), storage)?;
        let ordered = make(
            "large drops in order",
            RECORD * u64::from(max_large),
            storage | Usage::VERTEX_BUFFER,
        )?;
        let arguments = make("large drops' draw", 16, storage | Usage::INDIRECT_BUFFER)?;
        let counters = counters::buffer(device)?;
        let placed = PlacedDrops::new(device, (frame, &[]), scene, false, Arc::default())?;

        let chunks = count.div_ceil(chunk).max(1);
        let bindings = Bindings::each(device, "simulate", chunks, |index| {
            let bytes = RECORD * u64::from(chunk);
            // Placed drops come last, so a chunk may hold no stored position: bind the first.
            let of_stored = if bytes * u64::from(index) < stored.size { index } else { 0 };
            [
                (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
                (slot::DROPS, part_of(&drops, bytes, index)),
                (slot::PLACED_DROPS, Resource::Buffer(&placed.buffer)),
                (slot::STORED, part_of(&stored, bytes, of_stored)),
                (slot::LARGE_DROPS, Resource::Buffer(&large)),
                (slot::LARGE_INDEX, Resource::Buffer(&large_index)),
                (slot::COUNTERS, Resource::Buffer(&counters)),
            ]
        })?;
        let constants = [
            [constant::STORED, (simulation == Simulation::Stored).into()],
            [constant::MAX_LARGE, max_large],
            [constant::SEVERAL, (scene.populations().len() > 1).into()],
        ];
        let shader = shaders::SIMULATE_COMP;
        let pipeline = ComputePipeline::new(device, shader, &bindings, 8, &constants)?;
        let slots = [
            (order_large::LARGE_DROPS, &large),
            (order_large::LARGE_INDEX, &large_index),
            (order_large::COUNTERS, &counters),
            (order_large::ORDERED, &ordered),
            (order_large::ARGUMENTS, &arguments),
        ]
        .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)));
        let order_bindings = Bindings::of(device, "order large", &slots)?;
        let (shader, constants) = (shaders::ORDER_LARGE_COMP, [[constant::MAX_LARGE, max_large]]);
        let order_pipeline = ComputePipeline::new(device, shader, &order_bindings, 0, &constants)?;
        Ok(Self {
            drops,
            ordered,
            arguments,
            counters,
            chunk,
            count,
            bindings,
            pipeline,
            order_bindings,
            order_pipeline,
            placed,
        })
    }

    /// Number of drops that each chunk but the last has.
    pub(super) fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Number of drops of each chunk, in order: what one binding holds of the records.
    pub(super) fn chunks(&self) -> Vec<u32> {
        let firsts = (0..self.count).step_by(self.chunk as usize);
        firsts.map(|first| self.chunk.min(self.count - first)).collect()
    }

    /// Records the counters' reset and the placed drops' places; a barrier to compute must follow.
    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        self.placed.record(device, commands, scene);
        fill_buffer(device, commands, &self.counters, 0..self.counters.size, 0);
    }

    /// Records the simulation and the ordering of the large drops.
    pub fn record(&self, device: &Device, commands: Recorder<'_>) {
        for (index, length) in self.chunks().into_iter().enumerate() {
            let push = [index as u32 * self.chunk, length];
            let push = bytemuck::cast_slice(&push);
            let groups = [length.div_ceil(GROUP), 1, 1];
            self.pipeline.dispatch(commands, &self.bindings, index, push, groups);
        }
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        self.order_pipeline.dispatch(commands, &self.order_bindings, 0, &[], [ORDER_GROUPS, 1, 1]);
    }
}
