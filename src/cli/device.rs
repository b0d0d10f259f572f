//! The device that a command draws on, and what preset `auto` takes on it.

use std::sync::Arc;

use clap::Args;

use super::tell::{note, remark, say};
use crate::Result;
use crate::environment::Environment;
use crate::gpu::disk_cache::{KeptDevice, user_folder};
use crate::gpu::{Device, DeviceReport, Instance, Machine, Validation, choose_among};
use crate::measure;
use crate::measure::costs::{costs, kept, ranked};
use crate::plan::{Choice, Costs};
use crate::scene::Scene;
use crate::scene::model::Preset;

/// Which device, and whether validation watches it.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Device")]
pub struct DeviceArgs {
    /// Vulkan device: a part of its name or driver, or its index in `raindrops devices`
    #[arg(long, value_name = "NAME|INDEX", env = "RAINDROPS_DEVICE", hide_env_values = true)]
    pub device: Option<String>,
    /// Load the Khronos validation layer, with synchronization checks; any message is an error
    #[arg(long)]
    pub validate: bool,
}

impl DeviceArgs {
    /// Loads Vulkan.
    pub fn instance(&self) -> Result<Arc<Instance>> {
        Instance::new(if self.validate { Validation::On } else { Validation::Off })
    }

    /// Opens the device and says on stderr which one.
    pub fn open(&self) -> anyhow::Result<KeptDevice> {
        let instance = self.instance()?;
        let report = choose_device(&instance, self.device.as_deref())?;
        open_device(&instance, report)
    }
}

/// The devices in the order of `raindrops devices`.
pub fn devices(instance: &Arc<Instance>) -> Result<Vec<DeviceReport>> {
    let ranked = ranked(instance, user_folder().as_deref(), remark)?;
    Ok(ranked.into_iter().map(|device| device.report).collect())
}

/// The device that `wanted` means; without it, and among several of the same kind, the quickest, and says so.
pub fn choose_device(instance: &Arc<Instance>, wanted: Option<&str>) -> Result<DeviceReport> {
    let ranked = ranked(instance, user_folder().as_deref(), remark)?;
    let times: Vec<String> =
        ranked.iter().filter_map(|d| Some(format!("{:.0}", d.frame_ms?))).collect();
    if wanted.is_none() && times.len() > 1 {
        note!(
            "the quickest of {} devices of its kind; a frame of the paper's scene takes about {} ms",
            times.len(),
            times.join(", ")
        );
    }
    let reports: Vec<DeviceReport> = ranked.into_iter().map(|device| device.report).collect();
    choose_among(&reports, wanted)
}

/// Names the machine for which passes are laid out, in place of the device's own.
const MACHINE: &str = "RAINDROPS_MACHINE";

/// The machine that it names, said on stderr.
pub fn wanted_machine() -> anyhow::Result<Option<Machine>> {
    let wanted = std::env::var_os(MACHINE).filter(|wanted| !wanted.is_empty());
    let machine = match wanted.as_ref().map(|wanted| wanted.to_str()) {
        None => return Ok(None),
        Some(Some("cpu")) => Machine::Cpu,
        Some(Some("gpu")) => Machine::Gpu,
        Some(_) => {
            anyhow::bail!("{MACHINE} is {}: cpu or gpu", wanted.unwrap_or_default().display())
        }
    };
    say!("passes are laid out for a {} ({MACHINE})", wanted.unwrap_or_default().display());
    Ok(Some(machine))
}

/// Opens a device, with the user's file of compiled pipelines, and says on stderr which one.
pub fn open_device(
    instance: &Arc<Instance>,
    mut report: DeviceReport,
) -> anyhow::Result<KeptDevice> {
    say!("device: {}", report.summary());
    report.machine = wanted_machine()?.unwrap_or(report.machine);
    Ok(KeptDevice::open(instance, report, user_folder(), remark)?)
}

/// The times by which it is told how long something will take: those that are kept of the device, else of a CPU those that
/// are assumed; of a GPU that was not measured they would tell nothing.
pub fn expected_costs(report: &DeviceReport) -> Option<Costs> {
    let assumed = || (report.machine == Machine::Cpu).then(Costs::default);
    kept(report, user_folder().as_deref(), remark).or_else(assumed)
}

/// What preset `auto` takes for `scene` on `device`, said on stderr; `None` for another preset.
pub fn resolve(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> Result<Option<Choice>> {
    if scene.model.preset != Preset::Auto {
        return Ok(None);
    }
    let costs = costs(device, user_folder().as_deref(), remark)?;
    let choice = measure::resolve(device, scene, environment, &costs)?;
    if let Some(choice) = &choice {
        say!("auto: {}", choice.summary());
    }
    Ok(choice)
}
