//! Verdict rows as lines and columns.

use crate::cli::format::{Format, Sheet};
use crate::measure::verdict::{Method, MissingRow, Report, Verdict, VerdictRow};
use crate::thousands::{counted, thousands, thousands_of};

/// Who is A, who is B, and what differs between them.
pub fn side_lines(report: &Report, format: Format) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, side) in [("A", &report.a), ("B", &report.b)] {
        let (host, build) = (&side.host, &side.build);
        let start = side.start.as_ref().map_or(String::new(), |start| format!(", {start}"));
        lines.push(format!("{name}: {}", side.label));
        lines.push(format!(
            "   {}; raindrops {} {} {}; {} ({}){start}",
            side.device.summary(),
            build.version,
            build.commit,
            build.profile,
            host.cpu,
            counted(host.cores as u64, "core")
        ));
    }
    if format == Format::Markdown {
        // An item a side; the table begins after an empty line.
        let sides = lines.chunks(2).map(|side| format!("- {}  \n  {}", side[0], side[1].trim()));
        lines = sides.chain([String::new()]).collect();
    }
    lines
}

/// A row a row; with CSV plain numbers, and every row's passes in rows of their own.
pub fn sheet(report: &Report, format: Format) -> Sheet {
    if format == Format::Csv {
        return plain(report);
    }
    /// The column of A's times.
    const MS_A: usize = 4;
    let mut header = ["row", "verdict", "B / A", "95 %", "ms A", "ms B", "rounds", "noise"]
        .map(String::from)
        .to_vec();
    let has_flip = report.rows.iter().any(|row| row.flip_between.is_some());
    let has_errors = report.rows.iter().any(|row| row.error_a.is_some());
    let has_stages = report.rows.iter().any(|row| row.first_stage_that_differs.is_some());
    header.extend(has_flip.then(|| "FLIP".into()));
    header.extend(has_errors.then(|| "error A, B".into()));
    header.extend(has_stages.then(|| "paper: first differs".into()));
    let mut rows = Vec::new();
    for row in &report.rows {
        let decimals = decimals(row.ratio_low, row.ratio_high, row.threshold);
        let mut cells = vec![
            row.name.clone(),
            row.verdict.name().into(),
            row.ratio.map_or("-".into(), |ratio| format!("{ratio:.decimals$}")),
            range(row.ratio_low, row.ratio_high, row.threshold),
            thousands_of(row.median_ms_a, 2),
            thousands_of(row.median_ms_b, 2),
            row.rounds.to_string(),
            row.noise_floor.map_or("-".into(), |floor| format!("{:.1} %", 100.0 * floor)),
        ];
        if has_flip {
            cells.push(row.flip_between.map_or("-".into(), |flip| format!("{flip:.5}")));
        }
        if has_errors {
            let errors = row.error_a.zip(row.error_b);
            cells.push(errors.map_or("-".into(), |(a, b)| format!("{a:.4}, {b:.4}")));
        }
        if has_stages {
            cells.push(row.first_stage_that_differs.clone().unwrap_or("-".into()));
        }
        rows.push(cells);
    }
    for row in &report.missing {
        let mut cells = vec!["-".to_string(); header.len()];
        cells[..2].clone_from_slice(&[row.name.clone(), MissingRow::VERDICT.into()]);
        cells[MS_A] = thousands_of(row.median_ms_a, 2);
        rows.push(cells);
    }
    Sheet { names: 1, header, rows }
}

/// Decimals of a ratio that its interval lets stand, one digit more than the interval is wide; two at least, and three where
/// an end is so near to a bound that with two they might look alike.
fn decimals(low: Option<f64>, high: Option<f64>, threshold: f64) -> usize {
    let Some((low, high)) = low.zip(high) else { return 2 };
    let bounds = [1.0 + threshold, 1.0 / (1.0 + threshold)];
    let is_near = |end: f64| bounds.iter().any(|bound| (end - bound).abs() < 0.01);
    let least = if is_near(low) || is_near(high) { 3.0 } else { 2.0 };
    (1.0 - (high - low).max(1e-9).log10().ceil()).clamp(least, 4.0) as usize
}

fn range(low: Option<f64>, high: Option<f64>, threshold: f64) -> String {
    let places = decimals(low, high, threshold);
    low.zip(high).map_or("-".into(), |(low, high)| format!("{low:.places$} to {high:.places$}"))
}

/// What makes a comparison's times doubtful, and of which side: most of it two sides of one machine have in common.
pub fn warnings(report: &Report) -> Vec<String> {
    let [a, b] = [&report.a.warnings, &report.b.warnings];
    let of_a = a.iter().map(|warning| (if b.contains(warning) { "" } else { "A: " }, warning));
    let of_b = b.iter().filter(|warning| !a.contains(warning)).map(|warning| ("B: ", warning));
    of_a.chain(of_b).map(|(side, warning)| format!("{side}{warning}")).collect()
}

