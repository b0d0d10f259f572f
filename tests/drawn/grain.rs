//! The noise of single drops in far rain's medium: as strong as RAIN.md's Monte Carlo of drops that were drawn one by one,
//! without a change of the mean, and no quicker than drops.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::plan::{Cutoff, Output, plan};
use raindrops::scene::model::{DropShape, FarRain, Preset};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, RainSettings, Scene};

use crate::common::picture::renderer_of;
use crate::common::{on_device, painted};

/// The middle of a picture of 1024 x 1024 pixels, 60° wide, in which no drop is drawn by itself.
fn far_rain(cutoff_px: f64, shutter: f64) -> Scene {
    let shape = DropShape::Sphere;
    let rain = RealRain { rate: 25.0, extent: 60.0, shape, ..RealRain::default() };
    let mut scene = Scene {
        rain: Some(RainSettings::of(rain)),
        image: ImageSize { width: 1024, height: 1024 },
        ..Scene::default()
    };
    scene.camera.vertical_fov = 60.0;
    scene.camera.window = [0.4375, 0.4375, 0.5625, 0.5625];
    (scene.camera.near, scene.camera.shutter) = (100.0, shutter);
    scene.model.preset = Preset::Fast;
    (scene.model.cutoff_px, scene.model.far_rain) = (Some(cutoff_px), Some(FarRain::Grain));
    scene
}

/// Opacities of a picture's pixels, one picture a scene, by one renderer.
pub fn opacities(device: &Arc<Device>, scenes: &[Scene]) -> Vec<Vec<f64>> {
    let white = Environment::constant(Vec3::ONE);
    let mut renderer = renderer_of(device, &scenes[0], &white, Output::Layers);
    let mut pictures = Vec::new();
    for scene in scenes {
        renderer.draw(scene).expect("a frame");
        let layers = renderer.read_layers().expect("layers");
        pictures.push(layers.color.iter().map(|[.., alpha]| alpha.to_f64()).collect());
    }
    pictures
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root of the mean square of the differences of two pictures, or of one from its mean.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).collect();
    mean(&squares).sqrt()
}

fn deviation(values: &[f64]) -> f64 {
    apart(values, &vec![mean(values); values.len()])
}

/// RAIN.md, section 6: N0 = 8000, of which `rate` has 0.8863; and its opacity carries e^-τ of the drawn drops too.
#[test]
fn noise_is_that_of_drops_drawn_one_by_one() {
    on_device(|device| {
        for (cutoff_px, shutter, drawn) in
            [(0.1, 0.0, 0.01405), (0.05, 0.0, 0.00922), (0.1, 1.0 / 60.0, 0.00634)]
        {
            let (mut found, mut means) = (Vec::new(), Vec::new());
            for seed in 0..4 {
                let grain = Scene { seed, ..far_rain(cutoff_px, shutter) };
                let mut smooth = grain.clone();
                smooth.model.far_rain = Some(FarRain::Medium);
                let [grain, smooth] =
                    [grain, smooth].map(|scene| opacities(device, &[scene]).remove(0));
                assert!(deviation(&smooth) < 0.02 * deviation(&grain), "the control");
                found.push(deviation(&grain));
                means.push(mean(&grain) / mean(&smooth));
                let rain = far_rain(cutoff_px, shutter).real_rain().expect("rain");
                let of_drawn = rain.law().extinction() * rain.extent + (1.0 - mean(&smooth)).ln();
                let expected = drawn * 0.8863f64.sqrt() * of_drawn.exp();
                *found.last_mut().expect("pushed") /= expected;
            }
            println!("{cutoff_px} px, {shutter} s: {found:.3?} of the drops', mean {means:.4?}");
            assert!((mean(&found) - 1.0).abs() < 0.05, "{cutoff_px} px, {shutter} s: {found:?}");
            // Over 16,384 pixels of which neighbours are alike, s of 0.3 of the mean at most.
            assert!((mean(&means) - 1.0).abs() < 0.01, "{means:?}");
            assert!(means.iter().all(|mean| *mean != 1.0), "{means:?}");
        }
    });
}

/// In the time in which drops go half a pixel, and while the camera turns by as much, the noise changes less than drops
/// that are drawn do; after a second it is another.
#[test]
fn noise_flickers_no_more_than_drops() {
    let at = |far_rain: FarRain, seconds: f64, turn: f64| {
        let mut scene = self::far_rain(0.1, 0.0);
        scene.model.far_rain = Some(far_rain);
        if far_rain == FarRain::Drops {
            scene.model.cutoff_px = None;
            // Drops of two millimetres are in the medium from here on.
            scene.camera.near = 9.0;
        }
        let rain = scene.rain.get_or_insert_default().real.as_mut().expect("rain");
        (rain.diameters, rain.extent, rain.rate) = ([2.0, 2.05], 40.0, 20.0);
        scene.time = 3.0 + seconds;
        scene.camera.target = scene.camera.position + DVec3::new(turn.sin(), 0.0, -turn.cos());
        scene
    };
    // Half of them are nearer than twice the least depth: a pixel there is 20 mm.
    let moments = [(0.0, 0.0), (0.010 / 6.5, 0.0), (0.0, 0.5 / 886.81), (1.0, 0.0)];
    on_device(|device| {
        let [noise, drops] = [FarRain::Grain, FarRain::Drops].map(|far_rain| {
            let scenes = moments.map(|(seconds, turn)| at(far_rain, seconds, turn));
            let pictures = opacities(device, &scenes);
            let changes = [1, 2, 3].map(|other: usize| apart(&pictures[0], &pictures[other]));
            let all = deviation(&pictures[0]);
            (all, changes.map(|change| change / all))
        });
        println!("noise {noise:.3?}, drops {drops:.3?}");
        assert!((noise.0 / drops.0 - 1.0).abs() < 0.1, "{} and {}", noise.0, drops.0);
        for moment in 0..2 {
            assert!(noise.1[moment] < drops.1[moment], "{noise:?}, {drops:?}");
            assert!(noise.1[moment] > 0.2, "it stands still: {noise:?}");
        }
        // √2 where nothing is left of what was.
        assert!(noise.1[2] > 1.3, "{noise:?}");
    });
}

#[test]
fn noise_is_drawn_where_it_would_be_seen() {
    let mut scene = far_rain(0.05, 0.0);
    scene.model.far_rain = None;
    let of = |scene: &Scene, sky: &Environment| {
        Cutoff::of(scene, &scene.real_rain().expect("rain"), sky)
    };
    // Black and white have the most contrast that there is, half.
    let sky = painted(256, |d| if d.y > 0.0 { Vec3::splat(1e6) } else { Vec3::ZERO });
    let even = Environment::constant(Vec3::ONE);
    // RAIN.md with size: 0.00934 for N0 = 8000.
    let expected = 0.5 * 0.00934 * 0.8863f64.sqrt();
    let noise = of(&scene, &sky).noise;
    assert!((noise / expected - 1.0).abs() < 0.05, "{noise}, not {expected}");
    assert!(of(&scene, &sky).is_grainy && !of(&scene, &even).is_grainy);
    scene.model.error = Some(0.01);
    assert!(!of(&scene, &sky).is_grainy);
    scene.model.far_rain = Some(FarRain::Grain);
    assert!(of(&scene, &even).is_grainy);
    let plan = plan(&scene, &even, Output::Radiance).expect("a plan");
    assert!(plan.passes.iter().any(|(_, why)| why.contains("with the noise of single drops")));
}
