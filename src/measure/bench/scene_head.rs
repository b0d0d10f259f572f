//! What tells two results apart: the scene that was drawn, as a hash and in figures.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::environment::Environment;
use crate::scene::Scene;

/// The scene of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneHead {
    /// CRC-32 of all that was to be drawn, models and tone mapping apart: eight hexadecimal digits.
    pub hash: String,
    /// The random drops' seed.
    pub seed: u64,
    /// Scene time of the first frame, in seconds.
    pub time: f64,
    /// The eye.
    pub camera: CameraHead,
    /// The environment's name, without its folder.
    pub environment: String,
    /// Half the edges of the random drops' box; none without such drops.
    pub half_extent: Option<DVec3>,
    /// Their radius.
    pub radius: Option<f64>,
    /// Their velocity, in scene units a second.
    pub velocity: Option<DVec3>,
}

/// The camera of a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the scene file's keys of the same names")]
pub struct CameraHead {
    pub position: DVec3,
    pub target: DVec3,
    pub vertical_fov: f64,
}

impl SceneHead {
    /// The head of a scene in an environment.
    pub fn of(scene: &Scene, environment: &Environment) -> Self {
        let name = environment.name();
        let name = Path::new(name).file_name().map_or(name.into(), |name| name.to_string_lossy());
        Self {
            hash: format!("{:08x}", crc32fast::hash(canonical(scene, &name).as_bytes())),
            seed: scene.seed,
            time: scene.time,
            camera: CameraHead {
                position: scene.camera.position,
                target: scene.camera.target,
                vertical_fov: scene.camera.vertical_fov,
            },
            environment: name.into_owned(),
            half_extent: scene.rain.map(|rain| rain.half_extent),
            radius: scene.rain.map(|rain| rain.radius),
            velocity: scene.rain.map(|rain| rain.velocity),
        }
    }

    /// The first thing in which two scenes differ, as the first and as the second has it.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let vector = |v: Option<DVec3>| v.map_or("none".into(), |v| format!("{v}"));
        let number = |v: Option<f64>| v.map_or("none".into(), |v| v.to_string());
        let figures = |head: &Self| {
            [
                ("environment", head.environment.clone()),
                ("seed", head.seed.to_string()),
                ("time", head.time.to_string()),
                ("camera.position", format!("{}", head.camera.position)),
                ("camera.target", format!("{}", head.camera.target)),
                ("camera.vertical_fov", head.camera.vertical_fov.to_string()),
                ("rain.half_extent", vector(head.half_extent)),
                ("rain.radius", number(head.radius)),
                ("rain.velocity", vector(head.velocity)),
                ("hash", head.hash.clone()),
            ]
        };
        let mut both = figures(self).into_iter().zip(figures(other));
        both.find(|(a, b)| a.1 != b.1).map(|((name, a), (_, b))| (name, a, b))
    }
}

/// The scene as text. Keys at their defaults are left out, so that a later version, which has more keys,
/// makes the same of the same scene.
fn canonical(scene: &Scene, environment: &str) -> String {
    let value = |scene: &Scene| {
        let mut value = serde_json::to_value(scene).unwrap_or_default();
        if let Value::Object(keys) = &mut value {
            for key in ["model", "tone_map", "film", "environment"] {
                keys.remove(key);
            }
        }
        value
    };
    // Without rain the default's keys of it must not come back as differences.
    let default = Scene { rain: scene.rain.map(|_| Default::default()), ..Scene::default() };
    let mut of_scene = value(scene);
    without(&mut of_scene, &value(&default));
    // Keys that change places in the program do not change the scene.
    of_scene.sort_all_objects();
    format!("{environment}\n{}\n{of_scene}", scene.rain.is_some())
}

/// Removes what is the same in `default`.
fn without(value: &mut Value, default: &Value) {
    if let (Value::Object(keys), Value::Object(defaults)) = (value, default) {
        keys.retain(|key, value| {
            let Some(default) = defaults.get(key) else { return true };
            without(value, default);
            value != default && value.as_object().is_none_or(|keys| !keys.is_empty())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_hash_follows_the_scene_and_nothing_else() {
        let white = Environment::constant(Vec3::ONE);
        let hash = |scene: &Scene| SceneHead::of(scene, &white).hash;
        let scene = Scene::default();
        let mut other = scene.clone();
        other.model.samples = Some(4);
        assert_eq!(hash(&scene), hash(&other), "models are no part of it");
        let changes: [fn(&mut Scene); 5] = [
            |scene| scene.seed = 2,
            |scene| scene.camera.up.x = 0.5,
            |scene| scene.image.width = 512,
            |scene| scene.rain.get_or_insert_default().count = 7,
            |scene| scene.rain = None,
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(hash(&scene), hash(&other), "change {number}");
        }
    }

    #[test]
    fn a_difference_is_named() {
        let white = Environment::constant(Vec3::ONE);
        let one = SceneHead::of(&Scene::default(), &white);
        let other = SceneHead::of(&Scene { seed: 9, ..Scene::default() }, &white);
        assert_eq!(one.difference(&other), Some(("seed", "1".into(), "9".into())));
        assert_eq!(one.difference(&one), None);
    }
}
