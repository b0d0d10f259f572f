//! Errors by a drop's size as a picture: how the light is found, and what light is left out, a panel each.

use plotters::prelude::*;

use super::sizes::SizeRow;
use crate::Result;
use crate::measure::chart::{self, Area, Drawn, of_preset};

/// Size of both panels in the plot's units, and the width of each.
const SIZE: (u32, u32) = (1120, 480);
const PANEL: u32 = 560;

/// Curves of the left panel: the row's name, what the plot calls it, its colour. What is a preset's way has the preset's.
fn ways() -> [(&'static str, &'static str, RGBColor); 8] {
    let (light, grey) = (RGBColor(86, 180, 233), RGBColor(110, 110, 110));
    [
        ("far: one colour", "one colour", grey),
        ("mask, finest look-up", "mask, finest look-up", light),
        ("mask", "mask (paper)", of_preset("paper")),
        ("appearance (fast)", "appearance (fast)", of_preset("fast")),
        ("closed form, 1 ray", "1 ray", RGBColor(181, 137, 0)),
        ("closed form, 4 rays", "4 rays", RGBColor(68, 170, 153)),
        ("closed form, 16 rays", "16 rays (exact)", of_preset("exact")),
        ("closed form, 64 rays", "64 rays", RGBColor(136, 34, 85)),
    ]
}

/// Curves of the right panel.
fn left_out() -> [(&'static str, &'static str, RGBColor); 4] {
    [
        ("no reflection, converged", "the reflection", RGBColor(136, 34, 85)),
        ("no internal reflection, converged", "all internal reflections", RGBColor(181, 137, 0)),
        ("paper's weights, converged", "the same, paper's weights", of_preset("paper")),
        ("one internal reflection, converged", "all internal ones but one", RGBColor(68, 170, 153)),
    ]
}

/// The plot as SVG: RMS error over the radius, both axes logarithmic and the same in both panels.
///
/// # Errors
/// [`crate::Error::Plot`].
pub fn sizes_plot(rows: &[SizeRow]) -> Result<String> {
    let (below, above) = (SeriesLabelPosition::LowerLeft, SeriesLabelPosition::UpperLeft);
    chart::svg(SIZE, |root| {
        let (ways_area, left_area) = root.split_horizontally(PANEL);
        panel("By how the light is found", rows, &ways(), below, &ways_area)?;
        panel("By what light is left out, else converged", rows, &left_out(), above, &left_area)
    })
}

/// A row's place: its radius, and its error in grey levels; of none a hundredth, which has a place on the axis.
fn place(row: &SizeRow) -> (f64, f64) {
    (row.radius_px, (255.0 * row.rms).max(0.01))
}

fn panel(
    caption: &str,
    rows: &[SizeRow],
    curves: &[(&str, &str, RGBColor)],
    names: SeriesLabelPosition,
    area: &Area<'_>,
) -> Drawn {
    let range = |value: fn(&SizeRow) -> f64, room: (f64, f64)| {
        let low = rows.iter().map(value).fold(f64::INFINITY, f64::min);
        room.0 * low..room.1 * rows.iter().map(value).fold(0.0, f64::max)
    };
    // Below and above the curves stand their names.
    let errors = range(|row| place(row).1, (0.16, 1.6));
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(
            range(|row| place(row).0, (0.8, 1.2)).log_scale(),
            errors.log_scale(),
        )?;
    let axes = ["radius in pixels", "RMS error, grey levels of 255"];
    chart::logarithmic_axes(&mut chart, axes, None)?;
    for (model, name, color) in curves {
        let of_model = rows.iter().filter(|row| row.model == *model).map(place);
        let points: Vec<(f64, f64)> = of_model.collect();
        chart::curve(&mut chart, *name, color.stroke_width(2), &points)?;
        chart::circles(&mut chart, 3, color.filled(), &points)?;
    }
    chart::legend(&mut chart, names, 12)
}
