//! Glints: the images of small bright sources in drops, found instead of waited for.
//!
//! A drop shows a bare sun on some 10⁻⁶ to 10⁻⁵ of its disc, once for every way that light takes
//! through it. So what is bright and small ([`crate::environment::bright`]) is taken out of what the
//! pixels' rays find, and each of its images is sampled by itself.
//!
//! All happens in the plane of the axis (from the camera to the drop's centre) and the ray. With the
//! drop's radius r at distance d, a ray α off the axis meets it at the angle of incidence θ,
//! sin α = (r/d) sin θ, and leaves it ψ off the axis:
//!
//! - reflected, ψ = α + π - 2θ;
//! - after k internal reflections, ψ = α - 2(θ-θt) - k(π-2θt).
//!
//! ψ is concave in θ (α and θt are, as r < d and n > 1), so it has one crest at most, the rainbow's
//! ray, and is monotone on either side of it. A source Φ off the axis with angular radius ρ is seen
//! where ψ is within ρ of ±Φ + 2πm, at azimuths within asin(sin ρ / sin Φ) of the source's own or
//! of the opposite one: patches in (θ, azimuth), found by bisection. A patch is sampled evenly in
//! b² = sin²θ and azimuth, where a pixel's share of solid angle becomes area on the image plane:
//! `dA = (r/d)² / (2 cos α) db² dφ · f² / cos³γ` pixels, with γ the ray's angle to the view's axis
//! and f the plane's distance.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::light::Way;
use super::samples::Strata;
use super::tree::{Hit, Pyramid};
use super::{Drop, Ray, Tracer, Truth, Weights, flat_glints};
use crate::environment::Environment;
use crate::environment::bright::{Bright, Region, split};
use crate::optics::{Intersection, Shape};
use crate::rain::pcg4d;

/// Most internal reflections whose glints are looked for; of light that takes more, 0.02 % of all,
/// the pixels' samples find what they may.
pub(super) const MOST_REFLECTIONS: u32 = 8;

/// Drops between two words of progress.
const TOLD_EACH: u32 = 64;

/// Fewest samples of a patch.
const FEWEST: f64 = 4.0;

/// How closely a patch's ends are found, in the source's radii. What a patch has too much of is sampled,
/// and dark: under a tenth of its samples.
const END: f64 = 1.0 / 64.0;

/// How closely the crest is found, in radians. Where it is taken to be does not matter beyond: the
/// patches on either side end at the same angle.
const CREST: f64 = 1e-7;

impl Way {
    /// The ways whose glints are found.
    fn all(truth: &Truth) -> impl Iterator<Item = Self> {
        let most = match truth.weights {
            Weights::Paper => 0,
            Weights::Physical | Weights::Conserving => {
                truth.internal_reflections.min(MOST_REFLECTIONS)
            }
        };
        truth.reflection.then_some(Self::Outside).into_iter().chain((0..=most).map(Self::Inside))
    }

    /// A number of its own.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Outside => 0,
            Self::Inside(k) => 1 + k,
        }
    }

    /// Where the light comes from.
    fn direction(self, intersection: &Intersection) -> DVec3 {
        match self {
            Self::Outside => intersection.reflected(),
            Self::Inside(k) => intersection.after_internal_reflections(k),
        }
    }

    /// ψ at an angle of incidence, with r/d the sine of the drop's angular radius.
    fn angle(self, incidence: f64, sine: f64, index: f64) -> f64 {
        let b = incidence.sin();
        let (alpha, refraction) = ((sine * b).asin(), (b / index).asin());
        match self {
            Self::Outside => alpha + PI - 2.0 * incidence,
            Self::Inside(k) => {
                alpha - 2.0 * (incidence - refraction) - f64::from(k) * (PI - 2.0 * refraction)
            }
        }
    }

    /// The slope of ψ.
    fn slope(self, incidence: f64, sine: f64, index: f64) -> f64 {
        let (b, cosine) = incidence.sin_cos();
        let of_alpha = sine * cosine / (1.0 - (sine * b).powi(2)).sqrt();
        let of_refraction = cosine / (index * index - b * b).sqrt();
        match self {
            Self::Outside => of_alpha - 2.0,
            Self::Inside(k) => of_alpha - 2.0 + 2.0 * f64::from(k + 1) * of_refraction,
        }
    }

    /// Where ψ is greatest: 0 where it only falls.
    fn crest(self, sine: f64, index: f64) -> f64 {
        if self.slope(0.0, sine, index) <= 0.0 {
            return 0.0;
        }
        bisect((0.0, FRAC_PI_2), CREST, |incidence| self.slope(incidence, sine, index) > 0.0).0
    }
}

