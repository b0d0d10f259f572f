//! What `compare-devices` found, as JSON of the schema `raindrops-compare-devices/1`.

use serde::{Deserialize, Deserializer, Serialize};

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
    /// One verdict for each device but the first.
    #[serde(default)]
    pub verdicts: Vec<Compared>,
}

/// One device, its time and how far its picture is from the others'.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys of the result file, see docs/result-files.md")]
pub struct DeviceRow {
    pub device: DeviceHead,
    /// Median time of its tone-mapped frame over its rounds.
    pub median_ms: Option<f64>,
    /// Drops in view.
    pub visible: u64,
    /// To each device, in their order.
    #[serde(deserialize_with = "all_numbers")]
    pub flip: Vec<f64>,
    #[serde(deserialize_with = "all_numbers")]
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

impl Report {
    /// The largest mean FLIP between any two devices.
    pub fn largest_flip(&self) -> f64 {
        self.devices.iter().flat_map(|row| &row.flip).copied().fold(0.0, f64::max)
    }
}

/// JSON has no infinity: of a picture with NaN an error is written as `null`.
pub(super) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

fn all_numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let all = Vec::<Option<f64>>::deserialize(from)?;
    Ok(all.into_iter().map(|number| number.unwrap_or(f64::INFINITY)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_broken_driver_drew_can_be_read_again() {
        let device = serde_json::json!({"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"});
        let device: DeviceHead = serde_json::from_value(device).expect("a device");
        let apart = Apart {
            stage: "blend".into(),
            unit: "relative".into(),
            tolerance: 0.01,
            share: 1.0,
            alone: 0.0,
            largest: f64::INFINITY,
        };
        let row = DeviceRow {
            device,
            median_ms: None,
            visible: 1,
            flip: vec![0.0, 0.25],
            rel_mse: vec![0.0, f64::INFINITY],
            flip_to_truth: None,
            rel_mse_to_truth: None,
        };
        let pairs = vec![Pair { a: 0, b: 1, stages: vec![apart] }];
        let report = Report { schema: SCHEMA.into(), devices: vec![row], pairs, verdicts: vec![] };
        let text = serde_json::to_string(&report).expect("JSON");
        let read: Report = serde_json::from_str(&text).expect("a report");
        assert_eq!(read.devices[0].rel_mse, report.devices[0].rel_mse);
        assert_eq!(read.pairs[0].stages, report.pairs[0].stages);
        assert_eq!(read.largest_flip(), 0.25);
    }
}
