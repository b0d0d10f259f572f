//! An image with its memory and views, and a sampler.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::retired::Object;
use super::{Device, Named};
use crate::{Error, Result};

/// What kind of image.
#[derive(Clone, Copy, Debug)]
pub struct ImageInfo<'a> {
    /// For captures, messages and errors.
    pub name: &'a str,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Levels of the mip chain.
    pub levels: u32,
    /// Layers of the array; views of more than one are array views.
    pub layers: u32,
    /// Texel format.
    pub format: vk::Format,
    /// What it is used for.
    pub usage: vk::ImageUsageFlags,
    /// Samples a texel.
    pub samples: Samples,
}

impl<'a> ImageInfo<'a> {
    /// One level, one layer and one sample a texel.
    pub fn flat(
        name: &'a str,
        [width, height]: [u32; 2],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Self {
        Self { name, width, height, levels: 1, layers: 1, format, usage, samples: Samples::One }
    }
}

/// Samples a texel; all that the specification promises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Samples {
    /// One.
    #[default]
    One,
    /// Four.
    Four,
}

impl Samples {
    pub(super) fn flags(self) -> vk::SampleCountFlags {
        match self {
            Self::One => vk::SampleCountFlags::TYPE_1,
            Self::Four => vk::SampleCountFlags::TYPE_4,
        }
    }
}

/// A 2D image with its memory and its views. All are freed when neither this, nor a set of it, nor commands need them.
pub struct Image {
    pub(super) raw: vk::Image,
    pub(super) held: Arc<ImageMemory>,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Levels of the mip chain.
    pub levels: u32,
    /// Layers of the array.
    pub layers: u32,
    /// Texel format.
    pub format: vk::Format,
    /// Bytes of memory that it takes.
    pub bytes: u64,
}

/// What is freed with an image.
pub(super) struct ImageMemory {
    raw: vk::Image,
    /// The first view shows every level and layer; each of the others shows one level with all its layers.
    views: Vec<vk::ImageView>,
    allocation: Option<Allocation>,
    /// Whether the handle is to be destroyed; a swapchain's images are its own.
    is_owned: bool,
    device: Arc<Device>,
}

impl Image {
    /// Creates an image. With more than one layer its views are array views.
    ///
    /// # Errors
    /// [`Error::Limit`] if an edge is over the device's limit; [`Error::Memory`] or [`Error::Vulkan`]:
    /// what the driver says.
    pub fn new(device: &Arc<Device>, info: &ImageInfo<'_>) -> Result<Self> {
        let limit = device.report.limits.max_image_dimension2_d.into();
        let edge = info.width.max(info.height).into();
        device.report.check_limit("an image's edge in pixels", edge, limit)?;
        let create = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(info.format)
            .extent(vk::Extent3D { width: info.width, height: info.height, depth: 1 })
            .mip_levels(info.levels)
            .array_layers(info.layers)
            .samples(info.samples.flags())
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(info.usage);
        // SAFETY: `create` is valid; the handle is owned by the value made here.
        let raw =
            unsafe { device.raw.create_image(&create, None) }.named("vkCreateImage", info.name)?;
        // SAFETY: the image was just made.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        let mut held = ImageMemory::new(device, raw, true);
        device.name(raw, info.name);
        device.check_allocation(info.name, requirements.size)?;
        let allocation = device
            .allocator()
            .allocate(&AllocationCreateDesc {
                name: info.name,
                requirements,
                location: MemoryLocation::GpuOnly,
                linear: false,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|error| Error::Memory {
                object: info.name.into(),
                mebibytes: requirements.size as f64 / 1_048_576.0,
                reason: error.to_string(),
            })?;
        // SAFETY: memory of the image's own requirements, bound once.
        let bound =
            unsafe { device.raw.bind_image_memory(raw, allocation.memory(), allocation.offset()) };
        held.allocation = Some(allocation);
        bound.named("vkBindImageMemory", info.name)?;
        held.make_view(info.name, info, 0, info.levels)?;
        for level in 0..info.levels {
            held.make_view(&format!("{} level {level}", info.name), info, level, 1)?;
        }
        Ok(Self::of(held, info, requirements.size))
    }

    /// An image of a swapchain, with one level; the swapchain frees it.
    #[cfg(feature = "view")]
    pub(super) fn of_swapchain(
        device: &Arc<Device>,
        name: &str,
        raw: vk::Image,
        size: (u32, u32),
        format: vk::Format,
    ) -> Result<Self> {
        let info =
            ImageInfo::flat(name, size.into(), format, vk::ImageUsageFlags::COLOR_ATTACHMENT);
        let mut held = ImageMemory::new(device, raw, false);
        device.name(raw, name);
        held.make_view(name, &info, 0, 1)?;
        Ok(Self::of(held, &info, 0))
    }

    fn of(held: ImageMemory, info: &ImageInfo<'_>, bytes: u64) -> Self {
        let ImageInfo { width, height, levels, layers, format, .. } = *info;
        Self { raw: held.raw, held: Arc::new(held), width, height, levels, layers, format, bytes }
    }

    pub(super) fn aspect(&self) -> vk::ImageAspectFlags {
        aspect_of(self.format)
    }

    /// The raw handle, for recording commands.
    pub fn raw(&self) -> vk::Image {
        self.raw
    }

    /// View of every level and layer.
    pub fn view(&self) -> vk::ImageView {
        self.held.views[0]
    }

    /// View of one level, all layers.
    pub fn level_view(&self, level: u32) -> vk::ImageView {
        self.held.views[1 + level as usize]
    }

    /// Width and height of a level.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        ((self.width >> level).max(1), (self.height >> level).max(1))
    }

