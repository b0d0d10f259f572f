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
pub mod ordinary;
pub mod sky;

use std::f64::consts::PI;
use std::path::Path;
use std::sync::OnceLock;

use glam::{DVec3, Vec3};

pub use crate::picture::mend::Mended;
use crate::picture::mend::{Edges, clip_negative, mend};
use crate::picture::read::{self, Decoded, Request};
use crate::remark::Remark;
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
    remarks: Vec<Remark>,
    contrast: OnceLock<f64>,
}

impl Environment {
    /// What a scene asks for: its file, its constant radiance, or (neither) the bundled sky.
    ///
    /// # Errors
    /// Like [`Environment::load`]; a constant that is negative or not finite.
    pub fn open(choice: &EnvironmentChoice) -> Result<Self> {
        match (&choice.file, choice.radiance) {
            (Some(file), _) => Self::load_layer(file, choice.layer.as_deref()),
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

    /// Loads an image file as a panorama: the finished picture of an OpenEXR file, Radiance HDR, PNG or JPEG
    /// ([`Decoded`]). Alpha is left out: the colours already are radiance. What the data window leaves out of the
    /// display window is black.
    ///
    /// Memory: 12 bytes a texel (1.6 GB for the largest image), twice that for EXR, PNG and JPEG while they are decoded.
    ///
    /// # Errors
    /// [`Error::Environment`], one line, for a file that cannot be read, is none of these, is cut
    /// off or broken, is over [`MAX_WIDTH`] x [`MAX_HEIGHT`] (known from its header, before memory
    /// is taken for it), is not twice as wide as it is high, has several layers that may be meant, or has no finite texel.
    pub fn load(path: &Path) -> Result<Self> {
        Self::load_layer(path, None)
    }

    fn load_layer(path: &Path, layer: Option<&str>) -> Result<Self> {
        let name = match path.file_stem() {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => path.display().to_string(),
        };
        read::content(path)
            .and_then(|bytes| Self::decode(name, &bytes, layer))
            .map_err(|problem| Error::Environment { path: path.into(), problem })
    }

    /// An image file's content, in memory; else as [`Environment::load`].
    ///
    /// # Errors
    /// Like [`Environment::load`], with `name` for the path.
    pub fn from_bytes(name: impl Into<String>, bytes: &[u8]) -> Result<Self> {
        let name = name.into();
        Self::decode(name.clone(), bytes, None)
            .map_err(|problem| Error::Environment { path: name.into(), problem })
    }

    fn decode(name: String, bytes: &[u8], layer: Option<&str>) -> Result<Self, String> {
        let request = Request::new("environment.layer").layer(layer).mended(Edges::Joined);
        let decoded = read::decode(bytes, request.checked(&check_size))?;
        let Decoded { picture, remarks, mended, missing, .. } = decoded;
        // A picture that was turned has another shape than its header said.
        check_size(picture.width as usize, picture.height as usize)?;
        let (width, height, mut texels) = (picture.width, picture.height, picture.pixels);
        let negative = clip_negative(&mut texels);
        let mended = Mended { negative, missing, ..mended };
        Ok(Self { name, width, height, texels, mended, remarks, contrast: OnceLock::new() })
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

    /// An environment with one radiance from everywhere: a white furnace.
    pub fn constant(radiance: Vec3) -> Self {
        Self {
            name: constant_name(radiance),
            width: 4,
            height: 2,
            texels: vec![radiance; 8],
            mended: Mended::default(),
            remarks: Vec::new(),
            contrast: OnceLock::new(),
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
        let refuse = |problem| Error::Environment { path: name.clone().into(), problem };
        check_size(width as usize, height as usize).map_err(refuse)?;
        if texels.len() != width as usize * height as usize {
            return Err(refuse(format!("has {} texels, not {width} x {height}", texels.len())));
        }
        let mut texels = texels;
        let mended = mend(&mut texels, width as usize, Edges::Joined).map_err(refuse)?;
        let mended = Mended { negative: clip_negative(&mut texels), ..mended };
        let remarks = Vec::new();
        Ok(Self { name, width, height, texels, mended, remarks, contrast: OnceLock::new() })
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

    /// What was chosen in its file, converted or left out.
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
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

    /// Its contrast (`plan/demand.rs`), which is asked for with each picture and takes a while: found when it is first asked for.
    pub(crate) fn contrast_by(&self, find: impl FnOnce() -> f64) -> f64 {
        *self.contrast.get_or_init(find)
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

/// Refuses what is too large or not twice as wide as high. Called with what a header claims,
/// before memory is taken for it.
fn check_size(width: usize, height: usize) -> Result<(), String> {
    if width > MAX_WIDTH as usize || height > MAX_HEIGHT as usize {
        return Err(format!(
            "is {width} x {height}, over the limit of {MAX_WIDTH} x {MAX_HEIGHT}; scale it down"
        ));
    }
    if width == 0 || width != 2 * height {
        return Err(format!(
            "is {width} x {height}, but a latitude-longitude image is twice as wide as it is high; \
             resample it, say to {} x {}",
            2 * height.max(1),
            height.max(1)
        ));
    }
    Ok(())
}

/// `constant 1`, or `constant 1 0.5 0.25`.
fn constant_name(radiance: Vec3) -> String {
    let Vec3 { x, y, z } = radiance;
    if x == y && y == z { format!("constant {x}") } else { format!("constant {x} {y} {z}") }
}
