//! The images that a window shows in turn.
//!
//! An image is acquired, drawn to and presented. A surface that changes its size makes the swapchain
//! *stale*: it can no longer, or not well, be presented, and is made anew from the old one.

use std::sync::Arc;

use ash::{khr, vk};

use super::{Commands, Device, Image, Named, Surface};
use crate::{Error, Result};

/// Nanoseconds that acquiring waits for an image: a hidden window may never free one, and must not
/// hold up the program.
const PATIENCE_NS: u64 = 100_000_000;

/// The 8-bit formats whose attachment encodes sRGB; every desktop driver has one of them.
const FORMATS: [vk::Format; 2] = [vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_SRGB];

/// An image to draw to.
#[derive(Clone, Copy, Debug)]
pub struct Acquired {
    index: u32,
    ready: vk::Semaphore,
}

/// The images of a surface.
pub struct Swapchain {
    raw: vk::SwapchainKHR,
    loader: khr::swapchain::Device,
    images: Vec<Image>,
    /// Signalled when an image is ready to be drawn to; one for each frame under way.
    ready: Vec<vk::Semaphore>,
    /// Signalled when an image is drawn; one for each image, because presenting it tells no one when
    /// it has waited.
    drawn: Vec<vk::Semaphore>,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Format of its images.
    pub format: vk::Format,
    is_stale: bool,
    device: Arc<Device>,
    _surface: Arc<Surface>,
}

