//! `[pane]`: a pane of glass between the camera and the rain, and the drops that stand on it.
//!
//! Its keys are lengths in scene units; what physics needs of it is in metres (`metres`). The pane has no edges. Drops stand
//! on the wet face, outside; the camera is on the other side of the dry face.

mod refused;

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(super) use self::refused::problem;
use super::Scene;
use super::model::PaneModel;
use super::real_rain::{RATES, RealRain};
use crate::optics::Cap;
use crate::pane::Resting;
use crate::pane::arrivals::{Arrivals, Flux};
use crate::pane::population::{Population, Surface};
use crate::pane::retention::Retention;

/// How far beyond what the camera sees drops arrive where no extent is given, m.
const MARGIN: f64 = 0.05;

/// Least cosine between the normal and what the camera sees of a pane without an extent: beyond it is without end.
const LEAST_COSINE: f64 = 0.02;

/// Places of the picture along each edge at which the distance of the pane is found.
const PLACES: u32 = 8;

/// Cosine from which on a normal counts as vertical (within 10⁻⁶).
const VERTICAL: f64 = 1e-6;

/// The `[pane]` table.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Pane {
    /// A point of the wet face; with `frame = "camera"` in camera axes.
    #[schemars(with = "Option<[f64; 3]>", extend("x-unit" = "scene units"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<DVec3>,
    /// Points outside, away from the camera, all of whose lens is before the glass; of any length.
    #[schemars(with = "Option<[f64; 3]>")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<DVec3>,
    /// Instead of both: distance along the view axis to the wet face.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// With `distance`: angle by which the normal is turned up from the view axis about the camera's right; over 0 the top
    /// leans towards the camera.
    #[schemars(extend("exclusiveMinimum" = -90, "exclusiveMaximum" = 90, "x-unit" = "degrees", "x-default" = "0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<f64>,
    /// What the pane is fixed to.
    pub frame: Frame,
    /// How thick the glass is.
    #[schemars(range(min = 0), extend("x-unit" = "scene units"))]
    pub thickness: f64,
    /// Refractive index of the glass; 1: no glass, and drops keep their flat base.
    #[schemars(range(min = 1, max = 4))]
    pub index: f64,
    /// Angle through the water between glass and surface, of every drop that has none of its own.
    #[schemars(range(min = 1, max = 170), extend("x-unit" = "degrees"))]
    pub contact_angle: f64,
    /// Radiance of whatever is seen on the camera's side, red, green and blue.
    #[schemars(with = "[f64; 3]", extend("minimum" = 0))]
    pub inside: DVec3,
    /// Chooses the drops; 64 bits.
    #[schemars(extend("x-default" = "the scene's"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How long ago the pane was wiped, at the scene's `time`; up to 10⁸ drops may arrive since.
    #[schemars(range(min = 0), extend("x-unit" = "s", "x-default" = "20"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub age: Option<f64>,
    /// Rain on the pane; sizes, air and wind are those of real rain.
    #[schemars(range(min = 0, max = *RATES.end()), extend("x-unit" = "mm/h", "x-default" = "`rain.rate`"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Velocity of the pane through the air, up to 340 m/s: a car's; against wind the reverse of the wind.
    #[schemars(with = "Option<[f64; 3]>", extend("x-unit" = "m/s", "x-default" = "0 0 0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<DVec3>,
    /// Advancing and receding contact angle: between them a drop holds on (Furmidge).
    #[schemars(extend("minimum" = 0, "maximum" = 180, "x-unit" = "degrees", "x-default" = "50 20"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angles: Option<[f64; 2]>,
    /// Standard deviation of the contact angle from drop to drop; angles stay within 5 to 170.
    #[schemars(range(min = 0, max = 60), extend("x-unit" = "degrees", "x-default" = "0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_spread: Option<f64>,
    /// Share of an arriving drop's water that stays.
    #[schemars(range(min = 1e-6, max = 1), extend("x-default" = "1"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retained: Option<f64>,
    /// λ: water that a sliding drop leaves behind, as volume per width² and length; measured ones are up to 0.02.
    #[schemars(range(min = 0, max = 1), extend("x-default" = "0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trail: Option<f64>,
    /// Where drops arrive: lengths along u and v, about `point`. Must be given where a film's camera moves past a pane that
    /// stands, and where the horizon is seen in the pane.
    #[schemars(extend(
        "exclusiveMinimum" = 0,
        "x-unit" = "m",
        "x-default" = "what the camera sees and 5 cm around"
    ))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extent: Option<[f64; 2]>,
    /// Whether time goes on for the random drops.
    #[schemars(extend("x-default" = "`static`"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<PaneTime>,
    /// Drops placed by hand.
    #[serde(rename = "drop", skip_serializing_if = "Vec::is_empty")]
    pub drops: Vec<PaneDrop>,
}

