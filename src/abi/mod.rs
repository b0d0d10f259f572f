//! What Rust and GLSL share, each written once:
//! - constants in `constants.rs`, from which shaders get `constants.glsl`;
//! - structures in the shaders, from which `build.rs` makes those here (`build/interface.rs`), and the numbers of bindings
//!   and of specialization constants in `gpu::sets`.

mod constants;

pub use constants::*;

include!(concat!(env!("OUT_DIR"), "/structures.rs"));
