//! Three scenes that each device draws, held against what `raindrops reference` made of them with 256 samples a pixel.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::super::write_half;
use crate::Result;
use crate::environment::sky::{self, Sun};
use crate::files::write_whole;
use crate::picture::metrics::compare;
use crate::picture::read::{Decoded, Request};
use crate::picture::tone_map::Exposure;

/// The scenes: name, text, and the reference as PNG.
const SCENES: [(&str, &str, &[u8]); 3] = [
    (
        "drop",
        include_str!("../../../assets/survey/drop.toml"),
        include_bytes!("../../../assets/survey/drop.png"),
    ),
    (
        "box",
        include_str!("../../../assets/survey/box.toml"),
        include_bytes!("../../../assets/survey/box.png"),
    ),
    (
        "shower",
        include_str!("../../../assets/survey/shower.toml"),
        include_bytes!("../../../assets/survey/shower.png"),
    ),
];

/// By which presets they are drawn: scene, preset, name of the picture, and the largest mean FLIP error that is no fault of
/// the device: a quarter more than llvmpipe's.
const CASES: [(&str, &str, &str, f64); 7] = [
    ("drop", "fast", "drop-fast", 0.0163),
    ("drop", "exact", "drop-exact", 0.0107),
    ("box", "paper", "box-paper", 0.1417),
    ("box", "fast", "box-fast", 0.0723),
    ("box", "exact", "box-exact", 0.0572),
    ("shower", "fast", "shower-fast", 0.0433),
    ("shower", "exact", "shower-exact", 0.0430),
];

/// A scene by a preset.
pub(super) struct Case {
    pub name: &'static str,
    scene: &'static str,
    preset: &'static str,
    most_flip: f64,
}

/// What a device drew, and how far it is from the reference.
#[derive(Serialize)]
pub(super) struct Seen {
    pub name: &'static str,
    scene: &'static str,
    preset: &'static str,
    /// Mean FLIP error.
    pub flip: f64,
    /// Its 99th percentile.
    flip_p99: f64,
    psnr_db: f64,
    /// The largest mean that is no fault of the device.
    pub most_flip: f64,
}

impl Seen {
    /// Whether the picture is as true as on other devices.
    pub fn holds(&self) -> bool {
        self.flip <= self.most_flip
    }
}

/// All pictures.
pub(super) fn cases() -> impl Iterator<Item = Case> {
    let case = |(scene, preset, name, most_flip)| Case { name, scene, preset, most_flip };
    CASES.into_iter().map(case)
}

/// Writes the scenes, their sky and their references into a folder; gives the files.
pub(super) fn prepare(folder: &Path) -> Result<Vec<PathBuf>> {
    let sky = folder.join("low-sun.exr");
    write_half(&sky::picture(512, Sun { elevation: 12.0, azimuth: 180.0 }), &sky)?;
    let mut files = vec![sky];
    for (name, text, reference) in SCENES {
        for (path, bytes) in
            [(scene_in(folder, name), text.as_bytes()), (reference_in(folder, name), reference)]
        {
            write_whole(&path, bytes)?;
            files.push(path);
        }
    }
    Ok(files)
}

fn scene_in(folder: &Path, name: &str) -> PathBuf {
    folder.join(name).with_extension("toml")
}

fn reference_in(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}-reference.png"))
}

impl Case {
    /// The picture's file.
    pub fn file(&self, folder: &Path) -> PathBuf {
        folder.join(self.name).with_extension("png")
    }

    /// The command line that draws it.
    pub fn arguments(&self, folder: &Path) -> [OsString; 5] {
        let preset = format!("--preset={}", self.preset).into();
        let scene = scene_in(folder, self.scene).into();
        ["render".into(), scene, preset, "-o".into(), self.file(folder).into()]
    }

    /// Holds the picture against the reference.
    pub fn compare(&self, folder: &Path) -> Result<Seen> {
        let read = |path: &Path| Decoded::read(path, Request::new("--layer"));
        let reference = read(&reference_in(folder, self.scene))?.picture;
        let drawn = read(&self.file(folder))?.picture;
        let figures = compare(&reference, &drawn, None, Exposure::Clipped(1.0)).pixels;
        Ok(Seen {
            name: self.name,
            scene: self.scene,
            preset: self.preset,
            flip: figures.flip,
            flip_p99: figures.flip_p99,
            psnr_db: figures.psnr_db,
            most_flip: self.most_flip,
        })
    }
}
