//! Slower or not, and how sure: two results held against each other.
//!
//! The unit is a round, a fresh process: frames of one process are correlated, and medians of the same
//! binary differ by 5 to 30 % from minute to minute on the machines at hand. Two things that can run in
//! turn are compared pair by pair (`paired.rs`), looked at after fixed numbers of rounds (`looks.rs`).
//! A result that was kept cannot: there runs at different times are compared (`unpaired.rs`). `row.rs`
//! has what is said of a row, `files.rs` which rows of two result files belong together, `expect.rs` what a
//! project expects of them.

pub mod expect;
mod files;
pub mod looks;
pub mod paired;
mod row;
pub mod unpaired;

pub use files::{Side, in_turn, kept, missing};
pub use row::{Method, MissingRow, PassRow, Pictures, Report, SCHEMA, Verdict, VerdictRow, judge};

/// Part of all intervals that may miss the ratio, all looks at a row together.
pub const ERROR: f64 = 0.05;

/// A ratio of times, B over A, and the interval that holds it with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub ratio: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// The interval by the three fields of a result file; none if one is missing.
    fn of_ends(ratio: Option<f64>, low: Option<f64>, high: Option<f64>) -> Option<Self> {
        Some(Self { ratio: ratio?, low: low?, high: high? })
    }

    /// From logarithms.
    fn of_logs(middle: f64, low: f64, high: f64) -> Self {
        Self { ratio: middle.exp(), low: low.exp(), high: high.exp() }
    }
}
