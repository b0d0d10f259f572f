//! Verdicts as JUnit XML, which pages of continuous integration show: a test a row, a suite a comparison.

use std::path::Path;

use quick_junit::{NonSuccessKind, Report as Junit, TestCase, TestCaseStatus, TestSuite};

use super::table::row_lines;
use crate::files::write_whole;
use crate::measure::verdict::expect::Outcome;
use crate::measure::verdict::{Report, Verdict, VerdictRow};
use crate::thousands::counted;
use crate::{Error, Result};

/// Writes reports. Slower and different rows fail, undecided ones are skipped; where something is expected of the
/// rows, what is not as expected fails, and what is known to fail, is undecided or is left out is skipped. Rows that the
/// gate fails fail in any case. What the expectations name and no row has is a test of its own, where it fails.
pub fn write<'a>(
    path: &Path,
    reports: impl Iterator<Item = (&'a Report, &'a Option<Vec<Outcome>>)>,
) -> Result<()> {
    let mut junit = Junit::new("raindrops verdict");
    for (report, outcomes) in reports {
        let mut suite = TestSuite::new(name(report));
        for (number, row) in report.rows.iter().enumerate() {
            let outcome = outcomes.as_ref().and_then(|outcomes| outcomes.get(number));
            let is_failed = report.failed.iter().any(|failed| is_of(failed, row));
            suite.add_test_case(case(row, outcome, is_failed));
        }
        let is_of_none = |failed: &&String| !report.rows.iter().any(|row| is_of(failed, row));
        for what in report.failed.iter().filter(is_of_none) {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(what.as_str());
            let mut case = TestCase::new("--expect", status);
            case.set_classname("raindrops");
            suite.add_test_case(case);
        }
        junit.add_test_suite(suite);
    }
    let text = junit.to_string().map_err(|error| Error::write(path, error))?;
    write_whole(path, text.as_bytes())
}

/// Whether an entry of a report's failures is of a row: its name, then in brackets why.
fn is_of(failed: &str, row: &VerdictRow) -> bool {
    failed.strip_prefix(&row.name).is_some_and(|why| why.starts_with(" ("))
}

/// Which devices, where they differ: what a side is called may be a path. Else what the sides are called.
fn name(report: &Report) -> String {
    let [a, b] = [&report.a, &report.b].map(|side| side.device.summary());
    match a == b {
        true => format!("{} against {}", report.b.label, report.a.label),
        false => format!("{b} against {a}"),
    }
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
    let mut status = match (outcome, row.verdict) {
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
    status.set_message(message.clone());
    let mut case = TestCase::new(row.name.clone(), status);
    case.set_classname("raindrops");
    let more = row_lines(row).into_iter();
    case.set_system_out(std::iter::once(message).chain(more).collect::<Vec<_>>().join("\n"));
    case
}
