//! Frames of a device: against the reference, the CPU and each other.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/shader.rs"]
mod shader;

mod adjusted;
mod compact;
mod divided;
mod exposure;
mod flat_suns;
mod frame_layout;
mod frames;
mod glints_drawn;
mod grain;
mod lens;
mod limits;
mod mask;
mod models;
mod motion;
mod octahedron;
mod orders;
mod paper_model;
mod populations;
mod rain_field;
mod room;
mod rotation;
mod shape_shader;
mod shapes;
mod simulate;
mod specialized;
mod stages;
mod suns;
mod tile_entries;
mod tile_stages;
mod tile_twins;
mod tiled;
