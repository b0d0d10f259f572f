//! What is behind the drops instead of the sky: a picture, and how deep it is at each pixel.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The files of a background; with neither, the environment is behind the drops.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Background {
    /// Picture behind the drops, of the picture's size. Relative to the scene file.
    #[schemars(extend("x-default" = "the sky"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<PathBuf>,
    /// Its layer, of an EXR.
    #[schemars(extend("x-default" = "the finished picture"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_layer: Option<String>,
    /// Depth at each pixel, of the picture's size, over 0: an EXR with a channel such as `Z`, or a 16-bit PNG with
    /// `depth_scale`. A drop that a ray meets farther away is hidden.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<PathBuf>,
    /// Its layer or channel, of an EXR.
    #[schemars(extend("x-default" = "`Z`, or what is named depth"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_layer: Option<String>,
    /// How depth is measured.
    pub depth_kind: DepthKind,
    /// Length of a stored unit; a PNG must give it.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units", "x-default" = "1"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_scale: Option<f64>,
    /// The stored number that stands for an unknown depth; such pixels take the nearest known one.
    #[schemars(extend("x-infinite" = true, "x-nan" = true))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_invalid: Option<f64>,
}

/// How depth is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
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
        let needs = [
            ("color_layer", self.color_layer.is_some(), "color", self.color.is_some()),
            ("depth_layer", self.depth_layer.is_some(), "depth", self.depth.is_some()),
            ("depth_scale", self.depth_scale.is_some(), "depth", self.depth.is_some()),
            ("depth_invalid", self.depth_invalid.is_some(), "depth", self.depth.is_some()),
        ];
        match needs.iter().find(|(_, is_given, _, is_there)| *is_given && !is_there) {
            Some((key, _, file, _)) => Err(format!("background: {key} is given, but no {file}")),
            None => Ok(()),
        }
    }
}
