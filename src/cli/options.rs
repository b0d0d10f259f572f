//! Options that several commands share: the scene and its overrides, the device.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use crate::Result;
use crate::gpu::{Device, Instance, Validation};
use crate::model::{Operator, Optics, Preset, Simulation};
use crate::scene::Scene;

/// A scene and the values that the command line sets in it.
#[derive(Args, Clone, Debug, Default)]
pub struct SceneArgs {
    /// Scene file (TOML); left out: the paper's benchmark scene
    scene: Option<PathBuf>,
    /// Number of random drops
    #[arg(long, value_name = "N")]
    drops: Option<u32>,
    #[command(flatten)]
    values: SceneValues,
}

/// Values of a scene that a command line can set, the drop count apart.
#[derive(Args, Clone, Debug, Default)]
pub struct SceneValues {
    /// Seed of the random drops
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Scene time in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Environment image: latitude-longitude EXR, HDR, PNG or JPEG
    #[arg(long, value_name = "FILE")]
    environment: Option<PathBuf>,
    /// How the light leaving a drop is found
    #[arg(long, value_enum, value_name = "NAME")]
    optics: Option<Optics>,
    /// Where the drops' positions come from
    #[arg(long, value_enum, value_name = "NAME")]
    simulation: Option<Simulation>,
    /// Edge of the mask's finest level in texels
    #[arg(long, value_name = "N")]
    mask_size: Option<u32>,
    /// Tone mapping operator
    #[arg(long, value_enum, value_name = "NAME")]
    tone_map: Option<Operator>,
}

/// `--preset` and `--samples`, for commands that render one variant.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct ModelArgs {
    /// Models, all axes at once
    #[arg(long, value_enum, value_name = "NAME")]
    preset: Option<Preset>,
    /// Rays a pixel, where the model follows rays
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
}

impl ModelArgs {
    /// Sets the values that were given.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        scene.model.preset = self.preset.unwrap_or(scene.model.preset);
        scene.model.samples = self.samples.or(scene.model.samples);
        scene.validate("command line")
    }
}

impl SceneArgs {
    /// The scene file with the command line's values set in it, validated.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = self.values.load(self.scene.as_deref())?;
        if let Some(count) = self.drops {
            scene.rain.get_or_insert_default().count = count;
            scene.validate("command line")?;
        }
        Ok(scene)
    }
}

impl SceneValues {
    /// The scene of `file`, or the default one, with these values set in it, validated.
    pub fn load(&self, file: Option<&std::path::Path>) -> Result<Scene> {
        let mut scene = match file {
            Some(path) => Scene::load(path)?,
            None => Scene::default(),
        };
        scene.seed = self.seed.unwrap_or(scene.seed);
        scene.time = self.time.unwrap_or(scene.time);
        if let Some((width, height)) = self.size {
            (scene.image.width, scene.image.height) = (width, height);
        }
        if let Some(file) = &self.environment {
            scene.environment.file = Some(file.clone());
            scene.environment.radiance = None;
        }
        scene.model.optics = self.optics.or(scene.model.optics);
        scene.model.simulation = self.simulation.or(scene.model.simulation);
        scene.model.mask_size = self.mask_size.unwrap_or(scene.model.mask_size);
        scene.tone_map.operator = self.tone_map.unwrap_or(scene.tone_map.operator);
        scene.validate("command line")?;
        Ok(scene)
    }
}

/// `1920x1080` to (1920, 1080).
fn parse_size(text: &str) -> Result<(u32, u32), String> {
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .ok_or_else(|| format!("'{text}' is not a size like 1024x1024"))
}

/// Which device, and whether validation watches it.
#[derive(Args, Clone, Debug, Default)]
pub struct DeviceArgs {
    /// Vulkan device: a part of its name, or its index in `raindrops devices`
    #[arg(long, value_name = "NAME|INDEX")]
    pub device: Option<String>,
    /// Load the Khronos validation layer, with synchronization checks; any message is an error
    #[arg(long)]
    pub validate: bool,
}

impl DeviceArgs {
    /// Loads Vulkan.
    pub fn instance(&self) -> Result<Arc<Instance>> {
        Instance::new(if self.validate { Validation::On } else { Validation::Off })
    }

    /// Opens the device and says on stderr which one.
    pub fn open(&self) -> Result<Arc<Device>> {
        let instance = self.instance()?;
        let report = instance.choose(self.device.as_deref())?;
        eprintln!("device: {}", report.summary());
        Device::open(&instance, report)
    }
}
