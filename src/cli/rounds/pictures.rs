//! The pictures of two arms, each drawn by a process of its own, held against each other.

use std::ffi::OsString;

use anyhow::Context as _;

use super::process::{Arm, Limits};
use crate::environment::Environment;
use crate::measure::bench::Amount;
use crate::measure::verdict::VerdictRow;
use crate::picture::Picture;
use crate::picture::metrics::compare;
use crate::picture::plate::Plate;
use crate::picture::tone_map::exposure_of;
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
    /// What holds each process back.
    pub limits: Limits,
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
        let mut seen: Vec<(String, Amount, f64, Option<[f64; 2]>)> = Vec::new();
        for row in rows {
            let amount = Amount::of_row(row.drops, row.rate_mm_h, self.placed());
            let same = |(preset, other, ..): &&(String, Amount, f64, Option<[f64; 2]>)| {
                (preset, *other) == (&row.preset, amount)
            };
            let (flip, errors) = match seen.iter().find(same) {
                Some((_, _, flip, errors)) => (*flip, *errors),
                None => {
                    say(&format!("pictures of {}", row.name));
                    let (flip, errors) = self.compare(arms, row, folder.path())?;
                    seen.push((row.preset.clone(), amount, flip, errors));
                    (flip, errors)
                }
            };
            row.see(flip, self.max_flip);
            row.error_a = errors.map(|errors| errors[0]);
            row.error_b = errors.map(|errors| errors[1]);
        }
        Ok(())
    }

    /// Drops placed by hand.
    fn placed(&self) -> u32 {
        self.scene.drops.len() as u32
    }

    /// FLIP between the two, and the RMS error of each against the reference.
    fn compare(
        &self,
        arms: [&Arm; 2],
        row: &VerdictRow,
        folder: &std::path::Path,
    ) -> anyhow::Result<(f64, Option<[f64; 2]>)> {
        let mut arguments = self.arguments.clone();
        arguments.push(format!("--preset={}", row.preset).into());
        let amount = Amount::of_row(row.drops, row.rate_mm_h, self.placed());
        if self.is_series {
            arguments.push(match amount {
                Amount::Drops(count) => format!("--drops={count}").into(),
                Amount::Rate(rate) => format!("--rate={rate}").into(),
            });
        }
        let draw = |arm: &Arm, name: &str| -> anyhow::Result<Picture> {
            let path = folder.join(name);
            arm.render(&arguments, &path, self.limits)?;
            let picture = Picture::read(&path)?;
            // The next row's must not be taken for this one's.
            std::fs::remove_file(&path).context("a temporary file stays")?;
            Ok(picture)
        };
        let (a, b) = (draw(arms[0], "a.exr")?, draw(arms[1], "b.exr")?);
        let tone_map = &self.scene.tone_map;
        let exposure = exposure_of(tone_map, &a);
        let flip = compare(&a, &b, None, exposure).pixels.flip;
        let plate = Plate::of(self.scene)?;
        let errors = self.reference.map(|samples| {
            let mut scene = self.scene.clone();
            if self.is_series {
                amount.apply(&mut scene);
            }
            let truth = Truth { samples, ..Truth::default() };
            let tracer = Tracer::new(&scene, self.environment, truth);
            let reference = tracer.before(plate.clone()).picture();
            let exposure = exposure_of(tone_map, &reference);
            [&a, &b].map(|picture| {
                let psnr = compare(&reference, picture, None, exposure).pixels.psnr_db;
                10f64.powf(-psnr / 20.0)
            })
        });
        Ok((flip, errors))
    }
}
