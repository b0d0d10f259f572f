//! `raindrops compare-devices`: one scene on several drivers, how long each takes, how far apart their
//! pictures are, and from which stage on.
//!
//! Pictures and stages are drawn in this process, times come from rounds of fresh ones: each device in turn
//! with the first, a verdict each.

pub mod table;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context as _;
use clap::Args;

use super::device::{choose_device, devices, open_device, resolve};
use super::interrupt::heed_interrupts;
use super::options::{ModelArgs, SceneArgs};
use super::rounds::pictures::PictureFolder;
use super::rounds::process::Arm;
use super::rounds::stages::paper_stages;
use super::rounds::{Bound, Work, take_turns};
use super::tell::{failure, say};
use super::verdict::gate::{GateArgs, MAX_FLIP, parse_flip};
use super::{Answer, progress};
use crate::environment::Environment;
use crate::gpu::{Device, DeviceReport, Instance, Validation};
use crate::measure::bench::{DeviceHead, Report as Kept};
use crate::measure::drivers::{Compared, DeviceRow, Pair, Report, SCHEMA, apart, difference};
use crate::measure::verdict;
use crate::picture::Picture;
use crate::picture::metrics::compare;
use crate::picture::plate::Plate;
use crate::picture::tone_map::{Exposure, exposure_of};
use crate::plan::{Output, plan_by};
use crate::reference::{Tracer, Truth};
use crate::renderer::Renderer;
use crate::renderer::stages::Stages;
use crate::scene::Scene;

/// Compare this machine's drivers on one scene: times, pictures
#[derive(Args)]
pub struct CompareDevicesArgs {
    /// Devices, comma-separated: parts of their names or drivers, or indices in `raindrops devices`; the
    /// others are compared with the first [default: all]
    #[arg(
        long,
        value_name = "NAME|INDEX,…",
        value_delimiter = ',',
        env = "RAINDROPS_DEVICE",
        hide_env_values = true
    )]
    device: Vec<String>,
    /// Also compare with the truth, traced with this many samples a pixel
    #[arg(long, alias = "truth", value_name = "N")]
    truth_samples: Option<u32>,
    /// Seconds to measure in each process, or longer for --min-frames
    #[arg(long, value_name = "S", default_value_t = 0.2, value_parser = super::parse_seconds)]
    seconds: f64,
    /// Measure at least this many frames, for at most ten times --seconds
    #[arg(long, alias = "frames", value_name = "N", default_value_t = 2)]
    min_frames: usize,
    /// Rounds of fresh processes for each pair of devices, at most
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=1000))]
    rounds: u16,
    /// Begin no round that would end later than this: 90s, 15m, 1h
    #[arg(long, value_name = "TIME", default_value = "2m", value_parser = humantime::parse_duration)]
    max_time: Duration,
    /// End a process that takes longer, with an error
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = humantime::parse_duration)]
    timeout: Duration,
    /// Exit with status 1 if the mean FLIP of two drivers is over this; their verdict is then `different`
    /// [default for the verdict: 0.01]
    #[arg(long, value_name = "X", value_parser = parse_flip)]
    max_flip: Option<f64>,
    /// Keep the pictures as PNG in this folder: the first device's, each other's and their difference in false colours
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    gate: GateArgs,
}

/// A scene on one driver.
struct Portrait {
    report: DeviceReport,
    visible: u64,
    picture: Picture,
    /// The paper's frame, which alone has stages, and its picture.
    stages: Option<(Stages, Picture)>,
}

