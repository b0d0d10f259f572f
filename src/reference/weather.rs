//! Rays through real rain. A tile's drops are found once for all of its samples, and traced shell by shell from
//! the camera out, so that no rain takes more memory than another. Then comes the medium.

use glam::{DMat2, DVec2, DVec3};

use super::drops::{Drop, Drops};
use super::far::{Chance, FarRain};
use super::pane::{Passed, Told};
use super::rain::{NearRain, Shell};
use super::{
    Around, Found, Hit, OnPane, Pyramid, Ray, Samples, Scratch, Strata, TILE, Tracer, Tree,
};
use crate::rain::{pcg4d, unit};

/// Most drops of real rain that a tile has in memory: some 200 bytes each, for every thread.
const MOST_HELD: usize = 1 << 17;

/// Rays that are followed together, if a pixel has not more: some 150 bytes each, for every thread.
const PATHS: usize = 1 << 16;

/// Samples of a pixel along which it is found what surfaces keep off of the medium; it hardly changes within a pixel.
const CLEAR_PATHS: usize = 4;

/// Angle of a tile in radians under which a far drop's light is a plane over it: it changes by a few thousandths
/// a degree, most of that evenly.
const NARROW: f64 = 0.04;

/// The rain of a scene.
#[derive(Clone, Debug)]
pub(super) struct Weather {
    pub(super) near: NearRain,
    pub(super) far: FarRain,
}

/// A sample on its way.
struct Path {
    ray: Ray,
    /// From where on it is outside, and where the background is.
    from: f64,
    reach: f64,
    chance: Chance,
    light: DVec3,
    /// What is let through so far.
    left: f64,
    /// Share that a pane lets through, and the drop on it that was met.
    through: f64,
    on_pane: Option<Told>,
}

/// A pixel and its samples.
struct Pixel {
    /// Column and row.
    at: (u32, u32),
    /// The bright parts' light in a small sphere.
    sun: DVec3,
    /// The bright parts' light in a drop of the medium.
    sun_of_medium: DVec3,
    /// The part of the medium that no surface keeps off.
    clear: f64,
    paths: Vec<Path>,
}

/// Light that samples met, and where they are in the picture.
#[derive(Clone, Copy, Default)]
struct Mean {
    place: DVec2,
    sum: DVec3,
    count: f64,
}

impl Mean {
    fn light(&self) -> DVec3 {
        self.sum / self.count.max(1.0)
    }
}

/// Middle of a pixel.
fn place_of(pixel: &Pixel) -> DVec2 {
    DVec2::new(f64::from(pixel.at.0), f64::from(pixel.at.1)) + 0.5
}

