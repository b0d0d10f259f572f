//! What a height map shelters from rain, in float64: `[shelter]`.
//!
//! A texel is a column of its height without a bottom; beyond the map there is nothing. A place is sheltered from drops of a
//! velocity if the line on which they fall, followed back from there, meets a column. A drop goes along its own line, so while
//! the shutter is open it is there up to the moment when it meets a surface, and not after.
//!
//! The medium is sheltered class by class: along a ray as much of a class is left out as would have fallen through a surface.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::picture::heights::HeightMap;
use crate::scene::Scene;

/// Places along a ray where the medium is asked for; between two that differ the edge is found by [`HALVINGS`].
const PLACES: u32 = 128;

/// Halvings by which an edge is found.
const HALVINGS: u32 = 24;

/// The surfaces of a scene.
#[derive(Clone, Debug)]
pub(super) struct Roof {
    map: Arc<HeightMap>,
    from: DVec2,
    to: DVec2,
    highest: f64,
    /// Where the camera is as the shutter opens.
    camera: DVec3,
    /// The scene's seconds while the shutter is open.
    exposed: f64,
}

/// The share of the exposure from which on, and that until which, a drop is there.
pub(super) const ALWAYS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Roof {
    /// A scene's surfaces; none without a shelter.
    pub fn of(scene: &Scene) -> Option<Self> {
        let shelter = scene.shelter.as_ref()?;
        let map = shelter.map()?.clone();
        Some(Self {
            from: shelter.from.into(),
            to: shelter.to.into(),
            highest: map.highest().into(),
            camera: scene.camera.position,
            exposed: scene.exposed(),
            map,
        })
    }

    /// When a drop is there that is at `center`, from the camera, as the shutter opens; none if never.
    pub fn there(&self, center: DVec3, velocity: DVec3) -> Option<[f64; 2]> {
        let opens = self.camera + center;
        let is_sheltered =
            |moment: f64| self.shelters(opens + moment * self.exposed * velocity, velocity);
        let ends = [is_sheltered(0.0), is_sheltered(1.0)];
        if ends[0] == ends[1] {
            return (!ends[0]).then_some(ALWAYS);
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..52 {
            let middle = 0.5 * (low + high);
            if is_sheltered(middle) == ends[0] { low = middle } else { high = middle }
        }
        // Where time runs backwards, a drop comes back out of what it fell on.
        Some(if ends[0] { [high, f64::INFINITY] } else { [f64::NEG_INFINITY, high] })
    }

    /// Whether a place is sheltered from drops of a velocity.
    pub fn shelters(&self, place: DVec3, velocity: DVec3) -> bool {
        let back = -velocity;
        let at = DVec2::new(place.x, place.z);
        let across = DVec2::new(back.x, back.z);
        let size = DVec2::new(self.map.columns as f64, self.map.rows as f64);
        let texel = (self.to - self.from) / size;
        // Seconds back: below all heights, and over the map.
        let (mut begin, mut end) = (0.0_f64, (self.highest - place.y) / back.y);
        for axis in 0..2 {
            let edges = [self.from[axis], self.to[axis]].map(|edge| edge - at[axis]);
            if across[axis] == 0.0 {
                if edges[0] > 0.0 || edges[1] < 0.0 {
                    return false;
                }
                continue;
            }
            let [a, b] = edges.map(|edge| edge / across[axis]);
            (begin, end) = (begin.max(a.min(b)), end.min(a.max(b)));
        }
        while begin <= end {
            // The column is that of the middle between two borders of texels.
            let here = (at + begin * across - self.from) / texel;
            let crossing = |axis: usize| {
                let border = match across[axis] > 0.0 {
                    _ if across[axis] == 0.0 => return f64::INFINITY,
                    true => (here[axis] + 1e-9).floor() + 1.0,
                    false => (here[axis] - 1e-9).ceil() - 1.0,
                };
                (self.from[axis] + border * texel[axis] - at[axis]) / across[axis]
            };
            let next = crossing(0).min(crossing(1)).min(end);
            let column = (at + 0.5 * (begin + next) * across - self.from) / texel;
            let column = column.floor().clamp(DVec2::ZERO, size - 1.0);
            let index = column.y as usize * self.map.columns + column.x as usize;
            if place.y + begin * back.y <= f64::from(self.map.heights[index]) {
                return true;
            }
            if next >= end {
                return false;
            }
            begin = next;
        }
        false
    }

    /// The length of a ray of the camera, between two distances, that is sheltered from drops of a velocity.
    pub fn length_under(&self, direction: DVec3, [from, to]: [f64; 2], velocity: DVec3) -> f64 {
        let Some([from, to]) = self.reached(direction, [from, to], velocity) else { return 0.0 };
        let is_under = |along: f64| self.shelters(self.camera + along * direction, velocity);
        let step = (to - from) / f64::from(PLACES);
        let (mut sum, mut was_under, mut since) = (0.0, is_under(from), from);
        for place in 1..=PLACES {
            let (before, along) =
                (from + step * f64::from(place - 1), from + step * f64::from(place));
            if is_under(along) == was_under {
                continue;
            }
            let (mut low, mut high) = (before, along);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if is_under(middle) == was_under { low = middle } else { high = middle }
            }
            if was_under {
                sum += high - since;
            }
            (was_under, since) = (!was_under, high);
        }
        if was_under { sum + to - since } else { sum }
    }

    /// The part of a ray beyond which nothing is sheltered: no farther beside the map than the lines lean below the highest
    /// surface, and below that.
    fn reached(
        &self,
        direction: DVec3,
        [mut from, mut to]: [f64; 2],
        velocity: DVec3,
    ) -> Option<[f64; 2]> {
        let lean = DVec2::new(velocity.x, velocity.z).abs() / -velocity.y;
        // Each is `offset + slope * distance <= 0`.
        let below = self.camera.y - self.highest;
        let mut limits = vec![(below, direction.y)];
        for (axis, at, along) in [(0, self.camera.x, direction.x), (1, self.camera.z, direction.z)]
        {
            let leans = (lean[axis] * below, lean[axis] * direction.y);
            limits.push((at - self.to[axis] + leans.0, along + leans.1));
            limits.push((self.from[axis] - at + leans.0, -along + leans.1));
        }
        for (offset, slope) in limits {
            let limit = -offset / slope;
            match slope {
                0.0 if offset > 0.0 => return None,
                0.0 => (),
                _ if slope > 0.0 => to = to.min(limit),
                _ => from = from.max(limit),
            }
        }
        (from < to).then_some([from, to])
    }
}
