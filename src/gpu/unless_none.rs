//! Dispatches that may come out as no workgroup at all, left out whole where they do (`VK_EXT_conditional_rendering`).
//!
//! llvmpipe compiles a shader when it is first dispatched, of whatever number of workgroups: a first frame would wait seconds for
//! what it does not show. Other drivers have compiled it before, and a dispatch of nothing costs them next to nothing.

use ash::{ext, vk};

use super::{Instance, Recorder};

/// What buffers of such numbers are used for besides.
pub(super) const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
/// What reads the number of workgroups before the dispatch does.
pub(super) const STAGE: vk::PipelineStageFlags2 =
    vk::PipelineStageFlags2::CONDITIONAL_RENDERING_EXT;
/// How it reads it.
pub(super) const ACCESS: vk::AccessFlags2 = vk::AccessFlags2::CONDITIONAL_RENDERING_READ_EXT;

/// The calls, of a device that was made with the extension.
pub(super) struct UnlessNone(ext::conditional_rendering::Device);

impl UnlessNone {
    pub fn new(instance: &Instance, device: &ash::Device) -> Self {
        Self(ext::conditional_rendering::Device::new(&instance.raw, device))
    }

    /// Records what `dispatch` does, to be executed unless the word of the buffer at an offset is 0.
    pub fn record(
        &self,
        commands: Recorder<'_>,
        buffer: vk::Buffer,
        offset: u64,
        dispatch: impl FnOnce(),
    ) {
        let begin = vk::ConditionalRenderingBeginInfoEXT::default().buffer(buffer).offset(offset);
        // SAFETY: the feature is enabled; the buffer was made for it, as are all for indirect use, and lives as long as the
        // commands; the offset is one of indirect arguments, of whole words; the command buffer is recorded, with no other
        // condition open, and what `dispatch` records does not begin or end a rendering.
        unsafe { (self.0.fp().cmd_begin_conditional_rendering_ext)(commands.raw(), &begin) };
        dispatch();
        // SAFETY: ends what was just begun.
        unsafe { (self.0.fp().cmd_end_conditional_rendering_ext)(commands.raw()) };
    }
}
