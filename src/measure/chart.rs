//! What all plots share: the presets' colours, axes, curves and legends, and SVG to hold them.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::Result;
use crate::error::PlotFailed;
use crate::thousands::thousands;

/// A part of a plot.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Whether something was drawn.
pub(crate) type Drawn = std::result::Result<(), PlotFailed>;

/// A pair of axes and what is drawn in it.
type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

/// An axis of numbers.
pub(crate) trait Axis: Ranged<ValueType = f64> + ValueFormatter<f64> {}
impl<T: Ranged<ValueType = f64> + ValueFormatter<f64>> Axis for T {}

/// SVG of a size, white where nothing is drawn.
///
/// # Errors
/// [`crate::Error::Plot`].
pub(crate) fn svg(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(PlotFailed::from)?;
        draw(&root)?;
        root.present().map_err(PlotFailed::from)?;
    }
    Ok(text)
}

/// A number on a logarithmic axis: 1, 2 and 5 and their tenfolds; the others have no room.
pub(crate) fn label(value: f64) -> String {
    let leading = value / 10f64.powf(value.log10().floor());
    match leading.round() as u32 {
        1 | 2 | 5 | 10 if value >= 1.0 => thousands(value.round() as u64),
        1 | 2 | 5 | 10 => format!("{value:.1}"),
        _ => String::new(),
    }
}

/// What two logarithmic axes are of, and their lines. `ticks`: about how many numbers each has, none for as many as have room.
pub(crate) fn logarithmic_axes<X: Axis, Y: Axis>(
    chart: &mut Chart<'_, '_, X, Y>,
    [across, up]: [&str; 2],
    ticks: Option<usize>,
) -> Drawn {
    let (of_x, of_y) = (|x: &f64| label(*x), |y: &f64| label(*y));
    let mut mesh = chart.configure_mesh();
    if let Some(ticks) = ticks {
        mesh.x_labels(ticks).y_labels(ticks);
    }
    mesh.light_line_style(TRANSPARENT).x_desc(across).y_desc(up);
    mesh.x_label_formatter(&of_x).y_label_formatter(&of_y);
    mesh.label_style(("sans-serif", 13)).axis_desc_style(("sans-serif", 14)).draw()?;
    Ok(())
}

/// A line through points, with a place in the legend.
pub(crate) fn curve<X: Axis, Y: Axis>(
    chart: &mut Chart<'_, '_, X, Y>,
    name: impl Into<String>,
    style: ShapeStyle,
    points: &[(f64, f64)],
) -> Drawn {
    chart
        .draw_series(LineSeries::new(points.iter().copied(), style))?
        .label(name)
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], style));
    Ok(())
}

/// A circle at each point.
pub(crate) fn circles<X: Axis, Y: Axis>(
    chart: &mut Chart<'_, '_, X, Y>,
    radius: u32,
    style: ShapeStyle,
    points: &[(f64, f64)],
) -> Drawn {
    chart.draw_series(points.iter().map(|point| Circle::new(*point, radius, style)))?;
    Ok(())
}

/// The names of the curves, over a paper that lets a fifth of what is behind shine through.
pub(crate) fn legend<'a, 'b: 'a, X: Axis, Y: Axis>(
    chart: &mut Chart<'a, 'b, X, Y>,
    place: SeriesLabelPosition,
    size: u32,
) -> Drawn {
    let mut names = chart.configure_series_labels();
    names.position(place).background_style(WHITE.mix(0.8)).label_font(("sans-serif", size));
    names.draw()?;
    Ok(())
}

/// Colours of presets (Okabe and Ito 2008: told apart by everyone), in the order in which a report's page numbers them.
pub(crate) const PRESETS: [(&str, RGBColor); 5] = [
    ("paper", RGBColor(0, 114, 178)),
    ("fast", RGBColor(213, 94, 0)),
    ("exact", RGBColor(0, 158, 115)),
    ("paper-compact", RGBColor(204, 121, 167)),
    ("auto", RGBColor(0, 0, 0)),
];

/// The colour of a preset.
pub(crate) fn of_preset(name: &str) -> RGBColor {
    let found = PRESETS.iter().find(|(preset, _)| *preset == name);
    found.map_or(RGBColor(110, 110, 110), |(_, color)| *color)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::scene::model::Preset;

    #[test]
    fn every_preset_has_a_colour_of_its_own() {
        let mut seen = Vec::new();
        for preset in Preset::value_variants() {
            let color = of_preset(&preset.to_string());
            assert!(PRESETS.iter().any(|(name, _)| *name == preset.to_string()), "{preset}");
            assert!(!seen.contains(&color), "{preset} has another's colour");
            seen.push(color);
        }
    }
}