/// Runs the command.
pub fn run(args: &CompareDevicesArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    args.gate.check()?;
    let environment = super::open_environment(&scene)?;
    let instance = Instance::new(Validation::Off)?;
    let chosen = chosen(args, &instance)?;
    if let [only] = chosen.as_slice() {
        anyhow::bail!(
            "{} is the only device that is there or selected, and there is nothing to compare it with; scripts/setup.sh --drivers fetches \
             more (Debian, Ubuntu), VK_DRIVER_FILES, --device and RAINDROPS_DEVICE select",
            DeviceHead::of(only).summary()
        );
    }
    let mut portraits = Vec::new();
    for report in chosen {
        let device = open_device(&instance, report)?;
        portraits.push(portray(&device, &scene, &environment)?);
    }
    let [first, ..] = portraits.as_slice() else { return Err(crate::Error::NoDevice.into()) };
    let exposure = exposure_of(&scene.tone_map, &first.picture);
    let plate = Plate::of(&scene)?;
    let truth = args.truth_samples.map(|samples| {
        let truth = Truth { samples, ..Truth::default() };
        Tracer::new(&scene, &environment, truth).before(plate.clone()).picture()
    });

    let stages = stages_apart(&portraits);
    let (mut verdicts, failed) = measure(args, &scene, &instance, &portraits)?;
    let pictures =
        Pictures { portraits: &portraits, truth: truth.as_ref(), exposure, stages: &stages };
    pictures.judge(&mut verdicts, args.max_flip.unwrap_or(MAX_FLIP));
    if let Some(path) = &args.pictures {
        let folder = PictureFolder { path, result: args.gate.json.as_deref() };
        pictures.keep(&mut verdicts, &folder)?;
    }
    verdicts.iter_mut().try_for_each(|of| args.gate.settle(&mut of.verdict))?;
    let devices = pictures.rows(&verdicts);
    let file = Report { schema: SCHEMA.into(), devices, pairs: stages, verdicts };
    table::show(&file, &args.gate)?;
    args.gate.write_json(&file)?;
    if let Some(error) = failed {
        return Err(error);
    }
    let reports: Vec<&verdict::Report> = file.verdicts.iter().map(|of| &of.verdict).collect();
    let answer = args.gate.judge(&reports, args.max_flip.is_some())?;
    Ok(if are_alike(&file, args.max_flip) { answer } else { Answer::No })
}

/// Whether no two devices' pictures are farther apart than that; where they are, says so.
pub fn are_alike(report: &Report, max_flip: Option<f64>) -> bool {
    let largest = report.largest_flip();
    let is_over = max_flip.is_some_and(|most| largest > most);
    if is_over {
        failure!("two drivers are FLIP {largest:.5} apart");
    }
    !is_over
}

fn stages_apart(portraits: &[Portrait]) -> Vec<Pair> {
    let mut stages = Vec::new();
    for (b, other) in portraits.iter().enumerate() {
        for (a, one) in portraits[..b].iter().enumerate() {
            let (Some(one), Some(other)) = (&one.stages, &other.stages) else { continue };
            let apart = apart((&one.0, &one.1), (&other.0, &other.1));
            stages.push(Pair { a, b, stages: apart });
        }
    }
    stages
}

/// The pictures of all devices.
struct Pictures<'a> {
    portraits: &'a [Portrait],
    truth: Option<&'a Picture>,
    exposure: Exposure,
    stages: &'a [Pair],
}

impl Pictures<'_> {
    /// Enters into the verdicts what pictures say.
    fn judge(&self, verdicts: &mut [Compared], max_flip: f64) {
        let Self { portraits, truth, exposure, stages } = self;
        for Compared { b, verdict, .. } in verdicts {
            let b = *b;
            for row in &mut verdict.rows {
                let flip = difference(&portraits[0].picture, &portraits[b].picture, *exposure).0;
                row.see(flip, max_flip);
                if let Some(truth) = truth {
                    let error = |of: &Portrait| {
                        Some(compare(truth, &of.picture, None, *exposure).pixels.rms())
                    };
                    (row.error_a, row.error_b) = (error(&portraits[0]), error(&portraits[b]));
                }
                let pair = stages.iter().find(|pair| (pair.a, pair.b) == (0, b));
                let differing = pair.and_then(|pair| pair.stages.iter().find(|a| a.differs()));
                row.first_stage_that_differs = differing.map(|apart| apart.stage.to_string());
            }
        }
    }

    /// Writes the pictures, and enters their files into the verdicts.
    fn keep(&self, verdicts: &mut [Compared], folder: &PictureFolder<'_>) -> anyhow::Result<()> {
        for Compared { b: device, verdict, .. } in verdicts {
            let [a, b] = [0, *device].map(|number| &self.portraits[number].picture);
            let found = compare(a, b, None, self.exposure);
            let written = folder.write(
                &format!("device-{device}"),
                [a, b],
                &found.flip_map,
                self.exposure,
            )?;
            for row in &mut verdict.rows {
                row.pictures = Some(written.clone());
            }
        }
        Ok(())
    }

    /// A row a device.
    fn rows(&self, verdicts: &[Compared]) -> Vec<DeviceRow> {
        let Self { portraits, truth, exposure, .. } = self;
        let row = |(number, portrait): (usize, &Portrait)| {
            let to = |of: &Picture| difference(of, &portrait.picture, *exposure);
            let (flip, rel_mse) = portraits.iter().map(|other| to(&other.picture)).unzip();
            let (flip_to_truth, rel_mse_to_truth) = truth.map(to).unzip();
            DeviceRow {
                device: DeviceHead::of(&portrait.report),
                median_ms: median_of(number, verdicts),
                visible: portrait.visible,
                flip,
                rel_mse,
                flip_to_truth,
                rel_mse_to_truth,
            }
        };
        portraits.iter().enumerate().map(row).collect()
    }
}

