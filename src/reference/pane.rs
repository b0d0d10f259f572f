//! A pane of glass with drops on it, by refraction at each interface.
//!
//! What is computed, for a ray of the camera that meets the pane:
//! - **Dry**: T = (1-F)/(1+F) goes on along the ray from where it leaves the wet face, with F of air to glass at the ray's
//!   angle: all orders of reflection within the pane, without their shift sideways. 1-T sees the inside.
//! - **In a contact disc**: (1-F)(1-F) of air to glass and glass to water enters the water; the rest sees the inside.
//! - **Dry, then a cap from outside**: F sees the sky, 1-F enters the water.
//! - **In the water**: from hit to hit of cap and base, up to [`super::Truth::internal_reflections`]. What leaves by the cap
//!   sees the sky. What leaves by the base goes into the glass: caught there, or F/(1+F) comes back out beside the drop,
//!   where it sees the sky, and 1/(1+F) goes inside.
//!
//! The sky is the plate in the direction that is seen, where the camera has it in its picture, else the environment. What
//! leaves a drop towards the pane is mirrored by it, by 1-T, and sees the inside by T. Drops see neither rain nor one another.
//!
//! All ways are followed, none is chosen by chance. Places are along the pane's u, v and normal, from its point.

use glam::{DVec2, DVec3};

use super::{Ray, Tracer};
use crate::optics::{Cap, Interface};
use crate::scene::Scene;
use crate::scene::camera::View;
use crate::scene::pane::Face;

use super::pane_grid::Grid;

/// Light under this share of a ray's is not followed on.
const NOTHING: f64 = 1e-15;

/// A drop on the pane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PaneCap {
    /// Middle of its disc.
    pub(super) at: DVec2,
    /// Radius of its disc, and of the circle that it covers seen square on.
    pub(super) radius: f64,
    pub(super) reach: f64,
    /// Its height.
    pub(super) height: f64,
    /// Radius of its sphere, and the height of that's centre.
    sphere: f64,
    center: f64,
    /// What layers tell of it.
    told: Told,
}

/// Which drop of a pane a ray has met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Told {
    /// From 1 on, in the order of the pane's drops.
    pub(super) number: u32,
    /// Planar depth of the middle of its disc, in the middle of the exposure.
    pub(super) depth: f64,
}

/// Drops on a pane in a pixel: what layers hold of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnPane {
    /// Share of the pixel that they cover.
    pub share: f32,
    /// Number of the nearest, from 1 on; 0: there is none.
    pub number: u32,
    /// Planar depth of the middle of its disc; infinite where there is none.
    pub depth: f32,
}

impl OnPane {
    /// What so many samples have met, taken together.
    pub(super) fn of(met: impl Iterator<Item = Option<Told>>, samples: usize) -> Self {
        let (mut count, mut nearest) = (0.0, Told { number: 0, depth: f64::INFINITY });
        for told in met.flatten() {
            count += 1.0;
            if (told.depth, told.number) < (nearest.depth, nearest.number) {
                nearest = told;
            }
        }
        let share = count / samples as f64;
        Self { share: share as f32, number: nearest.number, depth: nearest.depth as f32 }
    }
}

/// The pane of a scene.
#[derive(Clone, Debug)]
pub(super) struct Pane {
    /// Its point is seen from the camera, as the shutter opens.
    face: Face,
    /// By how much it moves, as the camera sees it, while the shutter is open.
    pub(super) motion: DVec3,
    pub(super) thickness: f64,
    index: f64,
    inside: DVec3,
    grid: Grid,
    /// The whole picture, for plates.
    whole: View,
}

/// A ray that has come to the pane, or to nothing of it.
pub(super) struct Passed {
    /// What it sees there.
    pub(super) light: DVec3,
    /// Share of it that goes on.
    pub(super) left: f64,
    /// The drop that it has met.
    pub(super) drop: Option<Told>,
    /// The ray that goes on, and the distance along it from which on it is outside.
    pub(super) ray: Ray,
    pub(super) from: f64,
}

impl PaneCap {
    fn new(at: DVec2, cap: Cap, told: Told) -> Self {
        Self {
            at,
            radius: cap.radius,
            reach: cap.reach(),
            height: cap.height(),
            sphere: cap.sphere_radius(),
            center: cap.center_height(),
            told,
        }
    }

