//! What a verdict is held to, and what is made of it: options and output that all comparisons share.

use std::path::PathBuf;

use clap::Args;

use super::junit;
use super::table::{sheet, side_lines, tail_lines};
use crate::cli::format::Format;
use crate::cli::tell::{Kind, failure, line, note, say};
use crate::cli::{Answer, check_folders, print, write_json};
use crate::measure::bench::DeviceHead;
use crate::measure::verdict::expect::{DeviceExpectations, Expectations, Outcome};
use crate::measure::verdict::{MissingRow, Report, Verdict, VerdictRow};
use crate::remark::Severity;

/// By how much times must differ, whether that is a failure, and how it is printed.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Verdict")]
pub struct GateArgs {
    /// A ratio of times farther from 1 than this is faster or slower: 5% or 0.05 [default: 5%; of a comparison that is judged
    /// again, its own]
    #[arg(long, value_name = "X", value_parser = parse_part)]
    threshold: Option<f64>,
    /// Set --threshold to this (5% or 0.05), and exit with status 1 if a row is slower, or its picture is different where
    /// pictures are compared. An undecided row does not fail (--fail-undecided)
    #[arg(long, value_name = "X", value_parser = parse_part, conflicts_with = "threshold")]
    fail_above: Option<f64>,
    /// Exit with status 1 if a row is undecided: nothing is known of it
    #[arg(long)]
    fail_undecided: bool,
    /// Exit with status 1 if B lacks a row of A [default: true with --fail-above, else false]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    fail_missing: Option<bool>,
    /// How the rows are printed
    #[arg(long, value_enum, value_name = "NAME", default_value_t = Format::Table)]
    pub format: Format,
    /// Write the figures as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the verdicts as JUnit XML, for continuous integration
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Read bounds by device, and rows that are known to fail or to flake, or are skipped, which the other options then do
    /// not fail; exit with status 1 if another row fails, or one that is known to fail passes
    #[arg(long, value_name = "FILE.toml")]
    expect: Option<PathBuf>,
    /// Exit with status 1 also if something in the file of --expect holds for nothing: a name that no row or pass has, a bound of
    /// what was not measured. Without this it is a note
    #[arg(long, requires = "expect")]
    fail_unused: bool,
}

impl GateArgs {
    /// By how much, as a part of 1.
    pub fn threshold(&self) -> f64 {
        self.threshold_or(0.05)
    }

    /// The threshold as a part of 1; `usual` where no option gives one.
    pub fn threshold_or(&self, usual: f64) -> f64 {
        self.fail_above.or(self.threshold).unwrap_or(usual)
    }

    /// Whether a row of A that B lacks fails.
    fn fails_missing(&self) -> bool {
        self.fail_missing.unwrap_or(self.fail_above.is_some())
    }

    /// Whether an option was given that only a comparison has.
    pub fn is_asked(&self) -> bool {
        let files = [&self.junit, &self.expect];
        self.threshold.is_some()
            || self.fail_above.is_some()
            || self.fail_undecided
            || self.fail_missing.is_some()
            || files.into_iter().any(Option::is_some)
    }

    /// Whether stdout is the result file's alone.
    pub fn is_json(&self) -> bool {
        self.format == Format::Json
            || self.json.as_ref().is_some_and(|path| path.as_os_str() == "-")
    }

    /// Fails before the work if the result could not be written after it.
    pub fn check(&self) -> anyhow::Result<()> {
        check_folders([&self.json, &self.junit])?;
        // A mistake in it is reported before the measurement, not after.
        Ok(self.expect.as_deref().map_or(Ok(()), |path| Expectations::load(path).map(drop))?)
    }

    /// Fails if nothing is expected of a device that is to be judged.
    pub fn fits(&self, device: &DeviceHead) -> crate::Result<()> {
        self.expect
            .as_deref()
            .map_or(Ok(()), |path| Expectations::load(path)?.of(path, device).map(drop))
    }

