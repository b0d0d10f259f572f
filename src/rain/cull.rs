//! Which drops are in view: the same as the second half of `glsl/simulate.comp`, bit for bit.
//!
//! Only products, sums and comparisons of float32, each rounded by itself, so that every driver and
//! the CPU agree on every drop, and counts can be compared exactly.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::rain::pairs::{Pair, carried, moment};
use crate::rain::shelter::Roofs;
use crate::scene::Scene;
use crate::scene::camera::View;

/// What became of a drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// Its sphere meets the view volume: drawn.
    Visible,
    /// Out of the view volume, nearer than the near plane, or kept off by a shelter.
    OutOfView,
    /// The camera is inside it: not drawn.
    CameraInside,
    /// In the view volume, but as deep as its radius or less: its outline reaches the camera plane
    /// and is no ellipse. A billboard cannot show it; not drawn.
    BesideCamera,
}

/// The camera as float32 constants; the same bits go to the GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The camera's axes in world space: right, up, back.
    pub axes: [Vec3; 3],
    /// Cosine and sine of the angle from the view axis to the left edge, then to the right one.
    pub frustum_x: [f32; 4],
    /// Cosine and sine of the angle from the view axis to the upper edge, then to the lower one.
    pub frustum_y: [f32; 4],
    /// Near plane: least distance of a drop's centre.
    pub near: f32,
    /// The camera's position, and what float32 lost of it.
    pub position: [Vec3; 2],
    /// Radius of the lens, and inverse distance of the focus; 0 for a pinhole.
    pub lens: [f32; 2],
}

impl Sight {
    /// The constants of a scene's camera.
    pub fn of(scene: &Scene) -> Self {
        let radius = scene.drawn_lens() as f32;
        let inverse_focus = if radius > 0.0 { scene.camera.focus.recip() as f32 } else { 0.0 };
        Self { lens: [radius, inverse_focus], ..Self::new(&scene.view(), scene.drawn_near()) }
    }

    /// The constants of a view and a near plane, seen through a pinhole.
    pub fn new(view: &View, near: f64) -> Self {
        let [left, top, right, bottom] = view.tan_edges().map(|tangent| {
            let (sine, cosine) = tangent.atan().sin_cos();
            [cosine as f32, sine as f32]
        });
        Self {
            axes: [view.right.as_vec3(), view.up.as_vec3(), view.back.as_vec3()],
            frustum_x: [left[0], left[1], right[0], right[1]],
            frustum_y: [top[0], top[1], bottom[0], bottom[1]],
            near: near as f32,
            position: split(view.position),
            lens: [0.0; 2],
        }
    }

    /// Centre of a hand-placed drop relative to the camera along the world's axes. Differences of
    /// the two halves apart keep a drop's place exact far from the world's origin.
    pub fn relative_placed(&self, center: Pair) -> Vec3 {
        (center.high - self.position[0]) + (center.low - self.position[1])
    }

    /// From world axes to the camera's axes.
    pub fn view_space(&self, p: Vec3) -> Vec3 {
        let along = |axis: Vec3| (axis.x * p.x + axis.y * p.y) + axis.z * p.z;
        Vec3::new(along(self.axes[0]), along(self.axes[1]), along(self.axes[2]))
    }

    /// How far beyond the left, the right, the upper and the lower edge of the view a place is.
    fn beyond(&self, v: Vec3) -> [f32; 4] {
        let (depth, x, y) = (-v.z, self.frustum_x, self.frustum_y);
        [
            -v.x * x[0] - depth * x[1],
            v.x * x[2] - depth * x[3],
            v.y * y[0] - depth * y[1],
            -v.y * y[2] - depth * y[3],
        ]
    }

    /// How far from its centre a drop is seen across the view axis: by its radius and, through a lens, by how far the
    /// places of the lens see it apart there.
    fn reach(&self, v: Vec3, radius: f32) -> f32 {
        let [lens, inverse_focus] = self.lens;
        if lens == 0.0 {
            return radius;
        }
        radius + lens * ((1.0 + v.z * inverse_focus).abs() + radius * inverse_focus)
    }

