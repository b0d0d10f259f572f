//! The pictures of two arms, each drawn by a process of its own, held against each other.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;

use super::process::Arm;
use super::stages::between;
use crate::cli::compare::false_color;
use crate::cli::interrupt::is_interrupted;
use crate::environment::Environment;
use crate::files::whole_path;
use crate::measure::bench::Amount;
use crate::measure::verdict::{Pictures, VerdictRow};
use crate::picture::metrics::compare;
use crate::picture::plate::Plate;
use crate::picture::tone_map::{Exposure, display, exposure_of};
use crate::picture::{Picture, write_png};
use crate::reference::{Tracer, Truth};
use crate::scene::Scene;

/// What to compare pictures by.
pub struct Eye<'a> {
    /// The scene, amount of rain and preset apart, for the reference and the exposure.
    pub scene: &'a Scene,
    /// Around it.
    pub environment: &'a Environment,
    /// Arguments of `render`, amount of rain and preset apart.
    pub arguments: Vec<OsString>,
    /// Whether rows are a series of drop counts or rates, or the scene's own.
    pub is_series: bool,
    /// Pictures with a mean FLIP over this are different.
    pub max_flip: f64,
    /// Samples a pixel of the reference; none: no reference.
    pub reference: Option<u32>,
    /// Where to keep them; none: nowhere.
    pub kept: Option<PictureFolder<'a>>,
    /// A process that takes longer is ended.
    pub timeout: Duration,
}

/// What was seen of a preset's pictures.
#[derive(Clone)]
struct Seen {
    flip: f64,
    /// RMS error of each against the reference.
    errors: Option<[f64; 2]>,
    pictures: Option<Pictures>,
    /// Where the pictures differ.
    first_stage: Option<String>,
    /// Why that is not known.
    note: Option<String>,
}

impl Eye<'_> {
    /// Draws what `rows` measured on both arms, and says in each row how far the pictures are apart.
    pub fn look(
        &self,
        arms: [&Arm; 2],
        rows: &mut [VerdictRow],
        say: &dyn Fn(&str),
    ) -> anyhow::Result<()> {
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let mut all: Vec<(String, Amount, Seen)> = Vec::new();
        for row in rows {
            let amount = Amount::of_row(row.drops, row.rate_mm_h, self.scene.placed_count());
            let same = |(preset, other, _): &&(String, Amount, Seen)| {
                (preset, *other) == (&row.preset, amount)
            };
            let seen = match all.iter().find(same) {
                Some((.., seen)) => seen.clone(),
                None => {
                    say(&format!("pictures of {}", row.name));
                    let seen = self.compare(arms, row, folder.path())?;
                    all.push((row.preset.clone(), amount, seen.clone()));
                    seen
                }
            };
            row.see(seen.flip, self.max_flip);
            row.error_a = seen.errors.map(|errors| errors[0]);
            row.error_b = seen.errors.map(|errors| errors[1]);
            row.pictures = seen.pictures;
            row.first_stage_that_differs = seen.first_stage;
            row.notes.extend(seen.note);
        }
        Ok(())
    }

    /// FLIP between the two, and the RMS error of each against the reference.
    fn compare(&self, arms: [&Arm; 2], row: &VerdictRow, folder: &Path) -> anyhow::Result<Seen> {
        let mut arguments = self.arguments.clone();
        arguments.push(format!("--preset={}", row.preset).into());
        let amount = Amount::of_row(row.drops, row.rate_mm_h, self.scene.placed_count());
        if self.is_series {
            arguments.push(match amount {
                Amount::Drops(count) => format!("--drops={count}").into(),
                Amount::Rate(rate) => format!("--rate={rate}").into(),
            });
            if matches!(amount, Amount::Rate(_)) && self.scene.random_count() > 0 {
                // It takes their place.
                arguments.push("--drops=0".into());
            }
        }
        if self.scene.film.frames() > 1 {
            arguments.push("--frames=1".into());
        }
        let draw = |arm: &Arm, name: &str| -> anyhow::Result<Picture> {
            let path = folder.join(name);
            arm.render(&arguments, &path, self.timeout)?;
            let picture = Picture::read(&path)?;
            // The next row's must not be taken for this one's.
            std::fs::remove_file(&path).context("a temporary file stays")?;
            Ok(picture)
        };
        let (a, b) = (draw(arms[0], "a.exr")?, draw(arms[1], "b.exr")?);
        let tone_map = &self.scene.tone_map;
        let exposure = exposure_of(tone_map, &a);
        let found = compare(&a, &b, None, exposure);
        let plate = Plate::of(self.scene)?;
        let errors = self.reference.map(|samples| -> crate::Result<_> {
            let mut scene = self.scene.film.frame(self.scene, 0); // particles as of the scene, whose time it has
            if self.is_series {
                amount.apply(&mut scene)?;
            }
            let truth = Truth { samples, ..Truth::default() };
            let tracer = Tracer::new(&scene, self.environment, truth);
            let reference = tracer.before(plate.clone()).picture();
            let exposure = exposure_of(tone_map, &reference);
            Ok([&a, &b].map(|picture| compare(&reference, picture, None, exposure).pixels.rms()))
        });
        let errors = errors.transpose()?;
        let pictures = self.kept.as_ref().map(|into| {
            let amount = amount.option();
            let name = format!("{}-{}{}", row.preset, amount.1, &amount.0[1..]);
            into.write(&name, [&a, &b], &found.flip_map, exposure)
        });
        let flip = found.pixels.flip;
        let mut seen =
            Seen { flip, errors, pictures: pictures.transpose()?, first_stage: None, note: None };
        // Real rain has no stages: the paper knows none.
        if flip > self.max_flip && row.rate_mm_h.is_none() && row.drops > 0 {
            match self.first_stage(arms, &arguments, folder) {
                Ok(first) => seen.first_stage = first,
                Err(error) if is_interrupted() => return Err(error),
                Err(error) => seen.note = Some(format!("stages: {error:#}")),
            }
        }
        Ok(seen)
    }

    /// The first stage of the paper's frame that differs, by its name. Programs of other versions may not know how to
    /// draw them.
    fn first_stage(
        &self,
        arms: [&Arm; 2],
        arguments: &[OsString],
        folder: &Path,
    ) -> anyhow::Result<Option<String>> {
        let paths = ["a.stages", "b.stages"].map(|name| folder.join(name));
        for (arm, path) in arms.iter().zip(&paths) {
            // The next row's must not be taken for this one's.
            let _ = std::fs::remove_file(path);
            let mut option = OsString::from("--stages=");
            option.push(path);
            let arguments = [arguments, &[option]].concat();
            arm.render(&arguments, &folder.join("again.exr"), self.timeout)?;
        }
        let all = between(&paths[0], &paths[1])?;
        Ok(all.iter().find(|stage| stage.differs()).map(|stage| stage.stage.to_string()))
    }
}

