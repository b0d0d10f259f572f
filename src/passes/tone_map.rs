//! From radiance to display: the global photographic operator of Reinhard et al. 2002, with the
//! log-average luminance reduced on the GPU (`glsl/{log_luminance,sum_logs}.comp`,
//! `tone_map.{vert,frag}`).
//!
//! With a fixed exposure nothing is summed. Else
//! L̄ = exp(Σ log(δ + L) / N); the paper's sum outside of the exponential is a misprint. δ is stated
//! relative to the scene: a fraction of the environment's mean luminance, so that a picture does not
//! change with the unit of its radiance.
//!
//! The sum runs in steps without shared memory or barriers: 16,384 strided sums (or those of the tiles, which
//! `composite.rs` leaves), on a GPU 4,096 sums of those, 128 sums, and the rest in the vertex shader of the full-screen
//! triangle. On CPU drivers a tree reduction with barriers takes five to eighty times as long; on GPUs the strides
//! coalesce, but 128 invocations alone waited for a thousand loads each, longer than all else took.

use std::sync::Arc;

use ash::vk;

use super::frame::FrameBuffer;
use super::{attachment, rendering};
use crate::Result;
use crate::abi::LogSumsPush;
use crate::gpu::sets::{constant, group, tone_map as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, GraphicsPipeline, GraphicsState, Image, Machine,
    Memory, Recorder, Resource, Sampler, Shader, Slot, Texel, Texels, Use, memory_barrier, shaders,
    update_buffer,
};
use crate::scene::model::Operator;

/// Format of the display image: the attachment encodes sRGB.
pub const DISPLAY: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Sums of the first step over an image.
const SUMS: u32 = 16_384;
/// The last sums before that of the vertex shader.
const FINAL_SUMS: u32 = 128;

/// Them, of one picture.
pub type FinalSums = [f32; FINAL_SUMS as usize];

/// How many sums follow those of the first step in their buffer: the final ones, and those between.
pub fn further_sums(machine: Machine) -> u32 {
    FINAL_SUMS + machine.log_sums_between().unwrap_or(0)
}

/// What `glsl/sum_logs.comp` leaves of the sums of the first step, to the bit: of a picture that was drawn in parts.
pub fn final_sums(sums: &[f32], machine: Machine) -> FinalSums {
    let between = machine.log_sums_between().map(|count| strided(sums, count as usize));
    let sums = between.as_deref().unwrap_or(sums);
    let found = strided(sums, FINAL_SUMS as usize);
    std::array::from_fn(|at| found[at])
}

/// So many sums, each of a stride of values.
fn strided(values: &[f32], count: usize) -> Vec<f32> {
    let of = |first| values.iter().skip(first).step_by(count).fold(0.0, |sum, log| sum + log);
    (0..count).map(of).collect()
}

/// Where the radiance is.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// In an image, read as a texture.
    Image(&'a Image),
    /// In a buffer, four halves a pixel; read a texel at a time where the device takes texel buffers so large.
    Tiles {
        /// Row by row.
        radiance: &'a Buffer,
        /// A sum of log(delta + luminance) for each tile, then room for [`further_sums`].
        log_sums: &'a Buffer,
        /// Number of tiles.
        count: u32,
    },
}

/// How shaders read the radiance of a source.
pub(super) enum Radiance<'a> {
    Image(&'a Image, Sampler),
    Texels(Texels),
    Buffer(&'a Buffer),
}

impl<'a> Source<'a> {
    /// The kind of reading that suits the device best.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub(super) fn radiance(self, device: &Arc<Device>) -> Result<Radiance<'a>> {
        Ok(match self {
            Source::Image(image) => {
                let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
                Radiance::Image(image, Sampler::linear(device, "radiance", clamp, clamp)?)
            }
            Source::Tiles { radiance, .. } if Texels::fit(device, radiance, Texel::FourHalves) => {
                let name = "texels of radiance";
                Radiance::Texels(Texels::new(device, name, radiance, Texel::FourHalves)?)
            }
            Source::Tiles { radiance, .. } => Radiance::Buffer(radiance),
        })
    }
}

