//! A Vulkan device with one queue for everything.

use std::collections::HashMap;
use std::ffi::CStr;
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::host::OfHost;
use super::pipeline::Pipelines;
use super::promises::{MAXIMAL_RECONVERGENCE, Reconvergence};
use super::report::DeviceReport;
use super::requirements::Requirements;
use super::retired::Retired;
use super::unless_none::UnlessNone;
use super::{Instance, Named, Recorder, Shader, pipeline_cache};
use crate::thousands::thousands_of;
use crate::{Error, Result};

/// What a device really does with points (`probe::points`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointRules {
    /// Largest point, in pixels, that is drawn at its size; 0: none.
    pub limit_px: f32,
    /// A point is drawn even where its centre is off the viewport.
    pub draws_off_screen: bool,
}

/// SPIR-V by a shader's name and variant.
pub type ReplacedShaders = HashMap<(&'static str, Option<&'static str>), Arc<[u32]>>;

/// What was made on a device so far, of all that need not be made for each picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MadeCounts {
    /// Pipelines.
    pub pipelines: u32,
    /// Uploads of an environment, or of a part of one.
    pub environments: u32,
    /// Tables of a drop's light.
    pub tables: u32,
    /// Sorts of the rain's drops into clusters.
    pub sorts: u32,
}

/// A logical device, its queue, its memory and its pipelines.
pub struct Device {
    pub(super) raw: ash::Device,
    queue: Mutex<vk::Queue>,
    /// What is of a host: the device itself, and the lock of the queue.
    pub(super) host: Option<OfHost>,
    pub(super) queue_family: u32,
    debug_utils: Option<ext::debug_utils::Device>,
    /// None where every indirect dispatch is executed.
    pub(super) unless_none: Option<UnlessNone>,
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    pub(super) pipeline_cache: vk::PipelineCache,
    pipelines_made: Mutex<Pipelines>,
    made: Mutex<MadeCounts>,
    pub(super) retired: Mutex<Retired>,
    replaced_shaders: Mutex<ReplacedShaders>,
    long_jobs: AtomicUsize,
    pub(super) only_describes: AtomicBool,
    /// What the device says of itself.
    pub report: DeviceReport,
    /// Filled by `probe::point_rules` when it is first asked.
    pub point_rules: OnceLock<PointRules>,
    instance: Arc<Instance>,
}

impl Device {
    /// Opens the device that `report` describes.
    ///
    /// # Errors
    /// [`Error::DeviceNotFound`] if the report is of another instance; [`Error::DeviceLacks`] if it misses a feature
    /// or, under an instance for windows, the swapchain; [`Error::Memory`] if no allocator can be made for it;
    /// [`Error::Vulkan`] if the driver refuses.
    pub fn open(instance: &Arc<Instance>, report: DeviceReport) -> Result<Arc<Self>> {
        // SAFETY: nothing is given.
        unsafe { Self::open_with_pipelines(instance, report, &[]) }
    }

    /// Like [`Device::open`], with pipelines that [`Device::pipelines`] gave in an earlier run: what is
    /// among them need not be compiled again.
    ///
    /// # Errors
    /// See [`Device::open`].
    ///
    /// # Safety
    /// Drivers trust the pipelines: they must come from this device and its driver, unchanged.
    pub unsafe fn open_with_pipelines(
        instance: &Arc<Instance>,
        report: DeviceReport,
        pipelines: &[u8],
    ) -> Result<Arc<Self>> {
        if report.instance != instance.number {
            return Err(Error::DeviceNotFound {
                wanted: report.name,
                found: "those of another instance".into(),
            });
        }
        // What was changed in the report says nothing of the device, but for what passes are laid out for.
        let machine = report.machine;
        let mut report = instance.report(report.physical);
        report.machine = machine;
        // SAFETY: by contract; the report is the instance's own.
        unsafe { Self::open_as(instance, report, pipelines) }
    }

