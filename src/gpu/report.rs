//! What devices say of themselves, what they lack, and which of them is meant by a name, an index or nothing.

use std::ffi::CStr;

use ash::{ext, vk};

use super::promises::{self, Promises};
use super::requirements::{Capabilities, Features, Requirements};
use super::{Instance, Machine, Named, PipelineKey};
use crate::{Error, Result};

/// What a device is and can do, as it says itself.
#[derive(Clone, Debug)]
pub struct DeviceReport {
    pub(super) physical: vk::PhysicalDevice,
    /// Number of the instance that it is of.
    pub(super) instance: u64,
    /// Device name.
    pub name: String,
    /// Driver name, such as `llvmpipe` or `NVIDIA`.
    pub driver: String,
    /// Driver version, in the driver's own words.
    pub driver_info: String,
    /// Vulkan version, such as 1.3.230.
    pub api_version: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    pub kind: &'static str,
    /// For which machine passes are laid out on it: by its kind, unless somebody sets another.
    pub machine: Machine,
    /// What all presets need and the device lacks, by its Vulkan names; empty if it will do.
    pub missing: Vec<&'static str>,
    /// The features, among those the renderer knows, that the device has; once it is open, those that are enabled.
    pub features: Features,
    /// The device's limits.
    pub limits: vk::PhysicalDeviceLimits,
    /// What it promises of how shaders run, which they declare.
    pub promises: Promises,
    /// The device says that points whose centre is off the viewport are clipped (two of three drivers
    /// say so and draw them).
    pub claims_to_clip_points: bool,
    /// Bytes that a buffer or an image may take at most: by the limit of one allocation, of a buffer,
    /// and by the largest heap.
    pub max_allocation: u64,
    pub(super) queue_family: Option<u32>,
    /// Whether what the host writes is best written to the device's own memory ([`super::buffer::writes_to_device`]).
    pub(super) writes_to_device: bool,
    /// Whether dispatches of no workgroups are left out, which the driver would compile a shader for ([`super::unless_none`]).
    pub(super) leaves_out_empty: bool,
    /// What compiled pipelines of this device belong to.
    pub pipeline_key: PipelineKey,
    /// The build of the driver, in 16 bytes of its own; all 0 before Vulkan 1.3.
    pub driver_uuid: [u8; vk::UUID_SIZE],
    /// Valid bits of a timestamp; 0 if the queue has none.
    pub(super) timestamp_bits: u32,
    rank: u32,
}

/// Kind of a device whose driver runs on the host.
const CPU: &str = "CPU";

impl DeviceReport {
    /// Device, driver and Vulkan version in one line.
    pub fn summary(&self) -> String {
        let driver = format!("{} {}", self.driver, self.driver_info);
        let (name, kind, version) = (&self.name, &self.kind, &self.api_version);
        format!("{name} ({kind}), {}, Vulkan {version}", driver.trim_end())
    }

    /// Whether both are of one device, whatever else has the same name and driver.
    pub fn is_of_same_device(&self, other: &Self) -> bool {
        (self.instance, self.physical) == (other.instance, other.physical)
    }

    /// Whether it will do as well as `other` by all that the two say of themselves.
    pub fn is_as_fit_as(&self, other: &Self) -> bool {
        (self.missing.is_empty(), self.rank) == (other.missing.is_empty(), other.rank)
    }

    /// Features that are required and that it has not, by their Vulkan names.
    pub fn lacks(&self, required: &Requirements) -> Vec<&'static str> {
        let pairs = required.features.named().into_iter().zip(self.features.named());
        pairs.filter(|((_, wanted), (_, is))| *wanted && !is).map(|((name, _), _)| name).collect()
    }

    /// The error of a device that lacks something.
    pub(crate) fn lacking(&self, missing: impl Into<String>) -> Error {
        Error::DeviceLacks { device: self.name.clone(), missing: missing.into() }
    }

    /// Fails if more of something is wanted than the device takes.
    ///
    /// # Errors
    /// [`Error::Limit`], with both figures.
    pub(crate) fn check_limit(&self, what: &'static str, wanted: u64, limit: u64) -> Result<()> {
        if wanted <= limit {
            return Ok(());
        }
        Err(Error::Limit { what, wanted, limit, device: self.name.clone() })
    }

    /// Nanoseconds a tick of its timer, and the bits of it that count; without bits it has none.
    pub fn timer(&self) -> (f64, u32) {
        (self.limits.timestamp_period.into(), self.timestamp_bits)
    }

    /// Does the driver run shaders on the host's processor?
    pub fn is_cpu(&self) -> bool {
        self.kind == CPU
    }
}

