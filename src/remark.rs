//! What is worth saying beside a result, and how much it matters.

use std::fmt;

/// How much a remark matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// For whoever asks for details.
    Detail,
    /// Good to know; the result is what was asked for.
    Note,
    /// The result may not be what was asked for.
    Warning,
}

/// One line beside a result, without an end of line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// How much it matters.
    pub severity: Severity,
    /// The line, without a label.
    pub text: String,
}

impl Remark {
    /// A line for whoever asks for details.
    pub fn detail(text: impl Into<String>) -> Self {
        Self { severity: Severity::Detail, text: text.into() }
    }

    /// A line that is good to know.
    pub fn note(text: impl Into<String>) -> Self {
        Self { severity: Severity::Note, text: text.into() }
    }

    /// A line that one should know.
    pub fn warning(text: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, text: text.into() }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}