impl Swapchain {
    /// The images of `surface`, for `frames` frames under way; `wanted` is its size where the
    /// surface leaves it open. With `vsync` frames wait for the screen, without it they are shown as
    /// they come, if the surface can. None while the surface has no area (a minimised window).
    ///
    /// # Errors
    /// [`Error::Window`] without an sRGB format; [`Error::Vulkan`].
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        wanted: (u32, u32),
        vsync: bool,
        frames: usize,
        old: Option<Self>,
    ) -> Result<Option<Self>> {
        debug_assert!(device.presents());
        // What the old images are still used for.
        device.wait_idle()?;
        let physical = device.report.physical;
        let (raw_surface, loader) = (surface.raw, &surface.loader);
        // SAFETY: device and surface come from one instance.
        let (limits, formats, modes) = unsafe {
            (
                loader
                    .get_physical_device_surface_capabilities(physical, raw_surface)
                    .named("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", "the window")?,
                loader
                    .get_physical_device_surface_formats(physical, raw_surface)
                    .named("vkGetPhysicalDeviceSurfaceFormatsKHR", "the window")?,
                loader
                    .get_physical_device_surface_present_modes(physical, raw_surface)
                    .named("vkGetPhysicalDeviceSurfacePresentModesKHR", "the window")?,
            )
        };
        let (least, most) = (limits.min_image_extent, limits.max_image_extent);
        let extent = match limits.current_extent {
            // "The surface takes the swapchain's size", as on Wayland.
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: wanted.0.clamp(least.width, most.width),
                height: wanted.1.clamp(least.height, most.height),
            },
            current => current,
        };
        if extent.width == 0 || extent.height == 0 || wanted.0 == 0 || wanted.1 == 0 {
            return Ok(None);
        }
        let Some(format) = FORMATS.into_iter().find_map(|f| formats.iter().find(|s| s.format == f))
        else {
            return Err(Error::Window("its surface has no 8-bit sRGB format".into()));
        };
        let unsynchronized = [vk::PresentModeKHR::MAILBOX, vk::PresentModeKHR::IMMEDIATE];
        let mode = unsynchronized.into_iter().find(|mode| !vsync && modes.contains(mode));
        let most_images =
            if limits.max_image_count == 0 { u32::MAX } else { limits.max_image_count };
        let alphas = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alphas.into_iter().find(|a| limits.supported_composite_alpha.contains(*a));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(raw_surface)
            .min_image_count((limits.min_image_count + 1).min(most_images))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(limits.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(mode.unwrap_or(vk::PresentModeKHR::FIFO))
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |old| old.raw));
        let loader = khr::swapchain::Device::new(&device.instance().raw, &device.raw);
        // SAFETY: `info` is valid; the handle is owned by the value made here.
        let raw = unsafe { loader.create_swapchain(&info, None) }
            .named("vkCreateSwapchainKHR", "the window")?;
        drop(old);
        let mut swapchain = Self {
            raw,
            loader,
            images: Vec::new(),
            ready: Vec::new(),
            drawn: Vec::new(),
            size: (extent.width, extent.height),
            format: format.format,
            is_stale: false,
            device: device.clone(),
            _surface: surface.clone(),
        };
        device.name(raw, "swapchain");
        // SAFETY: the swapchain was just made.
        let images = unsafe { swapchain.loader.get_swapchain_images(raw) }
            .named("vkGetSwapchainImagesKHR", "the window")?;
        for raw in images {
            let (size, format) = (swapchain.size, swapchain.format);
            let image = Image::of_swapchain(device, "window", raw, size, format)?;
            swapchain.images.push(image);
            swapchain.drawn.push(make_semaphore(device, "window drawn")?);
        }
        for _ in 0..frames {
            swapchain.ready.push(make_semaphore(device, "window ready")?);
        }
        Ok(Some(swapchain))
    }

    /// Whether it should be made anew.
    pub fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// The next image for frame `frame` of those under way, whose last use must be done; none if the
    /// swapchain has become stale or no image came free.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if it fails for another reason, such as a lost device or surface.
    pub fn acquire(&mut self, frame: usize) -> Result<Option<Acquired>> {
        let ready = self.ready[frame];
        // SAFETY: nothing waits for the semaphore: the frame's last use is done.
        let acquired = unsafe {
            self.loader.acquire_next_image(self.raw, PATIENCE_NS, ready, vk::Fence::null())
        };
        match acquired {
            Ok((index, is_suboptimal)) => {
                self.is_stale |= is_suboptimal;
                Ok(Some(Acquired { index, ready }))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.is_stale = true;
                Ok(None)
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(None),
            Err(result) => Err(result).named("vkAcquireNextImageKHR", &self.device.report.name),
        }
    }

    /// The acquired image.
    pub fn image(&self, acquired: Acquired) -> &Image {
        &self.images[acquired.index as usize]
    }

    /// Submits what draws to the acquired image, leaving it ready to present, and presents it.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if submitting or presenting fails, as for a lost device or surface; a swapchain
    /// that has become stale is no error.
    pub fn present(&mut self, acquired: Acquired, commands: &mut Commands) -> Result<()> {
        let drawn = [self.drawn[acquired.index as usize]];
        commands.submit_between(Some(acquired.ready), Some(drawn[0]))?;
        let (swapchains, indices) = ([self.raw], [acquired.index]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&drawn)
            .swapchains(&swapchains)
            .image_indices(&indices);
        let presented = self.device.with_queue(|queue| {
            // SAFETY: the image was acquired; nobody else uses the queue.
            unsafe { self.loader.queue_present(queue, &info) }
        });
        match presented {
            Ok(is_suboptimal) => self.is_stale |= is_suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.is_stale = true,
            Err(result) => {
                return Err(result).named("vkQueuePresentKHR", &self.device.report.name);
            }
        }
        Ok(())
    }
}

fn make_semaphore(device: &Device, name: &str) -> Result<vk::Semaphore> {
    let info = vk::SemaphoreCreateInfo::default();
    // SAFETY: valid info; the swapchain owns the handle.
    let semaphore =
        unsafe { device.raw.create_semaphore(&info, None) }.named("vkCreateSemaphore", name)?;
    device.name(semaphore, name);
    Ok(semaphore)
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // What is still presented uses the images; a lost device presents nothing.
        let _ = self.device.wait_idle();
        self.images.clear();
        // SAFETY: the device is idle, and the surface is still there.
        unsafe {
            for semaphore in self.ready.iter().chain(&self.drawn) {
                self.device.raw.destroy_semaphore(*semaphore, None);
            }
            self.loader.destroy_swapchain(self.raw, None);
        }
    }
}
