//! Real rain beyond the bound to which its drops are traced: a medium that takes light out of a ray and puts
//! in that of a far drop.
//!
//! Extinction is the drops' outlines, σ = (π/4) ∫ N D² dD times what flattening does to an outline by the
//! ray's elevation. The light is that of a far drop, of a size and met at a place of its outline that each
//! sample draws.
//!
//! The small bright parts of an environment ([`crate::environment::bright`]) are met so by chance alone: one
//! sample in 10⁵ would have all the light of a bare sun. They are taken out of what samples find, and come by
//! the far drop's *phase function*, how much light a sphere sends on by the angle between where it is seen
//! and where the light comes from; what flattened drops send depends on both directions (`flat_light.rs`). So it is for
//! the drops that are traced and are smaller than [`SMALL_PX`]: their glints stand somewhere in the pixel either way.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::Truth;
use super::flat_light::FlatLight;
use super::shelter::Roof;
use crate::environment::Environment;
use crate::environment::bright::{Bright, Region, split};
use crate::optics::{Intersection, Shape};
use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED};
use crate::scene::Scene;
use crate::scene::camera::View;
use crate::scene::model::DropShape;
use crate::scene::real_rain::RealRain;

/// Radius in pixels under which a traced drop shows the bright parts spread over its disc.
pub(super) const SMALL_PX: f64 = 0.5;

/// Sizes of equal blocked area that the mean outline is taken over.
const SIZES: u32 = 64;

/// Rows of the extinction, by the square of the sine of the elevation, less one.
const ELEVATIONS: usize = 64;

/// Angles of the phase function: a hundredth of a degree each.
const ANGLES: usize = 18_000;

/// Rings of equal area of a drop's disc that light is followed from.
const RINGS: u32 = 1 << 15;

/// The medium, and a far drop.
#[derive(Clone, Debug)]
pub(super) struct FarRain {
    /// Extinction a scene unit, by the square of the sine of the ray's elevation.
    extinction: Vec<f64>,
    /// Where drops end and the medium begins, and where that ends, in scene units.
    from: f64,
    to: f64,
    /// The shapes of drops that block as much as each other.
    sizes: Vec<Halves>,
    /// The law of flattened drops, and how much of what drops block is theirs.
    flat: Option<(Law, f64)>,
    /// Length of a scene unit, m.
    metres: f64,
    /// What shelters it, with the velocity of each class and its share of what drops block.
    sheltered: Option<(Roof, Vec<(DVec3, f64)>)>,
    suns: Option<Suns>,
}

/// What a sample meets in the medium: two numbers of 0 to 1 for a place in a unit square, one for a drop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chance {
    pub(super) place: (f64, f64),
    pub(super) drop: f64,
}

/// The small bright parts of the environment, and how far drops show them.
#[derive(Clone, Debug)]
struct Suns {
    bright: Bright,
    /// A phase function each refractive index, with the colours that it is for.
    phases: Vec<(Phase, DVec3)>,
    /// What flattened drops show.
    flat: Option<FlatLight>,
}

/// What small drops show of an environment with bright parts.
#[derive(Clone, Copy)]
pub(super) struct SmallDrops<'a> {
    /// The environment without them.
    pub(super) rest: &'a Environment,
    /// Their light in a sphere.
    of_sphere: DVec3,
    /// Their light in flattened drops, and millimetres of diameter for each unit of radius.
    flat: Option<(&'a FlatLight, f64)>,
}

impl SmallDrops<'_> {
    /// Light of the bright parts in a drop seen in a unit direction; `None` where chance finds it.
    pub(super) fn light(&self, shape: Shape, radius: f64, direction: DVec3) -> Option<DVec3> {
        match shape {
            Shape::Sphere => Some(self.of_sphere),
            Shape::Halves { .. } => {
                self.flat.map(|(flat, diameter)| flat.of(diameter * radius, direction))
            }
            Shape::Spheroid { .. } => None,
        }
    }
}

/// Share of the light for each unit of solid angle, by angle.
#[derive(Clone, Debug)]
struct Phase(Vec<f64>);

