//! What Rust and GLSL share, without a device: the numbers, structures and constants that the program was built with are
//! those of the shaders' sources, some of them as a reader finds them there, and the build fails where shaders do not agree.

use std::mem::offset_of;
use std::path::PathBuf;

use crate::glsl::Glsl;
use crate::interface::{self, Interface};

const SETS: &str = include_str!(concat!(env!("OUT_DIR"), "/sets.rs"));
const STRUCTURES: &str = include_str!(concat!(env!("OUT_DIR"), "/structures.rs"));

#[allow(dead_code, reason = "a few of them are looked at")]
mod structures {
    include!(concat!(env!("OUT_DIR"), "/structures.rs"));
}

/// What the shaders share with Rust: of this tree, or of those that `tests/house/mutants.rs` has put a fault in.
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

/// The numbers here are read from the GLSL by hand: a generator that reads all shaders alike, and wrongly, is noticed.
#[test]
fn some_numbers_are_those_that_a_reader_finds_in_the_shaders() {
    use structures::{BackgroundPush, Constants, Frame, MotionDepthPush, Population, RenewalPush};
    // include/frame.glsl: 24 vectors, of which `window` is the 13th; five in a population, of which three follow.
    assert_eq!([offset_of!(Frame, up), offset_of!(Frame, window)], [16, 192]);
    assert_eq!([offset_of!(Frame, lens), size_of::<Frame>()], [368, 384]);
    assert_eq!([offset_of!(Population, moved), size_of::<Population>()], [64, 80]);
    assert_eq!([offset_of!(Constants, others), size_of::<Constants>()], [384, 624]);
    // sky.comp
    assert_eq!(
        [offset_of!(BackgroundPush, depth), offset_of!(BackgroundPush, color_scale)],
        [0, 16]
    );
    // renew_map.comp: three vectors, then two words; motion_depth.frag: two words, then one.
    assert_eq!([offset_of!(RenewalPush, scale), offset_of!(RenewalPush, edge)], [48, 52]);
    assert_eq!([offset_of!(MotionDepthPush, pixel), offset_of!(MotionDepthPush, is_depth)], [0, 8]);

    let has = |module: &str, line: String| {
        let (_, rest) = SETS.split_once(&format!("pub mod {module} {{")).expect(module);
        let own = rest.split('}').next().expect("its end");
        assert!(own.lines().any(|other| other.trim() == line), "{module}: no '{line}' in {own}");
    };
    for (set, slot, number, kind) in [
        ("background", "COLOR_IMAGE", 18, "COMBINED_IMAGE_SAMPLER"),
        ("background", "DEPTH_IMAGE", 19, "COMBINED_IMAGE_SAMPLER"),
        // sky.comp is in two sets, and writes one buffer.
        ("background", "SKY", 1, "STORAGE_BUFFER"),
        ("composite", "SKY", 1, "STORAGE_BUFFER"),
        ("composite", "SPLAT_TABLE", 5, "STORAGE_BUFFER"),
        ("splat_table", "SPLAT_TABLE", 5, "STORAGE_BUFFER"),
        ("tile_frame", "CONSTANTS", 0, "UNIFORM_BUFFER"),
        ("tile_frame", "NODES", 4, "STORAGE_BUFFER"),
        ("tile_frame", "BEHIND", 12, "STORAGE_BUFFER"),
        ("glints", "SOURCES", 14, "STORAGE_BUFFER"),
        ("simulate", "COUNTERS", 11, "STORAGE_BUFFER"),
        ("renew_map", "HOST_IMAGE", 0, "COMBINED_IMAGE_SAMPLER"),
        ("renew_map", "REST", 2, "STORAGE_IMAGE"),
        ("motion_depth", "CONSTANTS", 0, "UNIFORM_BUFFER"),
        ("motion_depth", "DROP_RECORDS", 2, "STORAGE_BUFFER"),
    ] {
        let kind = format!("crate::gpu::Binding::{kind}");
        has(
            set,
            format!(
                "pub const {slot}: crate::gpu::Slot = crate::gpu::Slot::new({number}, {kind});"
            ),
        );
    }
    for (constant, number) in [("STORED", 0), ("SPLAT_PX", 9), ("LOG_SUMS", 17), ("LAYERS", 20)] {
        has("constant", format!("pub const {constant}: u32 = {number};"));
    }
    for (shader, size) in [("SKY_COMP", "[16, 4, 1]"), ("RENEW_MAP_COMP_CUBE", "[64, 1, 1]")] {
        has("group", format!("pub const {shader}: [u32; 3] = {size};"));
    }
}
