//! A fixed exposure: the same radiance gives the same byte in every frame, on the GPU as in
//! `src/picture/tone_map.rs`.

use std::sync::Arc;

use crate::common::picture::renderer_of;
use crate::common::{on_adjusted_device, on_device};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Machine};
use raindrops::picture::Picture;
use raindrops::picture::tone_map::{DELTA, Exposure, display, luminance};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::{Operator, Preset};
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

const EDGE: u32 = 48;

/// Dim below, bright above; in units that make the stored 1 something else than 1.
fn bright_above() -> Environment {
    let texels = (0..16 * 32)
        .map(|at| Vec3::new(1.0, 0.7, 0.4) * if at < 8 * 32 { 2e6 } else { 5e3 })
        .collect();
    Environment::from_texels("bright above", 32, 16, texels).expect("an environment")
}

/// A drop before the left part of the picture, of a size that changes how bright the picture is.
fn scene(preset: Preset, radius: f64) -> Scene {
    let mut scene = Scene {
        rain: None,
        drops: vec![PlacedDrop::sphere(DVec3::new(-2.0, 0.0, -4.0), radius)],
        image: ImageSize { width: EDGE, height: EDGE },
        ..Scene::default()
    };
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.camera.target = DVec3::new(0.0, -0.4, -1.0);
    scene
}

fn renderer(device: &Arc<Device>, scene: &Scene, output: Output) -> Renderer {
    renderer_of(device, scene, &bright_above(), output)
}

fn shown(renderer: &mut Renderer, scene: &Scene) -> Vec<u8> {
    renderer.submit(scene).expect("a frame");
    renderer.read_display().expect("a picture")
}

/// Bytes of the two rightmost columns, which the drop does not reach.
fn beside_the_drop(bytes: &[u8]) -> Vec<u8> {
    let pixels = bytes.chunks_exact(3).enumerate();
    let right = pixels.filter(|(at, _)| *at as u32 % EDGE >= EDGE - 2);
    right.flat_map(|(_, pixel)| pixel.to_vec()).collect()
}

fn bytes_of(exposure: Exposure, radiance: &Picture) -> Vec<u8> {
    let shown = display(exposure, radiance);
    shown.srgb()
}

/// The largest difference of two pictures' bytes, and the share of bytes that differ.
fn differences(a: &[u8], b: &[u8]) -> (u8, f64) {
    let pairs = || a.iter().zip(b);
    let largest = pairs().map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let differ = pairs().filter(|(a, b)| a != b).count();
    (largest, differ as f64 / a.len() as f64)
}

#[test]
fn a_sequence_does_not_breathe() {
    for preset in [Preset::Paper, Preset::Fast] {
        on_device(|device| {
            for (exposure, steady) in [(Some(3e-6), true), (None, false)] {
                let mut first = scene(preset, 0.4);
                first.tone_map.exposure = exposure;
                let mut second = scene(preset, 1.6);
                second.tone_map.exposure = exposure;
                let mut renderer = renderer(device, &first, Output::Display);
                let a = beside_the_drop(&shown(&mut renderer, &first));
                // Drops are made with a renderer: the other frame has another one.
                let mut other = self::renderer(device, &second, Output::Display);
                let b = beside_the_drop(&shown(&mut other, &second));
                assert!(a.iter().any(|byte| (20..235).contains(byte)), "nothing to see");
                // The control: derived, the two are not alike.
                assert_eq!(a == b, steady, "{preset} {exposure:?}");
            }
        });
    }
}

