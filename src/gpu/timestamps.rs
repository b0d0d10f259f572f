//! GPU time of each pass of a frame.

use std::sync::Arc;

use ash::vk;

use super::retired::Object;
use super::{Device, Named, Recorder};
use crate::Result;

/// Most passes that one frame can time.
const MAX_REGIONS: u32 = 16;

/// Begin and end of each named region of a command buffer, in device time.
pub struct Timestamps {
    pool: vk::QueryPool,
    regions: Vec<&'static str>,
    device: Arc<Device>,
}

impl Timestamps {
    /// Room for the passes of one frame.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 * MAX_REGIONS);
        // SAFETY: valid info; the value owns the handle.
        let pool = unsafe { device.raw.create_query_pool(&info, None) }
            .named("vkCreateQueryPool", "timestamps")?;
        device.name(pool, "timestamps");
        Ok(Self { pool, regions: Vec::new(), device: device.clone() })
    }

    /// Forgets the last frame. The frame must be done.
    pub fn reset(&mut self) {
        self.regions.clear();
        // SAFETY: the queries are not in use; hostQueryReset is enabled.
        unsafe { self.device.raw.reset_query_pool(self.pool, 0, 2 * MAX_REGIONS) };
    }

    /// Times what `record` records, and labels it for captures.
    ///
    /// # Panics
    /// With more regions a frame than there is room for: a mistake of the caller.
    pub fn time(&mut self, commands: Recorder<'_>, name: &'static str, record: impl FnOnce()) {
        let index = 2 * self.regions.len() as u32;
        assert!(index < 2 * MAX_REGIONS, "more than {MAX_REGIONS} timed passes");
        self.regions.push(name);
        self.device.begin_label(commands, name);
        self.write(commands, index);
        record();
        self.write(commands, index + 1);
        self.device.end_label(commands);
    }

    fn write(&self, commands: Recorder<'_>, index: u32) {
        if self.device.report.timestamp_bits > 0 {
            let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
            // SAFETY: the query was reset and is written once a frame.
            unsafe {
                self.device.raw.cmd_write_timestamp2(commands.raw(), stage, self.pool, index)
            };
        }
    }

    /// Whether a frame was recorded since it was made.
    pub fn is_used(&self) -> bool {
        !self.regions.is_empty()
    }

    /// Milliseconds of each region of the last frame, which must be done; empty where the queue
    /// has no timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if they cannot be read, as for a lost device.
    pub fn read_ms(&self) -> Result<Vec<(&'static str, f64)>> {
        let bits = self.device.report.timestamp_bits;
        if bits == 0 || self.regions.is_empty() {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0u64; 2 * self.regions.len()];
        // SAFETY: the frame is done, so every query asked for is available.
        unsafe {
            self.device.raw.get_query_pool_results(
                self.pool,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )
        }
        .named("vkGetQueryPoolResults", "timestamps")?;
        let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
        let period_ms = f64::from(self.device.report.limits.timestamp_period) * 1e-6;
        let ms = |pair: &[u64]| (pair[1].wrapping_sub(pair[0]) & mask) as f64 * period_ms;
        Ok(self.regions.iter().copied().zip(ticks.chunks_exact(2).map(ms)).collect())
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        self.device.retire([Object::QueryPool(self.pool)]);
    }
}
