//! The eye: where it is, what it sees, and what a pixel's ray is.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

pub use super::projection::View;

/// A camera with a thin lens and a shutter, as the scene file gives it; a pinhole and an instant where
/// nothing is said of them. Right-handed, y up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Where the eye is, in scene units.
    pub position: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// Which way is up in the picture; need not be perpendicular to the view.
    pub up: DVec3,
    /// Angle between the upper and the lower edge of the picture, in degrees.
    pub vertical_fov: f64,
    /// Drops whose centre is nearer than this are not drawn, in scene units (the paper's near plane).
    pub near: f64,
    /// Over this distance beyond `near` drops fade in, in scene units (the paper's section 5).
    pub near_fade: f64,
    /// For how long the shutter is open from `time` on, in the camera's seconds; 0: an instant.
    pub shutter: f64,
    /// The same as a share of a film's frame, in degrees: shutter = angle / 360 / fps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter_angle: Option<f64>,
    /// Its velocity while the shutter is open, in scene units a second of its own; none: that of a film's path, else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<DVec3>,
    /// The lens's diameter, in scene units; 0: a pinhole.
    pub aperture: f64,
    /// Distance along the view axis of the plane in focus, in scene units; may be infinite.
    pub focus: f64,
    /// Left, top, right and bottom edge of what is drawn, as parts of the whole picture; they fall on pixels.
    #[serde(skip_serializing_if = "is_whole")]
    pub window: [f64; 4],
    /// Where the view axis meets the whole picture, as parts of its width and height from the upper left corner: beside
    /// the middle for an off-centre or a jittered projection, which keeps the angle's focal length.
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
    /// Checks shutter and lens; a problem is an error in words.
    pub(crate) fn validate_exposure(&self) -> Result<(), String> {
        let at_least_0 = |name: &str, value: f64| match value.is_finite() && value >= 0.0 {
            true => Ok(()),
            false => Err(format!("camera: {name} = {value} is not finite and at least 0")),
        };
        at_least_0("shutter", self.shutter)?;
        at_least_0("aperture", self.aperture)?;
        if let Some(angle) = self.shutter_angle {
            if !(0.0..=360.0).contains(&angle) {
                return Err(format!(
                    "camera: shutter_angle = {angle} is not within 0 to 360 degrees"
                ));
            }
            if self.shutter != 0.0 {
                return Err("camera: give shutter or shutter_angle, not both".into());
            }
        }
        let DVec3 { x, y, z } = self.velocity();
        if !self.velocity().is_finite() || self.velocity().length() > FASTEST {
            return Err(format!(
                "camera: velocity = [{x}, {y}, {z}] is not finite and up to {FASTEST:e} scene units a second"
            ));
        }
        // Infinity is a focus.
        if self.focus.is_nan() || self.focus <= 0.0 {
            return Err(format!(
                "camera: focus = {} is not before the camera; it is a distance over 0, or inf",
                self.focus
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
