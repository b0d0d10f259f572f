//! What a scene asks of a renderer: how many drops it shows, how large, and how much of the picture
//! they take. Expected values, from the scene's numbers alone; no drop is looked at.
//!
//! Along a ray the rain is a Poisson process: with ρ drops a volume, each of radius r, the drops met
//! per length are σ = ρπr², and the first is met between a and b with probability e^-σa - e^-σb.

use std::f64::consts::PI;

use glam::DVec3;

use super::Cutoff;
use crate::environment::Environment;
use crate::picture::tone_map::{Exposure, apply, exposure_of};
use crate::picture::{Picture, srgb_of_linear};
use crate::rain::Rain;
use crate::rain::thinned::drops_drawn;
use crate::rain::visibility::Frustum;
use crate::scene::camera::View;
use crate::scene::real_rain::RealRain;
use crate::scene::{Scene, ToneMap};

/// Smallest radius in pixels by which drops of real rain are told apart, and the number of drops that counts as none.
const LEAST_RADIUS_PX: f64 = 1e-3;
const FEWEST: f64 = 0.01;

/// Rays along an edge of the picture.
const GRID: u32 = 8;

/// Drops of about one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeClass {
    /// Radius in pixels.
    pub radius_px: f64,
    /// Whether they are so near that they look otherwise than from afar.
    pub is_near: bool,
    /// Share of the picture in which they are what one sees.
    pub share: f64,
    /// The share that holds for the square of what each drop adds. It is less than `share` for drops smaller than a pixel, which
    /// let a part of the light through.
    pub weight: f64,
    /// Pixels that they cover, hidden ones counted.
    pub pixels: f64,
}

/// What a scene asks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demand {
    /// All drops.
    pub drops: f64,
    /// Drops in view.
    pub visible: f64,
    /// Pixels of the picture.
    pub pixels: f64,
    /// The drops in view by size.
    pub classes: Vec<SizeClass>,
}

impl Demand {
    /// What `scene` asks, its real rain apart. Nearer than `near_radii` radii a drop counts as near.
    pub fn of(scene: &Scene, near_radii: f64) -> Self {
        let view = scene.view();
        let mut demand = Self {
            drops: scene.drop_count().into(),
            pixels: f64::from(view.width) * f64::from(view.height),
            ..Self::default()
        };
        demand.add_placed(scene, &view, near_radii);
        demand.add_rain(scene, &view, near_radii);
        demand
    }

    fn add_placed(&mut self, scene: &Scene, view: &View, near_radii: f64) {
        for drop in scene.placed() {
            let v = drop.center_at(scene.time) - view.position;
            let (x, y, z) = (v.dot(view.right), v.dot(view.up), -v.dot(view.back));
            let distance = v.length();
            let reach = |edge: u32| 0.5 * f64::from(edge) / view.focal_px * z + 2.0 * drop.radius;
            let is_seen = z > -drop.radius
                && distance > drop.radius
                && distance >= scene.camera.near
                && x.abs() < reach(view.width)
                && y.abs() < reach(view.height);
            if is_seen {
                let far = (distance * distance - drop.radius * drop.radius).sqrt();
                let radius_px = view.focal_px * drop.radius / far;
                let pixels = (PI * radius_px * radius_px).min(self.pixels);
                self.visible += 1.0;
                self.classes.push(SizeClass {
                    radius_px,
                    is_near: distance < near_radii * drop.radius,
                    share: pixels / self.pixels,
                    weight: pixels / self.pixels,
                    pixels,
                });
            }
        }
    }

    fn add_rain(&mut self, scene: &Scene, view: &View, near_radii: f64) {
        scene
            .populations()
            .iter()
            .for_each(|rain| self.add_population(rain, scene, view, near_radii));
    }