/// Where pictures are kept.
pub struct PictureFolder<'a> {
    /// The folder, which is made if need be.
    pub path: &'a Path,
    /// The result file, to which their paths are relative.
    pub result: Option<&'a Path>,
}

impl PictureFolder<'_> {
    /// Writes two pictures and FLIP's map of their difference.
    pub fn write(
        &self,
        name: &str,
        pictures: [&Picture; 2],
        flip_map: &[f64],
        exposure: Exposure,
    ) -> anyhow::Result<Pictures> {
        let into = self.path;
        std::fs::create_dir_all(into).with_context(|| format!("{}", into.display()))?;
        let Picture { width, height, .. } = *pictures[0];
        let write = |what: &str, srgb: &[u8]| -> anyhow::Result<PathBuf> {
            let path = into.join(format!("{name}-{what}.png"));
            write_png(&path, width, height, srgb)?;
            as_seen_from(self.result, &path)
        };
        let shown = |picture: &Picture| display(exposure, picture).srgb();
        let difference: Vec<u8> = flip_map.iter().flat_map(|error| false_color(*error)).collect();
        let largest = flip_map.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let (at, largest_flip) = largest.map_or((0, 0.0), |(at, largest)| (at as u32, *largest));
        Ok(Pictures {
            a: write("a", &shown(pictures[0]))?,
            b: write("b", &shown(pictures[1]))?,
            difference: write("difference", &difference)?,
            largest_flip: Some(largest_flip),
            largest_flip_at: Some((at % width, at / width)),
        })
    }
}

/// A file's path relative to a result file's folder if it lies below it, so that both can be moved; else the whole path.
pub fn as_seen_from(result: Option<&Path>, path: &Path) -> anyhow::Result<PathBuf> {
    let whole = |path: &Path| whole_path(path).with_context(|| format!("{}", path.display()));
    let path = whole(path)?;
    let folder = result.and_then(Path::parent);
    let folder = folder.map(|folder| match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    });
    let folder = folder.map(whole).transpose()?;
    let below = folder.and_then(|folder| path.strip_prefix(folder).ok().map(Path::to_path_buf));
    Ok(below.unwrap_or(path))
}
