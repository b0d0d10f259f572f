//! The law of real rain and the drops that its cells hold, in one plot: asked and realised.

use plotters::prelude::*;

use crate::Result;
use crate::measure::chart::{self, Area, Drawn};
use crate::rain::cells::Lattice;
use crate::scene::real_rain::RealRain;
use crate::thousands::thousands_of;

/// Bins of the diameter.
const BINS: usize = 60;

/// Drops a cubic metre and millimetre, by bins of the diameter: asked and found among `drops` drops.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Edges of the bins, mm.
    pub edges: Vec<f64>,
    /// By the law, in each bin.
    pub asked: Vec<f64>,
    /// By the drops, in each bin.
    pub found: Vec<f64>,
}

/// Counts the drops of as many cells as hold `drops` on average.
pub fn distribution(rain: &RealRain, seed: u64, drops: f64) -> Distribution {
    let law = rain.law();
    let width = (law.to - law.from) / BINS as f64;
    let edges: Vec<f64> = (0..=BINS).map(|bin| law.from + bin as f64 * width).collect();
    let asked = edges.windows(2).map(|e| law.moment_between(0.0, e[0], e[1]) / width).collect();
    let mut found = vec![0.0; BINS];
    for lattice in rain.lattices(seed) {
        let cells = (drops / law.number() / lattice.edge().powi(3)).ceil().max(1.0);
        for diameter in diameters(&lattice, cells as i64) {
            let bin = ((diameter - law.from) / width).clamp(0.0, BINS as f64 - 1.0) as usize;
            found[bin] += 1.0 / (cells * lattice.edge().powi(3) * width);
        }
    }
    Distribution { edges, asked, found }
}

fn diameters(lattice: &Lattice, cells: i64) -> impl Iterator<Item = f64> {
    (0..cells).flat_map(|x| lattice.drops([x, 0, 0]).map(|drop| drop.diameter_mm()))
}

/// The plot as SVG.
///
/// # Errors
/// [`crate::Error::Plot`].
pub fn svg(rain: &RealRain, seed: u64, drops: f64) -> Result<String> {
    chart::svg((800, 520), |root| draw(&distribution(rain, seed, drops), rain, drops, root))
}

fn draw(distribution: &Distribution, rain: &RealRain, drops: f64, area: &Area<'_>) -> Drawn {
    let Distribution { edges, asked, found } = distribution;
    let all = || asked.iter().chain(found).copied().filter(|value| *value > 0.0);
    let (least, most) = all().fold((f64::MAX, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{} mm/h, {}", rain.rate, rain.sizes), ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(
            edges[0]..edges[edges.len() - 1],
            (0.7 * least..1.4 * most).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("diameter, mm")
        .y_desc("drops per m³ and mm")
        .y_label_formatter(&|value| format!("{value:.0e}"))
        .draw()?;
    let middles = || edges.windows(2).map(|e| 0.5 * (e[0] + e[1]));
    chart
        .draw_series(LineSeries::new(middles().zip(asked.iter().copied()), BLACK.stroke_width(2)))?
        .label("asked")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.stroke_width(2)));
    let points = middles().zip(found.iter().copied()).filter(|(_, value)| *value > 0.0);
    chart
        .draw_series(points.map(|at| Circle::new(at, 3, RED.filled())))?
        .label(format!("found among {} drops", thousands_of(drops, 0)))
        .legend(|(x, y)| Circle::new((x + 10, y), 3, RED.filled()));
    chart
        .configure_series_labels()
        .background_style(WHITE)
        .border_style(BLACK)
        .position(SeriesLabelPosition::UpperRight)
        .draw()?;
    Ok(())
}
