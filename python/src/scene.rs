//! A scene, read once: from a dict, a TOML text or a scene file, with single keys set.

use std::path::PathBuf;

use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raindrops::files::read_text;
use raindrops::scene::{RainSettings, Scene as Parsed};
use raindrops::{Error, scene::ImageSize};
use toml::Table;

use crate::document::{line, set, table, value};
use crate::raise::Raise as _;

/// What stands for the document in messages.
const NAME: &str = "scene";

/// A valid scene.
#[pyclass(frozen, module = "raindrops._native")]
pub struct Scene {
    pub(crate) scene: Parsed,
    /// Frames a second of the video that it is a picture of.
    pub(crate) fps: Option<f64>,
    /// Whether rain or drops were named; else it has the default million drops.
    #[pyo3(get)]
    names_rain: bool,
}

#[pymethods]
impl Scene {
    /// Reads a dict, a text or a file, or takes the default scene, with keys such as `rain.rate` set.
    #[staticmethod]
    #[pyo3(signature = (dict=None, text=None, path=None, keys=None))]
    fn read(
        py: Python<'_>,
        dict: Option<&Bound<'_, PyDict>>,
        text: Option<&str>,
        path: Option<PathBuf>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut edits = Vec::new();
        for (key, item) in keys.into_iter().flatten() {
            let key: String = key.extract()?;
            let item = value(&item, &key)?;
            edits.push((key, item));
        }
        let document = dict.map(|dict| table(dict, "")).transpose()?;
        let scene = match (&document, text, &path) {
            (None, None, Some(path)) => {
                let edits: Vec<String> =
                    edits.iter().map(|(key, value)| format!("{key}={value}")).collect();
                Parsed::load_edited(Some(path), &edits).map_err(|error| match error {
                    Error::Scene { place, problem } if place == "--set" => {
                        Error::Scene { place: path.display().to_string(), problem }
                    }
                    other => other,
                })
            }
            (_, Some(text), _) if edits.is_empty() => Parsed::parse(text, NAME),
            (_, Some(text), _) => {
                // What is wrong with the text itself has a line of it.
                Parsed::parse(text, NAME).raise(py)?;
                edited(text.parse().unwrap_or_default(), edits)
            }
            (Some(document), ..) => edited(document.clone(), edits),
            (None, None, None) => edited(Table::new(), edits),
        };
        let scene = scene.raise(py)?;
        // Only who names the default's own values must be told from who names nothing.
        let names_rain = scene.rain != Some(RainSettings::default()) || {
            let document = match (document, text, path) {
                (Some(document), ..) => document,
                (_, Some(text), _) => text.parse().unwrap_or_default(),
                (_, _, Some(path)) => read_text(&path).raise(py)?.parse().unwrap_or_default(),
                (None, None, None) => Table::new(),
            };
            document.contains_key("rain")
        };
        Ok(Self { scene, fps: None, names_rain })
    }

    /// A copy with other values of a picture, also where keys of its film or its pane would say otherwise. `moved`: the
    /// camera and its path, by so much; `fps`: the picture is one of a video.
    #[pyo3(signature = (size=None, seed=None, time=None, fov=None, moved=None, fps=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn with_(
        &self,
        py: Python<'_>,
        size: Option<(u32, u32)>,
        seed: Option<u64>,
        time: Option<f64>,
        fov: Option<f64>,
        moved: Option<[f64; 3]>,
        fps: Option<f64>,
    ) -> PyResult<Self> {
        let mut scene = self.scene.clone();
        if let Some((width, height)) = size {
            scene.image = ImageSize { width, height };
        }
        scene.seed = seed.unwrap_or(scene.seed);
        if let Some(time) = time {
            let gone_by = time - scene.time;
            scene.pane = scene.pane.map(|pane| pane.after(gone_by));
            scene.time = time;
        }
        if let Some(fov) = fov {
            scene.camera.vertical_fov = fov;
            scene.film.camera.iter_mut().for_each(|key| key.vertical_fov = None);
        }
        if let Some(way) = moved {
            let way = DVec3::from_array(way);
            scene.camera = scene.camera.moved_by(way);
            for key in &mut scene.film.camera {
                (key.position, key.target) = (key.position + way, key.target + way);
            }
        }
        if let (Some(fps), Some(angle)) = (fps, scene.camera.shutter_angle) {
            // Not by `film.fps`: with a film drops are drawn as for all of its paces.
            (scene.camera.shutter, scene.camera.shutter_angle) = (angle / 360.0 / fps, None);
        }
        scene.validate(NAME).raise(py)?;
        Ok(Self { scene, fps: fps.or(self.fps), names_rain: self.names_rain })
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.scene.image.width, self.scene.image.height)
    }

    /// Seconds.
    #[getter]
    fn time(&self) -> f64 {
        self.scene.time
    }

    /// Chooses the drops' places.
    #[getter]
    fn seed(&self) -> u64 {
        self.scene.seed
    }
}

/// The scene of a document with keys set.
fn edited(mut document: Table, edits: Vec<(String, toml::Value)>) -> raindrops::Result<Parsed> {
    let refuse = |problem: String| Error::Scene { place: NAME.into(), problem };
    for (key, value) in edits {
        set(&mut document, &key, value).map_err(refuse)?;
    }
    let text = toml::to_string(&document).map_err(|error| refuse(error.to_string()))?;
    Parsed::parse(&text, NAME).map_err(|error| match error {
        Error::Scene { place, problem } => {
            let number = place.strip_prefix("scene:").and_then(|number| number.parse().ok());
            let place = number.map_or(place, |number| format!("{NAME}, {}", line(&text, number)));
            Error::Scene { place, problem }
        }
        other => other,
    })
}