    fn add_population(&mut self, rain: &Rain, scene: &Scene, view: &View, near_radii: f64) {
        let half = rain.half_extent;
        let density = f64::from(rain.count) / (8.0 * half.x * half.y * half.z);
        let met = density * PI * rain.radius * rain.radius;
        let near = scene.camera.near.max(rain.radius);
        let rays = f64::from(GRID * GRID);
        // Classes an octave of radius apart, from what fills the picture to the box's far corner.
        let largest = view.focal_px * rain.radius / near;
        let smallest = view.focal_px * rain.radius / half.length();
        let octaves = (largest / smallest).log2().ceil().max(1.0) as u32;
        // How far drops before hide a square, along each ray.
        let mut hidden = vec![0.0_f64; (GRID * GRID) as usize];
        for octave in 0..octaves {
            let radius = |number: u32| largest * 0.5f64.powi(number as i32);
            let distance = |number: u32| view.focal_px * rain.radius / radius(number);
            let (from, to) = (distance(octave), distance(octave + 1));
            let radius_px = radius(octave) * 0.5f64.sqrt();
            let squared = 2.0 - filled(radius_px);
            let (mut share, mut weight, mut covered) = (0.0, 0.0, 0.0);
            for (ray, hidden) in rays_of(view).zip(&mut hidden) {
                let end = exit(ray, half);
                let (from, to) = (from.min(end), to.min(end));
                let depth = (to - from) * met;
                share += ((near - from) * met).exp() - ((near - to) * met).exp();
                weight += (-*hidden).exp() * (1.0 - (-squared * depth).exp()) / squared;
                *hidden += squared * depth;
                covered += depth;
            }
            if covered > 0.0 {
                self.classes.push(SizeClass {
                    radius_px,
                    is_near: 0.5 * (from + to) < near_radii * rain.radius,
                    share: share / rays,
                    weight: weight / rays,
                    pixels: covered / rays * self.pixels,
                });
            }
        }
        // A pixel's solid angle is cos³ of its angle from the axis over the focal length squared.
        let solid: f64 = rays_of(view)
            .map(|ray| (-ray.dot(view.back)).powi(3) * exit(ray, half).powi(3) / 3.0)
            .sum();
        let volume = solid / rays * self.pixels / (view.focal_px * view.focal_px);
        self.visible += density * volume;
    }
}

/// How many drops over a radius in pixels are in the whole picture, at most.
pub(super) fn drops_above(scene: &Scene, radius_px: f64) -> f64 {
    let view = scene.view();
    let frustum = |extent| Frustum::of(&view, extent);
    let placed = f64::from(scene.placed_count());
    if let Some(rain) = scene.real_rain() {
        return placed + frustum(rain.extent).drops_above(&rain.law(), radius_px);
    }
    let of_population = |rain: &Rain| {
        let Frustum { focal_px, width, height, .. } = frustum(f64::INFINITY);
        let depth = focal_px * rain.radius / radius_px;
        let volume = width * height / (3.0 * focal_px * focal_px) * depth.powi(3);
        let half = rain.half_extent;
        f64::from(rain.count) * (volume / (8.0 * half.x * half.y * half.z)).min(1.0)
    };
    placed + scene.populations().iter().map(of_population).sum::<f64>()
}

impl Demand {
    /// Adds the drops of real rain that are shown by themselves, those over a cut-off, an octave of radius after the
    /// other. They take so little of the picture that none hides another.
    pub(super) fn add_real_rain(&mut self, rain: &RealRain, cutoff: &Cutoff, view: &View) {
        let (law, frustum) = (rain.law(), Frustum::of(view, rain.extent));
        let part = self.pixels / (frustum.width * frustum.height);
        let (cutoff_px, thinned_px) = (cutoff.px, cutoff.thinned_px);
        let above = |radius_px: f64| part * drops_drawn(&frustum, &law, radius_px, thinned_px);
        self.visible += above(cutoff_px);
        // The cells in view hold as many drops again that are out of view.
        self.drops += 2.0 * above(cutoff_px);
        let mut from = cutoff_px.max(LEAST_RADIUS_PX);
        while above(from) > FEWEST {
            let drops = above(from) - above(2.0 * from);
            let radius_px = (std::f64::consts::SQRT_2 * from).max(thinned_px);
            let pixels = drops * PI * radius_px * radius_px;
            let share = pixels / self.pixels;
            self.classes.push(SizeClass {
                radius_px,
                is_near: false,
                share,
                weight: share,
                pixels,
            });
            from *= 2.0;
        }
    }
}

