//! `raindrops compare-devices`: one scene on several drivers, how long each takes, how far apart their
//! pictures are, and from which stage on.
//!
//! Pictures and stages are drawn in this process, times come from rounds of fresh ones: each device in turn
//! with the first, a verdict each.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context as _;
use clap::Args;
use serde_json::{Value, json};

use super::format::{Format, Sheet};
use super::interrupt::heed_interrupts;
use super::options::{ModelArgs, SceneArgs, choose_device, devices, open_device, resolve};
use super::rounds::pictures::PictureFolder;
use super::rounds::process::{Arm, Limits};
use super::rounds::stages::paper_stages;
use super::rounds::{Bound, Work, take_turns};
use super::tell::say;
use super::verdict::gate::{GateArgs, MAX_FLIP, parse_flip};
use super::verdict::notes;
use super::verdict::table::{sheet, tail_lines};
use super::{Answer, command_line, print, progress};
use crate::environment::Environment;
use crate::gpu::{Device, DeviceReport, Instance, Validation};
use crate::measure::bench::drivers::{Apart, FEW, apart, difference};
use crate::measure::bench::{DeviceHead, Report as Kept};
use crate::measure::verdict::{self, Method, Side};
use crate::picture::Picture;
use crate::picture::flip::PIXELS_PER_DEGREE;
use crate::picture::metrics::compare;
use crate::picture::plate::Plate;
use crate::picture::tone_map::{Exposure, exposure_of};
use crate::plan::{Output, plan_by};
use crate::reference::{Tracer, Truth};
use crate::renderer::Renderer;
use crate::renderer::stages::Stages;
use crate::scene::Scene;
use crate::thousands::thousands;

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
            "{} is the only device, and there is nothing to compare it with; scripts/setup.sh --drivers fetches more, \
             VK_DRIVER_FILES, --device and RAINDROPS_DEVICE select",
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
    let times = Times { args, scene: &scene, instance: &instance, portraits: &portraits };
    let (mut verdicts, failed) = times.measure()?;
    let pictures =
        Pictures { portraits: &portraits, truth: truth.as_ref(), exposure, stages: &stages };
    pictures.judge(&mut verdicts, args.max_flip.unwrap_or(MAX_FLIP));
    if let Some(path) = &args.pictures {
        let folder = PictureFolder { path, result: args.gate.json.as_deref() };
        pictures.keep(&mut verdicts, &folder)?;
    }
    verdicts.iter_mut().try_for_each(|verdict| args.gate.settle(&mut verdict.report))?;
    let (table, rows, worst) = pictures.figures(&verdicts, args.gate.format);
    show(args, &table, &stages, &verdicts)?;
    let pairs: Vec<_> =
        stages.iter().map(|(a, b, apart)| json!({ "a": a, "b": b, "stages": apart })).collect();
    let verdict_rows: Vec<_> = verdicts
        .iter()
        .map(|Compared { device, report }| json!({ "a": 0, "b": device, "verdict": report }))
        .collect();
    let schema = "raindrops-compare-devices/1";
    let file =
        json!({ "schema": schema, "devices": rows, "pairs": pairs, "verdicts": verdict_rows });
    args.gate.write_json(&file)?;
    if let Some(error) = failed {
        return Err(error);
    }
    let reports: Vec<&verdict::Report> = verdicts.iter().map(|verdict| &verdict.report).collect();
    let answer = args.gate.judge(&reports)?;
    if args.max_flip.is_some_and(|most| worst > most) {
        say!("raindrops: two drivers are FLIP {worst:.5} apart");
        return Ok(Answer::No);
    }
    Ok(answer)
}

/// Two devices, and how far the stages of their frames are apart.
type Pair = (usize, usize, Vec<Apart>);