impl Radiance<'_> {
    /// What is bound, and which of three slots and shaders it is for: of an image, of texels, of a buffer.
    pub fn choose(
        &self,
        [image, texels, buffer]: [(Slot, &'static Shader); 3],
    ) -> ((Slot, Resource<'_>), &'static Shader) {
        let ((slot, shader), resource) = match self {
            Self::Image(of, sampler) => (image, Resource::Sampled(of, sampler)),
            Self::Texels(of) => (texels, Resource::Texels(of)),
            Self::Buffer(of) => (buffer, Resource::Buffer(of)),
        };
        ((slot, resource), shader)
    }
}

/// The pass.
pub struct ToneMap {
    bindings: Bindings,
    /// The first step; none where it is done before.
    reduce: Option<ComputePipeline>,
    sum_up: ComputePipeline,
    apply: GraphicsPipeline,
    /// Number of sums of the first step.
    pub count: u32,
    /// The sums of the first step, then those of the second, where the source has none.
    own_sums: Option<Buffer>,
}

impl ToneMap {
    /// Pipelines that read the radiance of `source`.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if a buffer of `source` does not fit in one binding;
    /// [`crate::Error::Memory`] if the device has no room for the sums; [`crate::Error::Vulkan`] if the
    /// driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        source: Source<'_>,
        operator: Operator,
    ) -> Result<Self> {
        let own_sums = match source {
            Source::Image(_) => {
                let bytes = 4 * u64::from(SUMS + further_sums(device.report.machine));
                let usage = vk::BufferUsageFlags::STORAGE_BUFFER
                    | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
                    | vk::BufferUsageFlags::TRANSFER_SRC
                    | vk::BufferUsageFlags::TRANSFER_DST;
                Some(Buffer::new(device, "luminance sums", bytes, usage, Memory::Device)?)
            }
            Source::Tiles { .. } => None,
        };
        let (sums, count) = match source {
            Source::Image(_) => (own_sums.as_ref(), SUMS),
            Source::Tiles { log_sums, count, .. } => (Some(log_sums), count),
        };
        let radiance = source.radiance(device)?;
        let (radiance, apply_shader) = radiance.choose([
            (slot::RADIANCE_IMAGE, shaders::TONE_MAP_FRAG),
            (slot::RADIANCE_TEXELS, shaders::TONE_MAP_FRAG_TEXELS),
            (slot::RADIANCE, shaders::TONE_MAP_FRAG_BUFFER),
        ]);
        let uniform = (slot::CONSTANTS, Resource::Buffer(&frame.buffer));
        let words = sums
            .map(|sums| Texels::new(device, "words of luminance sums", sums, Texel::Word))
            .transpose()?;
        let by_texels = words.as_ref().is_some_and(|words| words.is_whole);
        let sums = sums.map(|sums| (slot::SUMS, Resource::Buffer(sums)));
        let words = words.as_ref().map(|words| (slot::SUM_WORDS, Resource::Texels(words)));
        let slots: Vec<_> = [uniform, radiance].into_iter().chain(sums).chain(words).collect();
        let bindings = Bindings::of(device, "tone map", &slots)?;
        let read = [[constant::BY_TEXELS, by_texels.into()]];
        let compute = |shader, bytes| ComputePipeline::new(device, shader, &bindings, bytes, &read);
        let reduces = own_sums.is_some();
        let reduce = reduces.then(|| compute(shaders::LOG_LUMINANCE_COMP, 0)).transpose()?;
        let sum_up = compute(shaders::SUM_LOGS_COMP, size_of::<LogSumsPush>() as u32)?;
        let stages = [shaders::TONE_MAP_VERT, apply_shader];
        let constants = [
            [constant::FINAL_SUMS, FINAL_SUMS],
            [constant::PHOTOGRAPHIC, (operator == Operator::Photographic).into()],
        ];
        let state = GraphicsState::triangles(DISPLAY);
        let apply = GraphicsPipeline::new(device, stages, &bindings, 0, &constants, &state)?;
        Ok(Self { bindings, reduce, sum_up, apply, count, own_sums })
    }

    /// Records the reduction; the radiance, or the tiles' sums, must be ready to be read by compute.
    pub fn record_log_luminance(&self, device: &Device, commands: Recorder<'_>) {
        let after = [Use::ComputeWrite, Use::ComputeRead];
        if let Some(reduce) = &self.reduce {
            let groups = [SUMS / group::LOG_LUMINANCE_COMP[0], 1, 1];
            reduce.dispatch(commands, &self.bindings, 0, &[], groups);
            memory_barrier(device, commands, &[Use::ComputeWrite], &after);
        }
        let sum_up = |[first, count, to, sums]: [u32; 4]| {
            let push = LogSumsPush { first, count, to };
            let groups = [sums / group::SUM_LOGS_COMP[0], 1, 1];
            self.sum_up.dispatch(commands, &self.bindings, 0, bytemuck::bytes_of(&push), groups);
        };
        match device.report.machine.log_sums_between() {
            None => sum_up([0, self.count, self.count, FINAL_SUMS]),
            Some(between) => {
                let at = self.count + FINAL_SUMS;
                sum_up([0, self.count, at, between]);
                memory_barrier(device, commands, &[Use::ComputeWrite], &after);
                sum_up([at, between, self.count, FINAL_SUMS]);
            }
        }
    }

    /// Records the sums of another picture in place of those of `source`, which the pass was made for: those of the
    /// whole, where this is a part of it.
    pub fn record_sums(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        source: Source<'_>,
        sums: &FinalSums,
    ) {
        let buffer = match source {
            Source::Image(_) => self.own_sums.as_ref(),
            Source::Tiles { log_sums, .. } => Some(log_sums),
        };
        if let Some(buffer) = buffer {
            let offset = 4 * u64::from(self.count);
            update_buffer(device, commands, buffer, offset, bytemuck::bytes_of(sums));
        }
    }

    /// Sums of the first step over an image; none where the tiles' are.
    pub fn own_sums(&self) -> Option<&Buffer> {
        self.own_sums.as_ref()
    }

    /// Records the operator; `display` is a colour attachment whose content is overwritten.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, display: &Image) {
        let color = attachment(display, vk::AttachmentLoadOp::DONT_CARE);
        let size = (display.width, display.height);
        rendering(device, commands, color, None, size, 0.0, || {
            self.apply.draw_triangle(commands, &self.bindings, &[])
        });
    }
}
