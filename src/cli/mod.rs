//! The `raindrops` command: one file a command, and what they share.
//!
//! Exit status: 0 done, 1 the answer is "no" (a comparison above its bound, a check that fails),
//! 2 an error, told in one line on stderr. Results go to stdout or to `-o`, progress to stderr.

mod compare;
mod reference;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::Result;
use crate::model::{Operator, Optics, Preset, Simulation};
use crate::scene::Scene;

/// Raindrops rendered as raindrops, at real-time rates, with the error known.
#[derive(Parser)]
#[command(name = "raindrops", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The truth: the scene by a float64 ray tracer on the CPU
    Reference(reference::ReferenceArgs),
    /// How far picture B is from the truth A; with bounds, a check
    Compare(compare::CompareArgs),
}

/// What a command answers when it did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Done, or "yes".
    Yes,
    /// The check that was asked for fails.
    No,
}

/// Parses the command line, runs the command and turns its outcome into the exit status.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome: anyhow::Result<Answer> = match cli.command {
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
    };
    match outcome {
        Ok(Answer::Yes) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(error) => {
            // `{:#}` puts the chain of causes on one line.
            eprintln!("raindrops: {}", format!("{error:#}").replace('\n', " "));
            ExitCode::from(2)
        }
    }
}

/// A scene and the values that the command line sets in it.
#[derive(Args, Clone, Debug, Default)]
pub struct SceneArgs {
    /// Scene file (TOML); left out: the paper's benchmark scene
    scene: Option<PathBuf>,
    /// Number of random drops
    #[arg(long, value_name = "N")]
    drops: Option<u32>,
    /// Seed of the random drops
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Scene time in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Environment image: latitude-longitude EXR, HDR, PNG or JPEG
    #[arg(long, value_name = "FILE")]
    environment: Option<PathBuf>,
    /// Models, all axes at once
    #[arg(long, value_enum, value_name = "NAME")]
    preset: Option<Preset>,
    /// How the light leaving a drop is found
    #[arg(long, value_enum, value_name = "NAME")]
    optics: Option<Optics>,
    /// Where the drops' positions come from
    #[arg(long, value_enum, value_name = "NAME")]
    simulation: Option<Simulation>,
    /// Edge of the mask's finest level in texels
    #[arg(long, value_name = "N")]
    mask_size: Option<u32>,
    /// Tone mapping operator
    #[arg(long, value_enum, value_name = "NAME")]
    tone_map: Option<Operator>,
}

impl SceneArgs {
    /// The scene file with the command line's values set in it, validated.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = match &self.scene {
            Some(path) => Scene::load(path)?,
            None => Scene::default(),
        };
        if let Some(count) = self.drops {
            scene.rain.get_or_insert_default().count = count;
        }
        if let Some(seed) = self.seed {
            scene.seed = seed;
        }
        if let Some(time) = self.time {
            scene.time = time;
        }
        if let Some((width, height)) = self.size {
            (scene.image.width, scene.image.height) = (width, height);
        }
        if let Some(file) = &self.environment {
            scene.environment.file = Some(file.clone());
            scene.environment.radiance = None;
        }
        if let Some(preset) = self.preset {
            scene.model.preset = preset;
        }
        scene.model.optics = self.optics.or(scene.model.optics);
        scene.model.simulation = self.simulation.or(scene.model.simulation);
        scene.model.mask_size = self.mask_size.unwrap_or(scene.model.mask_size);
        scene.tone_map.operator = self.tone_map.unwrap_or(scene.tone_map.operator);
        scene.validate("command line")?;
        Ok(scene)
    }
}

/// `1920x1080` to (1920, 1080).
fn parse_size(text: &str) -> Result<(u32, u32), String> {
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .ok_or_else(|| format!("'{text}' is not a size like 1024x1024"))
}
