//! A buffer that shaders read a texel at a time: a word, or four words at once.

use std::sync::Arc;

use ash::vk;

use super::{Buffer, Device, Named};
use crate::Result;

/// 32-bit words of a texel.
#[derive(Clone, Copy, Debug)]
pub enum TexelWords {
    /// One.
    One,
    /// Four.
    Four,
}

impl TexelWords {
    fn bytes(self) -> u64 {
        match self {
            Self::One => 4,
            Self::Four => 16,
        }
    }

    /// Every device has both for texel buffers.
    fn format(self) -> vk::Format {
        match self {
            Self::One => vk::Format::R32_UINT,
            Self::Four => vk::Format::R32G32B32A32_UINT,
        }
    }
}

/// A view of a whole buffer of usage `UNIFORM_TEXEL_BUFFER` as texels (`usamplerBuffer`); the buffer must
/// outlive it.
pub struct Texels {
    pub(super) view: vk::BufferView,
    device: Arc<Device>,
}

impl Texels {
    /// Whether a buffer can be viewed: GPUs take 2^27 texels and more, SwiftShader 2^16.
    pub fn fit(device: &Device, buffer: &Buffer, words: TexelWords) -> bool {
        buffer.size / words.bytes() <= device.report.limits.max_texel_buffer_elements.into()
    }

    /// The view of a buffer for which [`Texels::fit`] holds.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        buffer: &Buffer,
        words: TexelWords,
    ) -> Result<Self> {
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.raw)
            .format(words.format())
            .range(buffer.size / words.bytes() * words.bytes());
        // SAFETY: the buffer is alive and of that usage; every device has the format for it.
        let view = unsafe { device.raw.create_buffer_view(&info, None) }
            .named("vkCreateBufferView", name)?;
        device.name(view, name);
        Ok(Self { view, device: device.clone() })
    }
}

impl Drop for Texels {
    fn drop(&mut self) {
        // SAFETY: owners wait for the device before they drop what it uses.
        unsafe { self.device.raw.destroy_buffer_view(self.view, None) };
    }
}
