//! The environment behind the drops: one triangle over the image (`glsl/sky.frag`).

use std::sync::Arc;

use ash::vk;

use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::{attachment, rendering};
use crate::Result;
use crate::gpu::sets::sky as slot;
use crate::gpu::{
    Bindings, Device, GraphicsPipeline, GraphicsState, Image, Recorder, Resource, Samples, shaders,
};

/// The pass.
pub struct Sky {
    bindings: Bindings,
    pipeline: GraphicsPipeline,
}

impl Sky {
    /// Pipeline for a colour target of `format` with so many samples a pixel.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        format: vk::Format,
        samples: Samples,
    ) -> Result<Self> {
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let constants = (slot::CONSTANTS, Resource::Buffer(&frame.buffer));
        let bindings = Bindings::of(device, "sky", &[constants, (slot::ENVIRONMENT_MAP, map)])?;
        let stages = [shaders::FULLSCREEN_VERT, shaders::SKY_FRAG];
        let state = GraphicsState { samples, ..GraphicsState::triangles(format) };
        let pipeline = GraphicsPipeline::new(device, stages, &bindings, 0, &[], &state)?;
        Ok(Self { bindings, pipeline })
    }

    /// Records the pass; `target` is a colour attachment whose content is overwritten.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, target: &Image) {
        let color = attachment(target, vk::AttachmentLoadOp::DONT_CARE);
        let size = (target.width, target.height);
        rendering(device, commands, color, None, size, 0.0, || {
            self.pipeline.draw_triangle(commands, &self.bindings, &[])
        });
    }
}
