//! The stages of the frame by tiles, drop after drop and pixel after pixel in float64, written from what they are to find.
//! `tile_stages.rs` holds the shaders against them.

use glam::{DVec2, DVec3};
use raindrops::plan::FramePlan;
use raindrops::rain::cull::{Visibility, drops_with_visibility};
use raindrops::scene::Scene;
use raindrops::scene::projection::View;

/// Rays along each edge of a square that tell what a drop covers of it.
const RAYS: u32 = 16;
/// Radii from which a drop looks like a far one.
const FAR: f64 = 32.0;
/// Half sides of a splat are shorter, pixels.
const LONGEST: f64 = 1023.0 / 512.0;

/// A part of the picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Rect {
    pub low: DVec2,
    pub high: DVec2,
}

impl Rect {
    pub fn around(center: DVec2, half_sides: DVec2) -> Self {
        Self { low: center - half_sides, high: center + half_sides }
    }

    pub fn grown(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// Area of what both have.
    pub fn overlap(self, other: Self) -> f64 {
        let sides = self.high.min(other.high) - self.low.max(other.low);
        sides.x.max(0.0) * sides.y.max(0.0)
    }
}

/// How a drop is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The box of its outline's area, in two colours: it is small and far.
    Splat,
    /// That box, pixel after pixel: it has less than a pixel of radius.
    Box,
    /// By its outline.
    Outline,
    /// It reaches the camera's plane: whole pixels are covered or not.
    Beside,
}

/// A drop in view.
pub struct Shown {
    pub index: u32,
    pub kind: Kind,
    /// What drops are ordered by: squared length of the tangents from the camera, of splats that to the centre.
    pub distance2: f64,
    is_placed: bool,
    /// In view space.
    center: DVec3,
    radius: f64,
    opacity: f64,
    /// Around its outline.
    pub outline: Rect,
    /// A box of its outline's area.
    equal: Rect,
    view: View,
}

impl Shown {
    /// What it is ordered by in a tile: of a larger placed drop the squared distance to where the ray of the tile's middle meets
    /// it, or comes nearest.
    pub fn order_in(&self, middle: DVec2) -> f64 {
        if self.kind == Kind::Splat || !self.is_placed {
            return self.distance2;
        }
        let at = (middle - self.view.principal) / self.view.focal_px;
        let ray = DVec3::new(at.x, -at.y, -1.0).normalize();
        let along = ray.dot(self.center);
        let aside2 = self.center.length_squared() - along * along;
        let front = along - (self.radius * self.radius - aside2).max(0.0).sqrt();
        front.max(0.0).powi(2)
    }
}

/// Every drop of a scene that may be seen.
pub fn drops_in_view(scene: &Scene, plan: &FramePlan) -> Vec<Shown> {
    let is_seen = |visibility| matches!(visibility, Visibility::Visible | Visibility::BesideCamera);
    (0..)
        .zip(drops_with_visibility(scene))
        .filter(|(_, (.., visibility))| is_seen(*visibility))
        .map(|(index, (center, radius, _))| {
            shown(index, center.as_dvec3(), radius.into(), scene, plan)
        })
        .collect()
}

