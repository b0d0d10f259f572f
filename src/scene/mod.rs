//! What to show: pure data from a TOML file and the command line, validated once.
//!
//! An empty file is the paper's benchmark scene: a million drops of radius 1 in a box of ±1025.
//!
//! How a file becomes a scene: `edit.rs` sets keys of the document (`--set`), [`Scene::parse`] reads it by serde, `ranges.rs`
//! holds each number against its range in the schema, `validate.rs` holds values against one another, and `lines.rs` finds the
//! line that a problem is about. What a scene needs of other files, particles and a shelter's map, is read after that.
//!
//! Comments on keys are for users: `schema.rs` makes a JSON Schema of them, from which `docs/scene.md` and
//! `assets/scene.schema.json` are written. `RAINDROPS_WRITE_KEYS=1 cargo test --test house keys` writes both.

pub mod background;
pub mod camera;
mod edit;
mod exposure;
pub mod film;
mod lines;
pub mod matrices;
pub mod model;
pub mod pane;
pub mod particles;
mod placed;
pub mod projection;
mod ranges;
pub mod real_rain;
mod schema;
pub mod shelter;
mod validate;
pub mod water;

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::abi::MOST_POPULATIONS;
use crate::files::{read_text, write_whole};
use crate::optics::{WATER, WATER_RGB};
use crate::rain::Rain;
use crate::scene::background::Background;
use crate::scene::camera::{Camera, View};
#[cfg(feature = "cli")]
pub(crate) use crate::scene::edit::with_keys;
use crate::scene::film::Film;
pub use crate::scene::model::ModelChoice;
use crate::scene::model::{FarRain, Lens, Operator};
pub use crate::scene::pane::Pane;
use crate::scene::particles::Particles;
pub use crate::scene::placed::PlacedDrop;
use crate::scene::real_rain::{RainTables, RealRain};
pub use crate::scene::schema::schema;
pub use crate::scene::shelter::Shelter;
use crate::scene::water::Water;
use crate::{Error, Result};

/// Largest image edge; beyond it float32 pixel coordinates lose their subpixel bits and no device
/// takes the image anyway.
pub const MAX_IMAGE_EDGE: u32 = 32_768;

/// Most drops: an index is a `u32` and the paper's benchmark ends at 4 million.
pub const MAX_DROPS: u32 = 1 << 30;

/// Most times that the rain may cross its box while the shutter is open. Each crossing is one more drop to
/// trace, and a drop that comes by so often is a blur anyway.
pub const MAX_CROSSINGS: f64 = 16.0;

/// Distance in metres beyond which no drop has the size of a pixel, however far rain goes.
const BEYOND: f64 = 1e5;

/// Everything that makes a picture.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// Chooses the drops' starting places; 64 bits.
    pub seed: u64,
    /// When the shutter opens; may be negative, may be huge.
    #[schemars(extend("x-unit" = "s"))]
    pub time: f64,
    /// Length of a scene unit, for what physics needs.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub metres: f64,
    /// The eye.
    pub camera: Camera,
    /// The picture's size.
    pub image: ImageSize,
    /// The radiance from every direction.
    pub environment: EnvironmentChoice,
    /// Random drops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rain: Option<RainSettings>,
    /// Drops placed by hand.
    #[serde(rename = "drop", skip_serializing_if = "Vec::is_empty")]
    pub drops: Vec<PlacedDrop>,
    /// Drops that somebody else simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<Particles>,
    /// Where no random rain falls: below a surface that is in the way of its drops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shelter: Option<Shelter>,
    /// A pane of glass between the camera and the rain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pane: Option<Pane>,
    /// What drops are made of.
    pub water: Water,
    /// What is behind the drops instead of the sky.
    #[serde(skip_serializing_if = "Background::is_none")]
    pub background: Background,
    /// Which models compute it.
    pub model: ModelChoice,
    /// From radiance to display.
    pub tone_map: ToneMap,
    /// What changes from frame to frame of a film.
    #[serde(skip_serializing_if = "Film::is_default")]
    pub film: Film,
    /// Scene seconds a camera second: of a film's frame its pace, else 1.
    #[serde(skip)]
    pub pace: f64,
    /// Most drops that a host gives with each frame in a buffer of its own ([`crate::renderer::HostParticles`]). Only a host's
    /// frames show them.
    #[serde(skip)]
    pub host_particles: u32,
    /// Most drops on the pane that a host gives with each frame in a buffer of its own ([`crate::renderer::HostPaneDrops`]), instead
    /// of those of the pane. Only a host's frames show them.
    #[serde(skip)]
    pub host_pane_drops: u32,
}