/// What stands under the table, as lines of text or as a list.
pub fn tail_lines(report: &Report, format: Format) -> Vec<String> {
    let warnings = warnings(report).into_iter().map(|warning| format!("warning: {warning}"));
    let mut lines = tail(report);
    // The summary is last.
    let end = lines.len() - 1;
    lines.splice(end..end, warnings);
    if format == Format::Markdown {
        // A list of its own, after the table.
        lines = lines.into_iter().map(|line| format!("- {}", line.trim())).collect();
        lines.insert(0, String::new());
    }
    lines
}

/// What the table has no room for, warnings apart: how to read it, passes that are faster or slower, counters that changed,
/// notes, and a summary.
pub fn tail(report: &Report) -> Vec<String> {
    let mut lines = vec![legend(report)];
    let bounds = report.bounds.iter();
    lines.extend(
        bounds.map(|bounds| format!("a row fails beyond the bounds of --expect: {bounds}")),
    );
    for row in &report.rows {
        lines.extend(row_lines(row).into_iter().map(|line| format!("   {}: {line}", row.name)));
    }
    lines.extend(report.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(report.stopped.iter().map(|why| format!("stopped: {why}")));
    if report.rows.iter().any(|row| row.ratio_low.is_none()) {
        lines.push(
            "a row without an interval has fewer than the six rounds that can decide; give --rounds 10, or more --max-time"
                .into(),
        );
    }
    lines.push(summary(report));
    lines
}

/// How many rows have which verdict; and how much slower those may be of which nothing is known.
fn summary(report: &Report) -> String {
    let counts = Verdict::ALL.map(|verdict| (report.count(verdict), verdict.name()));
    let counts = counts.into_iter().filter(|(count, _)| *count > 0);
    let counts: Vec<_> = counts.map(|(count, name)| format!("{count} {name}")).collect();
    let undecided = report.rows.iter().filter(|row| row.verdict == Verdict::Undecided);
    let most = undecided.filter_map(|row| row.ratio_high).reduce(f64::max);
    let most = most.filter(|most| *most > 1.0).map_or(String::new(), |most| {
        format!("; that an undecided one is up to {most:.2} times as slow is not excluded")
    });
    let passes = report.rows.iter().flat_map(|row| row.passes.values());
    let slower = match passes.filter(|pass| pass.verdict == Verdict::Slower).count() {
        0 => String::new(),
        1 => "; 1 pass is slower".into(),
        more => format!("; {more} passes are slower"),
    };
    let missing = match report.missing.len() {
        0 => String::new(),
        count => format!("; B lacks {} of A", counted(count as u64, "row")),
    };
    let rows = counted(report.rows.len() as u64, "row");
    format!("{rows}: {}{missing}{slower}{most}", counts.join(", "))
}

/// How to read the table.
fn legend(report: &Report) -> String {
    let how = match report.method {
        Method::Paired => {
            "fresh processes in turn; B / A is the median of the rounds' ratios, ms A and ms B are medians of their own"
        }
        Method::Unpaired => "kept results: each run counts once, as nothing ran in turn",
    };
    let pictures = report.max_flip.map_or(String::new(), |most| {
        let observer = report.flip_pixels_per_degree.unwrap_or_default();
        format!("; different if FLIP ({observer:.0} pixels a degree) is over {most}")
    });
    let over = 1.0 + report.threshold;
    format!(
        "B / A of times: slower if the whole interval is over {over:.3}, faster if under {:.3}, same if between; else \
         undecided; {how}{pictures}",
        1.0 / over
    )
}

/// Short times with more digits.
fn ms(time: f64) -> String {
    thousands_of(time, if time < 0.1 { 4 } else { 2 })
}

/// What is told of a row: its passes that are slower or faster, its counters that changed, its notes.
pub fn row_lines(row: &VerdictRow) -> Vec<String> {
    let passes = row
        .passes
        .iter()
        .filter(|(_, pass)| matches!(pass.verdict, Verdict::Slower | Verdict::Faster));
    let passes = passes.map(|(name, pass)| {
        format!(
            "pass {name}: {}, {} -> {} ms (B / A {})",
            pass.verdict.name(),
            ms(pass.median_ms_a),
            ms(pass.median_ms_b),
            range(pass.ratio_low, pass.ratio_high, row.threshold)
        )
    });
    let counters = row.counters.iter().map(|(name, (a, b))| {
        format!("counter {name}: {} in A, {} in B", thousands(*a), thousands(*b))
    });
    let all = passes.chain(counters).chain(row.notes.iter().cloned());
    all.collect()
}

/// Every figure, unrounded; `pass` is empty for the frame as a whole.
fn plain(report: &Report) -> Sheet {
    const HEADER: &str = "preset,drops,width,height,tone_map,pass,verdict,ratio,ratio_low,ratio_high,threshold,\
         median_ms_a,median_ms_b,rounds,noise_floor,flip_between,error_a,error_b,rate_mm_h";
    let header: Vec<String> = HEADER.split(',').map(String::from).collect();
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let mut rows = Vec::new();
    for row in &report.rows {
        let of = |pass: &str, verdict: Verdict, ratios: [Option<f64>; 3], ms: [f64; 2]| {
            let mut cells = vec![row.preset.clone(), row.drops.to_string(), row.width.to_string()];
            cells.extend([row.height.to_string(), row.tone_map.to_string(), pass.into()]);
            cells.push(verdict.name().into());
            cells.extend(ratios.map(number));
            cells.extend([row.threshold, ms[0], ms[1]].map(|value| value.to_string()));
            cells.push(row.rounds.to_string());
            let whole = [row.noise_floor, row.flip_between, row.error_a, row.error_b];
            cells.extend(whole.map(|value| number(value.filter(|_| pass.is_empty()))));
            cells.push(number(row.rate_mm_h));
            cells
        };
        let ratios = [row.ratio, row.ratio_low, row.ratio_high];
        rows.push(of("", row.verdict, ratios, [row.median_ms_a, row.median_ms_b]));
        for (name, pass) in &row.passes {
            let ratios = [pass.ratio, pass.ratio_low, pass.ratio_high];
            rows.push(of(name, pass.verdict, ratios, [pass.median_ms_a, pass.median_ms_b]));
        }
    }
    for row in &report.missing {
        let mut cells = vec![String::new(); header.len()];
        let size = [row.width, row.height].map(|pixels| pixels.to_string());
        let head = [row.preset.clone(), row.drops.to_string()].into_iter().chain(size);
        let head =
            head.chain([row.tone_map.to_string(), String::new(), MissingRow::VERDICT.into()]);
        head.zip(&mut cells).for_each(|(value, cell)| *cell = value);
        for (name, value) in [("median_ms_a", Some(row.median_ms_a)), ("rate_mm_h", row.rate_mm_h)]
        {
            let at = header.iter().position(|column| column == name);
            at.into_iter().for_each(|at| cells[at] = number(value));
        }
        rows.push(cells);
    }
    Sheet { names: 1, header, rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The legend stands directly under its table.
    #[test]
    fn the_table_is_explained_before_its_rows() {
        let side = serde_json::json!({"label": "l", "start": null, "warnings": [],
            "device": {"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"},
            "build": {"version": "0.1.0", "commit": "c"}, "host": {"cpu": "C", "cores": 2, "os": "O"}});
        let row = serde_json::json!({"name": "one", "preset": "fast", "drops": 1, "width": 1, "height": 1, "tone_map": true,
            "verdict": "same", "ratio": 1.0, "ratio_low": 1.0, "ratio_high": 1.0, "threshold": 0.05, "rounds": 10,
            "noise_floor": null, "median_ms_a": 1.0, "median_ms_b": 1.0, "rounds_ms_a": [], "rounds_ms_b": [],
            "flip_between": null, "error_a": null, "error_b": null, "first_stage_that_differs": null,
            "counters": {"bytes": [1, 2]}, "passes": {}, "notes": []});
        let report = serde_json::json!({"schema": "s", "a": side, "b": side, "method": "paired", "threshold": 0.05,
            "max_flip": 0.01, "flip_pixels_per_degree": 67.0, "stopped": null, "notes": ["a note"], "rows": [row]});
        let report: Report = serde_json::from_value(report).expect("a report");
        let lines = tail_lines(&report, Format::Table);
        assert!(lines[0].starts_with("B / A of times: slower if"), "{lines:?}");
        assert!(lines[1].contains("counter bytes") && lines[2].contains("a note"), "{lines:?}");
    }

    #[test]
    fn no_more_decimals_than_are_known() {
        assert_eq!(decimals(Some(0.38), Some(1.13), 0.05), 2);
        assert_eq!(decimals(Some(0.98), Some(1.03), 0.05), 2);
        assert_eq!(decimals(Some(0.998), Some(1.002), 0.05), 3);
        assert_eq!(decimals(None, None, 0.05), 2);
        // 0.951 is under the bound 1 / 1.05, and 0.95 does not say so.
        assert_eq!(range(Some(0.79), Some(0.951), 0.05), "0.790 to 0.951");
    }
}
