//! Thinned rain: few drops that stand for many have the mean, the variance and the correlations of all that are drawn one by one.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::plan::{FramePlan, Output, plan};
use raindrops::rain::field::Field;
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, RainSettings, Scene};

use crate::common::on_device;
use crate::grain::opacities;

const EDGE: usize = 256;
/// Pictures of each rain. Most of a variance's deviation from one to the other is gone.
const MOMENTS: usize = 8;

/// Rain that falls aslant, far away: its drops are in the picture over a cut-off of 0.15 / √8 px.
fn scene(shutter: f64, thinned_px: Option<f64>) -> Scene {
    let wind = DVec3::new(2.0, 0.0, 0.0);
    let diameters = [1.0, 2.0];
    let rain = RealRain { rate: 25.0, extent: 80.0, wind, diameters, ..RealRain::default() };
    let edge = EDGE as u32;
    let mut scene = Scene {
        rain: Some(RainSettings::of(rain)),
        image: ImageSize { width: edge, height: edge },
        ..Scene::default()
    };
    scene.camera.vertical_fov = 10.0;
    // No drop is seen that is large in itself: one would be half of a variance. The smallest that is left out has 0.15 px.
    (scene.camera.near, scene.camera.shutter) = (4.8, shutter);
    scene.model.preset = Preset::Fast;
    scene.model.thinned_px = thinned_px;
    scene.model.cutoff_px = Some(0.15 / 8f64.sqrt());
    scene
}

fn planned(scene: &Scene, white: &Environment) -> FramePlan {
    plan(scene, white, Output::Layers).expect("a plan")
}

/// A rain at moments so far apart, in seconds.
fn moments(scene: &Scene, apart: f64) -> Vec<Scene> {
    let at = |moment: usize| Scene { time: apart * moment as f64, ..scene.clone() };
    (0..MOMENTS).map(at).collect()
}

/// Mean of products of a picture's deviation from its mean with another's, `across` and `down` pixels further.
fn covariance(a: &[f64], b: &[f64], across: usize, down: usize) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (columns, rows) = (EDGE - across, EDGE - down);
    let places = (0..columns * rows).map(|place| (place % columns, place / columns));
    let product = |(x, y): (usize, usize)| {
        (a[y * EDGE + x] - mean_a) * (b[(y + down) * EDGE + x + across] - mean_b)
    };
    places.map(product).sum::<f64>() / (columns * rows) as f64
}

/// Mean opacity, its variance, and by how much of it pixels are alike: next to each other, a fifth and two fifths of a usual
/// streak apart along it, and at the next moment.
fn statistics(pictures: &[Vec<f64>]) -> [f64; 6] {
    let mean =
        |of: &dyn Fn(usize) -> f64, count: usize| (0..count).map(of).sum::<f64>() / count as f64;
    let covariance_of =
        |across, down| mean(&|i| covariance(&pictures[i], &pictures[i], across, down), MOMENTS);
    let variance = covariance_of(0, 0);
    let next = mean(&|i| covariance(&pictures[i], &pictures[i + 1], 0, 0), MOMENTS - 1);
    let opacity = mean(&|i| pictures[i].iter().sum::<f64>() / pictures[i].len() as f64, MOMENTS);
    [
        opacity,
        variance,
        covariance_of(1, 0) / variance,
        covariance_of(1, 3) / variance,
        covariance_of(2, 6) / variance,
        next / variance,
    ]
}

#[test]
fn thinned_rain_has_the_statistics_of_all() {
    on_device(|device| {
        for (shutter, apart) in
            [(1.0 / 60.0, 1.0 / 500.0), (1.0 / 250.0, 1.0 / 1000.0), (0.0, 1.0 / 2000.0)]
        {
            let [all, thinned] = [None, Some(0.15)].map(|thinned| {
                statistics(&opacities(device, &moments(&scene(shutter, thinned), apart)))
            });
            let variances = thinned[1] / all[1];
            println!(
                "{shutter:.4} s: {all:.4?}, thinned {thinned:.4?}, variance {variances:.3} of all's"
            );
            // Usual: 0.001, 0.02 and 0.015.
            assert!((thinned[0] / all[0] - 1.0).abs() < 0.003, "mean: {all:?}, {thinned:?}");
            assert!((thinned[1] / all[1] - 1.0).abs() < 0.06, "variance: {all:?}, {thinned:?}");
            for alike in 2..6 {
                assert!(
                    (thinned[alike] - all[alike]).abs() < 0.04,
                    "{alike}: {all:?}, {thinned:?}"
                );
            }
        }
    });
}

/// The CPU finds the same drops, and about as many as the plan expects: a fraction of all.
#[test]
fn thinned_drops_are_those_that_the_cpu_finds() {
    on_device(|device| {
        let scene = Scene { seed: 5, ..scene(1.0 / 60.0, Some(0.15)) };
        let white = Environment::constant(Vec3::ONE);
        let plan = planned(&scene, &white);
        let mut renderer = Renderer::new(device, &scene, &white, &plan).expect("a renderer");
        renderer.submit(&scene).expect("a frame");
        let visible = renderer.finish().expect("a report").counts.visible;
        let cutoff = plan.cutoff.expect("real rain");
        let field = Field::of(&scene).expect("rain");
        let all = field.count_visible(&scene, cutoff.px) as f64;
        let field = field.thinned(&scene, cutoff.thinned_px);
        assert_eq!(visible, field.count_visible(&scene, cutoff.px));
        println!("{visible} of {all} drops");
        // For each drop over the radius from which all are drawn there are 8^1.5 - 1 = 21.6 others, of which 3 - 3/√8 = 1.94 are.
        let expected = all * 2.94 / 22.63;
        assert!((visible as f64 / expected - 1.0).abs() < 0.1, "{visible}, not {expected}");
    });
}
