//! Every model of a scene, timed and held against the truth: what a user chooses from.
//!
//! Two things are compared in one run or not at all: models are timed in groups, in turn, each group
//! with the presets `paper` and `paper-compact` in it, and a model's speed is a ratio to each; of real rain, which
//! these do not draw, with `fast` and `exact`. Errors are those of
//! [`crate::picture::metrics`] against [`crate::reference`]. A model is worth using if no other is both
//! quicker and truer: those form the Pareto front.

mod duration;
mod models;
#[cfg(feature = "cli")]
mod plot;
mod report;
mod scenes;
mod sizes;
#[cfg(feature = "cli")]
mod sizes_plot;
mod study;

pub use duration::expected_s;
pub use models::{BASES, Model, models, models_of, models_of_pane, models_of_rain};
#[cfg(feature = "cli")]
pub use plot::plot;
pub use report::{Noise, Report, Row, SCHEMA};
pub use scenes::{StudyScene, standard_set, still, weather};
pub use sizes::{Candidate, GlintRow, SizeRow, by_size, candidates, glints_by_size};
#[cfg(feature = "cli")]
pub use sizes_plot::sizes_plot;
pub use study::{Effort, Study, study};
