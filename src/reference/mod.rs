//! The truth: the picture that every model is held against, by a float64 ray tracer on the CPU.
//!
//! Nothing here is quick on purpose, and nothing approximates: rays meet spheres in true
//! perspective, the optics are those of [`crate::optics`], a pixel is the mean over its square (a
//! box filter) by stratified samples. A drop covers what is behind it wholly, for it shows the
//! environment *through* itself; so a ray ends at the first drop that it meets, and what a pixel
//! sees of a drop's edge comes from its samples. As the paper assumes, a drop sees only the
//! environment, unless [`Truth::drops_see_drops`] asks for more.
//!
//! Radiance of a ray that meets a drop with Fresnel reflectance F:
//! `F E(R) + Σ (1-F)² F^k E(T_k)` over k = 0 … K internal reflections.
//!
//! What is small and very bright, as a bare sun, such rays meet in a drop by chance alone; it is taken
//! out of what they find, and its images are looked for ([`Truth::glints`], `glints.rs`).
//!
//! The rays of 8 x 8 pixels share a pyramid; a tree gives the drops in it once, front to back.

mod drops;
mod glints;
pub mod paper;
mod samples;
mod tree;

pub use drops::{Sphere, fade, of_scene};
pub use samples::Strata;
pub use tree::{Hit, Pyramid, Tree};

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::glints::{Glints, MOST_REFLECTIONS};
use crate::environment::Environment;
use crate::optics::{Encounter, WATER};
use crate::picture::Picture;
use crate::scene::Scene;
use crate::scene::camera::View;

/// Edge of a tile in pixels. Of the rain's million drops a tile of 8 x 8 holds about ten: few
/// enough for every ray to try them all, and the tree is asked 64 times less often.
const TILE: u32 = 8;

/// A ray that carries less than this share of its pixel meets no further drops and takes the
/// environment instead. Bounds the fan of rays that [`Truth::drops_see_drops`] opens (an error of
/// a thousandth of the difference between the environment and a drop, at most, per such ray).
const FAINT: f64 = 1e-3;

/// How a drop's reflected and transmitted light are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Weights {
    /// F for the reflection, (1-F)² F^k after k internal reflections: what a sphere does.
    #[default]
    Physical,
    /// F for the reflection, 1-F for the twice refracted ray, no internal reflections (the paper's
    /// equation 5).
    Paper,
}

/// What is computed, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Samples a pixel; 0 is taken as 1.
    pub samples: u32,
    /// Chooses the samples' places within their strata.
    pub seed: u64,
    /// Most internal reflections K. What is left out is a share (1-F) F^(K+1) of a ray's light
    /// ([`Encounter::weight_beyond_internal_reflections`]): over a far drop's disc 5 % for K = 0,
    /// 0.8 % for K = 1, under 0.02 % for K = 8.
    pub internal_reflections: u32,
    /// Physical weights or the paper's.
    pub weights: Weights,
    /// Whether the outside reflects; without, the term F E(R) is left out and nothing stands in.
    pub reflection: bool,
    /// How many further drops the light leaving a drop may go through before the environment takes
    /// its place. 0: a drop sees only the environment (the paper's assumption).
    pub drops_see_drops: u32,
    /// Whether the images of small bright sources in drops are looked for; without, or where drops
    /// see drops, the pixels' samples meet them by chance. The same on the mean; an environment
    /// without such sources ([`crate::environment::bright`]) is traced the same to the bit.
    pub glints: bool,
}

impl Default for Truth {
    fn default() -> Self {
        Self {
            samples: 64,
            seed: 0,
            internal_reflections: 8,
            weights: Weights::Physical,
            reflection: true,
            drops_see_drops: 0,
            glints: true,
        }
    }
}

/// A picture, and where its drops are.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Linear radiance.
    pub picture: Picture,
    /// Share of each pixel that drops cover, 0 to 1, row by row from the top.
    pub coverage: Vec<f32>,
}

/// A scene made ready for tracing.
#[derive(Clone, Debug)]
pub struct Tracer<'a> {
    truth: Truth,
    view: View,
    environment: &'a Environment,
    glints: Option<Glints>,
    tree: Tree,
}

impl<'a> Tracer<'a> {
    /// The drops of a validated scene. The scene's models are ignored: the truth has none.
    pub fn new(scene: &Scene, environment: &'a Environment, truth: Truth) -> Self {
        Self::of_spheres(scene.view(), of_scene(scene), environment, truth)
    }

    /// Any spheres, relative to the camera; each must have the camera outside of it.
    pub fn of_spheres(
        view: View,
        spheres: Vec<Sphere>,
        environment: &'a Environment,
        truth: Truth,
    ) -> Self {
        let glints = Glints::new(environment, &truth);
        Self { truth, view, environment, glints, tree: Tree::new(spheres) }
    }

