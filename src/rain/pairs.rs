//! Numbers as sums of two float32, of which the second is at most half a unit in the last place of the first (double-float
//! arithmetic, Dekker, *A floating-point technique for extending the available precision*, 1971): 48 bits, by operations
//! that all devices round alike. The same as `glsl/include/pairs.glsl`, bit for bit.
//!
//! A placed drop that moves is carried along by them in every frame, on the device, exactly however far the scene's time is.

use bytemuck::Zeroable as _;
use glam::{DVec3, Vec3};

use crate::abi::PlacedPush;
use crate::rain::cull::split;
use crate::scene::{PlacedDrop, Scene};

/// Three such numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The first parts.
    pub high: Vec3,
    /// What those lack.
    pub low: Vec3,
}

impl From<DVec3> for Pair {
    fn from(v: DVec3) -> Self {
        let [high, low] = split(v);
        Self { high, low }
    }
}

impl Pair {
    /// The sum of two of which the first is larger, or 0.
    fn of_sum(large: Vec3, small: Vec3) -> Self {
        let high = large + small;
        Self { high, low: small - (high - large) }
    }

    fn plus(self, other: Self) -> Self {
        // Knuth's sum of two, which loses nothing.
        let sum = self.high + other.high;
        let added = sum - self.high;
        let lost = (self.high - (sum - added)) + (other.high - added);
        Self::of_sum(sum, lost + (self.low + other.low))
    }

    fn times(self, factor: [f32; 2]) -> Self {
        let (first, of_factor) = (self.high.map(first_bits), first_bits(factor[0]));
        let product = self.high * factor[0];
        let (rest, rest_of_factor) = (self.high - first, factor[0] - of_factor);
        let lost = ((first * of_factor - product) + first * rest_of_factor + rest * of_factor)
            + rest * rest_of_factor;
        Self::of_sum(product, lost + (self.high * factor[1] + self.low * factor[0]))
    }
}

/// The first twelve bits.
fn first_bits(v: f32) -> f32 {
    f32::from_bits(v.to_bits() & 0xffff_f000)
}

/// What a frame's pass needs to carry placed drops along (`glsl/placed.comp`); without the places of what it reads and writes.
pub fn moment(scene: &Scene) -> PlacedPush {
    let pair = |seconds: f64| split(DVec3::splat(seconds)).map(|part| part.x);
    let camera = scene.drawn_motion_of(DVec3::ZERO);
    let parts = |v: DVec3| split(v).map(|part| part.to_array());
    let ([before_high, before_low], [camera_high, camera_low]) =
        (parts(0.5 * camera), parts(camera));
    PlacedPush {
        moved: pair(scene.drawn_time()),
        exposed: pair(scene.drawn_exposure()),
        before_high,
        before_low,
        camera_high,
        camera_low,
        ..PlacedPush::zeroed()
    }
}

/// Where a drop is at a moment, in the middle of what is exposed, less what the camera has moved by then; and how far it moves
/// meanwhile, as the camera sees it.
pub fn carried(drop: &PlacedDrop, moment: &PlacedPush) -> (Pair, Vec3) {
    let pair = |high: [f32; 3], low: [f32; 3]| Pair { high: high.into(), low: low.into() };
    let velocity = Pair::from(drop.velocity);
    let moved = Pair::from(drop.center).plus(velocity.times(moment.moved));
    let center = moved.plus(pair(moment.before_high, moment.before_low));
    let motion = velocity.times(moment.exposed).plus(pair(moment.camera_high, moment.camera_low));
    (center, motion.high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Off by at most 2^-44 of the larger of the two, or of their product.
    #[test]
    fn sums_and_products_have_48_bits() {
        let of = |pair: Pair| pair.high.as_dvec3() + pair.low.as_dvec3();
        for number in 1..2000_u32 {
            let part = |k: u32| f64::from(number.wrapping_mul(k) % 100_003) - 50_001.3;
            let (a, b) = (DVec3::new(part(7919), part(31), part(101)), part(65_537) / 977.0);
            let other = DVec3::new(-a.x * (1.0 - 1e-9), part(17) * 1e6, part(3) * 1e-6);
            let factor = split(DVec3::splat(b)).map(|part| part.x);
            let product = of(Pair::from(a).times(factor)) - a * b;
            assert!(
                product.abs().cmple((a * b).abs() * 2f64.powi(-44)).all(),
                "{a} {b}: {product}"
            );
            let sum = of(Pair::from(a).plus(other.into())) - (a + other);
            assert!(
                sum.abs().cmple(a.abs().max(other.abs()) * 2f64.powi(-44)).all(),
                "{a} {other}: {sum}"
            );
        }
    }
}