/// Where a way shows a source: angles of incidence, and azimuths from the source's.
#[derive(Clone, Copy, Debug)]
struct Patch {
    incidence: (f64, f64),
    azimuth: (f64, f64),
}

impl Patch {
    /// b² and azimuth at a place in the unit square, evenly.
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let square = self.incidence.0.sin().powi(2) + x * self.squares();
        let (from, to) = self.azimuth;
        (square.min(1.0), from + (to - from) * y)
    }

    /// Extent in b². The sine of sums keeps its digits where sin²θ differ by little.
    fn squares(&self) -> f64 {
        let (from, to) = self.incidence;
        (to - from).sin() * (to + from).sin()
    }

    /// Area in b² and azimuth.
    fn area(&self) -> f64 {
        self.squares() * (self.azimuth.1 - self.azimuth.0)
    }
}

/// Narrows an interval down to a `width`, around where `is_before` turns from true to false.
fn bisect(interval: (f64, f64), width: f64, is_before: impl Fn(f64) -> bool) -> (f64, f64) {
    let (mut from, mut to) = interval;
    while to - from > width {
        let middle = 0.5 * (from + to);
        if is_before(middle) {
            from = middle;
        } else {
            to = middle;
        }
    }
    (from, to)
}

/// Every patch on which a drop (`sine` of its angular radius) shows by a way what is within `radius`
/// of a direction that is `off` the axis.
fn patches(way: Way, index: f64, sine: f64, crest: f64, off: f64, radius: f64) -> Vec<Patch> {
    let angle = |incidence: f64| way.angle(incidence, sine, index);
    let (low, high) = (off - radius, off + radius);
    let all_around = (-PI, PI);
    // Ranges of ψ, and the azimuths that go with them.
    let mut ranges = Vec::with_capacity(2);
    if low <= 0.0 {
        ranges.push(((-high, high), all_around));
    } else if high >= PI {
        ranges.push(((low, TAU - low), all_around));
    } else {
        let wide = (radius.sin() / off.sin()).min(1.0).asin();
        ranges.push(((low, high), (-wide, wide)));
        ranges.push(((-high, -low), (PI - wide, PI + wide)));
    }
    let mut found = Vec::new();
    for (branch, rises) in [((0.0, crest), true), ((crest, FRAC_PI_2), false)] {
        if branch.0 >= branch.1 {
            continue;
        }
        let (start, end) = (angle(branch.0), angle(branch.1));
        let (least, most) = (start.min(end), start.max(end));
        // Where ψ passes a value: an interval, so that an end of a patch can be taken on its outside.
        let passes = |value: f64| bisect(branch, END * radius, |x| (angle(x) < value) == rises);
        for &((low, high), azimuth) in &ranges {
            let turns = ((least - high) / TAU).ceil() as i64..=((most - low) / TAU).floor() as i64;
            for turn in turns {
                let turn = turn as f64 * TAU;
                let (first, last) = if rises { (low, high) } else { (high, low) };
                let (first, last) = (passes(first + turn).0, passes(last + turn).1);
                if first < last {
                    found.push(Patch { incidence: (first, last), azimuth });
                }
            }
        }
    }
    found
}

