//! What a device must have, as data: our own devices are chosen by it, and a host makes its device by it.

use std::ffi::CStr;

use ash::vk;

/// Features of Vulkan that must be enabled when a device is made, by their Vulkan names. All but the first two must be
/// there on every device of Vulkan 1.3; they must be enabled all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// A member of `VkPhysicalDeviceFeatures`.
    pub large_points: bool,
    /// A member of `VkPhysicalDeviceFeatures`.
    pub shader_storage_image_write_without_format: bool,
    /// A member of `VkPhysicalDeviceVulkan12Features`.
    pub timeline_semaphore: bool,
    /// A member of `VkPhysicalDeviceVulkan12Features`.
    pub host_query_reset: bool,
    /// A member of `VkPhysicalDeviceVulkan13Features`.
    pub dynamic_rendering: bool,
    /// A member of `VkPhysicalDeviceVulkan13Features`.
    pub synchronization2: bool,
    /// A member of `VkPhysicalDeviceVulkan13Features`. SPIR-V 1.6 gives workgroup sizes by LocalSizeId, which is part of it.
    pub maintenance4: bool,
    /// A member of `VkPhysicalDeviceVulkan13Features`. What `discard` becomes in SPIR-V 1.6, by compilers from 2024 on.
    pub shader_demote_to_helper_invocation: bool,
}

impl Features {
    /// The features that are set in these structures, which a device is made with or reports.
    pub fn of(
        core: &vk::PhysicalDeviceFeatures,
        vulkan12: &vk::PhysicalDeviceVulkan12Features<'_>,
        vulkan13: &vk::PhysicalDeviceVulkan13Features<'_>,
    ) -> Self {
        let is = |value| value == vk::TRUE;
        Self {
            large_points: is(core.large_points),
            shader_storage_image_write_without_format: is(
                core.shader_storage_image_write_without_format
            ),
            timeline_semaphore: is(vulkan12.timeline_semaphore),
            host_query_reset: is(vulkan12.host_query_reset),
            dynamic_rendering: is(vulkan13.dynamic_rendering),
            synchronization2: is(vulkan13.synchronization2),
            maintenance4: is(vulkan13.maintenance4),
            shader_demote_to_helper_invocation: is(vulkan13.shader_demote_to_helper_invocation),
        }
    }

    /// Sets them in the structures that a device is made with, and leaves what is set there.
    pub fn enable(
        &self,
        core: &mut vk::PhysicalDeviceFeatures,
        vulkan12: &mut vk::PhysicalDeviceVulkan12Features<'_>,
        vulkan13: &mut vk::PhysicalDeviceVulkan13Features<'_>,
    ) {
        let set = |feature: &mut vk::Bool32, wanted: bool| *feature |= vk::Bool32::from(wanted);
        set(&mut core.large_points, self.large_points);
        set(
            &mut core.shader_storage_image_write_without_format,
            self.shader_storage_image_write_without_format,
        );
        set(&mut vulkan12.timeline_semaphore, self.timeline_semaphore);
        set(&mut vulkan12.host_query_reset, self.host_query_reset);
        set(&mut vulkan13.dynamic_rendering, self.dynamic_rendering);
        set(&mut vulkan13.synchronization2, self.synchronization2);
        set(&mut vulkan13.maintenance4, self.maintenance4);
        set(
            &mut vulkan13.shader_demote_to_helper_invocation,
            self.shader_demote_to_helper_invocation,
        );
    }

    /// Each with its Vulkan name.
    pub fn named(&self) -> [(&'static str, bool); 8] {
        [
            ("largePoints", self.large_points),
            (
                "shaderStorageImageWriteWithoutFormat",
                self.shader_storage_image_write_without_format,
            ),
            ("timelineSemaphore", self.timeline_semaphore),
            ("hostQueryReset", self.host_query_reset),
            ("dynamicRendering", self.dynamic_rendering),
            ("synchronization2", self.synchronization2),
            ("maintenance4", self.maintenance4),
            ("shaderDemoteToHelperInvocation", self.shader_demote_to_helper_invocation),
        ]
    }
}

/// What a device must have. [`crate::plan::requirements`] has it by preset.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Requirements {
    /// Version of Vulkan, of the instance and of the device.
    pub api_version: u32,
    /// Features to enable.
    pub features: Features,
    /// Extensions to enable: none so far.
    pub extensions: &'static [&'static CStr],
    /// What the queue must take.
    pub queue_flags: vk::QueueFlags,
    /// What subgroups must do in compute shaders.
    pub subgroup_operations: vk::SubgroupFeatureFlags,
    /// Least `maxComputeWorkGroupSize[0]` and `maxComputeWorkGroupInvocations`; Vulkan promises 128.
    pub workgroup_invocations: u32,
    /// Least `maxPerStageDescriptorStorageBuffers`; Vulkan promises 4.
    pub storage_buffers_per_stage: u32,
}

/// What a device has of what is required.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Capabilities {
    pub api_version: u32,
    pub features: Features,
    /// What the queue family can do; none where no family has what is required.
    pub queue_flags: vk::QueueFlags,
    /// In compute shaders.
    pub subgroup_operations: vk::SubgroupFeatureFlags,
    pub workgroup_invocations: u32,
    pub storage_buffers_per_stage: u32,
}

/// Most storage buffers of a pipeline: those that all stages of the tile frame share, and those of `composite.comp`.
pub(super) const STORAGE_BUFFERS: u32 = 24;

impl Requirements {
    /// What `composite.comp` and the other passes of the tiles need, and with `points` and `masks` what the paper's do.
    pub(crate) fn new(points: bool, masks: bool) -> Self {
        Self {
            api_version: vk::API_VERSION_1_3,
            features: Features {
                large_points: points,
                shader_storage_image_write_without_format: masks,
                timeline_semaphore: true,
                host_query_reset: true,
                dynamic_rendering: true,
                synchronization2: true,
                maintenance4: true,
                shader_demote_to_helper_invocation: true,
            },
            extensions: &[],
            queue_flags: vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE,
            // `gather.comp` and others use them.
            subgroup_operations: vk::SubgroupFeatureFlags::BASIC
                | vk::SubgroupFeatureFlags::BALLOT
                | vk::SubgroupFeatureFlags::ARITHMETIC,
            workgroup_invocations: 256,
            storage_buffers_per_stage: STORAGE_BUFFERS,
        }
    }

    /// What of this a device lacks, by its Vulkan names; empty if it will do.
    pub(super) fn missing(&self, has: &Capabilities) -> Vec<&'static str> {
        if has.api_version < self.api_version {
            // Nothing more is known of it.
            return vec!["Vulkan 1.3"];
        }
        let of_queue =
            [(has.queue_flags.contains(self.queue_flags), "a queue for graphics and compute")];
        let features = self.features.named().into_iter().zip(has.features.named());
        let features = features.map(|((name, wanted), (_, is))| (is || !wanted, name));
        let of_shaders = [
            (
                has.subgroup_operations.contains(self.subgroup_operations),
                "subgroup ballots and sums in compute shaders",
            ),
            (
                has.workgroup_invocations >= self.workgroup_invocations,
                "workgroups of 256 invocations",
            ),
            (
                has.storage_buffers_per_stage >= self.storage_buffers_per_stage,
                "24 storage buffers a stage",
            ),
        ];
        let all = of_queue.into_iter().chain(features).chain(of_shaders);
        all.filter(|(is, _)| !is).map(|(_, name)| name).collect()
    }
}
