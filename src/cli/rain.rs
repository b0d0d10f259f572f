//! `raindrops rain`: what rain a scene has.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use serde::Serialize;

use super::format::{Format, Sheet};
use super::options::SceneArgs;
use super::tell::note;
use super::{Answer, print, write_json};
use crate::files::write_whole;
use crate::measure::rain_plot;
use crate::plan::Cutoff;
use crate::rain::visibility::Frustum;
use crate::rain::{fall, medium, shape};
use crate::scene::Scene;
use crate::scene::model::FarRain;
use crate::scene::real_rain::RealRain;
use crate::thousands::thousands;

/// Drops that `--svg` counts.
const SAMPLED: f64 = 1e6;

/// Print what rain a scene has, and how much of it is drawn
#[derive(Args)]
pub struct RainArgs {
    /// Radius in pixels under which drops are part of the medium
    #[arg(long, value_name = "PX")]
    cutoff_px: Option<f64>,
    /// What becomes of drops smaller than --cutoff-px
    #[arg(long, value_enum, value_name = "NAME")]
    far_rain: Option<FarRain>,
    /// Write the figures as JSON; `-` is stdout, instead of the table
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Plot the law of sizes, and the sizes of a million drops, as SVG
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
}

/// Schema `raindrops-rain/1`.
#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    rate_mm_h: f64,
    rate_that_falls_mm_h: f64,
    /// Λ of the law of sizes.
    slope_per_mm: f64,
    drops_per_m3: f64,
    mean_diameter_mm: f64,
    median_volume_diameter_mm: f64,
    water_g_m3: f64,
    extinction_per_m: f64,
    visibility_5_percent_m: f64,
    far_rain: FarRain,
    /// 0 where every drop is drawn.
    cutoff_px: f64,
    cutoff_reason: String,
    drops_in_view: f64,
    /// Depth from which on all rain is medium; none without a medium, or where the rain ends before.
    medium_from_m: Option<f64>,
    /// Standard deviation of a pixel's opacity by the drops that are not drawn.
    noise: f64,
    classes: Vec<ClassReport>,
}

#[derive(Serialize)]
struct ClassReport {
    diameter_from_mm: f64,
    diameter_to_mm: f64,
    drops_per_m3: f64,
    speed_m_s: f64,
    axis_ratio: f64,
}

/// Runs the command.
pub fn run(args: &RainArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    scene.model.cutoff_px = args.cutoff_px.or(scene.model.cutoff_px);
    scene.model.far_rain = args.far_rain.or(scene.model.far_rain);
    let Some(rain) = scene.real_rain() else {
        bail!(
            "{} has no rain by its rate: give rain.rate in the scene, or --rate 25",
            args.scene.name()
        );
    };
    scene.validate("command line")?;
    super::check_folders([&args.json, &args.svg])?;
    let cutoff = Cutoff::of(&scene, &rain, &super::open_environment(&scene)?);
    let report = report(args.scene.name(), &scene, &rain, cutoff);
    for note in notes(&rain) {
        note!("{note}");
    }
    write_json(args.json.as_ref(), &report)?;
    if args.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
        show(&report)?;
    }
    if let Some(path) = &args.svg {
        write_whole(path, rain_plot::svg(&rain, scene.seed, SAMPLED)?.as_bytes())?;
    }
    Ok(Answer::Yes)
}

fn report(name: String, scene: &Scene, rain: &RealRain, cutoff: Cutoff) -> Report {
    let law = rain.law();
    let frustum = Frustum::of(&scene.view(), rain.extent);
    let Cutoff { px: cutoff_px, why: cutoff_reason, is_grainy, .. } = cutoff;
    let by_need = if is_grainy { FarRain::Grain } else { FarRain::Medium };
    let far_rain = scene.model.far_rain.unwrap_or(by_need);
    let is_medium = [FarRain::Medium, FarRain::Grain].contains(&far_rain);
    let starts = medium::starts(&law, frustum.focal_px, cutoff_px);
    let noise = match far_rain {
        FarRain::Drops => 0.0,
        _ => frustum.noise(&law, rain.air_density, cutoff_px, scene.exposed().abs()),
    };
    Report {
        schema: "raindrops-rain/1",
        scene: name,
        rate_mm_h: rain.rate,
        rate_that_falls_mm_h: rain.rate_that_falls(),
        slope_per_mm: law.slope,
        drops_per_m3: law.number(),
        mean_diameter_mm: law.mean_diameter(),
        median_volume_diameter_mm: law.median_volume_diameter(),
        water_g_m3: law.water(),
        extinction_per_m: law.extinction(),
        visibility_5_percent_m: medium::visibility(law.extinction()),
        far_rain,
        cutoff_px,
        cutoff_reason,
        drops_in_view: frustum.drops_above(&law, cutoff_px),
        medium_from_m: (is_medium && starts < rain.extent).then_some(starts),
        noise,
        classes: rain
            .classes()
            .iter()
            .map(|class| ClassReport {
                diameter_from_mm: class.from,
                diameter_to_mm: class.to,
                drops_per_m3: class.number,
                speed_m_s: class.speed,
                axis_ratio: class.axis_ratio,
            })
            .collect(),
    }
}

