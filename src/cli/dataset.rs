//! `raindrops dataset`: many views of a scene or a plate, with and without rain, as layers, and what is in them.
//!
//! A view depends on the scene, the options and its number alone, so shards need not know of each other: together they
//! are what one run makes, byte for byte, on the same device. A view is there when its `view.json` is, which is
//! written last; the manifest is made of those, by whoever finds all of them there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use clap::Args;
use glam::{DQuat, DVec3};
use serde::Serialize;

use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::PictureArgs;
use super::render::{layers_by_parts, motion_end, parse_grid, radiance_by_parts, write_layers};
use super::tell::say;
use super::{Answer, progress, say_doubt, write_half};
use crate::environment::Environment;
use crate::files::write_whole;
use crate::gpu::Device;
use crate::picture::Picture;
use crate::picture::layers::Layers;
use crate::picture::plate::Plate;
use crate::picture::sidecar::CameraRecord;
use crate::plan::{FramePlan, Output, plan};
use crate::renderer::parts::{Grid, Parts};
use crate::scene::Scene;
use crate::scene::film::Film;
use crate::scene::model::Optics;
use crate::thousands::counted;
use crate::{Error, Result};

/// Draw many views with and without rain, as a data set
///
/// Each view is written as layers, with and without rain, and stands in a manifest: docs/data-set.md.
#[derive(Args)]
pub struct DatasetArgs {
    /// Folder to write into; views that exist already stay
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of views [default: the frames of the scene's film, or 100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9_999_999))]
    views: Option<u32>,
    /// Turn the camera about the vertical, by another angle of up to this many degrees in each view [default: 180; 0 with a
    /// background or a film's camera]
    #[arg(long, value_name = "DEGREES", value_parser = parse_turn)]
    turn: Option<f64>,
    /// Give each view a rain rate between these, in mm/h, spread evenly over the logarithm [default: the scene's rate]
    #[arg(long, value_name = "LOW,HIGH", value_parser = parse_rates)]
    rates: Option<[f64; 2]>,
    /// Make every Nth view only, starting with the Ith: for the Ith of N machines
    #[arg(long, value_name = "I/N", value_parser = parse_shard, default_value = "1/1")]
    shard: Shard,
    /// Write no list of the drops in view, which may take many times the space of the pictures
    #[arg(long)]
    no_drop_lists: bool,
    /// Draw each picture in this many parts, with the same result: for pictures larger than the device's images
    #[arg(long, value_name = "CxR", value_parser = parse_grid)]
    tiles: Option<Grid>,
    #[command(flatten)]
    picture: PictureArgs,
}

/// The views of one machine.
#[derive(Clone, Copy)]
struct Shard {
    /// From 1 on.
    number: u32,
    of: u32,
}

/// What a data set is of: `dataset.toml`.
#[derive(Serialize)]
struct Head<'a> {
    about: &'static str,
    version: &'static str,
    views: u32,
    turn_degrees: f64,
    rates_mm_h: Option<[f64; 2]>,
    drop_lists: bool,
    environment_hash: String,
    background_hash: Option<String>,
    scene: &'a Scene,
}

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
    scene: String,
}

/// Format of a line.
const FORMAT: &str = "raindrops-dataset/1";
/// Where the plate's own files are.
const PLATE: &str = "plate";

