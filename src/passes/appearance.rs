//! The prefiltered picture of a far drop, from every direction: the paper's hierarchical map carried
//! from directions to appearance (`glsl/appearance.comp`).
//!
//! A far drop's picture depends on the view direction and the place on its disc alone. For each of
//! 64 x 64 directions of an octahedral map it is integrated once, when a frame first looks there: a pyramid of pictures of 16 x 16 down
//! to 1 texel, reflection and all internal orders with their exact Fresnel weights, some 500 samples in all, each with its footprint
//! in the environment: one a texel, towards the rim up to eight. (With two by two a footprint there was up to 14° wide, and a
//! window 70° aside was a third too bright in a far drop.) Where a scene shows larger drops by pictures, there are 32 x 32 as well,
//! for twice as many samples and 17 MB. In a drop of up to some 12 pixels a pixel then reads four words.
//!
//! Eight orders are followed, unless a scene asks for fewer; what those beyond carry goes where the last goes, so that a white furnace
//! stays white. (With two, windows 120° to 130° aside were a third to a half too bright, and fog from above half a percent; a whole
//! view of 1024 x 1024 took 15 ms less, once.) Memory: 5.6 MB, a word a texel (9 bits a colour, a common exponent). Error: the nearest
//! direction is up to 3.8° off (texels are 1.8° to 7.6° across), and near drops look different from far ones (rays towards the rim are off
//! by 1.8° at 32 radii). For the light that a drop refracts, nearly all, a pixel mends both by where it reads
//! (`glsl/include/picture_turn.glsl`). Light that is reflected outside is not mended: it is off by what the place of reading moves.
//!
//! All colours are refracted by the index of green: by another one a direction differs by less than a sample's
//! footprint, and where that shows, in images of small bright sources and so in rainbows, the sources are not in the
//! map that is integrated (`glsl/far_glints.comp` has each colour by its own index). With three indices the table took
//! 2.5 times as long, and changed `fast` by a relMSE of 1e-5 at most under a hazy sun 5° across, where its error is
//! 4e-4 to 3e-3.

use std::sync::Arc;

use ash::vk;
use glam::Vec4;

use super::environment::EnvironmentMap;
use super::flat_light::FlatLight;
use super::frame::{Frame, FrameBuffer};
use super::glints::Glints;
use super::light_constants;
use crate::Result;
use crate::abi::NO_PICTURE;
use crate::gpu::sets::{appearance as slot, group};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, fill_buffer,
    memory_barrier, shaders,
};
use crate::plan::Light;

/// All directions of the octahedral map, which has `abi::DIRECTIONS` along an edge.
pub(super) const ALL_DIRECTIONS: u32 = crate::abi::DIRECTIONS * crate::abi::DIRECTIONS;
/// Words of all pictures of a direction up to 16 texels an edge.
const PICTURES: u32 = 1 + crate::abi::PYRAMID;
/// Words of a direction's picture of 32 texels an edge.
const LARGEST: u32 = crate::abi::LARGEST_EDGE * crate::abi::LARGEST_EDGE;

/// The directions between four planes, and some beyond, by the planes' normals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Directions(pub [Vec4; 4]);

impl Directions {
    /// All of them.
    pub const ALL: Self = Self([Vec4::ZERO; 4]);

    /// The directions in which a frame shows far drops that stand still and are sharp.
    pub fn of(frame: &Frame) -> Self {
        Self::between(frame, frame.frustum_x, frame.frustum_y)
    }

    /// The directions in which a frame shows any far drops: those of the whole picture, whatever part of it is drawn, for a drop
    /// that moves or is out of focus has its place in parts that do not show it (`glsl/include/shown_from.glsl`).
    pub fn of_whole(frame: &Frame) -> Self {
        let ([width, height, focal, _], [x, y, ..]) = (frame.image, frame.principal);
        let edges = |before: f32, after: f32| {
            let [(a, b), (c, d)] = [before, after].map(|across| across.atan2(focal).sin_cos());
            [b, a, d, c]
        };
        Self::between(frame, edges(x, width - x), edges(y, height - y))
    }

    /// By cosine and sine of the angles from the view axis to the left edge and the right one, and to the upper and the lower one.
    fn between(frame: &Frame, x: [f32; 4], y: [f32; 4]) -> Self {
        let [right, up, back] = [frame.right, frame.up, frame.back].map(Vec4::from_array);
        Self([
            x[1] * back - x[0] * right,
            x[3] * back + x[2] * right,
            y[1] * back + y[0] * up,
            y[3] * back - y[2] * up,
        ])
    }
}

/// What pictures show of a model of light: colours by the index of green (see the head of this file), and orders of their own.
pub(super) fn light_of_pictures(light: &Light) -> Light {
    Light {
        indices: [light.indices[1]; 3],
        internal_reflections: light.picture_reflections,
        ..*light
    }
}

/// The table and the pass that makes it.
pub struct Appearance {
    /// One word a texel, as `glsl/include/appearance.glsl` places them.
    pub table: Buffer,
    bindings: Bindings,
    pipeline: ComputePipeline,
}

/// What far drops show, for one model of light.
pub(crate) struct FarDrop {
    /// The map that was integrated.
    pub seen: Arc<EnvironmentMap>,
    pub appearance: Appearance,
    pub glints: Glints,
    /// Where drops may be flattened.
    pub flat: Option<FlatLight>,
}

impl FarDrop {
    /// Records that what is seen is new: there are no pictures of it yet, and other images of bright sources.
    pub fn record_renewed(&self, device: &Device, commands: Recorder<'_>) {
        self.appearance.record_none(device, commands);
        if let Some(flat) = &self.flat {
            flat.record_none(device, commands);
        }
        self.glints.record(commands);
        let written = [Use::TransferWrite, Use::ComputeWrite];
        let after = [Use::Uniform, Use::ComputeWrite, Use::ComputeRead, Use::ShaderRead];
        memory_barrier(device, commands, &written, &after);
    }
}

impl Appearance {
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
        // Level 5 has 32 texels an edge, and lies after all others.
        let largest = if light.picture_level == 5 { LARGEST } else { 0 };
        let bytes = 4 * u64::from(ALL_DIRECTIONS * (PICTURES + largest));
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER | Usage::TRANSFER_DST;
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
        let constants = light_constants(&light_of_pictures(light));
        let push = size_of::<Directions>() as u32;
        let pipeline =
            ComputePipeline::new(device, shaders::APPEARANCE_COMP, &bindings, push, &constants)?;
        Ok(Self { table, bindings, pipeline })
    }

    /// Records that no direction has pictures. What follows must wait for it.
    fn record_none(&self, device: &Device, commands: Recorder<'_>) {
        fill_buffer(device, commands, &self.table, 0..4 * u64::from(ALL_DIRECTIONS), NO_PICTURE);
    }

    /// Records the pictures of those of some directions that have none. What reads them must wait for it.
    pub(crate) fn record(&self, commands: Recorder<'_>, Directions(planes): Directions) {
        let push = bytemuck::cast_slice(&planes);
        let groups = [ALL_DIRECTIONS.div_ceil(group::APPEARANCE_COMP[0]), 1, 1];
        self.pipeline.dispatch(commands, &self.bindings, 0, push, groups);
    }
}
