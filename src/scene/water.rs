//! What drops are made of, and what they are in: refractive indices.

use serde::{Deserialize, Serialize};

use crate::optics::WATER;

/// Least and largest refractive index. Glass ends at 2, gems at 4.
const INDICES: std::ops::RangeInclusive<f64> = 1.0..=4.0;

/// The two substances of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Water {
    /// Refractive index of the drops; left out: that of water, see [`super::Scene::indices`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<Index>,
    /// Refractive index around them; 1.33 with an `index` of 1 makes bubbles in water.
    pub outside: f64,
}

/// A refractive index, the same for all light or one for each colour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "index must be a number, or three in brackets: red, green, blue")]
pub enum Index {
    /// For all light.
    One(f64),
    /// For red, green and blue.
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

    /// Checks every value; a problem is an error in words.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let indices = match self.index {
            None => [WATER; 3],
            Some(Index::One(index)) => [index; 3],
            Some(Index::Colors(indices)) => indices,
        };
        let named = [("index", indices[0]), ("index", indices[1]), ("index", indices[2])];
        for (name, index) in named.into_iter().chain([("outside", self.outside)]) {
            if !INDICES.contains(&index) {
                let (least, most) = (INDICES.start(), INDICES.end());
                return Err(format!(
                    "water: {name} = {index} is not a refractive index within {least} to {most}"
                ));
            }
        }
        Ok(())
    }
}
