//! What drops are made of, and what they are in: refractive indices.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The two substances of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Water {
    /// Refractive index of the drops, over that of vacuum: a number, or three for red, green and blue.
    #[schemars(extend("x-default" = "1.33; with `rain.rate` 1.33233, 1.33435, 1.33835"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<Index>,
    /// Refractive index around them; 1.33 with an `index` of 1 makes bubbles in water.
    #[schemars(range(min = 1, max = 4))]
    pub outside: f64,
}

/// A refractive index, the same for all light or one for each colour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "index must be a number, or three in brackets: red, green, blue")]
pub enum Index {
    /// For all light.
    One(#[schemars(range(min = 1, max = 4))] f64),
    /// For red, green and blue.
    #[schemars(extend("minimum" = 1, "maximum" = 4))]
    Colors([f64; 3]),
}

impl Default for Water {
    fn default() -> Self {
        Self { index: None, outside: 1.0 }
    }
}

impl Water {
    /// Index inside over that outside, for red, green and blue, with those of the drops where they are left
    /// out.
    pub fn relative(&self, usual: [f64; 3]) -> [f64; 3] {
        let index = match self.index {
            None => usual,
            Some(Index::One(index)) => [index; 3],
            Some(Index::Colors(indices)) => indices,
        };
        index.map(|index| index / self.outside)
    }
}
