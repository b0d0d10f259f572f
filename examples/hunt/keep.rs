//! What is kept of a scene that fails: its file with those beside it, its figures, and its pictures side by side.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use glam::Vec3;
use raindrops::files::write_whole;
use raindrops::picture::tone_map::display;
use raindrops::picture::{Picture, linear_of_srgb, srgb_of_linear};

use super::figures::Halves;
use super::measure::Measured;

/// Pictures under this edge are shown with pixels twice as large.
const SMALL: u32 = 129;

/// Differences are shown this many times as large, around grey.
const AMPLIFIED: f32 = 4.0;

/// Pixels between two pictures.
const GAP: u32 = 4;

/// The folder of a scene in the folder of a run.
pub fn folder(run: &Path, number: u64) -> PathBuf {
    run.join("scenes").join(format!("{number:05}"))
}

/// Writes figures and pictures into a scene's folder.
pub fn keep(measured: &Measured, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    write_whole(&folder.join("figures.json"), &serde_json::to_vec_pretty(&measured.row)?)?;
    side_by_side(measured).write_png(&folder.join("side.png"))?;
    Ok(())
}

/// `fast`, `exact`, the reference, and what both differ by, from left to right.
pub fn side_by_side(measured: &Measured) -> Picture {
    let Measured { halves, exposure, pictures, .. } = measured;
    let truth = display(*exposure, &Halves::mean(halves));
    let shown = |name: &str| {
        let of = pictures.iter().find(|(model, _)| model == name).or(pictures.first());
        of.map_or_else(|| truth.clone(), |(_, picture)| display(*exposure, picture))
    };
    let (fast, exact) = (shown("fast"), shown("exact"));
    let apart = |picture: &Picture| {
        let pairs = picture.pixels.iter().zip(&truth.pixels);
        let pixels = pairs.map(|(a, b)| {
            let off = |c: usize| srgb_of_linear(a[c]) - srgb_of_linear(b[c]);
            let grey = |c: usize| linear_of_srgb((0.5 + AMPLIFIED * off(c)).clamp(0.0, 1.0));
            Vec3::new(grey(0), grey(1), grey(2))
        });
        Picture { pixels: pixels.collect(), ..*picture }
    };
    let differences = [apart(&fast), apart(&exact)];
    let [of_fast, of_exact] = differences;
    beside(&[fast, exact, truth, of_fast, of_exact])
}

/// Pictures of one size in a row.
fn beside(pictures: &[Picture]) -> Picture {
    let (width, height) = (pictures[0].width, pictures[0].height);
    let times = if width.max(height) < SMALL { 2 } else { 1 };
    let count = pictures.len() as u32;
    let row = count * (times * width + GAP) - GAP;
    let mut whole = Picture {
        width: row,
        height: times * height,
        pixels: vec![Vec3::ONE; (row * times * height) as usize],
    };
    for (number, picture) in (0..).zip(pictures) {
        let left = number * (times * width + GAP);
        for y in 0..times * height {
            for x in 0..times * width {
                let from = (y / times * width + x / times) as usize;
                whole.pixels[(y * row + left + x) as usize] = picture.pixels[from];
            }
        }
    }
    whole
}
