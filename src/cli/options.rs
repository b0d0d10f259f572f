//! Options that several commands share: the scene and its overrides.

use std::path::PathBuf;

use clap::Args;

use super::aliases::Aliases;
use super::device::DeviceArgs;
use crate::scene::background::DepthKind;
use crate::scene::model::{Operator, Preset};
use crate::scene::real_rain::RealRain;
use crate::scene::{ModelChoice, RainSettings, Scene};
use crate::thousands::counted;
use crate::{Error, Result};

/// A scene and the values that the command line sets in it.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Scene")]
pub struct SceneArgs {
    /// Scene file (TOML) [default: the paper's benchmark scene]
    scene: Option<PathBuf>,
    /// Number of random drops: 125000, 125k, 4M
    #[arg(long, value_name = "N", value_parser = parse_drops)]
    drops: Option<u32>,
    #[command(flatten)]
    rain: RainValues,
    #[command(flatten)]
    values: SceneValues,
}

/// Values of real rain that a command line can set.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Real rain")]
pub struct RainValues {
    /// Rain rate in mm/h, in place of a number of equal drops
    #[arg(long, value_name = "MM/H", allow_negative_numbers = true)]
    rate: Option<f64>,
    #[command(flatten)]
    keys: Aliases<RainSettings>,
}

impl RainValues {
    /// Sets the values that were given. `is_chosen`: whether the scene's rain is of a file or an option.
    fn apply(&self, scene: &mut Scene, is_chosen: bool) -> Result<()> {
        let refuse = |problem: String| Err(Error::Scene { place: "command line".into(), problem });
        if *self == Self::default() {
            return Ok(());
        }
        let boxed = scene.rain.filter(|rain| rain.real.is_none() && rain.count > 0 && is_chosen);
        if let (Some(rate), Some(rain)) = (self.rate, boxed) {
            let drops = counted(rain.count.into(), "drop");
            return refuse(format!(
                "--rate {rate}: the scene has {drops} in a box already; --drops 0 leaves them out"
            ));
        }
        let Some(rate) = self.rate.or(scene.real_rain().map(|rain| rain.rate)) else {
            return refuse("the scene has no rain by its rate: give --rate 25".into());
        };
        let rain = RealRain { rate, ..scene.real_rain().unwrap_or_default() };
        scene.rain = Some(self.keys.set_in(RainSettings::of(rain))?);
        scene.validate("command line")
    }
}

/// Values of a scene that a command line can set, the drop count apart.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Scene")]
pub struct SceneValues {
    /// Set any key of the scene: --set rain.rate=50 --set camera.position=0,2,0 --set model.fresnel=schlick
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Seed of the random drops
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Scene time in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Seconds for which the shutter is open: 1/60 or 0.0167; 0 is an instant
    #[arg(long, value_name = "S", value_parser = parse_shutter)]
    shutter: Option<f64>,
    /// Environment image: latitude-longitude EXR, HDR, PNG or JPEG
    #[arg(long, value_name = "FILE")]
    environment: Option<PathBuf>,
    /// Tone mapping operator
    #[arg(long, value_enum, value_name = "NAME", hide = true)]
    tone_map: Option<Operator>,
    /// Fixed factor on linear radiance before the curve (not stops) [default: derived from each picture]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    exposure: Option<f64>,
}

/// What is behind the drops, over the scene's.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Background")]
pub struct BackgroundArgs {
    /// Picture behind the drops instead of the sky, of the picture's size: linear EXR; PNG or JPEG in sRGB
    #[arg(long, value_name = "FILE")]
    background: Option<PathBuf>,
    /// Depth behind the drops: channel Z of an EXR, or a 16-bit PNG with --depth-scale
    #[arg(long, value_name = "FILE")]
    depth: Option<PathBuf>,
    /// Whether --depth is along the view axis or along the ray
    #[arg(long, value_enum, value_name = "KIND")]
    depth_kind: Option<DepthKind>,
    /// Scene units for one stored unit of --depth
    #[arg(long, value_name = "S")]
    depth_scale: Option<f64>,
}

impl BackgroundArgs {
    /// Sets the values that were given.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        let background = &mut scene.background;
        background.color = self.background.clone().or(background.color.take());
        background.depth = self.depth.clone().or(background.depth.take());
        background.depth_kind = self.depth_kind.unwrap_or(background.depth_kind);
        background.depth_scale = self.depth_scale.or(background.depth_scale);
        scene.validate("command line")
    }
}

/// `--preset` and other keys of the model, for commands that render one variant.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Models")]
pub struct ModelArgs {
    /// A set of models; `--set model.KEY=VALUE` changes single ones
    #[arg(long, value_enum, value_name = "NAME")]
    preset: Option<Preset>,
    /// Largest RMS error that preset auto may make, tone mapped, over 0 to 1
    #[arg(long, value_name = "E")]
    error: Option<f64>,
    /// Milliseconds that preset auto may take for a frame on this device
    #[arg(long, value_name = "MS")]
    budget_ms: Option<f64>,
    #[command(flatten)]
    keys: Aliases<ModelChoice>,
}

impl ModelArgs {
    /// Sets the values that were given.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        scene.model.take_preset(self.preset.unwrap_or(scene.model.preset));
        scene.model.error = self.error.or(scene.model.error);
        scene.model.budget_ms = self.budget_ms.or(scene.model.budget_ms);
        scene.model = self.keys.set_in(scene.model)?;
        scene.validate("command line")
    }
}

impl SceneArgs {
    /// The scene file's name, or what stands in for it.
    pub fn name(&self) -> String {
        let file = self.scene.as_deref().and_then(std::path::Path::file_name);
        file.map_or("the paper's scene".into(), |name| name.to_string_lossy().into_owned())
    }

