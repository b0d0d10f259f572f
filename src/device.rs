//! A Vulkan device to draw on: found, chosen, opened, with its compiled pipelines kept; or a host's, with its images.

pub use crate::gpu::disk_cache::{KeptDevice, user_folder};
pub use crate::gpu::{
    Device, DeviceReport, Features, HostDevice, HostImage, ImageState, Instance, QueueLock,
    Requirements, Validation, choose_among,
};
pub use crate::plan::requirements;
