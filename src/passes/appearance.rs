//! The prefiltered picture of a far drop, from every direction: the paper's hierarchical map carried
//! from directions to appearance (`glsl/appearance.comp`).
//!
//! A far drop's picture depends on the view direction and the place on its disc alone. For each of
//! 64 x 64 directions of an octahedral map it is integrated once: a pyramid of pictures of 16 x 16
//! down to 1 texel, reflection and all internal orders with their exact Fresnel weights, some 400
//! samples in all, each with its footprint in the environment: one a texel, towards the rim four. (With four
//! everywhere it took half as long again, and in eight scenes before photographs errors were the same within 0.5 %.) A drop of up to
//! some 12 pixels is then one read of a word a pixel.
//!
//! The orders beyond the second internal reflection carry 0.1 % of the energy; it goes where the
//! second goes, so that a white furnace stays white. Memory: 5.6 MB, a word a texel (9 bits a colour,
//! a common exponent). Error: directions are quantised to 2.8°, which turns a picture by 1.4° at
//! most, a tenth of a texel of the finest picture; near drops look different from far ones (the
//! directions are off by 2.8° at 16 radii, 0.6° at 64).
//!
//! All colours are refracted by the index of green: by another one a direction differs by less than a sample's
//! footprint, and where that shows, in images of small bright sources and so in rainbows, the sources are not in the
//! map that is integrated (`glsl/far_glints.comp` has each colour by its own index). With three indices the table took
//! 2.5 times as long, and changed `fast` by a relMSE of 1e-5 at most under a hazy sun 5° across, where its error is
//! 4e-4 to 3e-3.

use std::sync::Arc;

use ash::vk;

use super::environment::EnvironmentMap;
use super::frame::{Frame, FrameBuffer};
use super::glints::Glints;
use super::light_constants;
use crate::Result;
use crate::gpu::sets::{appearance as slot, group};
use crate::gpu::{
    Bindings, Buffer, Commands, ComputePipeline, Device, Memory, Recorder, Resource, Use,
    memory_barrier, shaders,
};
use crate::plan::Light;

/// Directions of the octahedral map.
pub(super) const DIRECTIONS: u32 = crate::abi::DIRECTIONS * crate::abi::DIRECTIONS;
/// Words of all pictures of a direction, that of one texel included.
const PICTURES: u32 = 1 + crate::abi::PYRAMID;

/// The table and the pass that makes it.
pub struct Appearance {
    /// One word a texel, as `glsl/include/appearance.glsl` places them.
    pub table: Buffer,
    bindings: Bindings,
    pipeline: ComputePipeline,
}

/// A far drop from every direction, for one model of light.
pub(crate) struct FarDrop {
    /// The map that was integrated.
    pub seen: Arc<EnvironmentMap>,
    pub appearance: Appearance,
    pub glints: Glints,
    /// Milliseconds that the tables took; none where they are empty.
    pub ms: Option<f64>,
}

impl Appearance {
    /// Level of the finest picture, 16 texels an edge.
    pub const FINEST: u32 = 4;

    /// Makes an empty table.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room for it; [`crate::Error::Vulkan`] if the driver
    /// refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        light: &Light,
    ) -> Result<Self> {
        let bytes = 4 * u64::from(DIRECTIONS * PICTURES);
        let usage =
            vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER;
        let table = Buffer::new(device, "appearance", bytes, usage, Memory::Device)?;
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let bindings = Bindings::of(
            device,
            "appearance",
            &[
                (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
                (slot::ENVIRONMENT_MAP, map),
                (slot::PICTURES, Resource::Buffer(&table)),
            ],
        )?;
        // One index: see the head of this file.
        let constants = light_constants(&Light { indices: [light.indices[1]; 3], ..*light });
        let pipeline =
            ComputePipeline::new(device, shaders::APPEARANCE_COMP, &bindings, 0, &constants)?;
        Ok(Self { table, bindings, pipeline })
    }

    /// Computes the whole table, and waits for it; of `constants` it reads those of the environment.
    ///
    /// # Errors
    /// Those of [`Commands::once`].
    pub fn fill(&self, device: &Arc<Device>, frame: &FrameBuffer, constants: &Frame) -> Result<()> {
        device.count(|made| &mut made.tables);
        Commands::once(device, "appearance", |commands| {
            frame.record(device, commands, constants);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::Uniform]);
            self.record(commands);
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ShaderRead]);
        })
    }

    /// Records the whole table, from constants that [`Appearance::fill`] has left.
    pub fn record(&self, commands: Recorder<'_>) {
        let groups = [DIRECTIONS.div_ceil(group::APPEARANCE_COMP[0]), 1, 1];
        self.pipeline.dispatch(commands, &self.bindings, 0, &[], groups);
    }
}
