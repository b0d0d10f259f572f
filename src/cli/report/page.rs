//! The page: a section a result, one style for light and dark.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use indexmap::IndexSet;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::over_time::over_time;
use super::plots::{forest, passes, scatter, series};
use super::{Content, Entry, Tradeoff};
use crate::cli::compare_devices::table::{devices, stage_lines};
use crate::cli::format::Format;
use crate::cli::verdict::table::{self, sheet};
use crate::measure::Host;
use crate::measure::bench::{self, Build, DeviceHead};
use crate::measure::drivers;
use crate::measure::verdict::{self, MissingRow, Pictures};
use crate::thousands::{counted, thousands};

/// Colours of series are Okabe and Ito's (2008), told apart by everyone; in the dark their light variants.
pub(super) const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #5c6570; --line: #d5dae0; --back: #fff;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #cc79a7; --c4: #b58900; --c5: #56b4e9; --c6: #777; --c7: #882255; --c8: #44aa99;
  --good: #00754f; --bad: #b3341a; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e8ec; --soft: #9aa4af; --line: #363d45;
  --back: #15181c; --c0: #4aa8e0; --c1: #f08a3c; --c2: #35c79b; --c3: #e29fc6; --c4: #e0bd4d; --c6: #aaa; --c7: #d06a9a; --c8: #7fd6c8;
  --good: #43c796; --bad: #ff8a6b; } }
body { margin: 0 auto; max-width: 72rem; padding: 1.5rem; background: var(--back); color: var(--ink);
  font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.6rem; margin: 0 0 1rem; } h2 { font-size: 1.2rem; margin: 2.5rem 0 .25rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .25rem; }
p.who { color: var(--soft); margin: 0 0 1rem; font-size: .9rem; }
.wide { overflow-x: auto; background: /* a shade at the side to which more can be scrolled */
  linear-gradient(to right, var(--back) 1rem, transparent) left / 3rem 100% no-repeat local,
  linear-gradient(to left, var(--back) 1rem, transparent) right / 3rem 100% no-repeat local,
  linear-gradient(to right, var(--line), transparent) left / 1rem 100% no-repeat scroll,
  linear-gradient(to left, var(--line), transparent) right / 1rem 100% no-repeat scroll; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .5rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th.side { white-space: normal; min-width: 8rem; max-width: 16rem; font-size: .85rem; }
th:first-child, td:first-child { text-align: left; padding-left: 0; } th { font-weight: 600; }
.slower, .different, .missing { color: var(--bad); font-weight: 600; } .faster { color: var(--good); font-weight: 600; }
.undecided { color: var(--soft); } p.warning, li.warning { color: var(--bad); }
code { overflow-wrap: anywhere; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: 1rem; }
figure { margin: 0; } figure img { width: 100%; display: block; } figcaption { color: var(--soft); font-size: .9rem; }
.errors { display: flex; justify-content: space-between; margin: .5rem 0 1.5rem; padding: .1rem .4rem; font-size: .9rem; border: 1px solid var(--line);
  background: linear-gradient(to right, #000, #6119a0, #e04661, #ffd359, #fff); color: #fff; }
.errors span:nth-child(n+4) { color: #000; }
svg { min-width: 40rem; max-width: 100%; height: auto; display: block; margin: .5rem 0; } svg text { fill: var(--ink); font: 12px system-ui, sans-serif; }
svg .soft { fill: var(--soft); } svg .axis { stroke: var(--line); }
";

/// The style of a plot that is a file of its own.
pub(super) const ALONE: &str =
    "text { fill: var(--ink); font: 12px sans-serif; } .soft { fill: var(--soft); }";

/// A plot with the colours of daylight in place of their names, which not every viewer of SVG knows.
pub(super) fn without_variables(mut svg: String) -> String {
    let daylight = STYLE.split('}').next().unwrap_or_default();
    for (name, color) in daylight.split(';').filter_map(|one| one.split_once(": ")) {
        svg = svg.replace(&format!("var({})", name.trim()), color);
    }
    svg
}

/// All results on one page.
pub(super) fn page(entries: &[Entry]) -> Markup {
    let benches: Vec<(&str, &bench::Report)> = entries
        .iter()
        .filter_map(|entry| match &entry.content {
            Content::Bench(report) => Some((entry.file.as_str(), report)),
            _ => None,
        })
        .collect();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "raindrops: results" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "raindrops: results" }
                @if benches.len() > 1 {
                    h2 { "Devices side by side" }
                    div.wide { (series(&benches)) }
                    (side_by_side(&benches))
                }
                @for entry in entries {
                    @match &entry.content {
                        Content::Bench(report) => (of_bench(&entry.file, report, benches.len() == 1)),
                        Content::Verdict(report) => (of_verdict(&entry.file, &entry.folder, report)),
                        Content::Drivers(report) => (of_drivers(&entry.file, &entry.folder, report)),
                        Content::Tradeoff(report) => (of_tradeoff(&entry.file, report)),
                    }
                }
            }
        }
    }
}

