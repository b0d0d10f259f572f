//! What stands beside rain as layers: camera, time, seed, and each drop in view.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;
use serde_json::{Value, json};

use crate::Result;
use crate::optics::Shape;
use crate::rain::cull::{Visibility, drops_with_visibility};
use crate::rain::field::Field;
use crate::rain::shape::Halves;
use crate::rain::tick_of_seconds;
use crate::scene::model::{DropShape, PaneModel, ShapeModel};
use crate::scene::projection::View;
use crate::scene::{PlacedDrop, Scene};

/// Format of the file.
const FORMAT: &str = "raindrops-layers/1";

/// The file's content; lengths in scene units, times in the scene's seconds.
#[derive(Debug, Serialize)]
pub struct Sidecar {
    format: &'static str,
    seed: u64,
    time: f64,
    /// When the motion ends.
    until: f64,
    metres: f64,
    camera: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    pane: Option<Value>,
    /// Every drop in view.
    pub drops: Vec<DropRecord>,
}

/// A pane as a file tells it, where layers show it: its wet face, as the shutter opens, and the drops on it, in view or not;
/// the first has number 1 in `id`.
fn pane(scene: &Scene) -> Option<Value> {
    if scene.model.pane == Some(PaneModel::None) {
        return None;
    }
    let (pane, face) = (scene.pane.as_ref()?, scene.pane_face()?);
    let drops = (1u32..).zip(scene.pane_drops()).map(|(number, drop)| {
        let contact_angle = pane.angle_of(&drop);
        json!({"number": number, "at": drop.at, "radius": drop.radius, "contact_angle": contact_angle})
    });
    Some(json!({
        "point": face.point,
        "u": face.u,
        "v": face.v,
        "normal": face.normal,
        "thickness": pane.thickness,
        "index": pane.index,
        "drops": drops.collect::<Vec<_>>(),
    }))
}

/// The camera of `scene` as a file tells it; `docs/result-files.md` says what the keys mean.
pub fn camera(scene: &Scene) -> Value {
    let view = scene.view();
    json!({
        "position": view.position,
        "velocity": scene.camera.velocity(),
        "right": view.right,
        "up": view.up,
        "back": view.back,
        "vertical_fov": scene.camera.vertical_fov,
        "focal_px": view.focal_px,
        "principal_px": view.principal.to_array(),
        "whole": view.whole,
        "origin": view.origin,
        "size": [view.width, view.height],
    })
}

/// A drop in view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DropRecord {
    /// What stands in `id` (and `id_high`).
    pub number: u64,
    /// In the middle of what is exposed: at the file's time where nothing is.
    pub center: DVec3,
    /// Radius of the sphere of the drop's volume.
    pub radius: f64,
    /// Scene units a second.
    pub velocity: DVec3,
    /// Left, top, right, bottom: the pixels of what is drawn that its outline meets at any time of the exposure and from any
    /// place of the lens, the last ones not included; of a drop that is no sphere those of the sphere around it.
    #[serde(rename = "box")]
    pub pixels: [u32; 4],
}

impl Sidecar {
    /// What `scene` shows, moving until another time; of real rain drops of over `cutoff_px` pixels of radius.
    pub fn of(scene: &Scene, until: f64, cutoff_px: f64) -> Self {
        Self {
            format: FORMAT,
            seed: scene.seed,
            time: scene.time,
            until,
            metres: scene.metres,
            camera: camera(scene),
            pane: pane(scene),
            drops: drops_in_view(scene, cutoff_px),
        }
    }

    /// Writes it as JSON, a drop a line.
    ///
    /// # Errors
    /// [`crate::Error::File`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let problem = |error| crate::Error::write(path, error);
        let mut head = serde_json::to_value(self).map_err(problem)?;
        let _ = head.as_object_mut().map(|head| head.shift_remove("drops"));
        let head = serde_json::to_string_pretty(&head).map_err(problem)?;
        // Its last key may be an object, whose brace stays.
        let mut text = head.strip_suffix("\n}").unwrap_or(&head).to_string();
        text.push_str(",\n  \"drops\": [");
        for (number, drop) in self.drops.iter().enumerate() {
            text.push_str(if number == 0 { "\n    " } else { ",\n    " });
            text.push_str(&serde_json::to_string(drop).map_err(problem)?);
        }
        text.push_str("\n  ]\n}\n");
        crate::files::write_whole(path, text.as_bytes())
    }
}