#[test]
fn the_derived_exposure_can_be_held() {
    let on_cpus = [(Preset::Paper, Machine::Cpu), (Preset::Fast, Machine::Cpu)];
    let on_gpus = [(Preset::Paper, Machine::Gpu), (Preset::Fast, Machine::Gpu)];
    for (preset, machine) in on_cpus.into_iter().chain(on_gpus) {
        on_adjusted_device(
            |report| report.machine = machine,
            |device| {
                let mut scene = scene(preset, 1.0);
                let derived = shown(&mut renderer(device, &scene, Output::Display), &scene);
                let mut renderer = renderer(device, &scene, Output::Radiance);
                renderer.submit(&scene).expect("a frame");
                let radiance = renderer.read_radiance().expect("a picture");
                // The GPU's delta is told from the environment, not from the picture.
                let delta = DELTA * bright_above().mean_luminance();
                let logs = radiance.pixels.iter().map(|p| (delta + luminance(p.as_dvec3())).ln());
                let average = (logs.sum::<f64>() / radiance.pixels.len() as f64).exp();
                scene.tone_map.exposure = Some(scene.tone_map.key / average);
                let held = shown(&mut self::renderer(device, &scene, Output::Display), &scene);
                let (largest, share) = differences(&derived, &held);
                assert!(largest <= 1 && share < 0.01, "{preset}, {machine:?}: {largest}, {share}");
            },
        );
    }
}

#[test]
fn the_gpu_maps_tones_as_the_cpu_does() {
    for preset in [Preset::Paper, Preset::Fast] {
        on_device(|device| {
            let mut scene = scene(preset, 1.0);
            let mut linear = renderer(device, &scene, Output::Radiance);
            linear.submit(&scene).expect("a frame");
            let radiance = linear.read_radiance().expect("a picture");
            let photographic = |e| Exposure::Photographic(e);
            let clipped = |e| Exposure::Clipped(e);
            type OnCpu = fn(f64) -> Exposure;
            let operators: [(Operator, OnCpu); 2] =
                [(Operator::Photographic, photographic), (Operator::None, clipped)];
            for (operator, on_cpu) in operators {
                scene.tone_map.operator = operator;
                scene.tone_map.exposure = Some(1.0);
                // Another exposure needs no other renderer.
                let mut renderer = renderer(device, &scene, Output::Display);
                for exposure in [1e-30, 3e-7, 1e-6, 0.05, 1e30] {
                    scene.tone_map.exposure = Some(exposure);
                    let found = shown(&mut renderer, &scene);
                    let (largest, _) = differences(&found, &bytes_of(on_cpu(exposure), &radiance));
                    assert!(largest <= 1, "{preset} {operator} {exposure}: off by {largest}");
                }
            }
        });
    }
}

#[test]
fn a_fixed_exposure_needs_no_log_average() {
    let mut scene = scene(Preset::Fast, 1.0);
    let names = |scene: &Scene| -> Vec<&str> {
        let plan = plan(scene, &bright_above(), Output::Display).expect("a plan");
        plan.passes.iter().map(|(name, _)| *name).collect()
    };
    assert!(names(&scene).contains(&"log luminance"));
    scene.tone_map.exposure = Some(1.0);
    assert!(!names(&scene).contains(&"log luminance"));
    on_device(|device| {
        let mut renderer = renderer(device, &scene, Output::Display);
        shown(&mut renderer, &scene);
        let report = renderer.finish().expect("a report");
        assert!(report.passes_ms.iter().all(|(name, _)| *name != "log luminance"));
        // Nothing was summed up to derive one from.
        scene.tone_map.exposure = None;
        let error = renderer.submit(&scene).expect_err("no log average");
        assert!(error.to_string().contains("exposure"), "{error}");
    });
}

#[test]
fn a_fixed_exposure_is_a_finite_factor_over_0() {
    for bad in ["0.0", "-1.0", "nan", "inf", "-inf", "1e31", "1e-31"] {
        let text = format!("[tone_map]\nexposure = {bad}\n");
        let error = Scene::parse(&text, "scene.toml").expect_err(bad).to_string();
        assert!(error.contains("scene.toml:2: tone_map: exposure = "), "{error}");
    }
    let scene = Scene::parse("[tone_map]\nexposure = 1.5\n", "scene.toml").expect("a scene");
    assert_eq!(scene.tone_map.exposure, Some(1.5));
}
