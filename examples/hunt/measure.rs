//! A scene drawn by every model and held against its reference.

use std::path::PathBuf;
use std::time::Instant;

use raindrops::picture::Picture;
use raindrops::picture::tone_map::{Exposure, exposure_of};
use raindrops::plan::FramePlan;
use raindrops::scene::model::Preset;

use super::bytes::{Child, bytes_of};
use super::figures::Halves;
use super::folder::Loaded;
use super::models::{Drawn, Model, Place};
use super::row::{ModelRow, Row, tags};
use super::sweep::{Swept, sweep};
use super::trace::Tracing;

/// What a hunt works with.
#[derive(Clone)]
pub struct Hunt {
    pub place: Place,
    pub tracing: Tracing,
    /// Folder of the photographs.
    pub photographs: PathBuf,
    /// How this program is started to draw in another process.
    pub child: Child,
}

/// What is measured of a scene besides its errors.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Whether other runs give the same bytes.
    pub bytes: bool,
    /// What is swept.
    pub sweep: Option<Swept>,
    /// These models alone; all where it is empty.
    pub models: Vec<String>,
}

/// A scene with its figures and pictures.
pub struct Measured {
    pub row: Row,
    pub halves: Halves,
    pub exposure: Exposure,
    /// By the models' names.
    pub pictures: Vec<(String, Picture)>,
}

impl Measured {
    /// The picture of a model.
    pub fn picture(&self, model: &str) -> Option<&Picture> {
        self.pictures.iter().find(|(name, _)| name == model).map(|(_, picture)| picture)
    }
}

impl Hunt {
    /// Measures a scene; `name` is that of its kept reference.
    pub fn measure(&self, name: &str, loaded: &Loaded, asked: &Asked) -> anyhow::Result<Measured> {
        let since = Instant::now();
        let Loaded { scene, environment, .. } = loaded;
        // What cannot be drawn is not traced.
        let mut models = Vec::new();
        for preset in super::models::PRESETS {
            let is_asked =
                asked.models.is_empty() || asked.models.iter().any(|m| m == preset.name());
            if is_asked {
                models.push((preset, Model::new(&self.place, scene, environment, preset)?));
            }
        }
        let before = Instant::now();
        let halves = self.tracing.halves(name, scene, environment)?;
        let reference_seconds = before.elapsed().as_secs_f64();
        let exposure = exposure_of(&scene.tone_map, &halves.mean());
        let noise = halves.noise(exposure);
        let (width, height) = scene.picture_size();
        let mut row = Row {
            tags: tags(&loaded.parsed),
            size: [width, height],
            of_drops: halves.of_drops(),
            samples: 2 * halves.samples,
            noise,
            error: scene.model.error,
            reference_seconds,
            ..Row::default()
        };
        let mut drawn: Vec<(FramePlan, String, Drawn)> = Vec::new();
        for (preset, model) in &models {
            let (name, plan) = (preset.name().to_string(), by_models(&model.plan));
            // `auto` often takes the models of another preset: the picture is the same.
            let at = match drawn.iter().position(|(other, ..)| *other == plan) {
                Some(at) => at,
                None => {
                    drawn.push((plan, name.clone(), model.draw(2)?));
                    drawn.len() - 1
                }
            };
            let Drawn { picture, ms, report } = &drawn[at].2;
            let of_model = ModelRow {
                figures: halves.figures(picture, exposure, &noise),
                ms: *ms,
                lost: report.counts.overflow,
                warnings: model.warnings(report),
                models: model.summary(),
                ..ModelRow::default()
            };
            row.models.insert(name, of_model);
        }
        let pictures: Vec<(String, Picture)> =
            drawn.into_iter().map(|(_, name, drawn)| (name, drawn.picture)).collect();
        if asked.bytes {
            for (preset, model) in models.iter().filter(|(preset, _)| *preset != Preset::Auto) {
                let first = pictures.iter().find(|(name, _)| name == preset.name());
                if let Some((name, first)) = first {
                    let bytes =
                        bytes_of(model, first, &self.child, &loaded.file, &self.photographs)?;
                    row.models.entry(name.clone()).or_default().bytes = Some(bytes);
                }
            }
        }
        if let Some(swept) = asked.sweep {
            let presets: Vec<Preset> = models.iter().map(|(preset, _)| *preset).collect();
            for (name, step) in sweep(self, name, loaded, swept, &presets)? {
                row.models.entry(name).or_default().step = Some(step);
            }
        }
        row.seconds = since.elapsed().as_secs_f64();
        Ok(Measured { row, halves, exposure, pictures })
    }
}

/// What of a plan decides the picture.
fn by_models(plan: &FramePlan) -> FramePlan {
    let plan = plan.clone();
    FramePlan { preset: Preset::Fast, why: None, doubt: None, passes: Vec::new(), ..plan }
}
