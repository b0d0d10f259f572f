//! Motion vectors, depth and number of each pixel's nearest drop, into images of a host's (`glsl/motion_depth.frag`): motion since
//! the frame before. A pixel without a drop keeps what the host has there: its own motion vectors and depth, or what it
//! has cleared them to.
//!
//! It reads which drop `composite` has found, and the drop's record (`layers.rs`).

use std::sync::Arc;

use ash::vk;

use super::composite::Composite;
use super::frame::FrameBuffer;
use super::rendering;
use super::tiles::Tiles;
use crate::abi::MotionDepthPush;
use crate::gpu::sets::motion_depth as slot;
use crate::gpu::{
    Bindings, Device, GraphicsPipeline, GraphicsState, HostImage, Recorder, Resource, Use,
    attachment_of, shaders,
};
use crate::scene::camera::Camera;
use crate::{Error, Result};

/// Formats of motion, of depth and of numbers. Every device draws into them.
const MOTION_FORMATS: [vk::Format; 4] = [
    vk::Format::R16G16_SFLOAT,
    vk::Format::R32G32_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
];
const DEPTH_FORMATS: [vk::Format; 2] = [vk::Format::R32_SFLOAT, vk::Format::R16_SFLOAT];
const NUMBER_FORMATS: [vk::Format; 2] = [vk::Format::R32_UINT, vk::Format::R32G32_UINT];

/// Where a host has the motion of each pixel's nearest drop drawn, and since when.
#[derive(Clone, Copy, Debug)]
pub struct HostMotion {
    /// The image. A pixel without a drop keeps what it holds.
    pub image: HostImage,
    /// The camera of the frame before; with this frame's jitter, if vectors are to be free of it.
    pub camera: Camera,
    /// The time of the frame before.
    pub time: f64,
    /// What a pixel to the right and one down are in the image's unit: 1 and 1 for pixels, 1 / width and 1 / height for
    /// parts of the picture.
    pub pixel: [f32; 2],
}

impl HostMotion {
    /// In pixels, right and down, from where the drop is in this frame to where it was in the one before.
    pub fn since(camera: Camera, time: f64, image: HostImage) -> Self {
        Self { image, camera, time, pixel: [1.0; 2] }
    }
}

/// The pass.
pub struct MotionDepth {
    bindings: Bindings,
    motion: Option<GraphicsPipeline>,
    depth: Option<GraphicsPipeline>,
    number: Option<GraphicsPipeline>,
}

impl MotionDepth {
    /// Writes what `composite` finds; none if nothing is asked for. `formats`: of motion, of depth, of numbers.
    ///
    /// # Errors
    /// [`Error::Scene`] for a format that cannot hold it; [`Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        tiles: &Tiles,
        composite: &Composite,
        formats: [Option<vk::Format>; 3],
    ) -> Result<Option<Self>> {
        let (Some(records), Some(nearest)) = (&tiles.records, &composite.nearest) else {
            return Ok(None);
        };
        if formats.iter().all(Option::is_none) {
            return Ok(None);
        }
        let slots = [
            (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
            (slot::NEAREST_DROPS, Resource::Buffer(nearest)),
            (slot::DROP_RECORDS, Resource::Buffer(&records.records)),
        ];
        let bindings = Bindings::of(device, "motion and depth", &slots)?;
        let pipeline = |name: &str, fragment, format: Option<vk::Format>, known: &[vk::Format]| {
            let Some(format) = format else { return Ok(None) };
            if !known.contains(&format) {
                let known: Vec<_> = known.iter().map(|format| format!("{format:?}")).collect();
                let problem = format!("{format:?} is none of {}", known.join(", "));
                return Err(Error::scene(format!("the format of {name}"), problem));
            }
            let state = GraphicsState::triangles(format);
            let shaders = [shaders::FULLSCREEN_VERT, fragment];
            let push = size_of::<MotionDepthPush>() as u32;
            GraphicsPipeline::new(device, shaders, &bindings, push, &[], &state).map(Some)
        };
        let [motion, depth, number] = formats;
        let (floats, numbers) = (shaders::MOTION_DEPTH_FRAG, shaders::MOTION_DEPTH_FRAG_NUMBER);
        Ok(Some(Self {
            motion: pipeline("motion", floats, motion, &MOTION_FORMATS)?,
            depth: pipeline("nearest depth", floats, depth, &DEPTH_FORMATS)?,
            number: pipeline("nearest number", numbers, number, &NUMBER_FORMATS)?,
            bindings,
        }))
    }

    /// Records it into the images that there are, when what `composite` found is ready to be read.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        motion: Option<&HostMotion>,
        [depth, number]: [Option<&HostImage>; 2],
    ) {
        let draw = |pipeline: &GraphicsPipeline, image: &HostImage, push: MotionDepthPush| {
            image.take(device, commands, Use::ColorAttachment);
            let color = attachment_of(image.view, vk::AttachmentLoadOp::LOAD);
            rendering(device, commands, color, None, image.size, 0.0, || {
                pipeline.draw_triangle(commands, &self.bindings, bytemuck::bytes_of(&push))
            });
            image.give_back(device, commands, Use::ColorAttachment);
        };
        if let (Some(pipeline), Some(motion)) = (&self.motion, motion) {
            draw(pipeline, &motion.image, MotionDepthPush { pixel: motion.pixel, is_depth: 0 });
        }
        if let (Some(pipeline), Some(image)) = (&self.depth, depth) {
            draw(pipeline, image, MotionDepthPush { pixel: [0.0; 2], is_depth: 1 });
        }
        if let (Some(pipeline), Some(image)) = (&self.number, number) {
            draw(pipeline, image, MotionDepthPush::default());
        }
    }
}
