//! A spherical drop in closed form. `glsl/include/optics.glsl` has the same in float32.
//!
//! A ray of unit direction `D` passes the centre at distance `b` (the *impact parameter*, in radii);
//! `e` is the unit vector from the centre to the ray, perpendicular to `D`. Everything happens in the
//! plane of `D` and `e`, so two cosines tell all: no ray is intersected. A ray that got in always gets
//! out, because both ends of a chord have the same angle; total reflection exists on the outside alone,
//! where the index is under 1 (a bubble).
//!
//! Closed forms checked in `tests/physics/optics.rs` against two explicit refractions.

use glam::DVec3;

use super::{WATER, fresnel};

/// A ray that meets a drop, reduced to what the optics depend on.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// The ray's unit direction.
    pub direction: DVec3,
    /// Unit vector from the drop's centre to the ray, perpendicular to `direction`. For a ray
    /// through the centre any perpendicular serves: every deviation there is along `direction`.
    pub offset: DVec3,
    /// Impact parameter, 0 at the middle, 1 at the rim.
    pub impact_parameter: f64,
    /// Cosine of the incidence angle, √(1-b²).
    pub cos_incidence: f64,
    /// Refractive index inside the drop over that outside.
    pub index: f64,
}

impl Intersection {
    /// The intersection of a ray that starts at the origin with a sphere; `None` if the ray's line
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
        Some(Self { direction, offset, impact_parameter, cos_incidence, index: WATER })
    }

    /// This ray and sphere, with another refractive index.
    pub fn with_index(self, index: f64) -> Self {
        Self { index, ..self }
    }

    /// Cosine of the refraction angle θt inside the drop; sin θt = b/n. 0 under total reflection, which a
    /// bubble shows from b = n on.
    pub fn cos_refraction(&self) -> f64 {
        let sine = self.impact_parameter / self.index;
        (1.0 - sine * sine).max(0.0).sqrt()
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
        let st = b / self.index;
        // Half of 2(θi-θt): cos and sin of θi-θt, then the double angle.
        let (c, s) = (ci * ct + b * st, b * ct - ci * st);
        let (mut cosine, mut sine) = (c * c - s * s, 2.0 * c * s);
        let (turn_cosine, turn_sine) = self.turn();
        for _ in 0..k {
            (cosine, sine) =
                (cosine * turn_cosine - sine * turn_sine, sine * turn_cosine + cosine * turn_sine);
        }
        (cosine, sine)
    }

    /// Outward normal where the light leaves after `k` internal reflections: each of the k + 1 chords turns
    /// the normal in the plane of the ray, towards and past the centre.
    pub fn exit_normal(&self, k: u32) -> DVec3 {
        let (turn_cosine, turn_sine) = self.turn();
        let (mut along, mut across) = (-self.cos_incidence, self.impact_parameter);
        for _ in 0..=k {
            (along, across) = (
                along * turn_cosine + across * turn_sine,
                across * turn_cosine - along * turn_sine,
            );
        }
        along * self.direction + across * self.offset
    }

    /// Cosine and sine of π-2θt, by which each internal reflection turns.
    fn turn(&self) -> (f64, f64) {
        let (st, ct) = (self.impact_parameter / self.index, self.cos_refraction());
        (st * st - ct * ct, 2.0 * st * ct)
    }

    /// Fresnel reflectance of the interface for unpolarised light, the same going in and out.
    pub fn reflectance(&self) -> f64 {
        fresnel(self.cos_incidence, self.cos_refraction(), self.index)
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
