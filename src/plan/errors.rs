//! The measured error of each way to draw a drop, by its radius in pixels.
//!
//! RMS of sRGB values inside the drop over the environment's contrast ([`super::contrast`]); medians
//! over eight photographed environments, made by `raindrops errors` (docs/method.md);
//! `tests/auto.rs` derives them anew under the bundled sky, within a factor of two.

/// Radii of the table's columns, in pixels.
pub const RADII_PX: [f64; 7] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0];

/// Error of finding a drop's light too coarsely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// By its prefiltered picture.
    Appearance,
    /// By one ray a pixel.
    Rays1,
    /// By four.
    Rays4,
    /// By sixteen.
    Rays16,
    /// By 64.
    Rays64,
}

/// Light that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// None that matters.
    Nothing,
    /// After two internal reflections and more.
    AllButOneInside,
    /// All internal reflections; the paper's weights.
    AllInside,
    /// The reflection on the outside.
    Reflection,
}

/// The table: names as `raindrops errors` has them, and a figure a radius.
pub const ERRORS: [(&str, [f64; 7]); 8] = [
    ("appearance (fast)", [0.379, 0.673, 0.376, 0.314, 0.283, 0.199, 0.118]),
    ("closed form, 1 rays", [0.210, 0.256, 0.306, 0.358, 0.246, 0.199, 0.118]),
    ("closed form, 4 rays", [0.223, 0.272, 0.224, 0.218, 0.161, 0.123, 0.075]),
    ("closed form, 16 rays", [0.143, 0.200, 0.148, 0.118, 0.097, 0.063, 0.048]),
    ("closed form, 64 rays", [0.192, 0.133, 0.083, 0.098, 0.051, 0.034, 0.035]),
    ("one internal reflection, converged", [0.008, 0.013, 0.018, 0.026, 0.038, 0.046, 0.071]),
    ("paper's weights, converged", [0.026, 0.047, 0.075, 0.121, 0.145, 0.168, 0.181]),
    ("no reflection, converged", [0.063, 0.148, 0.233, 0.289, 0.291, 0.313, 0.329]),
];

/// RMS error over contrast at a radius.
pub fn rms(error: Error, radius_px: f64) -> f64 {
    at(error as usize, radius_px)
}

impl Left {
    /// RMS error over contrast at a radius.
    pub fn rms(self, radius_px: f64) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::AllButOneInside => at(5, radius_px),
            Self::AllInside => at(6, radius_px),
            Self::Reflection => at(7, radius_px),
        }
    }
}

/// A row of the table between its columns, linear over the logarithm of the radius; beyond them its
/// ends.
fn at(row: usize, radius_px: f64) -> f64 {
    let figures = &ERRORS[row].1;
    let Some(above) = RADII_PX.iter().position(|&radius| radius >= radius_px) else {
        return figures[figures.len() - 1];
    };
    let Some(below) = above.checked_sub(1) else { return figures[0] };
    let share = (radius_px / RADII_PX[below]).ln() / (RADII_PX[above] / RADII_PX[below]).ln();
    figures[below] + (figures[above] - figures[below]) * share
}
