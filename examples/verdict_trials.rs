//! How often a verdict is wrong, measured: comparisons on this machine whose true ratio is known. Run by
//! `scripts/verdict-trials.sh`, which builds the program to compare.
//!
//! Both sides are one program, which counts `FRAMES_A_SAMPLE` frames as one, so that the true ratio of times is
//! that of two whole numbers. A trial is a comparison by `bench --a … --b …` as anyone runs it; its tone-mapped
//! row counts. Kinds take turns, so that whatever else the machine does falls on all of them alike. The result is
//! written after each trial.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant, SystemTime};

use anyhow::Context as _;
use clap::Parser;
use raindrops::measure::Host;
use raindrops::measure::verdict::{Report, Verdict, VerdictRow};
use serde::Serialize;

/// Frames that side A counts as one.
const FRAMES: u32 = 10;

/// Measure how often verdicts are wrong
#[derive(Parser)]
struct Args {
    /// Program to compare with itself, built by scripts/verdict-trials.sh
    program: PathBuf,
    /// Result file (JSON)
    output: PathBuf,
    /// Trials of nothing, of a slowdown of 20 %, and of one of 10 %
    #[arg(long, value_delimiter = ',', default_value = "40,20,20")]
    trials: Vec<usize>,
    /// Begin no trial after this
    #[arg(long, default_value = "3h", value_parser = humantime::parse_duration)]
    max_time: Duration,
    /// Options of bench: what to draw
    #[arg(last = true)]
    options: Vec<String>,
}

/// A kind of trial.
#[derive(Clone, Debug, Serialize)]
struct Kind {
    true_ratio: f64,
    asked: usize,
    slower: usize,
    faster: usize,
    same: usize,
    undecided: usize,
    /// Whose interval does not hold the true ratio.
    missed: usize,
}

#[derive(Serialize)]
struct Trial {
    true_ratio: f64,
    start: String,
    /// Load averages of the last minute before and after.
    load: [Option<f64>; 2],
    seconds: f64,
    verdict: Verdict,
    ratio: Option<f64>,
    ratio_low: Option<f64>,
    ratio_high: Option<f64>,
    rounds: usize,
    noise_floor: Option<f64>,
    rounds_ms_a: Vec<f64>,
    rounds_ms_b: Vec<f64>,
}

#[derive(Serialize)]
struct Results {
    schema: &'static str,
    device: String,
    host: Host,
    start: String,
    options: Vec<String>,
    row: String,
    threshold: f64,
    kinds: Vec<Kind>,
    trials: Vec<Trial>,
}

fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}

/// One comparison, with B's frames of a sample.
fn compare(args: &Args, frames: u32, folder: &Path) -> anyhow::Result<Report> {
    let json = folder.join("verdict.json");
    let output = Command::new(&args.program)
        .args(["bench", "--a", &format!("FRAMES_A_SAMPLE={FRAMES}")])
        .args(["--b", &format!("FRAMES_A_SAMPLE={frames}")])
        .args(&args.options)
        .arg("--json")
        .arg(&json)
        .output()
        .with_context(|| format!("{} does not start", args.program.display()))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        anyhow::bail!("a trial failed: {}", said.lines().last().unwrap_or_default());
    }
    Ok(serde_json::from_slice(&std::fs::read(&json)?)?)
}

fn write(results: &Results, path: &Path) -> anyhow::Result<()> {
    let aside = path.with_extension("part");
    std::fs::write(&aside, serde_json::to_string(results)? + "\n")?;
    Ok(std::fs::rename(&aside, path)?)
}

impl Kind {
    fn new(frames: u32, asked: usize) -> Self {
        let true_ratio = f64::from(frames) / f64::from(FRAMES);
        Self { true_ratio, asked, slower: 0, faster: 0, same: 0, undecided: 0, missed: 0 }
    }

    fn done(&self) -> usize {
        self.slower + self.faster + self.same + self.undecided
    }

