//! An environment where only a plate is known: what the camera saw, continued around it.
//!
//! Within the plate's field of view a direction shows the plate. Beyond its sides the plate is mirrored again and again,
//! above its top and below its bottom its edge goes on, and fades into that edge's mean towards the pole. So brightness
//! and colour are about right around the horizon, and a drop shows what is behind it, upside down. What is not in the plate is
//! not in the guess: a sun outside of it, a lamp behind the camera. What that costs: docs/data-set.md.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::Environment;
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::scene::Scene;
use crate::scene::background::Background;
use crate::scene::projection::View;
use crate::{Error, Result};

/// Most texels down, which are a third of a degree each, and least.
const MOST_ROWS: u32 = 512;
const LEAST_ROWS: u32 = 128;

impl Environment {
    /// The environment of a scene: what it names, or, where it names none but has a plate, one that is guessed from that.
    ///
    /// # Errors
    /// See [`Environment::open`] and [`Plate::open`].
    pub fn of(scene: &Scene) -> Result<Self> {
        if !is_guessed(scene) {
            return Self::open(&scene.environment);
        }
        let color = Background { color: scene.background.color.clone(), ..Background::default() };
        let plate = Plate::open(&color, scene.image.width, scene.image.height)?;
        match plate.color() {
            Some(picture) => Guess::for_scene(scene).around(picture),
            None => Self::open(&scene.environment),
        }
    }
}

/// The surroundings of pictures of one view: where in the picture each direction's light is.
pub struct Guess {
    view: View,
    rows: u32,
    places: Vec<Place>,
}

/// Where a direction's light is.
struct Place {
    /// In the picture, in pixels of [`Guess::factor`] of its own.
    at: Vec2,
    /// By how much it fades into the mean of the upper edge; below 0, of the lower one.
    faded: f32,
}

impl Guess {
    /// For pictures behind a scene's drops. Those of real rain are small: in the middle of one that is a sixth of the
    /// picture's height, a pixel shows as much as a texel of half as many rows as the picture has. Any other drop may be
    /// as large as the picture.
    pub fn for_scene(scene: &Scene) -> Self {
        let (view, rows) = of_scene(scene);
        Self::new(&view, rows)
    }

    /// Whether it is that for this scene.
    pub fn is_for(&self, scene: &Scene) -> bool {
        (self.view, self.rows) == of_scene(scene)
    }

    /// A guess by the whole of `view`, with so many texels down.
    pub fn new(view: &View, rows: u32) -> Self {
        let angle = std::f64::consts::PI / f64::from(rows);
        let small = view.whole[0] / Self::factor(view, rows);
        let scale = f64::from(small) / f64::from(view.whole[0]);
        // Angles from the view axis to the picture's edges.
        let [left, top, right, bottom] = view.tan_edges().map(f64::atan);
        let place = |direction: DVec3| {
            let [x, y, z] = [view.right, view.up, -view.back].map(|axis| direction.dot(axis));
            let across = mirrored(x.atan2(z), [-left, right]);
            let above = y.clamp(-1.0, 1.0).asin();
            let held = above.clamp(-bottom, top);
            let point = DVec2::new(across.tan(), -held.tan() / across.cos());
            let at = scale * (view.focal_px * point + view.principal);
            let edge_at = if above < 0.0 { bottom } else { top };
            let faded = (above.abs() - edge_at).max(0.0) / (0.5 * std::f64::consts::PI - edge_at);
            Place { at: at.as_vec2(), faded: faded.copysign(above) as f32 }
        };
        let rows_of = |row| (0..2 * rows).map(move |column| direction_of(column, row, angle));
        Self { view: *view, rows, places: (0..rows).flat_map(rows_of).map(place).collect() }
    }

    /// Pixels along an edge that are taken for one, so that those are about as wide as texels and each texel is a mean.
    fn factor(view: &View, rows: u32) -> u32 {
        let texel = std::f64::consts::PI / f64::from(rows) * view.focal_px;
        (texel as u32).clamp(1, view.whole[0].min(view.whole[1]))
    }

    /// What is around the camera that has taken this picture, which has the size of the view and is of finite radiance.
    ///
    /// # Errors
    /// [`Error::Environment`] if the picture is of another size, or empty.
    pub fn around(&self, plate: &Picture) -> Result<Environment> {
        if [plate.width, plate.height] != self.view.whole || plate.pixels.is_empty() {
            let (Picture { width, height, .. }, [across, down]) = (plate, self.view.whole);
            let problem =
                format!("a picture of {width} x {height} pixels for a view of {across} x {down}");
            return Err(Error::Environment { path: "the plate".into(), problem });
        }
        let small = shrink(plate, Self::factor(&self.view, self.rows));
        let edges = [row_mean(&small, 0), row_mean(&small, small.height - 1)];
        let light = |place: &Place| {
            let edge = edges[usize::from(place.faded.is_sign_negative())];
            bilinear(&small, place.at).lerp(edge, place.faded.abs())
        };
        let texels = self.places.iter().map(light).collect();
        Environment::from_texels("guessed from the plate", 2 * self.rows, self.rows, texels)
    }
}

/// What a guess for a scene is made of.
fn of_scene(scene: &Scene) -> (View, u32) {
    let has_others = !scene.drops.is_empty() || scene.particles.is_some() || scene.pane.is_some();
    let rows = match scene.real_rain().is_some() && !has_others {
        true => (scene.image.height / 2).next_power_of_two().clamp(LEAST_ROWS, MOST_ROWS),
        false => MOST_ROWS,
    };
    (scene.whole().view(), rows)
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

fn bilinear(picture: &Picture, at: Vec2) -> Vec3 {
    let last = Vec2::new((picture.width - 1) as f32, (picture.height - 1) as f32);
    let at = (at - 0.5).clamp(Vec2::ZERO, last);
    let [x, y] = at.to_array().map(|at| at as usize);
    let share = at.fract();
    let width = picture.width as usize;
    let (right, below) = (usize::from(x + 1 < width), y + 1 < picture.height as usize);
    let row = |from: usize| {
        let (left, right) = (picture.pixels[from], picture.pixels[from + right]);
        left.lerp(right, share.x)
    };
    let from = y * width + x;
    row(from).lerp(row(if below { from + width } else { from }), share.y)
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
            let guess = Guess::new(&view, MOST_ROWS).around(&plate)?;
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
