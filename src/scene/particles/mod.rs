//! `[particles]`: drops that somebody else simulated, from files: a file for all times, or one for each frame of a sequence.
//!
//! A file becomes placed drops, so that everything that draws or traces those draws particles. They are read once and shared
//! by every copy of the scene. Which bytes are which format is told by the first of them, not by the file's name.

mod comma;
mod numpy;
mod ply;
mod table;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{PlacedDrop, Scene};
use crate::{Error, Result};
use table::Table;

/// Most particles: their records take 2 GiB.
const MOST: u64 = 1 << 26;

/// The `[particles]` table.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Particles {
    /// PLY, NPY, NPZ or CSV, relative to the scene file; with `%04d` in its name, for the frame's number, a sequence.
    pub file: PathBuf,
    /// Radius of those whose file has none, which must have it here.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Factor on the file's lengths: positions, radii and velocities.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: f64,
    /// Frames a second of a sequence, in the scene's time: what is shown is frame `first` + floor(`time` · `fps`).
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1/s"))]
    pub fps: f64,
    /// Number of the sequence's frame at time 0.
    pub first: i64,
    /// What was read.
    #[serde(skip)]
    read: Option<Shared>,
}

impl Default for Particles {
    fn default() -> Self {
        Self { file: PathBuf::new(), radius: None, scale: 1.0, fps: 24.0, first: 1, read: None }
    }
}

/// The drops of a file, shared by all copies of a scene.
#[derive(Clone, Debug)]
struct Shared {
    /// Number of the frame, of a sequence.
    frame: Option<i64>,
    drops: Arc<[PlacedDrop]>,
    /// Radius of the smallest; infinite if there is none.
    least_radius: f64,
}

impl PartialEq for Shared {
    fn eq(&self, other: &Self) -> bool {
        self.frame == other.frame
            && (Arc::ptr_eq(&self.drops, &other.drops) || self.drops == other.drops)
    }
}

impl Particles {
    /// The particles of a file.
    pub fn of(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), ..Self::default() }
    }

    /// The drops that were read; none before.
    pub fn drops(&self) -> &[PlacedDrop] {
        self.read.as_ref().map_or(&[], |read| &read.drops)
    }

    /// Checks the keys; a problem is an error in words.
    pub(super) fn validate(&self) -> std::result::Result<(), String> {
        if self.file.as_os_str().is_empty() {
            return Err("particles: give a file: PLY, NPY, NPZ or CSV".into());
        }
        Ok(())
    }

    /// Number of the frame that is shown at a time; none for a file without frames.
    fn frame_at(&self, time: f64) -> Option<i64> {
        let name = self.file.to_string_lossy();
        numbered(&name, 0).map(|_| self.first.saturating_add((time * self.fps).floor() as i64))
    }

    /// The file of a frame.
    fn path_of(&self, frame: Option<i64>) -> PathBuf {
        let numbered = frame.and_then(|frame| numbered(&self.file.to_string_lossy(), frame));
        numbered.map_or_else(|| self.file.clone(), PathBuf::from)
    }

    /// Whether what was read is what the scene shows at a time.
    fn is_read_at(&self, time: f64) -> bool {
        self.read.as_ref().is_some_and(|read| read.frame == self.frame_at(time))
    }

    /// Fails if the file of a frame is not there.
    fn find(&self, frame: Option<i64>, time: f64) -> Result<PathBuf> {
        let path = self.path_of(frame);
        match frame.filter(|_| !path.is_file()) {
            Some(frame) => {
                let problem = format!(
                    "{} is not there: frame {frame} of the sequence, which time {time} s shows; mend file, first or fps, or \
                     show another time",
                    path.display()
                );
                Err(Error::scene("particles", problem))
            }
            None => Ok(path),
        }
    }

    fn read_at(&self, time: f64) -> Result<Shared> {
        let frame = self.frame_at(time);
        let path = self.find(frame, time)?;
        let (mut drops, has_velocities) = self.read_file(&path)?;
        if let Some(frame) = frame {
            if !has_velocities {
                self.find_velocities(frame, &mut drops)?;
            }
            // A placed drop is at its centre at time 0.
            let at = (frame - self.first) as f64 / self.fps;
            drops.iter_mut().for_each(|drop| drop.center -= drop.velocity * at);
        }
        let least_radius = least_radius(&drops);
        Ok(Shared { frame, drops: drops.into(), least_radius })
    }

    /// The drops of a file, and whether it has velocities.
    fn read_file(&self, path: &Path) -> Result<(Vec<PlacedDrop>, bool)> {
        let bytes = std::fs::read(path).map_err(|error| Error::read(path, error))?;
        let drops = table_of(&bytes).and_then(|table| self.drops_of(&table));
        drops.map_err(|problem| Error::read(path, one_line(&problem)))
    }

    /// The drops of a table.
    fn drops_of(&self, table: &Table) -> std::result::Result<(Vec<PlacedDrop>, bool), String> {
        let drops = table.drops(self.scale, self.radius)?;
        Ok((drops, table.has_velocities()))
    }

    /// Velocities of a frame's drops that have ids: to where the next frame has them, or from where the last one had them
    /// if there is no next. Drops that are in one frame alone stand.
    fn find_velocities(&self, frame: i64, drops: &mut [PlacedDrop]) -> Result<()> {
        if drops.iter().all(|drop| drop.id.is_none()) {
            return Ok(());
        }
        let neighbours = [(frame + 1, self.fps), (frame - 1, -self.fps)];
        let there = neighbours.map(|(frame, rate)| (self.path_of(Some(frame)), rate));
        let Some((path, rate)) = there.into_iter().find(|(path, _)| path.is_file()) else {
            return Ok(());
        };
        let (others, _) = self.read_file(&path)?;
        let places: HashMap<_, _> = others.iter().map(|drop| (drop.id, drop.center)).collect();
        for drop in drops {
            let other = places.get(&drop.id).filter(|_| drop.id.is_some());
            drop.velocity = other.map_or(DVec3::ZERO, |other| (*other - drop.center) * rate);
        }
        Ok(())
    }
}

