//! A run through scenes of a seed: each is drawn, measured, written down, and kept and made smaller if it fails.

use std::collections::BTreeSet;
use std::io::IsTerminal as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use raindrops::files::write_whole;
use raindrops::scene::Scene;
use serde::{Deserialize, Serialize};

use super::bounds::Miss;
use super::folder::{Loaded, read, write};
use super::measure::{Asked, Hunt, Measured};
use super::row::{self, Row};
use super::shrink::shrink;
use super::sweep::Swept;
use super::trace::Tracing;
use super::{Means, keep, report, scene, scene_file};

/// One scene in so many is swept, and one in so many is drawn again to compare its bytes.
const SWEPT: u64 = 50;
const REPEATED: u64 = 10;

/// What a run is of, beside its rows.
const HEAD: &str = "run.json";

#[derive(Args)]
pub struct RunArgs {
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the first scene
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// How many scenes
    #[arg(long, value_name = "N", default_value_t = 100)]
    scenes: u64,
    /// Folder for what is found; one that holds a run of this commit and seed goes on
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// How many smaller scenes are tried where one fails, at most
    #[arg(long, value_name = "N", default_value_t = 8)]
    shrink: u32,
    #[command(flatten)]
    pub means: Means,
}

/// What all rows of a folder have in common.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
struct Head {
    seed: u64,
    commit: String,
    device: String,
    samples: u32,
    sweep_every: u64,
    bytes_every: u64,
}

impl Head {
    /// A line for a report.
    fn line(&self) -> String {
        let Self { seed, commit, device, samples, .. } = self;
        format!(
            "Seed {seed}, commit {commit}, {device}. References of up to {} samples a pixel. One scene of \
             {SWEPT} is swept in {} steps; one of {REPEATED} is drawn again for its bytes.",
            2 * samples,
            super::sweep::STEPS
        )
    }
}

