//! The rays of the camera: from a place on the lens, at a moment of the exposure, through a place in a
//! pixel.
//!
//! The lens is thin and without faults: all rays through one place of the picture meet in the plane of
//! focus. Places are from where the camera is: what it moves by is in the motion of the drops.

use glam::{DVec2, DVec3};

use super::drops::fade;
use super::samples::Sample;
use crate::scene::Scene;
use crate::scene::camera::View;

/// A ray relative to the camera, along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins, in scene units.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// When, as a share of the exposure, 0 to 1.
    pub moment: f64,
}

impl Ray {
    /// From the camera's place as the shutter opens.
    pub fn along(direction: DVec3) -> Self {
        Self { origin: DVec3::ZERO, direction, moment: 0.0 }
    }
}

/// Frame, lens and near plane of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// The frame and the image plane.
    pub view: View,
    /// Radius of the lens, in scene units; 0: a pinhole.
    pub lens: f64,
    /// Depth of the plane in focus, in scene units.
    pub focus: f64,
    /// Drops whose centre is nearer are not drawn.
    pub near: f64,
    /// Over this distance beyond they fade in.
    pub near_fade: f64,
}

impl Eye {
    /// The eye of a validated scene.
    pub fn of_scene(scene: &Scene) -> Self {
        let camera = &scene.camera;
        Self {
            lens: 0.5 * camera.aperture,
            focus: camera.focus,
            near: camera.near,
            near_fade: camera.near_fade,
            ..Self::pinhole(scene.view())
        }
    }

    /// A pinhole without a near plane.
    pub fn pinhole(view: View) -> Self {
        Self { view, lens: 0.0, focus: f64::INFINITY, near: 0.0, near_fade: 0.0 }
    }

    /// The ray of a sample of the pixel in column `x` and row `y`.
    pub fn ray(&self, x: u32, y: u32, sample: &Sample) -> Ray {
        let direction = self.view.ray(f64::from(x) + sample.x, f64::from(y) + sample.y);
        let moment = sample.moment;
        if self.lens == 0.0 {
            return Ray { origin: DVec3::ZERO, direction, moment };
        }
        let DVec2 { x: right, y: up } = self.lens * sample.lens;
        let origin = right * self.view.right + up * self.view.up;
        // Over the distance to the focus, so that an infinite one is no special case.
        let depth = -direction.dot(self.view.back);
        let direction = (direction / depth - origin / self.focus).normalize();
        Ray { origin, direction, moment }
    }

    /// Opacity of a drop whose centre is here.
    pub fn opacity(&self, center: DVec3) -> f64 {
        fade(center.length(), self.near, self.near_fade)
    }
}