    /// A place as seen from the centre of its sphere.
    fn seen_from_center(&self, place: DVec3) -> DVec3 {
        place - self.at.extend(self.center)
    }

    /// Distance at which a ray that begins outside meets the sphere, over the wet face.
    pub(super) fn meet(&self, place: DVec3, direction: DVec3) -> Option<f64> {
        let from = self.seen_from_center(place);
        let b = from.dot(direction);
        let miss2 = (from - b * direction).length_squared();
        let half2 = self.sphere * self.sphere - miss2;
        let distance = -b - half2.max(0.0).sqrt();
        let height = place.z + distance * direction.z;
        (half2 > 0.0 && distance > 0.0 && height > 0.0).then_some(distance)
    }

    /// Distance from a place within to the cap.
    fn distance_to(&self, place: DVec3, direction: DVec3) -> f64 {
        let from = self.seen_from_center(place);
        let b = from.dot(direction);
        let within = from.length_squared() - self.sphere * self.sphere;
        (-b + (b * b - within).max(0.0).sqrt()).max(0.0)
    }
}

impl Pane {
    /// That of a validated scene; `None` without one.
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        let (pane, face) = (scene.pane.as_ref()?, scene.pane_face()?);
        let is_fixed = pane.frame == crate::scene::pane::Frame::World;
        let motion = if is_fixed { scene.motion_of(DVec3::ZERO) } else { DVec3::ZERO };
        let (from, back) = (face.point - scene.camera.position, scene.view().back);
        let caps = (1..).zip(scene.pane_drops()).map(|(number, drop)| {
            let cap = Cap { radius: drop.radius, angle: pane.angle_of(&drop) };
            let middle = from + face.to_world(drop.at.extend(0.0)) + 0.5 * motion;
            PaneCap::new(drop.at, cap, Told { number, depth: -middle.dot(back) })
        });
        Some(Self {
            face: Face { point: from, ..face },
            motion,
            thickness: pane.thickness,
            index: pane.index,
            inside: pane.inside,
            grid: Grid::new(caps.collect()),
            whole: scene.whole().view(),
        })
    }

    /// (1-F)/(1+F) of a dry pane, for a ray in air of this cosine to the normal.
    fn transmitted(&self, cosine: f64) -> f64 {
        let met = Interface::meet(
            DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine),
            DVec3::NEG_Z,
            self.index,
        );
        (1.0 - met.reflectance) / (1.0 + met.reflectance)
    }
}

