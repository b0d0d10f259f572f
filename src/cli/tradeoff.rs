//! `raindrops tradeoff`: every model's time and error.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::{DeviceArgs, SceneArgs};
use super::tell::{about, line, say};
use super::{Answer, parse_seconds, print_beside, progress, write_json};
use crate::files::write_whole;
use crate::gpu::disk_cache::user_folder;
use crate::measure::Host;
use crate::measure::bench::{self, Build, DeviceHead};
use crate::measure::costs::kept;
use crate::measure::tradeoff::{
    BASES, Effort, Report, Row, SCHEMA, StudyScene, csv, models, models_of, models_of_rain,
    of_file, plot, standard_set, study, table, weather,
};
use crate::plan::{Output, expected_ms, plan};
use crate::scene::Scene;
use crate::thousands::counted;

/// Measure every model's time and error
#[derive(Args)]
#[command(
    mut_arg("scene", |arg| arg.help("Scene file (TOML) [default: eight scenes, see below]")),
    after_help = "The eight scenes: close-up (one drop), near (hundreds), far (a million), sun, low range, pan (flicker), weather (real rain),\n\
                  lens (the same, out of focus).\n\
                  They take a quarter of an hour on two CPU cores; --models and --drops 20000 --size 256x256 take less."
)]
pub struct TradeoffArgs {
    /// Samples a pixel of the truth
    #[arg(long, value_name = "N", default_value_t = 128,
          value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    truth_samples: u32,
    /// Only models whose names contain one of these, comma-separated, and the two with which all are compared
    #[arg(long, value_name = "TEXT,…", value_delimiter = ',')]
    models: Vec<String>,
    /// Seconds to time a model, or longer for --min-frames
    #[arg(long, value_name = "S", default_value_t = 0.3, value_parser = parse_seconds)]
    seconds: f64,
    /// Time at least this many frames of a model, for at most ten times --seconds
    #[arg(long, alias = "frames", value_name = "N", default_value_t = 5)]
    min_frames: usize,
    /// Write the rows as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the rows as comma-separated values
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Plot error over time as SVG, with the Pareto front
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &TradeoffArgs) -> anyhow::Result<Answer> {
    for path in [&args.json, &args.csv, &args.svg].into_iter().flatten() {
        super::check_folder(path)?;
    }
    let scenes = if args.scene.is_default() {
        let mut set = standard_set()?;
        set.extend(weather()?);
        set
    } else {
        let scene = args.scene.load()?;
        let environment = super::open_environment(&scene)?;
        vec![of_file(&args.scene.name(), scene, environment)]
    };
    let all: Vec<_> = models().into_iter().chain(models_of_rain()).collect();
    let holds = |name: &str, text: &String| name.contains(text.as_str());
    if let Some(text) = args.models.iter().find(|text| !all.iter().any(|m| holds(&m.name, text))) {
        anyhow::bail!("--models {text}: no model's name contains that; docs/results lists them");
    }
    let wanted =
        |name: &str| args.models.is_empty() || args.models.iter().any(|text| holds(name, text));
    // The speed of every other model is relative to the first two.
    let of_scene = |scene: &StudyScene| -> Vec<_> {
        let all = models_of(&scene.frames[0]).into_iter().enumerate();
        all.filter(|(number, model)| *number < BASES || wanted(&model.name))
            .map(|(_, model)| model)
            .collect()
    };
    let device = args.device.open()?;
    let host = Host::now();
    let effort = Effort {
        time: bench::Effort {
            seconds: args.seconds,
            frames: args.min_frames,
            stop: is_interrupted,
        },
        truth_samples: args.truth_samples,
    };
    let count: usize = scenes.iter().map(|scene| of_scene(scene).len()).sum();
    let costs = kept(&device.report, user_folder().as_deref(), line).unwrap_or_default();
    let times: f64 = scenes
        .iter()
        .flat_map(|scene| of_scene(scene).into_iter().map(move |model| (scene, model)))
        .filter_map(|(scene, model)| {
            let first = Scene { model: model.choice, ..scene.frames[0].clone() };
            let plan = plan(&first, &scene.environment, Output::Display).ok()?;
            let ms = expected_ms(&first, &scene.environment, &costs, &plan);
            Some(effort.time.expected_s(ms))
        })
        .sum();
    // The truth and the pictures take about half as long again.
    say!(
        "note: {} of {}, about {} (by times of {})",
        counted(count as u64, "model"),
        counted(scenes.len() as u64, "scene"),
        about(1.5 * times),
        costs.of
    );
    heed_interrupts()?;
    let bar = progress(100 * scenes.len() as u64, "%");
    let mut rows = Vec::new();
    for (number, scene) in scenes.iter().enumerate() {
        let say = |what: &str, share: f64| {
            bar.set_message(format!("{}: {what}", scene.name));
            bar.set_position(((number as f64 + share) * 100.0) as u64);
        };
        let found = study(&device, scene, &of_scene(scene), effort, &say)?;
        if let Some(Row { width, height, .. }) = found.first() {
            bar.suspend(|| {
                print_beside(
                    args.json.as_ref(),
                    format_args!("{}: {}, {width} x {height}", scene.name, scene.asks),
                )?;
                print_beside(args.json.as_ref(), format_args!("{}\n", table(&found)))
            })?;
        }
        rows.extend(found);
        if is_interrupted() {
            break;
        }
    }
    bar.finish_and_clear();
    print_beside(
        args.json.as_ref(),
        "* no other model is both quicker and truer (by rms); speed: as a multiple of paper's, and of paper-compact's; \
         with real rain of fast's, and of exact's",
    )?;
    let failed = (is_interrupted() && rows.len() < count).then(|| {
        let done = format!("{} of {} finished", rows.len(), counted(count as u64, "row"));
        anyhow::Error::from(Interrupted).context(done)
    });
    if rows.is_empty()
        && let Some(error) = failed
    {
        return Err(error);
    }
    let report = Report {
        schema: SCHEMA,
        command: Some(super::command_line()),
        device: DeviceHead::of(&device.report),
        build: Build::this(),
        host,
        truth_samples: args.truth_samples,
        stopped: failed.as_ref().map(|error| format!("{error:#}")),
        rows,
    };
    if let Some(path) = &args.json {
        write_json(path, &report)?;
    }
    if let Some(path) = &args.csv {
        let mut text = Vec::new();
        csv(&report.rows, &mut text)?;
        write_whole(path, &text)?;
    }
    if let Some(path) = &args.svg {
        write_whole(path, plot(&report)?.as_bytes())?;
    }
    if let Some(error) = failed {
        return Err(error);
    }
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}
