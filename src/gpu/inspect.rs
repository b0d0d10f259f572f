//! What another driver's compiler makes of the pipelines of a device (`VK_KHR_pipeline_executable_properties`): of a card that
//! is not there, too, as RADV compiles for any of its cards. Nothing is drawn by it.

use std::ffi::CStr;
use std::sync::atomic::Ordering;

use ash::{khr, vk};
use rayon::prelude::*;

use super::bindings::set_layout;
use super::device::{create, extensions_of};
use super::pipeline::PipelineOf;
use super::{Device, DeviceReport, Named, Promises};
use crate::Result;

/// What a driver says of a compiled stage: names and counts.
type Figures = Vec<(String, u64)>;

/// What a compiler says of a shader of a pipeline: names as the driver has them.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The shader.
    pub shader: &'static str,
    /// The specialization constants: number and value.
    pub constants: Vec<[u32; 2]>,
    /// Registers, bytes, …
    pub figures: Figures,
}

impl Device {
    /// From now on pipelines are described and not made, and none is dispatched: for [`Device::pipelines_compiled_for`], which
    /// makes them elsewhere. Nothing may be drawn.
    #[doc(hidden)]
    pub fn only_describe(&self) {
        self.only_describes.store(true, Ordering::Relaxed);
    }

    pub(super) fn only_describes(&self) -> bool {
        self.only_describes.load(Ordering::Relaxed)
    }

    /// Makes every pipeline that was asked for on this device on another of its instance, and gives what its driver says of each.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLacks`] if it does not tell; [`crate::Error::Vulkan`] if a pipeline cannot be made there.
    #[doc(hidden)]
    pub fn pipelines_compiled_for(&self, other: &DeviceReport) -> Result<Vec<Compiled>> {
        let instance = &self.instance().raw;
        let name = khr::pipeline_executable_properties::NAME;
        if !extensions_of(instance, other)?(name) {
            return Err(other.lacking(name.to_string_lossy()));
        }
        let mut told = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let info = vk::DeviceCreateInfo::default().push_next(&mut told);
        let queue_family = other.queue_family.unwrap_or(0);
        let raw = create(instance, other, queue_family, vec![name], info)?;
        let told = khr::pipeline_executable_properties::Device::new(instance, &raw);
        let made = self.pipelines_made();
        let of_all: Vec<_> = made.all().collect();
        let all = of_all.par_iter().map(|of| compiled(&raw, other.promises, &told, of));
        let all: Result<Vec<_>> = all.collect();
        // SAFETY: what was made from it is gone.
        unsafe { raw.destroy_device(None) };
        Ok(all?.into_iter().flatten().collect())
    }
}

/// Makes a pipeline, asks what came of it, and destroys it.
fn compiled(
    device: &ash::Device,
    promises: Promises,
    told: &khr::pipeline_executable_properties::Device,
    of: &PipelineOf,
) -> Result<Vec<Compiled>> {
    let sets = of.slots().iter().map(|slots| set_layout(device, of.name(), slots));
    let sets = sets.collect::<Result<Vec<_>>>()?;
    let layout = of.layout(device, &sets)?;
    let flags = vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
    let pipeline = of.make(device, promises, vk::PipelineCache::null(), layout, flags);
    let stages = match &pipeline {
        // SAFETY: the pipeline was made so that it tells.
        Ok(pipeline) => unsafe { stages(told, *pipeline) },
        Err(_) => Ok(Vec::new()),
    };
    // SAFETY: nothing uses them; null is ignored.
    unsafe {
        device.destroy_pipeline(*pipeline.as_ref().unwrap_or(&vk::Pipeline::null()), None);
        device.destroy_pipeline_layout(layout, None);
        sets.iter().for_each(|set| device.destroy_descriptor_set_layout(*set, None));
    }
    pipeline?;
    let of_stage = |(stage, figures): (String, _)| Compiled {
        shader: of.shader_of(stage.starts_with("Fragment")),
        constants: of.constants().to_vec(),
        figures,
    };
    Ok(stages?.into_iter().map(of_stage).collect())
}

/// The stages of a pipeline, and what the driver says of each.
///
/// # Safety
/// The pipeline is of this device, and was made with `CAPTURE_STATISTICS_KHR`.
unsafe fn stages(
    told: &khr::pipeline_executable_properties::Device,
    pipeline: vk::Pipeline,
) -> Result<Vec<(String, Figures)>> {
    let text = |name: std::result::Result<&CStr, _>| {
        name.map_or_else(|_| "?".into(), |name| name.to_string_lossy().into_owned())
    };
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
    // SAFETY: by contract.
    let stages = unsafe { told.get_pipeline_executable_properties(&info) }
        .named("vkGetPipelineExecutablePropertiesKHR", "a pipeline")?;
    let mut all = Vec::new();
    for (number, stage) in (0..).zip(&stages) {
        let info =
            vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(number);
        // SAFETY: by contract.
        let figures = unsafe { told.get_pipeline_executable_statistics(&info) }
            .named("vkGetPipelineExecutableStatisticsKHR", "a pipeline")?;
        let is_count = |figure: &&vk::PipelineExecutableStatisticKHR<'_>| {
            figure.format == vk::PipelineExecutableStatisticFormatKHR::UINT64
        };
        let figures = figures.iter().filter(is_count).map(|figure| {
            // SAFETY: the format says which it is.
            (text(figure.name_as_c_str()), unsafe { figure.value.u64 })
        });
        all.push((text(stage.name_as_c_str()), figures.collect()));
    }
    Ok(all)
}
