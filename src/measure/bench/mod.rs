//! The benchmark: frames of one scene at several drop counts or rain rates, with and without tone mapping.

#[cfg(feature = "cli")]
mod amount;
mod believed;
#[cfg(feature = "cli")]
mod long;
#[cfg(feature = "cli")]
mod long_plot;
mod measure;
mod over_time;
#[cfg(feature = "cli")]
mod plot;
mod read;
mod report;
mod scene_head;

#[cfg(feature = "cli")]
pub use amount::Amount;
pub use believed::{Timer, WarmUp};
#[cfg(feature = "cli")]
pub use long::{Samples, Watch, Watched, watch};
#[cfg(feature = "cli")]
pub use long_plot::long_plot;
pub use measure::{Effort, Measured, Variant, measure};
pub use over_time::{OverTime, Stretch, Trend};
#[cfg(feature = "cli")]
pub use plot::plot;
pub use read::{of_schema, of_value, read, read_json};
pub use report::{Build, DeviceHead, Parts, Report, Round, Row, SCHEMA};
pub use scene_head::{CameraHead, SceneHead};
