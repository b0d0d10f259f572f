//! What the tree says of itself: pages, schemas, shaders' interfaces, and the list of faults that tests must notice.

#[path = "../common/mod.rs"]
mod common;
#[allow(dead_code, reason = "a part of it is needed here")]
#[path = "../../src/gpu/glsl.rs"]
mod glsl;
#[path = "../../build/interface.rs"]
mod interface;

mod abi;
mod docs;
mod expression;
mod generated;
mod mutants;
mod new_key;
mod replaced;
mod scene_keys;
mod shaders;
