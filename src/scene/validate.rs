//! Whether every value of a scene is within its range and goes with the others.

use super::camera::{Camera, FASTEST};
use super::{AXIS_RATIOS, EXPOSURES, ImageSize, MAX_CROSSINGS, MAX_DROPS, MAX_IMAGE_EDGE, Scene};
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
        place(self)?;
        size(image)?;
        window(self, image)?;
        principal(self)
    }
}

/// The first problem of a scene, in words that [`super::lines::line_of`] reads: "table: …", "drop 3: …", "key = …".
pub(super) fn problem(scene: &Scene) -> Result<(), String> {
    check(scene.time.is_finite(), || format!("time = {} is not a finite number", scene.time))?;
    scene.camera.validate(scene.image)?;
    environment(scene)?;
    check(positive(scene.metres), || {
        format!("metres = {} must be finite and over 0", scene.metres)
    })?;
    scene.particles.iter().try_for_each(Particles::validate)?;
    scene.camera.validate_exposure()?;
    real_rain(scene)?;
    scene.model.validate_far_rain(scene.real_rain().as_ref())?;
    rain(scene)?;
    drops(scene)?;
    scene.water.validate()?;
    super::pane::problem(scene)?;
    scene.background.validate()?;
    model(scene)?;
    tone_map(scene)?;
    scene.film.validate()?;
    exposed_motion(scene)
}

fn check(good: bool, problem: impl FnOnce() -> String) -> Result<(), String> {
    if good { Ok(()) } else { Err(problem()) }
}

fn positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Where it stands and looks.
fn place(camera: &Camera) -> Result<(), String> {
    check(camera.position.is_finite() && camera.target.is_finite(), || {
        "camera: position and target must be finite".into()
    })?;
    check(camera.position != camera.target, || {
        "camera: position and target are the same point; move one of them".into()
    })?;
    check(camera.up.is_finite() && camera.up.length() > 0.0, || {
        "camera: up must be a finite vector that is not zero".into()
    })?;
    check((0.01..=175.0).contains(&camera.vertical_fov), || {
        format!("camera: vertical_fov = {} is not within 0.01 to 175 degrees", camera.vertical_fov)
    })?;
    check(
        camera.near.is_finite()
            && camera.near >= 0.0
            && camera.near_fade.is_finite()
            && camera.near_fade >= 0.0,
        || "camera: near and near_fade must be finite and at least 0".into(),
    )
}

/// The picture's size.
fn size(ImageSize { width, height }: ImageSize) -> Result<(), String> {
    let edge = 1..=MAX_IMAGE_EDGE;
    check(edge.contains(&width) && edge.contains(&height), || {
        format!("image: {width} x {height} is not within 1 to {MAX_IMAGE_EDGE} pixels an edge")
    })
}

/// Where the view axis meets the picture.
fn principal(camera: &Camera) -> Result<(), String> {
    let principal = camera.principal;
    check(principal.iter().all(|part| (-10.0..=10.0).contains(part)), || {
        format!("camera: principal = {principal:?} is not within -10 to 10")
    })
}

/// The part of the picture that is drawn.
fn window(camera: &Camera, image: ImageSize) -> Result<(), String> {
    let [left, top, right, bottom] = camera.window;
    for (name, low, high, pixels) in
        [("left to right", left, right, image.width), ("top to bottom", top, bottom, image.height)]
    {
        check((0.0..1.0).contains(&low) && high > low && high <= 1.0, || {
            format!("camera: window from {name} is {low} to {high}, not a part of 0 to 1")
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
    if let Some(radiance) = scene.environment.radiance {
        check(scene.environment.file.is_none(), || {
            "environment: give a file or a radiance, not both".into()
        })?;
        check(radiance.is_finite() && radiance.min_element() >= 0.0, || {
            "environment: radiance must be finite and at least 0".into()
        })?;
    }
    Ok(())
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
        check(rain.half_extent.to_array().into_iter().all(positive), || {
            format!("{name}: half_extent must be finite and over 0")
        })?;
        check(positive(rain.radius), || format!("{name}: radius must be finite and over 0"))?;
        check(rain.radius < rain.half_extent.min_element(), || {
            format!("{name}: radius = {} does not fit into the box's half_extent", rain.radius)
        })?;
        check(rain.velocity.is_finite(), || format!("{name}: velocity must be finite"))?;
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
        check(drop.center.is_finite(), || format!("drop {}: center must be finite", number + 1))?;
        check(positive(drop.radius), || {
            format!("drop {}: radius = {} must be finite and over 0", number + 1, drop.radius)
        })?;
        check(drop.axis_ratio.is_none_or(|ratio| AXIS_RATIOS.contains(&ratio)), || {
            format!(
                "drop {}: axis_ratio = {} is not within {} to {}",
                number + 1,
                drop.axis_ratio.unwrap_or(1.0),
                AXIS_RATIOS.start(),
                AXIS_RATIOS.end()
            )
        })?;
        check(drop.axis_ratio.is_none() || drop.shape.is_none(), || {
            format!("drop {}: give an axis_ratio or a shape, not both", number + 1)
        })?;
        check(drop.id != Some(0), || {
            format!("drop {}: id = 0 is no drop's; ids begin with 1", number + 1)
        })?;
        check(drop.velocity.is_finite(), || {
            format!("drop {}: velocity must be finite", number + 1)
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
    check(size.is_power_of_two() && size <= 4096, || {
        format!("model: mask_size = {size} is not a power of two from 1 to 4096")
    })?;
    let accepted = scene.model.error;
    check(accepted.is_none_or(|error| error > 0.0 && error <= 1.0), || {
        format!("model: error = {} is not over 0 and up to 1", accepted.unwrap_or(0.0))
    })?;
    check(accepted.is_none() || scene.model.preset == Preset::Auto, || {
        format!("model: error is for preset auto, not for {}", scene.model.preset)
    })?;
    let budget = scene.model.budget_ms;
    check(budget.is_none_or(positive), || {
        format!("model: budget_ms = {} is not finite and over 0", budget.unwrap_or(0.0))
    })?;
    check(budget.is_none() || scene.model.preset == Preset::Auto, || {
        format!("model: budget_ms is for preset auto, not for {}", scene.model.preset)
    })?;
    let samples = scene.model.samples.unwrap_or(1);
    check((1..=256).contains(&samples), || {
        format!("model: samples = {samples} is not within 1 to 256")
    })?;
    let splats = scene.model.splat_px.unwrap_or(1.0);
    check((0.4..=1.5).contains(&splats), || {
        format!("model: splat_px = {splats} is not within 0.4 to 1.5 pixels")
    })?;
    let order = scene.model.internal_reflections.unwrap_or(0);
    check(order <= 8, || format!("model: internal_reflections = {order} is over 8"))?;
    Ok(())
}

/// From radiance to display.
fn tone_map(scene: &Scene) -> Result<(), String> {
    check(positive(scene.tone_map.key), || "tone_map: key must be finite and over 0".into())?;
    let exposure = scene.tone_map.exposure.unwrap_or(1.0);
    check(EXPOSURES.contains(&exposure), || {
        let (least, most) = (EXPOSURES.start(), EXPOSURES.end());
        format!(
            "tone_map: exposure = {exposure} is not within {least:e} to {most:e}; it is a factor on \
             radiance, not stops"
        )
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