impl Tracer<'_> {
    /// A ray of the camera at the pane.
    pub(super) fn pass(&self, ray: &Ray) -> Passed {
        let untouched = Passed {
            light: DVec3::ZERO,
            left: 1.0,
            drop: None,
            ray: *ray,
            from: f64::NEG_INFINITY,
        };
        let Some(pane) = &self.pane else { return untouched };
        let direction = pane.face.to_local(ray.direction);
        if direction.z <= 0.0 {
            return untouched;
        }
        let point = pane.face.point + ray.moment * pane.motion;
        let origin = pane.face.to_local(ray.origin - point);
        let to_dry = (-pane.thickness - origin.z) / direction.z;
        let entry = Interface::meet(direction, DVec3::NEG_Z, pane.index);
        // Into a denser substance light always goes.
        let in_glass = entry.refracted.unwrap_or(direction);
        let dry = origin + to_dry * direction;
        let wet = (dry + in_glass * (pane.thickness / in_glass.z)).truncate().extend(0.0);

        if let Some(cap) = pane.grid.containing(wet.truncate()) {
            let light = self.by_colors(|index| {
                let base = Interface::meet(in_glass, DVec3::NEG_Z, index / pane.index);
                let into = (1.0 - entry.reflectance) * (1.0 - base.reflectance);
                let water = base
                    .refracted
                    .map_or(DVec3::ZERO, |way| self.in_water(pane, cap, wet, way, index));
                into * water + (1.0 - into) * pane.inside
            });
            return Passed { light, left: 0.0, drop: Some(cap.told), ..untouched };
        }
        let through = pane.transmitted(direction.z);
        let inside = (1.0 - through) * pane.inside;
        if let Some((cap, distance)) = pane.grid.first_met(wet, direction) {
            let place = wet + distance * direction;
            let normal = cap.seen_from_center(place).normalize();
            let light = self.by_colors(|index| {
                let met = Interface::meet(direction, normal, index);
                let water = met
                    .refracted
                    .map_or(DVec3::ZERO, |way| self.in_water(pane, cap, place, way, index));
                met.reflectance * self.sky(pane, met.reflected) + (1.0 - met.reflectance) * water
            });
            return Passed {
                light: inside + through * light,
                left: 0.0,
                drop: Some(cap.told),
                ..untouched
            };
        }
        // The ray that goes on begins beside the camera, so that distances along it are the camera's.
        let moved = wet - direction * ((wet - origin).dot(direction));
        let ray = Ray { origin: point + pane.face.to_world(moved), ..*ray };
        let from = (wet - moved).dot(direction);
        Passed { light: inside, left: through, drop: None, ray, from }
    }

    /// The light for each colour of its own index.
    fn by_colors(&self, light: impl Fn(f64) -> DVec3) -> DVec3 {
        self.indices.iter().map(|&(index, colors)| colors * light(index)).sum()
    }

    /// Radiance that arrives in the water at a place from where a ray goes on in a unit direction.
    fn in_water(
        &self,
        pane: &Pane,
        cap: &PaneCap,
        place: DVec3,
        direction: DVec3,
        index: f64,
    ) -> DVec3 {
        let (mut place, mut direction) = (place, direction);
        let (mut light, mut left) = (DVec3::ZERO, 1.0);
        for _ in 0..=self.truth.internal_reflections {
            let to_cap = cap.distance_to(place, direction);
            let to_base = if direction.z < 0.0 { -place.z / direction.z } else { f64::INFINITY };
            let met = if to_base < to_cap {
                place = (place + to_base * direction).truncate().extend(0.0);
                let met = Interface::meet(direction, DVec3::Z, pane.index / index);
                if let Some(in_glass) = met.refracted {
                    light += left * (1.0 - met.reflectance) * self.behind_base(pane, in_glass);
                }
                met
            } else {
                let normal = cap.seen_from_center(place + to_cap * direction).normalize();
                place = cap.at.extend(cap.center) + cap.sphere * normal;
                let met = Interface::meet(direction, -normal, 1.0 / index);
                if let Some(in_air) = met.refracted {
                    light += left * (1.0 - met.reflectance) * self.sky(pane, in_air);
                }
                met
            };
            left *= met.reflectance;
            direction = met.reflected.normalize();
            if left < NOTHING {
                break;
            }
        }
        light
    }

    /// Radiance that arrives in the glass from a direction towards the dry face.
    fn behind_base(&self, pane: &Pane, in_glass: DVec3) -> DVec3 {
        let dry = Interface::meet(in_glass, DVec3::Z, 1.0 / pane.index);
        let Some(inside) = dry.refracted else { return pane.inside };
        let back = dry.reflectance / (1.0 + dry.reflectance);
        let beside = DVec3::new(inside.x, inside.y, -inside.z);
        back * self.sky(pane, beside) + (1.0 - back) * pane.inside
    }

    /// Radiance outside in a direction along the pane's axes, or by way of the dry pane.
    fn sky(&self, pane: &Pane, direction: DVec3) -> DVec3 {
        if direction.z > 0.0 {
            return self.outside(pane, direction);
        }
        let through = pane.transmitted(-direction.z);
        let mirrored = DVec3::new(direction.x, direction.y, -direction.z);
        (1.0 - through) * self.outside(pane, mirrored) + through * pane.inside
    }

    /// The plate where it is in the picture, else the environment.
    fn outside(&self, pane: &Pane, direction: DVec3) -> DVec3 {
        let direction = pane.face.to_world(direction);
        let [width, height] = pane.whole.whole.map(f64::from);
        let (place, is_before) = pane.whole.point(direction);
        let is_within =
            is_before && (0.0..=width).contains(&place.x) && (0.0..=height).contains(&place.y);
        let plate = if is_within { self.plate.bilinear(place) } else { None };
        plate.unwrap_or_else(|| self.environment.radiance(direction))
    }
}
