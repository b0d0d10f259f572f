//! A film of a scene: where the camera is and how fast the rain falls at every moment of it.
//!
//! *Film time* is what the viewer's watch shows: frame n is at n / fps seconds. *Scene time* is the
//! rain's; where `pace` is 0 the drops hang in the air while the camera goes on.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::Scene;
use crate::scene::camera::Camera;

/// A film: camera keys and pace keys, in any number.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Film {
    /// Frames a second of film time, not 0; negative runs backwards, from the last key or without keys from 0.
    pub fps: f64,
    /// Where the camera is: keys `at` (film seconds, each later than the last), `position`, `target`, `vertical_fov`
    /// (default: as the key before). It passes each key at its time, smoothly, and while the shutter is open it has the
    /// velocity of its path. Without keys it stands where the scene has it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub camera: Vec<CameraKey>,
    /// How fast the rain falls: keys `at` (film seconds), `rate` (scene seconds a second; 0 stands still), linear between
    /// keys and constant outside. Without keys as in the world.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pace: Vec<PaceKey>,
}

/// The camera at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Film time, later than that of the key before.
    #[schemars(extend("x-unit" = "s"))]
    pub at: f64,
    /// Where the eye is; it passes each key at its time, smoothly.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units"))]
    pub position: DVec3,
    /// What it looks at.
    #[schemars(with = "[f64; 3]", extend("x-unit" = "scene units"))]
    pub target: DVec3,
    /// Angle between the upper and the lower edge of the picture.
    #[schemars(range(min = 0.01, max = 175.0), extend("x-unit" = "degrees", "x-default" = "as the key before, or as the scene"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_fov: Option<f64>,
}

/// The pace at one moment; between two it changes evenly.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaceKey {
    /// Film time, later than that of the key before.
    #[schemars(extend("x-unit" = "s"))]
    pub at: f64,
    /// Scene seconds a second of film; 0 stands still, negative runs backwards.
    pub rate: f64,
}

impl Default for Film {
    fn default() -> Self {
        Self { fps: 30.0, camera: Vec::new(), pace: Vec::new() }
    }
}

impl Film {
    /// Whether nothing was said of a film.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every value; a problem is an error in words.
    pub(crate) fn validate(&self) -> Result<(), String> {
        if self.fps == 0.0 {
            return Err("film: fps = 0 shows no frame".into());
        }
        let camera = self.camera.iter().map(|key| key.at).collect();
        let pace = self.pace.iter().map(|key| key.at).collect();
        for (name, times) in [("camera", camera), ("pace", pace)] {
            let times: Vec<f64> = times;
            let rises = times.windows(2).all(|pair| pair[0] < pair[1]);
            if !rises {
                return Err(format!("film: each {name} key must be at a later time than the last"));
            }
        }
        match self.camera.iter().find(|key| key.position == key.target) {
            Some(key) => Err(format!(
                "film: camera key at {}: position and target are the same point",
                key.at
            )),
            None => Ok(()),
        }
    }

    /// Frames up to and with the last key; 1 without keys.
    pub fn frames(&self) -> u32 {
        // The last key may be at a frame, but for the rounding of its time.
        let number = (self.seconds() * self.fps.abs() - 1e-9).ceil();
        1 + number.clamp(0.0, f64::from(u32::MAX - 1)) as u32
    }

    /// Film time of the last key, in seconds; 0 without keys.
    fn seconds(&self) -> f64 {
        let last = self.camera.last().map(|key| key.at).into_iter();
        last.chain(self.pace.last().map(|key| key.at)).fold(0.0, f64::max)
    }

    /// `scene` as frame `number` shows it.
    pub fn frame(&self, scene: &Scene, number: u32) -> Scene {
        let first = if self.fps < 0.0 { self.seconds() } else { 0.0 };
        let at = first + f64::from(number) / self.fps;
        let seconds = self.scene_seconds(at);
        Scene {
            time: scene.time + seconds,
            pace: self.pace_at(at),
            camera: self.camera_at(&scene.camera, at),
            pane: scene.pane.as_ref().map(|pane| pane.after(seconds)),
            ..scene.clone()
        }
    }

