//! The physics of one drop and of rain, what is measured of pictures, and the reference: on the CPU alone, against closed
//! forms, other ray tracers and themselves.

#[path = "../common/mod.rs"]
mod common;

mod flat_suns;
mod glints;
mod independent;
mod matrices;
mod metrics;
mod optics;
mod pane;
mod pane_pictures;
mod pane_rain;
mod plates;
mod rain_cells;
mod rain_drops;
mod rain_law;
mod rain_reference;
mod rain_shape;
mod rainbow;
mod reference;
mod shutter;
mod spheroid;
mod tone_map;
mod verdict_rates;
