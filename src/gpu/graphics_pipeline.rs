//! Graphics pipelines.

use std::sync::Arc;

use ash::vk;

use super::pipeline::{Code, Made, PipelineOf, Shader, Specialization};
use super::{Bindings, Device, Recorder, Samples};
use crate::Result;

/// What a fragment's alpha does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Alpha {
    /// Nothing: the fragment overwrites.
    Ignored,
    /// "Over" blending.
    Blended,
    /// "Over" blending; the colour already holds its alpha.
    Premultiplied,
    /// The share of the pixel's samples that it overwrites.
    ToCoverage,
}

/// The fixed-function state of a graphics pipeline; all else has one value throughout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GraphicsState {
    /// Points, strips, …
    pub topology: vk::PrimitiveTopology,
    /// Advances per vertex or per instance: one `vec4` attribute at location 0; `None` without.
    pub attribute: Option<vk::VertexInputRate>,
    /// Format of the colour attachment.
    pub color: vk::Format,
    /// What becomes of the fragment's alpha.
    pub alpha: Alpha,
    /// Samples a pixel of the attachments.
    pub samples: Samples,
    /// Depth attachment of D32, tested with "greater" (reversed depth) and written.
    pub depth: bool,
}

impl GraphicsState {
    /// Triangles that overwrite an image of one sample a pixel, with neither attributes nor depth.
    pub fn triangles(color: vk::Format) -> Self {
        Self {
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            attribute: None,
            color,
            alpha: Alpha::Ignored,
            samples: Samples::One,
            depth: false,
        }
    }
}

/// A graphics pipeline with dynamic viewport and scissor; it lives as long as its device.
pub struct GraphicsPipeline {
    made: Made,
    device: Arc<Device>,
}

impl GraphicsPipeline {
    /// Makes the pipeline of a vertex and a fragment shader with the sets of `bindings`. Both get the
    /// same specialization constants.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        [vertex, fragment]: [&Shader; 2],
        bindings: &Bindings,
        push_bytes: u32,
        specialization: Specialization<'_>,
        state: &GraphicsState,
    ) -> Result<Self> {
        let of = PipelineOf {
            shaders: [vertex, fragment].map(|shader| Code::of(device, shader)).into(),
            slots: bindings.slots(),
            push_bytes,
            constants: specialization.to_vec(),
            state: Some(*state),
        };
        Ok(Self { made: device.pipeline(bindings, of)?, device: device.clone() })
    }

    /// Binds the pipeline with the first set of `bindings` and its push constants.
    pub fn bind(&self, commands: Recorder<'_>, bindings: &Bindings, push: &[u8]) {
        let kind = vk::PipelineBindPoint::GRAPHICS;
        self.made.bind(&self.device, commands, kind, (bindings, 0), push);
    }

    /// Draws one triangle within a rendering, with the first set of `bindings`: that of a vertex shader which covers all pixels.
    pub fn draw_triangle(&self, commands: Recorder<'_>, bindings: &Bindings, push: &[u8]) {
        self.bind(commands, bindings, push);
        // SAFETY: everything is bound, and by contract within a rendering.
        unsafe { self.device.raw.cmd_draw(commands.raw(), 3, 1, 0, 0) };
    }
}
