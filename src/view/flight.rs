//! Flying: the camera moved by keys and turned by the mouse.

use std::collections::HashSet;
use std::f64::consts::FRAC_1_SQRT_2;
use std::time::Duration;

use glam::{DQuat, DVec3};
use winit::keyboard::KeyCode;

use super::nearest::nearest;
use crate::scene::Scene;
use crate::scene::camera::{Camera, View};

/// Radians a pixel of mouse movement turns.
const RADIANS_PER_PX: f64 = 0.004;

/// Radians a second that arrow keys turn.
const RADIANS_PER_SECOND: f64 = 1.0;

/// The view stays this far from straight up and down, where turning left and right has no meaning.
const POLE_RADIANS: f64 = 0.01;

/// Drop radii between the eye and the middle of a drop that was flown to.
pub const VISIT_RADII: f64 = 4.0;

/// The keys that are held, and how fast they move the camera.
#[derive(Debug)]
pub struct Flight {
    held: HashSet<KeyCode>,
    /// Scene units a second.
    pub speed: f64,
}

impl Flight {
    /// At rest, with a speed that suits the scene: twenty radii of its smallest drop a second.
    pub fn new(scene: &Scene) -> Self {
        let radii = scene.placed().map(|drop| drop.radius);
        let falling = scene.populations().into_iter().map(|rain| rain.radius);
        let least = radii.chain(falling).fold(f64::INFINITY, f64::min);
        Self { held: HashSet::new(), speed: 20.0 * if least.is_finite() { least } else { 1.0 } }
    }

    /// A key went down or up.
    pub fn key(&mut self, code: KeyCode, is_down: bool) {
        if is_down {
            self.held.insert(code);
        } else {
            self.held.remove(&code);
        }
    }

    /// No key is held any more: the window has lost the keyboard, and will not hear of releases.
    pub fn release(&mut self) {
        self.held.clear();
    }

    /// Whether a key that moves is held.
    pub fn is_moving(&self) -> bool {
        self.wish() != DVec3::ZERO || self.turn() != (0.0, 0.0)
    }

    fn along(&self, positive: KeyCode, negative: KeyCode) -> f64 {
        f64::from(self.held.contains(&positive)) - f64::from(self.held.contains(&negative))
    }

    /// Right, up, forward.
    fn wish(&self) -> DVec3 {
        DVec3::new(
            self.along(KeyCode::KeyD, KeyCode::KeyA),
            self.along(KeyCode::KeyE, KeyCode::KeyQ),
            self.along(KeyCode::KeyW, KeyCode::KeyS),
        )
    }

    fn turn(&self) -> (f64, f64) {
        (
            self.along(KeyCode::ArrowLeft, KeyCode::ArrowRight),
            self.along(KeyCode::ArrowUp, KeyCode::ArrowDown),
        )
    }

    /// Moves and turns by the keys held for `elapsed`.
    pub fn fly(&self, camera: &mut Camera, elapsed: Duration) {
        let seconds = elapsed.as_secs_f64();
        let (wish, turn) = (self.wish(), self.turn());
        if wish != DVec3::ZERO {
            let fast = self.held.contains(&KeyCode::ShiftLeft);
            let view = camera.view(1, 1);
            let step = (wish.x * view.right + wish.y * view.up - wish.z * view.back)
                * (self.speed * seconds * if fast { 10.0 } else { 1.0 });
            camera.position += step;
            camera.target += step;
        }
        if turn != (0.0, 0.0) {
            let radians = RADIANS_PER_SECOND * seconds;
            rotate(camera, radians * turn.0, radians * turn.1);
        }
    }
}

/// Turns by a movement of the mouse in pixels, as if the picture were dragged along.
pub fn drag(camera: &mut Camera, (right, down): (f64, f64)) {
    rotate(camera, RADIANS_PER_PX * right, RADIANS_PER_PX * down);
}

/// Turns to the left about `up`, then upwards.
fn rotate(camera: &mut Camera, left: f64, up: f64) {
    let axis = camera.up.normalize_or(DVec3::Y);
    let (forward, distance) = (camera.forward(), camera.position.distance(camera.target));
    let height = forward.angle_between(axis);
    let up = height - (height - up).clamp(POLE_RADIANS, std::f64::consts::PI - POLE_RADIANS);
    let right = camera.view(1, 1).right;
    let turned = DQuat::from_axis_angle(axis, left) * DQuat::from_axis_angle(right, up) * forward;
    camera.target = camera.position + distance * turned;
}

