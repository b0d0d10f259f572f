//! The reference: the picture that every model is held against, by a float64 ray tracer on the CPU.
//!
//! Nothing here is quick on purpose, and nothing approximates: rays meet drops in true perspective, the
//! optics are those of [`crate::optics`], a pixel is the mean over its square (a box filter), over the
//! exposure and over the lens, by samples that are stratified together. A drop covers what is behind it
//! wholly, for it shows the environment *through* itself; so a ray ends at the first drop that it meets,
//! and what a pixel sees of a drop's edge comes from its samples. As the paper assumes, a drop sees only
//! the environment, unless [`Truth::drops_see_drops`] asks for more. What is behind the drops is the
//! environment or a [`Plate`]; a drop farther away than the plate's depth is hidden.
//!
//! Radiance of a ray that meets a sphere with Fresnel reflectance F:
//! `F E(R) + Σ (1-F)² F^k E(T_k)` over k = 0 … K internal reflections. Of other shapes each interface has
//! its own F, and weights are products along the path.
//!
//! What is small and very bright, as a bare sun, such rays meet in a drop by chance alone. Seen by a pinhole, in spheres at
//! rest and in flattened drops it is taken out of what they find, and its images are looked for
//! ([`Truth::glints`], `glints.rs`, `flat_glints.rs`). In others it is left to chance: as true on the mean, but noisy.
//!
//! The rays of 8 x 8 pixels share a pyramid; a tree gives the drops in it once, front to back.
//!
//! Real rain is not stored: out to a bound ([`Truth::rain_to`]) each tile finds its own drops in the rain's
//! cells (`weather.rs`, `rain.rs`); beyond it is a medium (`far.rs`).

mod drops;
mod eye;
mod far;
mod flat_glints;
mod flat_light;
mod glints;
mod light;
mod outline;
mod pane;
mod pane_grid;
pub mod paper;
mod rain;
mod samples;
mod shelter;
mod sobol;
mod tree;
mod weather;

pub use drops::{Drop, Drops, Population, fade, of_scene};
pub use eye::{Eye, Ray};
pub use pane::OnPane;
pub use rain::{MOST_TRACED, usual_bound};
pub use samples::{Sample, Samples, Strata};
pub use sobol::Sobol;
pub use tree::{Hit, Pyramid, Tree};

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::far::{FarRain, SmallDrops};
use self::glints::Glints;
use self::pane::{Pane, Passed, Told};
use self::rain::NearRain;
use self::weather::Weather;
use crate::environment::Environment;
use crate::optics::WATER;
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::scene::Scene;
use crate::scene::camera::View;

/// Edge of a tile in pixels. Of the rain's million drops a tile of 8 x 8 holds about ten: few
/// enough for every ray to try them all, and the tree is asked 64 times less often.
const TILE: u32 = 8;

/// How a drop's reflected and transmitted light are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Weights {
    /// F for the reflection, (1-F)² F^k after k internal reflections: what a sphere does.
    #[default]
    Physical,
    /// Like `Physical`, but the last order that is followed carries all that is left: no light is lost.
    Conserving,
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
    /// ([`crate::optics::Intersection::weight_beyond_internal_reflections`]): over a far drop's disc 5 % for K = 0,
    /// 0.8 % for K = 1, under 0.02 % for K = 8.
    pub internal_reflections: u32,
    /// Physical weights or the paper's.
    pub weights: Weights,
    /// Whether the outside reflects; without, the term F E(R) is left out and nothing stands in.
    pub reflection: bool,
    /// How many further drops the light leaving a drop may go through before the environment takes
    /// its place. 0: a drop sees only the environment (the paper's assumption), as in real rain it always does.
    pub drops_see_drops: u32,
    /// Whether the images of small bright sources in drops are looked for; without, or where drops
    /// see drops, the pixels' samples meet them by chance. The same on the mean; an environment
    /// without such sources ([`crate::environment::bright`]) is traced the same to the bit. In a scene with
    /// real rain, drops under half a pixel of radius show them spread over their disc, and others by chance.
    pub glints: bool,
    /// Distance in metres to which real rain is traced drop by drop; beyond it is a medium. `None`:
    /// [`usual_bound`].
    pub rain_to: Option<f64>,
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
            rain_to: None,
        }
    }
}

/// A picture, and where its drops are.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Linear radiance.
    pub picture: Picture,
    /// Share of each pixel that drops cover, 0 to 1, row by row from the top. Far rain that is a medium covers nothing.
    pub coverage: Vec<f32>,
    /// Share of the light behind that drops and medium take away, likewise.
    pub opacity: Vec<f32>,
    /// The drops on the pane, likewise; empty without a pane.
    pub on_pane: Vec<OnPane>,
}

