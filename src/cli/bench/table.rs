//! A benchmark as the paper's Table II.

use indexmap::IndexSet;

use crate::cli::format::{Format, Sheet};
use crate::measure::bench::{Parts, Report, Row};
use crate::thousands::{thousands, thousands_of};

/// The paper's Table II, GeForce GTX 280: drops, frames a second with and without tone mapping.
const GTX_280: [(u32, u32, u32); 6] = [
    (125_000, 595, 794),
    (250_000, 430, 540),
    (500_000, 250, 295),
    (1_000_000, 140, 157),
    (2_000_000, 74, 83),
    (4_000_000, 43, 46),
];

/// The rows as the paper's Table II has them: a line a count and preset, frame rates with (-T) and
/// without tone mapping, then milliseconds. Under it a table a preset with the milliseconds of each pass.
pub(super) fn table(rows: &[Row], is_papers: bool, format: Format) -> String {
    let presets: IndexSet<&str> = rows.iter().map(|row| row.preset.as_str()).collect();
    let of_passes = presets.into_iter().filter_map(|preset| passes(rows, preset));
    let sheets = std::iter::once(figures(rows, is_papers)).chain(of_passes);
    let texts: Vec<_> = sheets.map(|sheet| sheet.text(format)).collect();
    texts.join(if format == Format::Markdown { "\n\n" } else { "\n" })
}

fn figures(rows: &[Row], is_papers: bool) -> Sheet {
    let mut header: Vec<String> =
        ["preset", amount_name(rows), "in view", "FPS-T", "FPS", "ms-T"].map(String::from).to_vec();
    let has_rounds = rows.iter().any(|row| row.median_low_ms.is_some());
    header.extend(has_rounds.then(|| "95 %".into()));
    header.extend(["p10-p90", "ms"].map(String::from));
    header.extend(has_rounds.then(|| "95 %".into()));
    header.extend(is_papers.then(|| "GTX 280: FPS-T / FPS".into()));
    let mut lines = Vec::new();
    for row in rows.iter().filter(|row| row.tone_map) {
        let without = rows.iter().find(|other| {
            !other.tone_map
                && (other.drops, other.rate_mm_h) == (row.drops, row.rate_mm_h)
                && other.preset == row.preset
        });
        let mut line = vec![
            row.preset.clone(),
            row.amount(),
            thousands(row.visible),
            rate(row.fps),
            without.map_or("-".into(), |without| rate(without.fps)),
            thousands_of(row.median_ms, 2),
        ];
        line.extend(has_rounds.then(|| interval(row)));
        line.push(format!("{}-{}", thousands_of(row.p10_ms, 2), thousands_of(row.p90_ms, 2)));
        line.push(without.map_or("-".into(), |without| thousands_of(without.median_ms, 2)));
        line.extend(has_rounds.then(|| without.map_or("-".into(), interval)));
        let published =
            GTX_280.iter().find(|(drops, ..)| row.preset == "paper" && *drops == row.drops);
        let published = published.map(|(_, mapped, plain)| format!("{mapped} / {plain}"));
        line.extend(is_papers.then(|| published.unwrap_or("-".into())));
        lines.push(line);
    }
    // Preset and amount.
    Sheet { names: 2, header, rows: lines }
}

/// Milliseconds of the passes of a preset's frame with tone mapping; none where the device has no timestamps.
fn passes(rows: &[Row], preset: &str) -> Option<Sheet> {
    let of_preset: Vec<&Row> =
        rows.iter().filter(|row| row.tone_map && row.preset == preset).collect();
    let names = all_passes(of_preset.iter().map(|row| &row.passes));
    let mut header = vec![format!("{preset}: ms of"), amount_name(rows).to_string()];
    header.extend(names.iter().map(|name| (*name).to_string()));
    let line = |row: &&Row| {
        let ms = |name: &&str| row.passes.get(*name).map_or("-".into(), |ms| thousands_of(*ms, 2));
        let cells = [String::new(), row.amount()].into_iter();
        cells.chain(names.iter().map(ms)).collect()
    };
    let lines = of_preset.iter().map(line).collect();
    (!names.is_empty()).then_some(Sheet { names: 2, header, rows: lines })
}

fn amount_name(rows: &[Row]) -> &'static str {
    // A pass has the name `drops`, too.
    if rows.iter().all(|row| row.rate_mm_h.is_some()) { "rain" } else { "all drops" }
}

