//! Compiled pipelines as the driver keeps them, from which the same ones are made in less time.

use ash::vk;

use super::{Device, Named};
use crate::Result;

/// Bytes that the driver's data begins with, as Vulkan defines them: length of this header, its
/// version, vendor, device, UUID.
pub(super) const HEADER: usize = 16 + vk::UUID_SIZE;

/// What compiled pipelines belong to: a device under a version of its driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the words of Vulkan's own properties")]
pub struct PipelineKey {
    pub vendor: u32,
    pub device: u32,
    pub driver_version: u32,
    pub uuid: [u8; vk::UUID_SIZE],
}

impl PipelineKey {
    pub(super) fn of(properties: &vk::PhysicalDeviceProperties) -> Self {
        Self {
            vendor: properties.vendor_id,
            device: properties.device_id,
            driver_version: properties.driver_version,
            uuid: properties.pipeline_cache_uuid,
        }
    }

    /// Whether `data` says that it is of this device and driver. (It says nothing of the driver's
    /// version: the UUID is to change with it.)
    pub fn heads(&self, data: &[u8]) -> bool {
        let version = vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32;
        let words = [HEADER as u32, version, self.vendor, self.device];
        let expected = words.iter().flat_map(|word| word.to_le_bytes()).chain(self.uuid);
        data.len() >= HEADER && expected.eq(data[..HEADER].iter().copied())
    }
}

impl Device {
    /// All pipelines that were made, compiled, with those that the device was opened with.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver does not give them out.
    pub fn pipelines(&self) -> Result<Vec<u8>> {
        // SAFETY: the cache lives as long as the device.
        unsafe { self.raw.get_pipeline_cache_data(self.pipeline_cache) }
            .named("vkGetPipelineCacheData", &self.report.name)
    }
}

/// A cache that holds `data` at first.
pub(super) fn create(device: &ash::Device, data: &[u8]) -> Result<vk::PipelineCache> {
    let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
    // SAFETY: `info` and the data outlive the call.
    unsafe { device.create_pipeline_cache(&info, None) }
        .named("vkCreatePipelineCache", "compiled pipelines")
}
