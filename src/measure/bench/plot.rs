//! Table II as a picture: frame rates by the number of drops, and the paper's three machines.

use plotters::prelude::*;

use super::report::{Report, Row};
use crate::Result;
use crate::measure::chart::{self, Area, Drawn, of_preset};
use crate::thousands::counted;

/// Size in the plot's units.
const SIZE: (u32, u32) = (820, 560);

/// Height of the line below the plot.
const FOOT: u32 = 34;

/// The paper's Table II: frames a second with tone mapping, by drops.
const PAPER: [(&str, [(u32, f64); 6]); 3] = [
    ("GeForce GTX 280", by_drops([595.0, 430.0, 250.0, 140.0, 74.0, 43.0])),
    ("GeForce 8600M GT", by_drops([99.0, 75.0, 50.0, 33.0, 21.0, 8.0])),
    ("GeForce 7300 GT", by_drops([55.0, 45.0, 29.0, 20.0, 10.0, 5.0])),
];

const fn by_drops(fps: [f64; 6]) -> [(u32, f64); 6] {
    let [a, b, c, d, e, f] = fps;
    [(125_000, a), (250_000, b), (500_000, c), (1_000_000, d), (2_000_000, e), (4_000_000, f)]
}

const BY_DROPS: &str = "Frames a second by number of drops, tone mapped";
const BY_RATE: &str = "Frames a second by rain rate, tone mapped";

/// The plot as SVG: frames a second with tone mapping.
///
/// # Errors
/// [`crate::Error::Plot`].
pub fn plot(report: &Report) -> Result<String> {
    chart::svg(SIZE, |root| draw(report, root))
}

fn draw(report: &Report, root: &Area<'_>) -> Drawn {
    let rows: Vec<&Row> = report.rows.iter().filter(|row| row.tone_map).collect();
    let mut presets: Vec<&str> = rows.iter().map(|row| row.preset.as_str()).collect();
    presets.sort_unstable();
    presets.dedup();
    let place = |row: &&Row| (row.along(), row.fps);
    // The paper has no real rain.
    let is_rate = rows.iter().any(|row| row.rate_mm_h.is_some());
    let papers: &[(&str, [(u32, f64); 6])] = if is_rate { &[] } else { &PAPER };
    let published = papers.iter().flat_map(|(_, points)| points.iter().copied());
    let all = published.map(|(drops, fps)| (f64::from(drops), fps)).chain(rows.iter().map(place));
    let all: Vec<(f64, f64)> = all.collect();
    let range = |value: fn(&(f64, f64)) -> f64| {
        let low = all.iter().map(value).fold(f64::INFINITY, f64::min);
        0.8 * low..1.2 * all.iter().map(value).fold(0.0, f64::max)
    };

    let (area, foot) = root.split_vertically(SIZE.1 - FOOT);
    let mut chart = ChartBuilder::on(&area)
        .caption(if is_rate { BY_RATE } else { BY_DROPS }, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    let along = if is_rate { "rain in mm/h" } else { "drops" };
    chart::logarithmic_axes(&mut chart, [along, "frames a second"], None)?;
    for (number, (name, points)) in papers.iter().enumerate() {
        let grey = RGBColor(110, 110, 110).mix(1.0 - 0.25 * number as f64);
        let points = points.map(|(drops, fps)| (f64::from(drops), fps));
        chart::curve(&mut chart, format!("{name}, 2011"), grey.into(), &points)?;
        chart::circles(&mut chart, 3, grey.stroke_width(1), &points)?;
    }
    for preset in presets {
        let color = of_preset(preset);
        let of_preset = rows.iter().filter(|row| row.preset == preset);
        let points: Vec<(f64, f64)> = of_preset.map(place).collect();
        chart::curve(&mut chart, preset, color.stroke_width(2), &points)?;
        chart::circles(&mut chart, 4, color.filled(), &points)?;
    }
    chart::legend(&mut chart, SeriesLabelPosition::UpperRight, 13)?;
    let (device, host) = (&report.device, &report.host);
    let (width, height) = rows.first().map_or((0, 0), |row| (row.width, row.height));
    let load = host.load.map_or(String::new(), |load| format!(", load {load}"));
    let line = format!(
        "{}, {} {}; {width} x {height}; {}{load}",
        device.name,
        device.driver,
        device.driver_info,
        counted(host.cores as u64, "core")
    );
    foot.draw(&Text::new(line, (16, 8), ("sans-serif", 13)))?;
    Ok(())
}
