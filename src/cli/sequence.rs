//! The files of a numbered sequence: their names, what they are frames of, and which are there.
//!
//! Frames appear whole or not at all, so a sequence that was interrupted, in whatever way, goes on
//! with the frames that are missing, or that something else has cut off. A manifest beside them says what they are frames of; frames of
//! another scene are not taken for this one's.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::tell::say;
use crate::environment::Environment;
use crate::files::{read_text_if_there, write_whole};
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::plan::Choice;
use crate::scene::Scene;
use crate::{Error, Result};

/// A sequence of pictures beside each other.
pub struct Sequence {
    output: PathBuf,
    resume: bool,
    /// Its frames are layers.
    layers: bool,
    /// Number of its frames.
    frames: u32,
    /// So many of them, from the first on, are of this scene where they are there: its manifest says so.
    known: u32,
}

/// What every frame depends on, and its number alone does not tell.
#[derive(Serialize)]
struct Manifest<'a> {
    /// What this file is, for whoever finds it.
    about: &'static str,
    version: &'static str,
    /// Hash of the environment's texels.
    environment_hash: String,
    /// Hash of what is behind the drops.
    background_hash: Option<String>,
    /// Whether frames are layers; left out where they are pictures.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    layers: bool,
    /// Number of frames, from the first on, that are of it.
    frames: Option<u32>,
    scene: &'a Scene,
    /// What preset `auto` took, so that no frame is made by other models than the rest.
    auto: Option<&'a Choice>,
}

/// The part of it that is read back.
#[derive(Deserialize)]
struct Kept {
    auto: Option<Choice>,
    /// None: by a version that did not say; all that are there are of it.
    frames: Option<u32>,
}

/// The manifest's text.
fn text_of(
    path: &Path,
    scene: &Scene,
    environment: &Environment,
    layers: bool,
    frames: Option<u32>,
    auto: Option<&Choice>,
) -> Result<String> {
    // Its files are known by their sums, wherever they lie.
    let named = scene.without_folders();
    let manifest = Manifest {
        about: "the scene of the frames beside this file; `render --resume` compares it",
        version: env!("CARGO_PKG_VERSION"),
        environment_hash: format!("{:016x}", environment.hash()),
        background_hash: Plate::of(scene)?.hash().map(|hash| format!("{hash:08x}")),
        layers,
        frames,
        scene: &named,
        auto,
    };
    toml::to_string(&manifest).map_err(|error| Error::write(path, error))
}

impl Sequence {
    /// The sequence of so many frames named after `output`; with `resume` what is there stays.
    pub fn new(output: &Path, resume: bool, layers: bool, frames: u32) -> Self {
        Self { output: output.into(), resume, layers, frames, known: 0 }
    }

    /// Where it goes on, what preset `auto` took for the frames that are there (`None` inside for another
    /// preset); else `None`.
    ///
    /// # Errors
    /// With `resume`: frames that are there belong to something else, or nothing says to what.
    pub fn resume(
        &mut self,
        scene: &Scene,
        environment: &Environment,
    ) -> Result<Option<Option<Choice>>> {
        if !self.resume {
            return Ok(None);
        }
        let path = self.manifest_path();
        let Some(there) = read_text_if_there(&path)? else {
            if (0..self.frames).any(|number| self.path(number).exists()) {
                let problem = "it is not there, so nothing says what the frames beside it are of; \
                               render without --resume";
                return Err(Error::read(&path, problem));
            }
            return Ok(None);
        };
        let Kept { auto, frames } =
            toml::from_str(&there).unwrap_or(Kept { auto: None, frames: None });
        let wanted = text_of(&path, scene, environment, self.layers, frames, auto.as_ref())?;
        if there != wanted {
            return Err(other_scene(&path, &there, &wanted));
        }
        self.known = frames.unwrap_or(u32::MAX);
        Ok(Some(auto))
    }

    /// Says in its manifest what its frames are of. What is there of other scenes under their names is removed first, so
    /// that it is not taken for theirs if they are not all drawn.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn begin(
        &self,
        scene: &Scene,
        environment: &Environment,
        auto: Option<&Choice>,
    ) -> Result<()> {
        if self.known >= self.frames {
            return Ok(());
        }
        for frame in (self.known..self.frames).map(|number| self.path(number)) {
            remove(&frame)?;
            if self.layers {
                remove(&frame.with_extension("json"))?;
            }
        }
        let path = self.manifest_path();
        let text = text_of(&path, scene, environment, self.layers, Some(self.frames), auto)?;
        write_whole(&path, text.as_bytes())
    }

    /// `rain.png` and 7 to `rain-0007.png`.
    pub fn path(&self, number: u32) -> PathBuf {
        let extension = self.output.extension().unwrap_or_default().to_string_lossy();
        self.output.with_file_name(format!("{}-{number:04}.{extension}", self.stem()))
    }

    /// Whether a frame is there already, whole, and stays. One that something else has cut off is reported.
    pub fn has(&self, number: u32) -> bool {
        let path = self.path(number);
        let is_known = number < self.known;
        let is_whole = is_known && Picture::is_whole(&path);
        if is_known && !is_whole && path.exists() {
            say!("{} is cut off or broken, and is drawn again", path.display());
        }
        is_whole
    }

    fn manifest_path(&self) -> PathBuf {
        self.output.with_file_name(format!("{}.frames.toml", self.stem()))
    }

    fn stem(&self) -> String {
        self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// Removes a file, if there is one.
fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::write(path, error))
        }
        _ => Ok(()),
    }
}

/// Names the first line that differs.
fn other_scene(path: &Path, there: &str, wanted: &str) -> Error {
    let lines = there.lines().zip(wanted.lines());
    let differs = lines.enumerate().find(|(_, (there, wanted))| there != wanted);
    let (number, there, wanted) = match differs {
        Some((number, (there, wanted))) => (number + 1, there, wanted),
        None => (there.lines().count().min(wanted.lines().count()) + 1, "its end", "more or less"),
    };
    Error::Scene {
        place: format!("{}:{number}", path.display()),
        problem: format!(
            "the frames are of another scene (`{there}`, not `{wanted}`); render without --resume, \
             or under another name"
        ),
    }
}
