//! The eye: where it is, what it sees, and what a pixel's ray is.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

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
    /// The lens's diameter, in scene units; 0: a pinhole.
    pub aperture: f64,
    /// Distance along the view axis of the plane in focus, in scene units; may be infinite.
    pub focus: f64,
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
            aperture: 0.0,
            focus: 5.0,
        }
    }
}

/// A camera and an image size, resolved: an orthonormal frame and the scale of the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is, in scene units.
    pub position: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Unit vector towards the viewer, against the view direction.
    pub back: DVec3,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Distance of the image plane in pixels: half the height times cot(fov/2). A length of 1 at
    /// depth 1 covers this many pixels.
    pub focal_px: f64,
}

impl Camera {
    /// Checks shutter and lens; the problem is told in words.
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
        // Infinity is a focus.
        if self.focus.is_nan() || self.focus <= 0.0 {
            return Err(format!(
                "camera: focus = {} is not before the camera; it is a distance over 0, or inf",
                self.focus
            ));
        }
        Ok(())
    }

    /// Unit vector of the view direction.
    pub fn forward(&self) -> DVec3 {
        (self.target - self.position).normalize_or(DVec3::NEG_Z)
    }

    /// The camera's frame for an image of this size.
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
        View {
            position: self.position,
            right,
            up: right.cross(forward),
            back: -forward,
            width,
            height,
            focal_px: 0.5 * f64::from(height) / (0.5 * self.vertical_fov.to_radians()).tan(),
        }
    }
}

impl View {
    /// Columns right, up, back: view space to world space.
    pub fn to_world(&self) -> DMat3 {
        DMat3::from_cols(self.right, self.up, self.back)
    }

    /// Unit direction in world space of the ray through image point (x, y), in pixels from the
    /// upper left corner; the middle of the first pixel is (0.5, 0.5).
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        let right = x - 0.5 * f64::from(self.width);
        let up = 0.5 * f64::from(self.height) - y;
        (right * self.right + up * self.up - self.focal_px * self.back).normalize()
    }

    /// Column and row of the pixel that a direction in world space falls into; `None` beside the
    /// picture and behind the camera.
    pub fn pixel(&self, direction: DVec3) -> Option<(u32, u32)> {
        let scale = self.focal_px / -direction.dot(self.back);
        let x = 0.5 * f64::from(self.width) + scale * direction.dot(self.right);
        let y = 0.5 * f64::from(self.height) - scale * direction.dot(self.up);
        let is_seen = scale > 0.0
            && (0.0..f64::from(self.width)).contains(&x)
            && (0.0..f64::from(self.height)).contains(&y);
        is_seen.then_some((x as u32, y as u32))
    }

    /// Largest tangent of the half-angles of the picture, horizontal and vertical.
    pub fn tan_half_angles(&self) -> (f64, f64) {
        (0.5 * f64::from(self.width) / self.focal_px, 0.5 * f64::from(self.height) / self.focal_px)
    }
}
