//! The measured error of each way to draw a drop, by its radius in pixels.
//!
//! RMS of sRGB values inside the drop over the environment's contrast ([`super::contrast`]); medians
//! over eight photographed environments, made by `raindrops errors` (docs/auto.md). `tests/drawn/auto.rs`
//! measures them anew under the bundled sky at three radii; each model's mean ratio to the tables must be
//! 0.4 to 2.5, for one sky is not eight photographs.
//!
//! A second table holds what glints add under a sky with a bare sun, made by `raindrops errors --glints`
//! under the bundled sky and measured anew by another test there, at one radius within the same bounds.
//! Their squared error goes with the light of the bright parts over that of the rest
//! ([`crate::environment::bright::Bright::strength`]): from 0.02 to 1.4 in five photographs the figures over
//! its root are those of the bundled sky within a factor of two on the mean, in one, of lights between
//! leaves, of three. What the photographs' own bright parts add is in the first table too, and counts twice.

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
    ("appearance (fast)", [0.140, 0.144, 0.144, 0.106, 0.129, 0.176, 0.098]),
    ("closed form, 1 ray", [0.170, 0.185, 0.211, 0.311, 0.236, 0.176, 0.098]),
    ("closed form, 4 rays", [0.148, 0.247, 0.185, 0.190, 0.142, 0.113, 0.066]),
    ("closed form, 16 rays", [0.061, 0.083, 0.111, 0.091, 0.082, 0.063, 0.051]),
    ("closed form, 64 rays", [0.033, 0.051, 0.062, 0.046, 0.038, 0.034, 0.041]),
    ("one internal reflection, converged", [0.009, 0.013, 0.019, 0.028, 0.037, 0.046, 0.070]),
    ("paper's weights, converged", [0.029, 0.046, 0.074, 0.120, 0.145, 0.168, 0.181]),
    ("no reflection, converged", [0.083, 0.159, 0.229, 0.291, 0.292, 0.313, 0.329]),
];

/// Radii of the second table's columns, in pixels. Glints are so bright that they are seen in far smaller
/// drops than anything else.
pub const GLINT_RADII_PX: [f64; 9] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0];

/// What glints add: names as in [`ERRORS`]; RMS over the drops' area and the root of the bright parts'
/// light.
pub const GLINTS: [(&str, [f64; 9]); 8] = [
    ("appearance (fast)", [0.002, 0.001, 0.000, 0.000, 0.028, 0.021, 0.018, 0.015, 0.008]),
    ("closed form, 1 ray", [0.028, 0.004, 0.000, 0.019, 0.028, 0.021, 0.019, 0.015, 0.008]),
    ("closed form, 4 rays", [0.030, 0.000, 0.000, 0.022, 0.027, 0.021, 0.018, 0.015, 0.007]),
    ("closed form, 16 rays", [0.029, 0.004, 0.000, 0.021, 0.027, 0.021, 0.018, 0.015, 0.008]),
    ("closed form, 64 rays", [0.028, 0.005, 0.003, 0.022, 0.027, 0.021, 0.018, 0.015, 0.008]),
    (
        "one internal reflection, converged",
        [0.001, 0.002, 0.005, 0.007, 0.012, 0.015, 0.015, 0.013, 0.008],
    ),
    ("paper's weights, converged", [0.010, 0.019, 0.032, 0.036, 0.034, 0.033, 0.024, 0.018, 0.010]),
    ("no reflection, converged", [0.004, 0.009, 0.015, 0.028, 0.035, 0.041, 0.032, 0.021, 0.010]),
];

/// What is wrong with a drop of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// RMS error over contrast.
    pub of_contrast: f64,
    /// RMS error by glints, over the root of the bright parts' light.
    pub of_glints: f64,
}

/// Both errors of finding light coarsely and leaving some out, at a radius. Below the first column of the
/// first table errors fall with the radius: the square over a drop's pixels goes with its share of them.
pub fn expected(error: Error, left: Left, radius_px: f64) -> Expected {
    let both = |at: &dyn Fn(usize) -> f64| at(error as usize).hypot(left.row().map_or(0.0, at));
    let small = (radius_px / RADII_PX[0]).min(1.0);
    Expected {
        of_contrast: small * both(&|row| between(&RADII_PX, &ERRORS[row].1, radius_px)),
        of_glints: both(&|row| between(&GLINT_RADII_PX, &GLINTS[row].1, radius_px)),
    }
}

impl Left {
    /// Error by what is left out alone, over contrast.
    pub fn of_contrast(self, radius_px: f64) -> f64 {
        self.row().map_or(0.0, |row| between(&RADII_PX, &ERRORS[row].1, radius_px))
    }

    /// The tables' row; none where nothing is left out.
    fn row(self) -> Option<usize> {
        match self {
            Self::Nothing => None,
            Self::AllButOneInside => Some(5),
            Self::AllInside => Some(6),
            Self::Reflection => Some(7),
        }
    }
}

/// A table's row between its columns, linear over the logarithm of the radius; beyond them its ends.
fn between(radii_px: &[f64], figures: &[f64], radius_px: f64) -> f64 {
    let Some(above) = radii_px.iter().position(|&radius| radius >= radius_px) else {
        return figures[figures.len() - 1];
    };
    let Some(below) = above.checked_sub(1) else { return figures[0] };
    let share = (radius_px / radii_px[below]).ln() / (radii_px[above] / radii_px[below]).ln();
    figures[below] + (figures[above] - figures[below]) * share
}
