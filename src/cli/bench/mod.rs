//! `raindrops bench`: frame rates of a scene, or the paper's Table II, on this machine's Vulkan devices.

mod compare;
mod google;
mod long;
mod table;

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use anyhow::Context as _;
use clap::{ArgMatches, Args};

use self::table::{plain, table};
use super::aliases::Aliases;
use super::device::{DeviceArgs, choose_device, devices, expected_costs, open_device, resolve};
use super::format::Format;
use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::{SceneValues, parse_drops};
use super::verdict::gate::GateArgs;
use super::{Answer, parse_seconds, print, progress, say_doubt, write_json};
use crate::cli::tell::{about, failure, note, say, warning};
use crate::environment::Environment;
use crate::files::write_whole;
use crate::gpu::disk_cache::KeptDevice;
use crate::measure::bench::{
    Amount, Build, DeviceHead, Effort, Report, Row, SCHEMA, Variant, measure, plot,
};
use crate::measure::{Host, Watch};
use crate::plan::{Output, expected_ms, plan, plan_by};
use crate::rain::cull::count_visible;
use crate::rain::field::Field;
use crate::scene::model::{Operator, Preset};
use crate::scene::{ModelChoice, RainSettings, Scene};
use crate::thousands::counted;

/// Measure frame rates: of a scene, or the paper's Table II
#[derive(Args)]
#[command(
    mut_arg("device", |arg| arg.help(
        "Vulkan device: a part of its name or driver, or its index in `raindrops devices`; `all`: every device in turn"
    )),
    after_help = "Examples:
  raindrops bench --preset paper,fast --drops 125000
  raindrops bench assets/scenes/steady-rain.toml --json result.json
  raindrops bench --drops 125000 --b LP_NUM_THREADS=1

Table II with two presets takes some four minutes on two CPU cores; --drops 125000 takes seconds.
How to use --a, --b and --baseline: docs/drivers.md."
)]
pub struct BenchArgs {
    /// Scene file (TOML) [default: the paper's benchmark scene]
    scene: Option<PathBuf>,
    /// Numbers of random drops, comma-separated: 125k,4M [default: the scene's own; without a scene
    /// the paper's 125000 to 4000000]
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = parse_drops)]
    drops: Vec<u32>,
    /// Rates of real rain in mm/h, comma-separated, in place of numbers of drops
    #[arg(
        long,
        value_name = "MM_H,…",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "drops"
    )]
    rain: Vec<f64>,
    /// Presets to measure in turn, comma-separated [default: the scene's; without a scene paper]
    #[arg(long, value_enum, value_name = "NAME,…", value_delimiter = ',')]
    preset: Vec<Preset>,
    /// Seconds to measure a row, or longer for --min-frames [default: 2; in rounds 0.2]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    seconds: Option<f64>,
    /// Measure at least this many frames of a row, for at most ten times --seconds [default: 12; in rounds 2]
    #[arg(long, alias = "frames", value_name = "N")]
    min_frames: Option<usize>,
    /// Measure one row for this long without a break (90s, 15m, 1h): frame time, memory and the device's clock over
    /// time, in the result file and as --svg
    #[arg(long, value_name = "TIME", value_parser = long::parse_duration, allow_hyphen_values = true,
          conflicts_with_all = ["seconds", "min_frames", "a", "b", "a_binary", "b_binary", "baseline", "rounds"])]
    duration: Option<Duration>,
    /// Write the figures in the JSON of google/benchmark
    #[arg(long, value_name = "FILE")]
    google_benchmark: Option<PathBuf>,
    /// Plot frames a second by number of drops as SVG, beside the paper's three machines; with --duration what was
    /// measured over time
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    values: SceneValues,
    #[command(flatten)]
    model: Aliases<ModelChoice>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    gate: GateArgs,
    #[command(flatten)]
    compare: compare::CompareArgs,
}

/// The paper's numbers of drops.
const TABLE_II: [u32; 6] = [125_000, 250_000, 500_000, 1_000_000, 2_000_000, 4_000_000];

