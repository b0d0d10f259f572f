//! The physics of one drop and of rain, and what is measured of pictures: on the CPU alone.

#[path = "../common/mod.rs"]
mod common;

mod metrics;
mod optics;
mod rain_cells;
mod rain_law;
mod rain_shape;
mod spheroid;
mod tone_map;
