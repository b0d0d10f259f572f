//! An environment where only a plate is known: what the camera saw, continued around it.
//!
//! Within the plate's field of view a direction shows the plate. Beyond its sides the plate is mirrored again and again,
//! above its top and below its bottom its edge goes on, and fades into that edge's mean towards the pole. So brightness
//! and colour are about right around the horizon, and a drop shows what is behind it, upside down. What is not in the plate is
//! not in the guess: a sun outside of it, a lamp behind the camera. What that costs: docs/data-set.md.

use glam::{DVec2, Vec3};

use super::Environment;
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::scene::Scene;
use crate::scene::background::Background;
use crate::scene::projection::View;
use crate::{Error, Result};

/// Texels down; a texel is a third of a degree.
const HEIGHT: u32 = 512;

impl Environment {
    /// The environment of a scene: what it names, or, where it names none but has a plate, one that is guessed from that.
    ///
    /// # Errors
    /// Those of [`Environment::open`] and [`Plate::open`].
    pub fn of(scene: &Scene) -> Result<Self> {
        if !is_guessed(scene) {
            return Self::open(&scene.environment);
        }
        let whole = scene.whole();
        let color = Background { color: scene.background.color.clone(), ..Background::default() };
        let plate = Plate::open(&color, scene.image.width, scene.image.height)?;
        match plate.color() {
            Some(picture) => Self::guessed(picture, &whole.view()),
            None => Self::open(&scene.environment),
        }
    }

    /// Guesses the surroundings of a picture of the whole of `view`, of finite radiance.
    ///
    /// # Errors
    /// [`Error::Environment`] if the picture is empty.
    pub fn guessed(plate: &Picture, view: &View) -> Result<Self> {
        let (width, height) = (2 * HEIGHT, HEIGHT);
        let angle = std::f64::consts::PI / f64::from(height);
        if plate.pixels.is_empty() {
            let problem = "a picture without pixels".into();
            return Err(Error::Environment { path: "the plate".into(), problem });
        }
        // Pixels about as wide as texels, so that each texel is a mean.
        let small = shrink(plate, ((angle * view.focal_px) as u32).max(1));
        let scale = f64::from(small.width) / f64::from(view.whole[0]);
        let half = 0.5 * DVec2::new(view.whole[0].into(), view.whole[1].into()) / view.focal_px;
        let (most_x, most_y) = (half.x.atan(), half.y.atan());
        let rows = [row_mean(&small, 0), row_mean(&small, small.height - 1)];
        let mut texels = Vec::with_capacity((width * height) as usize);
        for row in 0..height {
            for column in 0..width {
                let direction = direction_of(column, row, angle);
                let [x, y, z] = [view.right, view.up, -view.back].map(|axis| direction.dot(axis));
                let (across, above) = (mirrored(x.atan2(z), most_x), y.clamp(-1.0, 1.0).asin());
                let held = above.clamp(-most_y, most_y);
                let point = DVec2::new(across.tan(), -held.tan() / across.cos());
                let at = scale * (view.focal_px * (point + half));
                let faded = (above.abs() - most_y).max(0.0) / (0.5 * std::f64::consts::PI - most_y);
                let edge = rows[usize::from(above < 0.0)];
                texels.push(bilinear(&small, at).lerp(edge, faded as f32));
            }
        }
        let mut guess = Self::from_texels("guessed from the plate", width, height, texels)?;
        guess.low_dynamic_range = plate.pixels.iter().all(|pixel| pixel.max_element() <= 1.0);
        Ok(guess)
    }
}

/// Whether the environment of a scene is guessed from its plate.
pub fn is_guessed(scene: &Scene) -> bool {
    let choice = &scene.environment;
    choice.file.is_none() && choice.radiance.is_none() && scene.background.color.is_some()
}

/// Unit direction through the middle of a texel.
fn direction_of(column: u32, row: u32, angle: f64) -> glam::DVec3 {
    let (longitude, polar) =
        ((f64::from(column) + 0.5) * angle - std::f64::consts::PI, (f64::from(row) + 0.5) * angle);
    let sine = polar.sin();
    glam::DVec3::new(sine * longitude.sin(), polar.cos(), -sine * longitude.cos())
}

/// An angle within ±`most`, by mirrors at both.
fn mirrored(angle: f64, most: f64) -> f64 {
    let turned = (angle + most).rem_euclid(4.0 * most);
    if turned <= 2.0 * most { turned - most } else { 3.0 * most - turned }
}

/// Means of squares of `factor` pixels an edge, as many as fit.
fn shrink(picture: &Picture, factor: u32) -> Picture {
    let factor = factor.min(picture.width).min(picture.height);
    let (width, height) = (picture.width / factor, picture.height / factor);
    let mean = |at: u32| {
        let (x, y) = (at % width * factor, at / width * factor);
        let one = |n: u32| (y + n / factor) * picture.width + x + n % factor;
        let sum: Vec3 =
            (0..factor * factor).map(|n| picture.pixels[one(n) as usize].max(Vec3::ZERO)).sum();
        sum / (factor * factor) as f32
    };
    Picture { width, height, pixels: (0..width * height).map(mean).collect() }
}

fn row_mean(picture: &Picture, row: u32) -> Vec3 {
    let from = (row * picture.width) as usize;
    let row = &picture.pixels[from..from + picture.width as usize];
    row.iter().sum::<Vec3>() / picture.width as f32
}

fn bilinear(picture: &Picture, at: DVec2) -> Vec3 {
    let last = DVec2::new(f64::from(picture.width - 1), f64::from(picture.height - 1));
    let at = (at - 0.5).clamp(DVec2::ZERO, last);
    let (from, share) = (at.floor(), at.fract().as_vec2());
    let pixel = |x: f64, y: f64| {
        let (x, y) = ((from.x + x).min(last.x) as usize, (from.y + y).min(last.y) as usize);
        picture.pixels[y * picture.width as usize + x]
    };
    let above = pixel(0.0, 0.0).lerp(pixel(1.0, 0.0), share.x);
    let below = pixel(0.0, 1.0).lerp(pixel(1.0, 1.0), share.x);
    above.lerp(below, share.y)
}
