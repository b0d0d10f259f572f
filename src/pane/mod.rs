//! Rain on a pane: how drops arrive on glass, merge, slide and leave, in metres and seconds.
//!
//! - `retention.rs`: which drops gravity pulls down.
//! - `arrivals.rs`: when which drop falls where.
//! - `population.rs`: the drops that are there after some time.
//! - `discs.rs`: their contact discs, found by place.
//! - `keyframes.rs`: the drops at any time, also before the last that was asked for.
//!
//! **The same drops on every machine.** Arrivals are hashes of their number. What libraries may compute differently in the
//! last digit (exponentials, angles) is rounded to 40 bits once (`settled`); from there on there are only sums, products,
//! quotients and square roots of float64 in a fixed order.

pub mod arrivals;
mod discs;
pub mod keyframes;
pub mod population;
pub mod retention;

use glam::DVec2;

/// A drop on the pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resting {
    /// Middle of its contact disc, in metres along the pane's u and v.
    pub at: DVec2,
    /// Radius of its contact disc, m.
    pub radius: f64,
    /// Its contact angle, degrees.
    pub angle: f64,
    /// Its volume, m³.
    pub volume: f64,
}

/// A number without its last 12 binary digits.
pub(crate) fn settled(value: f64) -> f64 {
    const LOST: u64 = 1 << 12;
    if !value.is_finite() {
        return value;
    }
    f64::from_bits((value.to_bits() + LOST / 2) & !(LOST - 1))
}

/// The cube root of a number over 0, by Halley's steps from a guess that is right to a few percent.
pub(crate) fn cube_root(value: f64) -> f64 {
    // A third of the bits is a third of the exponent; the constant puts its bias back.
    let mut root = f64::from_bits(value.to_bits() / 3 + 0x2a9f_7893_782d_a1ce);
    for _ in 0..4 {
        let cube = root * root * root;
        root *= (cube + 2.0 * value) / (2.0 * cube + value);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_right_to_the_last_digits() {
        for exponent in -60..60 {
            let value = 1.37_f64.powi(exponent) * 1e-9;
            let root = cube_root(value);
            assert!((root.powi(3) / value - 1.0).abs() < 1e-14, "{value}: {root}");
        }
    }

    #[test]
    fn the_last_digits_are_forgotten_and_no_others() {
        let value = 0.123_456_789_012_345_6;
        assert_eq!(settled(value), settled(f64::from_bits(value.to_bits() + 1)));
        assert!((settled(value) / value - 1.0).abs() < 1e-12);
        assert_ne!(settled(value), settled(value * (1.0 + 1e-11)));
    }
}