/// What a pane is fixed to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// The world.
    #[default]
    World,
    /// The camera, in its axes: right, up, back.
    Camera,
}

/// Whether time goes on for the random drops of a pane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PaneTime {
    /// `age` is that of the whole film.
    #[default]
    Static,
    /// `age` is that at the scene's time, and grows with it.
    Running,
}

/// A drop placed on a pane.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaneDrop {
    /// Middle of its contact disc along u and v from the pane's point.
    #[schemars(with = "[f64; 2]", extend("x-unit" = "scene units"))]
    pub at: DVec2,
    /// Radius of its contact disc.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units"))]
    pub radius: f64,
    /// Contact angle.
    #[schemars(range(min = 1, max = 170), extend("x-unit" = "degrees", "x-default" = "the pane's"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_angle: Option<f64>,
}

impl Default for Pane {
    fn default() -> Self {
        Self {
            point: None,
            normal: None,
            distance: None,
            tilt: None,
            frame: Frame::World,
            thickness: 0.005,
            index: 1.52,
            contact_angle: 60.0,
            inside: DVec3::ZERO,
            seed: None,
            age: None,
            rate: None,
            velocity: None,
            angles: None,
            angle_spread: None,
            retained: None,
            trail: None,
            extent: None,
            simulation: None,
            drops: Vec::new(),
        }
    }
}

/// A pane's wet face in the world: a point of it and its axes, all of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Where u and v are 0, scene units.
    pub point: DVec3,
    /// To the right as seen from the dry side.
    pub u: DVec3,
    /// Up along the pane.
    pub v: DVec3,
    /// Outside.
    pub normal: DVec3,
}

impl Face {
    fn new(point: DVec3, normal: DVec3) -> Self {
        let upward = DVec3::Y - normal.y * normal;
        let v = match upward.length() > VERTICAL {
            true => upward.normalize(),
            // A level pane has no up.
            false => (DVec3::NEG_Z - normal.dot(DVec3::NEG_Z) * normal).normalize(),
        };
        Self { point, u: normal.cross(v), v, normal }
    }

    /// A vector of the world along u, v and the normal.
    pub fn to_local(&self, vector: DVec3) -> DVec3 {
        DVec3::new(vector.dot(self.u), vector.dot(self.v), vector.dot(self.normal))
    }

    /// The reverse.
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        local.x * self.u + local.y * self.v + local.z * self.normal
    }

    /// Sine of the pane's angle from level.
    pub fn slope_sine(&self) -> f64 {
        self.normal.x.hypot(self.normal.z)
    }
}

impl Pane {
    /// Whether rain falls on it.
    pub fn has_population(&self) -> bool {
        self.seed.is_some()
            || self.age.is_some()
            || self.rate.is_some()
            || self.velocity.is_some()
            || self.angles.is_some()
            || self.angle_spread.is_some()
            || self.retained.is_some()
            || self.trail.is_some()
            || self.extent.is_some()
            || self.simulation.is_some()
    }

    /// The glass without a drop.
    pub fn dry(self) -> Self {
        let Self { point, normal, distance, tilt, frame, thickness, index, inside, .. } = self;
        Self { point, normal, distance, tilt, frame, thickness, index, inside, ..Self::default() }
    }

    /// Whether it stays where it is when the camera moves.
    pub fn stands(&self) -> bool {
        self.frame == Frame::World && self.distance.is_none()
    }

    /// Contact angle of a placed drop.
    pub fn angle_of(&self, drop: &PaneDrop) -> f64 {
        drop.contact_angle.unwrap_or(self.contact_angle)
    }

    /// Seconds since it was wiped.
    pub fn age(&self) -> f64 {
        self.age.unwrap_or(20.0)
    }