fn who(device: &DeviceHead, host: &Host, build: &Build, start: Option<&str>) -> Markup {
    let load = host.load.map_or(String::new(), |load| format!(", load {load} as it began"));
    html! {
        p.who {
            (device.summary()) ", Vulkan " (device.api_version) " (" (device.kind) "). "
            (host.cpu) ", " (counted(host.cores as u64, "core")) (load) (host.settings()) ", " (host.os) ". raindrops " (build.version) " "
            (build.commit) " " (build.profile)
            @if let Some(start) = start { ", " (start) }
            "."
        }
    }
}

fn command(line: Option<&str>) -> Markup {
    html! { @if let Some(line) = line { p.who { code { (line) } } } }
}

/// A row a row that any of the files has, a column a file.
fn side_by_side(benches: &[(&str, &bench::Report)]) -> Markup {
    let rows = benches.iter().flat_map(|(_, report)| &report.rows);
    let names: IndexSet<String> = rows.map(bench::Row::name).collect();
    html! {
        div.wide { table {
            tr {
                th { "ms a frame" }
                @for (file, report) in benches { th.side { (file) br; (report.device.summary()) } }
            }
            @for name in &names {
                tr {
                    td { (name) }
                    @for (_, report) in benches {
                        @let row = report.rows.iter().find(|row| row.name() == *name);
                        td { (row.map_or("–".into(), |row| format!("{:.2}", row.median_ms))) }
                    }
                }
            }
        } }
    }
}

/// A picture within the page; where its file cannot be read, that.
fn picture(folder: &Path, file: &Path, caption: &str) -> Markup {
    let path = folder.join(file);
    html! {
        figure {
            @match std::fs::read(&path) {
                Ok(bytes) => img alt=(caption) src=(format!("data:image/png;base64,{}", STANDARD.encode(bytes))) {},
                Err(error) => p.different { (path.display()) ": " (error) },
            }
            figcaption { (caption) }
        }
    }
}

/// Pictures of each preset and amount, once.
fn pictures(folder: &Path, report: &verdict::Report) -> Markup {
    let mut all: Vec<(&verdict::VerdictRow, &Pictures)> = Vec::new();
    for row in &report.rows {
        if let Some(pictures) = &row.pictures
            && !all.iter().any(|(_, known)| *known == pictures)
        {
            all.push((row, pictures));
        }
    }
    html! {
        @if !all.is_empty() { h3 { "Pictures" } }
        @for (row, pictures) in all {
            div.pictures {
                (picture(folder, &pictures.a, &format!("A: {}", row.name)))
                (picture(folder, &pictures.b, "B"))
                (picture(folder, &pictures.difference, &difference_caption(row, pictures)))
            }
            div.errors { span { "FLIP 0" } span { "1/16" } span { "1/4" } span { "9/16" } span { "1" } }
        }
    }
}

/// How far apart two pictures are, and where most.
fn difference_caption(row: &verdict::VerdictRow, pictures: &Pictures) -> String {
    let mean = format!("difference: FLIP {:.5} in the mean", row.flip_between.unwrap_or_default());
    match pictures.largest_flip.zip(pictures.largest_flip_at) {
        None => mean,
        Some((0.0, _)) => "difference: none".into(),
        Some((largest, (x, y))) => {
            format!("{mean}, {largest:.3} at most (column {x}, row {y} from the upper left)")
        }
    }
}

fn warnings(all: &[String]) -> Markup {
    html! { @if !all.is_empty() { ul { @for warning in all { li.warning { (warning) } } } } }
}

