//! A long measurement's plot within the page.

use maud::{Markup, html};

use crate::measure::bench::{OverTime, Stretch};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 60.0;
/// Height of a panel with its labels.
const PANEL: f64 = 150.0;

/// A figure of a stretch.
type Figure = fn(&Stretch) -> Option<f64>;

const PANELS: [(&str, Figure); 4] = [
    ("ms a frame, median", |stretch| Some(stretch.median_ms)),
    ("MiB of memory", |stretch| Some(stretch.resident_bytes? as f64 / f64::from(1 << 20))),
    ("MHz", |stretch| stretch.clock_mhz),
    ("load of the machine", |stretch| stretch.load),
];

/// Frame time, memory, clock and load over time, those that were measured; the steady part begins at the upright line.
pub(super) fn over_time(all: &OverTime) -> Markup {
    let is_told = |(_, figure): &&(&str, Figure)| all.stretches.iter().any(|s| figure(s).is_some());
    let panels: Vec<_> = PANELS.iter().filter(is_told).collect();
    let height = PANEL * panels.len() as f64 + 20.0;
    let end = all.stretches.last().map_or(1.0, |stretch| stretch.to_s).max(1e-9);
    let x = |seconds: f64| LEFT + (WIDTH - LEFT - 20.0) * seconds / end;
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label="frame time and memory over time" {
            @for (number, (name, figure)) in panels.iter().enumerate() {
                @let (top, foot) = (PANEL * number as f64 + 22.0, PANEL * number as f64 + 130.0);
                @let most = 1.1 * all.stretches.iter().filter_map(figure).fold(1e-9, f64::max);
                @let y = |value: f64| foot - (foot - top) * value / most;
                text.soft x=(LEFT) y=(top - 8.0) { (name) }
                @for tick in [0.0, most / 2.0, most] {
                    line.axis x1=(LEFT) x2=(WIDTH - 20.0) y1=(y(tick)) y2=(y(tick)) {}
                    text.soft x=(LEFT - 6.0) y=(y(tick) + 4.0) text-anchor="end" { (format!("{tick:.1}")) }
                }
                @if let Some(from) = all.steady_from_s {
                    line x1=(x(from)) x2=(x(from)) y1=(top) y2=(foot) stroke="var(--soft)" stroke-dasharray="4 3" {}
                }
                @let points: Vec<String> = all.stretches.iter()
                    .filter_map(|s| Some(format!("{:.1},{:.1}", x(s.to_s), y(figure(s)?)))).collect();
                polyline points=(points.join(" ")) fill="none" stroke=(format!("var(--c{number})")) stroke-width="2" {}
            }
            text.soft x=(WIDTH - 20.0) y=(height - 4.0) text-anchor="end" { (format!("0 to {end:.0} seconds")) }
        }
    }
}
