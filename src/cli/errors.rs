//! `raindrops errors`: each model's error by the drop's size.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::device::DeviceArgs;
use super::format::{Format, Sheet};
use super::{Answer, print_beside, progress, write_json};
use crate::Error;
use crate::environment::Environment;
use crate::environment::bright::split;
use crate::files::write_whole;
use crate::gpu::Device;
use crate::measure::bench::read_json;
use crate::measure::tradeoff::{SizeRow, by_size, candidates, glints_by_size, sizes_plot};
use crate::plan::contrast;

/// Print each model's error by a drop's radius in pixels
#[derive(Args)]
pub struct ErrorsArgs {
    /// Environment images; errors are medians over them [default: the bundled sky]
    environments: Vec<PathBuf>,
    /// Radii in pixels, comma-separated
    #[arg(long, value_name = "R,…", value_delimiter = ',',
          default_values_t = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0])]
    radii: Vec<f64>,
    /// Views of each environment
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    views: u32,
    /// Measure only the error that images of small bright sources, such as a bare sun, add
    #[arg(long)]
    glints: bool,
    /// Write the rows as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Plot RMS error by radius
    #[arg(long, value_name = "FILE", conflicts_with = "glints")]
    svg: Option<PathBuf>,
    /// Take the rows that `--json` wrote instead of measuring
    #[arg(long, value_name = "FILE", conflicts_with_all = ["environments", "radii", "views", "glints", "json"])]
    from: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &ErrorsArgs) -> anyhow::Result<Answer> {
    super::check_folders([&args.json, &args.svg])?;
    if let Some(path) = &args.from {
        let rows: Vec<SizeRow> = serde_json::from_value(read_json(path)?)
            .map_err(|error| Error::read(path, format!("no rows of `errors --json`: {error}")))?;
        return show(args, &rows);
    }
    if let Some(radius) = args.radii.iter().find(|radius| !(0.1..=1000.0).contains(*radius)) {
        anyhow::bail!("--radii {radius}: give radii from 0.1 to 1000 pixels");
    }
    let mut environments = Vec::new();
    for path in &args.environments {
        environments.push(Environment::load(path)?);
    }
    if environments.is_empty() {
        environments.push(Environment::bundled()?);
    }
    let device = args.device.open()?;
    if args.glints {
        return glints(args, &device, &environments);
    }
    let (json, bar) = (args.json.as_ref(), progress(1000, ""));
    let say = |share: f64| bar.set_position((1000.0 * share) as u64);
    let rows = by_size(&device, &environments, &candidates(), &args.radii, args.views, &say)?;
    bar.finish_and_clear();
    show(args, &rows)?;
    for environment in &environments {
        let contrast = contrast(environment);
        print_beside(json, format_args!("contrast {contrast:.3}  {}", environment.name()))?;
    }
    write_json(json, &rows)?;
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

/// Prints rows as a table, and plots them if that was asked for.
fn show(args: &ErrorsArgs, rows: &[SizeRow]) -> anyhow::Result<Answer> {
    let json = args.json.as_ref();
    let mut radii: Vec<f64> = rows.iter().map(|row| row.radius_px).collect();
    radii.dedup();
    let cells = rows
        .iter()
        .map(|row| (row.model.as_str(), format!("{:.1} / {:.3}", 255.0 * row.rms, row.flip)));
    print_beside(json, table(cells.collect(), &radii))?;
    let unit =
        "RMS error in grey levels of 255 / mean FLIP, inside the drop; medians over environments";
    print_beside(json, unit)?;
    if let Some(path) = &args.svg {
        write_whole(path, sizes_plot(rows)?.as_bytes())?;
    }
    Ok(Answer::Yes)
}

/// What small bright sources add, environment by environment.
fn glints(
    args: &ErrorsArgs,
    device: &Arc<Device>,
    environments: &[Environment],
) -> anyhow::Result<Answer> {
    let (json, candidates, mut all) = (args.json.as_ref(), candidates(), Vec::new());
    for environment in environments {
        let bar = progress(1000, "");
        let say = |share: f64| bar.set_position((1000.0 * share) as u64);
        let (radii, views) = (&args.radii, args.views);
        let rows = glints_by_size(device, environment, &candidates, radii, views, &say)?;
        bar.finish_and_clear();
        let (Some(rows), Some(bright)) = (rows, split(environment)) else {
            print_beside(json, format_args!("no small bright sources in {}", environment.name()))?;
            continue;
        };
        let cells = rows.iter().map(|row| (row.model.as_str(), format!("{:.3}", row.rms)));
        print_beside(json, table(cells.collect(), radii))?;
        let unit = format!(
            "RMS error, 0 to 1, over the area of the drop and the root of the sources' light, which is {:.3} of the \
             rest's in {}",
            bright.strength(),
            environment.name()
        );
        print_beside(json, unit)?;
        all.push(rows);
    }
    write_json(json, &all)?;
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

/// A line a model, a column a radius, of cells radius by radius.
fn table(cells: Vec<(&str, String)>, radii: &[f64]) -> String {
    let mut header = vec!["radius in pixels".to_string()];
    header.extend(radii.iter().map(f64::to_string));
    let models = cells.iter().take(cells.len() / radii.len().max(1));
    let row = |(model, _): &(&str, String)| {
        let of_model = cells.iter().filter(|(name, _)| name == model);
        let figures = of_model.map(|(_, figures)| figures.clone());
        std::iter::once(model.to_string()).chain(figures).collect()
    };
    Sheet { names: 1, header, rows: models.map(row).collect() }.text(Format::Table)
}
