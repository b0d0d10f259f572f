//! What a verdict is held to, and what is made of it: options and output that all comparisons share.

use std::path::{Path, PathBuf};

use clap::Args;

use super::junit;
use super::table::{sheet, side_lines, tail_lines};
use crate::cli::format::Format;
use crate::cli::{Answer, check_folder, print, write_json};
use crate::measure::verdict::expect::{Expectations, Outcome};
use crate::measure::verdict::{Report, Verdict};

/// By how much times must differ, whether that is a failure, and how it is told.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Verdict")]
pub struct GateArgs {
    /// A ratio of times farther from 1 than this is faster or slower: 5% or 0.05 [default: 5%]
    #[arg(long, value_name = "X", value_parser = parse_part)]
    threshold: Option<f64>,
    /// Set --threshold to this, and exit with status 1 if a row is slower or its picture is different
    #[arg(long, value_name = "X", value_parser = parse_part, conflicts_with = "threshold")]
    fail_above: Option<f64>,
    /// What the rows are printed as
    #[arg(long, value_enum, value_name = "NAME", default_value_t = Format::Table)]
    pub format: Format,
    /// Write the figures as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the verdicts as JUnit XML, for a page of continuous integration
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Bounds by device, and rows that are known to fail, to flake or to be left out; exit with status 1 if
    /// an unlisted row fails or one that is known to fail passes
    #[arg(long, value_name = "FILE.toml")]
    expect: Option<PathBuf>,
}

impl GateArgs {
    /// The ids of its options, for whoever passes the others on.
    pub const IDS: [&str; 6] = ["threshold", "fail_above", "format", "json", "junit", "expect"];

    /// By how much, as a part of 1.
    pub fn threshold(&self) -> f64 {
        self.fail_above.or(self.threshold).unwrap_or(0.05)
    }

    /// Whether an option was given that only a comparison has.
    pub fn is_asked(&self) -> bool {
        let files = [&self.junit, &self.expect];
        self.threshold.is_some()
            || self.fail_above.is_some()
            || files.into_iter().any(Option::is_some)
    }

    /// Whether stdout is the result file's alone.
    pub fn is_json(&self) -> bool {
        self.format == Format::Json
            || self.json.as_ref().is_some_and(|path| path.as_os_str() == "-")
    }

    /// Fails before the work if the result could not be written after it.
    pub fn check(&self) -> anyhow::Result<()> {
        [&self.json, &self.junit].into_iter().flatten().try_for_each(|path| check_folder(path))?;
        // A mistake in it is told before the measurement, not after.
        Ok(self.expect.as_deref().map_or(Ok(()), |path| Expectations::load(path).map(drop))?)
    }

    /// Writes and prints a report, and answers by the gate.
    pub fn tell(&self, report: &Report) -> anyhow::Result<Answer> {
        if let Some(path) = &self.json {
            write_json(path, report)?;
        } else if self.is_json() {
            write_json("-".as_ref(), report)?;
        }
        if !self.is_json() {
            if self.format != Format::Csv {
                side_lines(report, self.format).into_iter().try_for_each(print)?;
            }
            print(sheet(report, self.format).text(self.format))?;
            if self.format != Format::Csv {
                tail_lines(report, self.format).into_iter().try_for_each(print)?;
            }
        }
        if let Some(path) = &self.junit {
            junit::write(path, report)?;
        }
        let unexpected = self.expect.as_deref().map_or(Ok(0), |path| expected(path, report))?;
        let fails = self.fails([report].into_iter());
        Ok(if fails || unexpected > 0 { Answer::No } else { Answer::Yes })
    }

    /// Whether a gate was asked for and fails; says on stderr by which rows.
    pub fn fails<'a>(&self, reports: impl Iterator<Item = &'a Report>) -> bool {
        let reports: Vec<&Report> = reports.filter(|report| report.fails()).collect();
        if self.fail_above.is_none() || reports.is_empty() {
            return false;
        }
        let of = |verdict: Verdict| {
            let rows = reports.iter().flat_map(|report| &report.rows);
            let rows = rows.filter(move |row| row.verdict == verdict);
            rows.map(move |row| format!("{} ({})", row.name, verdict.name()))
        };
        let failed: Vec<_> = of(Verdict::Slower).chain(of(Verdict::Different)).collect();
        eprintln!("raindrops: {}", failed.join("; "));
        true
    }
}

/// Holds a report against an expectations file, says on stderr what became of each row that did not simply
/// pass, and counts those that are not as expected.
fn expected(path: &Path, report: &Report) -> anyhow::Result<usize> {
    let all = Expectations::load(path)?;
    let expectations = all.of(path, &report.b.device)?;
    let mut unexpected = 0;
    for row in &report.rows {
        let outcome = expectations.judge(row);
        unexpected += usize::from(outcome.is_unexpected());
        let why = match &outcome {
            Outcome::Pass => continue,
            Outcome::Fail(why) | Outcome::ExpectedFail(why) | Outcome::Flake(why) => why.as_str(),
            Outcome::UnexpectedPass => "take it from the fails",
            Outcome::Faster => "its bounds may be set tighter",
            Outcome::Skip => "left out",
        };
        eprintln!("{}: {}: {why}", outcome.name(), row.name);
    }
    for part in expectations.unused(&report.rows) {
        eprintln!("note: {}: no row's name contains '{part}'", path.display());
    }
    Ok(unexpected)
}

/// `5%` or `0.05` to 0.05.
pub fn parse_part(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let part = match text.strip_suffix('%') {
        Some(percent) => number(percent).map(|percent| percent / 100.0),
        None => number(text),
    };
    part.filter(|part| *part > 0.0 && *part <= 10.0).ok_or_else(|| {
        format!("'{text}' is not a fraction like 5% or 0.05, over 0 and up to 1000%")
    })
}

#[cfg(test)]
mod tests {
    use super::parse_part;

    #[test]
    fn parts() {
        assert_eq!(parse_part("5%"), Ok(0.05));
        assert_eq!(parse_part("0.05"), Ok(0.05));
        for wrong in ["", "%", "0", "-5%", "nan", "inf", "5 percent"] {
            assert!(parse_part(wrong).is_err(), "{wrong}");
        }
    }
}
