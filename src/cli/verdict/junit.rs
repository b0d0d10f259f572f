//! Verdicts as JUnit XML, which pages of continuous integration show: a test a row, a suite a comparison.
//!
//! Such pages know a test by its `classname` and `name` together, over all suites of a file: of two tests with the same two
//! they keep one. So the class is the suite's name, and names that would be there twice get a number.

use std::path::Path;

use quick_junit::{NonSuccessKind, Report as Junit, TestCase, TestCaseStatus, TestSuite};

use super::table::row_lines;
use crate::files::write_whole;
use crate::measure::verdict::expect::Outcome;
use crate::measure::verdict::{MissingRow, Report, Verdict, VerdictRow};
use crate::thousands::counted;
use crate::{Error, Result};

/// Writes reports. Slower and different rows fail, undecided ones are skipped; where something is expected of the
/// rows, what is not as expected fails, and what is known to fail, is undecided or is left out is skipped. Rows that the
/// gate fails fail in any case. A row that B lacks fails by the gate, else it is skipped. What the expectations name and no row
/// has is a test of its own, where it fails.
pub fn write<'a>(
    path: &Path,
    reports: impl Iterator<Item = (&'a Report, &'a Option<Vec<Outcome>>)>,
) -> Result<()> {
    let mut junit = Junit::new("raindrops verdict");
    let mut suites = Names::default();
    for (report, outcomes) in reports {
        let mut suite = TestSuite::new(suites.taken(&name(report)));
        let is_failed = |name: &str| report.failed.iter().any(|failed| is_of(failed, name));
        let mut cases = Vec::new();
        for (number, row) in report.rows.iter().enumerate() {
            let outcome = outcomes.as_ref().and_then(|outcomes| outcomes.get(number));
            cases.push(case(row, outcome, is_failed(&row.name)));
        }
        cases.extend(report.missing.iter().map(|row| missing(row, is_failed(&row.name))));
        let rows = || {
            let missing = report.missing.iter().map(|row| &row.name);
            report.rows.iter().map(|row| &row.name).chain(missing)
        };
        let is_of_none = |failed: &&String| !rows().any(|name| is_of(failed, name));
        for what in report.failed.iter().filter(is_of_none) {
            let status = said(TestCaseStatus::non_success(NonSuccessKind::Failure), what);
            cases.push(TestCase::new(format!("--expect: {what}"), status));
        }
        let mut names = Names::default();
        for mut case in cases {
            case.name = names.taken(&case.name).into();
            case.set_classname(suite.name.clone());
            suite.add_test_case(case);
        }
        junit.add_test_suite(suite);
    }
    let text = junit.to_string().map_err(|error| Error::write(path, error))?;
    write_whole(path, text.as_bytes())
}

/// Names that are in use.
#[derive(Default)]
struct Names(Vec<String>);

impl Names {
    /// A name that is not in use yet: that one, or that one with the first number that makes it new.
    fn taken(&mut self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        let mut all = std::iter::once(name.to_string()).chain(numbered);
        let new = all.find(|name| !self.0.contains(name)).unwrap_or_default();
        self.0.push(new.clone());
        new
    }
}

/// Whether an entry of a report's failures is of the row of this name: the name, then in brackets why.
fn is_of(failed: &str, name: &str) -> bool {
    failed.strip_prefix(name).is_some_and(|why| why.starts_with(" ("))
}

/// Which devices, where they differ: what a side is called may be a path. Else what the sides are called.
fn name(report: &Report) -> String {
    let [a, b] = [&report.a, &report.b].map(|side| side.device.summary());
    match a == b {
        true => format!("{} against {}", report.b.label, report.a.label),
        false => format!("{b} against {a}"),
    }
}

fn said(mut status: TestCaseStatus, message: &str) -> TestCaseStatus {
    status.set_message(message);
    status
}

/// A row that B lacks.
fn missing(row: &MissingRow, is_failed: bool) -> TestCase {
    let status = match is_failed {
        true => TestCaseStatus::non_success(NonSuccessKind::Failure),
        false => TestCaseStatus::skipped(),
    };
    let message = format!("{}: A has this row, B does not", MissingRow::VERDICT);
    TestCase::new(row.name.clone(), said(status, &message))
}

fn case(row: &VerdictRow, outcome: Option<&Outcome>, is_failed: bool) -> TestCase {
    let ratio = row.ratio.zip(row.ratio_low.zip(row.ratio_high));
    let ratio = ratio.map_or("no interval".into(), |(ratio, (low, high))| {
        format!("B / A {ratio:.3} ({low:.3} to {high:.3})")
    });
    let rounds = counted(row.rounds as u64, "round");
    let mut message = format!("{}: {ratio}, {rounds}", row.verdict.name());
    if let Some(outcome) = outcome {
        let why = outcome.why().map_or(String::new(), |why| format!(": {why}"));
        message = format!("{}{why}; {message}", outcome.name());
    }
    let failure = || TestCaseStatus::non_success(NonSuccessKind::Failure);
    let status = match (outcome, row.verdict) {
        _ if is_failed => failure(),
        (
            Some(
                Outcome::ExpectedFail(_)
                | Outcome::Flake(_)
                | Outcome::Undecided(_)
                | Outcome::Skip,
            ),
            _,
        ) => TestCaseStatus::skipped(),
        (Some(_), _) | (None, Verdict::Same | Verdict::Faster) => TestCaseStatus::success(),
        (None, Verdict::Undecided) => TestCaseStatus::skipped(),
        (None, Verdict::Slower | Verdict::Different) => failure(),
    };
    let mut case = TestCase::new(row.name.clone(), said(status, &message));
    let more = row_lines(row).into_iter();
    case.set_system_out(std::iter::once(message).chain(more).collect::<Vec<_>>().join("\n"));
    case
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn no_name_is_given_twice() {
        let mut names = Names::default();
        let found = ["a", "a (2)", "a", "b", "a"].map(|name| names.taken(name));
        assert_eq!(found, ["a", "a (2)", "a (3)", "b", "a (4)"]);
    }
}
