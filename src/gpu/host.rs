//! A host's device: used, never destroyed and never waited for.

use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::device::new_allocator;
use super::{Device, Features, Instance, Requirements, pipeline_cache};
use crate::Result;

/// Calls what it is given, once, while nobody else uses the queue.
pub type QueueLock = Arc<dyn Fn(&mut dyn FnMut()) + Send + Sync>;

/// A device that somebody else has made, and what of it is lent.
pub struct HostDevice {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// `apiVersion` of the application info that the instance was made with.
    pub api_version: u32,
    /// Whether the instance has `VK_EXT_debug_utils`: then objects have names, and passes labels.
    pub debug_utils: bool,
    /// What the device is of.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// Features that it was made with.
    pub features: Features,
    /// Family of the queue.
    pub queue_family: u32,
    /// The queue that all commands will be submitted to. Set-up is done on it too.
    pub queue: vk::Queue,
    /// How set-up keeps others from the queue; none where no other thread uses it.
    pub queue_lock: Option<QueueLock>,
    /// Where memory is from; none: from an allocator of its own.
    pub allocator: Option<Arc<Mutex<Allocator>>>,
    /// What [`Device::pipelines`] gave in an earlier run, so that it need not be compiled again; empty if you kept none.
    pub pipelines: Vec<u8>,
}

/// What a [`Device`] has of its host.
pub(super) struct OfHost {
    pub queue_lock: Option<QueueLock>,
}

impl Device {
    /// Takes a host's device, for what `requirements` say ([`crate::plan::requirements`]).
    ///
    /// # Errors
    /// [`crate::Error::DeviceLacks`] with everything that is missing; [`crate::Error::Memory`] if no allocator can be made
    /// for it; [`crate::Error::Vulkan`] if the driver refuses.
    ///
    /// # Safety
    /// - All that `host` says is so, and its objects belong together. Its pipelines come from this device and its driver,
    ///   unchanged: drivers trust them.
    /// - Instance and device outlive what is returned and everything that is made from it.
    /// - The last of those is dropped when the queue is done with all commands that were recorded by them.
    pub unsafe fn import(host: HostDevice, requirements: &Requirements) -> Result<Arc<Self>> {
        let HostDevice { entry, instance, api_version, debug_utils, .. } = host;
        // SAFETY: by contract.
        let instance = unsafe { Instance::of_host(entry, instance, api_version, debug_utils) };
        let family = Some(host.queue_family);
        let report =
            instance.report_of(host.physical_device, family, Some(host.features), requirements);
        if !report.missing.is_empty() {
            let missing = report.missing.join(", ");
            return Err(report.lacking(format!("{missing} as its host made it")));
        }
        let allocator = match host.allocator {
            Some(allocator) => allocator,
            None => {
                let own = new_allocator(&instance.raw, &host.device, host.physical_device)?;
                Arc::new(Mutex::new(own))
            }
        };
        let pipeline_cache = pipeline_cache::create(&host.device, &host.pipelines)?;
        let of_host = Some(OfHost { queue_lock: host.queue_lock });
        Ok(Self::of_parts(
            &instance,
            host.device,
            host.queue,
            report,
            host.queue_family,
            allocator,
            pipeline_cache,
            of_host,
        ))
    }
}