/// How much of a pixel a drop takes where it takes any, on the mean over what it takes.
fn filled(radius_px: f64) -> f64 {
    let area = PI * radius_px * radius_px;
    area / (1.0 + area)
}

fn rays_of(view: &View) -> impl Iterator<Item = DVec3> {
    let place =
        |number: u32, edge: u32| (f64::from(number) + 0.5) / f64::from(GRID) * f64::from(edge);
    let view = *view;
    (0..GRID * GRID)
        .map(move |n| view.ray(place(n % GRID, view.width), place(n / GRID, view.height)))
}

/// How far a ray from the middle of the rain box runs in it.
fn exit(ray: DVec3, half_extent: DVec3) -> f64 {
    (half_extent / ray.abs().max(DVec3::splat(1e-12))).min_element()
}

/// Texels across of which [`contrast`] takes all; of a wider environment it takes every n-th.
const MOST_ACROSS: u32 = 512;

/// How much tone-mapped radiance varies over the sphere: standard deviation of the sRGB luminance.
/// Errors of a drop, which shows the whole sphere, grow with it.
pub fn contrast(environment: &Environment) -> f64 {
    environment.contrast_by(|| {
        let seen = some_of(environment);
        contrast_of(&seen, exposure_of(&ToneMap::default(), &seen))
    })
}

/// [`contrast`] at a picture's exposure.
pub fn contrast_at(environment: &Environment, exposure: Exposure) -> f64 {
    contrast_of(&some_of(environment), exposure)
}

fn some_of(environment: &Environment) -> Picture {
    let step = environment.width().div_ceil(MOST_ACROSS);
    let (width, height) = (environment.width() / step, environment.height() / step);
    let texel =
        |x: u32, y: u32| environment.texels()[(y * step * environment.width() + x * step) as usize];
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y))).collect();
    Picture { width, height, pixels }
}

