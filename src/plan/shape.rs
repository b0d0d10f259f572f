//! In what shape drops are drawn that are no spheres in the scene.

use super::Optics;
use crate::rain::shape::SMALLEST_FLATTENED;
use crate::scene::Scene;
use crate::scene::model::{DropShape, Primitive, ShapeModel};
use crate::{Error, Result};

/// While the shutter is open for so long, in seconds, a falling drop is so faint that its shape does not show: by under
/// 5/255 at every size.
const LONG_EXPOSURE: f64 = 1.0 / 250.0;

/// Radius in pixels from which a drop that is no sphere is traced rather than shown by a sphere's picture, flattened.
const FLAT_RAYS_PX: f32 = 4.0;

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
        let placed = (1..).zip(&scene.drops).find_map(|(number, drop)| {
            if drop.axis_ratio.is_some_and(|ratio| ratio != 1.0) {
                return Some((number, "axis_ratio"));
            }
            let mm = 2000.0 * drop.radius * scene.metres;
            let is_flat = drop.shape == Some(DropShape::Equilibrium) && mm >= SMALLEST_FLATTENED;
            is_flat.then_some((number, "shape"))
        });
        Self { falls, placed }
    }
}

/// The model for the drops of `scene` that are no spheres, drawn as `primitive` by `optics`.
///
/// # Errors
/// [`Error::Scene`] if they cannot be drawn so, with what can.
pub(super) fn shape_of(
    scene: &Scene,
    primitive: Primitive,
    optics: Optics,
) -> Result<DrawnShape> {
    let NoSpheres { falls, placed } = NoSpheres::of(scene);
    let rays_px = if optics == Optics::Appearance { FLAT_RAYS_PX } else { 0.0 };
    let drawn = |model, why: &str| Ok(DrawnShape { model, rays_px, why: why.into() });
    if !falls && placed.is_none() {
        return drawn(ShapeModel::Sphere, "every drop is one");
    }
    if scene.model.shape == Some(ShapeModel::Sphere) {
        return drawn(ShapeModel::Sphere, "as the scene asks, though some drops are none");
    }
    if let (true, Some((number, key))) = (primitive != Primitive::Tile, placed) {
        return Err(Error::Scene {
            place: format!("drop {number}: {key}"),
            problem: format!(
                "a {primitive} is drawn as a sphere; take preset fast, exact or auto, or model.shape = \"sphere\""
            ),
        });
    }
    let pictures = if optics == Optics::Appearance {
        format!("; under {rays_px} px of radius a sphere's picture on their outline")
    } else {
        String::new()
    };
    match scene.model.shape {
        Some(ShapeModel::Stretched) => {
            drawn(ShapeModel::Stretched, "a sphere's picture on a spheroid's outline, as the scene asks")
        }
        Some(ShapeModel::Spheroid) => {
            drawn(ShapeModel::Spheroid, &format!("spheroids, traced, as the scene asks{pictures}"))
        }
        None if optics == Optics::Appearance && placed.is_none() && is_long(scene) => drawn(
            ShapeModel::Sphere,
            "drops that fall for 1/250 s or longer while the shutter is open are too faint to show their shape",
        ),
        _ => drawn(
            ShapeModel::Equilibrium,
            &format!("drops are flattened, rays traced through two half spheroids{pictures}"),
        ),
    }
}

/// Whether the shutter is open so long that drops that fall show no shape.
fn is_long(scene: &Scene) -> bool {
    scene.drawn_exposure().abs() >= LONG_EXPOSURE
}
