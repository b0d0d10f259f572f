//! Rays through real rain. A tile's drops are found once for all of its samples, and traced shell by shell from
//! the camera out, so that no rain takes more memory than another. Then comes the medium.

use glam::DVec3;

use super::drops::{Drop, Drops};
use super::far::{Chance, FarRain};
use super::rain::{NearRain, Shell};
use super::{Around, Hit, Pyramid, Ray, Samples, Scratch, Strata, Tracer, Tree};
use crate::rain::pcg4d;

/// Most drops of real rain that a tile has in memory: some 200 bytes each, for every thread.
const MOST_HELD: usize = 1 << 17;

/// Rays that are followed together, if a pixel has not more: some 150 bytes each, for every thread.
const PATHS: usize = 1 << 16;

/// The rain of a scene.
#[derive(Clone, Debug)]
pub(super) struct Weather {
    pub(super) near: NearRain,
    pub(super) far: FarRain,
}

/// A sample on its way.
struct Path {
    ray: Ray,
    /// Where the background is.
    reach: f64,
    chance: Chance,
    light: DVec3,
    /// What is let through so far.
    left: f64,
}

/// A pixel and its samples.
struct Pixel {
    /// Column and row.
    at: (u32, u32),
    /// The bright parts' light in a far drop.
    sun: DVec3,
    paths: Vec<Path>,
}

impl Tracer<'_> {
    /// As [`Tracer::tile`], of a scene with real rain.
    pub(super) fn tile_of_rain(
        &self,
        rain: &Weather,
        (left, upper): (u32, u32),
        samples: &Samples,
        scratch: &mut Scratch,
    ) -> Vec<(DVec3, f64)> {
        let all: Vec<(u32, u32)> = self.pixels_of(left, upper).collect();
        let pyramid = self.pyramid_of(left, upper);
        let together = (PATHS / self.truth.samples.max(1) as usize).max(1);
        let parts = all.chunks(together).flat_map(|part| {
            let pixel = |at: &(u32, u32)| self.begin(rain, *at, samples, scratch);
            let mut pixels: Vec<Pixel> = part.iter().map(pixel).collect();
            self.follow(rain, &pyramid, &mut pixels, &mut scratch.candidates);
            pixels.into_iter().map(|pixel| self.end(rain, &pixel)).collect::<Vec<_>>()
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
            let ray = self.eye.ray(at.0, at.1, sample);
            Path { ray, reach: self.reach(number, &ray), chance, light: DVec3::ZERO, left: 1.0 }
        };
        let paths: Vec<Path> = scratch.samples.iter().zip(chances).map(path).collect();
        let suns = paths.iter().map(|path| rain.far.of_suns(path.ray.direction, path.chance.place));
        let sun = suns.sum::<DVec3>() / paths.len() as f64;
        Pixel { at, sun, paths }
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
            for Pixel { at, sun, paths } in &mut *pixels {
                let own = self.pyramid_between(*at, (at.0 + 1, at.1 + 1));
                tree.within(&own, f64::INFINITY, candidates);
                let suns = rain.far.rest().map(|rest| (rest, *sun));
                let around = Around { tree: &tree, glints: false, suns };
                for path in paths.iter_mut().filter(|path| goes_on(path)) {
                    let ray = path.ray;
                    let next = |after: Hit| {
                        tree.first_hit_of(
                            candidates,
                            &ray,
                            if after < start { start } else { after },
                        )
                    };
                    let reach = path.reach.min(shell.to);
                    let (light, left) = self.gather(&around, &ray, path.left, 0, reach, next);
                    path.light += path.left * light;
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

    /// Radiance and coverage of a pixel: behind the drops the medium, behind that the background.
    fn end(&self, rain: &Weather, pixel: &Pixel) -> (DVec3, f64) {
        let number = self.eye.view.number_in_whole(pixel.at.0, pixel.at.1);
        let (mut radiance, mut covered) = (DVec3::ZERO, 0.0);
        for path in &pixel.paths {
            let direction = path.ray.direction;
            let through = rain.far.transmittance(direction, path.reach);
            radiance += path.light;
            if path.left > 0.0 && through < 1.0 {
                let (indices, all) = (&self.indices, self.environment);
                let of_drop = rain.far.of_drop(&self.truth, indices, all, direction, path.chance);
                radiance += path.left * (1.0 - through) * (of_drop + pixel.sun);
            }
            let left = path.left * through;
            if left > 0.0 {
                radiance += left * self.behind(number, &path.ray);
            }
            covered += 1.0 - left;
        }
        let count = pixel.paths.len() as f64;
        (radiance / count, covered / count)
    }
}

/// What the samples of a pixel meet in the medium: numbers that fill the square evenly together. Where a sample
/// is in its pixel says nothing of them: they are dealt out from a random one on.
fn chances(pixel: u32, count: u32, seed: u64) -> Vec<Chance> {
    const SALT: u64 = 0x6661_7220_7261_696e; // "far rain"
    let [first, drop, ..] = pcg4d([pixel, count, seed as u32, SALT as u32]);
    let unit = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0;
    let strata = Strata::new(count, seed ^ SALT);
    let places = strata.places(pixel).zip(0_u32..);
    // Steps of the golden section fill a line evenly in any order.
    let drop = |number: u32| unit(drop.wrapping_add(number.wrapping_mul(0x9e37_79b9)));
    let mut chances: Vec<_> =
        places.map(|(place, number)| Chance { place, drop: drop(number) }).collect();
    chances.rotate_left((unit(first) * f64::from(count)) as usize);
    chances
}
