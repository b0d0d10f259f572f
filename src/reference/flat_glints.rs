//! Glints of drops that are no spheres, at rest or moving: looked for in parts of a square around the outline
//! (`outline.rs`), each of which is sampled by its exact area.
//!
//! A drop that moves is searched anew for each slice of the exposure, in which it turns by a small angle as seen from the
//! camera; each sample has a moment of its own in the slice.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::drops::{Drop, Population};
use super::glints::MOST_REFLECTIONS;
use super::light::Way;
use super::outline::{Cap, Outline, Part};
use super::tree::{Hit, Pyramid, nearest_between};
use super::{Ray, Strata, Tracer};
use crate::environment::bright::Region;
use crate::rain::{pcg4d, unit};

/// Distance from the eye in reaches of the drop, under which rays over it differ too much: chance finds its glints.
const NEAREST: f64 = 1.5;

/// Angle in radians by which a drop turns in a slice of the exposure.
const SLICE: f64 = 0.02;

/// Most slices. A drop that turns by more in each has more noise.
const MOST_SLICES: f64 = 64.0;

/// How closely the search finds a source, in the source's radii.
const FINEST: f64 = 0.5;

/// Fewest samples of a part that shows a source.
const FEWEST: f64 = 4.0;

/// Whether a drop is so far away, all the while, that its glints are looked for.
pub(super) fn is_far(drop: &Drop, population: &Population) -> bool {
    let ends = [drop.center, drop.center + population.motion];
    nearest_between(ends) > NEAREST * drop.radius * population.shape.reach()
}

/// A drop in a slice of the exposure.
pub(super) struct Slice<'a> {
    tracer: &'a Tracer<'a>,
    number: u32,
    drop: &'a Drop,
    population: &'a Population,
    /// The first moment, and how long it is, as shares of the exposure.
    from: f64,
    length: f64,
    /// A unit vector across the axis to the drop's middle place.
    across: DVec3,
}

/// A ray of the camera, as it meets a drop's square.
struct Look {
    direction: DVec3,
    /// Its nearest point to the drop's centre, in radii from there.
    point: DVec3,
    /// From the camera to that point, in scene units.
    along: f64,
    /// Solid angle for each unit of the square from -1 to 1.
    solid_angle: f64,
}

/// The light of a drop's glints, by pixel.
pub(super) fn glints(
    tracer: &Tracer,
    number: u32,
    regions: &[Region],
    before: &mut Vec<Hit>,
) -> BTreeMap<u32, DVec3> {
    let drops = tracer.tree.drops();
    let drop = &drops.all[number as usize];
    let population = drops.population(drop);
    let turn = drop.center.angle_between(drop.center + population.motion);
    let slices = (turn / SLICE).ceil().clamp(1.0, MOST_SLICES);
    let mut pixels = BTreeMap::new();
    for slice in 0..slices as u32 {
        let (from, length) = (f64::from(slice) / slices, slices.recip());
        let middle = drops.center(drop, from + 0.5 * length);
        let across = middle.normalize().any_orthonormal_vector();
        let slice_of = Slice { tracer, number, drop, population, from, length, across };
        slice_of.hiding(before);
        slice_of.sample(regions, slice, before, &mut pixels);
    }
    pixels
}

