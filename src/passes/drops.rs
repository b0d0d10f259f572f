//! The paper's section 3.3: every drop in view as a point, shaded from the mask
//! (`glsl/drops_point.vert`, `drops.frag`); those larger than a point may be as quads, by the same
//! fragment shader (`drops_quad.vert`).
//!
//! A drop's square has the area of its true, elliptic outline and stands where that ellipse stands;
//! the mask level follows from the drop's distance. Alpha is coverage; fragments without any are
//! discarded, the others blended, with the depth test resolving the order (drops are not sorted).
//!
//! The viewport is wider than the image by half the largest point: drivers may clip a point whose
//! centre is off the viewport, and with this guard band such a point cannot reach the image.
//!
//! Errors (`docs/method.md`): off the axis directions are wrong by 8° at 30° and more beyond, the
//! ellipse's shape is lost, one sample a pixel aliases.

use std::sync::Arc;

use ash::vk;

use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::mask::Mask;
use super::simulate::Simulate;
use super::{attachment, rendering};
use crate::Result;
use crate::gpu::{
    Binding, Bindings, Device, GraphicsPipeline, GraphicsState, Image, Resource, shaders,
};

/// The pass.
pub struct Drops {
    bindings: Bindings,
    points: GraphicsPipeline,
    quads: GraphicsPipeline,
    guard_px: f32,
    count: u32,
}

/// Guard band in pixels on every side of an image, and the largest point that it allows: half a
/// point off the image must still be inside the viewport.
pub fn guard_band(device: &Device, width: u32, height: u32) -> (f32, f32) {
    let limits = &device.report.limits;
    let room = |edge: u32, axis: usize| {
        let viewport = limits.max_viewport_dimensions[axis].saturating_sub(edge) / 2;
        (viewport as f32).min(-limits.viewport_bounds_range[0])
    };
    let room = room(width, 0).min(room(height, 1));
    let guard = (0.5 * limits.point_size_range[1]).ceil().min(room);
    (guard, limits.point_size_range[1].min(2.0 * guard))
}

impl Drops {
    /// Pipelines for `count` drops on a colour target of `format` with a depth buffer.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        mask: &Mask,
        format: vk::Format,
        count: u32,
        guard_px: f32,
    ) -> Result<Self> {
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let sampled = Binding::COMBINED_IMAGE_SAMPLER;
        let bindings = Bindings::of(
            device,
            "drops",
            &[
                (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer)),
                (sampled, Resource::Sampled(&mask.image, &mask.sampler)),
                (sampled, map),
            ],
        )?;
        let pipeline = |vertex, topology, rate, is_point: u32| {
            GraphicsPipeline::new(
                device,
                [vertex, shaders::DROPS_FRAG],
                &bindings,
                8,
                &[is_point],
                &GraphicsState {
                    topology,
                    attribute: Some(rate),
                    color: format,
                    blend: true,
                    depth: true,
                },
            )
        };
        let points = pipeline(
            shaders::DROPS_POINT_VERT,
            vk::PrimitiveTopology::POINT_LIST,
            vk::VertexInputRate::VERTEX,
            1,
        )?;
        let quads = pipeline(
            shaders::DROPS_QUAD_VERT,
            vk::PrimitiveTopology::TRIANGLE_STRIP,
            vk::VertexInputRate::INSTANCE,
            0,
        )?;
        Ok(Self { bindings, points, quads, guard_px, count })
    }

    /// Records the pass over what `target` holds; `depth` is cleared.
    pub fn record(
        &self,
        device: &Device,
        commands: vk::CommandBuffer,
        simulate: &Simulate,
        target: &Image,
        depth: &Image,
    ) {
        let color = attachment(target, vk::AttachmentLoadOp::LOAD);
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(depth.view())
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::DONT_CARE);
        let size = (target.width, target.height);
        let scale = |edge: u32| edge as f32 / (edge as f32 + 2.0 * self.guard_px);
        let push = [scale(target.width), scale(target.height)];
        let push: &[u8] = bytemuck::cast_slice(&push);
        rendering(device, commands, color, Some(&depth), size, self.guard_px, || {
            let raw = device.raw();
            self.points.bind(commands, &self.bindings, 0, push);
            // SAFETY: within a rendering, with everything bound; the buffers hold what is drawn.
            unsafe {
                raw.cmd_bind_vertex_buffers(commands, 0, &[simulate.drops.raw()], &[0]);
                raw.cmd_draw(commands, self.count, 1, 0, 0);
            }
            self.quads.bind(commands, &self.bindings, 0, push);
            // SAFETY: as above; the arguments were written by the simulation.
            unsafe {
                raw.cmd_bind_vertex_buffers(commands, 0, &[simulate.ordered.raw()], &[0]);
                raw.cmd_draw_indirect(commands, simulate.arguments.raw(), 0, 1, 16);
            }
        });
    }
}