    /// The drops, and which of them a ray meets.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Radiance that arrives at the camera from a unit direction, in world space.
    pub fn radiance_along(&self, direction: DVec3) -> DVec3 {
        let next = |after| self.tree.first_hit(DVec3::ZERO, direction, after, None);
        let depth = self.truth.drops_see_drops;
        self.gather(DVec3::ZERO, direction, 1.0, depth, self.environment, next).0
    }

    /// The picture, on the threads of the current rayon pool; the same for any number of them.
    /// `progress` is called from these threads with the share that is done, 0 to 1.
    pub fn trace(&self, progress: &(dyn Fn(f64) + Sync)) -> Traced {
        let (width, height) = (self.view.width, self.view.height);
        let strata = Strata::new(self.truth.samples, self.truth.seed);
        let count = self.tiles();
        // The glints' time is of the tiles' order, more or less by their number.
        let of_tiles = if self.glints.is_some() { 0.5 } else { 1.0 };
        let done = AtomicU32::new(0);
        let tiles: Vec<Vec<(DVec3, f64)>> = (0..count)
            .into_par_iter()
            .map_init(Vec::new, |candidates, tile| {
                let (left, upper) = self.corner_of(tile);
                let pixels = self.tile(left, upper, &strata, candidates);
                let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                progress(of_tiles * f64::from(done) / f64::from(count));
                pixels
            })
            .collect();

        let mut pixels = vec![DVec3::ZERO; width as usize * height as usize];
        let mut coverage = vec![0.0_f32; pixels.len()];
        for (tile, traced) in (0..).zip(tiles) {
            let (left, upper) = self.corner_of(tile);
            for ((x, y), (radiance, covered)) in self.pixels_of(left, upper).zip(traced) {
                let at = y as usize * width as usize + x as usize;
                (pixels[at], coverage[at]) = (radiance, covered as f32);
            }
        }
        let of_glints = |share: f64| progress(of_tiles + (1.0 - of_tiles) * share);
        let glints = self.glints.as_ref().map(|glints| glints.trace(self, &of_glints));
        for (pixel, light) in glints.into_iter().flatten().flatten() {
            pixels[pixel as usize] += light;
        }
        let pixels = pixels.iter().map(|pixel| pixel.as_vec3()).collect();
        Traced { picture: Picture { width, height, pixels }, coverage }
    }

    /// The picture alone, without progress.
    pub fn picture(&self) -> Picture {
        self.trace(&|_| ()).picture
    }

    /// The same with other places for its samples.
    pub fn with_seed(&self, seed: u64) -> Self {
        Self { truth: Truth { seed, ..self.truth }, ..self.clone() }
    }

    /// Tiles of 8 x 8 pixels that the picture is traced by, row by row.
    pub fn tiles(&self) -> u32 {
        self.view.width.div_ceil(TILE) * self.view.height.div_ceil(TILE)
    }

    /// Whether a drop may be seen in a tile.
    pub fn shows_drops(&self, tile: u32) -> bool {
        let mut found = Vec::new();
        let (left, upper) = self.corner_of(tile);
        self.tree.within(&self.pyramid_of(left, upper), f64::INFINITY, &mut found);
        !found.is_empty()
    }

    /// A tile's pixels, each with its number row by row in the picture: as [`Tracer::trace`] has them, but
    /// for the last digits, for a part of a picture.
    pub fn trace_tile(&self, tile: u32) -> Vec<(u32, DVec3)> {
        let strata = Strata::new(self.truth.samples, self.truth.seed);
        let (left, upper) = self.corner_of(tile);
        let traced = self.tile(left, upper, &strata, &mut Vec::new());
        let numbers = self.pixels_of(left, upper).map(|(x, y)| y * self.view.width + x);
        let mut pixels: Vec<(u32, DVec3)> =
            numbers.zip(traced).map(|(number, (radiance, _))| (number, radiance)).collect();
        let pyramid = self.pyramid_of(left, upper);
        for (number, light) in
            self.glints.iter().flat_map(|glints| glints.within(self, &pyramid)).flatten()
        {
            if let Some((_, radiance)) = pixels.iter_mut().find(|(pixel, _)| *pixel == number) {
                *radiance += light;
            }
        }
        pixels
    }

    /// Column and row of a tile's first pixel.
    fn corner_of(&self, tile: u32) -> (u32, u32) {
        let columns = self.view.width.div_ceil(TILE);
        (tile % columns * TILE, tile / columns * TILE)
    }

    /// The rays through a tile.
    fn pyramid_of(&self, left: u32, upper: u32) -> Pyramid {
        let (right, lower) = (left + TILE, upper + TILE);
        let corners = [(left, upper), (right, upper), (right, lower), (left, lower)];
        Pyramid::between(corners.map(|(x, y)| self.view.ray(f64::from(x), f64::from(y))))
    }

    /// The pixels of a tile, row by row; a tile at the right or lower edge may be narrower.
    fn pixels_of(&self, left: u32, upper: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let right = (left + TILE).min(self.view.width);
        let lower = (upper + TILE).min(self.view.height);
        (upper..lower).flat_map(move |y| (left..right).map(move |x| (x, y)))
    }