/// Size of the picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSize {
    /// Width of the whole picture; the device may take less.
    #[schemars(range(min = 1, max = MAX_IMAGE_EDGE), extend("x-unit" = "px"))]
    pub width: u32,
    /// Its height.
    #[schemars(range(min = 1, max = MAX_IMAGE_EDGE), extend("x-unit" = "px"))]
    pub height: u32,
}

/// Where the radiance comes from: a file, a constant, or (neither) the bundled sky.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentChoice {
    /// A latitude-longitude image, twice as wide as high: EXR, Radiance HDR, PNG or JPEG. Relative to the scene file.
    #[schemars(extend("x-default" = "the bundled sky; with `background.color` guessed from it"))]
    pub file: Option<PathBuf>,
    /// Its layer, of an EXR, by its name or the end of it.
    #[schemars(extend("x-default" = "the finished picture"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// Instead of a file: the same radiance from everywhere, red, green and blue (a white furnace).
    #[schemars(with = "Option<[f32; 3]>", extend("minimum" = 0))]
    pub radiance: Option<Vec3>,
}

/// The random drops of a scene file: equal ones in a box, or real rain.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "RainTables", into = "RainTables")]
pub struct RainSettings {
    /// Chooses their starting places; none: the scene's.
    pub seed: Option<u64>,
    /// How many; 0 for real rain.
    pub count: u32,
    /// Half the edges of the box that holds them, centred on the camera, in scene units.
    pub half_extent: DVec3,
    /// Their radius, in scene units.
    pub radius: f64,
    /// Their velocity, in scene units a second.
    pub velocity: DVec3,
    /// Real rain instead of drops in a box.
    pub real: Option<RealRain>,
    /// More drops, in boxes of their own, one population after the other.
    pub others: [Option<Population>; MOST_POPULATIONS as usize - 1],
}

/// Equal drops in a box, beside others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Population {
    /// Chooses their starting places; none: the scene's, and one for each population before.
    pub seed: Option<u64>,
    /// How many.
    pub count: u32,
    /// Half of the box's edges, like [`RainSettings::half_extent`].
    pub half_extent: DVec3,
    /// Radius of each drop, like [`RainSettings::radius`].
    pub radius: f64,
    /// Velocity of each drop, like [`RainSettings::velocity`].
    pub velocity: DVec3,
}

impl RainSettings {
    /// Real rain.
    pub fn of(rain: RealRain) -> Self {
        Self { count: 0, real: Some(rain), ..Self::default() }
    }

    /// Every population of drops in boxes; of real rain one without drops.
    fn populations(&self) -> impl Iterator<Item = Population> + use<> {
        let Self { seed, count, half_extent, radius, velocity, others, .. } = *self;
        let first = Population { seed, count, half_extent, radius, velocity };
        std::iter::once(first).chain(others.into_iter().flatten())
    }
}

/// From radiance to display colour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ToneMap {
    /// The operator.
    pub operator: Operator,
    /// What the log-average luminance is mapped to before compression, the "key" of the scene.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub key: f64,
    /// A fixed factor on linear radiance before the curve.
    #[schemars(range(min = 1e-30, max = 1e30), extend(
        "x-default" = "`key` over each picture's log-average luminance; 1 with operator `none`",
        "x-advice" = "it is a factor on radiance, not stops"
    ))]
    pub exposure: Option<f64>,
}

impl ToneMap {
    /// Whether the exposure depends on the picture.
    pub fn derives_exposure(&self) -> bool {
        self.operator == Operator::Photographic && self.exposure.is_none()
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            seed: 1,
            time: 0.0,
            metres: 1.0,
            camera: Camera::default(),
            image: ImageSize::default(),
            environment: EnvironmentChoice::default(),
            rain: Some(RainSettings::default()),
            drops: Vec::new(),
            particles: None,
            shelter: None,
            pane: None,
            water: Water::default(),
            background: Background::default(),
            model: ModelChoice::default(),
            tone_map: ToneMap::default(),
            film: Film::default(),
            pace: 1.0,
            host_particles: 0,
            host_pane_drops: 0,
        }
    }
}