/// What a scene's glints are made of.
#[derive(Clone, Debug)]
pub(super) struct Glints {
    bright: Bright,
    /// Mean luminance of the environment without its bright parts.
    mean: f64,
}

impl Glints {
    /// `None` where the environment has no small bright parts, or where the light may meet a second
    /// drop: nothing finds the images that drops show in drops.
    pub(super) fn new(environment: &Environment, truth: &Truth) -> Option<Self> {
        if !truth.glints || truth.drops_see_drops > 0 {
            return None;
        }
        let bright = split(environment)?.in_layers(environment);
        let mean = bright.rest.mean_luminance();
        Some(Self { bright, mean })
    }

    /// What the pixels' samples find in drops.
    pub(super) fn rest(&self) -> &Environment {
        &self.bright.rest
    }

    /// What the glints of each drop in view add to which pixels, in a fixed order. `progress` is called
    /// from the pool's threads with the share that is done.
    pub(super) fn trace(
        &self,
        tracer: &Tracer,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<BTreeMap<u32, DVec3>> {
        let view = &tracer.eye.view;
        let corners = view.corners([0, 0, view.width, view.height].map(f64::from));
        let pyramid = Pyramid::between(corners);
        self.of_drops(tracer, &pyramid, progress)
    }

    /// What the glints of each drop within a part of the view add, there and beside it.
    pub(super) fn within(&self, tracer: &Tracer, pyramid: &Pyramid) -> Vec<BTreeMap<u32, DVec3>> {
        self.of_drops(tracer, pyramid, &|_| ())
    }

    fn of_drops(
        &self,
        tracer: &Tracer,
        pyramid: &Pyramid,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<BTreeMap<u32, DVec3>> {
        let mut in_view = Vec::new();
        tracer.tree.within(pyramid, f64::INFINITY, &mut in_view);
        in_view.retain(|hit| {
            let drops = tracer.tree.drops();
            let drop = &drops.all[hit.drop as usize];
            // Whoever is within a drop does not see it.
            tracer.finds_glints_of(drop) && drop.center.length() > drop.radius
        });
        let done = AtomicU32::new(0);
        in_view
            .par_iter()
            .map_init(Vec::new, |before, hit| {
                let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                if done.is_multiple_of(TOLD_EACH) {
                    progress(f64::from(done) / in_view.len() as f64);
                }
                if (tracer.stop)() {
                    return BTreeMap::new();
                }
                let drops = tracer.tree.drops();
                let regions = &self.bright.regions;
                match drops.population(&drops.all[hit.drop as usize]).shape {
                    Shape::Sphere => {
                        Mirror::new(tracer, hit.drop, before).glints(regions, self.mean)
                    }
                    _ => flat_glints::glints(tracer, hit.drop, regions, before),
                }
            })
            .collect()
    }
}

/// What a drop shows of a source one way: one image, or the half of one that a rainbow doubles.
struct Glint<'a> {
    way: Way,
    /// The drop's refractive index, and the colours that it is for.
    index: f64,
    colors: DVec3,
    region: &'a Region,
    /// Unit vectors across the drop's axis: towards the source, and aside.
    frame: (DVec3, DVec3),
    patch: Patch,
}

impl Tracer<'_> {
    /// Whether the glints of a drop are found rather than met by chance: where a pinhole sees a sphere at rest, of a
    /// denser substance than what it is in, or another shape that is not too near.
    pub(super) fn finds_glints_of(&self, drop: &Drop) -> bool {
        let population = self.tree.drops().population(drop);
        let is_found = match population.shape {
            Shape::Sphere => {
                population.motion == DVec3::ZERO && self.indices.iter().all(|(n, _)| *n > 1.0)
            }
            _ => flat_glints::is_far(drop, population),
        };
        is_found && self.eye.lens == 0.0
    }

    /// Pixels for each unit of solid angle in a direction.
    pub(super) fn pixels_a_steradian(&self, direction: DVec3) -> f64 {
        let view = &self.eye.view;
        view.focal_px * view.focal_px / (-direction.dot(view.back)).powi(3)
    }

