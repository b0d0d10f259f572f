//! Plots as SVG within the page, in its colours.

use indexmap::IndexSet;
use maud::{Markup, PreEscaped, html};
use plotters::style::BLACK;

use super::TradeoffRow;
use crate::measure::bench::{self, Row};
use crate::measure::chart::PRESETS;
use crate::measure::verdict;
use crate::thousands::{thousands, thousands_of};

/// Width of every plot, in its own units.
const WIDTH: f64 = 900.0;
/// Left of a plot's area, where its labels stand.
const LEFT: f64 = 60.0;
/// Height of a bar with its gap.
const BAR: f64 = 22.0;
/// Names of passes beside each other.
const NAMES_A_LINE: usize = 7;
/// Room for names of rows.
const NAMES: f64 = 300.0;

fn color(number: usize) -> String {
    format!("var(--c{})", number % 9)
}

/// A preset's colour, as in the plots of `bench` and `tradeoff`; black there is the ink of the page.
fn of_preset(preset: &str) -> String {
    let number = PRESETS.iter().position(|(name, color)| *name == preset && *color != BLACK);
    number.map_or("var(--ink)".into(), color)
}

/// A logarithmic axis from data to plot units.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// One that holds all `values`, with some room; from 0.1 to 10 where there are none.
    fn of(values: impl Iterator<Item = f64> + Clone, from: f64, to: f64) -> Self {
        let values = values.filter(|value| value.is_finite() && *value > 0.0);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(0.0, f64::max);
        let (low, high) = if high > 0.0 { (low / 1.15, high * 1.15) } else { (0.1, 10.0) };
        Self { low, high, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.max(1e-12) / self.low).ln() / (self.high / self.low).ln();
        self.from + share.clamp(0.0, 1.0) * (self.to - self.from)
    }

    /// 1, 2 and 5 and their tenfolds.
    fn ticks(&self) -> Vec<f64> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all =
            decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|leading| leading * 10f64.powi(decade)));
        all.filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }
}

fn figure(value: f64) -> String {
    if value >= 1.0 {
        thousands(value.round() as u64)
    } else {
        format!("{}", (value * 1e6).round() / 1e6)
    }
}

fn grid(x: &Axis, y: &Axis, names: (&str, &str)) -> Markup {
    html! {
        @for tick in x.ticks() {
            line.axis x1=(x.at(tick)) x2=(x.at(tick)) y1=(y.from) y2=(y.to) {}
            text.soft x=(x.at(tick)) y=(y.from + 16.0) text-anchor="middle" { (figure(tick)) }
        }
        @for tick in y.ticks() {
            line.axis x1=(x.from) x2=(x.to) y1=(y.at(tick)) y2=(y.at(tick)) {}
            text.soft x=(x.from - 6.0) y=(y.at(tick) + 4.0) text-anchor="end" { (figure(tick)) }
        }
        text.soft x=(x.to) y=(y.from + 32.0) text-anchor="end" { (names.0) }
        text.soft x=(x.from) y=(y.to - 8.0) { (names.1) }
    }
}

/// Ends of a row's bar: the 95 % interval of the median over rounds, or of frames the 10th and 90th percentile.
fn bar(row: &Row) -> [f64; 2] {
    let interval = row.median_low_ms.zip(row.median_high_ms);
    interval.map_or([row.p10_ms, row.p90_ms], |(low, high)| [low, high])
}

