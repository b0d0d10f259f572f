//! One drop in float64: the physics, told once. `glsl/include/optics.glsl` is its float32 twin.
//!
//! A drop is a sphere of water. A ray of unit direction `D` passes its centre at distance `b` (the
//! *impact parameter*, in radii); `e` is the unit vector from the centre to the ray, perpendicular
//! to `D`. Everything happens in the plane of `D` and `e`, so two cosines tell all: no ray is
//! intersected and no refraction can fail (a ray that got into a sphere always gets out).
//!
//! Closed forms checked in `tests/optics.rs` against two explicit refractions.

use glam::DVec3;

/// Refractive index of water at 589 nm over that of air, as the paper has it.
pub const WATER: f64 = 1.33;

/// A ray that meets a drop, reduced to what the optics depend on.
#[derive(Clone, Copy, Debug)]
pub struct Encounter {
    /// The ray's unit direction.
    pub direction: DVec3,
    /// Unit vector from the drop's centre to the ray, perpendicular to `direction`. For a ray
    /// through the centre any perpendicular serves: every deviation there is along `direction`.
    pub offset: DVec3,
    /// Impact parameter, 0 at the middle, 1 at the rim.
    pub impact_parameter: f64,
    /// Cosine of the incidence angle, √(1-b²).
    pub cos_incidence: f64,
}

impl Encounter {
    /// The encounter of a ray that starts at the origin with a sphere; `None` if the ray's line
    /// misses the sphere or the sphere is behind the origin. The origin must be outside the sphere.
    pub fn of_ray(direction: DVec3, center: DVec3, radius: f64) -> Option<Self> {
        let along = center.dot(direction);
        // The cross product keeps its precision at the rim, where distance² - along² cancels.
        let to_ray = direction.cross(center).cross(direction) / -radius;
        let impact_parameter = to_ray.length();
        if along <= 0.0 || impact_parameter > 1.0 {
            return None;
        }
        let offset = if impact_parameter > 0.0 {
            to_ray / impact_parameter
        } else {
            direction.any_orthonormal_vector()
        };
        let cos_incidence = (1.0 - impact_parameter * impact_parameter).sqrt();
        Some(Self { direction, offset, impact_parameter, cos_incidence })
    }

    /// Cosine of the refraction angle θt inside the water; sin θt = b/n.
    pub fn cos_refraction(&self) -> f64 {
        let sine = self.impact_parameter / WATER;
        (1.0 - sine * sine).sqrt()
    }

    /// The outward normal where the ray meets the drop.
    pub fn normal(&self) -> DVec3 {
        self.impact_parameter * self.offset - self.cos_incidence * self.direction
    }

    /// Direction after reflection on the outside: `R = (1-2ci²) D + 2 b ci e`.
    pub fn reflected(&self) -> DVec3 {
        let (b, ci) = (self.impact_parameter, self.cos_incidence);
        (1.0 - 2.0 * ci * ci) * self.direction + 2.0 * b * ci * self.offset
    }

    /// Direction after refraction in and out, the paper's "refraction": deviated by
    /// `δ = 2(θi-θt)` towards the centre; `T = cos δ D - sin δ e`.
    pub fn transmitted(&self) -> DVec3 {
        self.after_internal_reflections(0)
    }

    /// Direction after `k` reflections inside and two refractions: total deviation
    /// `2(θi-θt) + k(π-2θt)` towards the centre. k = 1 is the rainbow.
    pub fn after_internal_reflections(&self, k: u32) -> DVec3 {
        let (cosine, sine) = self.deviation(k);
        cosine * self.direction - sine * self.offset
    }

    /// Cosine and sine of the total deviation after `k` internal reflections, without trigonometry.
    pub fn deviation(&self, k: u32) -> (f64, f64) {
        let (b, ci, ct) = (self.impact_parameter, self.cos_incidence, self.cos_refraction());
        let st = b / WATER;
        // Half of 2(θi-θt): cos and sin of θi-θt, then the double angle.
        let (c, s) = (ci * ct + b * st, b * ct - ci * st);
        let (mut cosine, mut sine) = (c * c - s * s, 2.0 * c * s);
        // Each internal reflection turns by π-2θt.
        let (turn_cosine, turn_sine) = (st * st - ct * ct, 2.0 * st * ct);
        for _ in 0..k {
            (cosine, sine) =
                (cosine * turn_cosine - sine * turn_sine, sine * turn_cosine + cosine * turn_sine);
        }
        (cosine, sine)
    }

