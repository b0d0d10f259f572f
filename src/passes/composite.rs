//! The picture from the tiles' lists (`glsl/composite.comp`): every tile's drops over one another,
//! front to back, exactly in order; the sky behind.
//!
//! One invocation a tile, not a pixel: neighbouring lanes then read different drops, and each drop's
//! few pixels are looped over, where a lane a pixel would have all 64 look at each drop. Four in five
//! of those looks would find nothing, and a CPU driver pays for them all.
//!
//! A drop's outline is the true ellipse; the part of a pixel that it covers keeps the sum over all
//! pixels equal to the outline's area. Up to some pixels of radius its colour comes from the
//! prefiltered pictures (`appearance.rs`); above, from the closed form along rays through several
//! places of the pixel.

use std::sync::Arc;

use ash::vk;

use super::appearance::Appearance;
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::simulate::MAX_LARGE;
use super::tiles::Tiles;
use crate::Result;
use crate::gpu::{Binding, Bindings, Buffer, ComputePipeline, Device, Memory, Resource, shaders};
use crate::plan::FramePlan;

/// The pass.
pub struct Composite {
    /// The picture: four halves a pixel, row by row from the top, in stored units.
    pub radiance: Buffer,
    groups: u32,
    bindings: Bindings,
    pipeline: ComputePipeline,
    _layers: Buffer,
}

impl Composite {
    /// The pass for an image of this size.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        appearance: &Appearance,
        tiles: &Tiles,
        (width, height): (u32, u32),
        plan: &FramePlan,
    ) -> Result<Self> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        let bytes = 8 * u64::from(width) * u64::from(height);
        let radiance = Buffer::new(device, "radiance", bytes, usage, Memory::Device)?;
        let layers = 16 * 64 * u64::from(tiles.count);
        let layers = Buffer::new(device, "layers", layers, usage, Memory::Device)?;

        let buffer = |buffer| (Binding::STORAGE_BUFFER, Resource::Buffer(buffer));
        // The numbers are those of tile_buffers.glsl; what this pass does not use of them is filled
        // with the counters, which it has anyway.
        let unused = || buffer(&tiles.counters);
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let bindings = Bindings::of(
            device,
            "composite",
            &[
                (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer)),
                unused(),
                unused(),
                unused(),
                unused(),
                buffer(&tiles.records),
                buffer(&tiles.spheres),
                buffer(&tiles.record_index),
                unused(),
                unused(),
                unused(),
                buffer(&tiles.tiles),
                buffer(&tiles.entries),
                buffer(&tiles.large),
                unused(),
                (Binding::COMBINED_IMAGE_SAMPLER, map),
                buffer(&tiles.counters),
                buffer(&appearance.table),
                buffer(&layers),
                buffer(&radiance),
            ],
        )?;
        let constants = [
            tiles.count,
            tiles.max_entries,
            MAX_LARGE,
            plan.appearance_px.to_bits(),
            plan.samples,
            plan.internal_reflections,
            1,
        ];
        let pipeline =
            ComputePipeline::new(device, shaders::COMPOSITE_COMP, &bindings, 0, &constants)?;
        let groups = tiles.count.div_ceil(32);
        Ok(Self { radiance, groups, bindings, pipeline, _layers: layers })
    }

    /// Records the pass, after the tiles' lists and a barrier.
    pub fn record(&self, commands: vk::CommandBuffer) {
        self.pipeline.dispatch(commands, &self.bindings, 0, &[], [self.groups, 1, 1]);
    }
}