    /// Like [`Device::open_with_pipelines`], and takes the device for what the report says.
    ///
    /// # Errors
    /// See [`Device::open`].
    ///
    /// # Safety
    /// That of [`Device::open_with_pipelines`]. The report is of this instance, and says of the device no more than it
    /// takes.
    #[doc(hidden)]
    pub unsafe fn open_as(
        instance: &Arc<Instance>,
        report: DeviceReport,
        pipelines: &[u8],
    ) -> Result<Arc<Self>> {
        let queue_family = report.queue_family.filter(|_| report.missing.is_empty());
        let Some(queue_family) = queue_family else {
            return Err(report.lacking(report.missing.join(", ")));
        };
        let has = extensions_of(&instance.raw, &report)?;
        let mut extensions = Vec::new();
        if instance.presents {
            let name = khr::swapchain::NAME;
            if !has(name) {
                return Err(report.lacking(name.to_string_lossy()));
            }
            extensions.push(name);
        }
        // A device that has it must be made with it.
        if has(khr::portability_subset::NAME) {
            extensions.push(khr::portability_subset::NAME);
        }
        let info = vk::DeviceCreateInfo::default();
        let raw = create(&instance.raw, &report, queue_family, extensions, info)?;
        // SAFETY: the family was asked for one queue.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let allocator = match new_allocator(&instance.raw, &raw, report.physical) {
            Ok(allocator) => Arc::new(Mutex::new(allocator)),
            Err(error) => {
                // SAFETY: nothing was made from the device yet.
                unsafe { raw.destroy_device(None) };
                return Err(error);
            }
        };
        let pipeline_cache = match pipeline_cache::create(&raw, pipelines) {
            Ok(cache) => cache,
            Err(error) => {
                drop(allocator);
                // SAFETY: nothing that was made from the device is left.
                unsafe { raw.destroy_device(None) };
                return Err(error);
            }
        };
        Ok(Self::of_parts(
            instance,
            raw,
            queue,
            report,
            queue_family,
            allocator,
            pipeline_cache,
            None,
        ))
    }

    #[expect(clippy::too_many_arguments, reason = "each is a part of its own")]
    pub(super) fn of_parts(
        instance: &Arc<Instance>,
        raw: ash::Device,
        queue: vk::Queue,
        report: DeviceReport,
        queue_family: u32,
        allocator: Arc<Mutex<Allocator>>,
        pipeline_cache: vk::PipelineCache,
        host: Option<OfHost>,
    ) -> Arc<Self> {
        let debug_utils =
            instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let unless_none = report.leaves_out_empty.then(|| UnlessNone::new(instance, &raw));
        Arc::new(Self {
            raw,
            queue: Mutex::new(queue),
            host,
            queue_family,
            debug_utils,
            unless_none,
            allocator: ManuallyDrop::new(allocator),
            pipeline_cache,
            pipelines_made: Mutex::default(),
            made: Mutex::default(),
            retired: Mutex::default(),
            replaced_shaders: Mutex::default(),
            long_jobs: AtomicUsize::new(0),
            only_describes: AtomicBool::new(false),
            report,
            point_rules: OnceLock::new(),
            instance: instance.clone(),
        })
    }

    /// Calls `work` with the queue, which nobody else uses meanwhile.
    pub(super) fn with_queue<T>(&self, work: impl FnOnce(vk::Queue) -> T) -> T {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(lock) = self.host.as_ref().and_then(|host| host.queue_lock.as_ref()) else {
            return work(*queue);
        };
        let (mut work, mut done) = (Some(work), None);
        lock(&mut || done = work.take().map(|work| work(*queue)));
        done.expect("the host's lock calls what it is given")
    }

    pub(super) fn pipelines_made(&self) -> MutexGuard<'_, Pipelines> {
        self.pipelines_made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fails if a feature is not enabled that a plan needs; the rest of what is required holds for all plans.
    ///
    /// # Errors
    /// [`Error::DeviceLacks`] with the features.
    pub(crate) fn require(&self, required: &Requirements) -> Result<()> {
        let missing = self.report.lacks(required);
        if missing.is_empty() { Ok(()) } else { Err(self.report.lacking(missing.join(", "))) }
    }

    /// What was made on it so far.
    #[doc(hidden)]
    pub fn made(&self) -> MadeCounts {
        *self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts one more of what [`Device::made`] tells.
    pub(crate) fn count(&self, which: impl FnOnce(&mut MadeCounts) -> &mut u32) {
        *which(&mut self.made.lock().unwrap_or_else(PoisonError::into_inner)) += 1;
    }

    /// What an image of this format with optimal tiling can be used for.
    pub fn format_features(&self, format: vk::Format) -> vk::FormatFeatureFlags {
        let physical = self.report.physical;
        // SAFETY: the physical device comes from this instance.
        unsafe { self.instance.raw.get_physical_device_format_properties(physical, format) }
            .optimal_tiling_features
    }

    /// The instance that this device belongs to.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Whether an instance with windows made it, so that it can present.
    #[cfg(feature = "view")]
    pub(super) fn presents(&self) -> bool {
        self.instance.presents
    }

    /// The raw device, for recording commands.
    pub fn raw(&self) -> &ash::Device {
        &self.raw
    }

    /// Gives an object a name, for captures and validation messages.
    pub(super) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(debug_utils) = &self.debug_utils else { return };
        let Ok(name) = std::ffi::CString::new(name) else { return };
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // A name that could not be set costs nothing but itself.
        // SAFETY: the object belongs to this device; the name outlives the call.
        let _ = unsafe { debug_utils.set_debug_utils_object_name(&info) };
    }

    /// Opens or closes a named region in the command buffer, for captures.
    pub(super) fn begin_label(&self, commands: Recorder<'_>, name: &str) {
        let Some(debug_utils) = &self.debug_utils else { return };
        let Ok(name) = std::ffi::CString::new(name) else { return };
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the command buffer is being recorded; the name outlives the call.
        unsafe { debug_utils.cmd_begin_debug_utils_label(commands.raw(), &label) };
    }

    pub(super) fn end_label(&self, commands: Recorder<'_>) {
        if let Some(debug_utils) = &self.debug_utils {
            // SAFETY: closes the region that `begin_label` opened.
            unsafe { debug_utils.cmd_end_debug_utils_label(commands.raw()) };
        }
    }

    /// Refuses what no allocation of this device can hold, before it is asked for.
    ///
    /// # Errors
    /// [`Error::Memory`], with both figures.
    pub(super) fn check_allocation(&self, object: &str, bytes: u64) -> Result<()> {
        let most = self.report.max_allocation;
        if bytes <= most {
            return Ok(());
        }
        const MEBIBYTE: f64 = 1_048_576.0;
        Err(Error::Memory {
            object: object.into(),
            mebibytes: bytes as f64 / MEBIBYTE,
            reason: format!(
                "{} gives {} MiB at once at most; draw fewer drops or a smaller image",
                self.report.name,
                thousands_of(most as f64 / MEBIBYTE, 1)
            ),
        })
    }

    /// Bytes of memory that everything made from the device takes now; of a host's allocator, all that it gave.
    pub fn allocated_bytes(&self) -> u64 {
        self.allocator().generate_report().total_allocated_bytes
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Pipelines made from now on take these instead of the shaders of the same name and variant
    /// that the program was built with.
    ///
    /// # Safety
    /// Each is valid SPIR-V, with the interface of the shader that it replaces.
    pub unsafe fn replace_shaders(&self, shaders: ReplacedShaders) {
        *self.replaced_shaders.lock().unwrap_or_else(PoisonError::into_inner) = shaders;
    }

    /// What [`Device::replace_shaders`] was given, for a device that takes this one's place.
    pub fn replaced_shaders(&self) -> ReplacedShaders {
        self.replaced_shaders.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn replaced_shader(&self, shader: &Shader) -> Option<Arc<[u32]>> {
        let replaced = self.replaced_shaders.lock().unwrap_or_else(PoisonError::into_inner);
        replaced.get(&(shader.name, shader.define)).cloned()
    }

    /// Announces work that is done once and may keep the queue for long, until the result is dropped.
    pub fn long_job(&self) -> LongJob<'_> {
        self.long_jobs.fetch_add(1, Ordering::Relaxed);
        LongJob(self)
    }

    /// Whether long work is announced. A frame submitted now would wait behind it, and so would the
    /// thread that presents the frame.
    pub fn has_long_job(&self) -> bool {
        self.long_jobs.load(Ordering::Relaxed) > 0
    }

    /// Waits until the device has nothing left to do. Other threads cannot submit meanwhile. A host's device is not
    /// waited for.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if waiting fails, as for a lost device.
    pub fn wait_idle(&self) -> Result<()> {
        if self.host.is_some() {
            return Ok(());
        }
        self.with_queue(|_| {
            // SAFETY: the device has one queue, and the lock keeps other threads from it.
            unsafe { self.raw.device_wait_idle() }.named("vkDeviceWaitIdle", &self.report.name)
        })
    }
}

