//! The trade as a picture: a panel a scene, error over time, the front as a line.

use plotters::prelude::*;

use super::report::{Report, Row};
use crate::Result;
use crate::measure::chart::{self, Area, Drawn, PRESETS};

/// Size of a panel in the plot's units.
const PANEL: (u32, u32) = (560, 420);
const COLUMNS: usize = 2;
/// Height of the line below the panels.
const FOOT: u32 = 40;
/// What a panel's axes and margins leave for its points, and the height and width of a letter of a name.
const PLOT: (f64, f64) = (484.0, 336.0);
const LETTER: (f64, f64) = (5.5, 12.0);

/// The plot as SVG.
///
/// # Errors
/// [`crate::Error::Plot`] if it cannot be drawn, with the reason.
pub fn plot(report: &Report) -> Result<String> {
    let mut scenes: Vec<&str> = report.rows.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    let (columns, lines) = (COLUMNS.min(scenes.len().max(1)), scenes.len().div_ceil(COLUMNS));
    let size = (PANEL.0 * columns as u32, PANEL.1 * lines.max(1) as u32 + FOOT);
    chart::svg(size, |root| draw(report, &scenes, [columns, lines], root))
}

fn draw(report: &Report, scenes: &[&str], [columns, lines]: [usize; 2], root: &Area<'_>) -> Drawn {
    let size = root.dim_in_pixel();
    let (panels, foot) = root.split_vertically(size.1 - FOOT);
    for (scene, area) in scenes.iter().zip(panels.split_evenly((lines.max(1), columns))) {
        let rows: Vec<&Row> = report.rows.iter().filter(|row| row.scene == *scene).collect();
        panel(scene, &rows, &area)?;
    }
    let device = &report.device;
    let lines = [
        format!("{} ({} {})", device.name, device.driver, device.driver_info),
        format!(
            "truth: {} samples a pixel; line: the Pareto front; names where there is room",
            report.truth_samples
        ),
    ];
    for (line, down) in lines.into_iter().zip([2, 20]) {
        foot.draw(&Text::new(line, (16, down), ("sans-serif", 14)))?;
    }
    Ok(())
}

fn panel(scene: &str, rows: &[&Row], area: &Area<'_>) -> Drawn {
    // A model without error has no place on a logarithmic axis: a hundredth of a grey level stands in.
    // Speeds are of models measured in turn, and the front is theirs; times alone are of different minutes.
    let base = rows.iter().find(|row| row.speed == 1.0).map_or(1.0, |row| row.median_ms);
    let place = |row: &Row| (base / row.speed, (255.0 * row.errors.rms).max(0.01));
    let range = |values: Vec<f64>| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        0.7 * low..1.6 * high
    };
    let times = range(rows.iter().map(|row| place(row).0).collect());
    let errors = range(rows.iter().map(|row| place(row).1).collect());
    let mut chart = ChartBuilder::on(area)
        .caption(scene, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(times.clone().log_scale(), errors.clone().log_scale())?;
    let axes =
        ["ms a frame: the first model's, divided by the speed", "RMS error, grey levels of 255"];
    chart::logarithmic_axes(&mut chart, axes, Some(6))?;
    let mut front: Vec<(f64, f64)> =
        rows.iter().filter(|row| row.pareto).map(|row| place(row)).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, BLACK.mix(0.4)))?;
    for (family, color) in PRESETS {
        let of_family = rows.iter().filter(|row| row.axes.preset.name() == family);
        chart
            .draw_series(of_family.map(|row| {
                let style = if row.pareto { color.filled() } else { color.stroke_width(1) };
                Circle::new(place(row), 4, style)
            }))?
            .label(family)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, color.filled()));
    }
    let on_panel = |row: &Row| {
        let (ms, error) = place(row);
        (
            PLOT.0 * (ms / times.start).ln() / (times.end / times.start).ln(),
            PLOT.1 * (error / errors.start).ln() / (errors.end / errors.start).ln(),
        )
    };
    chart.draw_series(names(rows, on_panel).into_iter().map(|(row, (right, down))| {
        let from = (right as i32, down as i32);
        let name = Text::new(row.model.clone(), from, ("sans-serif", 11).into_font());
        EmptyElement::at(place(row)) + name
    }))?;
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 13))
        .draw()?;
    Ok(())
}

/// The models to name, and how far to the right of and below its point each name begins: the presets, then the
/// front, each where it meets no other name. A preset is tried on all sides, as two may be the same program.
fn names<'a>(
    rows: &[&'a Row],
    on_panel: impl Fn(&Row) -> (f64, f64),
) -> Vec<(&'a Row, (f64, f64))> {
    const GAP: f64 = 7.0;
    let is_preset = |row: &Row| row.model == row.axes.preset.name();
    let mut wanted: Vec<&Row> =
        rows.iter().copied().filter(|row| row.pareto || is_preset(row)).collect();
    wanted.sort_by_key(|row| !is_preset(row));
    let (mut named, mut taken) = (Vec::new(), Vec::<(f64, f64, f64)>::new());
    for row in wanted {
        let (x, y) = on_panel(row);
        let width = LETTER.0 * row.model.len() as f64;
        let (right, left) = (GAP, -GAP - width);
        let beside = if x + GAP + width > PLOT.0 { left } else { right };
        let level = -5.0;
        let sides = [
            (beside, level),
            (beside, level + LETTER.1),
            (left, level),
            (beside, level - LETTER.1),
        ];
        let tried = if is_preset(row) { &sides[..] } else { &sides[..1] };
        let is_free = |(right, down): &&(f64, f64)| {
            let (from, to, height) = (x + right, x + right + width, y - down);
            from > 0.0
                && taken.iter().all(|(left, right, other)| {
                    from > *right || to < *left || (height - other).abs() > LETTER.1 - 0.5
                })
        };
        if let Some(&(right, down)) = tried.iter().find(is_free) {
            taken.push((x + right, x + right + width, y - down));
            named.push((row, (right, down)));
        }
    }
    named
}