    /// Copy region of one whole level, all layers, to or from a tightly packed buffer.
    pub fn level_copy(&self, level: u32, buffer_offset: u64) -> vk::BufferImageCopy {
        let (width, height) = self.level_size(level);
        vk::BufferImageCopy::default()
            .buffer_offset(buffer_offset)
            .image_subresource(
                vk::ImageSubresourceLayers::default()
                    .aspect_mask(self.aspect())
                    .mip_level(level)
                    .layer_count(self.layers),
            )
            .image_extent(vk::Extent3D { width, height, depth: 1 })
    }
}

fn aspect_of(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

impl ImageMemory {
    fn new(device: &Arc<Device>, raw: vk::Image, is_owned: bool) -> Self {
        Self { raw, views: Vec::new(), allocation: None, is_owned, device: device.clone() }
    }

    /// Adds a view of some levels, all layers.
    fn make_view(
        &mut self,
        name: &str,
        image: &ImageInfo<'_>,
        first: u32,
        count: u32,
    ) -> Result<()> {
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(aspect_of(image.format))
            .base_mip_level(first)
            .level_count(count)
            .layer_count(image.layers);
        let kind = if image.layers > 1 {
            vk::ImageViewType::TYPE_2D_ARRAY
        } else {
            vk::ImageViewType::TYPE_2D
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(image.format)
            .subresource_range(range);
        // SAFETY: the range lies within the image.
        let view = unsafe { self.device.raw.create_image_view(&info, None) }
            .named("vkCreateImageView", name)?;
        self.device.name(view, name);
        self.views.push(view);
        Ok(())
    }
}

impl Drop for ImageMemory {
    fn drop(&mut self) {
        let views = self.views.drain(..).map(Object::ImageView);
        let image = self.is_owned.then_some(Object::Image(self.raw));
        let memory = self.allocation.take().map(Object::Memory);
        self.device.retire(views.chain(image).chain(memory));
    }
}

/// A sampler: linear within and between levels.
pub struct Sampler {
    pub(super) raw: vk::Sampler,
    pub(super) held: Arc<SamplerOf>,
}

/// What is freed with a sampler.
pub(super) struct SamplerOf {
    raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Linear filtering with the given addressing along u and v.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if the driver refuses.
    pub fn linear(
        device: &Arc<Device>,
        name: &str,
        u: vk::SamplerAddressMode,
        v: vk::SamplerAddressMode,
    ) -> Result<Self> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .address_mode_u(u)
            .address_mode_v(v)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .max_lod(vk::LOD_CLAMP_NONE);
        Self::new(device, name, &info)
    }

    /// For images whose texels are read one by one.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if the driver refuses.
    pub fn nearest(device: &Arc<Device>, name: &str) -> Result<Self> {
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let info = vk::SamplerCreateInfo::default()
            .address_mode_u(edge)
            .address_mode_v(edge)
            .address_mode_w(edge);
        Self::new(device, name, &info)
    }

    fn new(device: &Arc<Device>, name: &str, info: &vk::SamplerCreateInfo<'_>) -> Result<Self> {
        // SAFETY: `info` is valid; the handle is owned by the value made here.
        let raw =
            unsafe { device.raw.create_sampler(info, None) }.named("vkCreateSampler", name)?;
        device.name(raw, name);
        Ok(Self { raw, held: Arc::new(SamplerOf { raw, device: device.clone() }) })
    }
}

impl Drop for SamplerOf {
    fn drop(&mut self) {
        self.device.retire([Object::Sampler(self.raw)]);
    }
}
