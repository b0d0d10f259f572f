//! `raindrops bench`: the paper's Table II on this machine's Vulkan devices.

use std::path::PathBuf;

use clap::Args;

use super::options::{
    AxisArgs, DeviceArgs, SceneValues, choose_device, devices, open_device, resolve,
};
use super::{Answer, parse_seconds, print, progress, say_doubt, write_json};
use crate::environment::Environment;
use crate::files::write_whole;
use crate::gpu::disk_cache::KeptDevice;
use crate::measure::Host;
use crate::measure::bench::{
    Build, DeviceHead, Effort, Report, Row, SCHEMA, Variant, measure, plot, table,
};
use crate::plan::{Output, plan_by};
use crate::rain::cull::count_visible;
use crate::scene::model::{Operator, Preset};
use crate::scene::{RainSettings, Scene};

/// Measure frame rates: the paper's Table II on this machine
#[derive(Args)]
pub struct BenchArgs {
    /// Scene file (TOML); left out: the paper's benchmark scene
    scene: Option<PathBuf>,
    /// Drop counts, comma-separated
    #[arg(
        long,
        value_name = "N,…",
        value_delimiter = ',',
        default_values_t = [125_000, 250_000, 500_000, 1_000_000, 2_000_000, 4_000_000],
    )]
    drops: Vec<u32>,
    /// Presets to measure side by side, in turn, comma-separated; left out: the scene's, or paper
    #[arg(long, value_enum, value_name = "NAME,…", value_delimiter = ',')]
    preset: Vec<Preset>,
    /// Seconds to measure a row …
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = parse_seconds)]
    seconds: f64,
    /// … and at least so many frames of it, but for no longer than ten times that
    #[arg(long, value_name = "N", default_value_t = 12)]
    frames: usize,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw frames a second by drops, beside the paper's three machines, as SVG
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    values: SceneValues,
    #[command(flatten)]
    axes: AxisArgs,
    /// `--device all` measures every device in turn
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &BenchArgs) -> anyhow::Result<Answer> {
    let mut scene = args.values.load(args.scene.as_deref())?;
    args.axes.apply(&mut scene)?;
    for file in [&args.json, &args.svg].into_iter().flatten() {
        super::check_folder(file)?;
    }
    let is_all = args.device.device.as_deref() == Some("all");
    if is_all && args.svg.is_some() {
        anyhow::bail!("--svg draws one device; choose it by --device");
    }
    if scene.tone_map.operator == Operator::None {
        eprintln!("note: the tone-mapped rows clip instead of compressing (operator none)");
    }
    let mut presets = args.preset.clone();
    if presets.is_empty() {
        // Without a scene the benchmark is the paper's table, by the paper's method.
        presets.push(args.scene.as_ref().map_or(Preset::Paper, |_| scene.model.preset));
    }
    scene.rain.get_or_insert_default();
    // The published rates stand beside the scene that they are of.
    let is_papers = {
        let (mut plain, mut papers) = (scene.clone(), Scene::default());
        plain.model = papers.model;
        (plain.rain, papers.rain) = (plain.rain.map(uncounted), papers.rain.map(uncounted));
        plain == papers
    };
    let environment = super::open_environment(&scene)?;

    let instance = args.device.instance()?;
    let chosen = match args.device.device.as_deref() {
        Some("all") => devices(&instance)?,
        wanted => vec![choose_device(&instance, wanted)?],
    };
    let mut reports = Vec::new();
    let mut answer = Answer::Yes;
    for device in chosen {
        if !device.missing.is_empty() {
            eprintln!("left out: {} lacks {}", device.name, device.missing.join(", "));
            continue;
        }
        let device = open_device(&instance, device)?;
        let report = bench(args, &device, &scene, &presets, &environment)?;
        print(format_args!("{}\n{}", device.report.summary(), table(&report.rows, is_papers)))?;
        print(host_line(&report))?;
        print(start_line(&report))?;
        if !report.rows.iter().all(Row::passes_add_up) {
            eprintln!(
                "note: the driver's times of the passes do not add up to the frames; trust the frames"
            );
        }
        if !check_counts(&scene, &report) {
            answer = Answer::No;
        }
        reports.push(report);
    }
    if reports.is_empty() {
        anyhow::bail!("--device all: no device has all that is needed; see raindrops devices");
    }
    if let Some(path) = &args.json {
        match reports.as_slice() {
            [one] if !is_all => write_json(path, one)?,
            all => write_json(path, &all)?,
        }
    }
    if let (Some(path), [report]) = (&args.svg, reports.as_slice()) {
        write_whole(path, plot(report)?.as_bytes())?;
    }
    instance.expect_silence()?;
    Ok(answer)
}