/// Runs the command; `given` is the whole command line, of which other processes get a part.
pub fn run(args: &BenchArgs, given: &ArgMatches) -> anyhow::Result<Answer> {
    let given = given.subcommand_matches("bench").context("the command is bench")?;
    let mut scene = args.values.load(args.scene.as_deref())?;
    scene.model = args.model.set_in(scene.model)?;
    for amount in args.series().into_iter().flatten() {
        let mut scene = scene.clone();
        amount.apply(&mut scene)?;
        scene.validate("command line")?;
    }
    args.gate.check()?;
    super::check_folders([&args.google_benchmark, &args.svg])?;
    let is_all = args.device.device.as_deref() == Some("all");
    if is_all && args.svg.is_some() {
        anyhow::bail!("--svg draws one device; choose it by --device");
    }
    if is_all && args.google_benchmark.is_some() {
        anyhow::bail!("--google-benchmark writes one device; choose it by --device");
    }
    args.compare.check(given, &args.gate)?;
    if args.compare.is_asked() {
        return compare::run(args, &scene, given);
    }
    if let Some(duration) = args.duration {
        return long::run(args, &scene, duration);
    }
    if scene.tone_map.operator == Operator::None {
        note!("the tone-mapped rows clip instead of compressing (operator none)");
    }
    let mut presets = args.preset.clone();
    if presets.is_empty() {
        // Without a scene the benchmark is the paper's table, by the paper's method.
        // It has no real rain.
        let usual = if args.rain.is_empty() { Preset::Paper } else { Preset::Fast };
        presets.push(args.scene.as_ref().map_or(usual, |_| scene.model.preset));
    }
    let is_papers = is_papers(&scene);
    let environment = super::open_environment(&scene)?;

    let instance = args.device.instance()?;
    let chosen = match args.device.device.as_deref() {
        Some("all") => devices(&instance)?,
        wanted => vec![choose_device(&instance, wanted)?],
    };
    heed_interrupts()?;
    let (mut reports, mut failed) = (Vec::new(), None);
    let mut answer = Answer::Yes;
    for device in chosen {
        if !device.missing.is_empty() {
            say!("left out: {} lacks {}", device.name, device.missing.join(", "));
            continue;
        }
        let device = open_device(&instance, device)?;
        let (report, why) = bench(args, &device, &scene, &presets, &environment);
        failed = why;
        if report.rows.is_empty() {
            break;
        }
        if !report.rows.iter().all(Row::passes_add_up) {
            note!("the driver's times of the passes do not add up to the frames; trust the frames");
        }
        if !check_counts(&scene, &report)? {
            answer = Answer::No;
        }
        reports.push(report);
        if failed.is_some() {
            break;
        }
    }
    if reports.is_empty() {
        let why = || {
            anyhow::anyhow!("--device all: no device has all that is needed; see raindrops devices")
        };
        return Err(failed.unwrap_or_else(why));
    }
    match reports.as_slice() {
        [one] if !is_all => write(args, is_papers, one, reports.iter())?,
        all => write(args, is_papers, &all, all.iter())?,
    }
    if let (Some(path), [report]) = (&args.svg, reports.as_slice()) {
        write_whole(path, plot(report)?.as_bytes())?;
    }
    if let Some(error) = failed {
        return Err(error);
    }
    instance.expect_silence()?;
    Ok(answer)
}

/// Whether published rates are of this scene, its number of drops apart.
fn is_papers(scene: &Scene) -> bool {
    let (mut plain, mut papers) = (scene.clone(), Scene::default());
    plain.model = papers.model;
    (plain.rain, papers.rain) = (plain.rain.map(uncounted), papers.rain.map(uncounted));
    plain == papers
}

/// Rain but for its count.
fn uncounted(rain: RainSettings) -> RainSettings {
    RainSettings { count: 0, ..rain }
}

impl BenchArgs {
    /// How much rain to measure; none: that of the scene.
    fn series(&self) -> Vec<Option<Amount>> {
        let drops = |counts: &[u32]| counts.iter().map(|n| Some(Amount::Drops(*n))).collect();
        match (self.rain.as_slice(), self.drops.as_slice(), &self.scene) {
            ([], [], Some(_)) => vec![None],
            ([], [], None) => drops(&TABLE_II),
            ([], counts, _) => drops(counts),
            (rates, ..) => rates.iter().map(|rate| Some(Amount::Rate(*rate))).collect(),
        }
    }
}

