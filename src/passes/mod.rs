//! The passes of a frame and what is made once for them: each beside its shader in `glsl/`, by the
//! same name. A pass owns what only it needs; barriers between passes stand in `renderer/`.

pub mod appearance;
pub mod background;
pub mod cells;
pub mod compact;
pub mod composite;
pub mod drops;
pub mod environment;
pub mod frame;
pub mod glints;
pub mod layers;
pub mod mask;
pub mod output;
#[cfg(feature = "view")]
pub mod overlay;
mod placed;
#[cfg(feature = "view")]
pub mod present;
pub mod radial;
pub mod rain_field;
pub mod renewal;
mod room;
mod shapes;
pub mod simulate;
pub mod sky;
pub(crate) mod tile_grid;
pub mod tiles;
pub mod tone_map;
pub mod totals;
mod veil;

pub(crate) use crate::gpu::{attachment, rendering};
use crate::plan::Light;
use crate::scene::model::{Fresnel, Lookup, Reflection, Weights};

/// Specialization constants 0 to 7 of the shaders that include `light_model.glsl`.
pub(crate) fn light_constants(light: &Light) -> [u32; 8] {
    let index = light.indices.map(|index| (index as f32).to_bits());
    [
        light.internal_reflections,
        (light.weights == Weights::Conserving).into(),
        (light.fresnel == Fresnel::Schlick).into(),
        (light.reflection == Reflection::On).into(),
        (light.lookup == Lookup::Footprint).into(),
        index[0],
        index[1],
        index[2],
    ]
}
