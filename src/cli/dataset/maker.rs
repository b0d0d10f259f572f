//! Views drawn and written, with their lines of the manifest.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use super::set::Set;
use crate::cli::render::write_layers;
use crate::cli::{say_undrawn, write_half};
use crate::files::write_whole;
use crate::gpu::Device;
use crate::picture::Picture;
use crate::picture::layers::Layers;
use crate::picture::masks::Masks;
use crate::picture::plate::Plate;
use crate::picture::sidecar::CameraRecord;
use crate::plan::{FramePlan, Output, plan};
use crate::renderer::FrameReport;
use crate::renderer::parts::{Grid, Parts};
use crate::scene::Scene;
use crate::scene::film::Film;
use crate::scene::model::Optics;
use crate::{Error, Result};

/// A line of the manifest; paths are relative to the folder.
#[derive(Serialize)]
struct Record {
    format: &'static str,
    view: u32,
    seed: u64,
    time: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_mm_h: Option<f64>,
    /// How it was drawn, which preset `auto` leaves open: optics, samples a pixel, and of real rain the radius in pixels
    /// under which drops are far rain.
    optics: Optics,
    samples: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    cutoff_px: Option<f64>,
    camera: CameraRecord,
    /// Pixels that drops cover a part of.
    covered_pixels: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    drops: Option<usize>,
    files: Files,
}

#[derive(Serialize)]
struct Files {
    rainy: String,
    clean: String,
    layers: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    drops: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<String>,
    scene: String,
}

/// Format of a line.
const FORMAT: &str = "raindrops-dataset/1";
/// Where the plate's own files are.
const PLATE: &str = "plate";
/// A view's file of what masks are made of.
const MASK: &str = "mask.exr";

/// How the pictures of all views are drawn.
pub(super) struct Plans {
    /// With rain, as layers.
    pub(super) rainy: FramePlan,
    /// Without.
    clean: FramePlan,
    /// With all rain as a medium, as layers, where masks are wanted.
    misty: Option<FramePlan>,
}

impl Plans {
    pub(super) fn of(set: &Set) -> Result<Self> {
        let plan_of = |scene: &Scene, output: Output| plan(scene, &set.environment, output);
        let misty =
            set.masks.then(|| plan_of(&set.scene.as_medium(), Output::Layers)).transpose()?;
        Ok(Self {
            rainy: plan_of(&set.scene, Output::Layers)?,
            clean: plan_of(&set.scene.without_rain(), Output::Radiance)?,
            misty,
        })
    }
}

/// Draws views and writes them.
pub(super) struct Maker<'a> {
    set: &'a Set,
    device: &'a Arc<Device>,
    plans: &'a Plans,
    tiles: Option<Grid>,
    clean: Parts<'a>,
    /// The rain as a medium, where masks are wanted.
    misty: Option<Parts<'a>>,
    /// What is behind the rain in every view, where the camera stands still before a plate.
    kept: Option<Picture>,
}

impl<'a> Maker<'a> {
    /// Fails if the pictures are larger than the device draws.
    pub(super) fn new(
        set: &'a Set,
        device: &'a Arc<Device>,
        plans: &'a Plans,
        tiles: Option<Grid>,
    ) -> Result<Self> {
        let mut clean = Parts::new(device, &set.environment, &plans.clean);
        match tiles {
            None => clean.prepare(&set.scene.without_rain())?,
            Some(grid) => drop(grid.windows(set.scene.image)?),
        }
        let misty = plans.misty.as_ref().map(|plan| Parts::new(device, &set.environment, plan));
        Ok(Self { set, device, plans, tiles, clean, misty, kept: None })
    }