/// Every row with plain figures, as comma-separated values; the names first if asked.
pub(super) fn plain(report: &Report, with_names: bool) -> String {
    const NAMES: &str = "device,driver_info,preset,optics,primitive,drops,visible,width,height,tone_map,rounds,\
         median_ms,p10_ms,p90_ms,fps,rate_mm_h";
    let row = |row: &Row| {
        let device = &report.device;
        let mut cells =
            [&device.name, &device.driver_info, &row.preset, &row.optics, &row.primitive]
                .map(String::clone)
                .to_vec();
        cells.extend([u64::from(row.drops), row.visible].map(|number| number.to_string()));
        cells.extend([row.width, row.height].map(|number| number.to_string()));
        cells.extend([row.tone_map.to_string(), row.rounds.len().to_string()]);
        cells.extend([row.median_ms, row.p10_ms, row.p90_ms, row.fps].map(|ms| ms.to_string()));
        cells.push(row.rate_mm_h.map_or(String::new(), |rate| rate.to_string()));
        cells
    };
    let rows = report.rows.iter().map(row).collect();
    let header = NAMES.split(',').map(String::from).collect();
    let text = Sheet { names: 1, header, rows }.text(Format::Csv);
    match with_names {
        true => text,
        false => text.split_once('\n').map(|(_, rows)| rows.to_string()).unwrap_or_default(),
    }
}

/// Every pass that any row has, in the order of the frame: rows with few drops may lack some.
fn all_passes<'a>(rows: impl Iterator<Item = &'a Parts>) -> Vec<&'a str> {
    let mut all: Vec<&str> = Vec::new();
    for passes in rows {
        let mut next = 0;
        for name in passes.keys() {
            let known = all.iter().position(|known| known == name);
            let place = known.unwrap_or_else(|| {
                all.insert(next, name);
                next
            });
            next = place + 1;
        }
    }
    all
}

/// The 95 % interval of the median over rounds.
fn interval(row: &Row) -> String {
    let ends = row.median_low_ms.zip(row.median_high_ms);
    ends.map_or("-".into(), |(low, high)| {
        format!("{}-{}", thousands_of(low, 2), thousands_of(high, 2))
    })
}

fn rate(fps: f64) -> String {
    match fps {
        ..1.0 => format!("{fps:.3}"),
        ..100.0 => format!("{fps:.1}"),
        _ => thousands_of(fps, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_preset_has_a_table_of_its_passes() {
        let row = |preset: &str, passes: serde_json::Value| -> Row {
            let row = serde_json::json!({"preset": preset, "optics": "mask", "primitive": "point", "order": "unsorted",
                "drops": 125_000, "visible": 2, "width": 9, "height": 9, "tone_map": true, "samples_ms": [2.0], "median_ms": 2.0,
                "p10_ms": 1.0, "p90_ms": 3.0, "fps": 500.0, "passes": passes, "counters": {}, "rounds": []});
            serde_json::from_value(row).expect("a row")
        };
        let paper = row("paper", serde_json::json!({"sky": 0.25, "drops": 1.5}));
        let rows = [paper, row("fast", serde_json::json!({"composite": 1.75}))];
        let text = table(&rows, true, Format::Table);
        let lines: Vec<Vec<&str>> =
            text.lines().map(|line| line.split_whitespace().collect()).collect();
        let has = |cells: &[&str]| lines.iter().any(|line| line == cells);
        assert!(has(&["paper:", "ms", "of", "all", "drops", "sky", "drops"]), "{text}");
        assert!(has(&["125,000", "0.25", "1.50"]) && has(&["125,000", "1.75"]), "{text}");
        // What the paper published is beside its own method alone.
        let published = |preset: &str| {
            lines.iter().find(|line| line.first() == Some(&preset)).map(|line| line[line.len() - 1])
        };
        assert_eq!((published("paper"), published("fast")), (Some("794"), Some("-")));
    }

    #[test]
    fn every_pass_of_every_preset_has_a_column() {
        let passes = |names: &[&str]| names.iter().map(|name| (name.to_string(), 1.0)).collect();
        let paper: Parts = passes(&["simulate", "sky", "drops", "tone map"]);
        let fast: Parts = passes(&["clusters", "gather", "composite", "tone map"]);
        let all = all_passes([&paper, &fast, &paper].into_iter());
        let fasts = all.iter().copied().filter(|name| fast.contains_key(*name));
        assert!(fasts.eq(fast.keys()), "{all:?}");
        let papers = all.iter().copied().filter(|name| paper.contains_key(*name));
        assert!(papers.eq(paper.keys()), "{all:?}");
        assert_eq!(all.len(), 7);
    }
}