    /// The pane as it is when so many seconds of the scene have gone by.
    pub fn after(&self, seconds: f64) -> Self {
        match self.simulation {
            Some(PaneTime::Running) => {
                Self { age: Some((self.age() + seconds).max(0.0)), ..self.clone() }
            }
            _ => self.clone(),
        }
    }

    /// Whether it is this pane, at whatever age, or with whatever drops where only those are on it that are placed.
    pub(crate) fn is_same_glass(&self, other: &Self) -> bool {
        let mut aged = Self { age: other.age, ..self.clone() };
        if !self.has_population() && !other.has_population() {
            aged.drops.clone_from(&other.drops);
        }
        self.has_population() == other.has_population() && aged == *other
    }

    /// Velocity through the air, m/s.
    fn velocity(&self) -> DVec3 {
        self.velocity.unwrap_or(DVec3::ZERO)
    }

    /// Advancing and receding contact angle, degrees.
    pub fn angles(&self) -> [f64; 2] {
        self.angles.unwrap_or([50.0, 20.0])
    }
}

impl Scene {
    /// The pane's wet face, as the shutter opens; `None` without a pane, or with one that has no place.
    pub fn pane_face(&self) -> Option<Face> {
        let pane = self.pane.as_ref()?;
        let view = self.view();
        if let Some(distance) = pane.distance {
            let (sine, cosine) = pane.tilt.unwrap_or(0.0).to_radians().sin_cos();
            let normal = sine * view.up - cosine * view.back;
            return Some(Face::new(view.position - distance * view.back, normal.normalize()));
        }
        let (point, normal) = (pane.point?, pane.normal?.try_normalize()?);
        Some(match pane.frame {
            Frame::World => Face::new(point, normal),
            Frame::Camera => {
                let axes = view.to_world();
                Face::new(view.position + axes * point, (axes * normal).normalize())
            }
        })
    }

    /// The drops on the pane: those placed by hand, or those that rain has made of them and of its own.
    pub fn pane_drops(&self) -> Vec<PaneDrop> {
        let mut rained = self.pane_population();
        if let Some((rained, pane)) = rained.as_mut().zip(self.pane.as_ref()) {
            rained.go_on_to(pane.age());
        }
        self.pane_drops_of(rained.as_ref())
    }

    /// The drops of a population, without one those placed by hand, as caps, each with the middle of its disc.
    pub(crate) fn pane_caps_of(&self, rained: Option<&Population>) -> Vec<(DVec2, Cap)> {
        let Some(pane) = &self.pane else { return Vec::new() };
        let cap =
            |drop: PaneDrop| (drop.at, Cap { radius: drop.radius, angle: pane.angle_of(&drop) });
        self.pane_drops_of(rained).into_iter().map(cap).collect()
    }

    /// Whether the camera is on the dry side of the pane that is drawn, if there is one.
    pub fn is_behind_glass(&self) -> bool {
        match (&self.pane, self.pane_face(), self.model.pane) {
            (_, _, Some(PaneModel::None)) | (None, ..) | (_, None, _) => true,
            (Some(pane), Some(face), _) => {
                face.to_local(self.camera.position - face.point).z < -pane.thickness
            }
        }
    }

    /// By how much the pane moves in what is drawn, as the camera sees it, while the shutter is open.
    pub fn pane_motion(&self) -> DVec3 {
        match &self.pane {
            Some(Pane { frame: Frame::World, .. }) => self.drawn_motion_of(DVec3::ZERO),
            _ => DVec3::ZERO,
        }
    }

    /// Least distance of the centre of a drop in the air that is drawn. Rain falls beyond the pane alone, so with one it is about that
    /// of the nearest glass in the picture; on a pane aslant some rain before the rest of it stays.
    pub fn drawn_near(&self) -> f64 {
        let near = self.camera.near;
        let Some(face) = self.pane_face().filter(|_| self.model.pane != Some(PaneModel::None))
        else {
            return near;
        };
        let view = self.whole().view();
        let [width, height] = view.whole.map(f64::from);
        let places = (0..=PLACES).flat_map(|y| (0..=PLACES).map(move |x| (x, y)));
        let part = |number: u32| f64::from(number) / f64::from(PLACES);
        let cosine = |(x, y)| view.ray(width * part(x), height * part(y)).dot(face.normal);
        let towards = places.map(cosine).fold(0.0, f64::max);
        let before = (face.point - view.position).dot(face.normal);
        if towards > 0.0 { near.max(0.98 * before / towards) } else { near }
    }