/// Flies up to the nearest drop within 45 degrees of the view's middle, and looks at it from
/// [`VISIT_RADII`]. False if no drop is there.
pub fn visit(scene: &mut Scene) -> bool {
    let camera = scene.camera;
    let forward = camera.forward();
    let Some((center, radius)) = nearest(scene, |center, radius| {
        let distance = center.length();
        let is_ahead = center.dot(forward) > FRAC_1_SQRT_2 * distance && distance > 1.5 * radius;
        if is_ahead { distance } else { f64::INFINITY }
    }) else {
        return false;
    };
    let target = camera.position + center;
    scene.camera.target = target;
    scene.camera.position = target - center.normalize() * (VISIT_RADII * radius);
    // The near plane would cut away what was flown to.
    scene.camera.near = scene.camera.near.min(radius);
    scene.camera.near_fade = 0.0;
    true
}

/// Turns until what a visit has brought to the middle of the picture is in the middle of the wider part beside what
/// covers the columns from `left` to `right`, in pixels, if that is in front of it.
pub fn look_past(camera: &mut Camera, view: &View, [left, right]: [f64; 2]) {
    let (width, radius) = (f64::from(view.whole[0]), view.focal_px / VISIT_RADII);
    let middle = 0.5 * width;
    if right <= middle - radius || left >= middle + radius {
        return;
    }
    let free = if width - right > left { 0.5 * (right + width) } else { 0.5 * left };
    rotate(camera, ((free - middle) / view.focal_px).atan(), 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::real_rain::RealRain;
    use crate::scene::{ImageSize, PlacedDrop, RainSettings};

    #[test]
    fn keys_move_along_the_view() {
        let mut scene = Scene::default();
        let mut flight = Flight::new(&scene);
        flight.key(KeyCode::KeyW, true);
        flight.fly(&mut scene.camera, Duration::from_millis(500));
        assert!(scene.camera.position.distance(DVec3::new(0.0, 0.0, -10.0)) < 1e-12);
        assert!(scene.camera.target.distance(DVec3::new(0.0, 0.0, -11.0)) < 1e-12);
        flight.release();
        assert!(!flight.is_moving());
    }

    #[test]
    fn turning_stops_short_of_the_pole() {
        let mut camera = Camera::default();
        for _ in 0..1000 {
            drag(&mut camera, (3.0, 100.0));
        }
        let up = camera.forward().y;
        assert!((0.999..1.0).contains(&up), "{up}");
        drag(&mut camera, (0.0, -1000.0));
        assert!(camera.forward().y < 0.0, "and there is a way back");
    }

    #[test]
    fn a_visit_ends_in_front_of_the_drop() {
        let drop = PlacedDrop::sphere(DVec3::new(3.0, 0.0, -40.0), 0.5);
        let mut scene = Scene { rain: None, drops: vec![drop], ..Scene::default() };
        assert!(visit(&mut scene));
        let distance = scene.camera.position.distance(drop.center);
        assert!((distance - VISIT_RADII * drop.radius).abs() < 1e-9, "{distance}");
        scene.camera = Camera { target: DVec3::Z, ..Camera::default() };
        assert!(!visit(&mut scene), "it is behind");
    }

    #[test]
    fn a_panel_does_not_cover_what_was_flown_to() {
        let drop = PlacedDrop::sphere(DVec3::new(3.0, 0.0, -40.0), 0.5);
        let image = ImageSize { width: 800, height: 600 };
        let mut scene = Scene { rain: None, drops: vec![drop], image, ..Scene::default() };
        let mut look = |covered: [f64; 2]| {
            assert!(visit(&mut scene));
            let view = scene.view();
            look_past(&mut scene.camera, &view, covered);
            scene.view().point(drop.center - scene.camera.position).0.x
        };
        assert!((look([12.0, 350.0]) - 575.0).abs() < 1e-6, "to the right of it");
        assert!((look([450.0, 788.0]) - 225.0).abs() < 1e-6, "to the left of it");
        assert!((look([12.0, 150.0]) - 400.0).abs() < 1e-6, "it does not cover the drop");
    }

    /// A visit finds drops of real rain, too.
    #[test]
    fn a_drop_of_real_rain_is_visited() {
        let rain = RainSettings::of(RealRain { rate: 25.0, ..RealRain::default() });
        let mut scene = Scene { rain: Some(rain), ..Scene::default() };
        let before = scene.camera;
        assert!(visit(&mut scene));
        let flown = before.position.distance(scene.camera.position);
        assert!((0.0..5.0).contains(&flown), "{flown}");
        assert!(scene.camera.forward().dot(before.forward()) > 0.7);
    }
}
