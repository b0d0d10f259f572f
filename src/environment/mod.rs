//! Radiance from every direction at infinity: a latitude-longitude image, made safe.
//!
//! Seen from inside: the centre column is -z, +x lies a quarter to the right of it, the top row is
//! +y: u = 1/2 + atan2(x, -z) / 2π, v = acos(y) / π.
//!
//! Whatever the source, the texels pass through [`Environment::from_texels`], which leaves none
//! that is negative or not finite: one such texel in a bilinear fetch or in a log-average makes a
//! whole picture NaN.

pub mod bright;
pub mod guess;
pub mod levels;
mod load;
mod mend;
mod open_exr;
pub mod ordinary;
pub mod sky;

use std::f64::consts::PI;
use std::path::Path;

use glam::{DVec3, Vec3};

pub use self::mend::Mended;
use crate::scene::EnvironmentChoice;
use crate::{Error, Result};

/// Most texels across. Twice what 8K panoramas have; beyond it the texels alone take over 1.6 GB
/// and many devices refuse the image.
pub const MAX_WIDTH: u32 = 16_384;

/// Most texels down.
pub const MAX_HEIGHT: u32 = 8_192;

/// The sky that `raindrops sky` computes, 512 x 256, float16.
const BUNDLED_SKY: &[u8] = include_bytes!("../../assets/sky.exr");

/// Luminance of linear Rec. 709 colour.
pub const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Radiance from every direction, finite and nowhere negative.
#[derive(Clone, Debug)]
pub struct Environment {
    name: String,
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
    mended: Mended,
}

impl Environment {
    /// What a scene asks for: its file, its constant radiance, or (neither) the bundled sky.
    ///
    /// # Errors
    /// As [`Environment::load`]; a constant that is negative or not finite.
    pub fn open(choice: &EnvironmentChoice) -> Result<Self> {
        match (&choice.file, choice.radiance) {
            (Some(file), _) => Self::load(file),
            (None, Some(radiance)) if radiance.is_finite() && radiance.min_element() >= 0.0 => {
                Ok(Self::constant(radiance))
            }
            (None, Some(radiance)) => Err(Error::Environment {
                path: constant_name(radiance).into(),
                problem: "the radiance must be finite and at least 0".into(),
            }),
            (None, None) => Self::bundled(),
        }
    }

    /// Loads an image file, whose first bytes, not its name, tell its format:
    ///
    /// - OpenEXR, every compression but HTJ2K: the first layer that has channels R, G, B (half,
    ///   float or u32; else a group such as `Combined.R`, …; else luminance Y alone). Alpha is left
    ///   out: the colours already are radiance. What the data window leaves out of the display
    ///   window is black.
    /// - Radiance HDR: the stored values, without the header's EXPOSURE, as other programs do it.
    /// - PNG and JPEG: sRGB, decoded to linear radiance of 0 to 1.
    ///
    /// Memory: 12 bytes a texel (1.6 GB for the largest image), as much again while PNG and JPEG are decoded.
    ///
    /// # Errors
    /// [`Error::Environment`], one line, for a file that cannot be read, is none of these, is cut
    /// off or broken, is over [`MAX_WIDTH`] x [`MAX_HEIGHT`] (known from its header, before memory
    /// is taken for it), is not twice as wide as it is high, or has no finite texel.
    pub fn load(path: &Path) -> Result<Self> {
        let name = match path.file_stem() {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => path.display().to_string(),
        };
        load::from_file(path)
            .and_then(|image| Self::from_image(name, image))
            .map_err(|problem| Error::Environment { path: path.into(), problem })
    }

    /// An image file's content, in memory; else as [`Environment::load`].
    ///
    /// # Errors
    /// As [`Environment::load`], with `name` for the path.
    pub fn from_bytes(name: impl Into<String>, bytes: &[u8]) -> Result<Self> {
        let name = name.into();
        load::from_bytes(bytes)
            .and_then(|image| Self::from_image(name.clone(), image))
            .map_err(|problem| Error::Environment { path: name.into(), problem })
    }

