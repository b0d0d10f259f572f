//! Environments: what loads, what is mended, what is refused, and that nothing panics.

mod broken;
mod files;
mod sky;
mod sound;
