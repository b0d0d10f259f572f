//! Preset `paper-compact` draws what `paper` draws, without a vertex for the drops out of view.

use std::sync::Arc;

use crate::common::on_adjusted_device;
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{FrameReport, Renderer};
use raindrops::scene::model::{Preset, Primitive};
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

fn scene(count: u32) -> Scene {
    let mut scene = Scene { image: ImageSize { width: 64, height: 48 }, ..Scene::default() };
    scene.model.mask_size = 64;
    let rain = scene.rain.get_or_insert_default();
    rain.count = count;
    rain.half_extent = DVec3::splat(40.0);
    // Placed drops come last, and blend over the others where they come to lie.
    scene.drops = vec![
        PlacedDrop::sphere(DVec3::new(0.5, 0.0, -6.0), 1.0),
        PlacedDrop::sphere(DVec3::new(0.0, 0.0, 9.0), 1.0),
        PlacedDrop::sphere(DVec3::new(-0.4, 0.3, -5.0), 0.5),
    ];
    scene
}

fn draw(device: &Arc<Device>, scene: &Scene) -> (Picture, FrameReport) {
    let texels = (0..8 * 16).map(|at| Vec3::new(1.0, 0.2, 0.4) * ((at % 7) as f32 + 0.5)).collect();
    let environment = Environment::from_texels("stripes", 16, 8, texels).expect("an environment");
    let plan = plan(scene, &environment, Output::Radiance).expect("a plan");
    let mut renderer = Renderer::new(device, scene, &environment, &plan).expect("a renderer");
    // The second frame meets what the first one left.
    for time in [0.3, scene.time] {
        renderer.submit(&Scene { time, ..scene.clone() }).expect("a frame");
    }
    let report = renderer.finish().expect("a report");
    let planned: Vec<_> = plan.passes.iter().map(|(name, _)| *name).collect();
    let timed: Vec<_> = report.passes_ms.iter().map(|(name, _)| *name).collect();
    assert_eq!(planned, timed, "what is planned is recorded");
    (renderer.read_radiance().expect("a picture"), report)
}

/// Draws with records in bindings of so many bytes at most.
fn same_pictures(count: u32, binding_bytes: u32) {
    on_adjusted_device(
        |report| {
            let limit = &mut report.limits.max_storage_buffer_range;
            *limit = binding_bytes.min(*limit);
        },
        |device| {
            for primitive in [Primitive::Point, Primitive::Quad] {
                let mut scene = scene(count);
                scene.model.primitive = Some(primitive);
                scene.model.preset = Preset::Paper;
                let (paper, of_paper) = draw(device, &scene);
                scene.model.preset = Preset::PaperCompact;
                let (compact, of_compact) = draw(device, &scene);
                assert_eq!(of_paper.counts, of_compact.counts);
                let visible = of_paper.counts.visible;
                assert!(visible > 0 && visible < u64::from(count) / 2, "{visible} of {count}");
                assert_eq!(paper.pixels, compact.pixels, "{primitive}, {count} drops");
            }
        },
    );
}

#[test]
fn the_pictures_are_the_papers() {
    same_pictures(5_000, u32::MAX);
}

#[test]
fn records_of_several_bindings_are_drawn_in_order() {
    // 65,536 records a binding, the last one not full.
    same_pictures(150_000, 1 << 20);
}

#[test]
fn few_drops_leave_most_blocks_empty() {
    same_pictures(50, u32::MAX);
}
