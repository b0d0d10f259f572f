//! Scenes that differ in what they ask of a model.

use glam::{DVec3, Vec3};

use crate::Result;
use crate::environment::Environment;
use crate::scene::real_rain::RealRain;
use crate::scene::{PlacedDrop, RainSettings, Scene};

/// A scene to try models on.
pub struct StudyScene {
    /// Its name in tables and plots.
    pub name: String,
    /// What it asks.
    pub asks: &'static str,
    /// One still, or the frames of a movement.
    pub frames: Vec<Scene>,
    /// Its radiance.
    pub environment: Environment,
}

/// A scene of one frame.
pub fn still(
    name: &str,
    asks: &'static str,
    scene: Scene,
    environment: &Environment,
) -> StudyScene {
    let environment = environment.clone();
    StudyScene { name: name.into(), asks, frames: vec![scene], environment }
}

/// The default set: from one drop to a million, from a bare sun to a sky that a display could show,
/// at rest and in motion. Modest in size: with every model it takes minutes on two cores.
///
/// # Errors
/// Like [`Environment::bundled`]: none for an intact program.
pub fn standard_set() -> Result<Vec<StudyScene>> {
    let sky = Environment::bundled()?;
    // The sun's disc is dimmed as by haze: glints are asked for in one scene, `sun`.
    let hazy = clipped(&sky, "veiled sky", 30.0 * sky.mean_luminance() as f32)?;
    let low = clipped(&sky, "low dynamic range sky", 1.0)?;
    Ok(vec![
        still("close-up", "one drop of 130 pixels of radius", close_up(320), &hazy),
        still("near", "hundreds of drops of 1 to 50 pixels", near(320), &hazy),
        still("far", "a million drops, most under a pixel", rain(1_000_000, 512), &hazy),
        still("sun", "the same light, 100,000 drops, with a bare sun", rain(100_000, 320), &sky),
        still("low range", "a sky that a display could show", rain(100_000, 320), &low),
        StudyScene {
            name: "pan".into(),
            asks: "a slow pan: flicker",
            frames: pan(&near(192), 4),
            environment: hazy,
        },
    ])
}

/// Real rain of 25 mm/h, ended where every drop in view can still be drawn one by one: exposed for a thousandth of a
/// second by a long lens; and near by, through a wide one that is focused among its drops.
///
/// # Errors
/// Like [`standard_set`].
pub fn weather() -> Result<[StudyScene; 2]> {
    let sky = Environment::bundled()?;
    let hazy = clipped(&sky, "veiled sky", 30.0 * sky.mean_luminance() as f32)?;
    let raining = |extent: f64, vertical_fov: f64| {
        let rain = RealRain { extent, ..RealRain::default() };
        let mut scene = Scene { rain: Some(RainSettings::of(rain)), ..square(192) };
        scene.camera.vertical_fov = vertical_fov;
        scene.camera.target = DVec3::new(0.0, 0.1, -1.0);
        scene
    };
    let mut exposed = raining(40.0, 12.0);
    exposed.camera.shutter = 1e-3;
    let mut out_of_focus = raining(8.0, 30.0);
    (out_of_focus.camera.aperture, out_of_focus.camera.focus) = (0.02, 2.0);
    let millions = "real rain of 25 mm/h, two million drops, exposed for 1/1000 s";
    let near_by = "real rain of 25 mm/h out of focus, nearer than 8 m";
    Ok([still("weather", millions, exposed, &hazy), still("lens", near_by, out_of_focus, &hazy)])
}

fn clipped(environment: &Environment, name: &str, most: f32) -> Result<Environment> {
    let texels = environment.texels().iter().map(|texel| texel.min(Vec3::splat(most))).collect();
    Environment::from_texels(name, environment.width(), environment.height(), texels)
}

fn square(edge: u32) -> Scene {
    let mut scene = Scene::default();
    (scene.image.width, scene.image.height) = (edge, edge);
    scene
}

fn close_up(edge: u32) -> Scene {
    let mut scene = Scene { rain: None, ..square(edge) };
    scene.camera.vertical_fov = 40.0;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.2, 0.1, -3.5), 1.0)];
    scene
}

fn near(edge: u32) -> Scene {
    let mut scene = square(edge);
    let half_extent = DVec3::splat(40.0);
    scene.rain = Some(RainSettings { count: 3_000, half_extent, ..RainSettings::default() });
    scene.camera.near = 3.0; // what fills the picture is the close-up's part
    scene.camera.vertical_fov = 60.0;
    scene
}

fn rain(count: u32, edge: u32) -> Scene {
    let mut scene = square(edge);
    scene.rain = Some(RainSettings { count, ..RainSettings::default() });
    scene
}

/// `count` frames of a camera that turns by a third of a pixel a frame; the rain stands.
fn pan(scene: &Scene, count: u32) -> Vec<Scene> {
    let pixel = 1.0 / scene.view().focal_px;
    (0..count)
        .map(|number| {
            let mut frame = scene.clone();
            let angle = f64::from(number) * pixel / 3.0;
            frame.camera.target =
                frame.camera.position + DVec3::new(angle.sin(), 0.0, -angle.cos());
            frame
        })
        .collect()
}
