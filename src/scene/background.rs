//! What is behind the drops instead of the sky: a picture, and how deep it is at each pixel.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The files of a background; with neither, the environment is behind the drops.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Background {
    /// Linear radiance, of the picture's size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<PathBuf>,
    /// Depth, of the picture's size: channel Z of an EXR, or a 16-bit PNG of one channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<PathBuf>,
    /// How depth is measured.
    pub depth_kind: DepthKind,
    /// Scene units a stored unit; 1 where it is left out, which a PNG must not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_scale: Option<f64>,
}

/// How depth is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum DepthKind {
    /// Along the view axis.
    #[default]
    Planar,
    /// Along the ray.
    Radial,
}

impl Background {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.color.is_none() && self.depth.is_none()
    }

    /// Checks every value; a problem is an error in words.
    pub(crate) fn validate(&self) -> Result<(), String> {
        match self.depth_scale {
            Some(scale) if !(scale.is_finite() && scale > 0.0) => {
                Err(format!("background: depth_scale = {scale} is not finite and over 0"))
            }
            Some(_) if self.depth.is_none() => {
                Err("background: depth_scale is given, but no depth".into())
            }
            _ => Ok(()),
        }
    }
}
