//! The paper's section 3.3: every drop in view as a point (`glsl/drops_point.vert`, `drops.frag`);
//! those larger than a point may be as quads, by the same fragment shader (`drops_quad.vert`). Or
//! all as quads.
//!
//! A drop's square has the area of its true, elliptic outline and stands where that ellipse stands.
//! Its light comes from the mask, at the level of its distance; or from another table, or from
//! none, by the closed form. Alpha is coverage; fragments without any are discarded, the others
//! blended, with the depth test resolving the order (drops are not sorted); or alpha decides how many
//! of a pixel's four samples a drop takes.
//!
//! Drivers may clip a point whose centre is off the viewport. Where one is found to (`src/probe`), the
//! viewport is wider than the image by half the largest point: with this guard band a point that is
//! clipped cannot reach the image.
//!
//! Errors (`docs/method.md`): off the axis directions are wrong by 8° at 30° and more beyond, the
//! ellipse's shape is lost, one sample a pixel aliases.

use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::appearance::FarDrop;
use super::compact::Compact;
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::mask::Mask;
use super::radial::{INTERVALS, Radial};
use super::simulate::Simulate;
use super::{light_constants, rendering};
use crate::Result;
use crate::gpu::probe::point_rules;
use crate::gpu::sets::{constant, drops as slot};
use crate::gpu::{
    Alpha, Bindings, Device, GraphicsPipeline, GraphicsState, Image, Recorder, Resource, Samples,
    Shader, Slot, shaders,
};
use crate::plan::FramePlan;
use crate::scene::model::{Optics, Primitive};

/// What the drops are drawn on.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Format of the colour attachment.
    pub format: vk::Format,
    /// Samples a pixel of the attachments.
    pub samples: Samples,
    /// What coverage does.
    pub alpha: Alpha,
    /// Guard band, see [`guard_band`].
    pub guard_px: f32,
    /// Instead of the colour a stage on the way to it, where a mask is read.
    pub stage: Option<u32>,
}

/// Where a fragment finds a drop's light.
pub(crate) enum Table {
    /// The name of either, and the milliseconds that it took.
    Mask(Mask, f64),
    Radial(Radial, f64),
    Pictures(Arc<FarDrop>),
    /// The closed form needs none.
    None,
}

/// A fragment shader, what is bound for it, and its own specialization constant.
type Reader<'a> = (&'static Shader, Option<(Slot, Resource<'a>)>, Option<[u32; 2]>);

impl Table {
    /// The mask, or the table over the impact parameter, whichever the plan's optics read.
    pub fn new(device: &Arc<Device>, plan: &FramePlan) -> Result<Self> {
        let (light, before) = (&plan.light, Instant::now());
        let ms = || before.elapsed().as_secs_f64() * 1e3;
        Ok(if plan.optics == Optics::Radial {
            Self::Radial(Radial::new(device, light.fresnel)?, ms())
        } else {
            Self::Mask(Mask::trace(device, plan.mask_size, plan.optics, light)?, ms())
        })
    }

    /// What it is, and the milliseconds that it took to make.
    pub fn ms(&self) -> Option<(&'static str, f64)> {
        match self {
            Self::Mask(_, ms) => Some(("mask", *ms)),
            Self::Radial(_, ms) => Some(("radial", *ms)),
            Self::Pictures(_) | Self::None => None,
        }
    }

    /// The fragment shader that reads it, what is bound for it, and its own constant.
    fn reader(&self) -> Reader<'_> {
        match self {
            Self::Mask(mask, _) => {
                let image = Resource::Sampled(&mask.image, &mask.sampler);
                (shaders::DROPS_FRAG, Some((slot::MASK, image)), None)
            }
            Self::Radial(radial, _) => (
                shaders::DROPS_FRAG_RADIAL,
                Some((slot::TABLE, Resource::Buffer(&radial.table))),
                Some([constant::INTERVALS, INTERVALS]),
            ),
            Self::Pictures(pictures) => {
                let table = Resource::Buffer(&pictures.appearance.table);
                let source = Some((slot::PICTURES, table));
                (shaders::DROPS_FRAG_PICTURE, source, None)
            }
            Self::None => (shaders::DROPS_FRAG_CLOSED_FORM, None, None),
        }
    }
}

/// The pass.
pub struct Drops {
    bindings: Bindings,
    /// None where all drops are quads.
    points: Option<GraphicsPipeline>,
    quads: GraphicsPipeline,
    guard_px: f32,
    count: u32,
    /// Read by the fragments.
    pub(crate) table: Arc<Table>,
}

