//! The benchmark: frames of one scene at several drop counts, with and without tone mapping.

pub mod drivers;
mod measure;
mod plot;
mod report;

pub use measure::{Effort, Measured, Variant, measure};
pub use plot::plot;
pub(crate) use report::thousands;
pub use report::{Build, DeviceHead, Parts, Report, Row, SCHEMA, table};