    /// The drops of a population in scene units; without one those placed by hand.
    pub(crate) fn pane_drops_of(&self, rained: Option<&Population>) -> Vec<PaneDrop> {
        let Some(rained) = rained else {
            return self.pane.as_ref().map_or_else(Vec::new, |pane| pane.drops.clone());
        };
        let drop = |drop: Resting| PaneDrop {
            at: drop.at / self.metres,
            radius: drop.radius / self.metres,
            contact_angle: Some(drop.angle),
        };
        rained.drops().into_iter().map(drop).collect()
    }

    /// Rain on the pane, when it was wiped.
    pub fn pane_population(&self) -> Option<Population> {
        let pane = self.pane.as_ref().filter(|pane| pane.has_population())?;
        let (from, to) = self.pane_extent().ok()?;
        let surface = Surface {
            from,
            to,
            angle: pane.contact_angle,
            angle_spread: pane.angle_spread.unwrap_or(0.0),
            retained: pane.retained.unwrap_or(1.0),
            trail: pane.trail.unwrap_or(0.0),
            retention: Retention::new(self.pane_face()?.slope_sine(), pane.angles()),
        };
        let seed = pane.seed.unwrap_or(self.seed);
        let arrivals = Arrivals::new(&self.pane_flux()?, (to - from).element_product(), seed);
        let placed = pane.drops.iter().map(|drop| {
            let (radius, angle) = (drop.radius * self.metres, pane.angle_of(drop));
            let volume = Cap { radius, angle }.volume();
            Resting { at: drop.at * self.metres, radius, angle, volume }
        });
        Some(Population::new(surface, arrivals, &placed.collect::<Vec<_>>()))
    }

    /// The rain that arrives on the pane.
    pub fn pane_flux(&self) -> Option<Flux> {
        let (pane, rain) = (self.pane.as_ref()?, self.pane_rain()?);
        if rain.rate == 0.0 {
            return None;
        }
        let velocity = pane.velocity() - rain.wind;
        Some(Flux::new(rain.law(), rain.air_density, self.pane_face()?.normal, velocity))
    }

    /// Drops that arrive on the pane each second; 0 without rain on it.
    pub fn pane_arrivals_a_second(&self) -> f64 {
        let flux = self.pane_flux().map_or(0.0, |flux| flux.number());
        self.pane_extent().map_or(0.0, |(from, to)| flux * (to - from).element_product())
    }

    /// The rain that falls on the pane: as real rain, with the pane's rate.
    fn pane_rain(&self) -> Option<RealRain> {
        let real = self.real_rain();
        let rate = self.pane.as_ref()?.rate.or(real.map(|rain| rain.rate))?;
        Some(RealRain { rate, ..real.unwrap_or_default() })
    }

    /// Where drops arrive: least and largest u and v, in metres. Where nothing is said, what the camera sees and 5 cm around.
    pub fn pane_extent(&self) -> Result<(DVec2, DVec2), String> {
        let (Some(pane), Some(face)) = (&self.pane, self.pane_face()) else {
            return Err("pane: there is none".into());
        };
        if let Some(extent) = pane.extent {
            let half = 0.5 * DVec2::from(extent);
            return Ok((-half, half));
        }
        let view = self.whole().view();
        let [width, height] = view.whole.map(f64::from);
        let origin = face.to_local(view.position - face.point);
        let (mut from, mut to) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for direction in view.corners([0.0, 0.0, width, height]) {
            let direction = face.to_local(direction);
            if direction.z < LEAST_COSINE {
                return Err(
                    "pane: the camera sees it to the horizon, so where rain falls on it has no end; give extent \
                     (metres along u and v)"
                        .into(),
                );
            }
            let met = origin + direction * (-origin.z / direction.z);
            (from, to) = (from.min(met.truncate()), to.max(met.truncate()));
        }
        let around = MARGIN + 0.5 * self.camera.aperture * self.metres;
        Ok((from * self.metres - around, to * self.metres + around))
    }
}
