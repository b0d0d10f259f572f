//! The picture of single drops on the GPU against the paper's model in float64.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::gpu::probe::Findings;
use raindrops::passes::drops::guard_band;
use raindrops::picture::Picture;
use raindrops::reference::paper::{PaperModel, Sprite};
use raindrops::scene::model::Optics;
use raindrops::scene::{ImageSize, Scene};
use rayon::prelude::*;

use crate::common::picture::picture_of;
use crate::common::{by_paper, painted};

const SIZE: u32 = 512;

/// A smooth environment without edges: a gradient along each axis for each colour.
fn gradient() -> Environment {
    painted(512, |d| (1.5 + d).as_vec3())
}

fn courtyard() -> Option<Environment> {
    let path = crate::common::photograph("courtyard.exr")?;
    Some(Environment::load(&path).expect("a sound image"))
}

/// A drop of radius 1 at a distance, on the axis or 30° off it in a slanted direction.
fn scene(distance: f64, off_axis: bool) -> Scene {
    // A little off the pixel grid, so that no edge of a square passes through pixel centres.
    let direction = if off_axis {
        let angle = 30f64.to_radians();
        DVec3::new(0.8 * angle.sin(), 0.6 * angle.sin(), -angle.cos())
    } else {
        DVec3::new(0.0013, -0.0007, -1.0).normalize()
    };
    let mut scene = crate::common::one_drop(distance * direction, 1.0);
    scene.image = ImageSize { width: SIZE, height: SIZE };
    scene
}

fn render(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Picture {
    picture_of(device, &by_paper(scene), environment)
}

/// Relative error over the pixels of a drop's square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Off {
    pixels: usize,
    mean: f64,
    /// 99 pixels of 100 are within it.
    most_of_99: f64,
    most: f64,
    /// Where the largest is, in sprite coordinates (s, t).
    at: DVec2,
}

impl Off {
    fn is_within(&self, bound: &Bound) -> bool {
        // In a square of few pixels the hundredth is the worst, and the mean is one pixel's error, or a few pixels'.
        let is_few = self.pixels < 100;
        self.mean < if is_few { bound.mean_of_few } else { bound.mean }
            && (is_few || self.most_of_99 < bound.most_of_99)
            && self.most < bound.most
    }
}

/// What is allowed of each, twice to thrice what is measured.
struct Bound {
    mean: f64,
    mean_of_few: f64,
    most_of_99: f64,
    most: f64,
    /// `most_of_99` and `mean_of_few` on a device that is found to blend two texels in 256 steps, where others have a float's.
    of_99_in_steps: f64,
}

impl Bound {
    fn on(&self, device: &Arc<Device>) -> Self {
        let blends = Findings::of(device).expect("findings").sampling.blends_a_texel;
        if blends >= 512 {
            return Self { ..*self };
        }
        let of_99 = self.of_99_in_steps;
        // A single pixel at a bright edge is off by three times as much: 0.57 where others have 0.17.
        Self { most_of_99: of_99, mean_of_few: of_99, most: 3.0 * self.most, ..*self }
    }
}

/// A smooth environment leaves the float16 target's rounding: a step is 4.9e-4 to 9.8e-4 of a value,
/// drivers may round down, and a rim pixel is rounded twice, as sky and as blend.
const SMOOTH: Bound =
    Bound { mean: 1e-3, mean_of_few: 1e-3, most_of_99: 2e-3, most: 5e-3, of_99_in_steps: 2e-3 };

/// In a photograph neighbouring texels differ by factors, and a direction that float32 moves by
/// 1/1000 of a texel is seen. The largest is a rim pixel of a bright reflection before a dark sky:
/// vertices are snapped to 1/256 of a pixel, which is 1 % of coverage. Between two texels of which one is a hundred times
/// as bright, a filter's step of 1/256 is 40 % of the darker.
const PHOTOGRAPH: Bound =
    Bound { mean: 5e-3, mean_of_few: 5e-3, most_of_99: 1e-2, most: 0.3, of_99_in_steps: 4e-2 };

/// The bound at float16, whose directions are off by 0.025°, a seventh of a texel.
const PHOTOGRAPH_F16: Bound =
    Bound { mean: 5e-3, mean_of_few: 5e-3, most_of_99: 2e-2, most: 0.5, of_99_in_steps: 4e-2 };

