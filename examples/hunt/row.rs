//! What is found of a scene: a line of JSON, by which a run goes on where it ended.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use raindrops::scene::Scene;
use raindrops::scene::model::DropShape;
use serde::{Deserialize, Serialize};

use super::bounds::{Miss, misses};
use super::figures::Figures;

/// Name of the file that has a line for each scene.
pub const ROWS: &str = "rows.jsonl";

/// One scene.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Row {
    /// By which it is drawn again.
    pub seed: u64,
    pub number: u64,
    /// What it has: see [`tags`].
    pub tags: Vec<String>,
    pub size: [u32; 2],
    /// Share of the picture that shows drops.
    pub of_drops: f64,
    /// Samples a pixel of both halves of the reference together, and the noise that is left.
    pub samples: u32,
    pub noise: Figures,
    /// The models by name.
    pub models: BTreeMap<String, ModelRow>,
    /// What `auto` is to keep.
    pub error: Option<f64>,
    /// Seconds for all of it, and of those for the reference.
    pub seconds: f64,
    pub reference_seconds: f64,
    /// Why there are no figures.
    pub problem: Option<String>,
}

/// One scene by one model.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ModelRow {
    pub figures: Figures,
    /// Milliseconds of the frame.
    pub ms: f64,
    /// What it draws by.
    pub models: String,
    /// What was said when it was drawn.
    pub warnings: Vec<String>,
    /// Drops, or entries of lists, that were lost.
    pub lost: u64,
    pub bytes: Option<Bytes>,
    pub step: Option<Step>,
}

/// Pixels that differ from those of the first run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Bytes {
    pub again: u32,
    pub one_thread: u32,
    pub two_threads: u32,
    /// None of a window, which is a part already.
    pub by_parts: Option<u32>,
}

impl Bytes {
    /// The most.
    pub fn most(&self) -> u32 {
        let Self { again, one_thread, two_threads, by_parts } = *self;
        again.max(one_thread).max(two_threads).max(by_parts.unwrap_or(0))
    }
}

/// The largest change of a picture from step to step of a sweep, over the reference's.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Step {
    /// What was swept.
    pub of: String,
    pub largest: f64,
    /// Between which values it is.
    pub between: [f64; 2],
    /// Levels by which the picture and the reference change there.
    pub levels: [f64; 2],
}

impl Row {
    /// What is over its bound.
    pub fn misses(&self) -> Vec<Miss> {
        misses(&self.models, &self.noise, self.error)
    }

    /// The miss that counts most, by how many times its bound it is.
    pub fn worst(&self) -> Option<Miss> {
        let counts = self.misses().into_iter().filter(Miss::counts);
        counts.max_by(|a, b| a.times().total_cmp(&b.times()))
    }
}

/// What a scene has that decides how it is drawn, in words.
pub fn tags(scene: &Scene) -> Vec<String> {
    let frame = super::scene::frame(scene);
    let view = frame.view();
    let is_flat = |shape: Option<DropShape>, ratio: Option<f64>| {
        shape == Some(DropShape::Equilibrium) || ratio.is_some_and(|ratio| ratio != 1.0)
    };
    let placed = &frame.drops;
    let rain = frame.real_rain();
    let moves = placed.iter().any(|drop| drop.velocity.length() > 0.0) || frame.rain.is_some();
    let file = frame.environment.file.as_deref().and_then(Path::file_stem);
    let light = match (file, frame.environment.radiance) {
        (Some(file), _) => file.to_string_lossy().into_owned(),
        (None, Some(_)) => "constant".into(),
        (None, None) => "bundled".into(),
    };
    let largest_px = |least: f64| {
        placed.iter().any(|drop| {
            let away = (drop.center_at(frame.drawn_time()) - view.position).length();
            drop.radius / away * view.focal_px > least
        })
    };
    let is_near = placed.iter().any(|drop| {
        let away = (drop.center_at(frame.drawn_time()) - view.position).length();
        away < 32.0 * drop.radius
    });
    let all = [
        ("placed", !placed.is_empty()),
        ("box", !frame.populations().is_empty() && frame.random_count() > 0),
        ("rain", rain.is_some()),
        ("moving", frame.exposed() != 0.0 && moves),
        ("lens", frame.drawn_lens() > 0.0),
        (
            "flat",
            placed.iter().any(|drop| is_flat(drop.shape, drop.axis_ratio))
                || rain.is_some_and(|rain| rain.shape == DropShape::Equilibrium),
        ),
        ("near", is_near),
        ("over 12 px", largest_px(12.0)),
        ("index", frame.water != raindrops::scene::water::Water::default()),
        ("plate", !frame.background.is_none()),
        ("window", frame.camera.window != raindrops::scene::camera::WHOLE),
    ];
    let mut tags: Vec<String> =
        all.into_iter().filter(|(_, has)| *has).map(|(name, _)| name.into()).collect();
    tags.push(light);
    tags
}

/// The rows of a folder; a last line that was cut off is left out.
pub fn read(folder: &Path) -> anyhow::Result<Vec<Row>> {
    let path = folder.join(ROWS);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let whole = lines.iter().filter(|line| line.ends_with('\n'));
    whole
        .enumerate()
        .map(|(at, line)| {
            serde_json::from_str(line).with_context(|| format!("{}:{}", path.display(), at + 1))
        })
        .collect()
}

/// Adds a row; what a run that was stopped has left of a line is cut off first.
pub fn append(folder: &Path, row: &Row) -> anyhow::Result<()> {
    let path = folder.join(ROWS);
    if let Ok(text) = std::fs::read(&path) {
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        if whole < text.len() {
            let file = OpenOptions::new().write(true).open(&path);
            file.and_then(|file: File| file.set_len(whole as u64))?;
        }
    }
    let mut line = serde_json::to_string(row)?;
    line.push('\n');
    let file = OpenOptions::new().create(true).append(true).open(&path);
    file.and_then(|mut file| file.write_all(line.as_bytes()))
        .with_context(|| path.display().to_string())
}