impl Default for ImageSize {
    fn default() -> Self {
        Self { width: 1024, height: 1024 }
    }
}

impl Default for RainSettings {
    fn default() -> Self {
        Self {
            count: 1_000_000,
            half_extent: DVec3::splat(1025.0),
            radius: 1.0,
            velocity: DVec3::new(0.0, -9.0, 0.0),
            seed: None,
            real: None,
            others: [None; MOST_POPULATIONS as usize - 1],
        }
    }
}

impl Default for ToneMap {
    fn default() -> Self {
        Self { operator: Operator::Photographic, key: 0.18, exposure: None }
    }
}

impl Scene {
    /// Reads and validates a scene file, with the particles that it shows at its time. Relative paths in it are from its
    /// folder.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read; [`Error::Scene`] as [`Scene::parse`]; those of
    /// [`Scene::read_particles`] and [`Scene::read_shelter`].
    pub fn load(path: &Path) -> Result<Self> {
        let mut scene = Self::load_alone(path)?;
        scene.read_particles()?;
        scene.read_shelter()?;
        Ok(scene)
    }

    /// Reads it without its particles and the map of its shelter.
    fn load_alone(path: &Path) -> Result<Self> {
        Self::parse_in(&read_text(path)?, &path.display().to_string(), path.parent())
    }

    /// Like [`Scene::parse`], with paths from a folder.
    fn parse_in(text: &str, name: &str, folder: Option<&Path>) -> Result<Self> {
        let mut scene = Self::parse(text, name)?;
        if let Some(folder) = folder {
            scene.files_mut().for_each(|file| *file = folder.join(&*file));
        }
        Ok(scene)
    }

