//! What a data set is of, and its views' scenes.

use std::path::PathBuf;

use glam::{DQuat, DVec3};
use serde::Serialize;

use super::DatasetArgs;
use crate::environment::Environment;
use crate::files::{read_text, read_text_if_there, write_whole};
use crate::picture::plate::Plate;
use crate::scene::{Pane, Scene};
use crate::{Error, Result};

/// Rain on a pane that `--pane-ages` puts before a scene without real rain, mm/h.
const USUAL_RATE: f64 = 5.0;

/// What a data set is of: `dataset.toml`.
#[derive(Serialize)]
struct Head<'a> {
    about: &'static str,
    version: &'static str,
    views: u32,
    turn_degrees: f64,
    rates_mm_h: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pane_ages_s: Option<[f64; 2]>,
    drop_lists: bool,
    /// Sets without are as those of older programs.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    masks: bool,
    environment_hash: String,
    background_hash: Option<String>,
    scene: &'a Scene,
}

/// A data set, and what all of its views share.
pub(super) struct Set {
    pub(super) scene: Scene,
    pub(super) environment: Environment,
    /// Hash of the plate, if there is one.
    background_hash: Option<u32>,
    pub(super) folder: PathBuf,
    pub(super) views: u32,
    turn: f64,
    rates: Option<[f64; 2]>,
    ages: Option<[f64; 2]>,
    pub(super) drop_lists: bool,
    pub(super) masks: bool,
}

impl Set {
    /// Fails if the options do not fit the scene.
    pub(super) fn new(args: &DatasetArgs) -> anyhow::Result<Self> {
        let mut scene = args.picture.load()?;
        if args.pane_ages.is_some() {
            let rate = scene.real_rain().is_none().then_some(USUAL_RATE);
            let leaning = Pane { distance: Some(0.2), tilt: Some(30.0), rate, ..Pane::default() };
            scene.pane.get_or_insert(leaning);
        }
        for age in args.pane_ages.into_iter().flatten() {
            aged(&scene, age).validate("--pane-ages")?;
        }
        let is_fixed = !scene.background.is_none() || !scene.film.camera.is_empty();
        // A camera that turns would look past a pane that stands.
        let looks_through = scene.pane.as_ref().is_some_and(Pane::stands);
        let turn = args.turn.unwrap_or(if is_fixed || looks_through { 0.0 } else { 180.0 });
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
        let environment = crate::cli::open_environment(&scene)?;
        // Before anything is written, and before a device is opened.
        let background_hash = Plate::of(&scene)?.hash();
        let views = args.views.unwrap_or(match scene.film.frames() {
            1 => 100,
            frames => frames,
        });
        let folder = args.output.clone();
        Ok(Self {
            scene,
            environment,
            background_hash,
            folder,
            views,
            turn,
            rates: args.rates,
            ages: args.pane_ages,
            drop_lists: !args.no_drop_lists,
            masks: args.masks,
        })
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
            pane_ages_s: self.ages,
            drop_lists: self.drop_lists,
            masks: self.masks,
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
    pub(super) fn is_begun(&self) -> Result<bool> {
        let (path, text) = (self.head_path(), self.head()?);
        let Some(there) = read_text_if_there(&path)? else { return Ok(false) };
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
    pub(super) fn begin(&self) -> Result<()> {
        if self.is_begun()? {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder).map_err(|error| Error::write(&self.folder, error))?;
        write_whole(&self.head_path(), self.head()?.as_bytes())
    }

    pub(super) fn name(view: u32) -> String {
        format!("{view:05}")
    }

    pub(super) fn record_path(&self, view: u32) -> PathBuf {
        self.folder.join(Self::name(view)).join("view.json")
    }

    /// Whether a view is there, whole.
    pub(super) fn has(&self, view: u32) -> bool {
        self.record_path(view).exists()
    }

    pub(super) fn line(&self, view: u32) -> Result<String> {
        read_text(&self.record_path(view))
    }

    /// The scene of a view, and where its motion ends. Each view has drops of its own.
    pub(super) fn scene_of(&self, view: u32) -> (Scene, Scene) {
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
        if let Some([low, high]) = self.ages {
            // Another sequence, so that heavy rain falls for short times and for long ones.
            let share = (first + f64::from(view) * 0.754_877_666_246_692_7).fract();
            base = aged(&base, low * (high / low).powf(share));
        }
        let number = if self.scene.film.frames() > 1 { view } else { 0 };
        let frame = base.film.frame(&base, number);
        let until = base.motion_end(&frame, number);
        (frame, until)
    }
}

/// The scene with a pane of this age, seconds.
fn aged(scene: &Scene, age: f64) -> Scene {
    let mut aged = scene.clone();
    aged.pane = aged.pane.map(|pane| Pane { age: Some(age), ..pane });
    aged
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
