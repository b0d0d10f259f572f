//! A comparison that was kept, judged again by other bounds: nothing is measured.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::gate::GateArgs;
use crate::Error;
use crate::cli::compare_devices::{are_alike, table};
use crate::cli::rounds::pictures::as_seen_from;
use crate::cli::{Answer, command_line};
use crate::measure::bench::{self, of_schema, read_json};
use crate::measure::drivers;
use crate::measure::verdict::{self, Report};

/// Judges what a file's comparison measured. Threshold and `max_flip` stay as they were unless they are given; what fails
/// is by the options of `gate` alone.
pub fn judge(files: &[PathBuf], max_flip: Option<f64>, gate: &GateArgs) -> anyhow::Result<Answer> {
    let [path] = files else {
        anyhow::bail!("a comparison is one file; to compare results name those of B, too");
    };
    let value = read_json(path)?;
    let schema = value.get("schema").and_then(Value::as_str).unwrap_or_default();
    match schema {
        verdict::SCHEMA => {
            let mut report: Report = of_schema(path, value, verdict::SCHEMA)?;
            let has_pictures = report.rows.iter().any(|row| row.flip_between.is_some());
            if max_flip.is_some() && !has_pictures {
                return Err(Error::read(path, "--max-flip: no pictures were compared").into());
            }
            renew(&mut report, path, max_flip, gate)?;
            gate.tell(report)
        }
        drivers::SCHEMA => {
            let mut file: drivers::Report = of_schema(path, value, drivers::SCHEMA)?;
            let (known, all) = (file.verdicts.len(), file.devices.len().saturating_sub(1));
            if known < all {
                let what = format!("{known} of {all} devices have a verdict; compare them again");
                return Err(Error::read(path, what).into());
            }
            for of in &mut file.verdicts {
                renew(&mut of.verdict, path, max_flip, gate)?;
                gate.settle(&mut of.verdict)?;
            }
            table::show(&file, gate)?;
            gate.write_json(&file)?;
            let verdicts: Vec<_> = file.verdicts.iter().map(|of| &of.verdict).collect();
            let answer = gate.judge(&verdicts, max_flip.is_some())?;
            Ok(if are_alike(&file, max_flip) { answer } else { Answer::No })
        }
        _ if schema == bench::SCHEMA || value.is_array() => {
            let what = "it is one side of a comparison: name the result to compare it with, too";
            Err(Error::read(path, what).into())
        }
        _ => {
            let what = format!("its schema is '{schema}'; a comparison is needed here");
            Err(Error::read(path, what).into())
        }
    }
}

/// A report by the bounds of `gate`, as it will stand in another file.
fn renew(
    report: &mut Report,
    path: &Path,
    max_flip: Option<f64>,
    gate: &GateArgs,
) -> anyhow::Result<()> {
    report.judge_again(gate.threshold_or(report.threshold), max_flip.or(report.max_flip));
    const AGAIN: &str = "judged again by ";
    report.notes.retain(|note| !note.starts_with(AGAIN));
    report.notes.push(format!("{AGAIN}{}", command_line()));
    let folder = path.parent().unwrap_or(Path::new(""));
    for pictures in report.rows.iter_mut().filter_map(|row| row.pictures.as_mut()) {
        for file in [&mut pictures.a, &mut pictures.b, &mut pictures.difference] {
            // Pictures that are not there any more stay named as they were.
            if let Ok(moved) = as_seen_from(gate.json.as_deref(), &folder.join(&file)) {
                *file = moved;
            }
        }
    }
    Ok(())
}
