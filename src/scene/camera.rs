//! The eye: where it is, what it sees, and what a pixel's ray is.

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::projection::View;

/// A camera with a thin lens and a shutter, as the scene file gives it; a pinhole and an instant where
/// nothing is said of them. Right-handed, y up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Where the eye is.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units"))]
    pub position: DVec3,
    /// A point that it looks at, other than its position.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units"))]
    pub target: DVec3,
    /// Which way is up in the picture; need not be perpendicular to the view, and may be along it.
    #[schemars(with = "[f64; 3]")]
    pub up: DVec3,
    /// Angle between the upper and the lower edge of the picture.
    #[schemars(range(min = 0.01, max = 175.0), extend("x-unit" = "degrees"))]
    pub vertical_fov: f64,
    /// Drops whose centre is nearer to the camera than this, along the ray, are not drawn (the paper's near plane).
    #[schemars(range(min = 0), extend("x-unit" = "scene units"))]
    pub near: f64,
    /// Over this distance beyond `near` drops fade in (the paper's section 5).
    #[schemars(range(min = 0), extend("x-unit" = "scene units"))]
    pub near_fade: f64,
    /// For how long the shutter is open from `time` on, in the camera's seconds; 0: an instant. The scene time that is
    /// exposed is this times the film's pace. While it is open the rain may cross its box 16 times, and on tiles a quarter of it.
    #[schemars(range(min = 0), extend("x-unit" = "s"))]
    pub shutter: f64,
    /// Instead of `shutter`, as a share of a film's frame: the shutter is open for angle / 360 / fps.
    #[schemars(range(min = 0, max = 360), extend("x-unit" = "degrees"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter_angle: Option<f64>,
    /// Its velocity while the shutter is open, constant, in scene units a second of its own whatever the pace; up to 1e6.
    #[schemars(with = "Option<[f64; 3]>", extend("x-unit" = "scene units/s", "x-default" = "that of a film's path, else 0 0 0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<DVec3>,
    /// The lens's diameter; 0: a pinhole. Presets draw up to 1e6.
    #[schemars(range(min = 0), extend("x-unit" = "scene units"))]
    pub aperture: f64,
    /// Distance along the view axis of the plane in focus. With an aperture presets draw 1e-6 and more.
    #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true, "x-unit" = "scene units", "x-advice" = "it is a distance before the camera"))]
    pub focus: f64,
    /// Left, top, right and bottom edge of what is drawn, as parts of the whole picture; they fall on pixels' edges.
    /// `image` stays the whole's size.
    #[schemars(extend("minimum" = 0, "maximum" = 1, "default" = WHOLE))]
    #[serde(skip_serializing_if = "is_whole")]
    pub window: [f64; 4],
    /// Where the view axis meets the whole picture, as parts of its width and height from the upper left corner: beside
    /// the middle for an off-centre or a jittered projection, which keeps the angle's focal length.
    #[schemars(extend("minimum" = -10, "maximum" = 10, "default" = CENTERED))]
    #[serde(skip_serializing_if = "is_centered")]
    pub principal: [f64; 2],
}

/// Fastest camera, in scene units a second: beyond it float32 leaves a streak too few digits.
pub const FASTEST: f64 = 1e6;

/// The principal point in the middle of the picture.
const CENTERED: [f64; 2] = [0.5, 0.5];

fn is_centered(principal: &[f64; 2]) -> bool {
    *principal == CENTERED
}

/// The window of the whole picture.
pub const WHOLE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];

fn is_whole(window: &[f64; 4]) -> bool {
    *window == WHOLE
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            position: DVec3::ZERO,
            target: DVec3::NEG_Z,
            up: DVec3::Y,
            vertical_fov: 90.0,
            near: 0.0,
            near_fade: 0.0,
            shutter: 0.0,
            shutter_angle: None,
            velocity: None,
            aperture: 0.0,
            focus: 5.0,
            window: WHOLE,
            principal: CENTERED,
        }
    }
}

impl Camera {
    /// Checks the shutter and the velocity; a problem is an error in words.
    pub(crate) fn validate_exposure(&self) -> Result<(), String> {
        if self.shutter_angle.is_some() && self.shutter != 0.0 {
            return Err("camera: give shutter or shutter_angle, not both".into());
        }
        let DVec3 { x, y, z } = self.velocity();
        if self.velocity().length() > FASTEST {
            return Err(format!(
                "camera: velocity = [{x}, {y}, {z}] is not up to {FASTEST:e} scene units a second"
            ));
        }
        Ok(())
    }

    /// Its velocity, in scene units a second of its own.
    pub fn velocity(&self) -> DVec3 {
        self.velocity.unwrap_or(DVec3::ZERO)
    }

    /// The camera elsewhere, looking in the same direction.
    pub fn moved_by(&self, way: DVec3) -> Self {
        Self { position: self.position + way, target: self.target + way, ..*self }
    }

    /// Unit vector of the view direction.
    pub fn forward(&self) -> DVec3 {
        (self.target - self.position).normalize_or(DVec3::NEG_Z)
    }

    /// The camera's frame for the window of a whole picture of this size. Edges of the window that fall on no pixels'
    /// edges are taken to the nearest, which [`crate::scene::Scene::validate`] sees to be the same.
    ///
    /// Looking straight along `up` leaves the roll open; the axis least along the view then stands
    /// in for `up` (z before x before y), so that the picture is defined for every direction.
    pub fn view(&self, width: u32, height: u32) -> View {
        let forward = self.forward();
        let stand_in = [DVec3::Z, DVec3::X, DVec3::Y]
            .into_iter()
            .min_by(|a, b| a.dot(forward).abs().total_cmp(&b.dot(forward).abs()))
            .unwrap_or(DVec3::Z);
        // Under 10⁻⁸ rad from `up` the cross product's direction is rounding noise.
        let right = forward
            .cross(self.up.normalize_or(DVec3::Y))
            .try_normalize()
            .filter(|_| forward.cross(self.up.normalize_or(DVec3::Y)).length() > 1e-8)
            .unwrap_or_else(|| forward.cross(stand_in).normalize());
        let edge = |part: f64, pixels: u32| (part * f64::from(pixels)).round() as u32;
        let [left, top] = [edge(self.window[0], width), edge(self.window[1], height)];
        let [right_edge, bottom] = [edge(self.window[2], width), edge(self.window[3], height)];
        let whole = DVec2::new(width.into(), height.into());
        View {
            position: self.position,
            right,
            up: right.cross(forward),
            back: -forward,
            whole: [width, height],
            origin: [left, top],
            width: right_edge.saturating_sub(left).max(1),
            height: bottom.saturating_sub(top).max(1),
            principal: DVec2::from(self.principal) * whole - DVec2::new(left.into(), top.into()),
            focal_px: 0.5 * whole.y / (0.5 * self.vertical_fov.to_radians()).tan(),
        }
    }
}
