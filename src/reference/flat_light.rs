//! What small flattened drops of real rain show of the bright parts of an environment
//! ([`crate::environment::bright`]): spread over the drop's disc, as in small spheres, by size and direction.
//!
//! Light that takes a way through a drop takes it backwards, too, and what it keeps of a beam's area times solid angle
//! is kept. So rays are followed from a source through a drop, and counted where they leave it towards the camera: in
//! blocks of the picture, about half a degree wide. A block's mean is unbiased; the seed decides the rays.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::outline::{Cap, Outline, Part};
use super::{Strata, Truth};
use crate::environment::bright::Region;
use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED};
use crate::rain::{pcg4d, unit};
use crate::scene::camera::View;

/// Classes of size. The drops of each block as much light as those of any other.
const CLASSES: u32 = 24;

/// Edge of a block in radians, if that is not less than a pixel.
const BLOCK: f64 = 0.5 * PI / 180.0;

/// Most blocks; of a wide view they are larger.
const MOST_BLOCKS: f64 = 16_384.0;

/// Half the edge of the square around a drop, in radii: for sources of up to 15 degrees of radius.
const HALF: f64 = 1.25;

/// How closely the search finds what leaves towards the picture, in the picture's radii.
const FINEST: f64 = 0.5;

/// Rays for each class, block and sample of a pixel, if all together are not more than those of the pixels.
const RAYS: f64 = 0.5;

/// Share of the light of all bright parts under which a part is not worth a search.
const FAINT: f64 = 0.1;

/// Light of small drops, by size and block.
#[derive(Clone, Debug)]
pub(super) struct FlatLight {
    /// Largest diameter of each class, mm.
    to: Vec<f64>,
    blocks: Blocks,
    /// By class, then by block.
    light: Vec<Vec<Vec3>>,
    /// Mean light of all classes together, by block.
    mean: Vec<Vec3>,
}

/// The whole picture in blocks.
#[derive(Clone, Copy, Debug)]
struct Blocks {
    view: View,
    /// Edge of a block in pixels.
    edge: f64,
    columns: usize,
    rows: usize,
}

impl Blocks {
    fn of(view: View) -> Self {
        let [width, height] = view.whole.map(f64::from);
        let edge = (view.focal_px * BLOCK).max(1.0).max((width * height / MOST_BLOCKS).sqrt());
        let [columns, rows] = view.whole.map(|pixels| (f64::from(pixels) / edge).ceil() as usize);
        Self { view, edge, columns, rows }
    }

    fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Rays for a class, of so many samples a pixel.
    fn rays(&self, samples: u32) -> f64 {
        let [width, height] = self.view.whole.map(f64::from);
        let of_pixels = width * height / f64::from(CLASSES);
        (RAYS * self.count() as f64).min(of_pixels) * f64::from(samples.max(1))
    }

    /// Pixels from the upper left corner of the whole picture, and whether that is before the camera.
    fn point(&self, direction: DVec3) -> (DVec2, bool) {
        let (point, is_before) = self.view.point(direction);
        let [left, top] = self.view.origin.map(f64::from);
        (point + DVec2::new(left, top), is_before)
    }

    /// The block nearest to a direction before the camera.
    fn nearest(&self, direction: DVec3) -> usize {
        let at = self.point(direction).0 / self.edge;
        let [column, row] = [(at.x, self.columns), (at.y, self.rows)]
            .map(|(at, count)| (at.max(0.0) as usize).min(count - 1));
        row * self.columns + column
    }

    /// The block that a direction falls into, and the share of it that one steradian there is.
    fn holding(&self, direction: DVec3) -> Option<(usize, f64)> {
        let (at, is_before) = self.point(direction);
        let [width, height] = self.view.whole.map(f64::from);
        if !(is_before && (0.0..width).contains(&at.x) && (0.0..height).contains(&at.y)) {
            return None;
        }
        let block = self.nearest(direction);
        let length = |at: f64, end: f64| {
            let first = (at / self.edge).floor() * self.edge;
            (first + self.edge).min(end) - first
        };
        let pixels = length(at.x, width) * length(at.y, height);
        let cosine = -direction.dot(self.view.back);
        Some((block, self.view.focal_px.powi(2) / (cosine.powi(3) * pixels)))
    }

    /// The cap of directions from which light comes to the picture's corners, and all between them.
    fn cap(&self) -> Cap {
        let [width, height] = self.view.whole.map(f64::from);
        let [left, top] = self.view.origin.map(f64::from);
        let corners = self.view.corners([0.0 - left, 0.0 - top, width - left, height - top]);
        let direction = corners.iter().sum::<DVec3>().normalize_or(-self.view.back);
        let radius = corners.map(|corner| corner.angle_between(direction));
        Cap { direction, radius: radius.into_iter().fold(0.0, f64::max) }
    }
}