impl Instance {
    /// Every Vulkan device that the loader knows: those that will do first, and of these by their kind. Which
    /// of one kind is the quickest is found by measuring (`measure::costs::ranked`).
    ///
    /// # Errors
    /// [`Error::NoCard`] if no driver finds a device; [`Error::Vulkan`] if one fails otherwise while devices are listed.
    pub fn devices(&self) -> Result<Vec<DeviceReport>> {
        let call = "vkEnumeratePhysicalDevices";
        // SAFETY: the instance is alive.
        let physical = match unsafe { self.raw.enumerate_physical_devices() } {
            Err(result @ vk::Result::ERROR_INITIALIZATION_FAILED) => {
                return Err(Error::NoCard { call, result });
            }
            listed => listed.named(call, "the instance")?,
        };
        let mut reports: Vec<_> =
            physical.into_iter().map(|physical| self.report(physical)).collect();
        reports.sort_by_key(|report| (!report.missing.is_empty(), report.rank));
        Ok(reports)
    }

    /// What a device says of itself, and what it lacks of what `fast` and `exact` need. What a plan needs besides is asked when
    /// it is drawn ([`super::Device::require`]); of the features for it a device has those enabled that it has.
    pub(super) fn report(&self, physical: vk::PhysicalDevice) -> DeviceReport {
        self.report_of(physical, None, None, &Requirements::new(false, false))
    }