    /// Whether nothing was given.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The scene file with the command line's values set in it, validated.
    pub fn load(&self) -> Result<Scene> {
        let mut values = self.values.clone();
        if let Some(rate) = self.rain.rate.filter(|_| values.sets("rain.")) {
            // Keys of real rain are read with the rate that makes it.
            values.set.insert(0, format!("rain.rate={rate}"));
        }
        let mut scene = values.load(self.scene.as_deref())?;
        if let Some(count) = self.drops {
            scene.set_random_count(count)?;
            scene.validate("command line")?;
        }
        self.rain.apply(&mut scene, self.scene.is_some() || self.drops.is_some())?;
        Ok(scene)
    }
}

impl SceneValues {
    /// Whether `--set` is given for a key that begins so.
    fn sets(&self, start: &str) -> bool {
        self.set.iter().any(|edit| edit.trim_start().starts_with(start))
    }

    /// The scene of `file`, or the default one, with these values set in it, validated.
    pub fn load(&self, file: Option<&std::path::Path>) -> Result<Scene> {
        let mut scene = Scene::load_edited(file, &self.set)?;
        scene.seed = self.seed.unwrap_or(scene.seed);
        scene.time = self.time.unwrap_or(scene.time);
        if let Some((width, height)) = self.size {
            (scene.image.width, scene.image.height) = (width, height);
        }
        if let Some(seconds) = self.shutter {
            (scene.camera.shutter, scene.camera.shutter_angle) = (seconds, None);
        }
        if let Some(file) = &self.environment {
            scene.environment.file = Some(file.clone());
            scene.environment.radiance = None;
        }
        scene.tone_map.operator = self.tone_map.unwrap_or(scene.tone_map.operator);
        scene.tone_map.exposure = self.exposure.or(scene.tone_map.exposure);
        scene.validate("command line")?;
        scene.read_particles()?;
        scene.read_shelter()?;
        Ok(scene)
    }
}

/// `125000`, `125k` or `0.125M` to 125,000.
pub fn parse_drops(text: &str) -> Result<u32, String> {
    let (digits, factor) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 1e3),
        None => text.strip_suffix(['m', 'M']).map_or((text, 1.0), |digits| (digits, 1e6)),
    };
    let is_plain = |text: &str| text.chars().all(|c| c.is_ascii_digit() || c == '.');
    // `bench --drops 125,000` would be 125 drops and none.
    let is_group = text.len() > 1 && text.bytes().all(|digit| digit == b'0');
    let count = digits.parse().ok().filter(|_| is_plain(digits) && !is_group);
    let count = count.map(|count: f64| count * factor);
    // 4.1 times a million is a whole number but for rounding.
    let is_whole = |count: &f64| (count - count.round()).abs() <= 1e-15 * count;
    let whole = count.filter(|count| is_whole(count) && *count <= f64::from(u32::MAX));
    whole
        .map(|count| count.round() as u32)
        .ok_or_else(|| "give a whole number without commas, such as 125000, 125k or 4M".into())
}

/// `1/60` or `0.0167` to seconds.
fn parse_shutter(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let seconds = match text.split_once('/') {
        Some((over, under)) => number(over).zip(number(under)).map(|(over, under)| over / under),
        None => number(text),
    };
    let seconds = seconds.filter(|seconds| seconds.is_finite() && *seconds >= 0.0);
    seconds.ok_or_else(|| format!("'{text}' is no time such as 1/60 or 0.0167, in seconds"))
}

/// `1920x1080` to (1920, 1080).
fn parse_size(text: &str) -> Result<(u32, u32), String> {
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .ok_or_else(|| format!("'{text}' is not a size like 1024x1024"))
}

/// A scene before its background, by its models, and the device that draws it.
#[derive(Args, Clone, Debug, Default)]
pub struct PictureArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    background: BackgroundArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    pub(super) device: DeviceArgs,
}

impl PictureArgs {
    /// The scene.
    ///
    /// # Errors
    /// [`Error::Scene`] for what makes no scene, and those of its files.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = self.scene.load()?;
        self.model.apply(&mut scene)?;
        self.background.apply(&mut scene)?;
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::{parse_drops, parse_shutter};

    #[test]
    fn exposures() {
        assert_eq!((parse_shutter("0"), parse_shutter("0.004")), (Ok(0.0), Ok(0.004)));
        assert_eq!(parse_shutter("1/250"), Ok(0.004));
        for wrong in ["", "/", "1/0", "0/0", "-1", "1/-60", "nan", "inf", "1/60 s"] {
            assert!(parse_shutter(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_of_drops() {
        for (text, count) in [("0", 0), ("125000", 125_000), ("125k", 125_000), ("4M", 4_000_000)] {
            assert_eq!(parse_drops(text), Ok(count), "{text}");
        }
        assert_eq!((parse_drops("0.5K"), parse_drops("0.000001m")), (Ok(500), Ok(1)));
        for thousandths in (0..10_000_000_u32).step_by(7) {
            let text = format!("{}.{:03}k", thousandths / 1000, thousandths % 1000);
            assert_eq!(parse_drops(&text), Ok(thousandths), "{text}");
        }
        assert_eq!(
            (parse_drops("4.1M"), parse_drops("0.1234567M").is_err()),
            (Ok(4_100_000), true)
        );
        for wrong in
            ["", "k", "1e4", "125,000", "000", "-1", "1.5", "0.0001k", "nan", "5000M", "1 k"]
        {
            assert!(parse_drops(wrong).is_err_and(|told| told.contains("125k")), "{wrong}");
        }
    }
}