    /// Mean radiance and coverage of a tile's pixels. `candidates` is scratch space.
    fn tile(
        &self,
        left: u32,
        upper: u32,
        strata: &Strata,
        candidates: &mut Vec<Hit>,
    ) -> Vec<(DVec3, f64)> {
        self.tree.within(&self.pyramid_of(left, upper), f64::INFINITY, candidates);
        let seen = self.glints.as_ref().map_or(self.environment, Glints::rest);
        self.pixels_of(left, upper)
            .map(|(x, y)| {
                let (mut radiance, mut covered, mut count) = (DVec3::ZERO, 0.0, 0.0);
                for (right, down) in strata.places(y * self.view.width + x) {
                    let direction = self.view.ray(f64::from(x) + right, f64::from(y) + down);
                    let next = |after| self.tree.first_hit_of(candidates, direction, after);
                    let depth = self.truth.drops_see_drops;
                    let (light, opacity) =
                        self.gather(DVec3::ZERO, direction, 1.0, depth, seen, next);
                    radiance += light;
                    covered += opacity;
                    count += 1.0;
                }
                (radiance / count, covered / count)
            })
            .collect()
    }

    /// Radiance along a ray, and how far drops cover it, given its hits one after the other. A drop
    /// that fades in lets the rest of the light through unbent. `seen` is what drops see where
    /// their glints are found apart.
    fn gather(
        &self,
        origin: DVec3,
        direction: DVec3,
        share: f64,
        depth: u32,
        seen: &Environment,
        next: impl Fn(Hit) -> Hit,
    ) -> (DVec3, f64) {
        let (mut sum, mut left) = (DVec3::ZERO, 1.0);
        let mut hit = next(Hit::START);
        while let Some(sphere) = self.tree.spheres().get(hit.sphere as usize) {
            let center = sphere.center - origin;
            if let Some(encounter) = Encounter::of_ray(direction, center, sphere.radius) {
                let share = share * left * sphere.opacity;
                sum += left
                    * sphere.opacity
                    * self.leaving(&encounter, hit.sphere, share, depth, seen);
                left *= 1.0 - sphere.opacity;
            }
            if left <= 0.0 {
                return (sum, 1.0);
            }
            hit = next(hit);
        }
        (sum + left * self.environment.radiance(direction), 1.0 - left)
    }

    /// Radiance that leaves a drop against the ray of the encounter.
    fn leaving(
        &self,
        encounter: &Encounter,
        number: u32,
        share: f64,
        depth: u32,
        seen: &Environment,
    ) -> DVec3 {
        let reflectance = encounter.reflectance();
        let arriving = |seen: &Environment, weight, direction, exit: &dyn Fn() -> DVec3| {
            let share = weight * share;
            if depth == 0 || share < FAINT {
                return weight * seen.radiance(direction);
            }
            let sphere = &self.tree.spheres()[number as usize];
            let origin = sphere.center + sphere.radius * exit();
            let next = |after| self.tree.first_hit(origin, direction, after, Some(number));
            weight * self.gather(origin, direction, share, depth - 1, seen, next).0
        };
        let mut sum = DVec3::ZERO;
        if self.truth.reflection {
            sum += arriving(seen, reflectance, encounter.reflected(), &|| encounter.normal());
        }
        match self.truth.weights {
            Weights::Paper => {
                let exit = || exit_normal(encounter, 0);
                sum += arriving(seen, 1.0 - reflectance, encounter.transmitted(), &exit);
            }
            Weights::Physical => {
                for k in 0..=self.truth.internal_reflections {
                    let seen = if k <= MOST_REFLECTIONS { seen } else { self.environment };
                    sum += arriving(
                        seen,
                        encounter.weight_of_internal_reflections(k),
                        encounter.after_internal_reflections(k),
                        &|| exit_normal(encounter, k),
                    );
                    // Away from the rim F is a few percent: a dozen orders exhaust float64.
                    if encounter.weight_beyond_internal_reflections(k) < f64::EPSILON {
                        break;
                    }
                }
            }
        }
        sum
    }
}

/// Outward normal where the light leaves the drop after `k` internal reflections: each of the k + 1
/// chords turns the normal by π-2θt, in the plane of the ray, towards and past the centre.
pub fn exit_normal(encounter: &Encounter, k: u32) -> DVec3 {
    let (st, ct) = (encounter.impact_parameter / WATER, encounter.cos_refraction());
    let (turn_cosine, turn_sine) = (st * st - ct * ct, 2.0 * st * ct);
    let (mut along, mut across) = (-encounter.cos_incidence, encounter.impact_parameter);
    for _ in 0..=k {
        (along, across) =
            (along * turn_cosine + across * turn_sine, across * turn_cosine - along * turn_sine);
    }
    along * encounter.direction + across * encounter.offset
}