impl FarRain {
    /// The rain of a scene beyond `bound` metres.
    pub(super) fn new(
        scene: &Scene,
        rain: &RealRain,
        bound: f64,
        environment: &Environment,
        truth: &Truth,
        indices: &[(f64, DVec3)],
    ) -> Self {
        let suns = split(environment).filter(|_| truth.glints).map(|bright| {
            let phases = indices.iter().map(|&(index, colors)| (Phase::of(truth, index), colors));
            let bright = bright.in_layers(environment);
            Suns { bright, phases: phases.collect(), flat: None }
        });
        let law = rain.law();
        let shares = (0..SIZES).map(|size| (f64::from(size) + 0.5) / f64::from(SIZES));
        let diameters = shares.map(|share| match rain.shape {
            DropShape::Sphere => 0.0,
            DropShape::Equilibrium => law.quantile(2.0, share),
        });
        let sizes: Vec<Halves> = diameters.map(Halves::of_diameter).collect();
        let extinction = (0..=ELEVATIONS).map(|row| {
            let sine = (row as f64 / ELEVATIONS as f64).sqrt();
            let outlines = sizes.iter().map(|halves| halves.outline_area(sine)).sum::<f64>();
            law.extinction() * scene.metres * outlines / f64::from(SIZES)
        });
        let flat = (rain.shape == DropShape::Equilibrium).then(|| {
            let of_flat = law.moment_between(2.0, SMALLEST_FLATTENED, law.to);
            (law, of_flat / law.moment(2.0))
        });
        let sheltered = Roof::of(scene).map(|roof| {
            let all = law.moment(2.0);
            let classes = rain.classes().into_iter().map(|class| {
                let velocity = (rain.wind - class.speed * DVec3::Y) / scene.metres;
                (velocity, law.moment_between(2.0, class.from, class.to) / all)
            });
            (roof, classes.collect())
        });
        Self {
            flat,
            sheltered,
            metres: scene.metres,
            extinction: extinction.collect(),
            from: bound / scene.metres,
            to: rain.extent / scene.metres,
            sizes,
            suns,
        }
    }

    /// The part of what drops block along a unit direction between two distances that no surface keeps off.
    pub(super) fn clear(&self, direction: DVec3, from: f64, reach: f64) -> f64 {
        let (from, to) = (self.from.max(from), self.to.min(reach));
        let Some((roof, classes)) = self.sheltered.as_ref().filter(|_| from < to) else {
            return 1.0;
        };
        let under = |(velocity, share): &(DVec3, f64)| {
            share * roof.length_under(direction, [from, to], *velocity)
        };
        1.0 - classes.iter().map(under).sum::<f64>() / (to - from)
    }

    /// What the medium lets through along a unit direction between two distances, of which a part is `clear`.
    pub(super) fn transmittance(&self, direction: DVec3, from: f64, reach: f64, clear: f64) -> f64 {
        let length = clear * (self.to.min(reach) - self.from.max(from));
        if length <= 0.0 {
            return 1.0;
        }
        let place = direction.y * direction.y * ELEVATIONS as f64;
        let row = (place as usize).min(ELEVATIONS - 1);
        let (low, high) = (self.extinction[row], self.extinction[row + 1]);
        (-(low + (place - row as f64) * (high - low)) * length).exp()
    }

    /// Follows the bright parts' light through flattened drops, by rays of the truth's seed.
    pub(super) fn light_flat_drops(
        &mut self,
        view: &View,
        truth: &Truth,
        indices: &[(f64, DVec3)],
        stop: fn() -> bool,
    ) {
        if let (Some(suns), Some((law, _))) = (&mut self.suns, &self.flat) {
            suns.flat = FlatLight::new(*view, law, &suns.bright.regions, truth, indices, stop);
        }
    }