    fn count(&mut self, row: &VerdictRow) {
        *match row.verdict {
            Verdict::Slower => &mut self.slower,
            Verdict::Faster => &mut self.faster,
            Verdict::Same => &mut self.same,
            Verdict::Undecided | Verdict::Different => &mut self.undecided,
        } += 1;
        let holds = |(low, high)| (low..=high).contains(&self.true_ratio);
        let missed = row.ratio_low.zip(row.ratio_high).is_some_and(|interval| !holds(interval));
        self.missed += usize::from(missed);
    }

    fn line(&self) -> String {
        format!(
            "B takes {:.2} times as long: {} trials, {} slower, {} faster, {} same, {} undecided; {} intervals miss",
            self.true_ratio,
            self.done(),
            self.slower,
            self.faster,
            self.same,
            self.undecided,
            self.missed
        )
    }
}

fn main() -> anyhow::Result<ExitCode> {
    let args = Args::parse();
    let [null, twenty, ten] = args.trials.as_slice() else {
        anyhow::bail!("--trials takes three numbers, such as 40,20,20");
    };
    let folder = tempfile::tempdir()?;
    let start = Instant::now();
    let mut results = Results {
        schema: "raindrops-verdict-trials/1",
        device: String::new(),
        host: Host::now(),
        start: now(),
        options: args.options.clone(),
        row: String::new(),
        threshold: 0.0,
        kinds: vec![Kind::new(FRAMES, *null), Kind::new(12, *twenty), Kind::new(11, *ten)],
        trials: Vec::new(),
    };
    let all: usize = args.trials.iter().sum();
    while start.elapsed() < args.max_time {
        // The kind of which the least part is done.
        let part = |kind: &&mut Kind| kind.done() as f64 / kind.asked as f64;
        let open = results.kinds.iter_mut().filter(|kind| kind.done() < kind.asked);
        let Some(kind) = open.min_by(|a, b| part(a).total_cmp(&part(b))) else { break };
        let (began, at, load) = (Instant::now(), now(), Host::now().load);
        let frames = (kind.true_ratio * f64::from(FRAMES)).round() as u32;
        let report = compare(&args, frames, folder.path())?;
        let row = report.rows.into_iter().find(|row| row.tone_map).context("no row")?;
        kind.count(&row);
        results.device = report.a.device.summary();
        results.threshold = report.threshold;
        eprintln!(
            "{} of {all}, {:.0} s, {}: {} after {} rounds, {:.3} ({:.3} to {:.3})",
            results.trials.len() + 1,
            start.elapsed().as_secs_f64(),
            kind.true_ratio,
            row.verdict.name(),
            row.rounds,
            row.ratio.unwrap_or(f64::NAN),
            row.ratio_low.unwrap_or(f64::NAN),
            row.ratio_high.unwrap_or(f64::NAN)
        );
        results.trials.push(Trial {
            true_ratio: kind.true_ratio,
            start: at,
            load: [load, Host::now().load],
            seconds: began.elapsed().as_secs_f64(),
            verdict: row.verdict,
            ratio: row.ratio,
            ratio_low: row.ratio_low,
            ratio_high: row.ratio_high,
            rounds: row.rounds,
            noise_floor: row.noise_floor,
            rounds_ms_a: row.rounds_ms_a,
            rounds_ms_b: row.rounds_ms_b,
        });
        results.row = row.name;
        write(&results, &args.output)?;
    }
    results.kinds.iter().for_each(|kind| println!("{}", kind.line()));
    // What is claimed, as parts of what was asked.
    let [null, twenty, _] = results.kinds.as_slice() else { anyhow::bail!("three kinds") };
    let holds = (null.slower + null.faster) * 40 <= null.done().max(40)
        && twenty.slower * 20 >= twenty.done() * 19
        && twenty.faster == 0;
    Ok(ExitCode::from(u8::from(!holds)))
}