impl Scene {
    /// Reads the particles that the scene shows at its time, if it has some that are not read yet.
    ///
    /// # Errors
    /// [`Error::File`] for a file that cannot be read or is none of drops; [`Error::Scene`] for a frame that is not there, or
    /// more drops than can be numbered.
    pub fn read_particles(&mut self) -> Result<()> {
        let (time, place) = (self.time, "particles");
        let Some(particles) = self.particles.as_mut().filter(|all| !all.is_read_at(time)) else {
            return Ok(());
        };
        particles.read = Some(particles.read_at(time)?);
        self.validate(place)
    }

    /// Fails if a particle file is missing that a frame of the film from `first` on shows; reads none.
    ///
    /// # Errors
    /// [`Error::Scene`] for the first frame of a sequence that is not there.
    pub fn find_particles(&self, frames: impl Iterator<Item = u32>) -> Result<()> {
        let Some(particles) = &self.particles else { return Ok(()) };
        let plain = Self { particles: None, ..self.clone() };
        for number in frames {
            let time = self.film.frame(&plain, number).time;
            particles.find(particles.frame_at(time), time)?;
        }
        Ok(())
    }

    /// Radius of the smallest drop that has a place; infinite if there is none.
    pub(crate) fn least_placed_radius(&self) -> f64 {
        let read = self.particles.iter().filter_map(|particles| particles.read.as_ref());
        read.map(|read| read.least_radius).fold(least_radius(&self.drops), f64::min)
    }

    /// Fails if particles are not read.
    pub(crate) fn expect_particles(&self) -> Result<()> {
        match &self.particles {
            Some(Particles { read: None, .. }) => {
                Err(Error::scene("particles", "they are not read; call Scene::read_particles"))
            }
            _ => Ok(()),
        }
    }
}

fn least_radius(drops: &[PlacedDrop]) -> f64 {
    drops.iter().map(|drop| drop.radius).fold(f64::INFINITY, f64::min)
}

/// The columns of a particle file, whatever its format; its problem in words.
#[doc(hidden)]
pub fn drops_of_bytes(bytes: &[u8]) -> std::result::Result<Vec<PlacedDrop>, String> {
    let particles = Particles { radius: Some(1.0), ..Particles::default() };
    let drops = table_of(bytes).and_then(|table| particles.drops_of(&table));
    drops.map(|(drops, _)| drops).map_err(|problem| one_line(&problem))
}

fn table_of(bytes: &[u8]) -> std::result::Result<Table, String> {
    match bytes {
        [b'p', b'l', b'y', b'\r' | b'\n', ..] => ply::read(bytes),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => numpy::read(bytes),
        [b'P', b'K', ..] => numpy::read_archive(bytes),
        _ => comma::read(bytes),
    }
}

/// A name with a frame's number in the place of `%d`, `%4d` or `%04d`; none if there is no such place.
fn numbered(name: &str, frame: i64) -> Option<String> {
    let start = name.find('%')?;
    let (digits, after) = name[start + 1..].split_once('d')?;
    let is_width = digits.len() <= 2 && digits.bytes().all(|digit| digit.is_ascii_digit());
    let width = digits.parse().unwrap_or(0);
    is_width.then(|| format!("{}{frame:0width$}{after}", &name[..start]))
}

/// The readers of others say some things in several lines.
fn one_line(problem: &str) -> String {
    problem.split_whitespace().collect::<Vec<_>>().join(" ")
}