    /// What a device says of itself, and what it lacks of what is required. `family`: of a queue that was chosen for it;
    /// `enabled`: features with which it was made.
    pub(super) fn report_of(
        &self,
        physical: vk::PhysicalDevice,
        family: Option<u32>,
        enabled: Option<Features>,
        required: &Requirements,
    ) -> DeviceReport {
        // What a host has enabled beside what is required is not known.
        let is_own = enabled.is_none();
        // SAFETY: `physical` comes from this instance.
        let base = unsafe { self.raw.get_physical_device_properties(physical) };
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties11 = vk::PhysicalDeviceVulkan11Properties::default();
        let mut properties13 = vk::PhysicalDeviceVulkan13Properties::default();
        let mut floats = vk::PhysicalDeviceFloatControlsProperties::default();
        let mut features11 = vk::PhysicalDeviceVulkan11Features::default();
        let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default();
        let api_version = base.api_version.min(self.api_version);
        let has_13 = api_version >= vk::API_VERSION_1_3;
        if has_13 {
            let mut properties = vk::PhysicalDeviceProperties2::default()
                .push_next(&mut driver)
                .push_next(&mut properties11)
                .push_next(&mut properties13)
                .push_next(&mut floats);
            features = features
                .push_next(&mut features11)
                .push_next(&mut features12)
                .push_next(&mut features13);
            // SAFETY: a 1.3 device knows all the structures chained here.
            unsafe {
                self.raw.get_physical_device_properties2(physical, &mut properties);
                self.raw.get_physical_device_features2(physical, &mut features);
            }
        }
        let features = features.features;
        let features = Features::of(&features, &features12, &features13);
        // SAFETY: `physical` comes from this instance.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(physical) };
        // SAFETY: as above.
        let memory = unsafe { self.raw.get_physical_device_memory_properties(physical) };
        let heap = memory.memory_heaps_as_slice().iter().map(|heap| heap.size).max().unwrap_or(0);
        let max_allocation =
            [properties11.max_memory_allocation_size, properties13.max_buffer_size]
                .into_iter()
                .filter(|limit| *limit > 0)
                .fold(heap, u64::min);
        let chosen = |family: &u32| families.get(*family as usize).is_some();
        let takes_all =
            |family: &vk::QueueFamilyProperties| family.queue_flags.contains(required.queue_flags);
        let family = family
            .filter(chosen)
            .or_else(|| families.iter().position(takes_all).map(|index| index as u32));
        let properties = family.map(|index| families[index as usize]).unwrap_or_default();
        let in_compute =
            properties11.subgroup_supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
        let limits = &base.limits;
        let has = Capabilities {
            api_version,
            features: enabled.unwrap_or(features),
            queue_flags: properties.queue_flags,
            subgroup_operations: if in_compute {
                properties11.subgroup_supported_operations
            } else {
                vk::SubgroupFeatureFlags::empty()
            },
            workgroup_invocations: limits.max_compute_work_group_size[0]
                .min(limits.max_compute_work_group_invocations),
            storage_buffers_per_stage: limits.max_per_stage_descriptor_storage_buffers,
        };
        let (rank, kind) = match base.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => (0, "discrete GPU"),
            vk::PhysicalDeviceType::INTEGRATED_GPU => (1, "integrated GPU"),
            vk::PhysicalDeviceType::VIRTUAL_GPU => (2, "virtual GPU"),
            vk::PhysicalDeviceType::CPU => (3, CPU),
            _ => (4, "other"),
        };
        let text = |name: Result<&CStr, _>| name.unwrap_or(c"?").to_string_lossy().into_owned();
        DeviceReport {
            physical,
            instance: self.number,
            name: text(base.device_name_as_c_str()),
            driver: text(driver.driver_name_as_c_str()),
            driver_info: text(driver.driver_info_as_c_str()),
            api_version: format!(
                "{}.{}.{}",
                vk::api_version_major(base.api_version),
                vk::api_version_minor(base.api_version),
                vk::api_version_patch(base.api_version)
            ),
            kind,
            machine: if kind == CPU { Machine::Cpu } else { Machine::Gpu },
            missing: required.missing(&has),
            features: has.features,
            limits: base.limits,
            promises: Promises::of(
                &floats,
                has_13 && is_own && self.reconverges(physical),
                kind == CPU,
                driver.driver_id,
            ),
            claims_to_clip_points: properties11.point_clipping_behavior
                == vk::PointClippingBehavior::ALL_CLIP_PLANES,
            max_allocation,
            writes_to_device: super::buffer::writes_to_device(&memory),
            leaves_out_empty: has_13 && is_own && kind == CPU && self.has_conditions(physical),
            queue_family: family,
            pipeline_key: PipelineKey::of(&base),
            driver_uuid: properties11.driver_uuid,
            timestamp_bits: properties.timestamp_valid_bits,
            rank,
        }
    }

    fn has_extension(&self, physical: vk::PhysicalDevice, name: &CStr) -> bool {
        // SAFETY: `physical` comes from this instance.
        let known = unsafe { self.raw.enumerate_device_extension_properties(physical) };
        known.unwrap_or_default().iter().any(|e| e.extension_name_as_c_str() == Ok(name))
    }

    /// Whether a device has `VK_EXT_conditional_rendering`.
    fn has_conditions(&self, physical: vk::PhysicalDevice) -> bool {
        if !self.has_extension(physical, ext::conditional_rendering::NAME) {
            return false;
        }
        let mut feature = vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut feature);
        // SAFETY: `physical` comes from this instance; the device knows the structure of its extension.
        unsafe { self.raw.get_physical_device_features2(physical, &mut features) };
        feature.conditional_rendering == vk::TRUE
    }

    /// Whether a device has `VK_KHR_shader_maximal_reconvergence`, and a layer that watches knows it.
    fn reconverges(&self, physical: vk::PhysicalDevice) -> bool {
        if !self.has_extension(physical, promises::MAXIMAL_RECONVERGENCE) {
            return false;
        }
        let mut feature = vk::PhysicalDeviceShaderMaximalReconvergenceFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut feature);
        // SAFETY: as above; the device knows the structure of its extension.
        unsafe { self.raw.get_physical_device_features2(physical, &mut features) };
        feature.shader_maximal_reconvergence == vk::TRUE
            && self.layer_version.is_none_or(|layer| layer >= promises::LAYER_KNOWS_IT)
    }

    /// The device that `wanted` means among [`Instance::devices`], as [`choose_among`] says.
    ///
    /// # Errors
    /// See [`choose_among`] and [`Instance::devices`].
    pub fn choose(&self, wanted: Option<&str>) -> Result<DeviceReport> {
        choose_among(&self.devices()?, wanted)
    }
}

/// The device that `wanted` means: an index, a part of its [`DeviceReport::summary`] in any case, or
/// without it the first.
///
/// # Errors
/// [`Error::NoDevice`], [`Error::DeviceNotFound`] or [`Error::DeviceLacks`].
pub fn choose_among(devices: &[DeviceReport], wanted: Option<&str>) -> Result<DeviceReport> {
    if devices.is_empty() {
        return Err(Error::NoDevice);
    }
    let chosen = match wanted {
        None => devices.first(),
        Some(wanted) => match wanted.parse::<usize>() {
            Ok(index) => devices.get(index),
            Err(_) => {
                let wanted = wanted.to_lowercase();
                devices.iter().find(|d| d.summary().to_lowercase().contains(&wanted))
            }
        },
    };
    let Some(chosen) = chosen else {
        let names: Vec<_> =
            devices.iter().enumerate().map(|(i, d)| format!("{i}: {}", d.summary())).collect();
        return Err(Error::DeviceNotFound {
            wanted: wanted.unwrap_or_default().into(),
            found: names.join(", "),
        });
    };
    if !chosen.missing.is_empty() {
        return Err(chosen.lacking(chosen.missing.join(", ")));
    }
    Ok(chosen.clone())
}
