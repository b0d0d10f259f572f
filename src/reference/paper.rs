//! The paper's model in plain float64, pixel by pixel: the serial model of `drops_point.vert`,
//! `drops_quad.vert`, `drops.frag` and `sky.frag`.
//!
//! It computes what the method *says*, with every texel of the mask evaluated when it is asked for,
//! and none of what a GPU adds: float32 arithmetic, float16 texels and targets, the few bits of a
//! texture unit's filter weights. The difference of the two pictures is the implementation's error;
//! the model's own error is the difference from `reference`. It takes all drops for every pixel, so
//! it is for few.

use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::environment::Environment;
use crate::environment::levels::{Level, levels, sample};
use crate::optics::{WATER, level_half_angle, mask_intersection};
use crate::rain::cull::{Visibility, drops_with_visibility};
use crate::scene::Scene;
use crate::scene::camera::{Camera, View};

/// A drop's square on the screen, by the rules of `glsl/include/sprite.glsl`.
#[derive(Clone, Copy, Debug)]
pub struct Sprite {
    /// Centre, in pixels from the upper left corner of the image.
    pub center: DVec2,
    /// Edge, in pixels; may be less than the pixel that is drawn.
    pub diameter: f64,
    /// Inverse of the depth: nearer is larger.
    pub nearness: f64,
    /// Distance of the centre from the eye.
    pub distance: f64,
    /// Level of the mask.
    pub level: f64,
    /// Opacity of the whole drop: near fade, and the area that a one-pixel point lacks.
    pub opacity: f64,
    /// From the pose of the preprocessing to world space.
    pub rotation: DMat3,
}

impl Sprite {
    /// The square of a drop whose centre, in view space, is deeper than its radius.
    pub fn new(view: &View, camera: &Camera, center: DVec3, radius: f64) -> Self {
        let (z, d2, r2) = (-center.z, center.length_squared(), radius * radius);
        let flat2 = z * z - r2;
        let offset = DVec2::new(center.x, -center.y) * z / flat2 * view.focal_px;
        let diameter = 2.0 * view.focal_px * radius * (d2 - r2).powf(0.25) / flat2.powf(0.75);
        let shrink = diameter.min(1.0);
        let distance = d2.sqrt();
        let faded = if camera.near_fade > 0.0 {
            let x = ((distance - camera.near) / camera.near_fade).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        } else {
            1.0
        };
        Self {
            center: view.principal + offset,
            diameter,
            nearness: 1.0 / z,
            distance,
            level: 0.5 * ((d2 - r2) / r2).log2(),
            opacity: shrink * shrink * faded,
            rotation: view.to_world() * rotation(center),
        }
    }

    /// Edge of the square that is drawn, in pixels.
    pub fn drawn(&self) -> f64 {
        self.diameter.max(1.0)
    }

    /// Where in the square an image point lies, (0, 0) to (1, 1) from its upper left corner; none
    /// outside.
    pub fn texture_place(&self, point: DVec2) -> Option<DVec2> {
        let at = (point - self.center) / self.drawn() + 0.5;
        (at.min_element() >= 0.0 && at.max_element() < 1.0).then_some(at)
    }
}

/// Equations 1 to 4: from the pose of the preprocessing to view space, for a drop with this centre.
/// The screen's axes carried to the drop's direction by the least rotation.
pub fn rotation(center: DVec3) -> DMat3 {
    let n = -center.normalize();
    let a = 1.0 / (1.0 + n.z);
    DMat3::from_cols(
        DVec3::new(1.0 - n.x * n.x * a, -n.x * n.y * a, -n.x),
        DVec3::new(-n.x * n.y * a, 1.0 - n.y * n.y * a, -n.y),
        n,
    )
}

/// Share of the mask's texel (x, y), in a level of `size` texels an edge, that the drop's disc
/// covers; exact.
pub fn texel_coverage(size: u32, x: u32, y: u32) -> f64 {
    if size == 1 {
        return std::f64::consts::FRAC_PI_4;
    }
    // A texel of a larger level lies in one quadrant, where the area under the arc is known.
    let texel = 2.0 / f64::from(size);
    let along = |index: u32| ((f64::from(index) + 0.5) * texel - 1.0).abs() - 0.5 * texel;
    let (left, low) = (along(x), along(y));
    let (right, high) = (left + texel, low + texel);
    // Where the arc leaves the texel's row through its top, and through its bottom.
    let leaves = |height: f64| (1.0 - height * height).max(0.0).sqrt().clamp(left, right);
    let (full, empty) = (leaves(high), leaves(low));
    let arc = |x: f64| 0.5 * (x * (1.0 - x * x).max(0.0).sqrt() + x.min(1.0).asin());
    let area = (full - left) * texel + arc(empty) - arc(full) - (empty - full) * low;
    area / (texel * texel)
}

/// A texel of both layers: reflected direction and reflectance, transmitted direction and coverage.
fn texel(level: u32, size: u32, x: u32, y: u32) -> [DVec4; 2] {
    let edge = 2.0 / f64::from(size);
    let (s, t) = ((f64::from(x) + 0.5) * edge - 1.0, 1.0 - (f64::from(y) + 0.5) * edge);
    let intersection = mask_intersection(s, t, level_half_angle(level));
    [
        intersection.reflected().extend(intersection.reflectance()),
        intersection.transmitted().extend(texel_coverage(size, x, y)),
    ]
}

