//! Raindrops rendered as raindrops, at real-time rates, with the error known.
//!
//! The data flow, one direction only: a [`scene::Scene`] and an [`environment::Environment`] go to
//! a renderer, which records the passes of one frame; `reference` computes the same picture in
//! float64. `gpu` knows nothing of rain; `optics`, `rain` and `scene` know nothing of Vulkan.

pub mod bench;
pub mod camera;
pub mod cells;
pub mod cli;
pub mod cull;
pub mod environment;
mod error;
pub mod film;
pub mod gpu;
pub mod model;
pub mod optics;
pub mod paper_twin;
pub mod passes;
pub mod picture;
pub mod plan;
pub mod probe;
pub mod rain;
pub mod reference;
pub mod renderer;
pub mod scene;
pub mod sky;
pub mod tone_map;
pub mod view;

pub use error::{Error, Result};
