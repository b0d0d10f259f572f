//! The paper's model stage by stage, in float32 and unblended, for the nearest drop of each pixel: where
//! two drivers' pictures differ, the stage that differs first says why.

use std::sync::Arc;

use ash::vk;

use super::lighting::Lighting;
use super::view::surroundings;
use crate::environment::Environment;
use crate::gpu::{
    Alpha, Buffer, Commands, Device, Image, ImageInfo, Samples, Use, attachment, copy_buffer,
    copy_to_buffer, image_barrier, image_discard, memory_barrier,
};
use crate::passes::drops::{Drops, Target, guard_band};
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::simulate::Simulate;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::Optics;
use crate::{Error, Result};

const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// What a pixel can show on the way to its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Where in the drop's square it is, in pixels from the centre; the mask's level.
    Footprint,
    /// The refracted direction, in world space.
    Direction,
    /// Radiance of the drop before blending.
    Radiance,
}

/// Every stage of a frame.
pub struct Stages {
    /// Drop records: centre in view space and radius, by index; radius 0 for those not drawn as points.
    pub drops: Vec<[f32; 4]>,
    /// A picture a stage, in the order of [`Stage`]: three values and alpha; zeros where no drop is.
    pub pictures: [Vec<[f32; 4]>; 3],
}

impl Stages {
    /// Draws the drops of `scene` as far as each stage.
    ///
    /// # Errors
    /// [`Error::Scene`] if the plan reads no mask; what the renderer fails with.
    pub fn draw(
        device: &Arc<Device>,
        scene: &Scene,
        environment: &Environment,
        plan: &FramePlan,
    ) -> Result<Self> {
        if plan.optics != Optics::Mask {
            let problem = format!("they are the mask's, not those of optics {}", plan.optics);
            return Err(Error::scene("stages", problem));
        }
        let (width, height) = scene.picture_size();
        let frame = FrameBuffer::new(device)?;
        let lighting = Lighting::new(device, environment)?;
        let constants = Frame::new(scene, &surroundings(&lighting, scene, plan)?, None);
        let simulate = Simulate::new(device, &frame, scene, plan.simulation)?;
        let (samples, alpha) = (Samples::One, Alpha::Ignored);
        let image = |name, format, usage| {
            Image::new(device, &ImageInfo::flat(name, [width, height], format, usage))
        };
        use vk::ImageUsageFlags as Usage;
        let target = image("stage", FORMAT, Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC)?;
        let depth = image("depth", vk::Format::D32_SFLOAT, Usage::DEPTH_STENCIL_ATTACHMENT)?;
        let (guard_px, _) = guard_band(device, width, height)?;
        let pixels = width as usize * height as usize;
        let name = "stage read back";
        let picture = Buffer::readback(device, name, 16 * pixels as u64)?;
        let records = Buffer::readback(device, name, simulate.drops.size)?;
        let draw = |stage: Stage| {
            let stage = Some(stage as u32);
            let state = Target { format: FORMAT, samples, alpha, guard_px, stage };
            let count = scene.drop_count();
            let (map, table) = (&lighting.environment, lighting.table(plan)?);
            let drops = Drops::new(device, &frame, map, table, plan, state, count)?;
            Commands::once(device, "stage", |commands| {
                let copied = [Use::TransferRead, Use::TransferWrite];
                memory_barrier(device, commands, &copied, &copied);
                simulate.record_reset(device, commands, scene);
                frame.record(device, commands, &constants);
                frame.record_others(device, commands, scene);
                let read = [Use::Uniform, Use::ComputeWrite];
                memory_barrier(device, commands, &[Use::TransferWrite], &read);
                simulate.record(device, commands);
                let readers = [Use::VertexInput, Use::Indirect, Use::TransferRead];
                memory_barrier(device, commands, &[Use::ComputeWrite], &readers);
                let (color_use, depth_use) = (Use::ColorAttachment, Use::DepthAttachment);
                image_discard(device, commands, &target, &[Use::TransferRead], color_use);
                image_discard(device, commands, &depth, &[depth_use], depth_use);
                let color = attachment(&target, vk::AttachmentLoadOp::CLEAR);
                drops.record(device, commands, (&simulate, None), color, (width, height), &depth);
                image_barrier(device, commands, &target, color_use, Use::TransferRead);
                copy_buffer(device, commands, &simulate.drops, &records);
                copy_to_buffer(device, commands, (&target, 0), (&picture, 0));
                memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
            })?;
            Ok::<_, Error>(picture.read(pixels))
        };
        let pictures = [draw(Stage::Footprint)?, draw(Stage::Direction)?, draw(Stage::Radiance)?];
        Ok(Self { drops: records.read(scene.drop_count() as usize), pictures })
    }
}
