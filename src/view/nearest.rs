//! Which of a scene's drops is nearest, by whatever is meant by near.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use crate::rain::field::Field;
use crate::rain::tick_of_seconds;
use crate::scene::Scene;

/// Radius in pixels from which on drops of real rain are looked at.
const LEAST_PX: f64 = 0.3;

/// A drop: how far it is, its centre relative to the camera along the world's axes, and its radius.
type Near = (f64, DVec3, f64);

/// The nearest drop, where `distance` tells how far one is from its centre relative to the camera and its radius; infinite
/// if it is not meant at all. None if none is meant.
pub(super) fn nearest(
    scene: &Scene,
    distance: impl Fn(DVec3, f64) -> f64 + Sync,
) -> Option<(DVec3, f64)> {
    let camera = scene.camera.position;
    let near = |center, radius| (distance(center, radius), center, radius);
    let nearer = |a: Near, b: Near| if b.0 < a.0 { b } else { a };
    let nowhere = (f64::INFINITY, DVec3::ZERO, 0.0);
    let placed = scene.placed().map(|drop| near(drop.center_at(scene.time) - camera, drop.radius));
    let mut found = placed.fold(nowhere, nearer);
    for rain in scene.populations() {
        let seen = rain.seen_from(camera, tick_of_seconds(scene.time));
        let falling = (0..rain.count)
            .into_par_iter()
            .map(|index| near(seen.drop_at(index).as_dvec3(), rain.radius))
            .reduce(|| nowhere, nearer);
        found = nearer(found, falling);
    }
    if let Some(field) = Field::of(scene) {
        field.for_each_shown(scene, LEAST_PX, &mut |drop| {
            found = nearer(found, near(drop.from_camera, drop.radius.into()));
        });
    }
    let (distance, center, radius) = found;
    distance.is_finite().then_some((center, radius))
}