fn bilinear(level: u32, size: u32, at: DVec2) -> [DVec4; 2] {
    let place = at * f64::from(size) - 0.5;
    let (corner, weight) = (place.floor(), place - place.floor());
    let clamp = |index: f64| index.clamp(0.0, f64::from(size - 1)) as u32;
    let get = |x: f64, y: f64| texel(level, size, clamp(corner.x + x), clamp(corner.y + y));
    let [a, b, c, d] = [get(0.0, 0.0), get(1.0, 0.0), get(0.0, 1.0), get(1.0, 1.0)];
    [0, 1].map(|i| a[i].lerp(b[i], weight.x).lerp(c[i].lerp(d[i], weight.x), weight.y))
}

/// Both layers of a mask whose finest level has `mask_size` texels an edge, filtered trilinearly.
pub fn sample_mask(mask_size: u32, at: DVec2, level: f64) -> [DVec4; 2] {
    let last = mask_size.ilog2();
    let level = level.clamp(0.0, f64::from(last));
    let fine = level.floor() as u32;
    let coarse = (fine + 1).min(last);
    let [a, b] = [fine, coarse].map(|level| bilinear(level, mask_size >> level, at));
    [0, 1].map(|i| a[i].lerp(b[i], level.fract()))
}

/// Evaluates the paper's model for single pixels of a scene.
pub struct PaperModel {
    view: View,
    mask_size: u32,
    chain: Vec<Level>,
    texel_angle: f64,
}

impl PaperModel {
    /// Prefilters the environment.
    pub fn new(scene: &Scene, environment: &Environment) -> Self {
        Self {
            view: scene.view(),
            mask_size: scene.model.mask_size,
            chain: levels(environment),
            texel_angle: std::f64::consts::PI / f64::from(environment.height()),
        }
    }

    /// The scene's drops in view in the order in which the GPU draws them: points by index, then
    /// those over `point_limit` pixels from back to front.
    pub fn sprites(scene: &Scene, point_limit: f64) -> Vec<Sprite> {
        let view = scene.view();
        let (points, mut quads): (Vec<_>, Vec<_>) = drops_with_visibility(scene)
            .filter(|(_, _, visibility)| *visibility == Visibility::Visible)
            .map(|(center, radius, _)| {
                Sprite::new(&view, &scene.camera, center.as_dvec3(), radius.into())
            })
            .partition(|sprite| sprite.diameter <= point_limit);
        // Equally far ones go by falling index.
        quads.reverse();
        quads.sort_by(|a, b| b.distance.total_cmp(&a.distance));
        points.into_iter().chain(quads).collect()
    }

    /// Radiance of the environment, averaged over about `spread` radians.
    fn radiance(&self, direction: DVec3, spread: f64) -> DVec3 {
        sample(&self.chain, direction, (spread.max(1e-9) / self.texel_angle).log2())
    }

    /// Radiance behind the drops at an image point.
    pub fn sky(&self, point: DVec2) -> DVec3 {
        let far = (point - self.view.principal).length().hypot(self.view.focal_px);
        let spread = (self.view.focal_px / far).sqrt() / far;
        self.radiance(self.view.ray(point.x, point.y), spread)
    }

    /// Radiance and alpha of a drop at a place of its square (equation 5).
    pub fn shade(&self, sprite: &Sprite, at: DVec2) -> (DVec3, f64) {
        let [front, through] = sample_mask(self.mask_size, at, sprite.level);
        let direction = |texel: DVec4| sprite.rotation * texel.truncate().normalize();
        // How far directions fan out over a pixel: see drops.frag.
        let pixels = 0.5 * sprite.drawn();
        let b = (2.0 * at - 1.0).length().clamp(1e-3, 1.0);
        let bn = b / WATER;
        let ci = (1.0 - b * b).max((1.0 / pixels).min(1.0)).sqrt();
        let ct = (1.0 - bn * bn).sqrt();
        let (c, s) = (ci * ct + b * bn, b * ct - ci * bn);
        let fan = 2.0 * (1.0 / ci - 1.0 / (WATER * ct)) * (2.0 * c * s).max(0.0) / b;
        let reflected = self.radiance(direction(front), 2.0 / pixels);
        let transmitted = self.radiance(direction(through), fan.max(0.0).sqrt() / pixels);
        (transmitted.lerp(reflected, front.w), through.w * sprite.opacity)
    }

    /// Radiance at an image point: sprites in the order of drawing over the sky, each behind what is
    /// nearer and was drawn before it.
    pub fn pixel(&self, sprites: &[Sprite], point: DVec2) -> DVec3 {
        let mut radiance = self.sky(point);
        let mut nearest = 0.0;
        for sprite in sprites.iter() {
            let Some(at) = sprite.texture_place(point) else { continue };
            if sprite.nearness <= nearest {
                continue;
            }
            let (color, alpha) = self.shade(sprite, at);
            if alpha > 0.0 {
                radiance = radiance.lerp(color, alpha);
                nearest = sprite.nearness;
            }
        }
        radiance
    }
}
