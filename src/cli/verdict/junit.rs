//! Verdicts as JUnit XML, which pages of continuous integration show: a test a row.

use std::path::Path;

use quick_junit::{NonSuccessKind, Report as Junit, TestCase, TestCaseStatus, TestSuite};

use crate::files::write_whole;
use crate::measure::verdict::{Report, Verdict, VerdictRow};
use crate::{Error, Result};

/// Writes a report: slower and different rows fail, undecided ones are skipped.
pub fn write(path: &Path, report: &Report) -> Result<()> {
    let text = text(report).map_err(|error| Error::write(path, error))?;
    write_whole(path, text.as_bytes())
}

fn text(report: &Report) -> std::result::Result<String, quick_junit::SerializeError> {
    let mut suite = TestSuite::new(format!("{} against {}", report.b.label, report.a.label));
    suite.add_test_cases(report.rows.iter().map(case));
    let mut junit = Junit::new("raindrops verdict");
    junit.add_test_suite(suite);
    junit.to_string()
}

fn case(row: &VerdictRow) -> TestCase {
    let ratio = row.ratio.zip(row.ratio_low.zip(row.ratio_high));
    let ratio = ratio.map_or("no interval".into(), |(ratio, (low, high))| {
        format!("B / A {ratio:.3} ({low:.3} to {high:.3})")
    });
    let message = format!("{}: {ratio}, {} rounds", row.verdict.name(), row.rounds);
    let mut status = match row.verdict {
        Verdict::Same | Verdict::Faster => TestCaseStatus::success(),
        Verdict::Undecided => TestCaseStatus::skipped(),
        Verdict::Slower | Verdict::Different => {
            TestCaseStatus::non_success(NonSuccessKind::Failure)
        }
    };
    status.set_message(message.clone());
    let mut case = TestCase::new(row.name.clone(), status);
    case.set_classname("raindrops");
    case.set_system_out(message);
    case
}