    /// What the background and the drops before a hit let through.
    pub(super) fn unhidden(&self, own: Hit, ray: &Ray, before: &[Hit], pixel: u32) -> f64 {
        let Tracer { eye, plate, tree, .. } = self;
        if own.distance >= plate.reach(pixel, -ray.direction.dot(eye.view.back)) {
            return 0.0;
        }
        let mut left = 1.0;
        for candidate in before {
            if candidate.distance > own.distance {
                break;
            }
            if let Some(distance) = tree.meet(candidate.drop, ray)
                && (Hit { distance, drop: candidate.drop }) < own
            {
                let hiding = &tree.drops().all[candidate.drop as usize];
                left *= 1.0 - eye.opacity(tree.drops().center(hiding, ray.moment));
            }
        }
        left
    }
}

/// A drop and what is before it.
struct Mirror<'a> {
    tracer: &'a Tracer<'a>,
    number: u32,
    drop: &'a Drop,
    /// Unit vector from the camera to the centre.
    axis: DVec3,
    /// From the camera to the centre, in scene units.
    distance: f64,
    /// Sine of its angular radius.
    sine: f64,
    /// Drops that may hide parts of it.
    before: &'a [Hit],
}

impl<'a> Mirror<'a> {
    /// The drop of this number. `before` is filled with what may hide it.
    fn new(tracer: &'a Tracer<'a>, number: u32, before: &'a mut Vec<Hit>) -> Self {
        let drop = &tracer.tree.drops().all[number as usize];
        let distance = drop.center.length();
        let (axis, sine) = (drop.center / distance, drop.radius / distance);
        // The square around its outline, at depth 1.
        let tangent = sine / (1.0 - sine * sine).sqrt();
        let (u, v) = axis.any_orthonormal_pair();
        let corners = [u + v, u - v, -u - v, v - u].map(|corner| axis + tangent * corner);
        tracer.tree.within(&Pyramid::between(corners), distance, before);
        before.retain(|hit| hit.drop != number);
        Self { tracer, number, drop, axis, distance, sine, before }
    }

    /// The light of every glint, by pixel. `mean` is the luminance that a glint is weighed against.
    fn glints(&self, regions: &[Region], mean: f64) -> BTreeMap<u32, DVec3> {
        let truth = &self.tracer.truth;
        let mut pixels = BTreeMap::new();
        let indices = self.tracer.indices.iter().zip(0_u32..);
        for (way, (&(index, colors), of_index)) in
            Way::all(truth).flat_map(|way| indices.clone().map(move |index| (way, index)))
        {
            let crest = way.crest(self.sine, index);
            for (region, source) in regions.iter().zip(0_u32..) {
                let off = self.axis.angle_between(region.direction);
                let aside = region.direction.reject_from_normalized(self.axis);
                let aside = aside.try_normalize().unwrap_or(self.axis.any_orthonormal_vector());
                let frame = (aside, self.axis.cross(aside));
                // A function of the drop, the way and the source, so that the noise of one way is the
                // same whether another is left out or not.
                let salt = of_index << 28 | way.number() << 16 | source;
                let [low, high, ..] =
                    pcg4d([self.number, salt, truth.seed as u32, (truth.seed >> 32) as u32]);
                let seed = u64::from(low) | u64::from(high) << 32;
                let found = patches(way, index, self.sine, crest, off, region.radius);
                for (patch, number) in found.into_iter().zip(0..) {
                    let glint = Glint { way, index, colors, region, frame, patch };
                    self.sample(&glint, self.samples(&glint, mean), seed, number, &mut pixels);
                }
            }
        }
        pixels
    }

