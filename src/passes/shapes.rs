//! The shapes of drops that are no spheres, as the passes read them (`glsl/include/shape.glsl`): those of falling drops by
//! their diameter, those of drops placed by hand one by one.
//!
//! A shape is four numbers over the radius of the sphere of equal volume: half the width, the heights of the upper and of
//! the lower half, the height of the plane between them over the centre. `large` finds a large drop's outline from it,
//! two ellipses, and leaves it for `blocks`, which finds what of each pixel it covers, and for `rays`, which traces
//! (`shape_light.glsl`). Where all drops are spheres, both buffers are empty and no shader reads them.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::abi::{DIAMETERS, DIAMETERS_A_MM, LargeShape, SMALLEST_MM};
use crate::gpu::{Buffer, Device, Memory};
use crate::optics::semi_axes;
use crate::plan::FramePlan;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED, axis_ratio};
use crate::scene::model::{DropShape, ShapeModel};
use crate::scene::{PlacedDrop, Scene};

// Every row of the two halves' own table is one of the diameters here; of spheroids what is between them is off by 1e-4 at
// most.
const _: () = assert!(SMALLEST_FLATTENED == SMALLEST_MM as f64);

/// A sphere.
const ROUND: [f64; 4] = [1.0, 1.0, 1.0, 0.0];

/// The buffers.
pub(super) struct Shapes {
    /// What shape drops have: `Shapes` of `glsl/include/shape_given.glsl`.
    pub given: Buffer,
    /// What `large` finds of large drops.
    pub large: Buffer,
}

impl Shapes {
    /// For the drops of `scene`, of which `larges` may be large.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(device: &Arc<Device>, scene: &Scene, plan: &FramePlan, larges: u64) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER;
        let (given, larges) = match plan.shape.model {
            ShapeModel::Sphere => (vec![[0.0; 4]], 1),
            model => (given(scene, model), larges),
        };
        let bytes = size_of::<LargeShape>() as u64 * larges;
        Ok(Self {
            given: Buffer::upload(device, "shapes", &given, usage | Usage::UNIFORM_TEXEL_BUFFER)?,
            large: Buffer::new(device, "shapes of large drops", bytes, usage, Memory::Device)?,
        })
    }
}

/// Millimetres of diameter of a drop of radius 1, whether falling drops are flattened, and [`parts_of_flat`]; the table; the placed
/// drops.
fn given(scene: &Scene, model: ShapeModel) -> Vec<[f32; 4]> {
    let falls_flat = scene.real_rain().is_some_and(|rain| rain.shape == DropShape::Equilibrium);
    let [first, second] = parts_of_flat(scene, model).map(|part| part as f32);
    let head = [(2000.0 * scene.metres) as f32, f32::from(u8::from(falls_flat)), first, second];
    let diameter = |row: u32| SMALLEST_FLATTENED + f64::from(row) / f64::from(DIAMETERS_A_MM);
    let table = (0..DIAMETERS).map(|row| of_diameter(model, diameter(row)));
    let placed = scene.placed().map(|drop| of_placed(model, drop, scene.metres));
    let of_host = std::iter::repeat_n(ROUND, scene.host_particles as usize);
    let shapes = table.chain(placed).chain(of_host).map(|shape| shape.map(|value| value as f32));
    std::iter::once(head).chain(shapes).collect()
}

/// Which parts of the light of placed drops together are that of flattened drops of 3 and 6 mm, by what each blocks and with the law of
/// `flattened_light` in `glsl/include/flattened.glsl`: small drops that move have one colour together (`glsl/include/streak_layer.glsl`).
/// Among other rain they have its colour.
fn parts_of_flat(scene: &Scene, model: ShapeModel) -> [f64; 2] {
    if scene.real_rain().is_some() || scene.random_count() + scene.host_particles > 0 {
        return [0.0; 2];
    }
    let [first, second] = [3.0, 6.0].map(|mm| 1.0 - axis_ratio(mm));
    let (mut blocked, mut parts) = (0.0, [0.0; 2]);
    for drop in scene.placed() {
        let [wide, above, below, _] = of_placed(model, drop, scene.metres);
        let flatness = (1.0 - 0.5 * (above + below) / wide).max(0.0);
        let from_round = (flatness / first).min(1.0).powf(1.5);
        let from_first = ((flatness - first) / (second - first)).clamp(0.0, 1.0);
        let area = drop.radius * drop.radius;
        blocked += area;
        parts[0] += area * from_round * (1.0 - from_first);
        parts[1] += area * from_round * from_first;
    }
    parts.map(|part| part / f64::max(blocked, f64::MIN_POSITIVE))
}

/// The shape of a falling drop.
fn of_diameter(model: ShapeModel, mm: f64) -> [f64; 4] {
    match model {
        ShapeModel::Equilibrium => {
            let Halves { joint, equatorial, top, bottom } = Halves::of_diameter(mm);
            [equatorial, top, bottom, joint]
        }
        ShapeModel::Stretched | ShapeModel::Spheroid if mm >= SMALLEST_FLATTENED => {
            spheroid(axis_ratio(mm))
        }
        _ => ROUND,
    }
}

/// The shape of a drop placed by hand.
fn of_placed(model: ShapeModel, drop: &PlacedDrop, metres: f64) -> [f64; 4] {
    match (drop.axis_ratio, drop.shape) {
        (Some(ratio), _) => spheroid(ratio),
        (None, Some(DropShape::Equilibrium)) => of_diameter(model, 2000.0 * drop.radius * metres),
        _ => ROUND,
    }
}

fn spheroid(axis_ratio: f64) -> [f64; 4] {
    let (equatorial, polar) = semi_axes(axis_ratio);
    [equatorial, polar, polar, 0.0]
}