    /// Draws and writes a view, its `view.json` last.
    pub(super) fn view(&mut self, view: u32) -> Result<()> {
        let set = self.set;
        let (mut scene, until) = set.scene_of(view);
        scene.read_particles()?;
        let folder = set.folder.join(Set::name(view));
        std::fs::create_dir_all(&folder).map_err(|error| Error::write(&folder, error))?;
        let in_view = |name: &str| format!("{}/{name}", Set::name(view));

        let has_plate = !set.scene.background.is_none();
        let (clean, clean_file, depth) = if has_plate {
            (self.plate()?, format!("{PLATE}/clean.exr"), scene.background.depth.is_some())
        } else {
            let clean = self.draw_clean(&scene)?;
            write_half(&clean, &folder.join("clean.exr"))?;
            (clean, in_view("clean.exr"), false)
        };
        let layers = self.draw_layers(&scene, until.clone())?;
        write_half(&layers.over(&clean), &folder.join("rainy.exr"))?;
        if let Some(parts) = &mut self.misty {
            let (medium, _) = layers_of(parts, &scene.as_medium(), self.tiles)?;
            Masks::of(&layers, &medium, &clean).write_exr(&folder.join(MASK))?;
        }
        let cutoff_px = self.plans.rainy.cutoff.as_ref().map(|cutoff| cutoff.px);
        let least = cutoff_px.unwrap_or(0.0);
        let path = folder.join("layers.exr");
        let drops = match set.drop_lists {
            true => Some(write_layers(&layers, &scene, (until.time, least), &path)?),
            false => layers.write_exr(&path).map(|()| None)?,
        };
        Film::still(&scene).save(&folder.join("scene.toml"))?;
        let record = Record {
            format: FORMAT,
            view,
            seed: scene.seed,
            time: scene.time,
            rate_mm_h: scene.real_rain().map(|rain| rain.rate),
            optics: self.plans.rainy.optics,
            samples: self.plans.rainy.samples,
            cutoff_px,
            camera: CameraRecord::of(&scene),
            covered_pixels: layers.count.iter().filter(|count| **count > 0).count(),
            drops,
            files: Files {
                rainy: in_view("rainy.exr"),
                clean: clean_file,
                layers: in_view("layers.exr"),
                drops: set.drop_lists.then(|| in_view("layers.json")),
                depth: depth.then(|| format!("{PLATE}/depth.exr")),
                mask: set.masks.then(|| in_view(MASK)),
                scene: in_view("scene.toml"),
            },
        };
        let path = set.record_path(view);
        let mut line =
            serde_json::to_string(&record).map_err(|error| Error::write(&path, error))?;
        line.push('\n');
        write_whole(&path, line.as_bytes())
    }

    fn draw_clean(&mut self, scene: &Scene) -> Result<Picture> {
        match self.tiles {
            Some(grid) => Ok(self.clean.radiance_by(&scene.without_rain(), grid)?.0),
            None => self.clean.draw_window(&scene.without_rain())?.0.read_radiance(),
        }
    }

    fn draw_layers(&self, scene: &Scene, until: Scene) -> Result<Layers> {
        // Other drops each time, so nothing but the device's pipelines is kept.
        let mut parts = Parts::new(self.device, &self.set.environment, &self.plans.rainy);
        parts.move_until(until);
        let (layers, report) = layers_of(&mut parts, scene, self.tiles)?;
        say_undrawn(&report.counts, report.room);
        Ok(layers)
    }

    /// The plate as it is drawn, written once, with its depth. Every shard writes the same bytes.
    fn plate(&mut self) -> Result<Picture> {
        if let Some(kept) = &self.kept {
            return Ok(kept.clone());
        }
        let (scene, _) = self.set.scene_of(0);
        let folder = self.set.folder.join(PLATE);
        std::fs::create_dir_all(&folder).map_err(|error| Error::write(&folder, error))?;
        let clean = self.draw_clean(&scene)?;
        write_half(&clean, &folder.join("clean.exr"))?;
        if let Some(depth) = Plate::of(&scene)?.depth() {
            write_depth(&folder.join("depth.exr"), &scene, &depth.values)?;
        }
        Ok(self.kept.insert(clean).clone())
    }
}

/// Draws a scene's layers, in parts if asked to.
fn layers_of(
    parts: &mut Parts<'_>,
    scene: &Scene,
    tiles: Option<Grid>,
) -> Result<(Layers, FrameReport)> {
    match tiles {
        Some(grid) => parts.layers_by(scene, grid),
        None => {
            let (renderer, report) = parts.draw_window(scene)?;
            Ok((renderer.read_layers()?, report))
        }
    }
}

/// Depth as channel Z, of the part of the picture that is drawn.
fn write_depth(path: &Path, scene: &Scene, depths: &[f64]) -> Result<()> {
    let view = scene.view();
    let mut layers = Layers::empty(view.width, view.height);
    for (at, depth) in layers.depth.iter_mut().enumerate() {
        let (x, y) = (at as u32 % view.width, at as u32 / view.width);
        *depth = depths[view.number_in_whole(x, y) as usize] as f32;
    }
    layers.write_depth(path)
}