/// What [`Device::long_job`] announced, as long as it lives.
pub struct LongJob<'a>(&'a Device);

impl Drop for LongJob<'_> {
    fn drop(&mut self) {
        self.0.long_jobs.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // A lost device cannot be waited for, and is destroyed all the same.
        let _ = self.wait_idle();
        self.free_all();
        // SAFETY: every object made from the device holds an `Arc` of it, so none is left, and no commands use one: the
        // device is idle, or its host has promised so. The allocator goes before the device whose memory it frees, and
        // is not used again.
        unsafe {
            ManuallyDrop::drop(&mut self.allocator);
            self.pipelines_made().destroy(&self.raw);
            self.raw.destroy_pipeline_cache(self.pipeline_cache, None);
            if self.host.is_none() {
                self.raw.destroy_device(None);
            }
        }
    }
}

/// Which extensions a device of this instance has.
pub(super) fn extensions_of(
    instance: &ash::Instance,
    report: &DeviceReport,
) -> Result<impl Fn(&CStr) -> bool + use<>> {
    // SAFETY: the physical device comes from this instance.
    let known = unsafe { instance.enumerate_device_extension_properties(report.physical) }
        .named("vkEnumerateDeviceExtensionProperties", &report.name)?;
    Ok(move |name: &CStr| known.iter().any(|e| e.extension_name_as_c_str() == Ok(name)))
}