    /// A frame as a scene of its own, without the film: what is exposed at the frame's pace is exposed at a pace of 1.
    pub fn still(frame: &Scene) -> Scene {
        let exposed = frame.exposed();
        let mut still = Scene { time: frame.time + exposed.min(0.0), pace: 1.0, ..frame.clone() };
        (still.camera.shutter, still.camera.shutter_angle) = (exposed.abs(), None);
        still.film = Self { fps: frame.film.fps.abs(), ..Self::default() };
        let velocity = frame.camera.velocity();
        still.camera.velocity = None;
        if velocity != DVec3::ZERO && frame.pace == 0.0 {
            // Only a film has a camera that moves through drops that stand.
            (still.camera.shutter, still.camera.velocity) = (frame.shutter(), Some(velocity));
            still.film.pace = vec![PaceKey { at: 0.0, rate: 0.0 }];
        } else if velocity != DVec3::ZERO {
            still.camera.velocity = Some(velocity / frame.pace);
            if exposed < 0.0 {
                // What was exposed last comes first.
                still.camera = still.camera.moved_by(frame.camera_motion());
            }
        }
        still
    }

    /// Scene seconds a second of film at film time `at`.
    pub fn pace_at(&self, at: f64) -> f64 {
        let (Some(first), Some(last)) = (self.pace.first(), self.pace.last()) else { return 1.0 };
        if at <= first.at {
            return first.rate;
        }
        for pair in self.pace.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            if at < to.at {
                return from.rate + (to.rate - from.rate) * (at - from.at) / (to.at - from.at);
            }
        }
        last.rate
    }

    /// Its slowest pace, forwards or backwards: 0 if the drops stand still at any time.
    pub(crate) fn least_pace(&self) -> f64 {
        let turns = self.pace.windows(2).any(|pair| pair[0].rate * pair[1].rate <= 0.0);
        let slowest = self.pace.iter().map(|key| key.rate.abs()).reduce(f64::min);
        if turns { 0.0 } else { slowest.unwrap_or(1.0) }
    }

    /// Scene time that goes by from film time 0 to `at`: the integral of the pace, in closed form (it
    /// is linear between keys, constant before the first and after the last), so that every frame is
    /// right by itself.
    pub fn scene_seconds(&self, at: f64) -> f64 {
        self.integral(at) - self.integral(0.0)
    }

    /// The integral of the pace from its first key to `at`.
    fn integral(&self, at: f64) -> f64 {
        let (Some(first), Some(last)) = (self.pace.first(), self.pace.last()) else { return at };
        if at <= first.at {
            return (at - first.at) * first.rate;
        }
        let mut sum = 0.0;
        for pair in self.pace.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let span = to.at - from.at;
            if at < to.at {
                let part = at - from.at;
                return sum + part * (from.rate + 0.5 * part * (to.rate - from.rate) / span);
            }
            sum += 0.5 * span * (from.rate + to.rate);
        }
        sum + (at - last.at) * last.rate
    }

    /// The camera at film time `at`: through every key at its time, with a velocity that does not
    /// jump (cubic Hermite, Catmull-Rom's tangents for keys at uneven times). It starts and ends at
    /// rest, and stands still between two keys that are alike.
    pub fn camera_at(&self, scene: &Camera, at: f64) -> Camera {
        let mut fov = scene.vertical_fov;
        let keys: Vec<Key> = self
            .camera
            .iter()
            .map(|key| {
                fov = key.vertical_fov.unwrap_or(fov);
                Key { at: key.at, value: [key.position, key.target, DVec3::splat(fov)] }
            })
            .collect();
        let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return *scene };
        let next = keys.partition_point(|key| key.at <= at);
        let (value, velocity) = match next {
            0 => (first.value, DVec3::ZERO),
            next if next == keys.len() => (last.value, DVec3::ZERO),
            next => (hermite(&keys, next - 1, at), velocity(&keys, next - 1, at)),
        };
        let [position, target, fov] = value;
        let velocity = scene.velocity.or(Some(velocity));
        Camera { position, target, vertical_fov: fov.x, velocity, ..*scene }
    }

    /// At least the largest velocity on each axis, backwards or forwards, that the camera has on its path.
    pub(super) fn fastest(&self) -> DVec3 {
        let key =
            |key: &CameraKey| Key { at: key.at, value: [key.position, key.target, DVec3::ZERO] };
        let keys: Vec<Key> = self.camera.iter().map(key).collect();
        let all = (1..keys.len()).flat_map(|next| velocities(&keys, next - 1));
        all.fold(DVec3::ZERO, |most, velocity| most.max(velocity.abs()))
    }
}

/// Position, target and (three times) the field of view.
#[derive(Clone, Copy)]
struct Key {
    at: f64,
    value: [DVec3; 3],
}