fn stages_apart(portraits: &[Portrait]) -> Vec<Pair> {
    let mut stages = Vec::new();
    for (b, other) in portraits.iter().enumerate() {
        for (a, one) in portraits[..b].iter().enumerate() {
            let (Some(one), Some(other)) = (&one.stages, &other.stages) else { continue };
            stages.push((a, b, apart((&one.0, &one.1), (&other.0, &other.1))));
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
        for verdict in verdicts {
            let b = verdict.device;
            for row in &mut verdict.report.rows {
                let flip = difference(&portraits[0].picture, &portraits[b].picture, *exposure).0;
                row.see(flip, max_flip);
                if let Some(truth) = truth {
                    let error = |of: &Portrait| {
                        Some(compare(truth, &of.picture, None, *exposure).pixels.rms())
                    };
                    (row.error_a, row.error_b) = (error(&portraits[0]), error(&portraits[b]));
                }
                let apart = stages.iter().find(|(one, other, _)| (*one, *other) == (0, b));
                let differing = apart.and_then(|(.., apart)| apart.iter().find(|a| a.differs()));
                row.first_stage_that_differs = differing.map(|apart| apart.stage.into());
            }
        }
    }

    /// Writes the pictures, and enters their files into the verdicts.
    fn keep(&self, verdicts: &mut [Compared], folder: &PictureFolder<'_>) -> anyhow::Result<()> {
        for Compared { device, report } in verdicts {
            let [a, b] = [0, *device].map(|number| &self.portraits[number].picture);
            let found = compare(a, b, None, self.exposure);
            let written = folder.write(
                &format!("device-{device}"),
                [a, b],
                &found.flip_map,
                self.exposure,
            )?;
            for row in &mut report.rows {
                row.pictures = Some(written.clone());
            }
        }
        Ok(())
    }

    /// A row a device, for the eye and for the result file, and the largest FLIP between two.
    fn figures(&self, verdicts: &[Compared], format: Format) -> (Sheet, Vec<Value>, f64) {
        let Self { portraits, truth, exposure, .. } = self;
        let mut table = Sheet {
            names: 1,
            header: vec!["device".into(), "ms".into(), "in view".into()],
            rows: vec![],
        };
        table.header.extend((0..portraits.len()).map(|n| format!("FLIP to {n}")));
        table.header.extend(truth.is_some().then(|| "FLIP to truth".to_string()));
        let mut rows = Vec::new();
        let mut worst = 0.0f64;
        for (number, portrait) in portraits.iter().enumerate() {
            let differences: Vec<(f64, f64)> = portraits
                .iter()
                .map(|other| difference(&other.picture, &portrait.picture, *exposure))
                .collect();
            worst = differences.iter().map(|(flip, _)| *flip).fold(worst, f64::max);
            let from_truth = truth.map(|truth| difference(truth, &portrait.picture, *exposure));
            let median_ms = median_of(number, verdicts);
            let mut cells = vec![
                format!("{number}: {}", DeviceHead::of(&portrait.report).summary()),
                median_ms.map_or("-".into(), |ms| format!("{ms:.1}")),
                match format {
                    Format::Csv => portrait.visible.to_string(),
                    _ => thousands(portrait.visible),
                },
            ];
            cells.extend(
                differences.iter().chain(&from_truth).map(|(flip, _)| format!("{flip:.5}")),
            );
            table.rows.push(cells);
            rows.push(json!({
                "device": DeviceHead::of(&portrait.report),
                "median_ms": median_ms,
                "visible": portrait.visible,
                "flip": differences.iter().map(|(flip, _)| flip).collect::<Vec<_>>(),
                "rel_mse": differences.iter().map(|(_, rel_mse)| rel_mse).collect::<Vec<_>>(),
                "flip_to_truth": from_truth.map(|(flip, _)| flip),
                "rel_mse_to_truth": from_truth.map(|(_, rel_mse)| rel_mse),
            }));
        }
        (table, rows, worst)
    }
}

/// Prints everything in the form that was asked for.
fn show(
    args: &CompareDevicesArgs,
    table: &Sheet,
    stages: &[Pair],
    verdicts: &[Compared],
) -> anyhow::Result<()> {
    let format = args.gate.format;
    match format {
        _ if args.gate.is_json() => {}
        Format::Csv if !verdicts.is_empty() => print(plain(verdicts).text(format))?,
        _ => {
            print(table.text(format))?;
            // In Markdown an empty line ends a table, and indented lines would be one.
            let (gap, item) =
                if format == Format::Markdown { ("\n", "\n- ") } else { ("", "\n   ") };
            for (a, b, apart) in stages {
                let stages = tell(apart).replace("\n   ", item);
                print(format_args!("{gap}{a} and {b}: {stages}"))?;
            }
            for Compared { device, report } in verdicts {
                print(format_args!(
                    "{gap}A is 0, B is {device}: times of fresh processes in turn{gap}"
                ))?;
                print(sheet(report, format).text(format))?;
                tail_lines(report, format).into_iter().try_for_each(print)?;
            }
        }
    }
    Ok(())
}

/// The devices that were asked for, or all that will do.
fn chosen(
    args: &CompareDevicesArgs,
    instance: &Arc<Instance>,
) -> anyhow::Result<Vec<DeviceReport>> {
    // A variable may be set to nothing.
    let mut named = args.device.iter().filter(|name| !name.is_empty()).peekable();
    if named.peek().is_some() {
        let all = named.map(|name| choose_device(instance, Some(name)));
        return Ok(all.collect::<Result<_, _>>()?);
    }
    let (sound, lacking): (Vec<_>, Vec<_>) =
        devices(instance)?.into_iter().partition(|report| report.missing.is_empty());
    for report in lacking {
        say!("left out: {} lacks {}", report.name, report.missing.join(", "));
    }
    Ok(sound)
}

/// A device's verdict against the first.
struct Compared {
    device: usize,
    report: verdict::Report,
}

/// What the times are measured of.
struct Times<'a> {
    args: &'a CompareDevicesArgs,
    scene: &'a Scene,
    instance: &'a Arc<Instance>,
    portraits: &'a [Portrait],
}