/// Milliseconds by drops, a line a file and preset, with bars.
pub(super) fn series(reports: &[(&str, &bench::Report)]) -> Markup {
    let mut lines: Vec<(String, Vec<&Row>)> = Vec::new();
    for (file, report) in reports {
        for row in report.rows.iter().filter(|row| row.tone_map) {
            let name = match reports.len() {
                1 => row.preset.clone(),
                _ => format!("{}, {} ({file})", row.preset, report.device.summary()),
            };
            match lines.iter_mut().find(|(other, _)| *other == name) {
                Some((_, rows)) => rows.push(row),
                None => lines.push((name, vec![row])),
            }
        }
    }
    let all = || lines.iter().flat_map(|(_, rows)| rows.iter().copied());
    let x = Axis::of(all().map(Row::along), LEFT, WIDTH - 20.0);
    let y = Axis::of(all().flat_map(bar), 330.0, 30.0);
    let height = 375.0 + 18.0 * lines.len() as f64;
    let is_rate = all().all(|row| row.rate_mm_h.is_some());
    let along = if is_rate { "rain in mm/h" } else { "drops" };
    let what = match all().all(|row| row.median_low_ms.is_some()) {
        true => "ms a frame, tone mapped; bars: 95 % interval over processes",
        false => {
            "ms a frame, tone mapped; bars: 10th to 90th percentile of frames, over processes where there are six their 95 %"
        }
    };
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label=(format!("milliseconds a frame by {along}")) {
            (grid(&x, &y, (along, what)))
            @for (number, (name, rows)) in lines.iter().enumerate() {
                @let color = if reports.len() == 1 { of_preset(name) } else { color(number) };
                @let points: Vec<String> = rows.iter()
                    .map(|row| format!("{:.1},{:.1}", x.at(row.along()), y.at(row.median_ms))).collect();
                polyline points=(points.join(" ")) fill="none" stroke=(color) stroke-width="2" {}
                @for row in rows {
                    @let at = x.at(row.along());
                    @let [low, high] = bar(row);
                    line x1=(at) x2=(at) y1=(y.at(low)) y2=(y.at(high)) stroke=(color) {}
                    circle cx=(at) cy=(y.at(row.median_ms)) r="3.5" fill=(color) {
                        title { (row.name()) ": " (row.median_ms) " ms" }
                    }
                }
                @let line = 378.0 + 18.0 * number as f64;
                rect x=(LEFT) y=(line - 9.0) width="12" height="10" fill=(color) {}
                text x=(LEFT + 18.0) y=(line) { (name) }
            }
        }
    }
}

/// Each row's passes as one bar; with a `style`, as a picture of its own.
pub(super) fn passes(rows: &[Row], style: Option<&str>) -> Markup {
    let rows: Vec<&Row> = rows.iter().filter(|row| !row.passes.is_empty()).collect();
    let names: IndexSet<&String> = rows.iter().flat_map(|row| row.passes.keys()).collect();
    let names: Vec<&String> = names.into_iter().collect();
    let most =
        rows.iter().map(|row| row.passes.values().sum::<f64>()).fold(0.0, f64::max).max(1e-9);
    let scale = (WIDTH - NAMES - 100.0) / most;
    let below = 20.0 * names.len().div_ceil(NAMES_A_LINE) as f64 + 8.0;
    let height = BAR * rows.len() as f64 + below;
    html! {
        svg xmlns=[style.map(|_| "http://www.w3.org/2000/svg")] viewBox=(format!("0 0 {WIDTH} {height}")) role="img"
            aria-label="milliseconds of each pass" {
            @if let Some(style) = style {
                style { (PreEscaped(style)) }
                rect width="100%" height="100%" fill="var(--back)" {}
            }
            @for (number, name) in names.iter().enumerate() {
                @let at = 12.0 + 125.0 * (number % NAMES_A_LINE) as f64;
                @let line = 20.0 * (number / NAMES_A_LINE) as f64;
                rect x=(at) y=(line + 4.0) width="12" height="10" fill=(color(number)) {}
                text x=(at + 17.0) y=(line + 13.0) { (name) }
            }
            @for (line, row) in rows.iter().enumerate() {
                @let top = below + BAR * line as f64;
                text x=(NAMES - 8.0) y=(top + 12.0) text-anchor="end" { (row.name()) }
                @for (number, name) in names.iter().enumerate() {
                    @let before: f64 = names[..number].iter().filter_map(|name| row.passes.get(*name)).sum();
                    @if let Some(ms) = row.passes.get(*name) {
                        rect x=(NAMES + scale * before) y=(top) width=(scale * ms) height=(BAR - 6.0) fill=(color(number)) {
                            title { (name) ": " (ms) " ms" }
                        }
                    }
                }
                @let sum: f64 = row.passes.values().sum();
                text.soft x=(NAMES + scale * sum + 6.0) y=(top + 12.0) { (thousands_of(sum, 2)) " ms" }
            }
        }
    }
}