/// The place of the field of view in a key's values.
const FIELD_OF_VIEW: usize = 2;

/// Between keys `number` and `number + 1`.
fn hermite(keys: &[Key], number: usize, at: f64) -> [DVec3; 3] {
    let (from, to) = (keys[number], keys[number + 1]);
    let span = to.at - from.at;
    let t = (at - from.at) / span;
    let [m0, m1] = [number, number + 1].map(|number| tangents(keys, number));
    std::array::from_fn(|i| {
        let (t2, t3) = (t * t, t * t * t);
        // In this form what is alike at both keys stays so to the bit.
        from.value[i]
            + (3.0 * t2 - 2.0 * t3) * (to.value[i] - from.value[i])
            + span * ((t3 - 2.0 * t2 + t) * m0[i] + (t3 - t2) * m1[i])
    })
}

/// The camera's velocity between keys `number` and `number + 1`: the derivative of [`hermite`].
fn velocity(keys: &[Key], number: usize, at: f64) -> DVec3 {
    let (from, to) = (keys[number], keys[number + 1]);
    let t = (at - from.at) / (to.at - from.at);
    let [a, b, c] = velocities(keys, number);
    (1.0 - t) * (1.0 - t) * a + 2.0 * t * (1.0 - t) * b + t * t * c
}

/// The velocities between two keys as the control points of a parabola, which lies within their hull (Bézier).
fn velocities(keys: &[Key], number: usize) -> [DVec3; 3] {
    let (from, to) = (keys[number], keys[number + 1]);
    let [[m0, ..], [m1, ..]] = [number, number + 1].map(|number| tangents(keys, number));
    let mean = (to.value[0] - from.value[0]) / (to.at - from.at);
    [m0, 3.0 * mean - m0 - m1, m1]
}

