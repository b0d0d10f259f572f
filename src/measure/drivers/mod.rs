//! How the pictures of two drivers differ, and from which stage on.

mod report;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::picture::Picture;
use crate::picture::metrics::compare;
use crate::picture::tone_map::Exposure;
use crate::renderer::stages::Stages;

pub use report::{Compared, DeviceRow, Pair, Report, SCHEMA};

/// Part of the pixels that may be off by more than rounding before a stage is said to differ: points
/// that fall between two pixels may go either way.
pub const FEW: f64 = 1e-3;

/// How far two drivers are apart at one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Apart {
    /// Name of the stage.
    pub stage: Cow<'static, str>,
    /// Unit of the errors.
    pub unit: Cow<'static, str>,
    /// More than rounding.
    pub tolerance: f64,
    /// Part of what was compared that is off by more, or that one of the two has alone.
    pub share: f64,
    /// Part of what was compared that one of the two has alone: there is nothing to be off by.
    #[serde(default)]
    pub alone: f64,
    /// Largest difference, where both have something.
    #[serde(deserialize_with = "report::number")]
    pub largest: f64,
}

impl Apart {
    fn of(
        stage: &'static str,
        unit: &'static str,
        tolerance: f64,
        errors: impl Iterator<Item = Option<f64>>,
    ) -> Self {
        let (mut compared, mut off, mut alone, mut largest) = (0u64, 0u64, 0u64, 0.0f64);
        for error in errors {
            compared += 1;
            alone += u64::from(error.is_none());
            off += u64::from(error.is_none_or(|error| error > tolerance));
            largest = largest.max(error.unwrap_or(0.0));
        }
        let share = |count: u64| count as f64 / compared.max(1) as f64;
        let (stage, unit) = (stage.into(), unit.into());
        Self { stage, unit, tolerance, share: share(off), alone: share(alone), largest }
    }

    /// Whether anything at all is off by more than rounding.
    pub fn strays(&self) -> bool {
        self.share > 0.0
    }

    /// Whether more than few are off.
    pub fn differs(&self) -> bool {
        self.share > FEW
    }
}

/// A stage of [`Stages::pictures`]: name, unit, more than rounding, error of a pixel.
type Measure = (&'static str, &'static str, f64, fn(&[f32; 4], &[f32; 4]) -> f64);

const MEASURES: [Measure; 3] = [
    ("footprint", "px", 1.0 / 128.0, |a, b| distance(a, b, 2)),
    ("direction", "degrees", 0.05, |a, b| distance(a, b, 3).to_degrees()),
    ("radiance", "relative", 0.01, |a, b| {
        (0..3).map(|i| relative((a[i] - b[i]).abs(), a[i].max(b[i]))).fold(0.0, f64::max)
    }),
];

fn distance(a: &[f32; 4], b: &[f32; 4], count: usize) -> f64 {
    (0..count).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn relative(error: f32, value: f32) -> f64 {
    f64::from(error) / f64::from(value).max(1e-9)
}

/// Two drivers' frames by the paper's model stage by stage, in the order of the frame; of the stages of
/// a drop's pixels, each over those that agreed so far.
pub fn apart(a: (&Stages, &Picture), b: (&Stages, &Picture)) -> Vec<Apart> {
    let bits = |record: &[f32; 4]| record.map(f32::to_bits);
    let pairs = a.0.drops.iter().zip(&b.0.drops);
    let positions = pairs
        // Drops over the point limit, which differs, go another way.
        .filter(|(a, b)| a[3] > 0.0 && b[3] > 0.0)
        .map(|(a, b)| Some(if bits(a) == bits(b) { 0.0 } else { 1.0 }));
    let mut found = vec![Apart::of("positions", "bits", 0.0, positions)];
    let mut agrees = vec![true; a.0.pictures[0].len()];
    for (number, (name, unit, tolerance, error)) in MEASURES.into_iter().enumerate() {
        let (a, b) = (&a.0.pictures[number], &b.0.pictures[number]);
        let errors: Vec<Option<Option<f64>>> = (0..agrees.len())
            .map(|at| match (agrees[at], a[at][3] > 0.0, b[at][3] > 0.0) {
                (false, ..) | (_, false, false) => None,
                (_, true, true) => Some(Some(error(&a[at], &b[at]))),
                _ => Some(None),
            })
            .collect();
        found.push(Apart::of(name, unit, tolerance, errors.iter().copied().flatten()));
        for (agrees, error) in agrees.iter_mut().zip(&errors) {
            *agrees &= matches!(error, Some(Some(error)) if *error <= tolerance);
        }
    }
    let colors = a.1.pixels.iter().zip(&b.1.pixels).map(|(a, b)| {
        Some(relative((*a - *b).abs().max_element(), a.max_element().max(b.max_element())))
    });
    found.push(Apart::of("blend", "relative", 0.01, colors));
    found
}

/// FLIP and relMSE of two drivers' pictures, the first setting the exposure.
pub fn difference(a: &Picture, b: &Picture, exposure: Exposure) -> (f64, f64) {
    let found = compare(a, b, None, exposure).pixels;
    (found.flip, found.rel_mse)
}
