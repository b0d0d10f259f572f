//! Barriers, said by what a resource is used for before and after.

use ash::vk::{self, AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};

use super::host_image::ImageState;
use super::{Device, Image, Recorder, unless_none};

/// What a resource is used for: its stages, accesses and, for an image, its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Nothing before; what an image held is lost.
    Nothing,
    /// Written by a copy, a fill or an update.
    TransferWrite,
    /// Read by a copy.
    TransferRead,
    /// Read and written by a compute shader as a storage buffer or a storage image.
    ComputeWrite,
    /// Read by a compute shader: a storage buffer, a buffer's texels, or a sampled image.
    ComputeRead,
    /// Sampled, or read as a storage buffer, by a vertex or fragment shader.
    GraphicsRead,
    /// Both of the last two.
    ShaderRead,
    /// Read by any shader as a uniform buffer.
    Uniform,
    /// Read as vertices.
    VertexInput,
    /// Read as arguments of a draw or dispatch.
    Indirect,
    /// A colour attachment, read (loaded, blended) and written.
    ColorAttachment,
    /// A depth attachment, tested and written.
    DepthAttachment,
    /// Shown in a window; its content reached the queue through a semaphore.
    Present,
    /// Read by the CPU after the queue has signalled.
    HostRead,
}

impl Use {
    pub(super) fn scope(self) -> (Stage, Access, Layout) {
        match self {
            Self::Nothing => (Stage::NONE, Access::NONE, Layout::UNDEFINED),
            Self::TransferWrite => {
                (Stage::TRANSFER, Access::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL)
            }
            Self::TransferRead => {
                (Stage::TRANSFER, Access::TRANSFER_READ, Layout::TRANSFER_SRC_OPTIMAL)
            }
            Self::ComputeWrite => (
                Stage::COMPUTE_SHADER,
                Access::SHADER_STORAGE_READ | Access::SHADER_STORAGE_WRITE,
                Layout::GENERAL,
            ),
            Self::ComputeRead => (
                Stage::COMPUTE_SHADER,
                Access::SHADER_STORAGE_READ | Access::SHADER_SAMPLED_READ,
                Layout::SHADER_READ_ONLY_OPTIMAL,
            ),
            Self::GraphicsRead => (
                Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER,
                Access::SHADER_STORAGE_READ | Access::SHADER_SAMPLED_READ,
                Layout::SHADER_READ_ONLY_OPTIMAL,
            ),
            Self::ShaderRead => (
                Stage::COMPUTE_SHADER | Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER,
                Access::SHADER_STORAGE_READ | Access::SHADER_SAMPLED_READ,
                Layout::SHADER_READ_ONLY_OPTIMAL,
            ),
            Self::Uniform => (
                Stage::COMPUTE_SHADER | Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER,
                Access::UNIFORM_READ,
                Layout::UNDEFINED,
            ),
            Self::VertexInput => {
                (Stage::VERTEX_INPUT, Access::VERTEX_ATTRIBUTE_READ, Layout::UNDEFINED)
            }
            Self::Indirect => {
                (Stage::DRAW_INDIRECT, Access::INDIRECT_COMMAND_READ, Layout::UNDEFINED)
            }
            Self::ColorAttachment => (
                Stage::COLOR_ATTACHMENT_OUTPUT,
                Access::COLOR_ATTACHMENT_READ | Access::COLOR_ATTACHMENT_WRITE,
                Layout::COLOR_ATTACHMENT_OPTIMAL,
            ),
            Self::DepthAttachment => (
                Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
                Access::DEPTH_STENCIL_ATTACHMENT_READ | Access::DEPTH_STENCIL_ATTACHMENT_WRITE,
                Layout::DEPTH_ATTACHMENT_OPTIMAL,
            ),
            Self::Present => (Stage::NONE, Access::NONE, Layout::PRESENT_SRC_KHR),
            Self::HostRead => (Stage::HOST, Access::HOST_READ, Layout::UNDEFINED),
        }
    }
}

/// The scopes of several uses together.
fn join(uses: &[Use]) -> (Stage, Access) {
    uses.iter()
        .map(|one| one.scope())
        .fold((Stage::NONE, Access::NONE), |all, one| (all.0 | one.0, all.1 | one.1))
}

/// Makes every buffer that was used as any of `before` ready for any use in `after`.
pub fn memory_barrier(device: &Device, commands: Recorder<'_>, before: &[Use], after: &[Use]) {
    let ((src_stage, src_access), (mut dst_stage, mut dst_access)) = (join(before), join(after));
    if device.unless_none.is_some() && dst_stage.contains(Stage::DRAW_INDIRECT) {
        dst_stage |= unless_none::STAGE;
        dst_access |= unless_none::ACCESS;
    }
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(src_stage)
        .src_access_mask(src_access)
        .dst_stage_mask(dst_stage)
        .dst_access_mask(dst_access)];
    let info = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: the command buffer is being recorded, outside of any rendering.
    unsafe { device.raw.cmd_pipeline_barrier2(commands.raw(), &info) };
}

/// Makes every level and layer of an image that was used as `before` ready for `after`, in the
/// layout that it needs there.
pub fn image_barrier(
    device: &Device,
    commands: Recorder<'_>,
    image: &Image,
    before: Use,
    after: Use,
) {
    let states = [ImageState::of(before), ImageState::of(after)];
    transition(device, commands, (image.raw, all_of(image)), states);
}

/// Like [`image_barrier`], after any of several uses, whose content is lost.
pub fn image_discard(
    device: &Device,
    commands: Recorder<'_>,
    image: &Image,
    before: &[Use],
    after: Use,
) {
    let (stages, access) = join(before);
    let states = [ImageState { layout: Layout::UNDEFINED, stages, access }, ImageState::of(after)];
    transition(device, commands, (image.raw, all_of(image)), states);
}

fn all_of(image: &Image) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default()
        .aspect_mask(image.aspect())
        .level_count(image.levels)
        .layer_count(image.layers)
}

/// Makes a part of an image that was used in one way ready for another.
pub(super) fn transition(
    device: &Device,
    commands: Recorder<'_>,
    (image, range): (vk::Image, vk::ImageSubresourceRange),
    [before, after]: [ImageState; 2],
) {
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(before.stages)
        .src_access_mask(before.access)
        .dst_stage_mask(after.stages)
        .dst_access_mask(after.access)
        .old_layout(before.layout)
        .new_layout(after.layout)
        .image(image)
        .subresource_range(range)];
    let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
    // SAFETY: the command buffer is being recorded, outside of any rendering; of a host's image the host says how it is used.
    unsafe { device.raw.cmd_pipeline_barrier2(commands.raw(), &info) };
}