/// Edges of a square are rasterised to 1/256 of a pixel, or to the device's grid: pixel centres nearer
/// than that may be on either side and are left out.
fn edge_px(device: &Arc<Device>) -> f64 {
    let of_size = coarse_sizes(device).map_or(0.0, |step| 0.5 * step);
    coarse_grid(device).unwrap_or(1.0 / 100.0).max(of_size)
}

fn compare(gpu: &Picture, model: &PaperModel, sprites: &[Sprite], edge_px: f64) -> Off {
    let is_at_edge = |sprite: &Sprite, point: DVec2| {
        let edge = (point - sprite.center).abs() - 0.5 * sprite.drawn();
        edge.abs().min_element() < edge_px
    };
    let mut errors: Vec<(f64, DVec2)> = (0..SIZE * SIZE)
        .into_par_iter()
        .filter_map(|index| {
            let point = DVec2::new((index % SIZE).into(), (index / SIZE).into()) + 0.5;
            let at = sprites.iter().find_map(|sprite| sprite.texture_place(point))?;
            if sprites.iter().any(|sprite| is_at_edge(sprite, point)) {
                return None;
            }
            let exact = model.pixel(sprites, point);
            let off = (gpu.pixels[index as usize].as_dvec3() - exact).abs().max_element();
            let st = DVec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
            Some((off / exact.max_element(), st))
        })
        .collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(most, at)) = errors.last() else { return Off::default() };
    Off {
        pixels: errors.len(),
        mean: errors.iter().map(|(error, _)| error).sum::<f64>() / errors.len() as f64,
        most_of_99: errors[(errors.len() - 1) * 99 / 100].0,
        most,
        at,
    }
}

/// Distance of the places, in pixels, to which a device is found to snap points where it snaps them
/// visibly: 1/16 on SwiftShader, 1/256 or less elsewhere.
fn coarse_grid(device: &Arc<Device>) -> Option<f64> {
    let places = Findings::of(device).expect("findings").points.expect("points").places_a_sixteenth;
    (places < 16).then_some(1.0 / 16.0)
}

/// Steps, in pixels, of the sizes that a device is found to give points where those are coarse: 1/32 on NVIDIA's, which
/// takes the step below.
fn coarse_sizes(device: &Arc<Device>) -> Option<f64> {
    let sizes = Findings::of(device).expect("findings").points.expect("points").sizes_a_pixel;
    (sizes < 60).then(|| 1.0 / f64::from(sizes))
}

/// Levels of detail that a device takes for one. Where filters are found to be in steps, so are levels, which are cut to those below: of
/// 1.49999996 is left 1.496, whose directions are off by enough for a hundredth of a photograph's pixels to be off by 12 %. A level
/// that float32 may have on either side of a step has two.
fn levels(device: &Arc<Device>, level: f64) -> Vec<f64> {
    if Findings::of(device).expect("findings").sampling.blends_a_texel >= 512 {
        return vec![level];
    }
    let steps = f64::from(1u32 << device.report.limits.mipmap_precision_bits);
    let mut levels = [-1e-6, 1e-6].map(|off| ((level + off) * steps).floor() / steps).to_vec();
    levels.dedup();
    levels
}

/// The model's sprites as this device places them and of the sizes that it gives them. With those of the scene instead, a
/// rim pixel is off by a hundred times as much on SwiftShader.
fn sprites(device: &Arc<Device>, scene: &Scene) -> Vec<Sprite> {
    let mut sprites = PaperModel::sprites(scene, point_limit(device));
    if let Some(step) = coarse_grid(device) {
        for sprite in &mut sprites {
            sprite.center = (sprite.center / step).round() * step;
        }
    }
    if let Some(step) = coarse_sizes(device) {
        for sprite in &mut sprites {
            sprite.diameter = (sprite.diameter / step).floor() * step;
        }
    }
    sprites
}

fn point_limit(device: &Arc<Device>) -> f64 {
    guard_band(device, SIZE, SIZE).expect("a limit").1.into()
}

const DISTANCES: [f64; 5] = [1.6, 3.0, 10.0, 60.0, 400.0];

