//! The passes of a frame and what is made once for them: each beside its shader in `glsl/`, by the
//! same name. A pass owns what only it needs; barriers between passes stand in `renderer.rs`.

pub mod appearance;
pub mod composite;
pub mod drops;
pub mod environment;
pub mod frame;
pub mod mask;
pub mod radial;
pub mod simulate;
pub mod sky;
pub mod tiles;
pub mod tone_map;

use ash::vk;

use crate::gpu::{Device, Image};
use crate::model::{Fresnel, Lookup, Reflection, Weights};
use crate::plan::Light;

/// Specialization constants 0 to 4 of the shaders that include `light_model.glsl`.
pub(crate) fn light_constants(light: &Light) -> [u32; 5] {
    [
        light.internal_reflections,
        (light.weights == Weights::Conserving).into(),
        (light.fresnel == Fresnel::Schlick).into(),
        (light.reflection == Reflection::On).into(),
        (light.lookup == Lookup::Footprint).into(),
    ]
}

/// A colour attachment of a rendering.
pub(crate) fn attachment(
    image: &Image,
    load: vk::AttachmentLoadOp,
) -> vk::RenderingAttachmentInfo<'static> {
    vk::RenderingAttachmentInfo::default()
        .image_view(image.view())
        .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
}

/// Records `draw` between begin and end of a rendering into `color` (and `depth`), with scissor
/// and viewport set to the image, the viewport widened by `guard` pixels on every side.
pub(crate) fn rendering(
    device: &Device,
    commands: vk::CommandBuffer,
    color: vk::RenderingAttachmentInfo<'_>,
    depth: Option<&vk::RenderingAttachmentInfo<'_>>,
    (width, height): (u32, u32),
    guard: f32,
    draw: impl FnOnce(),
) {
    let area = vk::Rect2D { offset: Default::default(), extent: vk::Extent2D { width, height } };
    let colors = [color];
    let mut info =
        vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
    if let Some(depth) = depth {
        info = info.depth_attachment(depth);
    }
    let viewport = vk::Viewport {
        x: -guard,
        y: -guard,
        width: width as f32 + 2.0 * guard,
        height: height as f32 + 2.0 * guard,
        min_depth: 0.0,
        max_depth: 1.0,
    };
    // SAFETY: the command buffer is being recorded; the attachments are in the layouts given.
    unsafe {
        device.raw().cmd_begin_rendering(commands, &info);
        device.raw().cmd_set_viewport(commands, 0, &[viewport]);
        device.raw().cmd_set_scissor(commands, 0, &[area]);
    }
    draw();
    // SAFETY: ends what was begun above.
    unsafe { device.raw().cmd_end_rendering(commands) };
}