    /// A hash of the texels (FNV-1a, 64 bits), by which other texels are told apart; not by whoever
    /// means to deceive.
    pub fn hash(&self) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(&self.texels);
        let basis = 0xcbf2_9ce4_8422_2325 ^ u64::from(self.width);
        bytes
            .iter()
            .fold(basis, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
    }

    /// The sky that comes with the program, made by `raindrops sky`.
    ///
    /// # Errors
    /// None for an intact program: the sky is a part of it and a test loads it.
    pub fn bundled() -> Result<Self> {
        Self::from_bytes("sky (bundled)", BUNDLED_SKY)
    }

    /// The same radiance from everywhere: a white furnace.
    pub fn constant(radiance: Vec3) -> Self {
        Self {
            name: constant_name(radiance),
            width: 4,
            height: 2,
            texels: vec![radiance; 8],
            mended: Mended::default(),
        }
    }

    /// An environment of `width * height` texels of linear radiance, row by row from the top.
    /// Texels that are negative or not finite are mended and counted, see [`Mended`]; all others
    /// stay as they are, however bright.
    ///
    /// # Errors
    /// [`Error::Environment`] with `name` for its path: a number of texels that is not
    /// `width * height`, a shape or size as [`Environment::load`] refuses it, no finite texel.
    pub fn from_texels(
        name: impl Into<String>,
        width: u32,
        height: u32,
        texels: Vec<Vec3>,
    ) -> Result<Self> {
        let name = name.into();
        let image = Image { width, height, texels, missing: 0 };
        Self::from_image(name.clone(), image)
            .map_err(|problem| Error::Environment { path: name.into(), problem })
    }

    fn from_image(name: String, image: Image) -> Result<Self, String> {
        let Image { width, height, mut texels, missing } = image;
        load::check_size(u64::from(width), u64::from(height))?;
        if texels.len() != width as usize * height as usize {
            return Err(format!("has {} texels, not {width} x {height}", texels.len()));
        }
        let mended = Mended { missing, ..mend::mend(&mut texels, width as usize)? };
        Ok(Self { name, width, height, texels, mended })
    }

    /// What tables call it: the file's stem, `sky (bundled)`, `constant 1`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Texels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels down, half of those across.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Linear radiance, row by row from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// What had to be made safe; its `Display` is a log line.
    pub fn mended(&self) -> Mended {
        self.mended
    }

    /// Largest component of all texels. Over 65 504 the texels must be scaled to fit into float16.
    pub fn max_radiance(&self) -> f32 {
        self.texels.iter().map(|texel| texel.max_element()).fold(0.0, f32::max)
    }

    /// Radiance from a unit direction: bilinear between texel centres, around the seam, clamped at
    /// the poles, as a sampler does it.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        levels::bilinear(&self.texels, self.width, self.height, direction)
    }

    /// Mean luminance over the sphere of directions.
    pub fn mean_luminance(&self) -> f64 {
        self.mean_luminance_of(|texel| texel)
    }

    /// Mean luminance over the sphere of what each texel is taken for.
    pub(crate) fn mean_luminance_of(&self, seen: impl Fn(Vec3) -> Vec3) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, texels) in self.texels.chunks_exact(self.width as usize).enumerate() {
            let weight = (PI * (row as f64 + 0.5) / f64::from(self.height)).sin();
            weights += weight * texels.len() as f64;
            sum += weight * texels.iter().map(|t| seen(*t).as_dvec3().dot(LUMINANCE)).sum::<f64>();
        }
        sum / weights
    }
}

/// A decoded image before it is made safe.
struct Image {
    width: u32,
    height: u32,
    /// Linear radiance, row by row from the top; may hold anything.
    texels: Vec<Vec3>,
    /// Texels that the file says it leaves out.
    missing: u64,
}

/// `constant 1`, or `constant 1 0.5 0.25`.
fn constant_name(radiance: Vec3) -> String {
    let Vec3 { x, y, z } = radiance;
    if x == y && y == z { format!("constant {x}") } else { format!("constant {x} {y} {z}") }
}
