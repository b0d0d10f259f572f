//! Copies between images and tightly packed buffers, and what fills a buffer. All are recorded outside of any rendering.
//! The barriers around them are the caller's.

use std::ops::Range;

use ash::vk;

use super::{Buffer, Device, Image, Recorder};

/// Most bytes that one `vkCmdUpdateBuffer` takes.
const MOST_UPDATED: usize = 65_536;

/// Records the update of a buffer from a byte offset on with whole words, which are copied now.
pub fn update_buffer(
    device: &Device,
    commands: Recorder<'_>,
    buffer: &Buffer,
    offset: u64,
    bytes: &[u8],
) {
    for (part, at) in bytes.chunks(MOST_UPDATED).zip((offset..).step_by(MOST_UPDATED)) {
        // SAFETY: by contract the buffer holds these words.
        unsafe { device.raw().cmd_update_buffer(commands.raw(), buffer.raw(), at, part) };
    }
}

/// Records that each word of a range, in bytes, becomes `word`.
pub fn fill_buffer(
    device: &Device,
    commands: Recorder<'_>,
    buffer: &Buffer,
    Range { start, end }: Range<u64>,
    word: u32,
) {
    let (raw, bytes) = (buffer.raw(), end - start);
    // SAFETY: by contract the buffer holds the range, which is not empty and of whole words.
    unsafe { device.raw().cmd_fill_buffer(commands.raw(), raw, start, bytes, word) };
}

/// Records the copy of all of a buffer to the beginning of another.
pub fn copy_buffer(device: &Device, commands: Recorder<'_>, from: &Buffer, to: &Buffer) {
    copy_range(device, commands, (from, 0), (to, 0), from.size);
}

/// Records the copy of so many bytes from a byte offset of a buffer to one of another.
pub fn copy_range(
    device: &Device,
    commands: Recorder<'_>,
    (from, src_offset): (&Buffer, u64),
    (to, dst_offset): (&Buffer, u64),
    size: u64,
) {
    let region = [vk::BufferCopy { src_offset, dst_offset, size }];
    // SAFETY: by contract both buffers hold that many bytes there.
    unsafe { device.raw().cmd_copy_buffer(commands.raw(), from.raw(), to.raw(), &region) };
}

/// Records the copy of a whole level, all layers, to a byte offset of a buffer that holds it there. The image is to be read by
/// transfers.
pub fn copy_to_buffer(
    device: &Device,
    commands: Recorder<'_>,
    (image, level): (&Image, u32),
    (buffer, offset): (&Buffer, u64),
) {
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let (image, from, to) = (image.level_copy(level, offset), image.raw(), buffer.raw());
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
