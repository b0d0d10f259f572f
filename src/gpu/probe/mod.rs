//! What a driver really does, found out by drawing. Properties and limits are a driver's word; where a
//! picture depends on them, this is asked instead.
//!
//! [`point_rules`] is what the renderer takes: two submissions of a few small points, once a device
//! (some 20 ms on a CPU driver). [`Findings`] is all of it, for `raindrops devices --probe`.

mod canvas;
mod clock;
pub mod halves;
pub mod points;
mod sampling;

use std::sync::Arc;

use serde::Serialize;

use crate::Result;
use crate::gpu::{Device, PointRules};

pub use clock::Clock;
pub use halves::{Halves, Rounding};
pub use points::Points;
pub use sampling::Sampling;

/// Everything that was found out about a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Points; none if the device lacks `largePoints`.
    pub points: Option<Points>,
    /// Texture levels and filters.
    pub sampling: Sampling,
    /// float16.
    pub halves: Halves,
    /// Timestamps; none if the queue has none.
    pub clock: Option<Clock>,
}

impl Findings {
    /// Probes a device.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the device's images cannot hold the largest point that it claims;
    /// [`crate::Error::Memory`] or [`crate::Error::Vulkan`]: what the driver says.
    pub fn of(device: &Arc<Device>) -> Result<Self> {
        Ok(Self {
            points: device.report.features.large_points.then(|| Points::of(device)).transpose()?,
            sampling: Sampling::of(device)?,
            halves: Halves::of(device)?,
            clock: Clock::of(device)?,
        })
    }
}

/// What the device does with points; found when first asked for.
///
/// # Errors
/// [`crate::Error::Limit`] if the device's images cannot hold the largest point that it claims;
/// [`crate::Error::Memory`] or [`crate::Error::Vulkan`]: what the driver says.
pub fn point_rules(device: &Arc<Device>) -> Result<PointRules> {
    if let Some(rules) = device.point_rules.get() {
        return Ok(*rules);
    }
    let rules = match device.report.features.large_points {
        true => points::rules(device)?,
        // No larger ones may be asked for.
        false => PointRules { limit_px: 1.0, draws_off_screen: false },
    };
    // Whoever was first has found the same.
    Ok(*device.point_rules.get_or_init(|| rules))
}