fn shown(index: u32, center: DVec3, radius: f64, scene: &Scene, plan: &FramePlan) -> Shown {
    let (view, distance) = (scene.view(), center.length());
    let (f, depth) = (view.focal_px, -center.z);
    // Projects the sphere's two tangents in the plane of one axis of the picture, by their angles to the view axis.
    let along = |across: f64| {
        let middle = across.atan2(depth);
        let half = (radius / across.hypot(depth)).min(1.0).asin();
        [f * (middle - half).tan(), f * (middle + half).tan()]
    };
    let ([left, right], [top, bottom]) = (along(center.x), along(-center.y));
    let outline = Rect {
        low: view.principal + DVec2::new(left, top),
        high: view.principal + DVec2::new(right, bottom),
    };
    let half_sides = 0.5 * (outline.high - outline.low);
    // The outline is an ellipse: one axis is towards the picture's middle, the other across.
    let (off_axis, half) =
        (center.truncate().length().atan2(depth), (radius / distance).min(1.0).asin());
    let long = 0.5 * f * ((off_axis + half).tan() - (off_axis - half).tan());
    let short = f * radius / (depth * depth - radius * radius).max(0.0).sqrt();
    let size = (long * short).sqrt();
    let equal_half =
        half_sides * size * (0.25 * std::f64::consts::PI / half_sides.element_product()).sqrt();
    let (near, fade) = (scene.camera.near, scene.camera.near_fade);
    let faded = if fade > 0.0 { ((distance - near) / fade).clamp(0.0, 1.0) } else { 1.0 };
    let opacity = faded * faded * (3.0 - 2.0 * faded);
    let is_far = distance >= FAR * radius;
    let is_short = equal_half.max_element() < LONGEST;
    let kind = if depth < 1.01 * radius {
        Kind::Beside
    } else if size < f64::from(plan.splat_px) && is_far && is_short && opacity == 1.0 {
        Kind::Splat
    } else if size < 1.0 || (size < 1.5 && short < 1.0) {
        Kind::Box
    } else {
        Kind::Outline
    };
    let tangents2 = if kind == Kind::Splat { 0.0 } else { radius * radius };
    let everywhere = DVec2::new(view.width.into(), view.height.into());
    let outline = match kind {
        Kind::Beside => Rect { low: DVec2::ZERO, high: everywhere },
        _ => outline,
    };
    Shown {
        index,
        kind,
        distance2: distance * distance - tangents2,
        is_placed: index >= scene.random_count(),
        center,
        radius,
        opacity,
        outline,
        equal: Rect::around(0.5 * (outline.low + outline.high), equal_half),
        view,
    }
}

impl Shown {
    /// What the drop covers of a square.
    pub fn coverage(&self, square: Rect) -> f64 {
        let sides = square.high - square.low;
        let share = match self.kind {
            Kind::Splat | Kind::Box => self.equal.overlap(square) / sides.element_product(),
            Kind::Outline | Kind::Beside => {
                let at = |i: u32| (f64::from(i) + 0.5) / f64::from(RAYS);
                let places = (0..RAYS * RAYS).map(|i| DVec2::new(at(i % RAYS), at(i / RAYS)));
                let hits = places.filter(|place| self.is_at(square.low + *place * sides)).count();
                hits as f64 / f64::from(RAYS * RAYS)
            }
        };
        self.opacity * share
    }

    /// How far from this a pixel's coverage may be.
    pub fn tolerance(&self) -> f64 {
        match self.kind {
            // Places and sides are whole parts of a pixel.
            Kind::Splat => 0.004,
            Kind::Box => 0.0003,
            // The smoothed edge is taken for a straight one, as steep at any angle.
            Kind::Outline => 0.075,
            // All or nothing.
            Kind::Beside => 0.6,
        }
    }

    /// Does the ray through a point of the picture meet the sphere?
    fn is_at(&self, point: DVec2) -> bool {
        let plane = point - self.view.principal;
        let ray = DVec3::new(plane.x, -plane.y, -self.view.focal_px).normalize();
        ray.dot(self.center) > 0.0 && ray.cross(self.center).length() < self.radius
    }

    /// May the drop be entered for a pixel? The edge of an outline is smoothed over a pixel; without one any may see it.
    pub fn may_reach(&self, pixel: Rect) -> bool {
        match self.kind {
            Kind::Splat | Kind::Box => self.equal.overlap(pixel.grown(0.01)) > 0.0,
            Kind::Outline => self.coverage(pixel.grown(0.5)) > 0.0,
            Kind::Beside => true,
        }
    }
}

/// Light and coverage of what is in a pixel, front to back, over what is behind.
pub fn over(fragments: impl Iterator<Item = (DVec3, f64)>, behind: DVec3) -> DVec3 {
    let (mut sum, mut passes) = (DVec3::ZERO, 1.0);
    for (light, coverage) in fragments {
        sum += passes * light;
        passes *= 1.0 - coverage;
    }
    sum + passes * behind
}
