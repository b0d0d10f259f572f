//! Devices, their stages and verdicts as lines and columns.

use crate::cli::format::{Format, Sheet};
use crate::cli::print;
use crate::cli::verdict::gate::GateArgs;
use crate::cli::verdict::table::{sheet, tail_lines};
use crate::measure::drivers::{Apart, Compared, DeviceRow, FEW, Report};
use crate::thousands::thousands;

/// Prints everything in the form that was asked for.
pub fn show(report: &Report, gate: &GateArgs) -> crate::Result<()> {
    let format = gate.format;
    match format {
        _ if gate.is_json() => {}
        Format::Csv if !report.verdicts.is_empty() => print(plain(&report.verdicts).text(format))?,
        _ => {
            print(devices(&report.devices, format).text(format))?;
            // In Markdown an empty line ends a table, and indented lines would be one.
            let (gap, item) =
                if format == Format::Markdown { ("\n", "\n- ") } else { ("", "\n   ") };
            for pair in &report.pairs {
                let lines = stage_lines(&pair.stages).join(item);
                print(format_args!("{gap}{} and {}: {lines}", pair.a, pair.b))?;
            }
            for Compared { a, b, verdict } in &report.verdicts {
                print(format_args!(
                    "{gap}A is {a}, B is {b}: times of fresh processes in turn{gap}"
                ))?;
                print(sheet(verdict, format).text(format))?;
                tail_lines(verdict, format).into_iter().try_for_each(print)?;
            }
        }
    }
    Ok(())
}

/// A row a device.
pub fn devices(rows: &[DeviceRow], format: Format) -> Sheet {
    let has_truth = rows.iter().any(|row| row.flip_to_truth.is_some());
    let mut header = ["device", "ms", "in view"].map(String::from).to_vec();
    header.extend((0..rows.len()).map(|number| format!("FLIP to {number}")));
    header.extend(has_truth.then(|| "FLIP to truth".to_string()));
    let cells = |(number, row): (usize, &DeviceRow)| {
        let mut cells = vec![
            format!("{number}: {}", row.device.summary()),
            row.median_ms.map_or("-".into(), |ms| format!("{ms:.1}")),
            match format {
                Format::Csv => row.visible.to_string(),
                _ => thousands(row.visible),
            },
        ];
        cells.extend(row.flip.iter().chain(&row.flip_to_truth).map(|flip| format!("{flip:.5}")));
        cells
    };
    Sheet { names: 1, header, rows: rows.iter().enumerate().map(cells).collect() }
}

/// Every row of every verdict, after its two devices' names.
fn plain(verdicts: &[Compared]) -> Sheet {
    let mut all = Sheet { names: 1, header: Vec::new(), rows: Vec::new() };
    for Compared { verdict, .. } in verdicts {
        let Sheet { header, rows, .. } = sheet(verdict, Format::Csv);
        let names = || [&verdict.a.label, &verdict.b.label].map(String::clone).into_iter();
        all.header = ["a", "b"].map(String::from).into_iter().chain(header).collect();
        all.rows.extend(rows.into_iter().map(|row| names().chain(row).collect::<Vec<_>>()));
    }
    all
}

/// The first of the stages that differs, then a line a stage.
pub fn stage_lines(apart: &[Apart]) -> Vec<String> {
    let stage = |apart: &Apart| {
        let Apart { stage, unit, tolerance, share, alone, largest } = apart;
        let off = 100.0 * (share - alone);
        let mut line = format!("{stage:<10}");
        if *share == 0.0 {
            line += &format!(" none off by over {tolerance} {unit}");
        } else {
            line += &format!(" {off:.4} % off by over {tolerance} {unit}");
        }
        if *alone > 0.0 {
            line += &format!(", {:.4} % drawn by one alone", 100.0 * alone);
        }
        // The number has enough digits that a difference is never shown as zero.
        if *largest > 0.0 {
            line += &format!(", largest {largest:.1e}");
        }
        line
    };
    let few = 100.0 * FEW;
    let first = match apart.iter().find(|apart| apart.differs()) {
        Some(first) => format!("the first stage to differ is the {}", first.stage),
        None if apart.iter().any(Apart::strays) => {
            format!("no stage differs by more than rounding in over {few} % of its pixels")
        }
        None => "no stage differs by more than rounding".into(),
    };
    std::iter::once(first).chain(apart.iter().map(stage)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said agrees with the figures beside it.
    #[test]
    fn stages_do_not_contradict_themselves() {
        let of = |share: f64, alone: f64, largest: f64| {
            let (stage, unit) = ("footprint".into(), "px".into());
            let apart = Apart { stage, unit, tolerance: 0.01, share, alone, largest };
            stage_lines(&[apart]).join("\n")
        };
        assert!(of(0.0, 0.0, 0.0).contains("none off") && !of(0.0, 0.0, 0.0).contains("largest"));
        assert!(of(0.0, 0.0, 0.003).starts_with("no stage differs by more than rounding\n"));
        assert!(of(0.0005, 0.0, 0.4675).contains("in over 0.1 % of its pixels"));
        let alone = of(0.0005, 0.0005, 0.0);
        assert!(
            alone.contains("0.0500 % drawn by one alone") && !alone.contains("largest"),
            "{alone}"
        );
        assert!(of(0.5, 0.0, 2e-5).contains("largest 2.0e-5"));
    }
}
