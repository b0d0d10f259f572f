//! The picture into an image of a host's (`glsl/output.frag`): radiance in the scene's unit, premultiplied, in the
//! format that the host has chosen. It reads each pixel once and writes it once.

use std::sync::Arc;

use ash::vk;

use super::frame::FrameBuffer;
use super::rendering;
use super::tone_map::Source;
use crate::gpu::sets::output as slot;
use crate::gpu::{
    Alpha, Bindings, Device, GraphicsPipeline, GraphicsState, HostImage, Recorder, Resource, Use,
    attachment_of, shaders,
};
use crate::{Error, Result};

/// What becomes of what an output image holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// It is overwritten: by the picture, or by premultiplied rain for a compositor where the plan is for layers.
    #[default]
    Replace,
    /// The rain is laid over it; the plan is for layers.
    Over,
}

/// Formats that a picture may be written in.
pub(crate) const FORMATS: [vk::Format; 10] = [
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
    vk::Format::B10G11R11_UFLOAT_PACK32,
    vk::Format::A2B10G10R10_UNORM_PACK32,
    vk::Format::A2R10G10B10_UNORM_PACK32,
    vk::Format::R16G16B16A16_UNORM,
    vk::Format::R8G8B8A8_UNORM,
    vk::Format::B8G8R8A8_UNORM,
    vk::Format::R8G8B8A8_SRGB,
    vk::Format::B8G8R8A8_SRGB,
];

/// The pass.
pub struct Output {
    format: vk::Format,
    blend: Blend,
    bindings: Bindings,
    pipeline: GraphicsPipeline,
}

impl Output {
    /// A pass that reads `source` and writes images of `format`.
    ///
    /// # Errors
    /// [`Error::Scene`] for a format that cannot hold the picture; [`Error::DeviceLacks`] if the device cannot draw into
    /// images of it; [`Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        source: Source<'_>,
        format: vk::Format,
        blend: Blend,
    ) -> Result<Self> {
        if !FORMATS.contains(&format) {
            let known = FORMATS.map(|format| format!("{format:?}"));
            let problem = format!("{format:?} is none of {}", known.join(", "));
            return Err(Error::scene("the output's format", problem));
        }
        let mut needs = vk::FormatFeatureFlags::COLOR_ATTACHMENT;
        if blend == Blend::Over {
            needs |= vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND;
        }
        if !device.format_features(format).contains(needs) {
            return Err(device.report.lacking(format!("drawing into {format:?} with {blend:?}")));
        }
        let radiance = source.radiance(device)?;
        let (radiance, shader) = radiance.choose([
            (slot::RADIANCE_IMAGE, shaders::OUTPUT_FRAG),
            (slot::RADIANCE_TEXELS, shaders::OUTPUT_FRAG_TEXELS),
            (slot::RADIANCE, shaders::OUTPUT_FRAG_BUFFER),
        ]);
        let uniform = (slot::CONSTANTS, Resource::Buffer(&frame.buffer));
        let bindings = Bindings::of(device, "output", &[uniform, radiance])?;
        let state = GraphicsState {
            alpha: match blend {
                Blend::Replace => Alpha::Ignored,
                Blend::Over => Alpha::Premultiplied,
            },
            ..GraphicsState::triangles(format)
        };
        let vertex = shaders::FULLSCREEN_VERT;
        let pipeline = GraphicsPipeline::new(device, [vertex, shader], &bindings, 0, &[], &state)?;
        Ok(Self { format, blend, bindings, pipeline })
    }

    /// Refuses an image that it cannot write.
    ///
    /// # Errors
    /// [`Error::Scene`] with what is wrong.
    pub fn check(&self, image: &HostImage, size: (u32, u32)) -> Result<()> {
        if image.format != self.format {
            let (is, wanted) = (image.format, self.format);
            let problem = format!("its format is {is:?}; the view was made for {wanted:?}");
            return Err(Error::scene("the output", problem));
        }
        image.check("the output", size, self.blend == Blend::Over)
    }

    /// Records the picture into an image that [`Output::check`] lets pass, when the radiance is ready to be read.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, image: &HostImage) {
        image.take(device, commands, Use::ColorAttachment);
        let load = match self.blend {
            Blend::Replace => vk::AttachmentLoadOp::DONT_CARE,
            Blend::Over => vk::AttachmentLoadOp::LOAD,
        };
        let color = attachment_of(image.view, load);
        rendering(device, commands, color, None, image.size, 0.0, || {
            self.pipeline.draw_triangle(commands, &self.bindings, &[])
        });
        image.give_back(device, commands, Use::ColorAttachment);
    }
}