    /// What becomes of a drop that moves so far, both in view space, around this centre: whether it may be in view at
    /// any time.
    pub fn visibility_moving(&self, v: Vec3, moved: Vec3, radius: f32) -> Visibility {
        if moved == Vec3::ZERO {
            return self.visibility(v, radius);
        }
        let half_way = 0.5 * moved;
        let (from, to) = (v - half_way, v + half_way);
        let square = (v.x * v.x + v.y * v.y) + v.z * v.z;
        let (a, b) = (self.beyond(from), self.beyond(to));
        let reach = self.reach(from, radius).max(self.reach(to, radius));
        let in_frustum = a.into_iter().zip(b).all(|(a, b)| a.min(b) <= reach);
        if !in_frustum || square < self.near * self.near || (-from.z).max(-to.z) <= -radius {
            Visibility::OutOfView
        } else if (-from.z).min(-to.z) <= radius {
            Visibility::BesideCamera
        } else {
            Visibility::Visible
        }
    }

    /// What becomes of a drop with this centre in view space.
    pub fn visibility(&self, v: Vec3, radius: f32) -> Visibility {
        let depth = -v.z;
        let distance2 = (v.x * v.x + v.y * v.y) + v.z * v.z;
        let reach = self.reach(v, radius);
        let in_frustum = self.beyond(v).into_iter().all(|beyond| beyond <= reach);
        if distance2 <= radius * radius {
            Visibility::CameraInside
        } else if !in_frustum || distance2 < self.near * self.near || depth <= -radius {
            Visibility::OutOfView
        } else if depth <= radius {
            Visibility::BesideCamera
        } else {
            Visibility::Visible
        }
    }
}

/// A float64 vector as the sum of two float32 ones.
pub fn split(v: DVec3) -> [Vec3; 2] {
    let high = v.as_vec3();
    [high, (v - high.as_dvec3()).as_vec3()]
}

/// Every drop of a scene in view space in the middle of what is exposed, with what became of it; by index, the random
/// drops in a box before the placed ones. Those of real rain have no index: [`crate::rain::field::Field::drops_with_visibility`].
pub fn drops_with_visibility(scene: &Scene) -> impl Iterator<Item = (Vec3, f32, Visibility)> {
    let sight = Sight::of(scene);
    let tick = crate::rain::tick_of_seconds(scene.drawn_time());
    let roofs = Arc::new(Roofs::of_boxes(scene));
    let random = (0..).zip(scene.populations()).flat_map(move |(kind, rain)| {
        let seen = rain.seen_from(scene.drawn_position(), tick);
        let moved = scene.drawn_motion_of(rain.velocity).as_vec3();
        let roofs = roofs.clone();
        (0..rain.count).map(move |index| {
            let relative = seen.drop_at(index);
            let sheltered =
                roofs.as_ref().as_ref().is_some_and(|roofs| roofs.shelter(relative, kind));
            (relative, moved, rain.radius as f32, sheltered)
        })
    });
    let moment = moment(scene);
    let placed = scene.placed().map(move |drop| {
        let (center, moved) = carried(drop, &moment);
        (sight.relative_placed(center), moved, drop.radius as f32, false)
    });
    random.chain(placed).map(move |(relative, moved, radius, sheltered)| {
        let center = sight.view_space(relative);
        let visibility = match sheltered {
            true => Visibility::OutOfView,
            false => sight.visibility_moving(center, sight.view_space(moved), radius),
        };
        (center, radius, visibility)
    })
}

/// Number of drops in view, as every driver must count them; without those of real rain
/// ([`crate::rain::field::Field::count_visible`]).
pub fn count_visible(scene: &Scene) -> u64 {
    let is_visible =
        |(_, _, visibility): &(Vec3, f32, Visibility)| *visibility == Visibility::Visible;
    drops_with_visibility(scene).filter(is_visible).count() as u64
}
