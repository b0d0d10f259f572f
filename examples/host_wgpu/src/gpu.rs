//! A wgpu device that has what rain needs, and the same device for `raindrops`.

use std::ffi::CStr;
use std::sync::Arc;

use raindrops::ash::vk;
use raindrops::device::{Device, Features, HostDevice, Requirements};
use wgpu::hal::api::Vulkan;

/// The first adapter whose name holds `wanted`.
pub fn adapter(wanted: Option<&str>) -> wgpu::Adapter {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    // Without DEBUG: wgpu would write the language of its shaders into them, which layers of 2022 do not know.
    descriptor.flags = wgpu::InstanceFlags::VALIDATION;
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    let wanted = wanted.unwrap_or_default().to_lowercase();
    let mut found = adapters.into_iter();
    found.find(|a| a.get_info().name.to_lowercase().contains(&wanted)).expect("a Vulkan adapter")
}

/// Opens the adapter with wgpu's own features and those of `required`. wgpu has no names for these, so the device is made
/// here, from the structures that wgpu would make it with.
pub fn open(adapter: &wgpu::Adapter, required: &Requirements) -> (wgpu::Device, wgpu::Queue) {
    let descriptor =
        wgpu::DeviceDescriptor { required_limits: wgpu::Limits::default(), ..Default::default() };
    let features = descriptor.required_features;
    // SAFETY: the device is made of this adapter, with the features and extensions that wgpu asks for and more.
    unsafe {
        let hal = adapter.as_hal::<Vulkan>().expect("Vulkan");
        let mut extensions: Vec<&'static CStr> = hal.required_device_extensions(features);
        extensions.extend_from_slice(required.extensions);
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let mut of_wgpu = hal.physical_device_features(&extensions, features);
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        // What wgpu chains already is switched on there; what it does not is added.
        let mut query_reset = vk::PhysicalDeviceHostQueryResetFeatures::default()
            .host_query_reset(required.features.host_query_reset);
        let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default()
            .dynamic_rendering(required.features.dynamic_rendering);
        let mut synchronization = vk::PhysicalDeviceSynchronization2Features::default()
            .synchronization2(required.features.synchronization2);
        let wanted = required.features.shader_demote_to_helper_invocation;
        let mut demotion = vk::PhysicalDeviceShaderDemoteToHelperInvocationFeatures::default()
            .shader_demote_to_helper_invocation(wanted);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&names)
            .push_next(&mut query_reset)
            .push_next(&mut rendering)
            .push_next(&mut synchronization)
            .push_next(&mut demotion);
        let info = of_wgpu.add_to_device_create(info);
        let mut next = info.p_next.cast_mut().cast::<vk::BaseOutStructure<'_>>();
        while !next.is_null() {
            match (*next).s_type {
                vk::StructureType::PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES => {
                    let found = next.cast::<vk::PhysicalDeviceMaintenance4Features<'_>>();
                    (*found).maintenance4 |= vk::Bool32::from(required.features.maintenance4);
                }
                vk::StructureType::PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES => {
                    let found = next.cast::<vk::PhysicalDeviceTimelineSemaphoreFeatures<'_>>();
                    let wanted = required.features.timeline_semaphore;
                    (*found).timeline_semaphore |= vk::Bool32::from(wanted);
                }
                _ => {}
            }
            next = (*next).p_next;
        }
        let raw = hal.shared_instance().raw_instance();
        let device = raw.create_device(hal.raw_physical_device(), &info, None).expect("a device");
        let limits = &descriptor.required_limits;
        let hints = &descriptor.memory_hints;
        let opened = hal.device_from_raw(device, None, &extensions, features, limits, hints, 0, 0);
        let opened = opened.expect("a device");
        drop(hal);
        adapter.create_device_from_hal(opened, &descriptor).expect("a device of wgpu's")
    }
}

/// Lends the device to `raindrops`.
///
/// # Safety
/// The device was opened by [`open`] with these requirements, outlives what is returned, and is idle when that is dropped.
/// While rain is set up no other thread uses the queue.
pub unsafe fn lend(device: &wgpu::Device, required: &Requirements) -> Arc<Device> {
    // SAFETY: by contract.
    unsafe {
        let hal = device.as_hal::<Vulkan>().expect("Vulkan");
        let instance = hal.shared_instance();
        let host = HostDevice {
            entry: instance.entry().clone(),
            instance: instance.raw_instance().clone(),
            api_version: instance.instance_api_version(),
            debug_utils: instance.extensions().contains(&c"VK_EXT_debug_utils"),
            physical_device: hal.raw_physical_device(),
            device: hal.raw_device().clone(),
            features: Features { ..required.features },
            queue_family: hal.queue_family_index(),
            queue: hal.raw_queue(),
            queue_lock: None,
            allocator: None,
            pipelines: Vec::new(),
        };
        Device::import(host, required).expect("what rain needs")
    }
}