/// Each row's interval, beside the bounds of "same".
pub(super) fn forest(report: &verdict::Report) -> Markup {
    let bounds = [1.0 / (1.0 + report.threshold), 1.0 + report.threshold];
    let ends = || report.rows.iter().flat_map(|row| [row.ratio_low, row.ratio_high]).flatten();
    let x = Axis::of(ends().chain(bounds), NAMES, WIDTH - 40.0);
    let height = BAR * report.rows.len() as f64 + 34.0;
    let foot = height - 22.0;
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label="intervals of B over A" {
            rect x=(x.at(bounds[0])) y="0" width=(x.at(bounds[1]) - x.at(bounds[0])) height=(foot)
                fill="var(--line)" opacity="0.5" {}
            line.axis x1=(x.at(1.0)) x2=(x.at(1.0)) y1="0" y2=(foot) {}
            @for (line, row) in report.rows.iter().enumerate() {
                @let middle = BAR * line as f64 + 11.0;
                text x=(NAMES - 8.0) y=(middle + 4.0) text-anchor="end" { (row.name) }
                @if let (Some(low), Some(high), Some(ratio)) = (row.ratio_low, row.ratio_high, row.ratio) {
                    line x1=(x.at(low)) x2=(x.at(high)) y1=(middle) y2=(middle) stroke="var(--c0)" stroke-width="3" {}
                    circle cx=(x.at(ratio)) cy=(middle) r="4.5" fill="var(--c0)" {
                        title { (format!("{ratio:.3} ({low:.3} to {high:.3})")) }
                    }
                } @else {
                    text.soft x=(x.at(1.0) + 8.0) y=(middle + 4.0) { "too few rounds" }
                }
            }
            @for bound in [bounds[0], 1.0, bounds[1]] {
                // Where the intervals are wide, the labels would stand on one another.
                @if bound == 1.0 || (x.at(bound) - x.at(1.0)).abs() > 30.0 {
                    text.soft x=(x.at(bound)) y=(height - 6.0) text-anchor="middle" { (format!("{bound:.2}")) }
                }
            }
            text.soft x=(NAMES - 8.0) y=(height - 6.0) text-anchor="end" { "B / A of times, 95 %" }
        }
    }
}

/// Error by time, in the presets' colours; what nothing else beats in both is filled, and joined.
pub(super) fn scatter(rows: &[&TradeoffRow]) -> Markup {
    let x = Axis::of(rows.iter().map(|row| row.median_ms), LEFT, WIDTH - 20.0);
    let y = Axis::of(rows.iter().map(|row| row.rms), 330.0, 30.0);
    let mut front: Vec<&&TradeoffRow> = rows.iter().filter(|row| row.pareto).collect();
    front.sort_by(|a, b| a.median_ms.total_cmp(&b.median_ms));
    let points: Vec<String> = front
        .iter()
        .map(|row| format!("{:.1},{:.1}", x.at(row.median_ms), y.at(row.rms)))
        .collect();
    html! {
        svg viewBox=(format!("0 0 {WIDTH} 370")) role="img" aria-label="error by time" {
            (grid(&x, &y, ("ms a frame", "RMS error, 0 to 1")))
            polyline points=(points.join(" ")) fill="none" stroke="var(--soft)" {}
            @for row in rows {
                @let color = of_preset(&row.preset);
                @let fill = if row.pareto { color.as_str() } else { "var(--back)" };
                circle cx=(x.at(row.median_ms)) cy=(y.at(row.rms)) r="4" fill=(fill) stroke=(color) {
                    title { (row.model) ": " (format!("{} ms, {:.4}", thousands_of(row.median_ms, 2), row.rms)) }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use plotters::style::RGBColor;

    use super::*;
    use crate::cli::report::page::STYLE;

    #[test]
    fn the_page_has_the_presets_colours() {
        for (name, RGBColor(red, green, blue)) in PRESETS.into_iter().filter(|(_, c)| *c != BLACK) {
            let variable = of_preset(name).replace("var(", "").replace(')', "");
            let expected = format!("{variable}: #{red:02x}{green:02x}{blue:02x};");
            assert!(STYLE.contains(&expected), "{name}: no {expected}");
        }
        assert_eq!([of_preset("auto"), of_preset("another")], ["var(--ink)"; 2]);
    }
}
