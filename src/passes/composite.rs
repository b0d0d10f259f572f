//! The picture from the tiles' lists (`glsl/composite.comp`): every tile's drops over one another,
//! front to back, exactly in order; the sky behind.
//!
//! One invocation a tile of 4 x 2 pixels, not a pixel: neighbouring lanes then read different drops,
//! each of which meets most of the tile's pixels, and the pixels stay in registers from the nearest
//! drop to the sky. With a lane a pixel, lanes would read the same drops over and over, most of them
//! to find that they do not touch; on CPU drivers reading is what costs.
//!
//! A drop's outline is the true ellipse; the part of a pixel that it covers keeps the sum over all
//! pixels equal to the outline's area. Up to some pixels of radius its colour comes from the
//! prefiltered pictures (`appearance.rs`). Above, `glsl/rays.comp` has computed its pixels before:
//! the closed form along rays through several places of the pixel, one invocation a pixel.

use std::sync::Arc;

use ash::vk;

use super::appearance::Appearance;
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::light_constants;
use super::tiles::{BLOCK_GROUPS, Tiles};
use crate::Result;
use crate::gpu::{Binding, Bindings, Buffer, ComputePipeline, Device, Memory, Resource, shaders};
use crate::plan::FramePlan;

/// The passes.
pub struct Composite {
    /// The picture: four halves a pixel, row by row from the top, in stored units.
    pub radiance: Buffer,
    tiles: u32,
    bindings: Bindings,
    rays: ComputePipeline,
    composite: ComputePipeline,
}

impl Composite {
    /// The passes for an image of this size.
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

        let buffer = |buffer| (Binding::STORAGE_BUFFER, Resource::Buffer(buffer));
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let slots: Vec<_> =
            std::iter::once((Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer)))
                .chain(tiles.shared.iter().map(buffer))
                .chain([
                    (Binding::COMBINED_IMAGE_SAMPLER, map),
                    buffer(&appearance.table),
                    buffer(&radiance),
                ])
                .collect();
        let bindings = Bindings::of(device, "composite", &slots)?;
        let pipeline = |shader, constants: &[u32]| {
            ComputePipeline::new(device, shader, &bindings, 0, constants)
        };
        let [a, b, c, d, e] = light_constants(&plan.light);
        let constants = [a, b, c, d, e, tiles.max_blocks, plan.samples];
        let rays = pipeline(shaders::RAYS_COMP, &constants)?;
        let constants = [tiles.count, tiles.max_entries, tiles.max_blocks];
        let composite = pipeline(shaders::COMPOSITE_COMP, &constants)?;
        Ok(Self { radiance, tiles: tiles.count, bindings, rays, composite })
    }

    /// Records the pixels of the large drops, after the tiles' lists and a barrier.
    pub fn record_rays(&self, commands: vk::CommandBuffer, tiles: &Tiles) {
        self.rays.dispatch_indirect(commands, &self.bindings, tiles.totals(), BLOCK_GROUPS);
    }

    /// Records the drops over one another and the sky behind, after [`Composite::record_rays`] and a
    /// barrier.
    pub fn record(&self, commands: vk::CommandBuffer) {
        self.composite.dispatch(commands, &self.bindings, 0, &[], [self.tiles.div_ceil(64), 1, 1]);
    }
}
