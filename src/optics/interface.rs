//! What a piece of the surface between two substances does to a ray: Snell's law and Fresnel's.

use glam::DVec3;

use super::WATER;

/// A ray at the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Unit direction after reflection.
    pub reflected: DVec3,
    /// Unit direction after refraction; `None` under total reflection.
    pub refracted: Option<DVec3>,
    /// Share of the radiance that is reflected, for unpolarised light; 1 under total reflection.
    pub reflectance: f64,
}

impl Interface {
    /// A ray of unit `direction` against the unit `normal` on its own side; `index` is that of the
    /// substance beyond the surface over that of the one before it.
    pub fn meet(direction: DVec3, normal: DVec3, index: f64) -> Self {
        let cos_incidence = -direction.dot(normal);
        let sine2 = (1.0 - cos_incidence * cos_incidence).max(0.0) / (index * index);
        let reflected = direction + 2.0 * cos_incidence * normal;
        if sine2 >= 1.0 {
            return Self { reflected, refracted: None, reflectance: 1.0 };
        }
        let cos_refraction = (1.0 - sine2).sqrt();
        let bent = direction / index + (cos_incidence / index - cos_refraction) * normal;
        let reflectance = fresnel(cos_incidence, cos_refraction, index);
        Self { reflected, refracted: Some(bent), reflectance }
    }
}

/// Exact Fresnel reflectance for unpolarised light, from the cosines of incidence and refraction and
/// the index beyond the surface over that before it. A cosine of refraction of 0 is total reflection.
pub fn fresnel(cos_incidence: f64, cos_refraction: f64, index: f64) -> f64 {
    let (ci, ct) = (cos_incidence, cos_refraction);
    if ct <= 0.0 {
        return 1.0;
    }
    let s = (ci - index * ct) / (ci + index * ct);
    let p = (index * ci - ct) / (index * ci + ct);
    0.5 * (s * s + p * p)
}

/// Schlick's approximation (1994) of [`fresnel`] for water from the cosine of incidence; off by 0.06 at
/// most.
pub fn schlick(cos_incidence: f64) -> f64 {
    let normal = ((WATER - 1.0) / (WATER + 1.0)).powi(2);
    normal + (1.0 - normal) * (1.0 - cos_incidence).powi(5)
}
