//! `bench` in rounds of fresh processes: two environments or two binaries in turn, or this device against a
//! kept result.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use clap::{ArgMatches, Args, CommandFactory as _};
use indexmap::IndexSet;

use super::BenchArgs;
use crate::cli::interrupt::heed_interrupts;
use crate::cli::rounds::environment::{Variables, parse};
use crate::cli::rounds::pictures::{Eye, PictureFolder};
use crate::cli::rounds::process::Arm;
use crate::cli::rounds::{Bound, Work, alone, passed_on, take_turns};
use crate::cli::tell::{note, warning};
use crate::cli::verdict::gate::{GateArgs, MAX_FLIP, parse_flip};
use crate::cli::verdict::{notes, of_runs, runs, side};
use crate::cli::{Answer, Cli, command_line, open_environment, progress};
use crate::files::whole_path;
use crate::measure::bench::{Amount, Report as Kept};
use crate::measure::verdict::looks::looks;
use crate::measure::verdict::{self, Method, MissingRow, Side, kept};
use crate::scene::Scene;
use crate::scene::model::Preset;

/// Rounds that a result is kept with.
const KEPT_ROUNDS: usize = 10;
/// Rounds of a comparison in turn, at most.
const MOST_ROUNDS: usize = 40;

/// What is compared, and for how long.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Comparison, in rounds of fresh processes")]
pub struct CompareArgs {
    /// Environment variables of side A: NAME=VALUE,… (quote a value with commas) [default: as they are]
    #[arg(long, value_name = "ENV=VALUE,…", value_parser = variables)]
    a: Option<Shared>,
    /// Environment variables of side B
    #[arg(long, value_name = "ENV=VALUE,…", value_parser = variables)]
    b: Option<Shared>,
    /// Program of side A [default: this one]
    #[arg(long, value_name = "FILE")]
    a_binary: Option<PathBuf>,
    /// Program of side B [default: this one]
    #[arg(long, value_name = "FILE")]
    b_binary: Option<PathBuf>,
    /// Compare with a kept result of this device, or with several of different times, comma-separated
    #[arg(long, value_name = "FILE,…", value_delimiter = ',',
          conflicts_with_all = ["a", "b", "a_binary", "b_binary"])]
    baseline: Vec<PathBuf>,
    /// Fresh processes for each side [default: at most 40 in turn, else 10]; without a side, `--rounds 10 --json FILE`
    /// makes a baseline
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    rounds: Option<u16>,
    /// Begin no round that would end later than this: 90s, 15m, 1h
    #[arg(long, value_name = "TIME", default_value = "15m", value_parser = humantime::parse_duration)]
    max_time: Duration,
    /// End a process that takes longer, with an error
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = humantime::parse_duration)]
    timeout: Duration,
    /// Write the pictures of both sides and their difference into this folder, as PNG; report shows them
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// A row is `different`, whatever its times, if the mean FLIP between its two pictures is over this
    #[arg(long, value_name = "X", default_value_t = MAX_FLIP, value_parser = parse_flip)]
    max_flip: f64,
    /// Also find the error of both pictures against the truth, traced with this many samples a pixel
    #[arg(long = "truth-samples", alias = "reference", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    reference: Option<u32>,
}

/// Clap takes a `Vec` for several values of an option, and this is one.
type Shared = std::sync::Arc<Variables>;

fn variables(text: &str) -> Result<Shared, String> {
    parse(text).map(Shared::new)
}

/// Options that are this process's alone, not of those that it starts, besides those of the comparison and its gate.
const OWN: [&str; 6] = ["drops", "rain", "seconds", "min_frames", "svg", "google_benchmark"];

/// The ids of all options that are this process's alone.
fn own() -> Vec<String> {
    let compared = CompareArgs::augment_args(clap::Command::new("compared"));
    let compared = GateArgs::augment_args(compared);
    let ids = compared.get_arguments().map(|argument| argument.get_id().to_string());
    ids.chain(OWN.map(String::from)).collect()
}

impl CompareArgs {
    /// Whether this is more than one measurement in this process.
    pub fn is_asked(&self) -> bool {
        self.is_in_turn() || !self.baseline.is_empty() || self.rounds.is_some()
    }

