//! Copies between images and tightly packed buffers. The barriers around them are the caller's.

use ash::vk;

use super::{Buffer, Device, Image, Recorder};

/// Records the copy of a whole level, all layers, into a buffer that holds it. The image is to be read by transfers.
pub fn copy_to_buffer(
    device: &Device,
    commands: Recorder<'_>,
    image: &Image,
    level: u32,
    buffer: &Buffer,
) {
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let (image, from, to) = (image.level_copy(level, 0), image.raw(), buffer.raw());
    // SAFETY: by contract the buffer holds the level, and the image is in this layout.
    unsafe { device.raw().cmd_copy_image_to_buffer(commands.raw(), from, layout, to, &[image]) };
}

/// Records copies into parts of an image, which is to be written by transfers.
pub fn copy_to_image(
    device: &Device,
    commands: Recorder<'_>,
    buffer: &Buffer,
    image: &Image,
    parts: &[vk::BufferImageCopy],
) {
    let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
    let (from, to) = (buffer.raw(), image.raw());
    // SAFETY: by contract the parts lie within buffer and image, which is in this layout.
    unsafe { device.raw().cmd_copy_buffer_to_image(commands.raw(), from, to, layout, parts) };
}

/// The part of a level of so many rows from `top` on.
pub fn copy_rows(image: &Image, level: u32, top: u32, height: u32) -> vk::BufferImageCopy {
    let (width, _) = image.level_size(level);
    image
        .level_copy(level, 0)
        .image_offset(vk::Offset3D { x: 0, y: top as i32, z: 0 })
        .image_extent(vk::Extent3D { width, height, depth: 1 })
}