/// Means over a pixel's samples.
struct Found {
    radiance: DVec3,
    coverage: f64,
    opacity: f64,
    on_pane: OnPane,
}

/// A scene made ready for tracing.
#[derive(Clone, Debug)]
pub struct Tracer<'a> {
    truth: Truth,
    eye: Eye,
    environment: &'a Environment,
    plate: Plate,
    /// Index inside drops over that outside, with the colours that it is for.
    indices: Vec<(f64, DVec3)>,
    glints: Option<Glints>,
    tree: Tree,
    rain: Option<Box<Weather>>,
    pane: Option<Box<Pane>>,
    /// See [`Tracer::new_until`].
    stop: fn() -> bool,
}

/// What the rays of a tile may meet.
struct Around<'a> {
    tree: &'a Tree,
    /// Whether glints are found apart, so that drops do not show them here.
    glints: bool,
    /// What small drops show.
    small: Option<SmallDrops<'a>>,
}

impl<'a> Tracer<'a> {
    /// The drops of a validated scene. The scene's models are ignored: the reference has none.
    pub fn new(scene: &Scene, environment: &'a Environment, truth: Truth) -> Self {
        Self::new_until(scene, environment, truth, || false)
    }

    /// Like [`Tracer::new`]. Once `stop` is true, this and [`Tracer::trace`] end early, and the picture is incomplete. It is asked
    /// at every sample: one pixel may take minutes.
    pub fn new_until(
        scene: &Scene,
        environment: &'a Environment,
        truth: Truth,
        stop: fn() -> bool,
    ) -> Self {
        let drops = of_scene(scene);
        let eye = Eye::of_scene(scene);
        let mut tracer = Self { stop, ..Self::of_drops(eye, drops, environment, truth) };
        tracer.pane = Pane::new(scene).map(Box::new);
        // Images of a bare sun are looked for without a pane alone.
        tracer.glints = tracer.glints.filter(|_| tracer.pane.is_none());
        let indices = by_color(scene.indices());
        let Some((rain, bound)) = scene.real_rain().zip(usual_bound(scene)) else {
            return Self { indices, ..tracer };
        };
        let bound = truth.rain_to.unwrap_or(bound).min(rain.extent);
        let mut far = FarRain::new(scene, &rain, bound, environment, &truth, &indices);
        far.light_flat_drops(&tracer.eye.view, &truth, &indices, stop);
        let rain = Weather { near: NearRain::new(scene, &rain, bound), far };
        Self { indices, glints: None, rain: Some(Box::new(rain)), ..tracer }
    }

    /// Any drops of water.
    pub fn of_drops(eye: Eye, drops: Drops, environment: &'a Environment, truth: Truth) -> Self {
        let glints = Glints::new(environment, &truth);
        let indices = vec![(WATER, DVec3::ONE)];
        let tree = Tree::new(drops);
        let plate = Plate::default();
        Self {
            truth,
            eye,
            environment,
            plate,
            indices,
            glints,
            tree,
            rain: None,
            pane: None,
            stop: || false,
        }
    }

    /// These drops before a background of the picture's size.
    pub fn before(self, plate: Plate) -> Self {
        Self { plate, ..self }
    }

    /// The drops, and which of them a ray meets.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Radiance that arrives from a unit direction, in world space, as the shutter opens; without lens and real rain, and
    /// with the plate only as drops on a pane show it.
    pub fn radiance_along(&self, direction: DVec3) -> DVec3 {
        let Passed { light: of_pane, left: through, drop, ray, from } =
            self.pass(&Ray::along(direction));
        if drop.is_some() {
            return of_pane;
        }
        let depth = self.truth.drops_see_drops;
        let next = |after: Hit| self.tree.first_hit(&ray, after.after(from), None);
        let around = Around { tree: &self.tree, glints: false, small: None };
        let (light, left) = self.gather(&around, &ray, 1.0, depth, f64::INFINITY, next);
        of_pane + through * (light + left * self.environment.radiance(direction))
    }

    /// The picture, on the threads of the current rayon pool; the same for any number of them.
    /// `progress` is called from these threads with the share that is done, 0 to 1.
    pub fn trace(&self, progress: &(dyn Fn(f64) + Sync)) -> Traced {
        let View { width, height, .. } = self.eye.view;
        let samples = Samples::new(self.truth.samples, self.truth.seed, self.is_exposed());
        let count = self.tiles();
        // The glints' time is of the tiles' order, more or less by their number.
        let of_tiles = if self.glints.is_some() { 0.5 } else { 1.0 };
        let done = AtomicU32::new(0);
        let tiles: Vec<Vec<Found>> = (0..count)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, tile| {
                if (self.stop)() {
                    return Vec::new();
                }
                let (left, upper) = self.corner_of(tile);
                let pixels = self.tile(left, upper, &samples, scratch);
                let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                progress(of_tiles * f64::from(done) / f64::from(count));
                pixels
            })
            .collect();

