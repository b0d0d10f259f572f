//! A drop whose place is given.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::model::DropShape;

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