fn check(environment: &Environment, optics: Optics, bound: &Bound) {
    crate::common::on_device(|device| {
        let (edge_px, bound) = (edge_px(device), bound.on(device));
        for off_axis in [false, true] {
            for distance in DISTANCES {
                let mut scene = scene(distance, off_axis);
                scene.model.optics = Some(optics);
                let model = PaperModel::new(&scene, environment);
                let sprites = sprites(device, &scene);
                let [sprite] = sprites[..] else { panic!("{} sprites", sprites.len()) };
                let picture = render(device, &scene, environment);
                let by_level = levels(device, sprite.level)
                    .into_iter()
                    .map(|level| compare(&picture, &model, &[Sprite { level, ..sprite }], edge_px));
                let off = by_level.min_by(|a, b| a.mean.total_cmp(&b.mean)).expect("a level");
                println!(
                    "{}, {optics}, d = {distance}{}: {} pixels, mean {:.1e}, 99 % {:.1e}, largest \
                     {:.1e} at ({:+.3}, {:+.3}), {:.3} of the radius, level {:.2}",
                    environment.name(),
                    if off_axis { ", 30° off" } else { "" },
                    off.pixels,
                    off.mean,
                    off.most_of_99,
                    off.most,
                    off.at.x,
                    off.at.y,
                    off.at.length(),
                    sprite.level,
                );
                assert!(off.pixels > 0 && off.is_within(&bound), "{off:?}");
            }
        }
    });
}

#[test]
fn gradient_through_the_float16_mask() {
    check(&gradient(), Optics::Mask, &SMOOTH);
}

#[test]
fn gradient_through_the_float32_mask() {
    check(&gradient(), Optics::MaskF32, &SMOOTH);
}

#[test]
fn the_bundled_sky() {
    let sky = Environment::bundled().expect("the sky");
    check(&sky, Optics::MaskF32, &PHOTOGRAPH);
    check(&sky, Optics::Mask, &PHOTOGRAPH_F16);
}

#[test]
fn a_courtyard() {
    if let Some(environment) = courtyard() {
        check(&environment, Optics::MaskF32, &PHOTOGRAPH);
        check(&environment, Optics::Mask, &PHOTOGRAPH_F16);
    }
}

/// Near drops hide far ones that are drawn later, far ones drawn before shine through the rim; quads
/// come last.
#[test]
fn drops_over_drops() {
    crate::common::on_device(|device| {
        let edge_px = edge_px(device);
        let mut scene = scene(10.0, false);
        let drop =
            |x: f64, y: f64, z: f64| raindrops::scene::PlacedDrop::sphere(DVec3::new(x, y, z), 1.0);
        scene.drops = vec![
            drop(0.31, 0.2, -6.0),
            drop(0.9, -0.4, -9.0),
            drop(-0.1, 0.13, -4.1),
            drop(-1.7, 0.2, -7.0),
            drop(0.2, -0.9, -1.9),
        ];
        let environment = gradient();
        let model = PaperModel::new(&scene, &environment);
        let sprites = sprites(device, &scene);
        assert_eq!(sprites.len(), 5);
        let picture = render(device, &scene, &environment);
        let off = compare(&picture, &model, &sprites, edge_px);
        println!("five drops: {off:?}");
        assert!(off.is_within(&SMOOTH), "{off:?}");
        // The control: the other order.
        let reversed: Vec<_> = sprites.iter().rev().copied().collect();
        assert!(!compare(&picture, &model, &reversed, edge_px).is_within(&SMOOTH));
    });
}

/// Models that are wrong on purpose must fail the loosest of the bounds that they stand under.
#[test]
fn a_wrong_model_is_found_out() {
    crate::common::on_device(|device| {
        let edge_px = edge_px(device);
        let environment = gradient();
        for distance in [1.6, 3.0, 10.0, 60.0] {
            let scene = scene(distance, true);
            let model = PaperModel::new(&scene, &environment);
            let sprites = sprites(device, &scene);
            let picture = render(device, &scene, &environment);
            let with = |change: &dyn Fn(&mut Sprite)| {
                let mut changed = sprites.clone();
                changed.iter_mut().for_each(change);
                compare(&picture, &model, &changed, edge_px)
            };
            assert!(with(&|_| {}).is_within(&SMOOTH), "d = {distance}: right as it is");
            let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
            let roll = DMat3::from_rotation_z(0.02);
            let wrong: [(&str, Off); 5] = [
                ("half a level", with(&|sprite| sprite.level += 0.5)),
                ("t flipped", with(&|sprite| sprite.rotation *= flip)),
                ("rolled by 1.1°", with(&|sprite| sprite.rotation *= roll)),
                ("half a pixel", with(&|sprite| sprite.center.x += 0.5)),
                ("1 % transparent", with(&|sprite| sprite.opacity *= 0.99)),
            ];
            for (what, off) in wrong {
                println!("d = {distance}, {what}: mean {:.1e}, largest {:.1e}", off.mean, off.most);
                assert!(!off.is_within(&SMOOTH), "d = {distance}: {what} passes: {off:?}");
            }
        }
    });
}
