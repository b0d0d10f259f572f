//! A drop on glass: a cap of a sphere. Its geometry, and where light goes that leaves it at its first meeting with the cap.
//!
//! Coordinates are (u, v, n): the first two in the plane that the drop stands on, the third out of it, from the middle of the
//! disc on which water touches glass. The glass does not bend a picture: a ray's part along the pane is the same in air,
//! glass and water. So the direction seen through a drop needs no index of the glass.

use std::f64::consts::PI;

use glam::DVec3;

use super::fresnel;

/// A cap by its contact radius and its contact angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// Radius of the disc on which water touches glass.
    pub radius: f64,
    /// Angle between glass and surface, measured through the water, in degrees.
    pub angle: f64,
}

/// Light that leaves a cap at the place where it meets it first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstExit {
    /// Unit direction in air.
    pub direction: DVec3,
    /// Share of the radiance: (1-F) of air to glass, of glass to water and of water to air.
    pub weight: f64,
}

impl Cap {
    /// Volume over the cube of the contact radius.
    pub fn volume_factor(angle: f64) -> f64 {
        // With t = h / a = tan(θ/2): V = π h (3 a² + h²) / 6, which does not cancel for flat drops.
        let t = (0.5 * angle.to_radians()).tan();
        PI / 6.0 * t * (3.0 + t * t)
    }

    /// The cap of some volume.
    pub fn of_volume(volume: f64, angle: f64) -> Self {
        Self { radius: (volume / Self::volume_factor(angle)).cbrt(), angle }
    }

    /// Contact radius over the diameter of the falling drop of the same volume.
    pub fn spread(angle: f64) -> f64 {
        (PI / 6.0 / Self::volume_factor(angle)).cbrt()
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        Self::volume_factor(self.angle) * self.radius.powi(3)
    }

    /// Its height over the glass.
    pub fn height(&self) -> f64 {
        self.radius * (0.5 * self.angle.to_radians()).tan()
    }

    /// Radius of its sphere.
    pub fn sphere_radius(&self) -> f64 {
        self.radius / self.angle.to_radians().sin()
    }

    /// Height of its sphere's centre over the glass; under it where the angle is under 90 degrees.
    pub fn center_height(&self) -> f64 {
        -self.radius / self.angle.to_radians().tan()
    }

    /// Radius of the circle that it covers, seen square on: of the disc, or of the sphere where that overhangs.
    pub fn reach(&self) -> f64 {
        if self.angle > 90.0 { self.sphere_radius() } else { self.radius }
    }

    /// What a ray of unit `direction` in air sees that meets the disc at `place`, in closed form; `None` under total
    /// reflection. `water` and `glass` are refractive indices.
    pub fn first_exit(
        &self,
        direction: DVec3,
        place: DVec3,
        water: f64,
        glass: f64,
    ) -> Option<FirstExit> {
        let along = DVec3::new(direction.x, direction.y, 0.0);
        let sine2 = along.length_squared();
        let in_water = along + DVec3::Z * (water * water - sine2).sqrt();
        let path = in_water / water;
        let from_center = place - DVec3::Z * self.center_height();
        let b = from_center.dot(path);
        // u² - a² is q² - R² without cancellation.
        let within = place.length_squared() - self.radius * self.radius;
        let normal = (from_center + (-b + (b * b - within).sqrt()) * path) / self.sphere_radius();
        let outward = in_water.dot(normal);
        let in_air2 = 1.0 - water * water + outward * outward;
        if in_air2 < 0.0 {
            return None;
        }
        let in_air = in_air2.sqrt();
        let [air_cos, glass_cos, water_cos] =
            [1.0, glass, water].map(|index: f64| (1.0 - sine2 / (index * index)).sqrt());
        let weight = (1.0 - fresnel(air_cos, glass_cos, glass))
            * (1.0 - fresnel(glass_cos, water_cos, water / glass))
            * (1.0 - fresnel(outward / water, in_air, 1.0 / water));
        Some(FirstExit { direction: in_water + (in_air - outward) * normal, weight })
    }

    /// Share of the disc whose rays of unit `direction` are reflected totally where they meet the cap first, by a few
    /// hundred places of equal area.
    pub fn dark_share(&self, direction: DVec3, water: f64) -> f64 {
        const PLACES: u32 = 400;
        // Steps of the golden section around a spiral of equal areas.
        let turn = PI * (3.0 - 5.0_f64.sqrt());
        let dark = (0..PLACES).filter(|&number| {
            let share = (f64::from(number) + 0.5) / f64::from(PLACES);
            let (sine, cosine) = (turn * f64::from(number)).sin_cos();
            let place = self.radius * share.sqrt() * DVec3::new(cosine, sine, 0.0);
            self.first_exit(direction, place, water, 1.0).is_none()
        });
        dark.count() as f64 / f64::from(PLACES)
    }
}
