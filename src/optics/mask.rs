//! The geometry of the paper's mask: its levels, and the intersection that each texel stands for.

use glam::DVec3;

use super::{Intersection, WATER};

/// Half-angle of the mask's level `i`, in radians: atan(2^-i) (Table I).
pub fn level_half_angle(level: u32) -> f64 {
    (-f64::from(level)).exp2().atan()
}

/// Distance of the drop in the mask's level `i`, in radii: 1 / sin(half-angle) (Table I).
pub fn level_distance(level: u32) -> f64 {
    1.0 / level_half_angle(level).sin()
}

/// The intersection of the mask's texel (s, t) in [-1, 1]² of a level of the given half-angle, seen
/// in the pose of the preprocessing: eye at the origin, looking along -z, y up. Outside the unit
/// disc it is the intersection of the nearest point of the rim, so that filtering across the rim finds
/// unit vectors and reflectance 1 there instead of zeros.
pub fn mask_intersection(s: f64, t: f64, half_angle: f64) -> Intersection {
    let (sin_a, cos_a) = half_angle.sin_cos();
    let distance = s.hypot(t);
    let (radial_x, radial_y) =
        if distance > 0.0 { (s / distance, t / distance) } else { (1.0, 0.0) };
    let r = distance.min(1.0);
    // With θ the ray's angle to the axis, tan θ = r tan a; b = sin θ / sin a.
    let norm = (cos_a * cos_a + r * r * sin_a * sin_a).sqrt();
    let (sin_theta, cos_theta) = (r * sin_a / norm, cos_a / norm);
    Intersection {
        direction: DVec3::new(radial_x * sin_theta, radial_y * sin_theta, -cos_theta),
        offset: DVec3::new(radial_x * cos_theta, radial_y * cos_theta, sin_theta),
        impact_parameter: r / norm,
        // 1-b² written so that nothing cancels at the rim.
        cos_incidence: cos_a * ((1.0 - r) * (1.0 + r)).sqrt() / norm,
        index: WATER,
    }
}
