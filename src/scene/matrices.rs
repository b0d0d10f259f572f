//! A camera from the matrices that engines have: any perspective, off-centre, jittered, with any mapping of depth.

use glam::{DMat4, DVec2, DVec3};

use super::camera::Camera;
use crate::{Error, Result};

/// Where clip space has its upper edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipSpace {
    /// At y = -1, as Vulkan has it.
    YDown,
    /// At y = 1: Direct3D, Metal, WebGPU, and Vulkan with a viewport of negative height.
    YUp,
}

/// How a projection maps distance along the view axis to what a depth image holds: `a + b / distance`. Reversed, infinite
/// and ordinary depth are all of this kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedDepth {
    /// What an infinite distance has.
    pub a: f64,
    /// What is added to it at distance 1.
    pub b: f64,
}

impl ProjectedDepth {
    /// Distance along the view axis of a stored depth; infinite where it is `a`.
    pub fn distance(&self, stored: f64) -> f64 {
        self.b / (stored - self.a)
    }
}

/// How far off square pixels may be: by this part of a pixel at the edge of a picture of 10,000.
const SQUARE: f64 = 1e-5;

impl Camera {
    /// The camera of a view matrix (from world space to eye space, y up) and a projection matrix, for a picture of
    /// `size` pixels, and how the projection maps depth. The eye looks along -z or, as in left-handed engines, along z.
    /// What the matrices do not say is as in [`Camera::default`]: an instant, a pinhole, no near plane for drops.
    ///
    /// # Errors
    /// [`Error::Scene`] for what is no perspective of square pixels: an orthographic or sheared one, a mirrored or scaled
    /// view, a picture upside down.
    pub fn from_matrices(
        view: DMat4,
        projection: DMat4,
        size: (u32, u32),
        clip_space: ClipSpace,
    ) -> Result<(Self, ProjectedDepth)> {
        let refuse = |problem: String| Err(Error::scene("the camera's matrices", problem));
        if !view.is_finite() || !projection.is_finite() {
            return refuse("the matrices hold a number that is not finite".into());
        }
        let m = projection.transpose().to_cols_array_2d(); // by row
        let [.., w] = m;
        let forward_sign = w[2];
        if w[0] != 0.0 || w[1] != 0.0 || w[3] != 0.0 || forward_sign.abs() != 1.0 {
            return refuse(format!(
                "the projection is no perspective: its last row is {w:?}, not 0, 0, ±1, 0"
            ));
        }
        if m[0][1] != 0.0 || m[1][0] != 0.0 || m[0][3] != 0.0 || m[1][3] != 0.0 {
            return refuse("the projection is sheared or rotated".into());
        }
        let down = match clip_space {
            ClipSpace::YDown => 1.0,
            ClipSpace::YUp => -1.0,
        };
        let half = 0.5 * DVec2::new(size.0.into(), size.1.into());
        let (focal_x, focal_y) = (m[0][0] * half.x, -down * m[1][1] * half.y);
        if focal_x <= 0.0 || focal_y <= 0.0 {
            return refuse(
                "the picture is mirrored or upside down: take the other clip space".into(),
            );
        }
        if (focal_x / focal_y - 1.0).abs() > SQUARE {
            return refuse(format!(
                "pixels are not square: the projection has {focal_x:.3} pixels across for {focal_y:.3} down"
            ));
        }
        let from_center = DVec2::new(m[0][2], down * m[1][2]) * forward_sign;

        let to_eye = glam::DMat3::from_mat4(view).transpose();
        let [right, up, along] = [to_eye.x_axis, to_eye.y_axis, to_eye.z_axis * forward_sign];
        let is_unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-5;
        if ![right, up, along].into_iter().all(is_unit) || (right.cross(along) - up).length() > 1e-5
        {
            return refuse(
                "the view is scaled, sheared or mirrored; the world must be right-handed".into(),
            );
        }
        let position = view.inverse().transform_point3(DVec3::ZERO);
        let camera = Self {
            position,
            target: position + along,
            up,
            vertical_fov: 2.0 * (half.y / focal_y).atan().to_degrees(),
            principal: (0.5 + 0.5 * from_center).to_array(),
            ..Self::default()
        };
        // Clip z over clip w, at a distance d: (m22 s d + m23) / d.
        let depth = ProjectedDepth { a: m[2][2] * forward_sign, b: m[2][3] };
        if depth.b == 0.0 {
            return refuse("the projection maps every distance to one depth".into());
        }
        Ok((camera, depth))
    }
}