impl Times<'_> {
    /// Each device in turn with the first; what was measured before something failed is kept.
    fn measure(&self) -> anyhow::Result<(Vec<Compared>, Option<anyhow::Error>)> {
        let args = self.args;
        let mut verdicts = Vec::new();
        heed_interrupts()?;
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let (scene, path) = (self.scene, folder.path().join("scene.toml"));
        scene.save(&path)?;
        let listed = devices(self.instance)?;
        let threshold = args.gate.threshold();
        let program = std::env::current_exe().context("this program's file is not known")?;
        let arm = |number: usize| {
            let shown = &self.portraits[number].report;
            // By its place in the list: names of two versions of a driver, or of two cards, may be alike.
            let index = listed.iter().position(|report| report.is_of_same_device(shown));
            let options =
                index.map(|index| format!("--device={index}").into()).into_iter().collect();
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
            placed: scene.drops.len() as u32,
            limits: Limits { timeout: args.timeout },
        };
        let each = args.max_time / (self.portraits.len() as u32 - 1);
        for device in 1..self.portraits.len() {
            let (a, b) = (arm(0), arm(device));
            let bar = progress(args.rounds.into(), "rounds");
            let bound = Bound { end: each, pictures: 0.0 };
            let fits = |of_b: &Kept| args.gate.fits(&of_b.device);
            let turns =
                take_turns([&a, &b], &work, args.rounds.into(), threshold, bound, &bar, &fits);
            bar.finish_and_clear();
            if let Some([of_a, of_b]) = &turns.reports {
                let sides = [Side::of(&a.label, of_a), Side::of(&b.label, of_b)];
                let notes = notes(of_a, of_b);
                let report = verdict::Report {
                    command: Some(command_line()),
                    max_flip: Some(args.max_flip.unwrap_or(MAX_FLIP)),
                    flip_pixels_per_degree: Some(PIXELS_PER_DEGREE),
                    stopped: turns.stopped,
                    ..verdict::Report::of(Method::Paired, sides, threshold, notes, turns.rows)
                };
                verdicts.push(Compared { device, report });
            }
            if turns.failed.is_some() {
                return Ok((verdicts, turns.failed));
            }
        }
        Ok((verdicts, None))
    }
}

/// Every row of every verdict, after its two devices' names.
fn plain(verdicts: &[Compared]) -> Sheet {
    let mut all = Sheet { names: 1, header: Vec::new(), rows: Vec::new() };
    for Compared { report, .. } in verdicts {
        let Sheet { header, rows, .. } = sheet(report, Format::Csv);
        let names = || [&report.a.label, &report.b.label].map(String::clone).into_iter();
        all.header = ["a", "b"].map(String::from).into_iter().chain(header).collect();
        all.rows.extend(rows.into_iter().map(|row| names().chain(row).collect::<Vec<_>>()));
    }
    all
}

/// Milliseconds of a device's tone-mapped frame, over its rounds.
fn median_of(device: usize, verdicts: &[Compared]) -> Option<f64> {
    let of = |compared: &Compared| {
        let row = compared.report.rows.iter().find(|row| row.tone_map)?;
        match device {
            0 => Some(row.median_ms_a),
            _ => (compared.device == device).then_some(row.median_ms_b),
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

/// The stages of the paper's frame, and the first that differs.
fn tell(apart: &[Apart]) -> String {
    let stage = |apart: &Apart| {
        let Apart { stage, unit, tolerance, share, alone, largest } = apart;
        let off = 100.0 * (share - alone);
        let mut line = format!("\n   {stage:<10}");
        if *share == 0.0 {
            line += &format!(" none off by over {tolerance} {unit}");
        } else {
            line += &format!(" {off:.4} % off by over {tolerance} {unit}");
        }
        if *alone > 0.0 {
            line += &format!(", {:.4} % drawn by one alone", 100.0 * alone);
        }
        // As many digits as it takes: a difference is never shown as none.
        if *largest > 0.0 {
            line += &format!(", largest {largest:.1e}");
        }
        line
    };
    let few = 100.0 * FEW;
    let first = match apart.iter().find(|apart| apart.differs()) {
        Some(first) => format!("the first stage to differ is the {}", first.stage),
        None if apart.iter().any(Apart::strays) => {
            format!("no stage differs by more than rounding in over {few} % of its pixels")
        }
        None => "no stage differs by more than rounding".into(),
    };
    format!("{first}{}", apart.iter().map(stage).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said agrees with the figures beside it.
    #[test]
    fn stages_do_not_contradict_themselves() {
        let of = |share: f64, alone: f64, largest: f64| {
            let apart =
                Apart { stage: "footprint", unit: "px", tolerance: 0.01, share, alone, largest };
            tell(&[apart])
        };
        assert!(of(0.0, 0.0, 0.0).contains("none off") && !of(0.0, 0.0, 0.0).contains("largest"));
        assert!(of(0.0, 0.0, 0.003).starts_with("no stage differs by more than rounding\n"));
        assert!(of(0.0005, 0.0, 0.4675).contains("in over 0.1 % of its pixels"));
        let alone = of(0.0005, 0.0005, 0.0);
        assert!(
            alone.contains("0.0500 % drawn by one alone") && !alone.contains("largest"),
            "{alone}"
        );
        assert!(of(0.5, 0.0, 2e-5).contains("largest 2.0e-5"));
    }
}