    /// Fresnel reflectance of the interface for unpolarised light, the same going in and out.
    pub fn reflectance(&self) -> f64 {
        fresnel(self.cos_incidence, self.cos_refraction())
    }

    /// Share of the radiance that arrives by `k` internal reflections: `(1-F)² F^k`.
    pub fn weight_of_internal_reflections(&self, k: u32) -> f64 {
        let reflectance = self.reflectance();
        (1.0 - reflectance).powi(2) * reflectance.powi(k as i32)
    }

    /// Share of the radiance that arrives by more than `k` internal reflections, all together:
    /// `Σ (1-F)² F^j` over j > k, which is `(1-F) F^(k+1)`.
    pub fn weight_beyond_internal_reflections(&self, k: u32) -> f64 {
        let reflectance = self.reflectance();
        (1.0 - reflectance) * reflectance.powi(k as i32 + 1)
    }
}

/// Exact Fresnel reflectance of the water surface for unpolarised light, from the cosines of
/// incidence and refraction.
pub fn fresnel(cos_incidence: f64, cos_refraction: f64) -> f64 {
    let (ci, ct) = (cos_incidence, cos_refraction);
    let s = (ci - WATER * ct) / (ci + WATER * ct);
    let p = (WATER * ci - ct) / (WATER * ci + ct);
    0.5 * (s * s + p * p)
}

/// Schlick's approximation (1994) of [`fresnel`] from the cosine of incidence; off by 0.06 at most.
pub fn schlick(cos_incidence: f64) -> f64 {
    let normal = ((WATER - 1.0) / (WATER + 1.0)).powi(2);
    normal + (1.0 - normal) * (1.0 - cos_incidence).powi(5)
}

/// Half-angle of the mask's level `i`, in radians: atan(2^-i) (Table I).
pub fn level_half_angle(level: u32) -> f64 {
    (-f64::from(level)).exp2().atan()
}

/// Distance of the drop in the mask's level `i`, in radii: 1 / sin(half-angle) (Table I).
pub fn level_distance(level: u32) -> f64 {
    1.0 / level_half_angle(level).sin()
}

/// The mask level that stands for a drop at `distance` radii: -log2(tan a) with sin a = 1/distance.
/// Fractional between levels, negative nearer than √2 radii.
pub fn level_of_distance(distance: f64) -> f64 {
    0.5 * (distance * distance - 1.0).log2()
}

/// The encounter of the mask's texel (s, t) in [-1, 1]² of a level of the given half-angle, seen
/// in the pose of the preprocessing: eye at the origin, looking along -z, y up. Outside the unit
/// disc it is the encounter of the nearest point of the rim, so that filtering across the rim finds
/// unit vectors and reflectance 1 there instead of zeros.
pub fn mask_encounter(s: f64, t: f64, half_angle: f64) -> Encounter {
    let (sin_a, cos_a) = half_angle.sin_cos();
    let distance = s.hypot(t);
    let (radial_x, radial_y) =
        if distance > 0.0 { (s / distance, t / distance) } else { (1.0, 0.0) };
    let r = distance.min(1.0);
    // With θ the ray's angle to the axis, tan θ = r tan a; b = sin θ / sin a.
    let norm = (cos_a * cos_a + r * r * sin_a * sin_a).sqrt();
    let (sin_theta, cos_theta) = (r * sin_a / norm, cos_a / norm);
    Encounter {
        direction: DVec3::new(radial_x * sin_theta, radial_y * sin_theta, -cos_theta),
        offset: DVec3::new(radial_x * cos_theta, radial_y * cos_theta, sin_theta),
        impact_parameter: r / norm,
        // 1-b² written so that nothing cancels at the rim.
        cos_incidence: cos_a * ((1.0 - r) * (1.0 + r)).sqrt() / norm,
    }
}
