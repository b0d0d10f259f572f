//! Rain in a host's frame: what it asks of the device, what it records and what not, what it refuses, and that its
//! picture is the one that `render` makes. The host is the one of `examples/host_ash`.

#[path = "../common/mod.rs"]
mod common;
#[path = "../../examples/host_ash/src/host.rs"]
mod host;

mod calls;
mod contract;
mod embedded;
mod host_scene;
mod images;
mod memory;
mod motion_depth;
mod over;
mod pane_drops;
mod particles;
mod pictures;
mod refused_images;
mod renewed;
mod shelter;
