//! The records of the drops in view one after the other, so that a draw has no vertex for those that are not
//! (`glsl/{compact_counts,compact}.comp`): what preset `paper-compact` adds to the paper's frame. The paper draws
//! every drop, and five in six of a uniform rain are out of view.
//!
//! Order-preserving: the drops are counted in up to `BLOCKS` blocks, then each block's are written from the sum
//! of the counts before it. So blending meets them as it meets the paper's, and the picture is the same to the
//! byte where a device blends in the order of vertices. An append by atomics would save the first reading and
//! would make every picture another one.

use std::sync::Arc;

use ash::vk;

use super::simulate::{RECORD, Simulate};
use crate::Result;
use crate::abi::BLOCKS;
use crate::gpu::sets::{compact as slot, constant};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, memory_barrier,
    shaders,
};
use crate::scene::model::Primitive;

/// Words of an indirect draw's arguments.
const ARGUMENTS: u64 = 4;

/// The pass and its buffers.
pub struct Compact {
    /// The records in view of each chunk, from the chunk's own place on.
    pub drops: Buffer,
    /// Arguments of a draw for each chunk.
    pub arguments: Buffer,
    /// Drops of each chunk.
    lengths: Vec<u32>,
    chunk: u32,
    bindings: Bindings,
    count: ComputePipeline,
    write: ComputePipeline,
}

impl Compact {
    /// Buffers and pipelines for the records of `simulate`.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room for the drops once more;
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, simulate: &Simulate, primitive: Primitive) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let lengths = simulate.chunks();
        let chunks = lengths.len() as u64;
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let drops = make("drops in view", simulate.drops.size, Usage::VERTEX_BUFFER)?;
        let counts = make("counts in view", 4 * chunks * u64::from(BLOCKS), Usage::empty())?;
        let arguments = make("draws in view", 4 * ARGUMENTS * chunks, Usage::INDIRECT_BUFFER)?;
        let chunk = simulate.chunk();
        let bindings = Bindings::each(device, "compact", chunks as u32, |index| {
            let offset = u64::from(index) * u64::from(chunk) * RECORD;
            let bytes = u64::from(lengths[index as usize]) * RECORD;
            [
                (slot::DROPS, Resource::Range(&simulate.drops, offset, bytes)),
                (slot::COUNTS, Resource::Buffer(&counts)),
                (slot::COMPACTED, Resource::Range(&drops, offset, bytes)),
                (slot::ARGUMENTS, Resource::Buffer(&arguments)),
            ]
        })?;
        let is_quad = u32::from(primitive == Primitive::Quad);
        let count = ComputePipeline::new(device, shaders::COMPACT_COUNTS_COMP, &bindings, 12, &[])?;
        let constants = [[constant::QUADS, is_quad]];
        let write = ComputePipeline::new(device, shaders::COMPACT_COMP, &bindings, 12, &constants)?;
        Ok(Self { drops, arguments, lengths, chunk, bindings, count, write })
    }

    /// Records the pass, after the simulation and a barrier.
    pub fn record(&self, device: &Device, commands: Recorder<'_>) {
        for pipeline in [&self.count, &self.write] {
            for (index, length) in self.lengths.iter().enumerate() {
                let push = [index as u32, *length, length.div_ceil(BLOCKS)];
                let push = bytemuck::cast_slice(&push);
                // A workgroup has one subgroup at the least.
                pipeline.dispatch(commands, &self.bindings, index, push, [BLOCKS, 1, 1]);
            }
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        }
    }

    /// Where the records of each chunk begin, and where the arguments of its draw do, in bytes.
    pub fn draws(&self) -> impl Iterator<Item = (u64, u64)> {
        let chunk = RECORD * u64::from(self.chunk);
        (0..self.lengths.len() as u64).map(move |index| (chunk * index, 4 * ARGUMENTS * index))
    }
}
