//! An environment where only a plate is known: what the camera saw, continued around it.
//!
//! Within the plate's field of view a direction shows the plate. Beyond its sides the plate is mirrored again and again,
//! above its top and below its bottom its edge goes on, and fades into that edge's mean towards the pole. So brightness
//! and colour are about right around the horizon, and a drop shows what is behind it, upside down. What is not in the plate is
//! not in the guess: a sun outside of it, a lamp behind the camera. What that costs: docs/data-set.md.

use glam::{DVec2, DVec3, Vec3};

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
    /// See [`Environment::open`] and [`Plate::open`].
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
        // Angles from the view axis to the plate's edges.
        let [left, top, right, bottom] = view.tan_edges().map(f64::atan);
        let rows = [row_mean(&small, 0), row_mean(&small, small.height - 1)];
        let mut texels = Vec::with_capacity((width * height) as usize);
        for row in 0..height {
            for column in 0..width {
                let direction = direction_of(column, row, angle);
                let [x, y, z] = [view.right, view.up, -view.back].map(|axis| direction.dot(axis));
                let across = mirrored(x.atan2(z), [-left, right]);
                let above = y.clamp(-1.0, 1.0).asin();
                let held = above.clamp(-bottom, top);
                let point = DVec2::new(across.tan(), -held.tan() / across.cos());
                let at = scale * (view.focal_px * point + view.principal);
                let edge_at = if above < 0.0 { bottom } else { top };
                let faded =
                    (above.abs() - edge_at).max(0.0) / (0.5 * std::f64::consts::PI - edge_at);
                let edge = rows[usize::from(above < 0.0)];
                texels.push(bilinear(&small, at).lerp(edge, faded as f32));
            }
        }
        Self::from_texels("guessed from the plate", width, height, texels)
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

/// An angle between two, by mirrors at both.
fn mirrored(angle: f64, [from, to]: [f64; 2]) -> f64 {
    let between = to - from;
    let turned = (angle - from).rem_euclid(2.0 * between);
    from + turned.min(2.0 * between - turned)
}

/// Means of squares of `factor` pixels an edge, as many as fit.
fn shrink(picture: &Picture, factor: u32) -> Picture {
    let factor = factor.min(picture.width).min(picture.height);
    let (width, height) = (picture.width / factor, picture.height / factor);
    let mean = |at: u32| {
        let (x, y) = (at % width * factor, at / width * factor);
        let one = |n: u32| (y + n / factor) * picture.width + x + n % factor;
        let pixels = (0..factor * factor).map(|n| picture.pixels[one(n) as usize]);
        mean_of(pixels.map(|pixel| pixel.max(Vec3::ZERO)), factor * factor)
    };
    Picture { width, height, pixels: (0..width * height).map(mean).collect() }
}

fn row_mean(picture: &Picture, row: u32) -> Vec3 {
    let from = (row * picture.width) as usize;
    let row = &picture.pixels[from..from + picture.width as usize];
    mean_of(row.iter().copied(), picture.width)
}

/// In float64: a sum of bright pixels may be over float32's range, and beside one of them it would lose the others.
fn mean_of(pixels: impl Iterator<Item = Vec3>, count: u32) -> Vec3 {
    (pixels.map(Vec3::as_dvec3).sum::<DVec3>() / f64::from(count)).as_vec3()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;

    /// A ramp across and down, seen through a principal point off the middle.
    #[test]
    fn a_direction_shows_what_the_plate_has_there() -> Result<()> {
        let pixels = (0..80 * 60).map(|at| Vec3::new((at % 80) as f32, (at / 80) as f32, 1.0));
        let plate = Picture { width: 80, height: 60, pixels: pixels.collect() };
        for principal in [[0.5, 0.5], [0.7, 0.35]] {
            let view = Camera { principal, ..Camera::default() }.view(80, 60);
            let guess = Environment::guessed(&plate, &view)?;
            // The edge between two mirrored rows is not tried.
            for (x, y) in [(2.0, 2.0), (40.0, 30.0), (78.0, 30.0), (13.0, 57.0), (77.5, 58.0)] {
                let off = guess.radiance(view.ray(x, y)) - glam::DVec3::new(x - 0.5, y - 0.5, 1.0);
                assert!(off.abs().max_element() < 0.4, "{principal:?}, {x}, {y}: off by {off}");
            }
            // Beyond a side it is mirrored.
            let beyond = [-1.0, 81.0].map(|x| guess.radiance(view.ray(x, 30.0)).x);
            assert!(beyond[0] < 2.0 && beyond[1] > 77.0, "{beyond:?}");
        }
        Ok(())
    }
}
