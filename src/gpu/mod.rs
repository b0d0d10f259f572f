//! Vulkan, one object a file. Nothing here knows of rain.
//!
//! Not part of the public interface, which is [`crate::device`]: this may change with any version, and much of
//! it is sound only as the passes use it.

mod barrier;
mod bindings;
mod buffer;
mod commands;
mod copies;
mod device;
pub mod disk_cache;
mod fold;
#[cfg(feature = "reload")]
mod glsl;
mod graphics_pipeline;
mod host;
mod host_image;
mod image;
mod inspect;
mod instance;
mod machine;
mod pipeline;
mod pipeline_cache;
pub mod probe;
mod promises;
mod rendering;
mod report;
mod requirements;
mod retired;
mod specialize;
#[cfg(feature = "view")]
mod surface;
#[cfg(feature = "view")]
mod swapchain;
mod texels;
mod timestamps;
mod unless_none;
mod words;

pub use barrier::{Use, image_barrier, image_discard, memory_barrier};
#[cfg(feature = "cli")]
pub(crate) use bindings::BUFFER_BYTES;
pub use bindings::{Binding, Bindings, Resource, Slot};
pub use buffer::{Buffer, Memory};
pub use commands::{Commands, Recorder};
pub use copies::{
    Upload, copy_buffer, copy_range, copy_to_buffer, copy_to_image, fill_buffer, update_buffer,
};
pub use device::{Device, MadeCounts, PointRules, ReplacedShaders};
#[cfg(feature = "reload")]
pub use glsl::Glsl;
pub use graphics_pipeline::{Alpha, GraphicsPipeline, GraphicsState};
pub use host::{HostDevice, QueueLock};
pub use host_image::{HostImage, ImageState};
pub use image::{Image, ImageInfo, Sampler, Samples};
#[doc(hidden)]
pub use inspect::Compiled;
pub use instance::{Instance, Validation};
pub use machine::Machine;
pub use pipeline::{ComputePipeline, Shader, Specialization};
pub use pipeline_cache::PipelineKey;
pub use promises::{Promises, Reconvergence};
pub(crate) use rendering::{attachment, attachment_of, rendering};
pub use report::{DeviceReport, choose_among};
pub use requirements::{Features, Requirements};
#[cfg(feature = "view")]
pub use surface::Surface;
#[cfg(feature = "view")]
pub use swapchain::{Acquired, Swapchain};
pub use texels::{Texel, Texels};
pub use timestamps::Timestamps;

/// Bindings and specialization constants of the shaders, set by set, and sizes of their workgroups, as the shaders declare them.
#[allow(missing_docs, reason = "the shaders say what they are")]
pub mod sets {
    include!(concat!(env!("OUT_DIR"), "/sets.rs"));
}

/// The compiled shaders, one constant a file in `glsl/`.
pub mod shaders {
    use super::Shader;
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

use crate::{Error, Result};
use ash::vk;

/// Names the call and the object in a Vulkan error.
trait Named<T> {
    fn named(self, call: &'static str, object: &str) -> Result<T>;
}

impl<T> Named<T> for ash::prelude::VkResult<T> {
    fn named(self, call: &'static str, object: &str) -> Result<T> {
        self.map_err(|result: vk::Result| Error::Vulkan { call, object: object.into(), result })
    }
}
