//! The paper's frame: every drop a billboard, over the sky, in an image.

use ash::vk;

use super::lighting::Lighting;
use crate::Result;
use crate::gpu::{
    Alpha, Device, Image, ImageInfo, Recorder, Samples, Timestamps, Use, image_barrier,
    image_discard, memory_barrier,
};
use crate::passes::appearance::Directions;
use crate::passes::attachment;
use crate::passes::compact::Compact;
use crate::passes::drops::{Drops, Table, Target, guard_band};
use crate::passes::frame::FrameBuffer;
use crate::passes::simulate::Simulate;
use crate::passes::sky::Sky;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::Order;

/// Format of the radiance image. Colour is blended in it; the alpha of a drop that is smaller than a
/// pixel is its area, well over float16's resolution in every scene with less than 10⁴ drops behind
/// one pixel.
const RADIANCE: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// The passes that show drops; none in a scene without.
struct Rain {
    simulate: Simulate,
    compact: Option<Compact>,
    drops: Drops,
    depth: Image,
}

/// The passes of the frame, up to its radiance.
pub(super) struct Points {
    pub radiance: Image,
    /// The image with several samples a pixel, where alpha goes to coverage: drawn into, resolved to `radiance`.
    samples: Option<Image>,
    sky: Sky,
    rain: Option<Rain>,
}

impl Points {
    pub fn new(
        lighting: &Lighting,
        frame: &FrameBuffer,
        scene: &Scene,
        plan: &FramePlan,
    ) -> Result<Self> {
        let (device, environment) = (lighting.device(), &lighting.environment);
        use vk::ImageUsageFlags as Usage;
        let (width, height) = scene.picture_size();
        let target = |name, format, usage, samples| {
            let flat = ImageInfo::flat(name, [width, height], format, usage);
            Image::new(device, &ImageInfo { samples, ..flat })
        };
        let count = scene.drop_count();
        let (alpha, samples) = if count > 0 && plan.order == Order::AlphaToCoverage {
            (Alpha::ToCoverage, Samples::Four)
        } else {
            (Alpha::Blended, Samples::One)
        };
        let usage = Usage::COLOR_ATTACHMENT | Usage::SAMPLED | Usage::TRANSFER_SRC;
        let radiance = target("radiance", RADIANCE, usage, Samples::One)?;
        let multisampled = match samples {
            Samples::One => None,
            _ => Some(target("radiance samples", RADIANCE, Usage::COLOR_ATTACHMENT, samples)?),
        };
        let rain = if count > 0 {
            let (guard_px, _) = guard_band(device, width, height)?;
            let target_state = Target { format: RADIANCE, samples, alpha, guard_px, stage: None };
            let usage = Usage::DEPTH_STENCIL_ATTACHMENT;
            let simulate = Simulate::new(device, frame, scene, plan.simulation)?;
            let compact = plan
                .compacts
                .then(|| Compact::new(device, &simulate, plan.primitive))
                .transpose()?;
            Some(Rain {
                simulate,
                compact,
                drops: Drops::new(
                    device,
                    frame,
                    environment,
                    lighting.table(plan)?,
                    plan,
                    target_state,
                    count,
                )?,
                depth: target("depth", vk::Format::D32_SFLOAT, usage, samples)?,
            })
        } else {
            None
        };
        let sky = Sky::new(device, frame, environment, RADIANCE, samples)?;
        Ok(Self { radiance, samples: multisampled, sky, rain })
    }

    pub fn simulate(&self) -> Option<&Simulate> {
        self.rain.as_ref().map(|rain| &rain.simulate)
    }

    /// What the drops' table is, and the milliseconds that it took.
    pub fn table_ms(&self) -> Option<(&'static str, f64)> {
        self.rain.as_ref().and_then(|rain| rain.drops.table.ms())
    }

    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if let Some(rain) = &self.rain {
            rain.simulate.record_reset(device, commands, scene);
        }
    }

    /// From the frame's constants to the radiance image, left as a colour attachment. A pass's time
    /// includes the wait for its input: drivers that defer drawing do it there.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, time: &mut Timestamps) {
        time.time(commands, "simulate", || {
            let written = [Use::Uniform, Use::ComputeWrite];
            memory_barrier(device, commands, &[Use::TransferWrite], &written);
            if let Some(rain) = &self.rain {
                if let Table::Pictures(far) = &*rain.drops.table {
                    far.appearance.record(commands, Directions::ALL);
                }
                rain.simulate.record(device, commands);
                let readers = [
                    Use::ComputeWrite,
                    Use::VertexInput,
                    Use::Indirect,
                    Use::TransferRead,
                    Use::ShaderRead,
                ];
                memory_barrier(device, commands, &[Use::ComputeWrite], &readers);
            }
        });
        if let Some(compact) = self.rain.as_ref().and_then(|rain| rain.compact.as_ref()) {
            time.time(commands, "compact", || {
                compact.record(device, commands);
                let readers = [Use::VertexInput, Use::Indirect];
                memory_barrier(device, commands, &[Use::ComputeWrite], &readers);
            });
        }

        let readers = [Use::ShaderRead, Use::TransferRead, Use::ColorAttachment];
        let drawn = Use::ColorAttachment;
        image_discard(device, commands, &self.radiance, &readers, drawn);
        if let Some(samples) = &self.samples {
            image_discard(device, commands, samples, &[drawn], drawn);
        }
        let target = self.samples.as_ref().unwrap_or(&self.radiance);
        time.time(commands, "sky", || self.sky.record(device, commands, target));

        if let Some(rain) = &self.rain {
            time.time(commands, "drops", || {
                image_barrier(device, commands, target, drawn, drawn);
                let depth = Use::DepthAttachment;
                image_discard(device, commands, &rain.depth, &[depth], depth);
                let mut color = attachment(target, vk::AttachmentLoadOp::LOAD);
                if self.samples.is_some() {
                    color = color
                        .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                        .resolve_image_view(self.radiance.view())
                        .resolve_image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
                }
                let size = (self.radiance.width, self.radiance.height);
                let records = (&rain.simulate, rain.compact.as_ref());
                rain.drops.record(device, commands, records, color, size, &rain.depth);
            });
        }
    }

    /// Makes the radiance ready for the display pass.
    pub fn record_display(&self, device: &Device, commands: Recorder<'_>) {
        let (before, after) = (Use::ColorAttachment, Use::ShaderRead);
        image_barrier(device, commands, &self.radiance, before, after);
    }
}
