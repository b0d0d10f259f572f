//! Real rain, drop by drop out to a bound, and not stored: the drops that the rays of a tile can meet are
//! found in the cells of each class ([`crate::rain::cells`]) when the tile is traced, and forgotten after.
//!
//! A class moves as one while the shutter is open, so its drops are a population with one motion. Which
//! drops there are is decided by their centres as the shutter opens.

use std::cell::Cell;

use glam::DVec3;

use super::drops::{Drop, Drops, Population};
use super::shelter::Roof;
use super::tree::{Pyramid, nearest_between};
use crate::optics::Shape;
use crate::rain::cells::{Lattice, Place};
use crate::rain::shape::Halves;
use crate::rain::tick_of_seconds;
use crate::scene::Scene;
use crate::scene::model::DropShape;
use crate::scene::real_rain::RealRain;

/// Most drops in view that are traced one by one where no bound is given: 32 m of 25 mm/h at 60 degrees.
/// The drops of a tile are found and sorted once for all its samples, at some 10⁻⁶ s each.
pub const MOST_TRACED: f64 = 3e7;

/// Distance in metres within which the whole picture holds [`MOST_TRACED`] drops of its real rain, or to
/// where that ends; `None` without real rain.
pub fn usual_bound(scene: &Scene) -> Option<f64> {
    let rain = scene.real_rain()?;
    let view = scene.whole().view();
    let [width, height] = [view.width, view.height].map(|edge| f64::from(edge) / view.focal_px);
    let corners = ((4.0 + width * width) * (4.0 + height * height)).sqrt();
    let solid_angle = 4.0 * (width * height / corners).asin();
    let bound = (3.0 * MOST_TRACED / (solid_angle * rain.law().number())).cbrt();
    Some(bound.min(rain.extent))
}

/// The drops of real rain near the camera.
#[derive(Clone, Debug)]
pub(super) struct NearRain {
    /// The classes' cells, where the camera is among them as the shutter opens, and how far they move while it is open, as
    /// the camera sees it, in scene units.
    classes: Vec<(Lattice, Place, DVec3)>,
    shape: DropShape,
    roof: Option<Roof>,
    /// Length of a scene unit, m.
    metres: f64,
    /// Distance to which drops are there, in scene units.
    pub(super) end: f64,
}

/// A range of distances from the camera, in scene units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shell {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Shell {
    /// Whether rays of the pyramid may meet in it what is between two distances from the camera.
    fn meets(&self, nearest: f64, farthest: f64, pyramid: &Pyramid) -> bool {
        nearest - pyramid.origins() < self.to && farthest + pyramid.origins() >= self.from
    }

    /// Two shells of one volume instead of this; `None` if they would be thinner than float64 can tell apart.
    pub(super) fn halves(self, end: f64) -> Option<[Self; 2]> {
        let to = self.to.min(end);
        let middle = (0.5 * (self.from.powi(3) + to.powi(3))).cbrt();
        let is_thick = to - self.from > 1e-6 * end;
        is_thick.then_some([Self { to: middle, ..self }, Self { from: middle, ..self }])
    }
}

impl NearRain {
    /// The drops of a scene's rain to `end` metres.
    pub(super) fn new(scene: &Scene, rain: &RealRain, end: f64) -> Self {
        let tick = tick_of_seconds(scene.time);
        let camera = scene.camera.position * scene.metres;
        let lattices = rain.lattices(scene.seed).into_iter();
        let classes = lattices.map(|lattice| {
            let place = lattice.place(camera, tick);
            let motion = scene.motion_of(lattice.velocity / scene.metres);
            (lattice, place, motion)
        });
        Self {
            classes: classes.collect(),
            shape: rain.shape,
            roof: Roof::of(scene),
            metres: scene.metres,
            end: end / scene.metres,
        }
    }

    /// Whether drops move while the shutter is open.
    pub(super) fn moves(&self) -> bool {
        self.classes.iter().any(|(.., motion)| *motion != DVec3::ZERO)
    }

    /// The drops that rays of the pyramid can meet at distances within the shell, in a fixed order; `None` if
    /// they are more than `most`.
    pub(super) fn within(&self, pyramid: &Pyramid, shell: Shell, most: usize) -> Option<Drops> {
        let mut drops = Drops::default();
        let found = Cell::new(0);
        for (lattice, place, motion) in &self.classes {
            let motion = *motion;
            let round = Population { shape: Shape::Sphere, motion, half_extent: None };
            drops.populations.push(round);
            let of_class = drops.populations.len() as u32 - 1;
            // A cell's box is larger by a sphere's radius; what a flat drop sticks out of it comes on top.
            let more = (self.shape_of(2e3 * lattice.radius).reach() - 1.0) * lattice.radius;
            let meets = |low: DVec3, high: DVec3| {
                let (low, high) = ((low - more) / self.metres, (high + more) / self.metres);
                let nearest = DVec3::ZERO.clamp(low, high).length();
                let farthest = low.abs().max(high.abs()).length();
                found.get() <= most
                    && nearest < self.end
                    && shell.meets(nearest, farthest, pyramid)
                    && !pyramid.misses_box(low, high)
            };
            let (reach, moved) = (self.end * self.metres, motion * self.metres);
            lattice.visit(place, reach, moved, &meets, &mut |cell| {
                for drop in lattice.drops(cell) {
                    let center = lattice.between(place, &drop.place) / self.metres;
                    let (diameter, ends) = (drop.diameter_mm(), [center, center + motion]);
                    let radius = 0.5e-3 * diameter / self.metres;
                    let shape = self.shape_of(diameter);
                    let reach = radius * shape.reach();
                    let farthest = ends[0].length().max(ends[1].length()) + reach;
                    if center.length() >= self.end
                        || !shell.meets(nearest_between(ends) - reach, farthest, pyramid)
                        || pyramid.misses_sphere(ends, reach)
                    {
                        continue;
                    }
                    if let Some(roof) = &self.roof {
                        let velocity = lattice.velocity / self.metres;
                        let Some(there) = roof.there(center, velocity) else { continue };
                        drops.there.push(there);
                    }
                    let mut population = of_class;
                    if shape != Shape::Sphere {
                        population = drops.populations.len() as u32;
                        drops.populations.push(Population { shape, ..round });
                    }
                    drops.all.push(Drop { center, radius, population });
                    found.set(drops.all.len());
                }
            });
        }
        (found.get() <= most).then_some(drops)
    }

    fn shape_of(&self, diameter_mm: f64) -> Shape {
        match self.shape {
            DropShape::Equilibrium => Halves::of_diameter(diameter_mm).into(),
            DropShape::Sphere => Shape::Sphere,
        }
    }
}
