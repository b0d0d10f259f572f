//! Copies between images and tightly packed buffers, and what fills a buffer. All are recorded outside of any rendering.
//! The barriers around them are the caller's. An [`Upload`] fills an image and has its own.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;
use rayon::prelude::*;

use super::{Buffer, Commands, Device, Image, Memory, Recorder, Use, image_barrier};
use crate::Result;

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

/// Bytes that are converted and copied at once, so that an upload's memory does not grow with the image.
const STRIP_BYTES: usize = 32 << 20;

/// Texels of `T` that are copied at once to a level of this width: whole rows, one at least.
fn strip<T>(width: usize) -> usize {
    (STRIP_BYTES / size_of::<T>() / width).max(1) * width
}

/// The most that are copied at once to any level of an image. (A level may have longer strips than the finest.)
fn longest_strip<T>(width: usize, height: usize) -> usize {
    (STRIP_BYTES / size_of::<T>()).max(width).min(width * height)
}

/// An image that is filled level by level with texels of `T`; what it held is lost.
pub struct Upload<'a, T> {
    device: &'a Arc<Device>,
    name: &'a str,
    image: &'a Image,
    staging: Buffer,
    of: PhantomData<T>,
}

impl<'a, T: Pod + Send> Upload<'a, T> {
    /// Begins it.
    ///
    /// # Errors
    /// See [`Buffer::new`] and [`Commands::once`].
    pub fn new(device: &'a Arc<Device>, name: &'a str, image: &'a Image) -> Result<Self> {
        let texels = longest_strip::<T>(image.width as usize, image.height as usize);
        let (bytes, usage) = (size_of::<T>() * texels, vk::BufferUsageFlags::TRANSFER_SRC);
        let staging = Buffer::new(device, name, bytes as u64, usage, Memory::Upload)?;
        let upload = Self { device, name, image, staging, of: PhantomData };
        upload.change(Use::Nothing, Use::TransferWrite)?;
        Ok(upload)
    }

    /// Fills a level, row by row from the top, with what `texel` makes of each value.
    ///
    /// # Errors
    /// See [`Commands::once`].
    pub fn level<V: Sync>(
        &mut self,
        level: u32,
        values: &[V],
        texel: impl Fn(&V) -> T + Sync,
    ) -> Result<()> {
        let (width, _) = self.image.level_size(level);
        let row = width as usize;
        for (number, values) in values.chunks(strip::<T>(row)).enumerate() {
            self.staging.write(0, &values.par_iter().map(&texel).collect::<Vec<T>>());
            let (y, height) = (number * strip::<T>(row) / row, (values.len() / row) as u32);
            let part = [self
                .image
                .level_copy(level, 0)
                .image_offset(vk::Offset3D { x: 0, y: y as i32, z: 0 })
                .image_extent(vk::Extent3D { width, height, depth: 1 })];
            Commands::once(self.device, self.name, |commands| {
                copy_to_image(self.device, commands, &self.staging, self.image, &part);
            })?;
        }
        Ok(())
    }

    /// Makes the image ready to be sampled.
    ///
    /// # Errors
    /// See [`Commands::once`].
    pub fn end(self) -> Result<()> {
        self.change(Use::TransferWrite, Use::ShaderRead)
    }

    fn change(&self, before: Use, after: Use) -> Result<()> {
        Commands::once(self.device, self.name, |commands| {
            image_barrier(self.device, commands, self.image, before, after);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{longest_strip, strip};

    #[test]
    fn a_strip_of_any_level_fits_into_the_buffer() {
        type Texel = [u16; 4];
        for width in (2..=32_768).step_by(2) {
            let room = longest_strip::<Texel>(width, width / 2);
            for level in 0..=width.ilog2() {
                let (width, height) = ((width >> level).max(1), ((width / 2) >> level).max(1));
                assert!(strip::<Texel>(width).min(width * height) <= room, "{width} x {height}");
            }
        }
    }
}
