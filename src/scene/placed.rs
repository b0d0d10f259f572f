//! Drops whose place is given, and how many a scene has.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use super::model::DropShape;
use super::particles::Particles;

/// A drop placed by hand.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacedDrop {
    /// Its centre.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units"))]
    pub center: DVec3,
    /// Radius of the sphere of equal volume.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units"))]
    #[serde(default = "unit_radius")]
    pub radius: f64,
    /// Height over width of a spheroid about +y.
    #[schemars(range(min = 0.05, max = 20), extend("x-default" = "1"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis_ratio: Option<f64>,
    /// Instead of an axis ratio: a sphere, or two half spheroids by the diameter in mm (`metres`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<DropShape>,
    /// At time t the centre is `center + velocity t`.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units/s"))]
    #[serde(default, skip_serializing_if = "is_at_rest")]
    pub velocity: DVec3,
    /// Its number in layers.
    #[schemars(range(min = 1), extend("x-default" = "by its place in the list"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<u32>,
}

impl PlacedDrop {
    /// A sphere at rest.
    pub fn sphere(center: DVec3, radius: f64) -> Self {
        Self { center, radius, ..Self::default() }
    }

    /// Whether it is a sphere, whatever its size.
    pub fn is_sphere(&self) -> bool {
        self.axis_ratio.is_none() && self.shape.is_none_or(|shape| shape == DropShape::Sphere)
    }

    /// Its centre at a time in seconds.
    pub fn center_at(&self, time: f64) -> DVec3 {
        self.center + self.velocity * time
    }
}

impl Scene {
    /// The drops whose place the scene knows: those placed by hand, then the particles that were read.
    pub fn placed(&self) -> impl Iterator<Item = &PlacedDrop> + Clone {
        self.drops.iter().chain(self.particles.iter().flat_map(Particles::drops))
    }

    /// How many have a place; of a host's particles as many as there may be, which come after those of [`Scene::placed`].
    pub fn placed_count(&self) -> u32 {
        self.known_count().saturating_add(self.host_particles)
    }

    /// How many [`Scene::placed`] has.
    pub(crate) fn known_count(&self) -> u32 {
        let particles = self.particles.as_ref().map_or(0, |particles| particles.drops().len());
        (self.drops.len() + particles) as u32
    }

    /// Number in layers of a drop that is the `place`th, from 0 on, of those that have a place.
    pub fn number_of(&self, drop: &PlacedDrop, place: u32) -> u32 {
        drop.id.unwrap_or(self.random_count() + place + 1)
    }

    /// Number of drops, random ones and those that have a place; those of real rain have no number.
    pub fn drop_count(&self) -> u32 {
        self.random_count() + self.placed_count()
    }
}

impl Default for PlacedDrop {
    /// At rest at the origin, of radius 1.
    fn default() -> Self {
        Self {
            center: DVec3::ZERO,
            radius: unit_radius(),
            axis_ratio: None,
            shape: None,
            velocity: DVec3::ZERO,
            id: None,
        }
    }
}

fn unit_radius() -> f64 {
    1.0
}

fn is_at_rest(velocity: &DVec3) -> bool {
    *velocity == DVec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::RainSettings;

    /// 0 is no drop: placed ones come after the random ones, which begin at 1.
    #[test]
    fn numbers_go_on_behind_the_random_drops() {
        let mut scene =
            Scene { rain: None, drops: vec![PlacedDrop::default(); 2], ..Scene::default() };
        let number =
            |scene: &Scene, place: u32| scene.number_of(&scene.drops[place as usize], place);
        assert_eq!([0, 1].map(|place| number(&scene, place)), [1, 2]);
        scene.rain = Some(RainSettings { count: 10, ..RainSettings::default() });
        scene.drops[0].id = Some(3);
        assert_eq!([0, 1].map(|place| number(&scene, place)), [3, 12]);
        assert_eq!((scene.placed_count(), scene.drop_count()), (2, 12));
    }
}
