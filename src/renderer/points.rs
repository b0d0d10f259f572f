//! The paper's frame: every drop a point, over the sky, in an image.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::gpu::{
    Device, Image, ImageInfo, Timestamps, Use, image_barrier, image_discard, memory_barrier,
};
use crate::passes::drops::{Drops, guard_band};
use crate::passes::environment::EnvironmentMap;
use crate::passes::frame::FrameBuffer;
use crate::passes::mask::Mask;
use crate::passes::simulate::Simulate;
use crate::passes::sky::Sky;
use crate::plan::FramePlan;
use crate::scene::Scene;

/// Format of the radiance image. Colour is blended in it; the alpha of a drop that is smaller than a
/// pixel is its area, well over float16's resolution in every scene with less than 10⁴ drops behind
/// one pixel.
const RADIANCE: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// The passes that show drops; none in a scene without.
struct Rain {
    simulate: Simulate,
    drops: Drops,
    depth: Image,
    // Sampled by the drops.
    _mask: Mask,
}

/// The passes of the frame, up to its radiance.
pub(super) struct Points {
    pub radiance: Image,
    sky: Sky,
    rain: Option<Rain>,
}

impl Points {
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        plan: &FramePlan,
    ) -> Result<Self> {
        use vk::ImageUsageFlags as Usage;
        let (width, height) = (scene.image.width, scene.image.height);
        let target = |name, format, usage| {
            let info = ImageInfo { name, width, height, levels: 1, layers: 1, format, usage };
            Image::new(device, &info)
        };
        let usage = Usage::COLOR_ATTACHMENT | Usage::SAMPLED | Usage::TRANSFER_SRC;
        let radiance = target("radiance", RADIANCE, usage)?;
        let count = scene.drop_count();
        let rain = if count > 0 {
            let (guard_px, _) = guard_band(device, width, height);
            let mask = Mask::trace(device, plan.mask_size, plan.optics)?;
            Some(Rain {
                simulate: Simulate::new(device, frame, scene, plan.simulation)?,
                drops: Drops::new(device, frame, environment, &mask, RADIANCE, count, guard_px)?,
                depth: target("depth", vk::Format::D32_SFLOAT, Usage::DEPTH_STENCIL_ATTACHMENT)?,
                _mask: mask,
            })
        } else {
            None
        };
        Ok(Self { radiance, sky: Sky::new(device, frame, environment, RADIANCE)?, rain })
    }

    pub fn simulate(&self) -> Option<&Simulate> {
        self.rain.as_ref().map(|rain| &rain.simulate)
    }

    pub fn record_reset(&self, device: &Device, commands: vk::CommandBuffer) {
        if let Some(rain) = &self.rain {
            rain.simulate.record_reset(device, commands);
        }
    }

    /// From the frame's constants to the radiance image, left as a colour attachment. A pass's time
    /// includes the wait for its input: drivers that defer drawing do it there.
    pub fn record(&self, device: &Device, commands: vk::CommandBuffer, time: &mut Timestamps) {
        time.time(commands, "simulate", || {
            let written = [Use::Uniform, Use::ComputeWrite];
            memory_barrier(device, commands, &[Use::TransferWrite], &written);
            if let Some(rain) = &self.rain {
                rain.simulate.record(device, commands);
                let readers = [Use::VertexInput, Use::Indirect, Use::TransferRead];
                memory_barrier(device, commands, &[Use::ComputeWrite], &readers);
            }
        });

        let readers = [Use::ShaderRead, Use::TransferRead, Use::ColorAttachment];
        image_discard(device, commands, &self.radiance, &readers, Use::ColorAttachment);
        time.time(commands, "sky", || self.sky.record(device, commands, &self.radiance));

        if let Some(rain) = &self.rain {
            time.time(commands, "drops", || {
                let drawn = Use::ColorAttachment;
                image_barrier(device, commands, &self.radiance, drawn, drawn);
                let depth = Use::DepthAttachment;
                image_discard(device, commands, &rain.depth, &[depth], depth);
                rain.drops.record(device, commands, &rain.simulate, &self.radiance, &rain.depth);
            });
        }
    }

    /// Makes the radiance ready for the display pass.
    pub fn record_display(&self, device: &Device, commands: vk::CommandBuffer) {
        let (before, after) = (Use::ColorAttachment, Use::ShaderRead);
        image_barrier(device, commands, &self.radiance, before, after);
    }
}
