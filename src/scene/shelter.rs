//! `[shelter]`: where no rain falls, by a map of the height of the highest surface. It is read once and shared by every copy
//! of the scene.

use std::path::PathBuf;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use crate::picture::heights::HeightMap;
use crate::{Error, Result};

/// The `[shelter]` table.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Shelter {
    /// Map of the height of the highest surface: channel `Y` of an OpenEXR in scene units, or a PNG of 16 bits. Relative to the
    /// scene file. Columns run along +x, rows along +z; -inf or under -1e9: nothing is there.
    pub height: PathBuf,
    /// Factor on the stored heights.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units"))]
    pub height_scale: f64,
    /// x and z of the outer corner of the first texel; beyond the map nothing is sheltered.
    #[schemars(extend("x-unit" = "scene units"))]
    pub from: [f64; 2],
    /// x and z of the outer corner of the last texel, over those of `from`.
    #[schemars(extend("x-unit" = "scene units"))]
    pub to: [f64; 2],
    /// What was read.
    #[serde(skip)]
    map: Option<Arc<HeightMap>>,
    /// Columns and rows of the map that a host gives with each frame instead.
    #[serde(skip)]
    of_host: Option<[u32; 2]>,
}

impl Default for Shelter {
    fn default() -> Self {
        Self {
            height: PathBuf::new(),
            height_scale: 1.0,
            from: [-20.0; 2],
            to: [20.0; 2],
            map: None,
            of_host: None,
        }
    }
}

impl Shelter {
    /// A shelter by a map in memory, whose heights are in scene units.
    pub fn of(map: HeightMap, from: [f64; 2], to: [f64; 2]) -> Self {
        Self { from, to, map: Some(Arc::new(map)), ..Self::default() }
    }

    /// A shelter whose map of so many columns along x and rows along z a host gives with each frame, with where it is
    /// ([`crate::renderer::HostShelter`]). Only a host's frames have it.
    pub fn of_host(columns: u32, rows: u32) -> Self {
        Self { of_host: Some([columns, rows]), ..Self::default() }
    }

    /// The map; none before it is read, and of a host's.
    pub fn map(&self) -> Option<&Arc<HeightMap>> {
        self.map.as_ref()
    }
}

/// What is wrong with a scene's shelter, and what would be right.
pub(super) fn problem(scene: &Scene) -> std::result::Result<(), String> {
    let Some(shelter) = &scene.shelter else { return Ok(()) };
    let Shelter { height, from, to, map, of_host, .. } = shelter;
    if of_host.is_some_and(|size| size.contains(&0)) {
        return Err("shelter: a host's map has one column and one row at least".into());
    }
    if height.as_os_str().is_empty() && map.is_none() && of_host.is_none() {
        return Err("shelter: give a height map: height = \"roofs.exr\"".into());
    }
    for (axis, from, to) in [("x", from[0], to[0]), ("z", from[1], to[1])] {
        if from >= to {
            return Err(format!(
                "shelter: its {axis} runs from {from} to {to}; to must be over from"
            ));
        }
    }
    if let Some(rain) = scene.populations().into_iter().find(|rain| rain.velocity.y >= 0.0) {
        let [x, y, z] = rain.velocity.to_array();
        return Err(format!(
            "rain: velocity = [{x}, {y}, {z}] does not fall, so that no shelter is above it; give it a y under 0"
        ));
    }
    // A still or sinking wind holds no drop up.
    if let Some(rain) = scene.real_rain().filter(|rain| rain.wind.y > 0.0) {
        let slowest = rain.classes().iter().map(|class| class.speed).fold(f64::INFINITY, f64::min);
        if rain.wind.y >= slowest {
            return Err(format!(
                "rain: wind blows up with {} m/s, and the smallest drops fall with {slowest:.2}: no shelter is above them; \
                 take less, or larger diameters",
                rain.wind.y
            ));
        }
    }
    Ok(())
}

impl Scene {
    /// Reads the height map of the scene's shelter, if it has one that is not read yet.
    ///
    /// # Errors
    /// [`Error::File`] for a file that cannot be read or is no height map.
    pub fn read_shelter(&mut self) -> Result<()> {
        let is_unread = |shelter: &&mut Shelter| shelter.map.is_none() && shelter.of_host.is_none();
        if let Some(shelter) = self.shelter.as_mut().filter(is_unread) {
            let map = HeightMap::read(&shelter.height, shelter.height_scale)?;
            shelter.map = Some(Arc::new(map));
        }
        Ok(())
    }

    /// Columns and rows of the height map that a host gives with each frame, if it does.
    pub fn host_shelter(&self) -> Option<[u32; 2]> {
        self.shelter.as_ref()?.of_host
    }

    /// Fails if the height map is not read.
    pub(crate) fn expect_shelter(&self) -> Result<()> {
        match &self.shelter {
            Some(Shelter { map: None, of_host: None, .. }) => {
                Err(Error::scene("shelter", "its map is not read; call Scene::read_shelter"))
            }
            _ => Ok(()),
        }
    }
}