/// Measures the scenes that the folder does not have yet.
pub fn run(hunt: &Hunt, args: &RunArgs) -> anyhow::Result<()> {
    let folder = &args.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let head = Head {
        seed: args.seed,
        commit: env!("RAINDROPS_COMMIT").into(),
        device: hunt.place.device.report.summary(),
        samples: args.means.samples,
        sweep_every: SWEPT,
        bytes_every: REPEATED,
    };
    let path = folder.join(HEAD);
    match path.exists() {
        true => {
            let there = read_head(folder)?;
            ensure!(
                there == head,
                "{} holds a run with another seed, commit, device or number of samples; choose another folder",
                folder.display()
            );
        }
        false => write_whole(&path, &serde_json::to_vec_pretty(&head)?)?,
    }
    let rows = row::read(folder)?;
    let done: BTreeSet<u64> = rows.iter().map(|row| row.number).collect();
    let missing: Vec<u64> =
        (args.first..args.first + args.scenes).filter(|number| !done.contains(number)).collect();
    let bar = progress(missing.len() as u64);
    for number in missing {
        let row = one_of_run(hunt, args, number)?;
        row::append(folder, &row)?;
        let said = line(&row);
        bar.set_message(said.clone());
        if bar.is_hidden() {
            eprintln!("{said}");
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    print!("{}", report(folder)?);
    Ok(())
}

/// A bar on a terminal; elsewhere a line a scene is printed.
fn progress(count: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} [{elapsed} < {eta}] {msg}");
    ProgressBar::new(count).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A scene in a line.
fn line(row: &Row) -> String {
    let what = match (&row.problem, row.worst()) {
        (Some(problem), _) => problem.clone(),
        (None, None) => "within the bounds".into(),
        (None, Some(Miss { model, figure, value, bound, .. })) => {
            format!("{model}: {figure} {value:.3} over {bound}")
        }
    };
    format!("scene {} ({:.0} s; {}): {what}", row.number, row.seconds, row.tags.join(", "))
}

/// Measures a scene of a run; what cannot be drawn is a row with its problem.
fn one_of_run(hunt: &Hunt, args: &RunArgs, number: u64) -> anyhow::Result<Row> {
    let made = scene::make(args.seed, number);
    let aside = tempfile::tempdir()?;
    write(&made, aside.path())?;
    let file = aside.path().join("scene.toml");
    let name = format!("{}-{number:05}", args.seed);
    let loaded = read(&file, &hunt.photographs)?;
    let sweep = (number % SWEPT == 7).then(|| Swept::of(&loaded.scene, number / SWEPT)).flatten();
    let asked = Asked { bytes: number % REPEATED == 3, sweep, ..Asked::default() };
    let outcome = catch_unwind(AssertUnwindSafe(|| hunt.measure(&name, &loaded, &asked)));
    let problem = match outcome {
        Ok(Ok(mut measured)) => {
            (measured.row.seed, measured.row.number) = (args.seed, number);
            if let Some(miss) = measured.row.worst() {
                let kept = keep::folder(&args.output, number);
                write(&made, &kept)?;
                keep::keep(&measured, &kept)?;
                if args.shrink > 0 && miss.figure != "step" {
                    let (text, _) = smaller(hunt, &loaded, &measured, &miss, args.shrink);
                    write_whole(&kept.join("small.toml"), text.as_bytes())?;
                }
            }
            return Ok(measured.row);
        }
        Ok(Err(problem)) if is_lost(&problem) => return Err(problem),
        Ok(Err(problem)) => format!("{problem:#}"),
        Err(_) => "it panicked".into(),
    };
    let kept = keep::folder(&args.output, number);
    write(&made, &kept)?;
    let tags = row::tags(&loaded.parsed);
    Ok(Row { seed: args.seed, number, tags, problem: Some(problem), ..Row::default() })
}

/// After that no other scene can be drawn.
fn is_lost(problem: &anyhow::Error) -> bool {
    problem.downcast_ref::<raindrops::Error>().is_some_and(raindrops::Error::is_lost)
}

/// The scene made smaller as long as it misses the same bound of the same model.
fn smaller(
    hunt: &Hunt,
    loaded: &Loaded,
    measured: &Measured,
    miss: &Miss,
    tries: u32,
) -> (String, u32) {
    let place = measured.picture(&miss.model).or(measured.pictures.first().map(|(_, p)| p));
    let place =
        place.map_or([0, 0], |picture| measured.halves.worst_place(picture, measured.exposure));
    let origin = loaded.scene.view().origin;
    let worst = [place[0] + origin[0], place[1] + origin[1]];
    // Less fine than at first: what is asked is whether it fails as well.
    let tracing = Tracing { kept: None, most_seconds: 3.0, ..hunt.tracing.clone() };
    let hunt = Hunt { tracing, ..hunt.clone() };
    let asked = Asked {
        bytes: miss.figure == "bytes",
        models: vec![miss.model.clone()],
        ..Asked::default()
    };
    shrink(&loaded.text, worst, tries, &mut |text| {
        let Ok(aside) = loaded.with_text(text, &hunt.photographs) else { return false };
        let outcome = catch_unwind(AssertUnwindSafe(|| hunt.measure("", &aside, &asked)));
        let Ok(Ok(found)) = outcome else { return false };
        let is_same = |other: &Miss| {
            other.counts() && (&other.model, &other.figure) == (&miss.model, &miss.figure)
        };
        found.row.misses().iter().any(is_same)
    })
}

/// Measures a scene file, prints its figures, and keeps them with the pictures.
pub fn measure_file(
    hunt: &Hunt,
    file: &Path,
    asked: &Asked,
    output: Option<&Path>,
) -> anyhow::Result<()> {
    let loaded = read(file, &hunt.photographs)?;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let measured = hunt.measure(&stem, &loaded, asked)?;
    if let Some(output) = output {
        keep::keep(&measured, output)?;
    }
    println!(
        "{}: {} samples, noise {:?}",
        file.display(),
        measured.row.samples,
        measured.row.noise
    );
    for (name, model) in &measured.row.models {
        println!("  {name}: {:?}, {:.0} ms; {}", model.figures, model.ms, model.models);
        if let Some(bytes) = &model.bytes {
            println!("    {bytes:?}");
        }
        if let Some(step) = &model.step {
            println!("    {step:?}");
        }
        model.warnings.iter().for_each(|warning| println!("    warning: {warning}"));
    }
    for miss in measured.row.misses() {
        println!("  over a bound: {miss:?}");
    }
    Ok(())
}

/// Makes a scene smaller that a run has kept.
pub fn shrink_kept(hunt: &Hunt, folder: &Path, tries: u32) -> anyhow::Result<()> {
    let loaded = read(&scene_file(folder), &hunt.photographs)?;
    let measured = hunt.measure("", &loaded, &Asked::default())?;
    let miss = measured.row.worst().context("the scene is within the bounds of single pictures")?;
    let (text, tried) = smaller(hunt, &loaded, &measured, &miss, tries);
    let path = folder.join("small.toml");
    Scene::parse(&text, &path.display().to_string())?;
    write_whole(&path, text.as_bytes())?;
    println!("{}: {tried} scenes tried; {} of {}", path.display(), miss.figure, miss.model);
    Ok(())
}

fn read_head(folder: &Path) -> anyhow::Result<Head> {
    let path = folder.join(HEAD);
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// The page of a run.
pub fn report(folder: &Path) -> anyhow::Result<String> {
    let head = read_head(folder)?;
    let mut rows = row::read(folder)?;
    rows.sort_by_key(|row| row.number);
    Ok(report::page(&rows, &head.line(), folder))
}