/// A device of this instance with one queue of a family, with the features and promises of its report, these extensions,
/// which it has, and what else `info` says.
pub(super) fn create(
    instance: &ash::Instance,
    report: &DeviceReport,
    queue_family: u32,
    mut extensions: Vec<&CStr>,
    info: vk::DeviceCreateInfo<'_>,
) -> Result<ash::Device> {
    let reconverges = report.promises.reconvergence == Reconvergence::Promised;
    if reconverges {
        extensions.push(MAXIMAL_RECONVERGENCE);
    }
    if report.leaves_out_empty {
        extensions.push(ext::conditional_rendering::NAME);
    }
    let extensions: Vec<_> = extensions.into_iter().map(CStr::as_ptr).collect();
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&priorities)];
    let mut enabled = vk::PhysicalDeviceFeatures::default();
    let mut enabled12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut enabled13 = vk::PhysicalDeviceVulkan13Features::default();
    report.features.enable(&mut enabled, &mut enabled12, &mut enabled13);
    let mut reconvergence = vk::PhysicalDeviceShaderMaximalReconvergenceFeaturesKHR::default()
        .shader_maximal_reconvergence(true);
    let mut conditional =
        vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default().conditional_rendering(true);
    let mut info = info
        .queue_create_infos(&queues)
        .enabled_features(&enabled)
        .enabled_extension_names(&extensions)
        .push_next(&mut enabled12)
        .push_next(&mut enabled13);
    if reconverges {
        info = info.push_next(&mut reconvergence);
    }
    if report.leaves_out_empty {
        info = info.push_next(&mut conditional);
    }
    // SAFETY: `info` and all it points to outlive the call; the device has what is enabled.
    unsafe { instance.create_device(report.physical, &info, None) }
        .named("vkCreateDevice", &report.name)
}

/// An allocator of memory of a device.
pub(super) fn new_allocator(
    instance: &ash::Instance,
    device: &ash::Device,
    physical_device: vk::PhysicalDevice,
) -> Result<Allocator> {
    Allocator::new(&AllocatorCreateDesc {
        instance: instance.clone(),
        device: device.clone(),
        physical_device,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    })
    .map_err(|error| Error::Memory {
        object: "the allocator".into(),
        mebibytes: 0.0,
        reason: error.to_string(),
    })
}
