//! `raindrops compare-devices`: one scene on every driver, how long each takes and how far apart their
//! pictures are, and from which stage on.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use comfy_table::{ContentArrangement, Table, presets};
use serde_json::json;

use super::options::{ModelArgs, SceneArgs, devices, open_device};
use super::{Answer, print, write_json};
use crate::environment::Environment;
use crate::gpu::{Device, DeviceReport, Instance, Validation};
use crate::measure::bench::drivers::{Apart, apart, difference};
use crate::measure::bench::{DeviceHead, Effort, Variant, measure};
use crate::measure::statistics::median;
use crate::picture::Picture;
use crate::picture::tone_map::exposure_of;
use crate::plan::{Output, plan};
use crate::reference::{Tracer, Truth};
use crate::renderer::Renderer;
use crate::renderer::stages::Stages;
use crate::scene::Scene;
use crate::scene::model::Preset;

/// Compare the drivers of this machine on one scene: time, picture, first stage that differs
#[derive(Args)]
pub struct CompareDevicesArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Compare with the truth too, of so many samples a pixel
    #[arg(long, value_name = "N")]
    truth: Option<u32>,
    /// Seconds to measure on each device …
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = super::parse_seconds)]
    seconds: f64,
    /// … and at least so many frames, but for no longer than ten times that
    #[arg(long, value_name = "N", default_value_t = 8)]
    frames: usize,
    /// Answer "no" (exit status 1) if the mean FLIP of two drivers is over this
    #[arg(long, value_name = "X")]
    max_flip: Option<f64>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A scene on one driver.
struct Portrait {
    report: DeviceReport,
    median_ms: f64,
    visible: u64,
    picture: Picture,
    /// The paper's frame, which alone has stages, and its picture.
    stages: Option<(Stages, Picture)>,
}

/// Runs the command.
pub fn run(args: &CompareDevicesArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    if let Some(path) = &args.json {
        super::check_folder(path)?;
    }
    let environment = super::open_environment(&scene)?;
    let instance = Instance::new(Validation::Off)?;
    let mut portraits = Vec::new();
    for report in devices(&instance)? {
        if !report.missing.is_empty() {
            eprintln!("left out: {} lacks {}", report.name, report.missing.join(", "));
            continue;
        }
        let device = open_device(&instance, report)?;
        portraits.push(portray(args, &device, &scene, &environment)?);
    }
    let [first, ..] = portraits.as_slice() else { return Err(crate::Error::NoDevice.into()) };
    if portraits.len() < 2 {
        eprintln!(
            "note: there is only one device; scripts/setup.sh --drivers fetches more, VK_DRIVER_FILES selects"
        );
    }
    let exposure = exposure_of(&scene.tone_map, &first.picture);

    let truth = args.truth.map(|samples| {
        let truth = Truth { samples, ..Truth::default() };
        Tracer::new(&scene, &environment, truth).picture()
    });
    let names: Vec<String> =
        portraits.iter().enumerate().map(|(n, p)| format!("{n}: {}", name(&p.report))).collect();
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_content_arrangement(ContentArrangement::Disabled);
    let mut header = vec!["device".into(), "ms".into(), "in view".into()];
    header.extend((0..portraits.len()).map(|n| format!("ms / ms of {n}")));
    header.extend((0..portraits.len()).map(|n| format!("FLIP to {n}")));
    header.extend(truth.is_some().then(|| "FLIP to truth".to_string()));
    table.set_header(header);
    let mut rows = Vec::new();
    let mut worst = 0.0f64;
    for (portrait, name) in portraits.iter().zip(&names) {
        let differences: Vec<(f64, f64)> = portraits
            .iter()
            .map(|other| difference(&other.picture, &portrait.picture, exposure))
            .collect();
        worst = differences.iter().map(|(flip, _)| *flip).fold(worst, f64::max);
        let from_truth = truth.as_ref().map(|truth| difference(truth, &portrait.picture, exposure));
        let mut cells =
            vec![name.clone(), format!("{:.1}", portrait.median_ms), portrait.visible.to_string()];
        cells.extend(portraits.iter().map(|o| format!("{:.2}", portrait.median_ms / o.median_ms)));
        cells.extend(differences.iter().chain(&from_truth).map(|(flip, _)| format!("{flip:.5}")));
        table.add_row(cells);
        rows.push(json!({
            "device": DeviceHead::of(&portrait.report),
            "median_ms": portrait.median_ms,
            "visible": portrait.visible,
            "flip": differences.iter().map(|(flip, _)| flip).collect::<Vec<_>>(),
            "rel_mse": differences.iter().map(|(_, rel_mse)| rel_mse).collect::<Vec<_>>(),
            "flip_to_truth": from_truth.map(|(flip, _)| flip),
            "rel_mse_to_truth": from_truth.map(|(_, rel_mse)| rel_mse),
        }));
    }
    print(table)?;

    let mut stages = Vec::new();
    for (b, other) in portraits.iter().enumerate() {
        for (a, one) in portraits[..b].iter().enumerate() {
            let (Some(one), Some(other)) = (&one.stages, &other.stages) else { continue };
            let apart = apart((&one.0, &one.1), (&other.0, &other.1));
            print(format_args!("{a} and {b}: {}", tell(&apart)))?;
            stages.push(json!({ "a": a, "b": b, "stages": apart }));
        }
    }
    if let Some(path) = &args.json {
        let schema = "raindrops-compare-devices/1";
        write_json(path, &json!({ "schema": schema, "devices": rows, "pairs": stages }))?;
    }
    if args.max_flip.is_some_and(|most| worst > most) {
        eprintln!("raindrops: two drivers are FLIP {worst:.5} apart");
        return Ok(Answer::No);
    }
    Ok(Answer::Yes)
}

