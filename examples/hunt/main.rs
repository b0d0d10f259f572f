//! Hunts for pictures that are wrong to an eye: random scenes by `fast`, `auto` and `exact`, held against the reference.
//! `cargo run --release --example hunt -- run --scenes 100 -o hunted`, 40 minutes on two cores. See `docs/hunt.md`.

mod bounds;
mod bytes;
mod drops;
mod figures;
mod folder;
mod keep;
mod measure;
mod models;
mod random;
mod report;
mod row;
mod run;
mod scene;
mod shrink;
mod skies;
mod sweep;
mod text;
mod trace;

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::{Args, Parser, Subcommand};
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::plan::Costs;
use raindrops::scene::model::Preset;

use bytes::Child;
use measure::{Asked, Hunt};
use models::{Model, Place};
use run::RunArgs;
use sweep::Swept;
use trace::{Tracing, fingerprint};

/// Hunt for pictures that are wrong to an eye
#[derive(Parser)]
struct Command {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Draw random scenes, hold them against the reference, keep those that fail; goes on where a run ended
    Run(RunArgs),
    /// Measure one scene of a seed, keep it whether it fails or not
    One(OneArgs),
    /// Measure scene files
    File(FileArgs),
    /// Make a scene that was kept smaller, as small.toml beside it
    Shrink(ShrinkArgs),
    /// Print what a run has found, as Markdown
    Report {
        /// Folder of the run
        folder: PathBuf,
    },
    /// Draw a scene file, for another process of this program
    #[command(hide = true)]
    Picture(PictureArgs),
}

/// How everything is drawn and traced.
#[derive(Args, Clone)]
struct Means {
    /// Samples a pixel of each half of a reference, at most
    #[arg(long, value_name = "K", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,
    /// Seconds of processor time that a reference may take, more or less
    #[arg(long, value_name = "S", default_value_t = 24.0)]
    seconds: f64,
    /// Folder where references are kept; another commit's run takes them from there
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
}

#[derive(Args, Clone)]
struct DeviceArgs {
    /// Folder of the photographs that scripts/setup.sh fetches
    #[arg(long, value_name = "DIR", default_value = "assets/environments")]
    photographs: PathBuf,
    /// Vulkan device: a part of its name or driver
    #[arg(long, value_name = "NAME", env = "RAINDROPS_DEVICE")]
    device: Option<String>,
}

#[derive(Args)]
struct OneArgs {
    /// Seed of the run
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the scene
    #[arg(long)]
    number: u64,
    /// Also sweep this parameter
    #[arg(long, value_enum)]
    sweep: Option<Swept>,
    /// Also compare the bytes of other runs
    #[arg(long)]
    bytes: bool,
    /// Folder for the scene, its figures and its pictures
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    means: Means,
}

#[derive(Args)]
struct FileArgs {
    /// Scene files
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Also sweep this parameter
    #[arg(long, value_enum)]
    sweep: Option<Swept>,
    /// Also compare the bytes of other runs
    #[arg(long)]
    bytes: bool,
    /// Folder for figures and pictures, a folder a scene
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    means: Means,
}

#[derive(Args)]
struct ShrinkArgs {
    /// Folder of the scene, as a run has kept it
    folder: PathBuf,
    /// How many smaller scenes are tried, at most
    #[arg(long, value_name = "N", default_value_t = 200)]
    tries: u32,
    #[command(flatten)]
    means: Means,
}

#[derive(Args)]
struct PictureArgs {
    scene: PathBuf,
    #[arg(long, value_enum)]
    preset: Preset,
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    device: DeviceArgs,
}

impl DeviceArgs {
    fn open(&self) -> anyhow::Result<Place> {
        let instance = Instance::new(Validation::Off)?;
        let device = Device::open(&instance, instance.choose(self.device.as_deref())?)?;
        Ok(Place { device, costs: Costs::default() })
    }
}

impl Means {
    fn hunt(&self) -> anyhow::Result<Hunt> {
        let place = self.device.open()?;
        eprintln!("device: {}", place.device.report.summary());
        let kept = match &self.references {
            Some(folder) => {
                std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
                Some((folder.clone(), fingerprint()?))
            }
            None => None,
        };
        let (most_samples, most_seconds) = (self.samples, self.seconds);
        let tracing = Tracing { most_samples, most_seconds, kept };
        let options = self.device.device.iter().flat_map(|name| ["--device".into(), name.clone()]);
        let child = Child { program: std::env::current_exe()?, options: options.collect() };
        Ok(Hunt { place, tracing, photographs: self.device.photographs.clone(), child })
    }
}

fn main() -> anyhow::Result<()> {
    match Command::parse().what {
        What::Run(args) => run::run(&args.means.hunt()?, &args),
        What::One(args) => {
            let hunt = args.means.hunt()?;
            let asked = Asked { bytes: args.bytes, sweep: args.sweep, ..Asked::default() };
            let made = scene::make(args.seed, args.number);
            folder::write(&made, &args.output)?;
            run::measure_file(&hunt, &args.output.join("scene.toml"), &asked, Some(&args.output))
        }
        What::File(args) => {
            let hunt = args.means.hunt()?;
            let asked = Asked { bytes: args.bytes, sweep: args.sweep, ..Asked::default() };
            for file in &args.files {
                let stem = file.file_stem().unwrap_or_default();
                let output = args.output.as_ref().map(|output| output.join(stem));
                run::measure_file(&hunt, file, &asked, output.as_deref())?;
            }
            Ok(())
        }
        What::Shrink(args) => run::shrink_kept(&args.means.hunt()?, &args.folder, args.tries),
        What::Report { folder } => {
            print!("{}", run::report(&folder)?);
            Ok(())
        }
        What::Picture(args) => picture(&args),
    }
}

fn picture(args: &PictureArgs) -> anyhow::Result<()> {
    let place = args.device.open()?;
    let loaded = folder::read(&args.scene, &args.device.photographs)?;
    let model = Model::new(&place, &loaded.scene, &loaded.environment, args.preset)?;
    model.draw(1)?.picture.write_exr(&args.output)?;
    Ok(())
}

/// The scene of a folder, or a file itself.
fn scene_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("scene.toml") } else { path.into() }
}
