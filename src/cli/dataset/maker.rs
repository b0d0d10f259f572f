//! Views drawn and written, with their lines of the manifest.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::set::Set;
use crate::cli::render::write_layers;
use crate::cli::{say_undrawn, write_half};
use crate::files::write_whole;
use crate::gpu::Device;
use crate::picture::Picture;
use crate::picture::layers::Layers;
use crate::picture::masks::Masks;
use crate::picture::plate::Plate;
use crate::picture::sidecar::camera;
use crate::plan::{Cutoff, FramePlan, Output, plan};
use crate::renderer::FrameReport;
use crate::renderer::parts::{Grid, Parts};
use crate::scene::film::Film;
use crate::scene::{Pane, Scene};
use crate::{Error, Result};

/// Format of a line of the manifest, whose paths are relative to the folder; `docs/result-files.md` says what its keys mean.
const FORMAT: &str = "raindrops-dataset/1";
/// Where the plate's own files are.
const PLATE: &str = "plate";
/// A view's file of what masks are made of.
const MASK: &str = "mask.exr";

/// How the pictures of all views are drawn.
pub(super) struct Plans {
    /// With rain, as layers.
    pub(super) rainy: FramePlan,
    /// Without, and without a pane.
    behind: FramePlan,
    /// Without rain through the dry pane, where there is one.
    dry: Option<FramePlan>,
    /// With all rain as a medium, as layers, where masks are wanted.
    misty: Option<FramePlan>,
}

impl Plans {
    pub(super) fn of(set: &Set) -> Result<Self> {
        let plan_of = |scene: &Scene, output: Output| plan(scene, &set.environment, output);
        let misty =
            set.masks.then(|| plan_of(&set.scene.as_medium(), Output::Layers)).transpose()?;
        let rainy = plan_of(&set.scene, Output::Layers)?;
        let dry = rainy.draws_pane().then(|| dry(&set.scene));
        Ok(Self {
            rainy,
            behind: plan_of(&behind(&set.scene), Output::Radiance)?,
            dry: dry.map(|scene| plan_of(&scene, Output::Radiance)).transpose()?,
            misty,
        })
    }
}

/// What layers of a view go over: no rain, and no pane.
fn behind(scene: &Scene) -> Scene {
    Scene { pane: None, ..scene.without_rain() }
}

/// A view without rain, in the air and on its pane.
fn dry(scene: &Scene) -> Scene {
    let mut dry = scene.without_rain();
    dry.pane = dry.pane.map(Pane::dry);
    dry
}

