//! How fast, and how true: the benchmark, the trade-off, and what their figures stand on.

pub mod bench;
#[cfg(feature = "cli")]
pub(crate) mod chart;
#[cfg(feature = "cli")]
pub mod clocks;
pub mod costs;
pub mod drivers;
pub(crate) mod host;
mod others;
#[cfg(feature = "cli")]
pub mod rain_plot;
mod resolve;
pub mod statistics;
mod system;
pub mod tradeoff;
pub mod verdict;

pub use host::Host;
pub use others::Watch;
pub use resolve::resolve;