/// Guard band in pixels on every side of an image, and the largest point that it allows. Without need
/// of a band, the largest that the device draws; else half a point off the image must still be inside
/// the viewport.
///
/// # Errors
/// See [`point_rules`].
pub fn guard_band(device: &Arc<Device>, width: u32, height: u32) -> Result<(f32, f32)> {
    let rules = point_rules(device)?;
    if rules.draws_off_screen {
        return Ok((0.0, rules.limit_px));
    }
    let limits = &device.report.limits;
    let room = |edge: u32, axis: usize| {
        let viewport = limits.max_viewport_dimensions[axis].saturating_sub(edge) / 2;
        (viewport as f32).min(-limits.viewport_bounds_range[0])
    };
    let room: f32 = room(width, 0).min(room(height, 1));
    let guard: f32 = f32::ceil(0.5 * rules.limit_px).min(room);
    Ok((guard, rules.limit_px.min(2.0 * guard)))
}

impl Drops {
    /// Pipelines for `count` drops.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub(crate) fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        table: Arc<Table>,
        plan: &FramePlan,
        target: Target,
        count: u32,
    ) -> Result<Self> {
        let (fragment, source, own_constant) = table.reader();
        let fragment = if target.stage.is_some() { shaders::DROPS_FRAG_STAGE } else { fragment };
        let map = Resource::Sampled(&environment.image, &environment.sampler);
        let slots: Vec<_> =
            [(slot::CONSTANTS, Resource::Buffer(&frame.buffer)), (slot::ENVIRONMENT_MAP, map)]
                .into_iter()
                .chain(source)
                .collect();
        let bindings = Bindings::of(device, "drops", &slots)?;
        let pipeline = |vertex, topology, rate, is_point: u32| {
            let mut specialization = light_constants(&plan.light).to_vec();
            specialization
                .extend([[constant::IS_POINT, is_point], [constant::SAMPLES, plan.samples]]);
            specialization.extend(own_constant);
            specialization.extend(target.stage.map(|stage| [constant::SHOWN, stage]));
            GraphicsPipeline::new(
                device,
                [vertex, fragment],
                &bindings,
                8,
                &specialization,
                &GraphicsState {
                    topology,
                    attribute: Some(rate),
                    color: target.format,
                    alpha: target.alpha,
                    samples: target.samples,
                    depth: true,
                },
            )
        };
        let points = match plan.primitive {
            Primitive::Quad => None,
            _ => Some(pipeline(
                shaders::DROPS_POINT_VERT,
                vk::PrimitiveTopology::POINT_LIST,
                vk::VertexInputRate::VERTEX,
                1,
            )?),
        };
        let quads = pipeline(
            shaders::DROPS_QUAD_VERT,
            vk::PrimitiveTopology::TRIANGLE_STRIP,
            vk::VertexInputRate::INSTANCE,
            0,
        )?;
        let guard_px = target.guard_px;
        Ok(Self { bindings, points, quads, guard_px, count, table })
    }

    /// Records the pass over what `color`, an attachment of that size, holds; `depth` is cleared. The records come
    /// from `compact` where there is one.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        (simulate, compact): (&Simulate, Option<&Compact>),
        color: vk::RenderingAttachmentInfo<'_>,
        size: (u32, u32),
        depth: &Image,
    ) {
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(depth.view())
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::DONT_CARE);
        let scale = |edge: u32| edge as f32 / (edge as f32 + 2.0 * self.guard_px);
        let push = [scale(size.0), scale(size.1)];
        let push: &[u8] = bytemuck::cast_slice(&push);
        rendering(device, commands, color, Some(&depth), size, self.guard_px, || {
            let raw = device.raw();
            let all = self.points.as_ref().unwrap_or(&self.quads);
            let (vertices, instances) = match self.points {
                Some(_) => (self.count, 1),
                None => (4, self.count),
            };
            all.bind(commands, &self.bindings, push);
            // SAFETY: within a rendering, with everything bound; the buffers hold what is drawn, and the arguments
            // were written by the compaction.
            unsafe {
                if let Some(compact) = compact {
                    for (records, arguments) in compact.draws() {
                        let drops = compact.drops.raw();
                        raw.cmd_bind_vertex_buffers(commands.raw(), 0, &[drops], &[records]);
                        let draws = compact.arguments.raw();
                        raw.cmd_draw_indirect(commands.raw(), draws, arguments, 1, 16);
                    }
                } else {
                    raw.cmd_bind_vertex_buffers(commands.raw(), 0, &[simulate.drops.raw()], &[0]);
                    raw.cmd_draw(commands.raw(), vertices, instances, 0, 0);
                }
            }
            self.quads.bind(commands, &self.bindings, push);
            // SAFETY: as above; the arguments were written by the simulation.
            unsafe {
                raw.cmd_bind_vertex_buffers(commands.raw(), 0, &[simulate.ordered.raw()], &[0]);
                raw.cmd_draw_indirect(commands.raw(), simulate.arguments.raw(), 0, 1, 16);
            }
        });
    }
}
