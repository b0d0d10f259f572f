//! A buffer that shaders read a texel at a time: a word, or several at once.

use std::sync::Arc;

use ash::vk;

use super::buffer::BufferMemory;
use super::retired::Object;
use super::{Buffer, Device, Named};
use crate::Result;

/// What a texel is.
#[derive(Clone, Copy, Debug)]
pub enum Texel {
    /// A word of 32 bits.
    Word,
    /// Two words.
    TwoWords,
    /// Four words.
    FourWords,
    /// Four halves, read as floats.
    FourHalves,
}

impl Texel {
    /// Its bytes, and a format that every device has for texel buffers.
    fn layout(self) -> (u64, vk::Format) {
        match self {
            Self::Word => (4, vk::Format::R32_UINT),
            Self::TwoWords => (8, vk::Format::R32G32_UINT),
            Self::FourWords => (16, vk::Format::R32G32B32A32_UINT),
            Self::FourHalves => (8, vk::Format::R16G16B16A16_SFLOAT),
        }
    }
}

/// A view of a buffer of usage `UNIFORM_TEXEL_BUFFER` as texels (`usamplerBuffer`, `samplerBuffer`).
pub struct Texels {
    /// Whether all of it is seen: GPUs take 2^27 texels and more, SwiftShader 2^16.
    pub is_whole: bool,
    pub(super) view: vk::BufferView,
    pub(super) held: Arc<TexelsOf>,
}

/// What is freed with a view.
pub(super) struct TexelsOf {
    view: vk::BufferView,
    device: Arc<Device>,
    _buffer: Arc<BufferMemory>,
}

impl Texels {
    /// Whether all of a buffer can be seen.
    pub fn fit(device: &Device, buffer: &Buffer, texel: Texel) -> bool {
        let (bytes, _) = texel.layout();
        buffer.size / bytes <= device.report.limits.max_texel_buffer_elements.into()
    }

    /// The view of a buffer, or of so much of it as the device takes.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, name: &str, buffer: &Buffer, texel: Texel) -> Result<Self> {
        let (bytes, format) = texel.layout();
        let most: u64 = device.report.limits.max_texel_buffer_elements.into();
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.raw)
            .format(format)
            .range((buffer.size / bytes).min(most) * bytes);
        // SAFETY: the buffer is alive and of that usage; every device has the format for it.
        let view = unsafe { device.raw.create_buffer_view(&info, None) }
            .named("vkCreateBufferView", name)?;
        device.name(view, name);
        let held = TexelsOf { view, device: device.clone(), _buffer: buffer.held.clone() };
        Ok(Self { is_whole: Self::fit(device, buffer, texel), view, held: Arc::new(held) })
    }
}

impl Drop for TexelsOf {
    fn drop(&mut self) {
        self.device.retire([Object::BufferView(self.view)]);
    }
}