/// Runs the command.
pub fn run(args: &DatasetArgs) -> anyhow::Result<Answer> {
    let set = Set::new(args)?;
    // Of a set that is there whole, too.
    set.is_begun()?;
    let mine: Vec<u32> = (0..set.views)
        .filter(|view| view % args.shard.of == args.shard.number - 1)
        .filter(|view| !set.has(*view))
        .collect();
    if !mine.is_empty() {
        let device = args.picture.device.open()?;
        let plan = plan(&set.scene, &set.environment, Output::Layers)?;
        say_doubt(&plan);
        let dry = dry(&set.scene);
        let clean_plan = crate::plan::plan(&dry, &set.environment, Output::Radiance)?;
        // What cannot be drawn is known before anything is written.
        let mut clean = Parts::new(&device, &set.environment, &clean_plan);
        match args.tiles {
            None => clean.prepare(&dry)?,
            Some(grid) => drop(grid.windows(dry.image)?),
        }
        set.begin()?;
        heed_interrupts()?;
        let bar = progress(mine.len() as u64, "views");
        let tiles = args.tiles;
        let mut made = Maker { set: &set, device: &device, plan: &plan, tiles, clean, kept: None };
        for (done, view) in mine.iter().enumerate() {
            if is_interrupted() {
                let left = mine.len() - done;
                let left = counted(left as u64, "view");
                let left = format!("{left} missing; the same command goes on");
                return Err(Interrupted).context(left);
            }
            made.view(*view)?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        device.instance().expect_silence()?;
    }
    let missing = (0..set.views).filter(|view| !set.has(*view)).count();
    if missing > 0 {
        say!(
            "{} made; {missing} of {} left to other shards, the last of which to end writes the manifest",
            counted(mine.len() as u64, "view"),
            set.views
        );
        return Ok(Answer::Yes);
    }
    let lines = (0..set.views).map(|view| set.line(view)).collect::<Result<Vec<_>>>()?;
    let manifest = set.folder.join("manifest.jsonl");
    write_whole(&manifest, lines.concat().as_bytes())?;
    say!("{}: {}", counted(set.views.into(), "view"), manifest.display());
    Ok(Answer::Yes)
}

/// A data set, and what all of its views share.
struct Set {
    scene: Scene,
    environment: Environment,
    /// Of the plate, if there is one.
    background_hash: Option<u32>,
    folder: PathBuf,
    views: u32,
    turn: f64,
    rates: Option<[f64; 2]>,
    drop_lists: bool,
}

impl Set {
    fn new(args: &DatasetArgs) -> anyhow::Result<Self> {
        let scene = args.picture.load()?;
        let is_fixed = !scene.background.is_none() || !scene.film.camera.is_empty();
        let turn = args.turn.unwrap_or(if is_fixed { 0.0 } else { 180.0 });
        if turn > 0.0 && is_fixed {
            anyhow::bail!(
                "--turn {turn}: a background and a film say where the camera looks; leave it out"
            );
        }
        if let (Some([low, high]), None) = (args.rates, scene.real_rain()) {
            anyhow::bail!(
                "--rates {low},{high}: this scene has no real rain; give rain.rate, or --rate"
            );
        }
        for rate in args.rates.into_iter().flatten() {
            let mut other = scene.clone();
            if let Some(rain) = other.rain.as_mut().and_then(|rain| rain.real.as_mut()) {
                rain.rate = rate;
            }
            other.validate("--rates")?;
        }
        let environment = super::open_environment(&scene)?;
        // Before anything is written, and before a device is opened.
        let background_hash = Plate::of(&scene)?.hash();
        let views = args.views.unwrap_or(match scene.film.frames() {
            1 => 100,
            frames => frames,
        });
        let folder = args.output.clone();
        let (rates, drop_lists) = (args.rates, !args.no_drop_lists);
        Ok(Self { scene, environment, background_hash, folder, views, turn, rates, drop_lists })
    }

    fn head_path(&self) -> PathBuf {
        self.folder.join("dataset.toml")
    }

    fn head(&self) -> Result<String> {
        // Its files are known by their sums, wherever they lie.
        let scene = self.scene.without_folders();
        let head = Head {
            about: "what the views in this folder are of; `raindrops dataset` compares it",
            version: env!("CARGO_PKG_VERSION"),
            views: self.views,
            turn_degrees: self.turn,
            rates_mm_h: self.rates,
            drop_lists: self.drop_lists,
            environment_hash: format!("{:016x}", self.environment.hash()),
            background_hash: self.background_hash.map(|hash| format!("{hash:08x}")),
            scene: &scene,
        };
        toml::to_string(&head).map_err(|error| Error::write(&self.head_path(), error))
    }

    /// Whether the folder has views of this set.
    ///
    /// # Errors
    /// If it has those of another.
    fn is_begun(&self) -> Result<bool> {
        let (path, text) = (self.head_path(), self.head()?);
        let there = match std::fs::read_to_string(&path) {
            Ok(there) => there,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(false),
            Err(error) => return Err(Error::read(&path, error)),
        };
        if there == text {
            return Ok(true);
        }
        let differs = there.lines().zip(text.lines()).find(|(there, new)| there != new);
        let (there, new) = differs.unwrap_or(("its end", "more or less"));
        let problem =
            format!("it has views of something else (`{there}`, not `{new}`); name another folder");
        Err(Error::Scene { place: self.folder.display().to_string(), problem })
    }

    /// Makes the folder, unless it is there.
    fn begin(&self) -> Result<()> {
        if self.is_begun()? {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder).map_err(|error| Error::write(&self.folder, error))?;
        write_whole(&self.head_path(), self.head()?.as_bytes())
    }

    fn name(view: u32) -> String {
        format!("{view:05}")
    }

    fn record_path(&self, view: u32) -> PathBuf {
        self.folder.join(Self::name(view)).join("view.json")
    }

    /// Whether a view is there, whole.
    fn has(&self, view: u32) -> bool {
        self.record_path(view).exists()
    }

    fn line(&self, view: u32) -> Result<String> {
        let path = self.record_path(view);
        std::fs::read_to_string(&path).map_err(|error| Error::read(&path, error))
    }

    /// The scene of a view, and where its motion ends. Each view has drops of its own.
    fn scene_of(&self, view: u32) -> (Scene, Scene) {
        let mut random =
            Random(self.scene.seed ^ u64::from(view + 1).wrapping_mul(0xd6e8_feb8_6659_fd93));
        let mut base = self.scene.clone();
        base.seed = random.bits() >> 12;
        let turn = (2.0 * random.unit() - 1.0) * self.turn.to_radians();
        let toward = base.camera.target - base.camera.position;
        if turn != 0.0 {
            base.camera.target =
                base.camera.position + DQuat::from_axis_angle(DVec3::Y, turn) * toward;
        }
        // Steps of the golden section cover the range evenly, however many views there are.
        let first = Random(self.scene.seed).unit();
        let share = (first + f64::from(view) * 0.618_033_988_749_894_9).fract();
        if let (Some([low, high]), Some(rain)) =
            (self.rates, base.rain.as_mut().and_then(|rain| rain.real.as_mut()))
        {
            rain.rate = low * (high / low).powf(share);
        }
        let number = if self.scene.film.frames() > 1 { view } else { 0 };
        let frame = base.film.frame(&base, number);
        let until = motion_end(&base, &frame, number);
        (frame, until)
    }
}

/// The scene without rain.
fn dry(scene: &Scene) -> Scene {
    let mut dry = Scene { rain: None, drops: Vec::new(), ..scene.clone() };
    (dry.model.far_rain, dry.model.cutoff_px) = (None, None);
    dry
}

/// Draws views and writes them.
struct Maker<'a> {
    set: &'a Set,
    device: &'a Arc<Device>,
    plan: &'a FramePlan,
    tiles: Option<Grid>,
    clean: Parts<'a>,
    /// What is behind the rain in every view, where the camera stands still before a plate.
    kept: Option<Picture>,
}

