//! How fast, and how true: the benchmark, the trade-off, and what their figures stand on.

pub mod bench;
mod host;
pub mod rain_plot;
pub mod statistics;
pub mod tradeoff;

pub use host::Host;