/// Rain but for its count.
fn uncounted(rain: RainSettings) -> RainSettings {
    RainSettings { count: 0, ..rain }
}

/// Every count with every preset, with and without tone mapping.
fn bench(
    args: &BenchArgs,
    device: &KeptDevice,
    scene: &Scene,
    presets: &[Preset],
    environment: &Environment,
) -> anyhow::Result<Report> {
    let host = Host::now();
    let bar = progress(100 * args.drops.len() as u64, "%");
    let mut rows = Vec::new();
    for (number, count) in args.drops.iter().enumerate() {
        bar.set_message(super::drops((*count).into()));
        let mut variants = Vec::new();
        for preset in presets {
            let mut scene = scene.clone();
            scene.model.take_preset(*preset);
            scene.rain.get_or_insert_default().count = *count;
            scene.validate("command line")?;
            let choice = bar.suspend(|| resolve(device, &scene, environment))?;
            for output in [Output::Display, Output::Radiance] {
                let plan = plan_by(&scene, choice.as_ref(), output)?;
                if output == Output::Display {
                    bar.suspend(|| say_doubt(&plan));
                }
                variants.push(Variant { plan, scene: scene.clone() });
            }
        }
        let effort = Effort { seconds: args.seconds, frames: args.frames };
        let tick = |share: f64| bar.set_position(((number as f64 + share) * 100.0) as u64);
        let measured = measure(device, environment, &variants, effort, &tick)?;
        rows.extend(variants.iter().zip(&measured).map(|(v, m)| Row::new(v, m)));
    }
    bar.finish_and_clear();
    Ok(Report {
        schema: SCHEMA,
        device: DeviceHead::of(&device.report),
        build: Build::this(),
        host,
        environment: environment.name().into(),
        pipeline_cache_bytes: device.bytes_found(),
        rows,
    })
}

fn host_line(report: &Report) -> String {
    let host = &report.host;
    let load = host.load.map_or(String::new(), |load| format!(", load {load}"));
    let (width, height) = report.rows.first().map_or((0, 0), |row| (row.width, row.height));
    format!(
        "{width} x {height}, environment {}; {} ({} cores{load}), {}; raindrops {} {} {}",
        report.environment,
        host.cpu,
        host.cores,
        host.os,
        report.build.version,
        report.build.commit,
        report.build.profile
    )
}

/// What each preset takes until its first picture, with the most drops that were measured.
fn start_line(report: &Report) -> String {
    let most = report.rows.iter().map(|row| row.drops).max().unwrap_or_default();
    let starts: Vec<String> = report
        .rows
        .iter()
        .filter(|row| row.tone_map && row.drops == most)
        .map(|row| {
            let steps = row.setup.0.iter().map(|(name, ms)| format!("{name} {ms:.0}"));
            let steps = steps.collect::<Vec<_>>().join(", ");
            let (setup, first) = (row.setup_ms, row.first_frame_ms);
            format!("{} {setup:.0} ms ({steps}) + {first:.0} ms", row.preset)
        })
        .collect();
    let pipelines = match report.pipeline_cache_bytes {
        0 => "no compiled pipelines kept".into(),
        bytes => format!("{bytes} bytes of compiled pipelines"),
    };
    format!("set-up + first frame, {most} drops, {pipelines}: {}", starts.join("; "))
}

/// The drops in view, counted by the GPU, against the CPU's count of the same.
fn check_counts(scene: &Scene, report: &Report) -> bool {
    let mut agree = true;
    for row in report.rows.iter().filter(|row| row.tone_map && row.simulation == "integer") {
        let mut scene = scene.clone();
        if let Some(rain) = &mut scene.rain {
            rain.count = row.drops - scene.drops.len() as u32;
        }
        let expected = count_visible(&scene);
        if row.visible != expected {
            eprintln!(
                "error: {} of {} drops in view on the GPU, {expected} by the CPU's count",
                row.visible, row.drops
            );
            agree = false;
        }
    }
    agree
}