impl Maker<'_> {
    fn view(&mut self, view: u32) -> Result<()> {
        let set = self.set;
        let (scene, until) = set.scene_of(view);
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
        let cutoff_px = self.plan.cutoff.as_ref().map(|cutoff| cutoff.px);
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
            optics: self.plan.optics,
            samples: self.plan.samples,
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
            Some(grid) => Ok(radiance_by_parts(&mut self.clean, &dry(scene), grid)?.0),
            None => self.clean.draw_window(&dry(scene))?.0.read_radiance(),
        }
    }

    fn draw_layers(&self, scene: &Scene, until: Scene) -> Result<Layers> {
        // Other drops each time, so nothing but the device's pipelines is kept.
        let mut parts = Parts::new(self.device, &self.set.environment, self.plan);
        parts.move_until(until);
        let (layers, report) = match self.tiles {
            Some(grid) => layers_by_parts(&mut parts, scene, grid)?,
            None => {
                let (renderer, report) = parts.draw_window(scene)?;
                (renderer.read_layers()?, report)
            }
        };
        super::say_undrawn(&report.counts, report.room);
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

/// splitmix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0 to 1.
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// `2/8` to the second of eight.
fn parse_shard(text: &str) -> std::result::Result<Shard, String> {
    text.split_once('/')
        .and_then(|(number, of)| Some(Shard { number: number.parse().ok()?, of: of.parse().ok()? }))
        .filter(|shard| shard.number > 0 && shard.number <= shard.of)
        .ok_or_else(|| format!("'{text}' is not a shard from 1/N to N/N"))
}

fn parse_turn(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|degrees| (0.0..=180.0).contains(degrees))
        .ok_or("give 0 to 180 degrees".into())
}

/// `2,50`.
fn parse_rates(text: &str) -> std::result::Result<[f64; 2], String> {
    let number =
        |text: &str| text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    text.split_once(',')
        .and_then(|(low, high)| Some([number(low)?, number(high)?]))
        .filter(|[low, high]| low <= high)
        .ok_or_else(|| format!("'{text}' is not two rates over 0, the lower one first, like 2,50"))
}
