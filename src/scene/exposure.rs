//! What moves while the shutter is open: the drops by their velocities, the camera by its own.
//!
//! Only the motion from one to the other is seen. So a picture by a camera that moves is that of one at rest with every
//! velocity less the camera's. A slower pace slows the drops, not the camera.

use glam::DVec3;

use super::model::Motion;
use super::{PlacedDrop, Scene};

impl Scene {
    /// For how long the shutter is open, in the camera's seconds.
    pub fn shutter(&self) -> f64 {
        match self.camera.shutter_angle {
            Some(angle) => angle / 360.0 / self.film.fps.abs(),
            None => self.camera.shutter,
        }
    }

    /// For how long the shutter is open in what is drawn: 0 where an instant is asked for.
    pub(crate) fn drawn_shutter(&self) -> f64 {
        if self.model.motion == Some(Motion::Instant) { 0.0 } else { self.shutter() }
    }

    /// The scene's time that is exposed from `time` on, in seconds; negative where the pace is.
    pub fn exposed(&self) -> f64 {
        self.shutter() * self.pace
    }

    /// The scene's time that drops move for in what is drawn, in seconds: that which is exposed, but none where an
    /// instant is asked for.
    pub fn drawn_exposure(&self) -> f64 {
        self.drawn_shutter() * self.pace
    }

    /// Whether drops may move, as the camera sees them, in what is drawn.
    pub fn is_exposed(&self) -> bool {
        self.drawn_exposure() != 0.0 || self.drawn_camera_motion() != DVec3::ZERO
    }

    /// The time of the drops' places in what is drawn: the middle of the exposure.
    pub fn drawn_time(&self) -> f64 {
        self.time + 0.5 * self.drawn_exposure()
    }

    /// By how much a drop of this velocity moves, as the camera sees it, while the shutter is open; in scene units.
    pub fn motion_of(&self, velocity: DVec3) -> DVec3 {
        self.seen_motion(velocity, self.shutter())
    }

    /// By how much a drop of this velocity moves in what is drawn; in scene units.
    pub fn drawn_motion_of(&self, velocity: DVec3) -> DVec3 {
        self.seen_motion(velocity, self.drawn_shutter())
    }

    fn seen_motion(&self, velocity: DVec3, shutter: f64) -> DVec3 {
        (velocity * self.pace - self.camera.velocity()) * shutter
    }

    /// By how much the camera moves while the shutter is open.
    pub fn camera_motion(&self) -> DVec3 {
        self.camera.velocity() * self.shutter()
    }

    /// Where the motion of `frame`, that number of this scene's film, ends: with its exposure, or, of an instant, with the
    /// next frame. A camera with a velocity of its own moves by that, whatever the film's path.
    pub fn motion_end(&self, frame: &Self, number: u32) -> Self {
        if frame.shutter() > 0.0 {
            let camera = frame.camera.moved_by(frame.camera_motion());
            return Self { time: frame.time + frame.exposed(), camera, ..frame.clone() };
        }
        let mut next = self.film.frame(self, number.saturating_add(1));
        if let Some(velocity) = self.camera.velocity {
            next.camera = frame.camera.moved_by(velocity / self.film.fps.abs());
        }
        next
    }

    fn drawn_camera_motion(&self) -> DVec3 {
        self.camera.velocity() * self.drawn_shutter()
    }

    /// Where the camera is in the middle of what is drawn: drops are culled and drawn around their places at that moment.
    pub fn drawn_position(&self) -> DVec3 {
        self.camera.position + 0.5 * self.drawn_camera_motion()
    }

    /// Where a placed drop is in the middle of what is drawn, in axes that move with the camera and are the world's as the
    /// shutter opens.
    pub fn drawn_center(&self, drop: &PlacedDrop) -> DVec3 {
        drop.center_at(self.time) + 0.5 * self.drawn_motion_of(drop.velocity)
    }

    /// The largest part of its box by which rain in a box moves, as the camera sees it, while the shutter is open; of a
    /// film in any of its frames.
    pub(crate) fn most_crossed(&self) -> f64 {
        let rates = self.film.pace.iter().map(|key| key.rate.abs());
        let fastest = rates.fold(self.pace.abs(), f64::max);
        let of_path = self.path_velocity();
        let parts = self.populations().into_iter().map(|rain| {
            let motion = match self.film.pace.is_empty() && of_path == DVec3::ZERO {
                true => self.motion_of(rain.velocity).abs(),
                false => {
                    let of_camera = self.camera.velocity().abs().max(of_path);
                    (rain.velocity.abs() * fastest + of_camera) * self.shutter()
                }
            };
            (motion / (2.0 * rain.half_extent)).max_element()
        });
        parts.fold(0.0, f64::max)
    }

    /// The largest velocity on each axis, backwards or forwards, that the camera has by the film's path; 0 where it has a
    /// velocity of its own.
    pub(super) fn path_velocity(&self) -> DVec3 {
        match self.camera.velocity {
            Some(_) => DVec3::ZERO,
            None => self.film.fastest(),
        }
    }
}
