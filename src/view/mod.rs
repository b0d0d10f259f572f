//! A window onto the rain: flying, stopping time, changing models and seeing what each costs.
//!
//! `app` hears the window system, `viewer` is the open window from frame to frame; `stage` draws
//! the rain, `screen` puts it and the panel (`panel`, by egui) into the window. `clock` and `flight`
//! are time and camera under the viewer's hand, `keys` says what the keys do.

mod app;
mod clock;
mod flight;
mod focus;
mod glass;
mod history;
mod keep;
pub mod keys;
mod nearest;
mod panel;
mod prepare;
mod reload;
mod screen;
mod stage;
mod viewer;
mod weather;

use std::path::{Path, PathBuf};

pub use self::app::run;
use crate::gpu::{Machine, Validation};
use crate::remark::Remark;
use crate::scene::{EnvironmentChoice, Scene};

/// How the window opens.
#[derive(Clone, Debug)]
pub struct Options {
    /// What it shows.
    pub scene: Scene,
    /// The scene's name, for the title.
    pub name: String,
    /// Which device; see [`crate::gpu::Instance::choose`].
    pub device: Option<String>,
    /// For which machine passes are laid out, in place of the device's own.
    pub machine: Option<Machine>,
    /// Whether the validation layer watches.
    pub validation: Validation,
    /// Whether time stands still at first.
    pub paused: bool,
    /// Whether the panel is shown at first.
    pub panel: bool,
    /// Whether frames wait for the screen.
    pub vsync: bool,
    /// Folder of screenshots and scene files.
    pub keep_in: PathBuf,
    /// Prints on the terminal what was done.
    pub say: fn(&str),
    /// Prints on the terminal what is worth saying beside that.
    pub remark: fn(&Remark),
}

/// Where `scripts/setup.sh` puts real environments, from the project's folder.
const FETCHED: &str = "assets/environments";

/// The environments that can be chosen: the bundled sky, a white furnace, the scene's own, and the
/// images beside it or among the fetched ones.
fn environments(scene: &Scene) -> Vec<(String, EnvironmentChoice)> {
    let own = &scene.environment;
    let white =
        EnvironmentChoice { radiance: Some(glam::Vec3::ONE), ..EnvironmentChoice::default() };
    let mut choices = vec![
        ("sky (bundled)".into(), EnvironmentChoice::default()),
        ("white furnace".into(), white.clone()),
    ];
    if own.radiance.is_some() && *own != white {
        choices.push(("the scene's radiance".into(), own.clone()));
    }
    let beside = own.file.as_deref().and_then(Path::parent);
    let mut files: Vec<PathBuf> = [beside, Some(Path::new(FETCHED))]
        .into_iter()
        .flatten()
        .filter_map(|folder| folder.read_dir().ok())
        .flat_map(|entries| entries.filter_map(Result::ok).map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "exr" || e == "hdr"))
        .chain(own.file.clone())
        .collect();
    files.sort();
    files.dedup();
    choices.extend(files.into_iter().map(|file| {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        (name, EnvironmentChoice { file: Some(file), ..EnvironmentChoice::default() })
    }));
    choices
}
