//! A small image that a probe draws into and reads back.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use crate::Result;
use crate::gpu::{
    Buffer, Commands, Device, Image, ImageInfo, Recorder, Use, attachment, copy_to_buffer,
    image_barrier, image_discard, memory_barrier, rendering,
};

/// A colour attachment, cleared to zeros before each drawing.
pub(super) struct Canvas<'a> {
    image: Image,
    device: &'a Arc<Device>,
}

impl<'a> Canvas<'a> {
    pub fn new(device: &'a Arc<Device>, size: (u32, u32), format: vk::Format) -> Result<Self> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = Image::new(device, &ImageInfo::flat("probe", size.into(), format, usage))?;
        Ok(Self { image, device })
    }

    pub fn size(&self) -> (u32, u32) {
        (self.image.width, self.image.height)
    }

    /// Records a rendering into the cleared image; viewport and scissor are the whole image.
    pub fn record(&self, commands: Recorder<'_>, draw: impl FnOnce()) {
        let device = &**self.device;
        image_discard(device, commands, &self.image, &[Use::TransferRead], Use::ColorAttachment);
        let color = attachment(&self.image, vk::AttachmentLoadOp::CLEAR);
        rendering(device, commands, color, None, self.size(), 0.0, draw);
    }

    /// Draws, waits, and returns the pixels row by row from the top; `Pixel` as the format has it.
    pub fn draw<Pixel: Pod>(&self, draw: impl FnOnce(Recorder<'_>)) -> Result<Vec<Pixel>> {
        let device = &**self.device;
        let count = self.image.width as usize * self.image.height as usize;
        let bytes = (count * size_of::<Pixel>()) as u64;
        let pixels = Buffer::readback(self.device, "probe", bytes)?;
        Commands::once(self.device, "probe", |commands| {
            // Image and buffer may lie where those of a drawing before did.
            let copied = [Use::TransferRead, Use::TransferWrite];
            memory_barrier(device, commands, &copied, &[Use::TransferWrite]);
            self.record(commands, || draw(commands));
            image_barrier(device, commands, &self.image, Use::ColorAttachment, Use::TransferRead);
            copy_to_buffer(device, commands, (&self.image, 0), (&pixels, 0));
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(pixels.read(count))
    }
}