impl Tracer<'_> {
    /// Like [`Tracer::tile`], of a scene with real rain.
    pub(super) fn tile_of_rain(
        &self,
        rain: &Weather,
        (left, upper): (u32, u32),
        samples: &Samples,
        scratch: &mut Scratch,
    ) -> Vec<Found> {
        let all: Vec<(u32, u32)> = self.pixels_of(left, upper).collect();
        let pyramid = self.pyramid_of(left, upper);
        let together = (PATHS / self.truth.samples.max(1) as usize).max(1);
        let parts = all.chunks(together).take_while(|_| !(self.stop)()).flat_map(|part| {
            let pixel = |at: &(u32, u32)| self.begin(rain, *at, samples, scratch);
            let mut pixels: Vec<Pixel> = part.iter().map(pixel).collect();
            self.follow(rain, &pyramid, &mut pixels, &mut scratch.candidates);
            let lights = self.lights_of_medium(rain, &pixels);
            let ended =
                pixels.iter().zip(lights).map(|(pixel, light)| self.end(rain, pixel, light));
            ended.collect::<Vec<_>>()
        });
        parts.collect()
    }

    /// A pixel whose samples have met nothing yet.
    fn begin(
        &self,
        rain: &Weather,
        at: (u32, u32),
        samples: &Samples,
        scratch: &mut Scratch,
    ) -> Pixel {
        let number = self.eye.view.number_in_whole(at.0, at.1);
        samples.of_pixel(number, &mut scratch.samples);
        let chances = chances(number, scratch.samples.len() as u32, self.truth.seed);
        let path = |(sample, chance)| {
            let Passed { light, left: through, drop: on_pane, ray, from } =
                self.pass(&self.eye.ray(at.0, at.1, sample));
            let left = if on_pane.is_some() { 0.0 } else { 1.0 };
            let reach = self.reach(number, &ray);
            Path { ray, from, reach, chance, light, left, through, on_pane }
        };
        let paths: Vec<Path> = scratch.samples.iter().zip(chances).map(path).collect();
        let suns = paths.iter().map(|path| rain.far.of_suns(path.ray.direction, path.chance.place));
        let sun = suns.sum::<DVec3>() / paths.len() as f64;
        let of_medium = |path: &Path| rain.far.of_suns_in_medium(path.ray.direction, sun);
        let sun_of_medium = paths.iter().map(of_medium).sum::<DVec3>() / paths.len() as f64;
        let step = paths.len().div_ceil(CLEAR_PATHS).max(1);
        let some = paths.iter().step_by(step);
        let clear =
            some.clone().map(|path| rain.far.clear(path.ray.direction, path.from, path.reach));
        let clear = clear.sum::<f64>() / some.len() as f64;
        Pixel { at, sun, sun_of_medium, clear, paths }
    }

    /// Follows paths through the drops of real rain and those placed by hand.
    fn follow(
        &self,
        rain: &Weather,
        pyramid: &Pyramid,
        pixels: &mut [Pixel],
        candidates: &mut Vec<Hit>,
    ) {
        let mut shells = vec![Shell { from: 0.0, to: f64::INFINITY }];
        while let Some(shell) = shells.pop() {
            if (self.stop)() {
                return;
            }
            let goes_on = |path: &Path| path.left > 0.0 && path.reach > shell.from;
            if !pixels.iter().any(|pixel| pixel.paths.iter().any(goes_on)) {
                break;
            }
            let halves = shell.halves(rain.near.end);
            let most = if halves.is_some() { MOST_HELD } else { usize::MAX };
            let Some(drops) = rain.near.within(pyramid, shell, most) else {
                shells.extend(halves.into_iter().flatten().rev());
                continue;
            };
            let tree = Tree::new(self.with_placed(drops));
            // A hit at the border belongs to one shell: both compare the same distance.
            let start = Hit { distance: shell.from, drop: 0 };
            for Pixel { at, sun, paths, .. } in &mut *pixels {
                let own = self.pyramid_between(*at, (at.0 + 1, at.1 + 1));
                tree.within(&own, f64::INFINITY, candidates);
                let around =
                    Around { tree: &tree, glints: false, small: rain.far.small_drops(*sun) };
                for path in paths.iter_mut().filter(|path| goes_on(path)) {
                    if (self.stop)() {
                        return;
                    }
                    let ray = path.ray;
                    let start = start.after(path.from);
                    let next = |after: Hit| {
                        tree.first_hit_of(
                            candidates,
                            &ray,
                            if after < start { start } else { after },
                        )
                    };
                    let reach = path.reach.min(shell.to);
                    let (light, left) = self.gather(&around, &ray, path.left, 0, reach, next);
                    path.light += path.through * path.left * light;
                    path.left *= left;
                }
            }
        }
    }

    /// The drops of real rain, and those placed by hand.
    fn with_placed(&self, mut drops: Drops) -> Drops {
        let placed = self.tree.drops();
        let before = drops.populations.len() as u32;
        drops.populations.extend(&placed.populations);
        let moved = |drop: &Drop| Drop { population: drop.population + before, ..*drop };
        drops.all.extend(placed.all.iter().map(moved));
        drops
    }

    /// Light of the medium at each pixel: the mean of its samples' drops, or where a tile is narrow the plane
    /// through those of all its pixels, which has a twentieth of the variance.
    fn lights_of_medium(&self, rain: &Weather, pixels: &[Pixel]) -> Vec<DVec3> {
        let means: Vec<Mean> =
            pixels.iter().map(|pixel| self.mean_of_medium(rain, pixel)).collect();
        if f64::from(TILE) > NARROW * self.eye.view.focal_px {
            return means.iter().map(Mean::light).collect();
        }
        let all = means.iter().fold(Mean::default(), |all, mean| Mean {
            place: all.place + mean.place,
            sum: all.sum + mean.sum,
            count: all.count + mean.count,
        });
        let (middle, light) = (all.place / all.count.max(1.0), all.light());
        let (mut squares, mut across, mut down) = (DMat2::ZERO, DVec3::ZERO, DVec3::ZERO);
        for mean in &means {
            let offset = mean.place / mean.count.max(1.0) - middle;
            squares += mean.count * DMat2::from_cols(offset.x * offset, offset.y * offset);
            across += offset.x * mean.sum;
            down += offset.y * mean.sum;
        }
        // Pixels in one line, or one alone, have no plane.
        let slopes = match squares.determinant() > 1e-6 * squares.col(0).x * squares.col(1).y {
            true => squares.inverse(),
            false => DMat2::ZERO,
        };
        let plane = |pixel: &Pixel| {
            let offset = slopes * (place_of(pixel) - middle);
            (light + offset.x * across + offset.y * down).max(DVec3::ZERO)
        };
        pixels.iter().map(plane).collect()
    }

    /// The drops that a pixel's samples meet in the medium.
    fn mean_of_medium(&self, rain: &Weather, pixel: &Pixel) -> Mean {
        let mut mean = Mean::default();
        let left = pixel.paths.iter().filter(|path| path.left > 0.0);
        for path in left.take_while(|_| !(self.stop)()) {
            let direction = path.ray.direction;
            if through_medium(rain, path, pixel.clear) < 1.0 {
                let (indices, all) = (&self.indices, self.environment);
                mean.sum += rain.far.of_drop(&self.truth, indices, all, direction, path.chance);
                mean.place += place_of(pixel);
                mean.count += 1.0;
            }
        }
        mean
    }

    /// A pixel: behind its drops the medium of a far drop's `light`, behind that the background.
    fn end(&self, rain: &Weather, pixel: &Pixel, light: DVec3) -> Found {
        let number = self.eye.view.number_in_whole(pixel.at.0, pixel.at.1);
        let (mut radiance, mut coverage, mut opacity) = (DVec3::ZERO, 0.0, 0.0);
        for path in &pixel.paths {
            let through = through_medium(rain, path, pixel.clear);
            radiance += path.light;
            radiance += path.through * path.left * (1.0 - through) * (light + pixel.sun_of_medium);
            let left = path.through * path.left * through;
            if left > 0.0 {
                radiance += left * self.behind(number, &path.ray);
            }
            coverage += 1.0 - path.left;
            opacity += 1.0 - left;
        }
        let count = pixel.paths.len() as f64;
        let met = pixel.paths.iter().map(|path| path.on_pane);
        Found {
            radiance: radiance / count,
            coverage: coverage / count,
            opacity: opacity / count,
            on_pane: OnPane::of(met, pixel.paths.len()),
        }
    }
}

/// What the medium lets through that is outside, of which a part is `clear`.
fn through_medium(rain: &Weather, path: &Path, clear: f64) -> f64 {
    let from = if path.from < path.reach { path.from } else { 0.0 };
    rain.far.transmittance(path.ray.direction, from, path.reach, clear)
}

/// What the samples of a pixel meet in the medium: numbers that fill the square evenly together. Where a sample
/// is in its pixel says nothing of them: they are dealt out from a random one on.
fn chances(pixel: u32, count: u32, seed: u64) -> Vec<Chance> {
    const SALT: u64 = 0x6661_7220_7261_696e; // "far rain"
    let [first, drop, ..] = pcg4d([pixel, count, seed as u32, SALT as u32]);
    let strata = Strata::new(count, seed ^ SALT);
    let places = strata.places(pixel).zip(0_u32..);
    // Steps of the golden section fill a line evenly in any order.
    let drop = |number: u32| unit(drop.wrapping_add(number.wrapping_mul(0x9e37_79b9)));
    let mut chances: Vec<_> =
        places.map(|(place, number)| Chance { place, drop: drop(number) }).collect();
    chances.rotate_left((unit(first) * f64::from(count)) as usize);
    chances
}