    /// Number of samples: as many as its pixels get, fewer where it is less bright than the environment's `mean`.
    fn samples(&self, glint: &Glint, mean: f64) -> u32 {
        let truth = &self.tracer.truth;
        let (intersection, cos_alpha) = self.ray(glint, (0.5, 0.5));
        let view = &self.tracer.eye.view;
        let picture = f64::from(view.whole[0]) * f64::from(view.whole[1]);
        // A drop that reaches out of view may have its middle there: no farther out than 78 degrees.
        let cos_gamma = -intersection.direction.dot(view.back).min(-0.2);
        let pixels = (glint.patch.area() * self.density(cos_alpha, cos_gamma)).min(picture);
        let light = glint.way.weight(&intersection, truth) * glint.region.luminance * pixels;
        (f64::from(truth.samples) * pixels.max(1.0).min(light / mean)).max(FEWEST) as u32
    }

    /// Adds the light of one glint, the drop's `number`th of its way and source.
    fn sample(
        &self,
        glint: &Glint,
        samples: u32,
        seed: u64,
        number: u32,
        pixels: &mut BTreeMap<u32, DVec3>,
    ) {
        let view = &self.tracer.eye.view;
        let opacity = self.tracer.eye.opacity(self.drop.center);
        let share = glint.patch.area() / f64::from(samples);
        for ((x, y), sample) in Strata::new(samples, seed).places(number).zip(0_u32..) {
            let (intersection, cos_alpha) = self.ray(glint, (x, y));
            let Some((column, row)) = view.pixel(intersection.direction) else { continue };
            let light = glint.region.radiance(glint.way.direction(&intersection));
            if light == DVec3::ZERO {
                continue;
            }
            let area = share * self.density(cos_alpha, -intersection.direction.dot(view.back));
            // Only drops that move ask for it: independent of the place in the patch.
            let moment = [number, sample, seed as u32, !(seed >> 32) as u32];
            let moment = f64::from(pcg4d(moment)[0]) / 4_294_967_296.0;
            let weight = area
                * glint.way.weight(&intersection, &self.tracer.truth)
                * opacity
                * self.unhidden(
                    &intersection,
                    cos_alpha,
                    view.number_in_whole(column, row),
                    moment,
                );
            *pixels.entry(row * view.width + column).or_default() += weight * light * glint.colors;
        }
    }

    /// The intersection of the ray that meets the drop at a place of a glint's patch, and cos α.
    fn ray(&self, glint: &Glint, place: (f64, f64)) -> (Intersection, f64) {
        let (square, azimuth) = glint.patch.at(place.0, place.1);
        let frame = glint.frame;
        let impact_parameter = square.sqrt();
        let sin_alpha = self.sine * impact_parameter;
        let cos_alpha = (1.0 - sin_alpha * sin_alpha).sqrt();
        let (sine, cosine) = azimuth.sin_cos();
        let aside = cosine * frame.0 + sine * frame.1;
        let intersection = Intersection {
            direction: cos_alpha * self.axis + sin_alpha * aside,
            offset: cos_alpha * aside - sin_alpha * self.axis,
            impact_parameter,
            cos_incidence: (1.0 - square).sqrt(),
            index: glint.index,
        };
        (intersection, cos_alpha)
    }

    /// Pixels for each unit of b² and azimuth.
    fn density(&self, cos_alpha: f64, cos_gamma: f64) -> f64 {
        let focal = self.tracer.eye.view.focal_px;
        self.sine * self.sine / (2.0 * cos_alpha) * focal * focal / cos_gamma.powi(3)
    }

    /// What the background and the drops before this one let through, at a moment: drops that move may be
    /// before it for a part of the exposure.
    fn unhidden(
        &self,
        intersection: &Intersection,
        cos_alpha: f64,
        pixel: u32,
        moment: f64,
    ) -> f64 {
        let distance = self.distance * cos_alpha - self.drop.radius * intersection.cos_incidence;
        let own = Hit { distance, drop: self.number };
        let ray = Ray { moment, ..Ray::along(intersection.direction) };
        self.tracer.unhidden(own, &ray, self.before, pixel)
    }
}