fn portray(
    args: &CompareDevicesArgs,
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> anyhow::Result<Portrait> {
    let draw = |scene: &Scene| -> anyhow::Result<_> {
        let plan = plan(scene, environment, Output::Radiance)?;
        let mut renderer = Renderer::new(device, scene, environment, &plan)?;
        renderer.submit(scene)?;
        let visible = renderer.finish()?.counts.visible;
        Ok((renderer.read_radiance()?, visible, plan))
    };
    let (picture, visible, plan) = draw(scene)?;
    let variants = [Variant { scene: scene.clone(), plan }];
    let effort = Effort { seconds: args.seconds, frames: args.frames };
    let measured = measure(device, environment, &variants, effort, &|_| {})?;
    let median_ms = median(&measured[0].samples_ms);
    let stages = if scene.drop_count() > 0 {
        let mut scene = scene.clone();
        scene.model = crate::scene::ModelChoice {
            preset: Preset::Paper,
            mask_size: scene.model.mask_size,
            ..Default::default()
        };
        let (picture, _, plan) = draw(&scene)?;
        Some((Stages::draw(device, &scene, environment, &plan)?, picture))
    } else {
        None
    };
    Ok(Portrait { report: device.report.clone(), median_ms, visible, picture, stages })
}

/// Device, driver and its version.
fn name(report: &DeviceReport) -> String {
    format!("{}, {} {}", report.name, report.driver, report.driver_info).trim_end().into()
}

/// The stages of the paper's frame, and the first that differs.
fn tell(apart: &[Apart]) -> String {
    let stage = |apart: &Apart| {
        let Apart { stage, unit, tolerance, share, largest } = apart;
        format!(
            "\n   {stage:<10} {:>9.4} % off by over {tolerance} {unit}, largest {largest:.4}",
            100.0 * share
        )
    };
    let first = match apart.iter().find(|apart| apart.differs()) {
        None => "no stage differs beyond rounding".into(),
        Some(first) => format!("the first stage to differ is the {}", first.stage),
    };
    format!("{first}{}", apart.iter().map(stage).collect::<String>())
}