/// Velocities at a key: those of the parabola through it and its neighbours; 0 at the ends, and where
/// a neighbour is alike. The field of view's is bounded so that it stays between its keys: a zoom that swings beyond
/// them may reach 0 degrees (Fritsch and Carlson 1980).
fn tangents(keys: &[Key], number: usize) -> [DVec3; 3] {
    let (Some(next), Some(last)) = (keys.get(number + 1), number.checked_sub(1)) else {
        return [DVec3::ZERO; 3];
    };
    let (last, key) = (&keys[last], &keys[number]);
    if last.value == key.value || next.value == key.value {
        return [DVec3::ZERO; 3];
    }
    let (before, after) = (key.at - last.at, next.at - key.at);
    std::array::from_fn(|i| {
        let slopes =
            [(key.value[i] - last.value[i]) / before, (next.value[i] - key.value[i]) / after];
        let tangent = (after * slopes[0] + before * slopes[1]) / (before + after);
        if i != FIELD_OF_VIEW {
            return tangent;
        }
        let is_turn = slopes[0].x * slopes[1].x <= 0.0;
        let most = if is_turn { DVec3::ZERO } else { 3.0 * slopes[0].abs().min(slopes[1].abs()) };
        tangent.clamp(-most, most)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(keys: &[(f64, f64)]) -> Film {
        let pace = keys.iter().map(|(at, rate)| PaceKey { at: *at, rate: *rate }).collect();
        Film { pace, ..Film::default() }
    }

    fn path(keys: &[(f64, DVec3)]) -> Film {
        let key = |(at, position): &(f64, DVec3)| CameraKey {
            at: *at,
            position: *position,
            target: *position - DVec3::Z,
            vertical_fov: None,
        };
        Film { camera: keys.iter().map(key).collect(), ..Film::default() }
    }

    const BENDS: [(f64, DVec3); 4] =
        [(0.0, DVec3::ZERO), (1.0, DVec3::X), (1.5, DVec3::ONE), (4.0, DVec3::new(9.0, 0.0, 1.0))];

    /// Forwards, at rest and backwards.
    #[test]
    fn a_still_is_exposed_as_its_frame() {
        let mut scene = Scene { film: pace(&[(0.0, 1.0), (2.0, -1.0)]), ..Scene::default() };
        scene.camera.shutter_angle = Some(180.0);
        let interval = |scene: &Scene| {
            let [from, to] = [scene.time, scene.time + scene.exposed()];
            [from.min(to), from.max(to)]
        };
        let fps = scene.film.fps as u32;
        for (number, longest) in [(0, 1.0), (fps, 0.0), (fps + fps / 2, 0.5), (2 * fps, 1.0)] {
            let frame = scene.film.frame(&scene, number);
            let still = Film::still(&frame);
            assert_eq!(interval(&still), interval(&frame), "frame {number}");
            assert_eq!(still.shutter(), longest * scene.shutter(), "frame {number}");
            assert_eq!((still.film.frames(), still.film.fps), (1, scene.film.fps));
        }
    }

    #[test]
    fn the_least_pace_is_0_where_drops_stand_or_turn() {
        assert_eq!(Film::default().least_pace(), 1.0);
        assert_eq!(pace(&[(0.0, 1.0), (1.0, 0.25), (2.0, 3.0)]).least_pace(), 0.25);
        assert_eq!(pace(&[(0.0, -2.0), (1.0, -0.5)]).least_pace(), 0.5);
        assert_eq!(pace(&[(0.0, 1.0), (1.0, -1.0)]).least_pace(), 0.0);
    }

    /// A camera that moves is at the same places at both ends, and moves drops by as much, at every pace.
    #[test]
    fn a_still_moves_as_its_frame() {
        let keys = [(0.0, DVec3::ZERO), (1.0, DVec3::X), (4.0, DVec3::new(9.0, 0.0, 1.0))];
        let film = Film { pace: pace(&[(0.0, 1.0), (4.0, -1.0)]).pace, ..path(&keys) };
        let mut scene = Scene { film, ..Scene::default() };
        scene.camera.shutter = 0.02;
        let ends = |scene: &Scene| {
            let from = scene.camera.position;
            let ends =
                [(scene.time, from), (scene.time + scene.exposed(), from + scene.camera_motion())];
            if ends[0].0 > ends[1].0 { [ends[1], ends[0]] } else { ends }
        };
        for number in [20, 60, 70, 100] {
            let frame = scene.film.frame(&scene, number);
            let still = Film::still(&frame);
            let still = still.film.frame(&still, 0);
            assert!(frame.camera_motion().length() > 0.01);
            for (a, b) in ends(&frame).into_iter().zip(ends(&still)) {
                assert!((a.0 - b.0).abs() < 1e-12 && a.1.distance(b.1) < 1e-12, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_path_has_a_velocity_unless_one_is_given() {
        let (film, camera) = (path(&BENDS), Camera::default());
        let (mut most, h) = (DVec3::ZERO, 1e-6);
        for step in -20..120 {
            let at = 0.0401 * f64::from(step);
            let place = |at: f64| film.camera_at(&camera, at).position;
            let slope = (place(at + h) - place(at - h)) / (2.0 * h);
            let velocity = film.camera_at(&camera, at).velocity();
            assert!(velocity.distance(slope) < 1e-5, "at {at}: {velocity}, not {slope}");
            most = most.max(velocity.abs());
        }
        let bound = film.fastest();
        // The bound is that of the hull of the velocities, which is over them by up to 1.94 times here.
        assert!(most.cmple(bound).all() && bound.cmple(2.0 * most).all(), "{most} {bound}");
        let given = Camera { velocity: Some(DVec3::ZERO), ..camera };
        assert_eq!(film.camera_at(&given, 2.0).velocity(), DVec3::ZERO);
        assert_eq!(Film::default().camera_at(&camera, 2.0).velocity, None);
    }

    /// Stops within 2 s, stands for 4, is back to speed within 2.
    #[test]
    fn rain_stops_to_the_bit_and_goes_on() {
        let film = pace(&[(2.0, 1.0), (4.0, 0.0), (8.0, 0.0), (10.0, 1.0)]);
        assert_eq!(film.frames(), 301);
        assert_eq!(film.scene_seconds(0.0), 0.0);
        assert_eq!(film.scene_seconds(1.5), 1.5);
        assert_eq!(film.scene_seconds(3.0), 2.75);
        for at in [4.0, 4.1, 5.7, 7.999, 8.0] {
            assert_eq!(film.scene_seconds(at), 3.0, "at {at}");
        }
        assert_eq!(film.scene_seconds(11.0), 5.0);
        assert_eq!(film.scene_seconds(-3.0), -3.0);
        assert_eq!(Film::default().scene_seconds(0.7), 0.7);
    }

    /// Against the trapezoidal rule with steps that meet every key, which is exact here.
    #[test]
    fn scene_time_is_the_integral_of_the_pace() {
        let film = pace(&[(-0.5, -1.0), (0.25, 2.0), (0.5, 2.0), (1.75, 0.125)]);
        let rate = |at: f64| {
            let after = film.pace.partition_point(|key| key.at <= at);
            match (after.checked_sub(1).map(|i| film.pace[i]), film.pace.get(after)) {
                (Some(a), Some(b)) => a.rate + (b.rate - a.rate) * (at - a.at) / (b.at - a.at),
                (Some(only), None) => only.rate,
                (None, only) => only.map_or(1.0, |key| key.rate),
            }
        };
        let (mut sum, step) = (0.0, 1.0 / 64.0);
        for number in 0..160 {
            let at = f64::from(number) * step;
            assert!((film.scene_seconds(at) - sum).abs() < 1e-12, "at {at}");
            sum += 0.5 * step * (rate(at) + rate(at + step));
        }
    }

    #[test]
    fn camera_meets_its_keys_and_does_not_jerk() {
        let film = path(&BENDS);
        let camera = Camera { vertical_fov: 50.0, ..Camera::default() };
        let place = |at: f64| film.camera_at(&camera, at).position;
        for (at, position) in BENDS {
            assert!(place(at).distance(position) < 1e-12, "at {at}");
        }
        assert_eq!((place(-1.0), place(5.0)), (BENDS[0].1, BENDS[3].1));
        assert_eq!(film.camera_at(&camera, 2.0).vertical_fov, 50.0);
        let h = 1e-6;
        let velocity = |at: f64| (place(at + h) - place(at)) / h;
        for at in [1.0, 1.5] {
            assert!(velocity(at - h).distance(velocity(at)) < 1e-4, "jerk at {at}");
        }
        for at in [0.0, 4.0 - h] {
            assert!(velocity(at).length() < 1e-4, "not at rest at {at}");
        }
    }

    /// Sharp bends: without a bound the field of view would reach -1.6 degrees.
    #[test]
    fn a_zoom_stays_between_its_keys() {
        let keys = [(0.0, 90.0), (2.0, 5.0), (4.0, 4.0), (5.0, 60.0), (9.0, 61.0)];
        let key = |(at, fov): (f64, f64)| CameraKey {
            at,
            position: DVec3::ZERO,
            target: -DVec3::Z,
            vertical_fov: Some(fov),
        };
        let film = Film { camera: keys.map(key).into(), ..Film::default() };
        let fov = |at: f64| film.camera_at(&Camera::default(), at).vertical_fov;
        for pair in keys.windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            assert_eq!((fov(from), fov(to)), (a, b));
            for step in 0..=100 {
                let between = fov(from + (to - from) * f64::from(step) / 100.0);
                assert!((a.min(b)..=a.max(b)).contains(&between), "{between} after {from} s");
            }
        }
        let speed = |at: f64| (fov(at + 1e-6) - fov(at - 1e-6)) / 2e-6;
        assert!(speed(2.0) < -0.5 && (speed(2.0 - 1e-4) - speed(2.0 + 1e-4)).abs() < 0.1, "a jerk");
    }

    #[test]
    fn the_last_key_is_a_frame() {
        for (at, fps, frames) in
            [(2.2, 25.0, 56), (8.3, 30.0, 250), (2.21, 25.0, 57), (0.0, 25.0, 1)]
        {
            let film = Film { fps, ..pace(&[(at, 1.0)]) };
            assert_eq!(film.frames(), frames, "{at} s at {fps}");
        }
    }

    #[test]
    fn backwards_it_is_the_same_film_from_its_end() {
        let film = path(&[(0.0, DVec3::ZERO), (1.0, DVec3::X), (4.0, DVec3::ONE)]);
        let film = Film { fps: 8.0, ..film };
        let (back, scene) = (Film { fps: -8.0, ..film.clone() }, Scene::default());
        let last = film.frames() - 1;
        assert_eq!((last, back.frames()), (32, 33));
        for number in 0..=last {
            assert_eq!(back.frame(&scene, number), film.frame(&scene, last - number));
        }
        let endless = Film { fps: -8.0, ..Film::default() };
        assert_eq!(endless.frame(&scene, 4).time, scene.time - 0.5);
    }

    #[test]
    fn keys_alike_hold_the_camera_still() {
        let held = DVec3::new(3.0, 2.0, 1.0);
        let film = path(&[(0.0, DVec3::ZERO), (1.0, held), (2.0, held), (3.0, DVec3::ONE)]);
        for at in [1.0, 1.2, 1.9] {
            let place = film.camera_at(&Camera::default(), at).position;
            assert!(place.distance(held) < 1e-12, "at {at}: {place}");
        }
    }
}
