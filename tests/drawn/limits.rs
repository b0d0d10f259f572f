//! What a device cannot hold is refused before it is asked for, with both figures.

use std::sync::Arc;

use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::gpu::{Device, DeviceReport};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, Scene};

fn scene(preset: Preset, drops: u32, edge: u32) -> Scene {
    let mut scene = Scene::default();
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.rain.get_or_insert_default().count = drops;
    scene.image = ImageSize { width: edge, height: edge };
    scene
}

fn make(device: &Arc<Device>, scene: &Scene) -> raindrops::Result<Renderer> {
    let white = Environment::constant(Vec3::ONE);
    let mut plan = plan(scene, &white, Output::Radiance)?;
    plan.light.picture_level = 4; // the largest pictures are more than such a device allocates
    Renderer::new(device, scene, &white, &plan)
}

/// On a device whose report was changed, making a renderer fails with a line that holds all of `words`.
#[track_caller]
fn refused(adjust: impl FnOnce(&mut DeviceReport), scene: &Scene, words: &[&str]) {
    crate::common::on_adjusted_device(adjust, |device| {
        let Err(error) = make(device, scene) else { panic!("{words:?}: it was made") };
        let line = error.to_string();
        println!("{line}");
        assert!(!line.contains('\n'), "{line}");
        for word in words {
            assert!(line.contains(word), "'{line}' does not say '{word}'");
        }
    });
}

#[test]
fn memory_is_refused_with_a_figure() {
    let adjust = |report: &mut DeviceReport| report.max_allocation = 8 << 20;
    let words = ["drops (9.5 MiB)", "8.0 MiB at once at most", "fewer drops"];
    refused(adjust, &scene(Preset::Paper, 625_000, 32), &words);
    refused(adjust, &scene(Preset::Paper, 0, 2048), &["radiance (32.0 MiB)", "8.0 MiB at once"]);
    refused(adjust, &scene(Preset::Fast, 3_000_000, 32), &["MiB", "8.0 MiB at once"]);
}

/// The paper's drops go in chunks; the tiles' lists are one binding each.
#[test]
fn more_drops_than_a_binding_holds() {
    let adjust = |report: &mut DeviceReport| report.limits.max_storage_buffer_range = 8 << 20;
    let words = ["drops in tiles is 2,100,000", "2,097,120 at most"];
    refused(adjust, &scene(Preset::Fast, 2_100_000, 32), &words);
    crate::common::on_adjusted_device(adjust, |device| {
        let scene = scene(Preset::Paper, 2_100_000, 32);
        let mut renderer = make(device, &scene).expect("a renderer");
        renderer.submit(&scene).expect("a frame");
        let counts = renderer.finish().expect("a report").counts;
        assert_eq!(counts.visible, raindrops::rain::cull::count_visible(&scene));
    });
}

#[test]
fn more_tiles_than_a_dispatch_takes() {
    let adjust = |report: &mut DeviceReport| report.limits.max_compute_work_group_count[0] = 1024;
    let words = ["number of pixels is 1,048,576", "524,288 at most"];
    refused(adjust, &scene(Preset::Fast, 100, 1024), &words);
}

#[test]
fn a_larger_image_than_the_device_takes() {
    let adjust = |report: &mut DeviceReport| report.limits.max_image_dimension2_d = 1000;
    refused(adjust, &scene(Preset::Paper, 0, 1001), &["1,001", "1,000 at most"]);
}

/// An environment that is uploaded in several strips is whole: every row where it belongs.
#[test]
fn a_large_environment_is_uploaded_whole() {
    let (width, height) = (4096, 2048);
    let row = |y: u32| Vec3::new(1.0, (y + 1) as f32, 1.0) / height as f32;
    let texels = (0..height).flat_map(|y| std::iter::repeat_n(row(y), width as usize)).collect();
    let ramp = Environment::from_texels("ramp", width, height, texels).expect("an environment");
    let mut scene = Scene { rain: None, ..Scene::default() };
    scene.image = ImageSize { width: 64, height: 512 };
    scene.camera.vertical_fov = 170.0;
    crate::common::on_device(|device| {
        let picture = crate::common::picture::picture_of(device, &scene, &ramp);
        let view = scene.camera.view(scene.image.width, scene.image.height);
        for (y, pixels) in picture.pixels.chunks_exact(64).enumerate() {
            let seen = pixels[32].y;
            let there = ramp.radiance(view.ray(32.5, y as f64 + 0.5)).y as f32;
            // Two texels, and float16.
            let bound = 2.0 / height as f32 + there / 1024.0;
            assert!((seen - there).abs() < bound, "row {y}: {seen}, not {there}");
        }
    });
}
