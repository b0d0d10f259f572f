//! Frames of a device: against the reference, the CPU and each other.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/shader.rs"]
mod shader;

mod adjusted;
mod auto;
mod compact;
mod divided;
mod exposure;
mod extremes;
mod flat_suns;
mod fog;
mod frame_layout;
mod frames;
mod glints_drawn;
mod grain;
mod known;
mod layers;
mod lens;
mod lifetimes;
mod limits;
mod mask;
mod models;
mod motion;
mod moving_camera;
mod octahedron;
mod orders;
mod pane_aging;
mod pane_drawn;
mod pane_layers;
mod paper_model;
mod particles;
mod pipelines;
mod placed;
mod plates_drawn;
mod populations;
mod probe;
mod rain_field;
mod room;
mod rotation;
mod same_bytes;
mod shape_shader;
mod shapes;
mod shelter;
mod simulate;
mod specialized;
mod stages;
mod streaks;
mod suns;
mod tile_entries;
mod tile_serial;
mod tile_stages;
mod tiled;
mod vendors;
mod window;