/// Writes the result file, and prints the rows of each device in the form that was asked for.
fn write<'a>(
    args: &BenchArgs,
    is_papers: bool,
    file: &impl serde::Serialize,
    reports: impl Iterator<Item = &'a Report> + Clone,
) -> anyhow::Result<()> {
    args.gate.write_json(file)?;
    for report in reports.clone() {
        write_json(args.google_benchmark.as_ref(), &google::google_benchmark(report))?;
    }
    if args.gate.is_json() {
        return Ok(());
    }
    for (number, report) in reports.enumerate() {
        match args.gate.format {
            Format::Csv => print(plain(report, number == 0))?,
            Format::Markdown => {
                let lines = [report.device.summary(), host_line(report)];
                let lines = lines
                    .into_iter()
                    .chain(report.warnings.iter().map(|w| format!("warning: {w}")));
                lines.map(|line| format!("- {line}")).try_for_each(print)?;
                let rows = table(&report.rows, is_papers, args.gate.format);
                print(format_args!("\n{rows}\n"))?;
            }
            Format::Table | Format::Json => {
                let rows = table(&report.rows, is_papers, args.gate.format);
                print(format_args!("{}\n{rows}", report.device.summary()))?;
                print(host_line(report))?;
                print(start_line(report))?;
            }
        }
    }
    Ok(())
}

/// The report of a measurement that begins now, without rows; says what makes its figures doubtful.
fn begun(device: &KeptDevice, environment: &Environment) -> Report {
    let host = Host::now();
    let warnings: Vec<String> = host.doubt().into_iter().collect();
    warnings.iter().for_each(|warning| warning!("{warning}"));
    Report {
        schema: SCHEMA.into(),
        device: DeviceHead::of(&device.report),
        build: Build::this(),
        host,
        start: Some(humantime::format_rfc3339_seconds(SystemTime::now()).to_string()),
        command: Some(super::command_line()),
        warnings,
        environment: environment.name().into(),
        pipeline_cache_bytes: device.bytes_found(),
        rows: Vec::new(),
    }
}

/// Every count with every preset, with and without tone mapping; if that fails or is interrupted, what was measured until
/// then, and why there is no more.
fn bench(
    args: &BenchArgs,
    device: &KeptDevice,
    scene: &Scene,
    presets: &[Preset],
    environment: &Environment,
) -> (Report, Option<anyhow::Error>) {
    let (mut report, watch) = (begun(device, environment), Watch::start());
    let series = args.series();
    let effort = Effort {
        seconds: args.seconds.unwrap_or(2.0),
        frames: args.min_frames.unwrap_or(12),
        stop: is_interrupted,
    };
    say_expected(device, scene, presets, &series, environment, effort);
    let bar = progress(100 * series.len() as u64, "%");
    let start = report.start.clone();
    let of_amount =
        |number: usize, amount: Option<Amount>| -> anyhow::Result<(Vec<Row>, Vec<String>)> {
            bar.set_message(match amount {
                Some(Amount::Rate(rate)) => format!("{rate} mm/h"),
                Some(Amount::Drops(count)) => counted(count.into(), "drop"),
                None => counted(scene.drop_count().into(), "drop"),
            });
            let mut variants = Vec::new();
            for preset in presets {
                let mut scene = scene.clone();
                scene.model.take_preset(*preset);
                if let Some(amount) = amount {
                    amount.apply(&mut scene)?;
                }
                scene.validate("command line")?;
                let choice = bar.suspend(|| resolve(device, &scene, environment))?;
                for output in [Output::Display, Output::Radiance] {
                    let plan = plan_by(&scene, environment, choice.as_ref(), output)?;
                    if output == Output::Display {
                        bar.suspend(|| say_doubt(&plan));
                    }
                    variants.push(Variant { plan, scene: scene.clone() });
                }
            }
            let tick = |share: f64| bar.set_position(((number as f64 + share) * 100.0) as u64);
            let measured = measure(device, environment, &variants, effort, &tick)?;
            let all = variants.iter().zip(&measured);
            let (mut rows, mut doubts) = (Vec::new(), Vec::new());
            for (variant, of) in all {
                let row = Row::new(variant, environment, of, start.clone());
                doubts.extend(of.doubts.iter().map(|doubt| format!("{}: {doubt}", row.name())));
                rows.push(row);
            }
            bar.suspend(|| doubts.iter().for_each(|doubt| warning!("{doubt}")));
            Ok((rows, doubts))
        };
    let (mut rows, mut failed) = (Vec::new(), None);
    for (number, amount) in series.into_iter().enumerate() {
        match of_amount(number, amount) {
            Ok((found, doubts)) => {
                rows.extend(found);
                report.warnings.extend(doubts);
            }
            Err(error) => failed = Some(error),
        }
        if is_interrupted() {
            failed = Some(Interrupted.into());
        }
        if failed.is_some() {
            break;
        }
    }
    bar.finish_and_clear();
    report.rows = rows;
    report.ended(watch.others());
    report.host.others_doubt().iter().for_each(|warning| warning!("{warning}"));
    (report, failed)
}

