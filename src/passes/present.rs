//! A finished picture into a window, or two beside each other with their difference
//! (`glsl/present.frag`). A picture of another size is scaled to the nearest pixel: while a window is
//! being resized, the last picture has to do.

use std::sync::Arc;

use ash::vk;

use super::{attachment, rendering};
use crate::Result;
use crate::gpu::sets::{constant, present as slot};
use crate::gpu::{
    Bindings, Device, GraphicsPipeline, GraphicsState, Image, Recorder, Resource, Sampler, shaders,
};

/// Panes of the split view: the first model, the second, their difference.
pub const SPLIT_PANES: u32 = 3;

/// What the difference of display values is multiplied by, so that 1/255 can be seen.
pub const DIFFERENCE_GAIN: u32 = 8;

/// The pass.
pub struct Present {
    one: GraphicsPipeline,
    split: GraphicsPipeline,
    bindings: Bindings,
    sampler: Sampler,
    /// How many pictures are shown.
    shown: usize,
    device: Arc<Device>,
}

impl Present {
    /// A pipeline into attachments of `format`, showing `pictures`; see [`Present::show`].
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, format: vk::Format, pictures: &[&Image]) -> Result<Self> {
        let slots = [slot::FIRST, slot::SECOND];
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler = Sampler::linear(device, "pictures", clamp, clamp)?;
        // Black, as long as nothing is to be shown.
        let bindings = Bindings::new(device, "present", &slots, 1)?;
        let state = GraphicsState::triangles(format);
        let stages = [shaders::FULLSCREEN_VERT, shaders::PRESENT_FRAG];
        let push_bytes = size_of::<[f32; 2]>() as u32;
        let pipeline = |panes: u32| {
            let constants = [[constant::PANES, panes], [constant::GAIN, DIFFERENCE_GAIN]];
            GraphicsPipeline::new(device, stages, &bindings, push_bytes, &constants, &state)
        };
        let (one, split) = (pipeline(1)?, pipeline(SPLIT_PANES)?);
        let (shown, device) = (0, device.clone());
        let mut present = Self { one, split, bindings, sampler, shown, device };
        present.show(pictures)?;
        Ok(present)
    }

    /// Shows other pictures from now on: none (black), one, or two to compare.
    /// Frames under way go on with the ones before.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn show(&mut self, pictures: &[&Image]) -> Result<()> {
        self.shown = pictures.len();
        let [first, ..] = *pictures else { return Ok(()) };
        let second = pictures.get(1).copied().unwrap_or(first);
        let slots = [(slot::FIRST, first), (slot::SECOND, second)]
            .map(|(slot, picture)| (slot, Resource::Sampled(picture, &self.sampler)));
        self.bindings = Bindings::of(&self.device, "present", &slots)?;
        Ok(())
    }

    /// Records the pass; `target` is a colour attachment whose content is overwritten.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, target: &Image) {
        let load = match self.shown {
            0 => vk::AttachmentLoadOp::CLEAR,
            _ => vk::AttachmentLoadOp::DONT_CARE,
        };
        let color = attachment(target, load);
        let size = (target.width, target.height);
        let push = [size.0 as f32, size.1 as f32];
        let pipeline = if self.shown > 1 { &self.split } else { &self.one };
        rendering(device, commands, color, None, size, 0.0, || {
            if self.shown > 0 {
                pipeline.draw_triangle(commands, &self.bindings, bytemuck::cast_slice(&push));
            }
        });
    }
}
