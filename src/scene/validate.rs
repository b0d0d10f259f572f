//! Whether the values of a scene go with one another; each by itself has its range in the schema.

use super::camera::{Camera, FASTEST};
use super::{ImageSize, MAX_CROSSINGS, MAX_DROPS, Scene, ranges};
use crate::Error;
use crate::scene::model::{Preset, Simulation};
use crate::scene::particles::Particles;
use crate::scene::real_rain::RealRain;

impl Scene {
    /// Checks every value; `place` stands for the scene in messages.
    ///
    /// # Errors
    /// [`Error::Scene`] for the first value that is out of its range, or does not go with another.
    pub fn validate(&self, place: &str) -> crate::Result<()> {
        problem(self).map_err(|problem| Error::Scene { place: place.into(), problem })
    }
}

impl Camera {
    /// Checks where it stands, where it looks and what of a picture of this size it shows; the problem is said in words.
    pub(crate) fn validate(&self, image: ImageSize) -> Result<(), String> {
        ranges::check_camera(self)?;
        place(self)?;
        window(self, image)
    }
}

/// The first problem of a scene, in words that [`super::lines::line_of`] reads: "table: …", "drop 3: …", "key = …".
pub(super) fn problem(scene: &Scene) -> Result<(), String> {
    ranges::check(scene)?;
    scene.camera.validate(scene.image)?;
    environment(scene)?;
    scene.particles.iter().try_for_each(Particles::validate)?;
    scene.camera.validate_exposure()?;
    real_rain(scene)?;
    scene.model.validate_far_rain(scene.real_rain().as_ref())?;
    rain(scene)?;
    drops(scene)?;
    super::pane::problem(scene)?;
    super::shelter::problem(scene)?;
    scene.background.validate()?;
    model(scene)?;
    scene.film.validate()?;
    exposed_motion(scene)
}

fn check(good: bool, problem: impl FnOnce() -> String) -> Result<(), String> {
    if good { Ok(()) } else { Err(problem()) }
}

/// Where it stands and looks.
fn place(camera: &Camera) -> Result<(), String> {
    check(camera.position != camera.target, || {
        "camera: position and target are the same point; move one of them".into()
    })?;
    check(camera.up.length() > 0.0, || "camera: up must be a vector that is not zero".into())
}

/// The part of the picture that is drawn.
fn window(camera: &Camera, image: ImageSize) -> Result<(), String> {
    let [left, top, right, bottom] = camera.window;
    for (name, low, high, pixels) in
        [("left to right", left, right, image.width), ("top to bottom", top, bottom, image.height)]
    {
        check(high > low, || {
            format!("camera: window from {name} is {low} to {high}, which holds nothing")
        })?;
        for edge in [low, high] {
            let at = edge * f64::from(pixels);
            check((at - at.round()).abs() < 0.01, || {
                let near = at.round() / f64::from(pixels);
                format!(
                    "camera: window: {edge} of {pixels} pixels is {at}, not a pixel's edge; {near} is one"
                )
            })?;
        }
        let drawn = (high * f64::from(pixels)).round() - (low * f64::from(pixels)).round();
        check(drawn >= 1.0, || format!("camera: window from {name} holds no pixel"))?;
    }
    Ok(())
}

/// One source of radiance, finite.
fn environment(scene: &Scene) -> Result<(), String> {
    check(scene.environment.layer.is_none() || scene.environment.file.is_some(), || {
        "environment: layer is given, but no file".into()
    })?;
    check(scene.environment.radiance.is_none() || scene.environment.file.is_none(), || {
        "environment: give a file or a radiance, not both".into()
    })
}

/// Rain by its rate, which excludes rain by a count.
fn real_rain(scene: &Scene) -> Result<(), String> {
    if let Some(rain) = &scene.real_rain() {
        let count = scene.rain.map_or(0, |rain| rain.count);
        check(count == 0, || {
            format!("rain: rate = {} and count = {count} do not go together", rain.rate)
        })?;
        rain.validate()?;
        let keys = scene.film.camera.iter().map(|key| key.position);
        for position in keys.chain([scene.camera.position]) {
            RealRain::validate_camera(position * scene.metres)?;
        }
    }
    Ok(())
}

/// Rain in a box.
fn rain(scene: &Scene) -> Result<(), String> {
    let populations = scene.populations();
    for (number, rain) in (1..).zip(&populations) {
        let name = if number == 1 { "rain".into() } else { format!("rain {number}") };
        check(rain.radius < rain.half_extent.min_element(), || {
            format!("{name}: radius = {} does not fit into the box's half_extent", rain.radius)
        })?;
    }
    let count = scene.random_count().saturating_add(scene.placed_count());
    check(count <= MAX_DROPS, || format!("rain: count = {count} is over {MAX_DROPS}"))?;
    let is_stored = scene.model.simulation == Some(Simulation::Stored);
    check(populations.len() <= 1 || !is_stored, || {
        "rain: stored positions know one population; leave out model.simulation".into()
    })
}

/// Drops placed by hand.
fn drops(scene: &Scene) -> Result<(), String> {
    for (number, drop) in scene.drops.iter().enumerate() {
        check(drop.axis_ratio.is_none() || drop.shape.is_none(), || {
            format!("drop {}: give an axis_ratio or a shape, not both", number + 1)
        })?;
        check(drop.center_at(scene.time).is_finite(), || {
            format!("drop {}: at time {} it is beyond all numbers", number + 1, scene.time)
        })?;
    }
    Ok(())
}

/// Models and what they are chosen by.
fn model(scene: &Scene) -> Result<(), String> {
    let size = scene.model.mask_size;
    check(size.is_power_of_two(), || format!("model: mask_size = {size} is not a power of two"))?;
    let accepted = scene.model.error;
    check(accepted.is_none() || scene.model.preset == Preset::Auto, || {
        format!("model: error is for preset auto, not for {}", scene.model.preset)
    })?;
    let budget = scene.model.budget_ms;
    check(budget.is_none() || scene.model.preset == Preset::Auto, || {
        format!("model: budget_ms is for preset auto, not for {}", scene.model.preset)
    })?;
    Ok(())
}

/// How far drops move while the shutter is open.
fn exposed_motion(scene: &Scene) -> Result<(), String> {
    let fastest = scene.film.pace.iter().map(|key| key.rate.abs()).fold(scene.pace.abs(), f64::max);
    let seconds = scene.shutter() * fastest;
    check(scene.shutter() == 0.0 || scene.path_velocity().length() <= FASTEST, || {
        format!(
            "film: between two camera keys the camera is faster than {FASTEST:e} scene units a second; part the keys, \
             or set camera.velocity"
        )
    })?;
    let crossings = scene.most_crossed();
    check(crossings <= MAX_CROSSINGS, || {
        format!(
            "camera: while the shutter is open for {seconds} s of the scene's time, the rain crosses its \
             box {crossings:.1} times, over {MAX_CROSSINGS}; shorten the shutter, or enlarge half_extent"
        )
    })?;
    check(scene.placed().all(|drop| (drop.velocity * seconds).is_finite()), || {
        format!("camera: in {seconds} s of the scene's time a drop moves beyond all numbers")
    })
}
