//! A long measurement as a picture: frame times, memory, and the device's clock and the machine's load where
//! they were measured, over time.

use plotters::prelude::*;

use super::over_time::{OverTime, Stretch};
use super::report::{Report, Row};
use crate::Result;
use crate::measure::chart::{self, Area, Drawn};
use crate::thousands::counted;

const WIDTH: u32 = 820;
/// Heights of the head, of each panel, and of the foot.
const HEAD: u32 = 40;
const PANEL: u32 = 210;
const FOOT: u32 = 34;

const BLUE: RGBColor = RGBColor(0, 114, 178);
const ORANGE: RGBColor = RGBColor(213, 94, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const GREY: RGBColor = RGBColor(110, 110, 110);

/// A curve: what it is, its colour, its points.
type Curve = (&'static str, RGBColor, Vec<(f64, f64)>);

/// The plot as SVG, of the report's first row that was measured over time; none if there is none.
///
/// # Errors
/// [`crate::Error::Plot`].
pub fn long_plot(report: &Report) -> Result<Option<String>> {
    let mut long = report.rows.iter().filter_map(|row| Some((row, row.over_time.as_ref()?)));
    let Some((row, over_time)) = long.next() else { return Ok(None) };
    draw(report, row, over_time).map(Some)
}

/// A time in the unit that the whole is read in.
fn unit(seconds: f64) -> (f64, &'static str) {
    match seconds {
        s if s >= 2.0 * 3600.0 => (3600.0, "hours"),
        s if s >= 120.0 => (60.0, "minutes"),
        _ => (1.0, "seconds"),
    }
}

/// What is known of each stretch, over time.
fn points(over_time: &OverTime, value: impl Fn(&Stretch) -> Option<f64>) -> Vec<(f64, f64)> {
    let (scale, _) = unit(over_time.duration_s);
    let point = |stretch: &Stretch| Some((stretch.to_s / scale, value(stretch)?));
    over_time.stretches.iter().filter_map(point).collect()
}

fn draw(report: &Report, row: &Row, over_time: &OverTime) -> Result<String> {
    const MIB: f64 = 1024.0 * 1024.0;
    let of = |value: fn(&Stretch) -> Option<f64>| points(over_time, value);
    let mut panels: Vec<(&str, Vec<Curve>)> = vec![
        ("ms a frame", vec![("median", BLUE, of(|stretch| Some(stretch.median_ms)))]),
        (
            "MiB",
            vec![
                ("memory of the process", ORANGE, of(|s| Some(s.resident_bytes? as f64 / MIB))),
                ("of the device", GREEN, of(|s| Some(s.device_bytes as f64 / MIB))),
            ],
        ),
    ];
    let clock = of(|stretch| stretch.clock_mhz);
    if !clock.is_empty() {
        panels.push(("clock, MHz", vec![("clock", BLUE, clock)]));
    }
    let load = of(|stretch| stretch.load);
    if !load.is_empty() {
        panels.push(("load", vec![("load of the machine", GREY, load)]));
    }
    let height = HEAD + PANEL * panels.len() as u32 + FOOT;
    let clock = if over_time.stretches.iter().any(|stretch| stretch.clock_mhz.is_some()) {
        ""
    } else {
        "; clock unknown"
    };
    let line = format!(
        "{}; {}, {}{clock}",
        report.device.summary(),
        report.host.cpu,
        counted(report.host.cores as u64, "core")
    );
    chart::svg((WIDTH, height), |root| {
        let (head, rest) = root.split_vertically(HEAD);
        let (area, foot) = rest.split_vertically(height - HEAD - FOOT);
        head.draw(&Text::new(format!("{} over time", row.name()), (16, 12), ("sans-serif", 18)))?;
        for (place, (name, curves)) in area.split_evenly((panels.len(), 1)).iter().zip(&panels) {
            panel(place, name, curves, over_time)?;
        }
        foot.draw(&Text::new(line, (16, 8), ("sans-serif", 13)))?;
        Ok(())
    })
}

fn panel(area: &Area<'_>, name: &str, curves: &[Curve], over_time: &OverTime) -> Drawn {
    let (scale, unit) = unit(over_time.duration_s);
    let is_time = name == "ms a frame";
    let values = curves.iter().flat_map(|(.., points)| points.iter().map(|point| point.1));
    let spread = |stretch: &Stretch| [stretch.p10_ms, stretch.p90_ms];
    let spreads = over_time.stretches.iter().filter(|_| is_time).flat_map(spread);
    let most = values.chain(spreads).fold(0.0, f64::max).max(1e-9);
    // Room for the legend over the frame times.
    let top = if is_time { 1.6 * most } else { 1.15 * most };
    let end = over_time.stretches.last().map_or(1.0, |stretch| stretch.to_s / scale).max(1e-9);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(24)
        .x_label_area_size(34)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..end, 0.0..top)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc(unit)
        .y_desc(name)
        .y_labels(5)
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .draw()?;
    if is_time {
        // From the 10th percentile there, and back by the 90th.
        let at = |value: fn(&Stretch) -> f64| points(over_time, |stretch| Some(value(stretch)));
        let mut outline = at(|stretch| stretch.p10_ms);
        outline.extend(at(|stretch| stretch.p90_ms).into_iter().rev());
        chart
            .draw_series([Polygon::new(outline, BLUE.mix(0.2))])?
            .label("10th to 90th percentile")
            .legend(|(x, y)| Rectangle::new([(x, y - 5), (x + 16, y + 5)], BLUE.mix(0.2).filled()));
    }
    for (name, color, points) in curves {
        chart::curve(&mut chart, *name, color.stroke_width(2), points)?;
    }
    if let Some(from) = over_time.steady_from_s.filter(|_| is_time) {
        let line = [(from / scale, 0.0), (from / scale, top)];
        chart
            .draw_series([PathElement::new(line, GREY)])?
            .label("steady from here on")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], GREY));
    }
    if !is_time && curves.len() == 1 {
        return Ok(());
    }
    let (above, beside) = (SeriesLabelPosition::UpperRight, SeriesLabelPosition::MiddleRight);
    chart::legend(&mut chart, if is_time { above } else { beside }, 13)
}
