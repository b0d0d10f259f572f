//! The passes of a frame and what is made once for them: each beside its shader in `glsl/`, by the
//! same name. A pass owns what only it needs; barriers between passes stand in `renderer/`.

pub mod appearance;
pub mod background;
pub mod cells;
pub mod compact;
pub mod composite;
pub mod counters;
pub mod drops;
pub mod environment;
pub mod flat_light;
pub mod frame;
pub mod glints;
pub(crate) mod heights;
pub(crate) mod host_records;
pub mod layers;
pub mod mask;
pub mod motion_depth;
pub mod output;
#[cfg(feature = "view")]
pub mod overlay;
pub mod pane;
pub(crate) mod particles;
mod pieces;
mod placed;
#[cfg(feature = "view")]
pub mod present;
pub mod radial;
pub mod rain_field;
pub mod renewal;
mod room;
mod shapes;
mod shelter;
pub mod simulate;
pub mod sky;
mod streak_layer;
pub(crate) mod tile_grid;
mod tile_lists;
pub mod tiles;
pub mod tone_map;
pub mod totals;

use rayon::prelude::*;

use crate::Result;
use crate::gpu::sets::constant;
pub(crate) use crate::gpu::{attachment, rendering};
use crate::plan::Light;
use crate::scene::model::{Fresnel, Lookup, Reflection, Weights};

/// Makes pipelines side by side, the slowest first: drivers compile each for tens of milliseconds.
pub(crate) fn side_by_side<T: Send, U: Send, const N: usize>(
    of: [T; N],
    make: impl Fn(T) -> Result<U> + Sync + Send,
) -> Result<[U; N]> {
    let made: Result<Vec<U>> = of.into_par_iter().with_max_len(1).map(make).collect();
    Ok(made?.try_into().unwrap_or_else(|_| unreachable!("as many as were asked for")))
}

/// Workgroups of a dispatch along an axis, on any device.
const MOST_GROUPS: u32 = 65_535;

/// So many workgroups, or a few more, in as many rows as a device with the least of limits needs.
fn rows_of(groups: u32) -> [u32; 3] {
    let rows = groups.div_ceil(MOST_GROUPS).max(1);
    [groups.div_ceil(rows), rows, 1]
}

/// Specialization constants of the shaders that include `light_model.glsl`.
pub(crate) fn light_constants(light: &Light) -> [[u32; 2]; 9] {
    let index = light.indices.map(|index| (index as f32).to_bits());
    [
        [constant::INTERNAL_REFLECTIONS, light.internal_reflections],
        [constant::CONSERVING, (light.weights == Weights::Conserving).into()],
        [constant::SCHLICK, (light.fresnel == Fresnel::Schlick).into()],
        [constant::REFLECTION, (light.reflection == Reflection::On).into()],
        [constant::FOOTPRINT, (light.lookup == Lookup::Footprint).into()],
        [constant::INDEX_RED, index[0]],
        [constant::INDEX_GREEN, index[1]],
        [constant::INDEX_BLUE, index[2]],
        [constant::PICTURE_LEVEL, light.picture_level],
    ]
}