    /// Writes a scene file that [`Scene::load`] reads back as the same scene, wherever it lies.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        let mut scene = self.clone();
        for file in scene.files_mut() {
            // Relative to the new file it would be another one.
            *file = std::path::absolute(&*file).map_err(|error| Error::write(path, error))?;
        }
        if scene.rain.is_none() && !scene.names_drops() {
            // Left out, rain would be the default one.
            scene.rain = Some(RainSettings { count: 0, ..RainSettings::default() });
        }
        let text = toml::to_string(&scene).map_err(|error| Error::write(path, error))?;
        write_whole(path, text.as_bytes())
    }

    /// The scene with files by their names alone, for whoever compares files by their content, wherever they lie.
    #[cfg(feature = "cli")]
    pub(crate) fn without_folders(&self) -> Self {
        let mut scene = self.clone();
        for file in scene.files_mut() {
            *file = file.file_name().map_or_else(|| file.clone(), PathBuf::from);
        }
        scene
    }

    /// The files that it names.
    fn files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let Background { color, depth, .. } = &mut self.background;
        let particles = self.particles.as_mut().map(|particles| &mut particles.file);
        // A map that was made in memory has no file.
        let shelter = self.shelter.as_mut().map(|shelter| &mut shelter.height);
        let shelter = shelter.filter(|height| !height.as_os_str().is_empty());
        let others = particles.into_iter().chain(shelter);
        [&mut self.environment.file, color, depth].into_iter().flatten().chain(others)
    }

    /// Parses and validates the text of a scene file; `name` stands for it in messages.
    ///
    /// # Errors
    /// [`Error::Scene`] with the line if it is no TOML, a key is unknown or a value is of another type, and for
    /// what [`Scene::validate`] refuses.
    pub fn parse(text: &str, name: &str) -> Result<Self> {
        let mut scene: Scene = toml::from_str(text).map_err(|error| {
            let (line, problem) = lines::of_reader(text, &error);
            Error::Scene { place: format!("{name}:{line}"), problem }
        })?;
        // The default scene's rain is for files that name no drops at all.
        let names_rain = text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("rain"));
        if scene.names_drops() && !names_rain {
            scene.rain = None;
        }
        validate::problem(&scene).map_err(|problem| {
            let place = match lines::line_of(text, &problem) {
                Some(line) => format!("{name}:{line}"),
                None => name.into(),
            };
            Error::Scene { place, problem }
        })?;
        Ok(scene)
    }

    /// Whether it names drops or a pane. If it does, a scene without `[rain]` has no rain; else it has the default one.
    fn names_drops(&self) -> bool {
        !self.drops.is_empty() || self.particles.is_some() || self.pane.is_some()
    }

    /// Refractive index inside drops over that outside, for red, green and blue. Where nothing is said, that
    /// of the paper; of real rain those of water at the sRGB primaries.
    pub fn indices(&self) -> [f64; 3] {
        let is_real = self.real_rain().is_some();
        self.water.relative(if is_real { WATER_RGB } else { [WATER; 3] })
    }

    /// Radius of the lens in what is drawn, in scene units; 0: a pinhole, also where one is asked for.
    pub fn drawn_lens(&self) -> f64 {
        if self.model.lens == Some(Lens::Pinhole) { 0.0 } else { 0.5 * self.camera.aperture }
    }

    /// Width and height in pixels of the picture that is drawn: the image, or the camera's window of it.
    pub fn picture_size(&self) -> (u32, u32) {
        let view = self.view();
        (view.width, view.height)
    }

    /// The scene with the whole picture in the camera's window.
    pub fn whole(&self) -> Self {
        let camera = Camera { window: camera::WHOLE, ..self.camera };
        Self { camera, ..self.clone() }
    }

    /// The scene without rain.
    pub fn without_rain(&self) -> Self {
        let mut dry = Self { rain: None, ..self.clone() }.without_placed();
        (dry.model.far_rain, dry.model.cutoff_px, dry.model.thinned_px) = (None, None, None);
        dry
    }

    /// The scene without drops that have a place.
    fn without_placed(self) -> Self {
        Self { drops: Vec::new(), particles: None, host_particles: 0, ..self }
    }

    /// This rain as a medium, without a single drop: drops of real rain under a pixel are the medium, and a near plane beyond all
    /// larger ones leaves these out. Other rain, and real rain that is drawn without a medium, is left out.
    pub fn as_medium(&self) -> Self {
        let has_medium = self.model.far_rain != Some(FarRain::None);
        let Some(rain) = self.real_rain().filter(|_| has_medium) else {
            return self.without_rain();
        };
        let mut misty = self.clone().without_placed();
        misty.camera.near = rain.extent.min(BEYOND) / self.metres;
        (misty.model.far_rain, misty.model.cutoff_px) = (Some(FarRain::Medium), Some(1.0));
        misty
    }

    /// The camera's frame for this scene's image, or its window of it.
    pub fn view(&self) -> View {
        self.camera.view(self.image.width, self.image.height)
    }

    /// The first population of random drops in a box; none if the scene has real rain, or names only drops placed by hand.
    pub fn rain(&self) -> Option<Rain> {
        self.populations().first().copied()
    }

    /// All populations of random drops in boxes. The indices of their drops follow one another.
    pub fn populations(&self) -> Vec<Rain> {
        let Some(rain) = self.rain.filter(|rain| rain.real.is_none()) else { return Vec::new() };
        let each = (0..).zip(rain.populations()).map(|(number, population)| {
            let Population { seed, count, half_extent, radius, velocity } = population;
            let seed = seed.unwrap_or(self.seed.wrapping_add(number));
            Rain { seed, count, half_extent, radius, velocity }
        });
        each.collect()
    }

    /// Real rain; none if the scene has none.
    pub fn real_rain(&self) -> Option<RealRain> {
        self.rain.and_then(|rain| rain.real)
    }

    /// Number of random drops in boxes.
    pub fn random_count(&self) -> u32 {
        let all = self.rain.into_iter().flat_map(|rain| rain.populations());
        all.fold(0, |sum, population| sum.saturating_add(population.count))
    }

    /// Sets the number of random drops in boxes: the first population has what the others leave. 0 leaves no
    /// rain at all, nor real rain.
    ///
    /// # Errors
    /// [`Error::Scene`] if the others have more.
    pub fn set_random_count(&mut self, count: u32) -> Result<()> {
        let rain = self.rain.get_or_insert_default();
        if count == 0 {
            (rain.others, rain.real) = (Default::default(), None);
        }
        let others = rain.populations().skip(1).map(|population| u64::from(population.count));
        let others: u64 = others.sum();
        let first = u64::from(count).checked_sub(others).ok_or_else(|| {
            let of_others = format!("{others} of populations after the first");
            Error::scene("rain", format!("count = {count} in all, and {of_others}"))
        })?;
        rain.count = first as u32;
        Ok(())
    }
}
