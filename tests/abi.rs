//! What Rust and GLSL share, without a device: the numbers, structures and constants that the program was built with are
//! those of the shaders' sources, and the build fails where shaders do not agree.

#[allow(dead_code, reason = "it needs the names alone")]
#[path = "../src/gpu/glsl.rs"]
mod glsl;
#[path = "../build/interface.rs"]
mod interface;

use std::path::PathBuf;

use glsl::Glsl;
use interface::Interface;

const SETS: &str = include_str!(concat!(env!("OUT_DIR"), "/sets.rs"));
const STRUCTURES: &str = include_str!(concat!(env!("OUT_DIR"), "/structures.rs"));

/// What the shaders share with Rust: of this tree, or of those that `tests/mutants.rs` has put a fault in.
fn interface() -> Result<Interface, String> {
    let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("glsl");
    let folder = std::env::var_os("RAINDROPS_TEST_GLSL").map_or(own, PathBuf::from);
    let variants = interface::variants(&folder).map_err(|error| error.to_string())?;
    Interface::read(&Glsl::new(&folder)?, &variants)
}

#[test]
fn shaders_are_those_that_rust_was_built_with() {
    let interface = interface().unwrap_or_else(|error| panic!("{error}"));
    assert!(interface.sets() == SETS, "other bindings, constants or workgroups");
    assert!(interface.structures().as_deref() == Ok(STRUCTURES), "other structures");
}
