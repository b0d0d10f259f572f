//! In what shape drops are drawn that are no spheres in the scene.

use std::ops::RangeInclusive;

use super::Optics;
use crate::rain::shape::SMALLEST_FLATTENED;
use crate::scene::model::{DropShape, Primitive, ShapeModel};
use crate::scene::{PlacedDrop, Scene};
use crate::{Error, Result};

/// While the shutter is open for so long, in seconds, a falling drop is so faint that the light of a sphere does for that of
/// its shape: off by under 5/255 at every size. Its outline counts, as many such streaks lie over one another.
pub(super) const LONG_EXPOSURE: f64 = 1.0 / 250.0;

/// Radius in pixels from which a drop that is no sphere is traced rather than shown by a sphere's picture, flattened;
/// less where rays are affordable over a smaller one.
const FLAT_RAYS_PX: f32 = 4.0;

/// Axis ratios of spheroids that show a bright source nearly always once straight through. A flatter one seen from the side is a
/// lens whose focus is inside, and shows it three times or not at all.
const SHOWS_ONCE: RangeInclusive<f64> = 0.6..=2.0;

/// The shape that drops are drawn in.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnShape {
    /// Its model; [`ShapeModel::Sphere`], too, where every drop of the scene is one.
    pub model: ShapeModel,
    /// Radius in pixels from which such a drop is drawn by rays rather than by its prefiltered picture.
    pub rays_px: f32,
    /// Why.
    pub why: String,
}

/// What `scene` has that is no sphere: of falling rain, and of placed drops the first one's number and key.
struct NoSpheres {
    falls: bool,
    placed: Option<(usize, &'static str)>,
}

impl NoSpheres {
    fn of(scene: &Scene) -> Self {
        let falls = scene.real_rain().is_some_and(|rain| {
            rain.shape == DropShape::Equilibrium && rain.diameters[1] > SMALLEST_FLATTENED
        });
        let placed = (1..).zip(scene.placed()).find_map(|(number, drop)| {
            if drop.axis_ratio.is_some_and(|ratio| ratio != 1.0) {
                return Some((number, "axis_ratio"));
            }
            let mm = 2000.0 * drop.radius * scene.metres;
            let is_flat = drop.shape == Some(DropShape::Equilibrium) && mm >= SMALLEST_FLATTENED;
            is_flat.then_some((number, "shape"))
        });
        Self { falls, placed }
    }

    /// Whether some are flatter below than above.
    fn is_halved(scene: &Scene) -> bool {
        let is_equilibrium = |drop: &PlacedDrop| drop.shape == Some(DropShape::Equilibrium);
        scene.real_rain().is_some() || scene.placed().any(is_equilibrium)
    }
}

/// The model for the drops of `scene` that are no spheres, drawn as `primitive` by `optics`; spheres are drawn by rays from
/// `sphere_rays_px` on.
///
/// # Errors
/// [`Error::Scene`] if they cannot be drawn so, with what can.
pub(super) fn shape_of(
    scene: &Scene,
    primitive: Primitive,
    optics: Optics,
    sphere_rays_px: f32,
) -> Result<DrawnShape> {
    let NoSpheres { falls, placed } = NoSpheres::of(scene);
    let by_pictures = optics == Optics::Appearance;
    let traced_px = sphere_rays_px.min(FLAT_RAYS_PX);
    let drawn = |model, why: String| {
        let rays_px = match (by_pictures, model) {
            (false, _) => 0.0,
            (true, ShapeModel::Sphere | ShapeModel::Stretched) => sphere_rays_px,
            (true, ShapeModel::Spheroid | ShapeModel::Equilibrium) => traced_px,
        };
        Ok(DrawnShape { model, rays_px, why })
    };
    if !falls && placed.is_none() {
        return drawn(ShapeModel::Sphere, "every drop is one".into());
    }
    let asked = scene.model.shape;
    if asked == Some(ShapeModel::Sphere) {
        return drawn(ShapeModel::Sphere, "as the scene asks, of drops that are none".into());
    }
    if let (true, Some((number, key))) = (primitive != Primitive::Tile, placed) {
        return Err(Error::Scene {
            place: format!("drop {number}: {key}"),
            problem: format!(
                "a {primitive} is drawn as a sphere; take preset fast, exact or auto, or model.shape = \"sphere\""
            ),
        });
    }
    if asked.is_none() && by_pictures && placed.is_none() && is_long(scene) {
        let why = "a sphere's picture on the outline of a spheroid: while the shutter is open for 1/250 s or longer, falling \
                   drops are too faint to show more";
        return drawn(ShapeModel::Stretched, why.into());
    }
    let model = asked.unwrap_or(ShapeModel::Equilibrium);
    let what = match model {
        ShapeModel::Sphere | ShapeModel::Stretched => {
            "a sphere's picture on the outline of a spheroid"
        }
        ShapeModel::Spheroid => "rays traced through spheroids",
        ShapeModel::Equilibrium if NoSpheres::is_halved(scene) => {
            "rays traced through two half spheroids"
        }
        ShapeModel::Equilibrium => "rays traced through spheroids",
    };
    let under = match (by_pictures, model) {
        (true, ShapeModel::Spheroid | ShapeModel::Equilibrium) => {
            format!("; under {traced_px} px of radius a sphere's picture on their outline")
        }
        _ => String::new(),
    };
    drawn(model, format!("{what}{under}"))
}

impl DrawnShape {
    /// Whether the falling drops of `scene` are drawn flattened.
    pub fn flattens_rain(&self, scene: &Scene) -> bool {
        NoSpheres::of(scene).falls && self.model != ShapeModel::Sphere
    }

    /// Whether drops that `scene` places are drawn flattened, and by pictures while they are small.
    pub fn flattens_placed(&self, scene: &Scene) -> bool {
        NoSpheres::of(scene).placed.is_some()
            && self.model != ShapeModel::Sphere
            && self.rays_px > 0.0
    }

    /// Whether each traced drop of `scene` shows a bright source once by each of the ways that `glints` looks for.
    pub fn shows_sources_once(&self, scene: &Scene) -> bool {
        scene.placed().all(|drop| drop.axis_ratio.is_none_or(|ratio| SHOWS_ONCE.contains(&ratio)))
    }

    /// Whether rays are traced through drops.
    pub fn is_traced(&self) -> bool {
        matches!(self.model, ShapeModel::Spheroid | ShapeModel::Equilibrium)
    }
}

/// Whether the shutter is open so long that drops that fall show no shape. A film may slow down until they stand still.
fn is_long(scene: &Scene) -> bool {
    scene.film.is_default() && scene.drawn_exposure().abs() >= LONG_EXPOSURE
}
