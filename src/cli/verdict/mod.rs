//! `raindrops verdict`: two kept results held against each other, row by row, or a kept comparison judged again.

mod again;
pub mod gate;
mod junit;
pub mod table;

use std::path::PathBuf;

use clap::Args;

use self::gate::{GateArgs, parse_flip};
use super::{Answer, command_line};
use crate::measure::bench::{Report, read};
use crate::measure::verdict::{self, Method, MissingRow, Side, kept};

/// Judge two kept results of bench, row by row, or a kept comparison again
///
/// Each row is faster, slower, same or undecided, by an interval that contains the ratio of times with 95 %
/// confidence. The two were measured at different times, so each run counts as one sample. Several
/// files of a side, measured at different times with `bench --rounds 10`, make the interval narrower.
///
/// One file that a comparison wrote (`bench --a … --b …`, compare-devices, verdict) is judged again; nothing is measured. Its
/// threshold and FLIP stay unless they are given here. What failed then is forgotten: give it here, too.
#[derive(Args)]
pub struct VerdictArgs {
    /// Result files of the base (A), comma-separated: the same measurement at different times. Without B: a comparison
    #[arg(value_name = "BASE.json,…", value_parser = files)]
    base: Files,
    /// Result files compared with it (B), comma-separated; they may be of another device
    #[arg(value_name = "NEW.json,…", value_parser = files)]
    new: Option<Files>,
    /// Refuse results of different devices; their drivers may be of different versions
    #[arg(long, requires = "new")]
    same_device: bool,
    /// A row of a comparison is `different` if its pictures are farther apart than this mean FLIP; for a comparison by
    /// compare-devices the exit status is then 1, as there [default: as it was measured]
    #[arg(long, value_name = "X", value_parser = parse_flip, conflicts_with = "new")]
    max_flip: Option<f64>,
    #[command(flatten)]
    gate: GateArgs,
}

/// Several files in one argument.
type Files = std::sync::Arc<[PathBuf]>;

fn files(text: &str) -> Result<Files, String> {
    Ok(text.split(',').map(PathBuf::from).collect())
}

/// Runs the command.
pub fn run(args: &VerdictArgs) -> anyhow::Result<Answer> {
    args.gate.check()?;
    let Some(new) = &args.new else {
        return again::judge(&args.base, args.max_flip, &args.gate);
    };
    let (a, b) = (runs(&args.base)?, runs(new)?);
    let threshold = args.gate.threshold();
    let rows = kept(&a, &b, args.same_device, threshold)?;
    let (notes, missing) = notes(&of_runs(&a), &of_runs(&b));
    let report = verdict::Report {
        command: Some(command_line()),
        missing,
        ..verdict::Report::of(Method::Unpaired, [side(&a), side(&b)], threshold, notes, rows)
    };
    args.gate.tell(report)
}

/// A result file of one device each.
pub fn runs(paths: &[PathBuf]) -> anyhow::Result<Vec<(PathBuf, Report)>> {
    let mut all = Vec::new();
    for path in paths {
        let mut reports = read(path)?;
        match (reports.pop(), reports.len()) {
            (Some(report), 0) => all.push((path.clone(), report)),
            (_, others) => anyhow::bail!(
                "{}: it holds {} devices; measure one at a time for a comparison",
                path.display(),
                others + 1
            ),
        }
    }
    Ok(all)
}

/// The side that runs make up, by their files' names.
pub fn side(runs: &[(PathBuf, Report)]) -> Side {
    let names: Vec<String> = runs.iter().map(|(path, _)| path.display().to_string()).collect();
    let mut side = Side::of(&names.join(", "), &runs[0].1);
    side.warnings = runs.iter().flat_map(|(_, report)| report.warnings.clone()).collect();
    side
}

/// The reports of runs.
pub fn of_runs(runs: &[(PathBuf, Report)]) -> Vec<&Report> {
    runs.iter().map(|(_, report)| report).collect()
}

/// What may differ between two sides' runs, with a note each; and the rows of A that B lacks.
pub fn notes(a: &[&Report], b: &[&Report]) -> (Vec<String>, Vec<MissingRow>) {
    let alone = |one: &[&Report], other: &[&Report]| {
        verdict::missing(one.iter().copied(), other.iter().copied())
    };
    let (of_a, of_b) = (alone(a, b), alone(b, a));
    let rows = [("A", &of_a), ("B", &of_b)].into_iter().filter(|(_, rows)| !rows.is_empty());
    let rows = rows.map(|(side, rows)| {
        let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        format!("only in {side}, so not compared: {}", names.join("; "))
    });
    (differences(a[0], b[0]).into_iter().chain(rows).collect(), of_a)
}

/// What is not the same of the devices, programs and machines of two runs.
fn differences(a: &Report, b: &Report) -> Vec<String> {
    let figures = [
        ("the device", a.device.name.clone(), b.device.name.clone()),
        (
            "the driver",
            format!("{} {}", a.device.driver, a.device.driver_info),
            format!("{} {}", b.device.driver, b.device.driver_info),
        ),
        ("the program's commit", a.build.commit.clone(), b.build.commit.clone()),
        ("the program's build", a.build.profile.clone(), b.build.profile.clone()),
        ("the number of cores", a.host.cores.to_string(), b.host.cores.to_string()),
    ];
    let processors = ("the processor", a.host.cpu.clone(), b.host.cpu.clone());
    let processors = Some(processors).filter(|_| !a.host.has_processor_of(&b.host));
    let differ = figures.into_iter().filter(|(_, a, b)| a != b).chain(processors);
    let differ =
        differ.map(|(what, a, b)| format!("{what} is {} in A, {} in B", a.trim(), b.trim()));
    differ.chain(variables(a, b)).collect()
}

/// Environment variables that are not the same on both sides.
fn variables(a: &Report, b: &Report) -> Vec<String> {
    let (a, b) = (&a.host.variables, &b.host.variables);
    let more = b.keys().filter(|name| !a.contains_key(*name));
    let names = a.keys().chain(more).filter(|name| a.get(*name) != b.get(*name));
    let value =
        |value: Option<&String>| value.map_or("not set".into(), |value| format!("'{value}'"));
    names
        .map(|name| format!("{name} is {} in A, {} in B", value(a.get(name)), value(b.get(name))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_settings_of_a_driver_are_told() {
        let of = |variables: serde_json::Value| -> Report {
            let text = serde_json::json!({"schema": "raindrops-bench/1", "rows": [],
                "device": {"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"},
                "build": {"version": "0.1.0", "commit": "c"},
                "host": {"cpu": "C", "cores": 2, "os": "O", "variables": variables}});
            serde_json::from_value(text).expect("a report")
        };
        let one = of(serde_json::json!({"LP_NUM_THREADS": "1", "LP_PERF": "x"}));
        let other = of(serde_json::json!({"LP_PERF": "x", "VK_DRIVER_FILES": "a.json"}));
        let told = [
            "LP_NUM_THREADS is '1' in A, not set in B",
            "VK_DRIVER_FILES is not set in A, 'a.json' in B",
        ];
        assert_eq!(differences(&one, &other), told);
        let mut moved = one.clone();
        moved.host.cpu = "another".into();
        assert_eq!(differences(&one, &moved), ["the processor is C in A, another in B"]);
        assert!(differences(&one, &one).is_empty());
    }
}
