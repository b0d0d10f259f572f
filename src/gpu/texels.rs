//! A buffer that shaders read four words at once.

use std::sync::Arc;

use ash::vk;

use super::{Buffer, Device, Named};
use crate::Result;

/// Bytes of a texel: four words.
const TEXEL_BYTES: u64 = 16;

/// A view of a whole buffer of usage `UNIFORM_TEXEL_BUFFER` as texels of four 32-bit words (`usamplerBuffer`);
/// the buffer must outlive it.
pub struct Texels {
    pub(super) view: vk::BufferView,
    device: Arc<Device>,
}

impl Texels {
    /// Whether a buffer of so many bytes can be viewed: GPUs take 2^27 texels and more, SwiftShader 2^16.
    pub fn fit(device: &Device, bytes: u64) -> bool {
        bytes / TEXEL_BYTES <= device.report.limits.max_texel_buffer_elements.into()
    }

    /// The view of a buffer for which [`Texels::fit`] holds.
    pub fn new(device: &Arc<Device>, name: &str, buffer: &Buffer) -> Result<Self> {
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.raw)
            .format(vk::Format::R32G32B32A32_UINT)
            .range(buffer.size / TEXEL_BYTES * TEXEL_BYTES);
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