/// Says how long the rows will take, by the times that are kept of the device.
fn say_expected(
    device: &KeptDevice,
    scene: &Scene,
    presets: &[Preset],
    series: &[Option<Amount>],
    environment: &Environment,
    effort: Effort,
) {
    let Some(costs) = expected_costs(&device.report) else { return };
    // A row that cannot be drawn is refused when its turn comes.
    let of_row = |amount: &Option<Amount>, preset: &Preset| -> crate::Result<f64> {
        let mut scene = scene.clone();
        scene.model.take_preset(*preset);
        amount.map_or(Ok(()), |amount| amount.apply(&mut scene))?;
        let plan = plan(&scene, environment, Output::Radiance)?;
        Ok(effort.expected_s(expected_ms(&scene, environment, &costs, &plan)))
    };
    let pairs = series.iter().flat_map(|amount| presets.iter().map(move |preset| (amount, preset)));
    let seconds: f64 =
        pairs.clone().filter_map(|(amount, preset)| of_row(amount, preset).ok()).sum();
    let lines = counted(pairs.count() as u64, "measurement");
    note!(
        "{lines}, each with tone mapping and without it: about {} (by times of {})",
        about(2.0 * seconds),
        costs.of
    );
}

fn host_line(report: &Report) -> String {
    let host = &report.host;
    let load = host.load.map_or(String::new(), |load| format!(", load {load} as it began"));
    let (width, height) = report.rows.first().map_or((0, 0), |row| (row.width, row.height));
    format!(
        "{width} x {height}, environment {}; {} ({}{load}{}), {}; raindrops {} {} {}",
        report.environment,
        host.cpu,
        counted(host.cores as u64, "core"),
        host.settings(),
        host.os,
        report.build.version,
        report.build.commit,
        report.build.profile
    )
}

/// What each preset takes until its first picture, with the most drops that were measured.
fn start_line(report: &Report) -> String {
    let most = report.rows.iter().max_by(|a, b| a.along().total_cmp(&b.along()));
    let Some(most) = most else { return String::new() };
    let starts: Vec<String> = report
        .rows
        .iter()
        .filter(|row| row.tone_map && row.along() == most.along())
        .map(|row| {
            let steps = row.setup.iter().map(|(name, ms)| format!("{name} {ms:.0}"));
            let steps = steps.collect::<Vec<_>>().join(", ");
            let (setup, first) = (row.setup_ms, row.first_frame_ms);
            format!("{} {setup:.0} ms ({steps}) + {first:.0} ms", row.preset)
        })
        .collect();
    let pipelines = match report.pipeline_cache_bytes {
        0 => "no compiled pipelines kept".into(),
        bytes => format!("{bytes} bytes of compiled pipelines"),
    };
    let drops = if most.rate_mm_h.is_some() { "" } else { " drops" };
    format!("set-up + first frame, {}{drops}, {pipelines}: {}", most.amount(), starts.join("; "))
}

/// The drops in view, counted by the GPU, against the CPU's count of the same.
fn check_counts(scene: &Scene, report: &Report) -> anyhow::Result<bool> {
    let mut agree = true;
    for row in report.rows.iter().filter(|row| row.tone_map && row.simulation == "integer") {
        let mut scene = scene.clone();
        let placed = scene.placed_count();
        // To a scene without random drops none are to be added.
        if row.rate_mm_h.is_some() || row.drops > placed || scene.rain.is_some() {
            Amount::of_row(row.drops, row.rate_mm_h, placed).apply(&mut scene)?;
        }
        let of_rain = Field::of(&scene).zip(row.cutoff_px);
        let expected = count_visible(&scene)
            + of_rain.map_or(0, |(field, cutoff_px)| {
                let thinned_px =
                    row.axes.get("thinned_px").and_then(|px| px.as_f64()).unwrap_or(0.0);
                field.thinned(&scene, thinned_px).count_visible(&scene, cutoff_px)
            });
        if row.visible != expected {
            failure!(
                "{} of {} drops in view on the GPU, {expected} by the CPU's count",
                row.visible,
                row.drops
            );
            agree = false;
        }
    }
    Ok(agree)
}