fn of_bench(file: &str, report: &bench::Report, with_plot: bool) -> Markup {
    html! {
        h2 { "Frame times: " (file) }
        (who(&report.device, &report.host, &report.build, report.start.as_deref()))
        (command(report.command.as_deref()))
        (warnings(&report.warnings))
        @if with_plot { div.wide { (series(&[(file, report)])) } }
        div.wide { table {
            tr {
                th { "row" } th { "in view" } th { "ms" } th { "95 %" } th { "p10 to p90" } th { "frames a second" } th { "processes" }
            }
            @for row in &report.rows {
                tr {
                    td { (row.name()) }
                    td { (thousands(row.visible)) }
                    td { (format!("{:.2}", row.median_ms)) }
                    td { (row.median_low_ms.zip(row.median_high_ms).map_or("–".into(), |(low, high)| format!("{low:.2} to {high:.2}"))) }
                    td { (format!("{:.2} to {:.2}", row.p10_ms, row.p90_ms)) }
                    td { (format!("{:.1}", row.fps)) }
                    td { (row.rounds.len().max(1)) }
                }
            }
        } }
        h3 { "Passes" }
        div.wide { (passes(&report.rows, None)) }
        @for row in &report.rows {
            @if let Some(all) = &row.over_time {
                h3 { "Over time: " (row.name()) }
                p.who { "Clock: " (all.clock) "." }
                div.wide { (over_time(all)) }
            }
        }
    }
}

/// The table of devices, what is known of the stages of any two, and a verdict for each but the first.
fn of_drivers(file: &str, folder: &Path, report: &drivers::Report) -> Markup {
    let table = devices(&report.devices, Format::Table);
    html! {
        h2 { "Devices: " (file) }
        div.wide { table {
            tr { @for name in &table.header { th { (name) } } }
            @for cells in &table.rows { tr { @for cell in cells { td { (cell) } } } }
        } }
        @for pair in &report.pairs {
            @let lines = stage_lines(&pair.stages);
            h3 { (pair.a) " and " (pair.b) ", drawn by preset paper: " (lines[0]) }
            ul { @for line in &lines[1..] { li { (line) } } }
        }
        @for of in &report.verdicts { (of_verdict(file, folder, &of.verdict)) }
    }
}

fn of_verdict(file: &str, folder: &Path, report: &verdict::Report) -> Markup {
    let table = sheet(report, Format::Table);
    html! {
        h2 { "Verdict: " (file) }
        (command(report.command.as_deref()))
        p.who { "A: " (report.a.label) }
        (who(&report.a.device, &report.a.host, &report.a.build, report.a.start.as_deref()))
        p.who { "B: " (report.b.label) }
        (who(&report.b.device, &report.b.host, &report.b.build, report.b.start.as_deref()))
        div.wide { (forest(report)) }
        div.wide { table {
            tr { @for name in &table.header { th { (name) } } }
            // Rows that B lacks follow those that both have.
            @let verdicts = report.rows.iter().map(|row| row.verdict.name());
            @for (name, cells) in verdicts.chain(report.missing.iter().map(|_| MissingRow::VERDICT)).zip(&table.rows) {
                tr { @for cell in cells {
                    @let verdict = (cell == name).then_some(cell);
                    td class=[verdict] { (cell) }
                } }
            }
        } }
        (warnings(&table::warnings(report)))
        ul { @for line in table::tail(report) { li { (line.trim()) } } }
        (pictures(folder, report))
    }
}

fn of_tradeoff(file: &str, report: &Tradeoff) -> Markup {
    let mut scenes: Vec<&str> = report.rows.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    html! {
        h2 { "Time and error: " (file) }
        (who(&report.device, &report.host, &report.build, None))
        (command(report.command.as_deref()))
        @if let Some(why) = &report.stopped { p.warning { "stopped: " (why) } }
        @for scene in scenes {
            @let rows: Vec<_> = report.rows.iter().filter(|row| row.scene == scene).collect();
            h3 { (scene) }
            div.wide { (scatter(&rows)) }
            div.wide { table {
                tr { th { "on the front" } th { "ms" } th { "RMS error" } th { "FLIP" } }
                @for row in rows.iter().filter(|row| row.pareto) {
                    tr {
                        td { (row.model) }
                        td { (format!("{:.2}", row.median_ms)) }
                        td { (format!("{:.4}", row.rms)) }
                        td { (format!("{:.4}", row.flip)) }
                    }
                }
            } }
        }
    }
}
