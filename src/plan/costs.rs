//! What the parts of a frame on tiles take, and so what a frame of a scene would take.

use serde::{Deserialize, Serialize};

use super::demand::{Demand, SizeClass};

/// Nanoseconds, of one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// Whose they are, for whoever reads a reason.
    pub of: String,
    /// A pixel of the picture, with its share of what a frame takes in any case.
    pub pixel: f64,
    /// A drop, in view or not.
    pub drop: f64,
    /// A drop in view, drawn from its prefiltered picture.
    pub visible: f64,
    /// A pixel that a drop covers.
    pub covered: f64,
    /// What a drop whose rays are followed takes beyond those.
    pub large: f64,
    /// A fetch from the environment, with its share of a ray.
    pub fetch: f64,
}

impl Default for Costs {
    /// The costs of llvmpipe on two cores (docs/performance.md), for where no device has been measured.
    fn default() -> Self {
        Self {
            of: "two CPU cores, assumed: no device was measured".into(),
            pixel: 12.0,
            drop: 1.0,
            visible: 190.0,
            covered: 8.0,
            large: 400.0,
            fetch: 8.0,
        }
    }
}

/// What a model asks of a frame beyond the drops in view.
#[derive(Clone, Copy, Debug)]
pub struct Rays {
    /// Rays a pixel.
    pub samples: u32,
    /// Fetches a ray.
    pub fetches: u32,
}

impl Costs {
    /// Milliseconds of a frame that shows what `demand` says; `rays` tells for each class of drops what is
    /// followed through its pixels, if anything.
    pub fn frame_ms(&self, demand: &Demand, rays: impl Fn(&SizeClass) -> Option<Rays>) -> f64 {
        let of_class = |class: &SizeClass| {
            let covered = class.pixels * self.covered;
            let Some(Rays { samples, fetches }) = rays(class) else { return covered };
            let drops = class.pixels / (std::f64::consts::PI * class.radius_px.powi(2));
            // Rays are followed in whole tiles of 4 x 2 pixels.
            let (width, height) = (2.0 * class.radius_px + 4.0, 2.0 * class.radius_px + 2.0);
            let followed = (width * height).min(demand.pixels) * f64::from(samples * fetches);
            covered + drops * (self.large + followed * self.fetch)
        };
        let drops = self.drop * demand.drops + self.visible * demand.visible;
        let classes: f64 = demand.classes.iter().map(of_class).sum();
        1e-6 * (self.pixel * demand.pixels + drops + classes)
    }
}