    /// Refuses options that were given without what they are for.
    pub fn check(&self, given: &ArgMatches, gate: &GateArgs) -> anyhow::Result<()> {
        let stray = |options: &[(&str, &'static str)]| {
            let is_given = |(id, _): &&(&str, &str)| {
                given.value_source(id) == Some(clap::parser::ValueSource::CommandLine)
            };
            options.iter().find(is_given).map(|(_, option)| *option)
        };
        if gate.is_asked() && !self.is_in_turn() && self.baseline.is_empty() {
            anyhow::bail!(
                "--threshold, --fail-above, --fail-undecided, --fail-missing, --junit and --expect are for --baseline, --a, --b, --a-binary and --b-binary"
            );
        }
        let of_rounds = [("max_time", "--max-time"), ("timeout", "--timeout")];
        if let (false, Some(option)) = (self.is_asked(), stray(&of_rounds)) {
            anyhow::bail!(
                "{option} is for rounds of fresh processes: --rounds, --baseline, --a, --b, --a-binary and --b-binary"
            );
        }
        let of_pictures = [
            ("max_flip", "--max-flip"),
            ("reference", "--truth-samples"),
            ("pictures", "--pictures"),
        ];
        if let (false, Some(option)) = (self.is_in_turn(), stray(&of_pictures)) {
            anyhow::bail!("{option} is for two sides in turn: --a, --b, --a-binary, --b-binary");
        }
        Ok(())
    }

    fn is_in_turn(&self) -> bool {
        self.a.is_some() || self.b.is_some() || self.a_binary.is_some() || self.b_binary.is_some()
    }

    fn arm(&self, is_b: bool) -> anyhow::Result<Arm> {
        let (variables, binary) =
            if is_b { (&self.b, &self.b_binary) } else { (&self.a, &self.a_binary) };
        // Windows' programs have an ending, which nobody types.
        let ended = binary.as_ref().map(|path| {
            let mut ended = path.clone().into_os_string();
            ended.push(if path.is_file() { "" } else { std::env::consts::EXE_SUFFIX });
            PathBuf::from(ended)
        });
        let program = match &ended {
            None => std::env::current_exe().context("this program's file is not known")?,
            Some(path) if path.is_file() => {
                whole_path(path).with_context(|| format!("{}", path.display()))?
            }
            Some(path) => anyhow::bail!("{}: there is no such program", path.display()),
        };
        let variables = variables.as_deref().cloned().unwrap_or_default();
        let mut parts: Vec<String> = Vec::new();
        parts.extend(binary.as_ref().map(|path| path.display().to_string()));
        parts.extend(variables.iter().map(|(name, value)| format!("{name}={value}")));
        let label = if parts.is_empty() { "this program".into() } else { parts.join(" ") };
        Ok(Arm { label, program, variables, options: Vec::new() })
    }
}

/// Runs the comparison; `given` are the options of `bench`.
pub fn run(args: &BenchArgs, scene: &Scene, given: &ArgMatches) -> anyhow::Result<Answer> {
    let compare = &args.compare;
    if args.device.device.as_deref() == Some("all") {
        anyhow::bail!("rounds are of one device; choose it by --device, or use compare-devices");
    }
    if args.svg.is_some() {
        anyhow::bail!(
            "--svg is for a measurement without rounds; report makes pages of result files"
        );
    }
    if args.google_benchmark.is_some() && (compare.is_in_turn() || !compare.baseline.is_empty()) {
        anyhow::bail!(
            "--google-benchmark writes one measurement: give it with --rounds, then compare by raindrops verdict"
        );
    }
    let bases = runs(&compare.baseline)?;
    let command = Cli::command();
    let command = command.find_subcommand("bench").context("there is no command bench")?;
    let mut own = own();
    let mut work = Work {
        arguments: passed_on(command, given, &own),
        series: args.series().into_iter().flatten().collect(),
        placed: scene.placed_count(),
        timeout: compare.timeout,
    };
    work.arguments.push(format!("--seconds={}", args.seconds.unwrap_or(0.2)).into());
    work.arguments.push(format!("--frames={}", args.min_frames.unwrap_or(2)).into());
    if let ([(_, base), ..], None) = (bases.as_slice(), &args.scene) {
        of_baseline(args, base, &mut work);
    }
    heed_interrupts()?;
    let most = humantime::format_duration(compare.max_time);
    note!("rounds of fresh processes, for at most {most} and one round (--max-time)");
    if compare.is_in_turn() {
        // `render` gets another for each picture.
        own.push("preset".into());
        in_turn(args, scene, &work, passed_on(command, given, &own))
    } else {
        against(args, scene, &work, &bases)
    }
}

/// Without a scene and values of its own, what the baseline measured is measured again.
fn of_baseline(args: &BenchArgs, base: &Kept, work: &mut Work) {
    if args.drops.is_empty() && args.rain.is_empty() {
        work.series.clear();
        for row in &base.rows {
            let amount = Amount::of_row(row.drops, row.rate_mm_h, 0);
            if !work.series.contains(&amount) {
                work.series.push(amount);
            }
        }
    }
    if args.preset.is_empty() {
        let all: IndexSet<&str> = base.rows.iter().map(|row| row.preset.as_str()).collect();
        let all: Vec<&str> = all.into_iter().collect();
        work.arguments.push(format!("--preset={}", all.join(",")).into());
    }
}

/// Whether a row of the baseline was to be measured: options that choose amounts or presets leave out the others.
fn is_asked(args: &BenchArgs, work: &Work, row: &MissingRow) -> bool {
    let is_preset = |preset: &Preset| preset.name() == row.preset;
    let is_amount = work.series.is_empty()
        || work.series.contains(&Amount::of_row(row.drops, row.rate_mm_h, work.placed));
    is_amount && (args.preset.is_empty() || args.preset.iter().any(is_preset))
}

/// Two arms in turn, then their pictures.
fn in_turn(
    args: &BenchArgs,
    scene: &Scene,
    work: &Work,
    of_pictures: Vec<OsString>,
) -> anyhow::Result<Answer> {
    let compare = &args.compare;
    let (a, b) = (compare.arm(false)?, compare.arm(true)?);
    let most = compare.rounds.map_or(MOST_ROUNDS, usize::from);
    let threshold = args.gate.threshold();
    if looks(most)[0].rank == 0 {
        note!("with fewer than six rounds there is no interval, and nothing is decided");
    }
    let bar = progress(most as u64, "rounds");
    // Each is one frame where a round has eight or more.
    let bound = Bound { end: compare.max_time, pictures: 0.5 };
    let fits = |of_b: &Kept| args.gate.fits(&of_b.device);
    let mut turns = take_turns([&a, &b], work, most, threshold, bound, &bar, &fits);
    let mut seen = false;
    if turns.failed.is_none() {
        let environment = open_environment(scene)?;
        let result = args.gate.json.as_deref();
        let eye = Eye {
            scene,
            environment: &environment,
            arguments: of_pictures,
            is_series: !work.series.is_empty(),
            max_flip: compare.max_flip,
            reference: compare.reference,
            kept: compare.pictures.as_deref().map(|path| PictureFolder { path, result }),
            timeout: work.timeout,
        };
        let say = |what: &str| bar.set_message(what.to_string());
        match eye.look([&a, &b], &mut turns.rows, &say) {
            Ok(()) => seen = true,
            Err(error) => turns.failed = Some(error),
        }
    }
    bar.finish_and_clear();
    let report = turns.report([&a, &b], threshold, seen.then_some(compare.max_flip));
    let Some(report) = report else {
        return Err(turns.failed.unwrap_or_else(|| anyhow::anyhow!("nothing was measured")));
    };
    let answer = args.gate.tell(report)?;
    turns.failed.map_or(Ok(answer), Err)
}

/// Rounds of this program alone: a result to keep, or to hold against one that was kept.
fn against(
    args: &BenchArgs,
    scene: &Scene,
    work: &Work,
    bases: &[(PathBuf, Kept)],
) -> anyhow::Result<Answer> {
    let rounds = args.compare.rounds.map_or(KEPT_ROUNDS, usize::from);
    let bar = progress(rounds as u64, "rounds");
    let (arm, time) = (args.compare.arm(false)?, args.compare.max_time);
    let threshold = args.gate.threshold();
    let name = "this measurement";
    let rows = |new: &Kept| kept(bases, &[(name.into(), new.clone())], true, threshold);
    // Before the other rounds; without a baseline there are no rows, and all fits.
    let fits = |first: &Kept| {
        rows(first)?;
        args.gate.fits(&first.device)
    };
    let (found, failed) = alone(&arm, work, rounds, time, &bar, &fits);
    bar.finish_and_clear();
    let Some(mut found) = found else {
        return Err(failed.unwrap_or_else(|| anyhow::anyhow!("nothing was measured")));
    };
    found.warnings.iter().for_each(|warning| warning!("{warning}"));
    // Not that of its first process.
    found.command = Some(command_line());
    if bases.is_empty() {
        super::write(args, super::is_papers(scene), &found, std::iter::once(&found))?;
        return failed.map_or(Ok(Answer::Yes), Err);
    }
    let sides = [side(bases), Side::of(name, &found)];
    let (notes, mut missing) = notes(&of_runs(bases), &[&found]);
    missing.retain(|row| is_asked(args, work, row));
    let report = verdict::Report {
        missing,
        command: Some(command_line()),
        stopped: failed.as_ref().map(|error| format!("{error:#}")),
        ..verdict::Report::of(Method::Unpaired, sides, threshold, notes, rows(&found)?)
    };
    let answer = args.gate.tell(report)?;
    failed.map_or(Ok(answer), Err)
}