/// Every drop that a picture of `scene` shows by itself, in view at any time of the exposure and with a pixel of its own;
/// of real rain those of over `cutoff_px` pixels of radius.
pub fn drops_in_view(scene: &Scene, cutoff_px: f64) -> Vec<DropRecord> {
    let view = scene.view();
    let mut found = Vec::new();
    let lens = Blur::of(scene);
    let mut add = |number: u64,
                   from_camera: DVec3,
                   (radius, reach): (f64, f64),
                   velocity: DVec3,
                   visibility| {
        let half_way = 0.5 * scene.drawn_motion_of(velocity);
        let ends = [from_camera - half_way, from_camera + half_way];
        let is_seen = matches!(visibility, Visibility::Visible | Visibility::BesideCamera);
        if let (true, Some(pixels)) = (is_seen, pixels_of(&view, ends, reach * radius, lens)) {
            let center = scene.drawn_position() + from_camera;
            found.push(DropRecord { number, center, radius, velocity, pixels });
        }
    };
    if let Some(field) = Field::of(scene) {
        field.for_each_shown(scene, cutoff_px, &mut |drop| {
            let radius = f64::from(drop.radius);
            let size = (radius, reach_of_falling(scene, radius));
            add(drop.number, drop.from_camera, size, drop.velocity, drop.visibility);
        });
    }
    let mut placed = (0..).zip(scene.placed());
    let mut random = scene.populations().into_iter().flat_map(|rain| {
        let seen = rain.seen_from(scene.drawn_position(), tick_of_seconds(scene.drawn_time()));
        (0..rain.count).map(move |index| (seen.drop_at(index).as_dvec3(), rain.velocity))
    });
    for (index, (_, radius, visibility)) in (0u32..).zip(drops_with_visibility(scene)) {
        let of_box = random.next();
        let by_hand = if of_box.is_none() { placed.next() } else { None };
        if matches!(visibility, Visibility::OutOfView) {
            continue;
        }
        if let Some((from_camera, velocity)) = of_box {
            let size = (radius.into(), 1.0);
            add(u64::from(index) + 1, from_camera, size, velocity, visibility);
        } else if let Some((place, drop)) = by_hand {
            let from_camera = scene.drawn_center(drop) - view.position;
            // With real rain, where random drops have no index, placed ones begin with 1 too.
            let size = (drop.radius, reach_of_placed(scene, drop));
            let number = scene.number_of(drop, place);
            add(number.into(), from_camera, size, drop.velocity, visibility);
        }
    }
    found
}

/// How far a falling drop reaches from its centre, in radii.
fn reach_of_falling(scene: &Scene, radius: f64) -> f64 {
    let is_flat = scene.real_rain().is_some_and(|rain| rain.shape == DropShape::Equilibrium);
    match is_flat && scene.model.shape != Some(ShapeModel::Sphere) {
        true => Halves::of_diameter(2e3 * radius * scene.metres).reach(),
        false => 1.0,
    }
}

/// How far a drop placed by hand reaches from its centre, in radii.
fn reach_of_placed(scene: &Scene, drop: &PlacedDrop) -> f64 {
    match (scene.model.shape, drop.axis_ratio, drop.shape) {
        (Some(ShapeModel::Sphere), ..) => 1.0,
        (_, Some(ratio), _) => Shape::of_axis_ratio(ratio).reach(),
        (_, None, Some(DropShape::Equilibrium)) => {
            Halves::of_diameter(2e3 * drop.radius * scene.metres).reach()
        }
        _ => 1.0,
    }
}

/// How far apart the places of the lens see a drop.
#[derive(Clone, Copy)]
struct Blur {
    /// Radius of the lens; 0: a pinhole.
    radius: f64,
    inverse_focus: f64,
}

impl Blur {
    fn of(scene: &Scene) -> Self {
        let radius = scene.drawn_lens();
        let inverse_focus = if radius > 0.0 { scene.camera.focus.recip() } else { 0.0 };
        Self { radius, inverse_focus }
    }

    /// Radius around a drop at a depth within which the whole lens sees it: `Sight::reach` in float64.
    fn reach(self, depth: f64, radius: f64) -> f64 {
        let apart = (1.0 - depth * self.inverse_focus).abs() + radius * self.inverse_focus;
        radius + self.radius * apart
    }
}

/// The pixels that the outline of a sphere meets on its way from one end to the other: left, top, right, bottom, the last
/// ones not included; none if it is beside what is drawn.
fn pixels_of(view: &View, ends: [DVec3; 2], radius: f64, lens: Blur) -> Option<[u32; 4]> {
    let size = [view.width, view.height];
    let [Some(from), Some(to)] = ends.map(|end| outline(view, end, radius, lens)) else {
        return Some([0, 0, size[0], size[1]]);
    };
    let mut pixels = [0; 4];
    for axis in 0..2 {
        // Between the ends it is nowhere else: the picture of a convex body is convex.
        let low = from[axis].min(to[axis]).floor();
        let high = from[axis + 2].max(to[axis + 2]).ceil();
        let most = f64::from(size[axis]);
        if low >= most || high <= 0.0 {
            return None;
        }
        (pixels[axis], pixels[axis + 2]) = (low.max(0.0) as u32, high.min(most) as u32);
    }
    Some(pixels)
}

/// Left, top, right and bottom of a sphere's outline, in pixels; none if it reaches the camera's plane, where its outline
/// is no ellipse.
fn outline(view: &View, from_camera: DVec3, radius: f64, lens: Blur) -> Option<[f64; 4]> {
    let [x, y, z] = [view.right, view.up, view.back].map(|axis| from_camera.dot(axis));
    let radius = lens.reach(-z, radius);
    if -z < 1.01 * radius {
        return None;
    }
    let flat2 = z * z - radius * radius;
    let along = |along: f64, principal: f64| {
        let center = principal + view.focal_px * along * -z / flat2;
        let half = view.focal_px * radius * (along * along + flat2).sqrt() / flat2;
        (center - half, center + half)
    };
    let (left, right) = along(x, view.principal.x);
    let (top, bottom) = along(-y, view.principal.y);
    Some([left, top, right, bottom])
}