        let mut pixels = vec![DVec3::ZERO; width as usize * height as usize];
        let [mut coverage, mut opacity] = [(); 2].map(|()| vec![0.0_f32; pixels.len()]);
        let nothing = OnPane::of(std::iter::empty(), 1);
        let mut on_pane = vec![nothing; if self.pane.is_some() { pixels.len() } else { 0 }];
        for (tile, traced) in (0..).zip(tiles) {
            let (left, upper) = self.corner_of(tile);
            for ((x, y), found) in self.pixels_of(left, upper).zip(traced) {
                let at = y as usize * width as usize + x as usize;
                pixels[at] = found.radiance;
                (coverage[at], opacity[at]) = (found.coverage as f32, found.opacity as f32);
                if let Some(on_pane) = on_pane.get_mut(at) {
                    *on_pane = found.on_pane;
                }
            }
        }
        let of_glints = |share: f64| progress(of_tiles + (1.0 - of_tiles) * share);
        let glints = self.glints.as_ref().map(|glints| glints.trace(self, &of_glints));
        for (pixel, light) in glints.into_iter().flatten().flatten() {
            pixels[pixel as usize] += light;
        }
        let pixels = pixels.iter().map(|pixel| pixel.as_vec3()).collect();
        Traced { picture: Picture { width, height, pixels }, coverage, opacity, on_pane }
    }

    /// The picture alone, without progress.
    pub fn picture(&self) -> Picture {
        self.trace(&|_| ()).picture
    }

    /// This tracer with other places for its samples.
    pub fn with_seed(&self, seed: u64) -> Self {
        let mut tracer = Self { truth: Truth { seed, ..self.truth }, ..self.clone() };
        if let Some(rain) = tracer.rain.as_mut().filter(|_| seed != self.truth.seed) {
            let stop = self.stop;
            rain.far.light_flat_drops(&tracer.eye.view, &tracer.truth, &tracer.indices, stop);
        }
        tracer
    }

    /// Tiles of 8 x 8 pixels that the picture is traced by, row by row.
    pub fn tiles(&self) -> u32 {
        self.eye.view.width.div_ceil(TILE) * self.eye.view.height.div_ceil(TILE)
    }

    /// Whether a drop may be seen in a tile. Of real rain, and behind a pane, one always may.
    pub fn shows_drops(&self, tile: u32) -> bool {
        if self.rain.is_some() || self.pane.is_some() {
            return true;
        }
        let mut found = Vec::new();
        let (left, upper) = self.corner_of(tile);
        self.tree.within(&self.pyramid_of(left, upper), f64::INFINITY, &mut found);
        !found.is_empty()
    }

    /// A tile's pixels, each with its number row by row in the picture: as [`Tracer::trace`] has them, but
    /// for the last digits, for a part of a picture.
    pub fn trace_tile(&self, tile: u32) -> Vec<(u32, DVec3)> {
        let samples = Samples::new(self.truth.samples, self.truth.seed, self.is_exposed());
        let (left, upper) = self.corner_of(tile);
        let traced = self.tile(left, upper, &samples, &mut Scratch::default());
        let numbers = self.pixels_of(left, upper).map(|(x, y)| y * self.eye.view.width + x);
        let mut pixels: Vec<(u32, DVec3)> =
            numbers.zip(traced).map(|(number, found)| (number, found.radiance)).collect();
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
        let columns = self.eye.view.width.div_ceil(TILE);
        (tile % columns * TILE, tile / columns * TILE)
    }

    /// The rays through a tile.
    fn pyramid_of(&self, left: u32, upper: u32) -> Pyramid {
        self.pyramid_between((left, upper), (left + TILE, upper + TILE))
    }

    /// The rays through a rectangle of the picture, from a column and row to others.
    fn pyramid_between(&self, (left, upper): (u32, u32), (right, lower): (u32, u32)) -> Pyramid {
        let corners = [left, upper, right, lower].map(f64::from);
        // A pane shifts no ray farther than it is thick.
        let shift = self.pane.as_ref().map_or(0.0, |pane| pane.thickness);
        Pyramid::between(self.eye.view.corners(corners)).through(&self.eye).shifted(shift)
    }

    /// Whether it matters when a ray is, or where on the lens it begins.
    fn is_exposed(&self) -> bool {
        let populations = &self.tree.drops().populations;
        let rain_moves = self.rain.as_ref().is_some_and(|rain| rain.near.moves());
        let pane_moves = self.pane.as_ref().is_some_and(|pane| pane.motion != DVec3::ZERO);
        rain_moves
            || pane_moves
            || self.eye.lens > 0.0
            || populations.iter().any(|all| all.motion != DVec3::ZERO)
    }

    /// The pixels of a tile, row by row; a tile at the right or lower edge may be narrower.
    fn pixels_of(&self, left: u32, upper: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let right = (left + TILE).min(self.eye.view.width);
        let lower = (upper + TILE).min(self.eye.view.height);
        (upper..lower).flat_map(move |y| (left..right).map(move |x| (x, y)))
    }

    /// What is seen in a tile's pixels.
    fn tile(&self, left: u32, upper: u32, samples: &Samples, scratch: &mut Scratch) -> Vec<Found> {
        if let Some(rain) = &self.rain {
            return self.tile_of_rain(rain, (left, upper), samples, scratch);
        }
        let Scratch { candidates, samples: places, on_pane } = scratch;
        let around = Around { tree: &self.tree, glints: true, small: None };
        self.tree.within(&self.pyramid_of(left, upper), f64::INFINITY, candidates);
        self.pixels_of(left, upper)
            .map(|(x, y)| {
                let pixel = self.eye.view.number_in_whole(x, y);
                let (mut radiance, mut covered, mut opacity) = (DVec3::ZERO, 0.0, 0.0);
                samples.of_pixel(pixel, places);
                on_pane.clear();
                for sample in places.iter().take_while(|_| !(self.stop)()) {
                    let Passed { light, left: through, drop, ray, from } =
                        self.pass(&self.eye.ray(x, y, sample));
                    radiance += light;
                    on_pane.push(drop);
                    if drop.is_some() {
                        (covered, opacity) = (covered + 1.0, opacity + 1.0);
                        continue;
                    }
                    let reach = self.reach(pixel, &ray);
                    let next =
                        |after: Hit| self.tree.first_hit_of(candidates, &ray, after.after(from));
                    let depth = self.truth.drops_see_drops;
                    let (light, left) = self.gather(&around, &ray, through, depth, reach, next);
                    radiance += through * light;
                    if left > 0.0 {
                        radiance += through * left * self.behind(pixel, &ray);
                    }
                    covered += 1.0 - left;
                    opacity += 1.0 - through * left;
                }
                let count = places.len() as f64;
                let [coverage, opacity] = [covered, opacity].map(|sum| sum / count);
                let on_pane = OnPane::of(on_pane.iter().copied(), places.len());
                Found { radiance: radiance / count, coverage, opacity, on_pane }
            })
            .collect()
    }

    /// Where a ray comes to what is behind the drops.
    fn reach(&self, pixel: u32, ray: &Ray) -> f64 {
        self.plate.reach(pixel, -ray.direction.dot(self.eye.view.back))
    }

    /// Radiance of what is behind the drops.
    fn behind(&self, pixel: u32, ray: &Ray) -> DVec3 {
        let plate = self.plate.radiance(pixel);
        plate.unwrap_or_else(|| self.environment.radiance(ray.direction))
    }

    /// Radiance of the drops along a ray that are nearer than `reach`, and what they let through of what
    /// is behind them, given the ray's hits one after the other. A drop that fades in lets the rest of the
    /// light through unbent.
    fn gather(
        &self,
        around: &Around,
        ray: &Ray,
        share: f64,
        depth: u32,
        reach: f64,
        next: impl Fn(Hit) -> Hit,
    ) -> (DVec3, f64) {
        let (mut sum, mut left) = (DVec3::ZERO, 1.0);
        let mut hit = next(Hit::START);
        while hit.drop != Hit::NONE.drop && hit.distance < reach {
            let drops = around.tree.drops();
            let center = drops.center(&drops.all[hit.drop as usize], ray.moment);
            let opacity = self.eye.opacity(center);
            if opacity > 0.0 {
                let share = share * left * opacity;
                sum += left * opacity * self.leaving(around, ray, hit.drop, share, depth);
                left *= 1.0 - opacity;
            }
            if left <= 0.0 {
                break;
            }
            hit = next(hit);
        }
        (sum, left)
    }
}

/// What a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    candidates: Vec<Hit>,
    samples: Vec<Sample>,
    on_pane: Vec<Option<Told>>,
}

/// Each index once, with the colours that it is for.
fn by_color(indices: [f64; 3]) -> Vec<(f64, DVec3)> {
    let mut found: Vec<(f64, DVec3)> = Vec::with_capacity(3);
    for (index, color) in indices.into_iter().zip(DVec3::AXES) {
        match found.iter_mut().find(|(known, _)| *known == index) {
            Some((_, colors)) => *colors += color,
            None => found.push((index, color)),
        }
    }
    found
}
