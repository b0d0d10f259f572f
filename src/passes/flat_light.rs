//! The mean light of far drops that are flattened, by direction (`glsl/flat_light.comp`).
//!
//! A flattened drop shows other parts of the environment than a sphere: seen from above or below it also reflects totally, and
//! seen level its flat base shows more of the sky. Its mean light differs by up to a quarter before a landscape. A far drop
//! shows no more than that light, so a table by direction holds all of it: for each direction of the octahedral map of
//! `appearance.rs`, and for [`FLAT_DIAMETERS`] diameters, the mean over the outline of rays that are traced through two half
//! spheroids, each with its footprint in the environment. Rain is a mixture of these drops and of spheres
//! (`src/rain/flat_sizes.rs`), which `glsl/splat_table.comp` makes of it for each view: of the medium, of drops shown one by
//! one, and of a splat by its size. Drops of a few pixels show a sphere's picture with that light in each half
//! of their outline (`glsl/include/flattened.glsl`). Drops placed by hand show what rain of their flatness does.
//!
//! Cost: 96 rays a diameter and direction, once an environment, for the directions in view; a frame reads as many words as
//! without it. Scenes of spheres have no table. Error before a landscape of
//! high contrast: up to 2.6 % of a third of the picture, where spheres are off by 5 to 45 % (`tests/drawn/fog.rs`).

use std::sync::Arc;

use ash::vk;

use super::appearance::{ALL_DIRECTIONS, Directions, light_of_pictures};
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::light_constants;
use crate::Result;
use crate::abi::{FLAT_DIAMETERS, FlatLightPush, NO_PICTURE};
use crate::gpu::sets::{flat_light as slot, group};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, fill_buffer, shaders,
};
use crate::plan::Light;
use crate::rain::flat_sizes::DIAMETERS;
use crate::rain::shape::Halves;

// The first is a sphere.
const _: () = assert!(DIAMETERS.len() == 1 + FLAT_DIAMETERS as usize);

/// The table and the pass that makes it.
pub struct FlatLight {
    /// For each direction a word a diameter, and as many for the lower half.
    pub(super) table: Buffer,
    bindings: Bindings,
    pipeline: ComputePipeline,
}

impl FlatLight {
    /// Makes an empty table.
    ///
    /// # Errors
    /// See [`super::appearance::Appearance::new`].
    pub(crate) fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        light: &Light,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let bytes = 2 * 4 * u64::from(ALL_DIRECTIONS * FLAT_DIAMETERS);
        let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_DST;
        let table = Buffer::new(device, "flat light", bytes, usage, Memory::Device)?;
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let slots = [
            (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
            (slot::ENVIRONMENT_MAP, map),
            (slot::FLAT_LIGHT, Resource::Buffer(&table)),
        ];
        let bindings = Bindings::of(device, "flat light", &slots)?;
        let constants = light_constants(&light_of_pictures(light));
        let push = size_of::<FlatLightPush>() as u32;
        let pipeline =
            ComputePipeline::new(device, shaders::FLAT_LIGHT_COMP, &bindings, push, &constants)?;
        Ok(Self { table, bindings, pipeline })
    }

    /// Records that no direction is known. What follows must wait for it.
    pub(super) fn record_none(&self, device: &Device, commands: Recorder<'_>) {
        fill_buffer(device, commands, &self.table, 0..self.table.size, NO_PICTURE);
    }

    /// Records those of some directions that are not known. What reads them must wait for it.
    pub(crate) fn record(&self, commands: Recorder<'_>, Directions(planes): Directions) {
        let shapes = std::array::from_fn(|number| {
            let Halves { joint, equatorial, top, bottom } =
                Halves::of_diameter(DIAMETERS[1 + number]);
            [equatorial, top, bottom, joint].map(|length| length as f32)
        });
        let push = FlatLightPush { planes: planes.map(|plane| plane.to_array()), shapes };
        let groups = [ALL_DIRECTIONS.div_ceil(group::FLAT_LIGHT_COMP[0]), 1, 1];
        self.pipeline.dispatch(commands, &self.bindings, 0, bytemuck::bytes_of(&push), groups);
    }
}