    /// Writes and prints a report, and answers by the gate.
    pub fn tell(&self, mut report: Report) -> anyhow::Result<Answer> {
        self.settle(&mut report)?;
        let report = &report;
        self.write_json(report)?;
        if !self.is_json() {
            if self.format != Format::Csv {
                side_lines(report, self.format).into_iter().try_for_each(print)?;
            }
            print(sheet(report, self.format).text(self.format))?;
            if self.format != Format::Csv {
                tail_lines(report, self.format).into_iter().try_for_each(print)?;
            }
        }
        self.judge(&[report], false)
    }

    /// Writes the result file where it was asked for: to a file, to stdout, to both.
    pub fn write_json(&self, value: &impl serde::Serialize) -> crate::Result<()> {
        write_json(self.json.as_ref(), value)?;
        if self.is_json() && self.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
            write_json(Some(&"-".into()), value)?;
        }
        Ok(())
    }

    /// Enters into a report how many rows have which verdict, and which of them the gate fails.
    pub fn settle(&self, report: &mut Report) -> crate::Result<()> {
        let counts = Verdict::ALL.map(|verdict| (verdict.name().into(), report.count(verdict)));
        report.counts = counts.into_iter().collect();
        let expected = self.expected(report)?;
        report.failed = self.failed(report, expected.as_ref());
        report.bounds = expected.as_ref().and_then(DeviceExpectations::bounds);
        let Some(expected) = expected else { return Ok(()) };
        if self.fail_unused {
            report.failed.extend(expected.unused(report));
        }
        let outcomes = outcomes(report, &expected);
        for (row, outcome) in report.rows.iter_mut().zip(outcomes) {
            row.outcome = Some(outcome.name().into());
            if outcome.is_unexpected() {
                report.failed.push(format!("{} ({})", row.name, outcome.name()));
            }
        }
        Ok(())
    }

    /// Holds reports that are settled against what is expected, writes JUnit's file, and answers by the gate. Says on
    /// stderr which rows did not simply pass. `fails_pictures`: another option fails those whose pictures differ.
    pub fn judge(&self, reports: &[&Report], fails_pictures: bool) -> anyhow::Result<Answer> {
        let (mut failed, mut all_outcomes) = (Vec::new(), Vec::new());
        for report in reports {
            let expected = self.expected(report)?;
            failed.extend(self.failed(report, expected.as_ref()));
            let of_rows = expected.as_ref().map(|all| outcomes(report, all));
            say_outcomes(report, of_rows.as_deref().unwrap_or_default());
            all_outcomes.push(of_rows);
            let (Some(path), Some(expected)) = (&self.expect, expected) else { continue };
            let kind = match self.fail_unused {
                true => Kind::Failure,
                false => Kind::Remark(Severity::Note),
            };
            for what in expected.unused(report) {
                line(kind, &format!("{}: {what}", path.display()));
            }
        }
        if let Some(path) = &self.junit {
            junit::write(path, reports.iter().copied().zip(&all_outcomes))?;
        }
        if !failed.is_empty() {
            failure!("{}", failed.join("; "));
        } else if self.fail_above.is_none() && self.expect.is_none() {
            for (verdict, fails) in [(Verdict::Slower, false), (Verdict::Different, fails_pictures)]
            {
                let is_there = |row: &VerdictRow| !fails && row.verdict == verdict;
                if reports.iter().any(|report| report.rows.iter().any(is_there)) {
                    let name = verdict.name();
                    note!("without --fail-above a {name} row does not change the exit status");
                }
            }
            if !self.fails_missing() && reports.iter().any(|report| !report.missing.is_empty()) {
                note!("without --fail-missing a row that B lacks does not change the exit status");
            }
        }
        let holds = reports.iter().all(|report| report.failed.is_empty());
        Ok(if holds { Answer::Yes } else { Answer::No })
    }

    /// The rows that `--fail-above`, `--fail-undecided` and `--fail-missing` fail. Those that a file of expectations lists are
    /// left to it.
    fn failed(&self, report: &Report, expected: Option<&DeviceExpectations>) -> Vec<String> {
        let is_bounded = self.fail_above.is_some();
        let fails = |row: &&VerdictRow| match row.verdict {
            Verdict::Slower | Verdict::Different => is_bounded,
            // Undecided by the threshold, it may be decided by a bound.
            Verdict::Undecided => {
                let is_decided =
                    |all: &DeviceExpectations| !matches!(all.judge(row), Outcome::Undecided(_));
                self.fail_undecided && !expected.is_some_and(is_decided)
            }
            Verdict::Faster | Verdict::Same => false,
        };
        let rows = report.rows.iter().filter(fails).map(|row| (&row.name, row.verdict.name()));
        let missing = report.missing.iter().filter(|_| self.fails_missing());
        let rows = rows.chain(missing.map(|row| (&row.name, MissingRow::VERDICT)));
        let is_listed = |name: &str| expected.is_some_and(|all| all.lists(name));
        let rows = rows.filter(|(name, _)| !is_listed(name));
        rows.map(|(name, why)| format!("{name} ({why})")).collect()
    }

    /// What is expected of a report's device; none where there is no file.
    fn expected(&self, report: &Report) -> crate::Result<Option<DeviceExpectations>> {
        let Some(path) = &self.expect else { return Ok(None) };
        Ok(Some(Expectations::load(path)?.of(path, &report.b.device)?.clone()))
    }
}