/// Part by which cut-offs may change the median-volume diameter that was asked for before it is said.
const MEDIAN_KEPT: f64 = 0.02;

/// What is otherwise than a reader of the scene may think: constant because no measurement goes on, or cut off.
fn notes(rain: &RealRain) -> Vec<String> {
    let mut notes = Vec::new();
    let largest = rain.diameters[1];
    if largest > fall::FASTEST {
        notes.push(format!("drops above {0} mm fall as fast as drops of {0} mm", fall::FASTEST));
    }
    if largest > shape::LARGEST {
        notes.push(format!("above {} mm drops have the shape of those of it", shape::LARGEST));
    }
    let median = rain.law().median_volume_diameter();
    if let Some(asked) =
        rain.median_diameter.filter(|asked| (median / asked - 1.0).abs() > MEDIAN_KEPT)
    {
        notes.push(format!(
            "without cut-offs the median-volume diameter is {asked} mm, as asked; within rain.diameters it is {median:.3} mm"
        ));
    }
    if rain.wind.y != 0.0 {
        notes.push("wind up or down changes the rate that falls, not the number of drops".into());
    }
    notes
}

/// Prints a figure, as `pane` does, too.
pub(super) fn line(name: &str, value: f64, unit: &str) -> crate::Result<()> {
    print(format_args!("{name:24} {:>12} {unit}", significant(value)))
}

fn show(report: &Report) -> anyhow::Result<()> {
    line("rate", report.rate_mm_h, "mm/h")?;
    line("rate that falls", report.rate_that_falls_mm_h, "mm/h")?;
    line("slope of the sizes", report.slope_per_mm, "per mm")?;
    line("drops", report.drops_per_m3, "per m³")?;
    line("mean diameter", report.mean_diameter_mm, "mm")?;
    line("median-volume diameter", report.median_volume_diameter_mm, "mm")?;
    line("water", report.water_g_m3, "g/m³")?;
    line("extinction", report.extinction_per_m, "per m")?;
    line("visibility (5 %)", report.visibility_5_percent_m, "m")?;
    line("cut-off", report.cutoff_px, &format!("px: {}", report.cutoff_reason))?;
    line("drops in view", report.drops_in_view, "drawn one by one")?;
    match (report.far_rain, report.medium_from_m) {
        (FarRain::Medium | FarRain::Grain, Some(from)) => {
            line("all rain is medium from", from, "m on")?
        }
        (FarRain::Medium | FarRain::Grain, None) => {
            print("all rain is medium from    nowhere: it ends before")?
        }
        (FarRain::Drops, _) => print("every drop is drawn")?,
        (FarRain::None, _) => print("drops under the cut-off are left out")?,
    }
    line("noise of the others", report.noise, "of a pixel's opacity, at an instant")?;
    let header = ["from mm", "to mm", "drops per m³", "speed m/s", "axis ratio"];
    let row = |class: &ClassReport| {
        vec![
            format!("{:.3}", class.diameter_from_mm),
            format!("{:.3}", class.diameter_to_mm),
            significant(class.drops_per_m3),
            format!("{:.3}", class.speed_m_s),
            format!("{:.4}", class.axis_ratio),
        ]
    };
    let rows = report.classes.iter().map(row).collect();
    let sheet = Sheet { names: 1, header: header.map(String::from).to_vec(), rows };
    print(sheet.text(Format::Table))?;
    Ok(())
}

/// Four significant digits; from 1,000 on a whole number.
fn significant(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e7).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    if value >= 999.5 {
        return thousands(value.round() as u64);
    }
    let digits = if value == 0.0 { 0 } else { (3 - value.abs().log10().floor() as i32).max(0) };
    format!("{value:.*}", digits as usize)
}
