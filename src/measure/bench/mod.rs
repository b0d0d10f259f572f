//! The benchmark: frames of one scene at several drop counts, with and without tone mapping.

pub mod drivers;
mod measure;
#[cfg(feature = "cli")]
mod plot;
mod report;

pub use measure::{Effort, Measured, Variant, measure};
#[cfg(feature = "cli")]
pub use plot::plot;
#[cfg(feature = "cli")]
pub use report::table;
#[cfg(any(feature = "cli", feature = "view"))]
pub(crate) use report::thousands;
pub use report::{Build, DeviceHead, Parts, Report, Row, SCHEMA};