    /// What small drops show, with the bright parts' light in a sphere; `None` without bright parts.
    pub(super) fn small_drops(&self, of_sphere: DVec3) -> Option<SmallDrops<'_>> {
        let suns = self.suns.as_ref()?;
        let flat = suns.flat.as_ref().map(|flat| (flat, 2e3 * self.metres));
        Some(SmallDrops { rest: &suns.bright.rest, of_sphere, flat })
    }

    /// The bright parts' light in a drop of the medium, with that in a sphere.
    pub(super) fn of_suns_in_medium(&self, direction: DVec3, of_sphere: DVec3) -> DVec3 {
        let flat = self.suns.as_ref().and_then(|suns| suns.flat.as_ref());
        match (flat, self.flat) {
            (Some(flat), Some((_, share))) => of_sphere.lerp(flat.mean(direction), share),
            _ => of_sphere,
        }
    }

    /// What drops show but for the bright parts that [`FarRain::of_suns`] has, if there are any.
    fn rest(&self) -> Option<&Environment> {
        self.suns.as_ref().map(|suns| &suns.bright.rest)
    }

    /// Light of a far drop seen in a unit direction, without the bright parts, where a ray meets it: of all
    /// sizes by what they block, at any place of its outline.
    pub(super) fn of_drop(
        &self,
        truth: &Truth,
        indices: &[(f64, DVec3)],
        environment: &Environment,
        direction: DVec3,
        chance: Chance,
    ) -> DVec3 {
        let environment = self.rest().unwrap_or(environment);
        let Chance { place: (square, turn), drop } = chance;
        let (sine, cosine) = (TAU * turn).sin_cos();
        let (halves, up) = self.half(direction.y, drop);
        let mut sum = DVec3::ZERO;
        if halves.top == halves.equatorial {
            let (u, v) = direction.any_orthonormal_pair();
            let intersection = intersection(direction, cosine * u + sine * v, square);
            for &(index, colors) in indices {
                truth.of_sphere(&intersection.with_index(index), |_, weight, direction, _| {
                    sum += weight * colors * environment.radiance(direction);
                });
            }
            return sum;
        }
        let (right, upwards) = across(direction);
        let aside = square.sqrt() * halves.equatorial * cosine;
        let point =
            aside * right + square.sqrt() * up * sine.abs() * upwards + DVec3::Y * halves.joint;
        let shape = Shape::from(halves);
        // On the very outline it may be missed by a rounding.
        let near = shape.cross(point, direction).map_or(0.0, |(near, _)| near);
        for &(index, colors) in indices {
            let light = |_, weight, direction, _: &dyn Fn() -> DVec3| {
                sum += weight * colors * environment.radiance(direction);
            };
            truth.of_shape(shape, point + near * direction, direction, index, light);
        }
        sum
    }

    /// The drop that a number of 0 to 1 chooses by its outline, and the height in the picture of the upper
    /// half or, negative, the lower, by theirs.
    fn half(&self, sine: f64, drop: f64) -> (Halves, f64) {
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let heights = |halves: &Halves| {
            [halves.top, halves.bottom].map(|half| (half * cosine).hypot(halves.equatorial * sine))
        };
        let all: f64 = self.sizes.iter().map(|halves| halves.outline_area(sine)).sum();
        // Twice the outline is the width times both heights.
        let mut left = 2.0 * drop * all;
        for halves in &self.sizes {
            let [top, bottom] = heights(halves);
            for height in [top, -bottom] {
                left -= halves.equatorial * height.abs();
                if left <= 0.0 {
                    return (*halves, height);
                }
            }
        }
        (self.sizes[0], heights(&self.sizes[0])[0])
    }

    /// The bright parts' light in a small sphere seen in a unit direction: a place in each part, drawn by two
    /// numbers of 0 to 1.
    pub(super) fn of_suns(&self, direction: DVec3, place: (f64, f64)) -> DVec3 {
        let Some(Suns { bright, phases, .. }) = &self.suns else { return DVec3::ZERO };
        let of_region = |region: &Region| {
            let from = region.at(place.0, place.1);
            let light = region.solid_angle() * region.radiance(from);
            let angle = direction.angle_between(from);
            let share = |(phase, colors): &(Phase, DVec3)| phase.at(angle) * *colors;
            light * phases.iter().map(share).sum::<DVec3>()
        };
        bright.regions.iter().map(of_region).sum()
    }
}

/// Unit vectors across a direction: level, and as steeply upwards as can be.
fn across(direction: DVec3) -> (DVec3, DVec3) {
    let right = direction.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    (right, right.cross(direction))
}

/// A ray that meets a sphere at the square of an impact parameter.
fn intersection(direction: DVec3, offset: DVec3, square: f64) -> Intersection {
    Intersection {
        direction,
        offset,
        impact_parameter: square.sqrt(),
        cos_incidence: (1.0 - square).sqrt(),
        index: 1.0,
    }
}

impl Phase {
    /// That of a sphere: rays in rings of equal area, the light between two neighbours spread evenly over the
    /// angles between those where they leave.
    fn of(truth: &Truth, index: f64) -> Self {
        let mut light = vec![0.0; ANGLES];
        let [mut before, mut now] = [Vec::<(f64, f64)>::new(), Vec::new()];
        for ring in 0..=RINGS {
            let square = f64::from(ring) / f64::from(RINGS);
            let intersection = intersection(DVec3::NEG_Z, DVec3::X, square).with_index(index);
            now.clear();
            truth.of_sphere(&intersection, |_, weight, direction, _| {
                let angle = direction.x.hypot(direction.y).atan2(-direction.z);
                now.push((weight, angle * ANGLES as f64 / PI));
            });
            for ((weight, angle), (weight_before, angle_before)) in now.iter().zip(&before) {
                let share = 0.5 * (weight + weight_before) / f64::from(RINGS);
                spread(&mut light, share, angle.min(*angle_before), angle.max(*angle_before));
            }
            std::mem::swap(&mut before, &mut now);
        }
        let solid_angle = |bin: usize| {
            let edge = |bin: usize| (bin as f64 * PI / ANGLES as f64).cos();
            TAU * (edge(bin) - edge(bin + 1))
        };
        Self((0..).zip(light).map(|(bin, light)| light / solid_angle(bin)).collect())
    }

    fn at(&self, angle: f64) -> f64 {
        self.0[((angle * ANGLES as f64 / PI) as usize).min(ANGLES - 1)]
    }
}

/// Adds a share to the bins between two places, by how much of each they hold.
fn spread(bins: &mut [f64], share: f64, from: f64, to: f64) {
    let last = bins.len() - 1;
    let (first_bin, last_bin) = ((from as usize).min(last), (to as usize).min(last));
    if first_bin == last_bin {
        bins[first_bin] += share;
        return;
    }
    for (bin, sum) in (first_bin..).zip(&mut bins[first_bin..=last_bin]) {
        let held = (to.min(bin as f64 + 1.0) - from.max(bin as f64)).max(0.0);
        *sum += share * held / (to - from);
    }
}
