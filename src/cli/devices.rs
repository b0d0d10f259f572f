//! `raindrops devices`: every Vulkan device, what it is and what it lacks.

use clap::Args;

use super::{Answer, print};
use crate::Error;
use crate::gpu::{Instance, Validation};

/// List the Vulkan devices: driver, limits, features that are missing
#[derive(Args)]
pub struct DevicesArgs {}

/// Runs the command.
pub fn run(_: &DevicesArgs) -> anyhow::Result<Answer> {
    let devices = Instance::new(Validation::Off)?.devices()?;
    if devices.is_empty() {
        return Err(Error::NoDevice.into());
    }
    for (index, device) in devices.iter().enumerate() {
        let limits = &device.limits;
        let fit = match device.missing.as_slice() {
            [] => "yes".into(),
            missing => format!("no, it lacks {}", missing.join(", ")),
        };
        print(format_args!(
            "{index}: {} ({})
   driver          {} {}
   Vulkan          {}
   point size      {} to {} px, in steps of {}
   largest image   {} px
   storage buffer  {} MiB a binding ({:.1} M drops; more go in chunks)
   timestamps      {} ns a tick
   fit             {fit}",
            device.name,
            device.kind,
            device.driver,
            device.driver_info,
            device.api_version,
            limits.point_size_range[0],
            limits.point_size_range[1],
            limits.point_size_granularity,
            limits.max_image_dimension2_d,
            limits.max_storage_buffer_range >> 20,
            f64::from(limits.max_storage_buffer_range / 16) / 1e6,
            limits.timestamp_period,
        ))?;
    }
    Ok(Answer::Yes)
}
