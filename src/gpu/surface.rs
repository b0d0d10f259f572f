//! The surface of a window: where a swapchain presents to.

use std::any::Any;
use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use super::{Device, Instance, Named};
use crate::{Error, Result};

/// The surface of a window, which it keeps alive.
pub struct Surface {
    pub(super) raw: vk::SurfaceKHR,
    pub(super) loader: khr::surface::Instance,
    // Freed in this order: the surface is gone before its window and its instance.
    _window: Arc<dyn Any + Send + Sync>,
    _instance: Arc<Instance>,
}

impl Surface {
    /// The surface of `window`; the instance was made for the window's display.
    ///
    /// # Errors
    /// [`Error::Window`]; [`Error::Vulkan`].
    pub fn new<W>(instance: &Arc<Instance>, window: Arc<W>) -> Result<Self>
    where
        W: HasDisplayHandle + HasWindowHandle + Send + Sync + 'static,
    {
        let problem = |error: &dyn std::fmt::Display| Error::Window(error.to_string());
        let display = window.display_handle().map_err(|error| problem(&error))?.as_raw();
        let handle = window.window_handle().map_err(|error| problem(&error))?.as_raw();
        // SAFETY: the handles are the window's, which the surface keeps alive; the instance has the
        // extensions of its display.
        let made = unsafe {
            ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None)
        };
        let raw = made.named("vkCreateSurfaceKHR", "the window")?;
        let loader = khr::surface::Instance::new(&instance.entry, &instance.raw);
        Ok(Self { raw, loader, _window: window, _instance: instance.clone() })
    }

    /// Fails if the device cannot present to this surface.
    ///
    /// # Errors
    /// [`Error::Window`] if it cannot; [`Error::Vulkan`] if the driver does not say.
    pub fn check(&self, device: &Device) -> Result<()> {
        // SAFETY: device and surface come from one instance.
        let supported = unsafe {
            self.loader.get_physical_device_surface_support(
                device.report.physical,
                device.queue_family,
                self.raw,
            )
        };
        match supported.named("vkGetPhysicalDeviceSurfaceSupportKHR", "the window")? {
            true => Ok(()),
            false => Err(Error::Window(format!(
                "{} cannot draw in windows of this display; take another device",
                device.report.name
            ))),
        }
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: a swapchain holds an `Arc` of its surface, so none is left.
        unsafe { self.loader.destroy_surface(self.raw, None) };
    }
}
