//! Recording a rendering into images.

use ash::vk;

use super::{Device, Image, Recorder};

/// A colour attachment of a rendering.
pub(crate) fn attachment(
    image: &Image,
    load: vk::AttachmentLoadOp,
) -> vk::RenderingAttachmentInfo<'static> {
    attachment_of(image.view(), load)
}

/// Like [`attachment`], of a view.
pub(crate) fn attachment_of(
    view: vk::ImageView,
    load: vk::AttachmentLoadOp,
) -> vk::RenderingAttachmentInfo<'static> {
    vk::RenderingAttachmentInfo::default()
        .image_view(view)
        .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
}

/// Records `draw` between begin and end of a rendering into `color` (and `depth`), with scissor
/// and viewport set to the image, the viewport widened by `guard` pixels on every side.
pub(crate) fn rendering(
    device: &Device,
    commands: Recorder<'_>,
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
        device.raw().cmd_begin_rendering(commands.raw(), &info);
        device.raw().cmd_set_viewport(commands.raw(), 0, &[viewport]);
        device.raw().cmd_set_scissor(commands.raw(), 0, &[area]);
    }
    draw();
    // SAFETY: ends what was begun above.
    unsafe { device.raw().cmd_end_rendering(commands.raw()) };
}
