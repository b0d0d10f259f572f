//! What `compare-devices` found, as JSON of the schema `raindrops-compare-devices/1`.

use serde::{Deserialize, Serialize};

use super::Apart;
use crate::measure::bench::DeviceHead;
use crate::measure::verdict;

/// Name and version of the format.
pub const SCHEMA: &str = "raindrops-compare-devices/1";

/// One scene on several devices.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: String,
    /// What each device drew.
    pub devices: Vec<DeviceRow>,
    /// Any two of them, where the scene has stages.
    pub pairs: Vec<Pair>,
    /// Of each device but the first.
    #[serde(default)]
    pub verdicts: Vec<Compared>,
}

/// One device, its time and how far its picture is from the others'.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct DeviceRow {
    pub device: DeviceHead,
    /// Of its tone-mapped frame, over its rounds.
    pub median_ms: Option<f64>,
    /// Drops in view.
    pub visible: u64,
    /// To each device, in their order.
    pub flip: Vec<f64>,
    pub rel_mse: Vec<f64>,
    /// Where a truth was asked for.
    pub flip_to_truth: Option<f64>,
    pub rel_mse_to_truth: Option<f64>,
}

/// Two devices by their numbers, and how far the stages of their frames are apart.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pair {
    /// The earlier one.
    pub a: usize,
    /// The later one.
    pub b: usize,
    /// In the order of the frame.
    pub stages: Vec<Apart>,
}

/// A device's verdict against another.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Compared {
    /// What it is compared with: 0, the first.
    pub a: usize,
    /// The device.
    pub b: usize,
    /// The comparison.
    pub verdict: verdict::Report,
}
