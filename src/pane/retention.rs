//! Which drops gravity pulls down: Furmidge's balance of weight along the pane and of what holds the drop's rim.
//!
//! ρ g V sin α = k w γ (cos θr - cos θa), with w = 2a the drop's width. k is π/4 for a round rim of first order, 0.774 as
//! ElSherbini and Jacobi fitted it, and 1 for a rim that has become long; here 1.

use super::{cube_root, settled};
use crate::optics::Cap;

/// Surface tension of water at 20 °C, N/m.
pub const TENSION: f64 = 0.0728;

/// Density of water at 20 °C, kg/m³.
pub const DENSITY: f64 = 998.2;

/// m/s².
pub const GRAVITY: f64 = 9.81;

/// What holds drops on a pane, and what pulls them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retention {
    /// Force that holds a drop, over its contact radius, N/m.
    hold: f64,
    /// Force that pulls it, over its volume, N/m³.
    pull: f64,
}

impl Retention {
    /// On a pane at an angle with this sine from level, by the advancing and receding contact angles in degrees.
    pub fn new(slope_sine: f64, [advancing, receding]: [f64; 2]) -> Self {
        let difference = receding.to_radians().cos() - advancing.to_radians().cos();
        Self {
            hold: settled(2.0 * TENSION * difference),
            pull: settled(DENSITY * GRAVITY * slope_sine),
        }
    }

    /// Whether a drop of this volume and contact radius slides.
    pub fn slides(&self, volume: f64, radius: f64) -> bool {
        self.pull * volume > self.hold * radius
    }

    /// The volume in m³ from which on caps of this contact angle slide; infinite on a level pane.
    pub fn critical_volume(&self, angle: f64) -> f64 {
        // V over the cube root of V's a: V^(2/3) = hold A / pull, A = a / V^(1/3).
        let spread = 1.0 / cube_root(Cap::volume_factor(angle));
        let power = self.hold * spread / self.pull;
        power * power.sqrt()
    }
}

/// By how many degrees the contact angle is larger in front and smaller behind, where a round rim holds a drop on a pane at
/// an angle with this sine from level; radius in metres (De Coninck et al. 2016, first order).
pub fn lean(cap: &Cap, slope_sine: f64) -> f64 {
    let held = std::f64::consts::PI * TENSION * cap.radius * cap.angle.to_radians().sin();
    (DENSITY * GRAVITY * cap.volume() * slope_sine / held).to_degrees()
}
