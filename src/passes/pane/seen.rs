//! What layers tell of a pane's drop: depth and motion of the middle of its contact disc, in float64.
//!
//! The shaders find which drop is nearest in a pixel, by its number. Everything else is the same in all of its pixels.

use glam::{DVec2, DVec3};
use half::f16;

use super::PaneDrops;
use crate::scene::Scene;
use crate::scene::projection::View;

/// A drop on the pane, in the middle of what is exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenOnPane {
    /// Planar depth, scene units.
    pub depth: f32,
    /// Pixels to the right and down; 0 if it is behind the camera at the end.
    pub motion: [f16; 2],
}

/// Where in the whole picture a direction is seen.
fn place_of(view: &View, direction: DVec3) -> (DVec2, bool) {
    let (place, is_before) = view.point(direction);
    (place + DVec2::from(view.origin.map(f64::from)), is_before)
}

impl PaneDrops {
    /// The drops in their order, from what `scene` shows to what `until` does; of a pane without a place none.
    pub(super) fn seen(&self, scene: &Scene, until: &Scene) -> Vec<SeenOnPane> {
        let (Some(from), Some(to)) = (scene.pane_face(), until.pane_face()) else {
            return Vec::new();
        };
        let (view, then) = (scene.view(), until.view());
        let half_way = 0.5 * scene.pane_motion();
        let seen = |at: &DVec2| {
            let local = at.extend(0.0);
            let now = from.point + from.to_world(local) - view.position + half_way;
            let end = to.point + to.to_world(local) - then.position + half_way;
            let ((start, is_before), (end, stays)) = (place_of(&view, now), place_of(&then, end));
            let motion = if is_before && stays { end - start } else { DVec2::ZERO };
            SeenOnPane {
                depth: -now.dot(view.back) as f32,
                motion: motion.to_array().map(f16::from_f64),
            }
        };
        self.at.iter().map(seen).collect()
    }
}
