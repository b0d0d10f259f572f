//! Environments: what loads, what is mended, what is refused, and that nothing panics.

#[path = "../common/mod.rs"]
mod common;

mod broken;
mod files;
mod heights;
mod reading;
mod reading_depth;
mod scenes_and_pictures;
mod sky;
mod sound;