/// What became of each row by what is expected.
fn outcomes(report: &Report, expected: &DeviceExpectations) -> Vec<Outcome> {
    report.rows.iter().map(|row| expected.judge(row)).collect()
}

/// Says on stderr what became of the rows that did not simply pass.
fn say_outcomes(report: &Report, outcomes: &[Outcome]) {
    for (row, outcome) in report.rows.iter().zip(outcomes) {
        if let Some(why) = outcome.why() {
            say!("{}: {}: {why}", outcome.name(), row.name);
        }
    }
}

/// `5%` or `0.05` to 0.05. Whoever writes 5 means 5%.
fn parse_part(text: &str) -> Result<f64, String> {
    let part = part(text).filter(|part| *part > 0.0 && *part <= 10.0).ok_or_else(|| {
        format!("'{text}' is not a fraction like 5% or 0.05, over 0 and up to 1000%")
    })?;
    match part > 1.0 && !text.ends_with('%') {
        true => Err(format!(
            "'{text}' would be {:.0}%; write {text}% or a number up to 1",
            100.0 * part
        )),
        false => Ok(part),
    }
}

/// The mean FLIP over which two drivers' pictures are different, unless it is said otherwise: over what they may round
/// (points of `paper` on a driver that places them by 1/16 pixel, 0.0076).
pub const MAX_FLIP: f64 = 0.01;

/// A mean FLIP; 0: pictures must be the same.
pub fn parse_flip(text: &str) -> Result<f64, String> {
    let flip = part(text).filter(|flip| (0.0..=1.0).contains(flip));
    flip.ok_or_else(|| format!("'{text}' is not a mean FLIP, from 0 to 1"))
}

fn part(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    match text.strip_suffix('%') {
        Some(percent) => number(percent).map(|percent| percent / 100.0),
        None => number(text),
    }
}

#[cfg(test)]
mod tests {
    use super::{parse_flip, parse_part};

    #[test]
    fn parts() {
        assert_eq!(parse_part("5%"), Ok(0.05));
        assert_eq!(parse_part("0.05"), Ok(0.05));
        for wrong in ["", "%", "0", "-5%", "nan", "inf", "5 percent", "5"] {
            assert!(parse_part(wrong).is_err(), "{wrong}");
        }
        assert_eq!((parse_flip("0"), parse_flip("1%")), (Ok(0.0), Ok(0.01)));
        // Over a bound that is no number nothing is.
        for wrong in ["nan", "-0.1", "1.1", ""] {
            assert!(parse_flip(wrong).is_err(), "{wrong}");
        }
    }
}