impl FlatLight {
    /// The light of the flattened drops of a law; `None` if it has none.
    pub(super) fn new(
        view: View,
        law: &Law,
        regions: &[Region],
        truth: &Truth,
        indices: &[(f64, DVec3)],
        stop: fn() -> bool,
    ) -> Option<Self> {
        let from = law.from.max(SMALLEST_FLATTENED);
        if law.to <= from {
            return None;
        }
        let edge = |class: u32| {
            law.quantile_between(2.0, f64::from(class) / f64::from(CLASSES), from, law.to)
        };
        let edges: Vec<f64> = (0..=CLASSES).map(edge).collect();
        let blocks = Blocks::of(view);
        let light_of = |region: &Region| region.luminance * region.solid_angle();
        let all: f64 = regions.iter().map(light_of).sum();
        let light: Vec<Vec<Vec3>> = (0..CLASSES as usize)
            .into_par_iter()
            .map(|class| {
                let mut light = vec![DVec3::ZERO; blocks.count()];
                for (region, source) in regions.iter().zip(0_u32..) {
                    let share = light_of(region) / all;
                    let beam = Beam { blocks: &blocks, region, share, truth, indices, stop };
                    let salt = (class as u32) << 16 | source;
                    beam.follow([edges[class], edges[class + 1]], salt, &mut light);
                }
                light.iter().map(|light| light.as_vec3()).collect()
            })
            .collect();
        let of_all = |block: usize| light.iter().map(|class| class[block]).sum::<Vec3>();
        let mean = (0..blocks.count()).map(|block| of_all(block) / CLASSES as f32).collect();
        Some(Self { to: edges[1..].to_vec(), blocks, light, mean })
    }

    /// Light of a drop of this diameter in mm, seen in a unit direction.
    pub(super) fn of(&self, diameter: f64, direction: DVec3) -> DVec3 {
        let class = self.to.partition_point(|to| *to < diameter).min(self.light.len() - 1);
        self.light[class][self.blocks.nearest(direction)].as_dvec3()
    }

    /// The mean light of all of them.
    pub(super) fn mean(&self, direction: DVec3) -> DVec3 {
        self.mean[self.blocks.nearest(direction)].as_dvec3()
    }
}

/// Rays from a source.
struct Beam<'a> {
    blocks: &'a Blocks,
    region: &'a Region,
    /// This region's share of the light of all regions.
    share: f64,
    truth: &'a Truth,
    indices: &'a [(f64, DVec3)],
    stop: fn() -> bool,
}

impl Beam<'_> {
    /// Adds what leaves drops of diameters between two, in mm, to the light of the blocks.
    fn follow(&self, [from, to]: [f64; 2], salt: u32, light: &mut [DVec3]) {
        let (middle, truth) = (self.region.direction, self.truth);
        let (u, v) = middle.any_orthonormal_pair();
        let outline = |diameter: f64, index: f64, direction: DVec3| Outline {
            truth,
            shape: Halves::of_diameter(diameter).into(),
            index,
            ray: move |place: DVec2| (HALF * (place.x * u + place.y * v), direction),
        };
        let seen = self.blocks.cap();
        let seen = Cap { direction: -seen.direction, radius: seen.radius + self.region.radius };
        let is_faint = self.share < FAINT;
        let sources = if is_faint { &[][..] } else { &[seen] };
        let parts = outline(0.5 * (from + to), self.indices[0].0, -middle).parts(sources, FINEST);
        let shown = |part: &&Part| part.shows || is_faint;
        let shown: f64 = parts.iter().filter(shown).map(Part::area).sum();
        let rays = self.share * self.blocks.rays(truth.samples) / self.indices.len() as f64;
        let seed = truth.seed ^ 0x666c_6174_7375_6e00; // "flatsun"
        for (part, number) in parts.iter().zip(0_u32..) {
            let is_shown = part.shows || is_faint;
            let count = if is_shown { (rays * part.area() / shown).ceil() } else { 1.0 };
            let share = HALF * HALF * part.area() / count;
            let strata = Strata::new(count as u32, seed ^ u64::from(salt) << 32);
            let places = strata.places(number).zip(0_u32..);
            for ((x, y), sample) in places.take_while(|_| !(self.stop)()) {
                let random = pcg4d([number, sample, salt ^ seed as u32, !(seed >> 32) as u32]);
                let [height, turn, size, _] = random.map(unit);
                let source = self.region.at(height, turn);
                let area = share * source.dot(middle) * self.region.solid_angle();
                let radiance = area * self.region.radiance(source);
                if radiance == DVec3::ZERO {
                    continue;
                }
                let diameter = from + size * (to - from);
                let halves = Halves::of_diameter(diameter);
                for &(index, colors) in self.indices {
                    outline(diameter, index, -source).follow(
                        part.at(x, y),
                        |_, weight, leaving| {
                            // The camera looks against the light.
                            if let Some((block, density)) = self.blocks.holding(-leaving) {
                                let disc = PI * halves.outline_area(leaving.y);
                                light[block] += weight * density / disc * radiance * colors;
                            }
                        },
                    );
                }
            }
        }
    }
}