fn contrast_of(seen: &Picture, exposure: Exposure) -> f64 {
    let (mut sum, mut squares, mut total) = (0.0, 0.0, 0.0);
    for (row, pixels) in seen.pixels.chunks_exact(seen.width as usize).enumerate() {
        let weight = (PI * (row as f64 + 0.5) / f64::from(seen.height)).sin();
        for pixel in pixels {
            for channel in apply(exposure, *pixel).to_array() {
                let value = f64::from(srgb_of_linear(channel));
                sum += weight * value;
                squares += weight * value * value;
                total += weight;
            }
        }
    }
    (squares / total - (sum / total).powi(2)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::rain::cull::drops_with_visibility;
    use crate::scene::{ImageSize, PlacedDrop, RainSettings};

    #[test]
    fn as_many_drops_are_larger_as_expected() {
        let half_extent = DVec3::splat(200.0);
        let rain = RainSettings { count: 500_000, half_extent, ..RainSettings::default() };
        let mut scene = Scene { rain: Some(rain), ..Scene::default() };
        scene.image = ImageSize { width: 192, height: 128 };
        scene.camera.vertical_fov = 40.0;
        // A part of the picture is drawn as the whole is.
        scene.camera.window = [0.0, 0.0, 0.5, 1.0];
        let expected = [0.9, 1.5, 3.0].map(|px| (px, drops_above(&scene, px)));
        scene.camera.window = [0.0, 0.0, 1.0, 1.0];
        for (px, expected) in expected {
            let view = scene.view();
            let half = DVec2::new(view.width.into(), view.height.into()) / (2.0 * view.focal_px);
            let is_larger = |center: DVec3| {
                let depth = -center.z;
                depth > 0.0
                    && depth < view.focal_px / px
                    && center.truncate().abs().cmple(half * depth).all()
            };
            let larger =
                drops_with_visibility(&scene).filter(|(center, ..)| is_larger(center.as_dvec3()));
            let counted = larger.count() as f64;
            println!("{px} px: {counted}, {expected:.0} expected");
            assert!((counted - expected).abs() < 4.0 * expected.sqrt());
        }
    }

    /// Before rain through which nothing is seen, weights are mean squares of what of a pixel a drop shows: where drops are larger
    /// than pixels, each of which shows one, they come to 1; of drops far smaller, laid over one another, a half.
    #[test]
    fn weights_before_dense_rain_are_mean_squares() {
        let sum_of = |count: u32, half: f64, radius: f64| -> f64 {
            let half_extent = DVec3::splat(half);
            let rain = RainSettings { count, half_extent, radius, ..RainSettings::default() };
            let image = ImageSize { width: 64, height: 64 };
            let scene = Scene { rain: Some(rain), image, ..Scene::default() };
            Demand::of(&scene, 32.0).classes.iter().map(|class| class.weight).sum()
        };
        let [large, small] = [sum_of(8000, 10.0, 0.5), sum_of(850_000_000, 1000.0, 0.1)];
        assert!((large - 1.0).abs() < 0.02, "{large}");
        // The nearest are not so small.
        assert!((0.5..0.53).contains(&small), "{small}");
    }

    /// Up to two radii out of the picture, and until they are behind the camera.
    #[test]
    fn placed_drops_beside_the_picture_are_counted_with_it() {
        let seen = |center: DVec3| {
            let (image, drop) =
                (ImageSize { width: 64, height: 32 }, PlacedDrop::sphere(center, 0.5));
            let scene = Scene { rain: None, drops: vec![drop], image, ..Scene::default() };
            Demand::of(&scene, 32.0).visible
        };
        let slope = (0.5 * Scene::default().camera.vertical_fov.to_radians()).tan();
        let (up, right) = (4.0 * slope, 8.0 * slope);
        for (x, y, z, expected) in [
            (right + 0.95, 0.0, -4.0, 1.0),
            (-right - 0.95, 0.0, -4.0, 1.0),
            (right + 1.05, 0.0, -4.0, 0.0),
            (0.0, up + 0.95, -4.0, 1.0),
            (0.0, -up - 1.05, -4.0, 0.0),
            (0.0, 0.4, 0.45, 1.0),
            (0.0, 0.4, 0.55, 0.0),
        ] {
            assert_eq!(seen(DVec3::new(x, y, z)), expected, "{x} {y} {z}");
        }
    }

    /// Each drop of real rain is in one class of an octave.
    #[test]
    fn classes_of_real_rain_have_each_drop_once() {
        let rain = RealRain { rate: 25.0, extent: 100.0, ..RealRain::default() };
        let scene = Scene { rain: Some(RainSettings::of(rain)), ..Scene::default() };
        let (rain, view) = (scene.real_rain().expect("real rain"), scene.view());
        let cutoff =
            Cutoff { px: 0.1, thinned_px: 0.0, why: String::new(), noise: 0.0, is_grainy: false };
        let mut demand =
            Demand { pixels: f64::from(view.width) * f64::from(view.height), ..Demand::default() };
        demand.add_real_rain(&rain, &cutoff, &view);
        let drops_of = |class: &SizeClass| class.pixels / (PI * class.radius_px * class.radius_px);
        let sum: f64 = demand.classes.iter().map(drops_of).sum();
        assert!(demand.visible > 1000.0, "{}", demand.visible);
        assert!((sum / demand.visible - 1.0).abs() < 1e-4, "{sum}, not {}", demand.visible);
    }
}