impl Slice<'_> {
    fn center(&self, moment: f64) -> DVec3 {
        self.drop.center + moment * self.population.motion
    }

    /// Fills `found` with the drops that may hide parts of this one.
    fn hiding(&self, found: &mut Vec<Hit>) {
        let tracer = self.tracer;
        let middle = self.center(self.from + 0.5 * self.length);
        let moved = 0.5 * self.length * self.population.motion.length();
        let reach = self.drop.radius * self.population.shape.reach() + moved;
        let (distance, view) = (middle.length(), &tracer.eye.view);
        let sine = reach / distance;
        let corners = if sine < 0.7 {
            let tangent = sine / (1.0 - sine * sine).sqrt();
            let (axis, u) = (middle / distance, self.across);
            let v = axis.cross(u);
            [u + v, u - v, -u - v, v - u].map(|corner| axis + tangent * corner)
        } else {
            view.corners([0, 0, view.width, view.height].map(f64::from))
        };
        tracer.tree.within(&Pyramid::between(corners), distance + reach, found);
        found.retain(|hit| hit.drop != self.number);
    }

    /// The ray through a place of the square around the drop's outline at a moment.
    fn look(&self, place: DVec2, moment: f64) -> Look {
        let center = self.center(moment);
        let distance = center.length();
        let axis = center / distance;
        let sine = self.drop.radius * self.population.shape.reach() / distance;
        let tangent2 = sine * sine / (1.0 - sine * sine);
        let u = self.across.reject_from_normalized(axis).normalize();
        let aside = tangent2.sqrt() * (place.x * u + place.y * axis.cross(u));
        let direction = (axis + aside).normalize();
        Look {
            direction,
            point: direction.cross(center).cross(direction) / -self.drop.radius,
            along: center.dot(direction),
            solid_angle: tangent2 * direction.dot(axis).powi(3),
        }
    }

    /// Adds the light of all glints.
    fn sample(
        &self,
        regions: &[Region],
        slice: u32,
        before: &[Hit],
        pixels: &mut BTreeMap<u32, DVec3>,
    ) {
        let Self { tracer, population, .. } = *self;
        let (truth, view) = (&tracer.truth, &tracer.eye.view);
        let middle = self.from + 0.5 * self.length;
        let outline = |index: f64, moment: f64| Outline {
            truth,
            shape: population.shape,
            index,
            ray: move |place: DVec2| {
                let look = self.look(place, moment);
                (look.point, look.direction)
            },
        };
        let turn = self.center(self.from).angle_between(self.center(self.from + self.length));
        let cap =
            |region: &Region| Cap { direction: region.direction, radius: region.radius + turn };
        let sources: Vec<Cap> = regions.iter().map(cap).collect();
        let seed = truth.seed ^ u64::from(slice) << 40;
        for (part, salt) in
            outline(tracer.indices[0].0, middle).parts(&sources, FINEST).iter().zip(0_u32..)
        {
            let count = self.samples(part, middle);
            let strata = Strata::new(count, seed ^ u64::from(salt) << 16);
            for ((x, y), sample) in strata.places(self.number).zip(0_u32..) {
                let random = pcg4d([self.number, sample, salt ^ seed as u32, !(seed >> 32) as u32]);
                let late = unit(random[0]);
                let moment = self.from + self.length * late;
                let (place, center) = (part.at(x, y), self.center(moment));
                let look = self.look(place, moment);
                let Some((column, row)) = view.pixel(look.direction) else { continue };
                let is_image = population
                    .half_extent
                    .is_none_or(|half| center.cmpge(-half).all() && center.cmplt(half).all());
                if !is_image {
                    continue;
                }
                let mut light = DVec3::ZERO;
                for &(index, colors) in &tracer.indices {
                    outline(index, moment).follow(place, |way, weight, direction| {
                        if !matches!(way, Way::Inside(k) if k > MOST_REFLECTIONS) {
                            let radiance = regions.iter().map(|region| region.radiance(direction));
                            light += weight * colors * radiance.sum::<DVec3>();
                        }
                    });
                }
                if light == DVec3::ZERO {
                    continue;
                }
                let ray = Ray { moment, ..Ray::along(look.direction) };
                let near = population.shape.cross(look.point, look.direction);
                let distance = look.along + self.drop.radius * near.map_or(0.0, |(near, _)| near);
                let own = Hit { distance, drop: self.number };
                let share = self.length * part.area() / f64::from(count)
                    * look.solid_angle
                    * tracer.pixels_a_steradian(look.direction)
                    * tracer.eye.opacity(center)
                    * tracer.unhidden(own, &ray, before, view.number_in_whole(column, row));
                *pixels.entry(row * view.width + column).or_default() += share * light;
            }
        }
    }

    /// Number of samples of a part: as many as its pixels get, and more if it shows a source.
    fn samples(&self, part: &Part, moment: f64) -> u32 {
        let look = self.look(part.at(0.5, 0.5), moment);
        let steradians = self.length * part.area() * look.solid_angle;
        let pixels = steradians * self.tracer.pixels_a_steradian(look.direction);
        let of_pixels = f64::from(self.tracer.truth.samples) * pixels;
        of_pixels.max(if part.shows { FEWEST } else { 1.0 }).ceil() as u32
    }
}