/// Draws views and writes them.
pub(super) struct Maker<'a> {
    set: &'a Set,
    device: &'a Arc<Device>,
    plans: &'a Plans,
    tiles: Option<Grid>,
    behind: Parts<'a>,
    /// Without rain through the dry pane, where there is one.
    dry: Option<Parts<'a>>,
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
        let parts = |plan| Parts::new(device, &set.environment, plan);
        let mut without = parts(&plans.behind);
        match tiles {
            None => without.prepare(&behind(&set.scene))?,
            Some(grid) => drop(grid.windows(set.scene.image)?),
        }
        let [dry, misty] = [&plans.dry, &plans.misty].map(|plan| plan.as_ref().map(parts));
        Ok(Self { set, device, plans, tiles, behind: without, dry, misty, kept: None })
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
        let depth = has_plate && scene.background.depth.is_some();
        let (without, file) = match (has_plate, self.dry.is_some()) {
            (true, _) => (self.plate()?, format!("{PLATE}/clean.exr")),
            (false, has_pane) => {
                let name = if has_pane { "behind.exr" } else { "clean.exr" };
                let without = radiance_of(&mut self.behind, &behind(&scene), self.tiles)?;
                write_half(&without, &folder.join(name))?;
                (without, in_view(name))
            }
        };
        let (clean_file, behind_file) = match &mut self.dry {
            Some(parts) => {
                let clean = radiance_of(parts, &dry(&scene), self.tiles)?;
                write_half(&clean, &folder.join("clean.exr"))?;
                (in_view("clean.exr"), Some(file))
            }
            None => (file, None),
        };
        let layers = self.draw_layers(&scene, until.clone())?;
        write_half(&layers.over(&without), &folder.join("rainy.exr"))?;
        if let Some(parts) = &mut self.misty {
            let (medium, _) = layers_of(parts, &scene.as_medium(), self.tiles)?;
            Masks::of(&layers, &medium, &without).write_exr(&folder.join(MASK))?;
        }
        let has_glass = self.dry.is_some();
        let glass = layers.glass.iter().map(|share| f64::from(share.to_f32()));
        let cover = glass.sum::<f64>() / layers.color.len() as f64;
        let cutoff = self.plans.rainy.cutoff.as_ref();
        let least = cutoff.map_or(0.0, Cutoff::single_px);
        let path = folder.join("layers.exr");
        let drops = match set.drop_lists {
            true => Some(write_layers(&layers, &scene, (until.time, least), &path)?),
            false => layers.write_exr(&path).map(|()| None)?,
        };
        Film::still(&scene).save(&folder.join("scene.toml"))?;
        let mut files = json!({
            "rainy": in_view("rainy.exr"),
            "clean": clean_file,
            // What layers go over; with a pane, where `clean` is seen through it.
            "behind": behind_file,
            "layers": in_view("layers.exr"),
            "drops": set.drop_lists.then(|| in_view("layers.json")),
            "depth": depth.then(|| format!("{PLATE}/depth.exr")),
            "mask": set.masks.then(|| in_view(MASK)),
            "scene": in_view("scene.toml"),
        });
        remove_nulls(&mut files);
        let on_pane = || layers.glass.iter().filter(|share| share.to_f32() > 0.0).count();
        let mut record = json!({
            "format": FORMAT,
            "view": view,
            "seed": scene.seed,
            "time": scene.time,
            "rate_mm_h": scene.real_rain().map(|rain| rain.rate),
            // How it was drawn, which preset `auto` leaves open.
            "optics": self.plans.rainy.optics,
            "samples": self.plans.rainy.samples,
            "cutoff_px": cutoff.map(|cutoff| cutoff.px),
            "thinned_px": cutoff.map(|cutoff| cutoff.thinned_px),
            "camera": camera(&scene),
            "covered_pixels": layers.count.iter().filter(|count| **count > 0).count(),
            "pane_pixels": has_glass.then(on_pane),
            "pane_cover": has_glass.then_some(cover),
            "pane_drops": has_glass.then(|| scene.pane_drops().len()),
            "pane_age_s": scene.pane.as_ref().filter(|pane| has_glass && pane.has_population()).map(Pane::age),
            "drops": drops,
            "files": files,
        });
        remove_nulls(&mut record);
        write_whole(&set.record_path(view), format!("{record}\n").as_bytes())
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
        let clean = radiance_of(&mut self.behind, &behind(&scene), self.tiles)?;
        write_half(&clean, &folder.join("clean.exr"))?;
        if let Some(depth) = Plate::of(&scene)?.depth() {
            write_depth(&folder.join("depth.exr"), &scene, &depth.values)?;
        }
        Ok(self.kept.insert(clean).clone())
    }
}

/// Removes the keys that a view has no value for.
fn remove_nulls(value: &mut Value) {
    value.as_object_mut().into_iter().for_each(|keys| keys.retain(|_, value| !value.is_null()));
}

/// Draws a scene's radiance, in parts if asked to.
fn radiance_of(parts: &mut Parts<'_>, scene: &Scene, tiles: Option<Grid>) -> Result<Picture> {
    match tiles {
        Some(grid) => Ok(parts.radiance_by(scene, grid)?.0),
        None => parts.draw_window(scene)?.0.read_radiance(),
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
