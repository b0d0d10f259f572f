//! From radiance to display: the global photographic operator of Reinhard et al. 2002, with the
//! log-average luminance reduced on the GPU (`glsl/log_luminance.comp`, `tone_map.{vert,frag}`).
//!
//! L̄ = exp(Σ log(δ + L) / N); the paper's sum outside of the exponential is a misprint. δ is stated
//! relative to the scene: a fraction of the environment's mean luminance, so that a picture does not
//! change with the unit of its radiance.
//!
//! The sum runs in three steps without shared memory or barriers: 16,384 strided sums, 128 sums of
//! those, and the rest in the vertex shader of the full-screen triangle. On CPU drivers a
//! tree reduction with barriers takes five to eighty times as long; on GPUs the strides coalesce.

use std::sync::Arc;

use ash::vk;

use super::frame::FrameBuffer;
use super::{attachment, rendering};
use crate::Result;
use crate::gpu::{
    Alpha, Binding, Bindings, Buffer, ComputePipeline, Device, GraphicsPipeline, GraphicsState,
    Image, Memory, Resource, Sampler, Samples, Use, memory_barrier, shaders,
};
use crate::model::Operator;

/// δ of the log average over the environment's mean luminance.
pub const DELTA: f64 = 1e-4;

/// Format of the display image: the attachment encodes sRGB.
pub const DISPLAY: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Sums of the first and of the second step.
const SUMS: u32 = 16_384;
const FINAL_SUMS: u32 = 128;
const GROUP: u32 = 64;

/// Where the radiance is.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// In an image, read as a texture.
    Image(&'a Image),
    /// In a buffer, four halves a pixel.
    Buffer(&'a Buffer),
}

/// The pass.
pub struct ToneMap {
    bindings: Bindings,
    reduce: ComputePipeline,
    apply: GraphicsPipeline,
    operator: Operator,
    _sums: Buffer,
    _sampler: Sampler,
}

impl ToneMap {
    /// Pipelines that read the radiance of `source`.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        source: Source<'_>,
        operator: Operator,
    ) -> Result<Self> {
        let bytes = 4 * u64::from(SUMS + FINAL_SUMS);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let sums = Buffer::new(device, "luminance sums", bytes, usage, Memory::Device)?;
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler = Sampler::linear(device, "radiance", clamp, clamp)?;
        let (radiance, reduce_shader, apply_shader) = match source {
            Source::Image(image) => (
                (Binding::COMBINED_IMAGE_SAMPLER, Resource::Sampled(image, &sampler)),
                shaders::LOG_LUMINANCE_COMP,
                shaders::TONE_MAP_FRAG,
            ),
            Source::Buffer(buffer) => (
                (Binding::STORAGE_BUFFER, Resource::Buffer(buffer)),
                shaders::LOG_LUMINANCE_COMP_BUFFER,
                shaders::TONE_MAP_FRAG_BUFFER,
            ),
        };
        let bindings = Bindings::of(
            device,
            "tone map",
            &[
                (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer)),
                radiance,
                (Binding::STORAGE_BUFFER, Resource::Buffer(&sums)),
            ],
        )?;
        let reduce = ComputePipeline::new(device, reduce_shader, &bindings, 4, &[SUMS])?;
        let apply = GraphicsPipeline::new(
            device,
            [shaders::TONE_MAP_VERT, apply_shader],
            &bindings,
            0,
            &[SUMS, FINAL_SUMS, u32::from(operator == Operator::Photographic)],
            &GraphicsState {
                topology: vk::PrimitiveTopology::TRIANGLE_LIST,
                attribute: None,
                color: DISPLAY,
                alpha: Alpha::Ignored,
                samples: Samples::One,
                depth: false,
            },
        )?;
        Ok(Self { bindings, reduce, apply, operator, _sums: sums, _sampler: sampler })
    }

    /// Whether the operator needs the log average.
    pub fn needs_log_average(&self) -> bool {
        self.operator == Operator::Photographic
    }

    /// Records the reduction; the radiance must be ready to be read by compute.
    pub fn record_log_luminance(&self, device: &Device, commands: vk::CommandBuffer) {
        let stage = |number: u32, sums: u32| {
            let push = number.to_ne_bytes();
            self.reduce.dispatch(commands, &self.bindings, 0, &push, [sums / GROUP, 1, 1]);
        };
        stage(0, SUMS);
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        stage(1, FINAL_SUMS);
    }

    /// Records the operator; `display` is a colour attachment whose content is overwritten.
    pub fn record(&self, device: &Device, commands: vk::CommandBuffer, display: &Image) {
        let color = attachment(display, vk::AttachmentLoadOp::DONT_CARE);
        let size = (display.width, display.height);
        rendering(device, commands, color, None, size, 0.0, || {
            self.apply.bind(commands, &self.bindings, 0, &[]);
            // SAFETY: within a rendering, with everything bound.
            unsafe { device.raw().cmd_draw(commands, 3, 1, 0, 0) };
        });
    }
}
