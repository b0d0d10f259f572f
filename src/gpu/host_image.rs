//! An image of a host's: how it comes, and how it is handed back.

use ash::vk::{self, AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};

use super::barrier::{Use, transition};
use super::{Device, Recorder};
use crate::{Error, Result};

/// How an image is used: its layout, and the stages and accesses that use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageState {
    /// Its layout.
    pub layout: Layout,
    /// On entry the stages that used it, on exit those that will.
    pub stages: Stage,
    /// On entry the accesses of those, on exit those that will be.
    pub access: Access,
}

impl ImageState {
    /// On entry: what it held is not needed, and nothing uses it any more.
    pub const UNDEFINED: Self =
        Self { layout: Layout::UNDEFINED, stages: Stage::NONE, access: Access::NONE };
    /// Drawn into, and blended.
    pub const COLOR_ATTACHMENT: Self = Self {
        layout: Layout::COLOR_ATTACHMENT_OPTIMAL,
        stages: Stage::COLOR_ATTACHMENT_OUTPUT,
        access: Access::from_raw(
            Access::COLOR_ATTACHMENT_READ.as_raw() | Access::COLOR_ATTACHMENT_WRITE.as_raw(),
        ),
    };
    /// Tested against, and written, as depth of a format without stencil.
    pub const DEPTH_ATTACHMENT: Self = Self {
        layout: Layout::DEPTH_ATTACHMENT_OPTIMAL,
        stages: Stage::from_raw(
            Stage::EARLY_FRAGMENT_TESTS.as_raw() | Stage::LATE_FRAGMENT_TESTS.as_raw(),
        ),
        access: Access::from_raw(
            Access::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
                | Access::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
        ),
    };
    /// Sampled by fragment and compute shaders.
    pub const SAMPLED: Self = Self {
        layout: Layout::SHADER_READ_ONLY_OPTIMAL,
        stages: Stage::from_raw(Stage::FRAGMENT_SHADER.as_raw() | Stage::COMPUTE_SHADER.as_raw()),
        access: Access::SHADER_SAMPLED_READ,
    };
    /// Copied from.
    pub const COPY_SOURCE: Self = Self {
        layout: Layout::TRANSFER_SRC_OPTIMAL,
        stages: Stage::ALL_TRANSFER,
        access: Access::TRANSFER_READ,
    };
    /// Copied to.
    pub const COPY_TARGET: Self = Self {
        layout: Layout::TRANSFER_DST_OPTIMAL,
        stages: Stage::ALL_TRANSFER,
        access: Access::TRANSFER_WRITE,
    };

    pub(super) fn of(used: Use) -> Self {
        let (stages, access, layout) = used.scope();
        Self { layout, stages, access }
    }
}

/// Depth formats with stencil.
const WITH_STENCIL: [vk::Format; 3] =
    [vk::Format::D16_UNORM_S8_UINT, vk::Format::D24_UNORM_S8_UINT, vk::Format::D32_SFLOAT_S8_UINT];

/// An image of a host's, with all that commands need to know of it.
#[derive(Clone, Copy, Debug)]
pub struct HostImage {
    /// The image.
    pub image: vk::Image,
    /// The view that is drawn into or read.
    pub view: vk::ImageView,
    /// What the view is of; of depth with stencil, barriers name both aspects.
    pub range: vk::ImageSubresourceRange,
    /// Format of the view.
    pub format: vk::Format,
    /// Texels across and down.
    pub size: (u32, u32),
    /// Samples a texel.
    pub samples: vk::SampleCountFlags,
    /// How it comes.
    pub entry: ImageState,
    /// How it is handed back.
    pub exit: ImageState,
}

impl HostImage {
    /// A colour image of one level, one layer and one sample, that comes and goes as a colour attachment.
    pub fn color(
        image: vk::Image,
        view: vk::ImageView,
        format: vk::Format,
        size: (u32, u32),
    ) -> Self {
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(1);
        let (entry, exit) = (ImageState::COLOR_ATTACHMENT, ImageState::COLOR_ATTACHMENT);
        let samples = vk::SampleCountFlags::TYPE_1;
        Self { image, view, range, format, size, samples, entry, exit }
    }

    /// A depth image of one level, one layer and one sample, that comes and goes as a depth attachment. Of a format with
    /// stencil the view is of the depth alone, and layout and range are those of both, as Vulkan has it without the
    /// feature `separateDepthStencilLayouts`.
    pub fn depth(
        image: vk::Image,
        view: vk::ImageView,
        format: vk::Format,
        size: (u32, u32),
    ) -> Self {
        let mut depth = Self::color(image, view, format, size);
        depth.range.aspect_mask = vk::ImageAspectFlags::DEPTH;
        let mut state = ImageState::DEPTH_ATTACHMENT;
        if WITH_STENCIL.contains(&format) {
            depth.range.aspect_mask |= vk::ImageAspectFlags::STENCIL;
            state.layout = Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        }
        (depth.entry, depth.exit) = (state, state);
        depth
    }

    /// Refuses what cannot be used as `name` by a view of this size. `keeps`: what it holds is read.
    pub(crate) fn check(&self, name: &str, size: (u32, u32), keeps: bool) -> Result<()> {
        let refuse = |problem: String| Err(Error::scene(name, problem));
        if self.image == vk::Image::null() || self.view == vk::ImageView::null() {
            return refuse("image or view is null".into());
        }
        if self.size != size {
            let ((width, height), (to_be, high)) = (self.size, size);
            return refuse(format!("{width} x {height} texels; the view has {to_be} x {high}"));
        }
        if self.samples != vk::SampleCountFlags::TYPE_1 {
            let samples = self.samples;
            return refuse(format!("{samples:?} samples a texel; resolve it first: one is used"));
        }
        let is_content = |layout| ![Layout::UNDEFINED, Layout::PREINITIALIZED].contains(&layout);
        if keeps && !is_content(self.entry.layout) {
            return refuse(format!(
                "it comes in layout {:?}, which holds nothing; what it holds is needed",
                self.entry.layout
            ));
        }
        if !is_content(self.exit.layout) {
            return refuse(format!("it cannot be handed back in layout {:?}", self.exit.layout));
        }
        Ok(())
    }

    /// Makes it ready to be used as `used`.
    pub(crate) fn take(&self, device: &Device, commands: Recorder<'_>, used: Use) {
        let states = [self.entry, ImageState::of(used)];
        transition(device, commands, (self.image, self.range), states);
    }

    /// Hands it back after it was used as `used`.
    pub(crate) fn give_back(&self, device: &Device, commands: Recorder<'_>, used: Use) {
        let states = [ImageState::of(used), self.exit];
        transition(device, commands, (self.image, self.range), states);
    }
}
