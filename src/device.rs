//! A Vulkan device to draw on: found, chosen, opened, with its compiled pipelines kept.

pub use crate::gpu::disk_cache::{KeptDevice, user_folder};
pub use crate::gpu::{Device, DeviceReport, Instance, Validation};