/// The devices that were asked for, or all that will do.
fn chosen(
    args: &CompareDevicesArgs,
    instance: &Arc<Instance>,
) -> anyhow::Result<Vec<DeviceReport>> {
    // A variable may be set to nothing.
    let mut named = args.device.iter().filter(|name| !name.is_empty()).peekable();
    if named.peek().is_some() {
        let mut all: Vec<(&String, DeviceReport)> = Vec::new();
        for name in named {
            let report = choose_device(instance, Some(name))?;
            // Who names a device twice by one word asks how far it is from itself.
            let is_other = |(other, known): &&(&String, DeviceReport)| {
                *other != name && known.is_of_same_device(&report)
            };
            if let Some((other, _)) = all.iter().find(is_other) {
                let device = DeviceHead::of(&report).summary();
                anyhow::bail!(
                    "--device: '{other}' and '{name}' are both {device}; give more of a name, or an index"
                );
            }
            all.push((name, report));
        }
        return Ok(all.into_iter().map(|(_, report)| report).collect());
    }
    let (sound, lacking): (Vec<_>, Vec<_>) =
        devices(instance)?.into_iter().partition(|report| report.missing.is_empty());
    for report in lacking {
        say!("left out: {} lacks {}", report.name, report.missing.join(", "));
    }
    Ok(sound)
}

/// Times of each device in turn with the first; what was measured before something failed is kept.
fn measure(
    args: &CompareDevicesArgs,
    scene: &Scene,
    instance: &Arc<Instance>,
    portraits: &[Portrait],
) -> anyhow::Result<(Vec<Compared>, Option<anyhow::Error>)> {
    let mut verdicts = Vec::new();
    heed_interrupts()?;
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let path = folder.path().join("scene.toml");
    scene.save(&path)?;
    let listed = devices(instance)?;
    let threshold = args.gate.threshold();
    let program = std::env::current_exe().context("this program's file is not known")?;
    let arm = |number: usize| {
        let shown = &portraits[number].report;
        // By its place in the list: names of two versions of a driver, or of two cards, may be alike.
        let index = listed.iter().position(|report| report.is_of_same_device(shown));
        let options = index.map(|index| format!("--device={index}").into()).into_iter().collect();
        let label = DeviceHead::of(shown).summary();
        Arm { label, program: program.clone(), variables: vec![], options }
    };
    let work = Work {
        arguments: vec![
            path.into(),
            format!("--seconds={}", args.seconds).into(),
            format!("--frames={}", args.min_frames).into(),
        ],
        series: Vec::new(),
        placed: scene.placed_count(),
        timeout: args.timeout,
    };
    let each = args.max_time / (portraits.len() as u32 - 1);
    for device in 1..portraits.len() {
        let (a, b) = (arm(0), arm(device));
        let bar = progress(args.rounds.into(), "rounds");
        let bound = Bound { end: each, pictures: 0.0 };
        let fits = |of_b: &Kept| args.gate.fits(&of_b.device);
        let turns = take_turns([&a, &b], &work, args.rounds.into(), threshold, bound, &bar, &fits);
        bar.finish_and_clear();
        let max_flip = args.max_flip.unwrap_or(MAX_FLIP);
        let verdict = turns.report([&a, &b], threshold, Some(max_flip));
        verdicts.extend(verdict.map(|verdict| Compared { a: 0, b: device, verdict }));
        if turns.failed.is_some() {
            return Ok((verdicts, turns.failed));
        }
    }
    Ok((verdicts, None))
}

/// Milliseconds of a device's tone-mapped frame, over its rounds.
fn median_of(device: usize, verdicts: &[Compared]) -> Option<f64> {
    let of = |compared: &Compared| {
        let row = compared.verdict.rows.iter().find(|row| row.tone_map)?;
        match device {
            0 => Some(row.median_ms_a),
            _ => (compared.b == device).then_some(row.median_ms_b),
        }
    };
    verdicts.iter().find_map(of)
}

fn portray(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> anyhow::Result<Portrait> {
    // The models that its times are of, too.
    let choice = resolve(device, scene, environment)?;
    let plan = plan_by(scene, environment, choice.as_ref(), Output::Radiance)?;
    let mut renderer = Renderer::new(device, scene, environment, &plan)?;
    let visible = renderer.draw(scene)?.counts.visible;
    let picture = renderer.read_radiance()?;
    let stages = paper_stages(device, scene, environment)?;
    Ok(Portrait { report: device.report.clone(), visible, picture, stages })
}
