//! What does not fit into a view's lists is told, and our own frames are then drawn again with more room.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::renderer::parts::{Grid, Parts, empty_picture, place};
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use crate::adjusted::alike_streaks;
use crate::common::{on_adjusted_device, on_device, painted};

/// A hundred drops that fill the picture, one behind the other.
fn layers() -> Scene {
    let image = ImageSize { width: 128, height: 64 };
    let mut scene = Scene { rain: None, image, ..Scene::default() };
    scene.model.preset = Preset::Fast;
    let drop = |number: i32| {
        PlacedDrop::sphere(DVec3::new(0.0, 0.0, -2.0 - 0.001 * f64::from(number)), 1.5)
    };
    scene.drops = (0..100).map(drop).collect();
    scene
}

fn ramps() -> Environment {
    painted(64, |d| Vec3::new(1.5 + d.x as f32, 1.5 + d.y as f32, 1.5 + d.z as f32))
}

/// A renderer by a plan with `room`.
fn renderer(device: &Arc<Device>, scene: &Scene, room: u32) -> Renderer {
    let environment = ramps();
    let mut plan = plan(scene, &environment, Output::Display).expect("a plan");
    plan.room = room;
    plan.light.picture_level = 4; // the largest pictures are more than some of these devices allocate
    Renderer::new(device, scene, &environment, &plan).expect("a renderer")
}

#[test]
fn a_frame_that_lacks_room_is_drawn_again_with_more() {
    let scene = layers();
    on_device(|device| {
        let mut small = renderer(device, &scene, 1);
        small.submit(&scene).expect("a frame");
        let lost = small.finish().expect("a report").counts.overflow;
        assert!(lost > 0, "the control: all of it fits");

        let mut grown = renderer(device, &scene, 1);
        let report = grown.draw(&scene).expect("a frame");
        assert!(report.room > 1 && report.counts.overflow == 0, "{report:?}");
        let mut large = renderer(device, &scene, report.room);
        assert_eq!(large.draw(&scene).expect("a frame").room, report.room);
        let [grown, large] = [grown, large].map(|renderer| {
            (
                renderer.read_radiance().expect("pixels").pixels,
                renderer.read_display().expect("pixels"),
            )
        });
        assert!(grown == large, "the pictures differ");
    });
}

/// What a streak's links lack is a reason for more, too.
#[test]
fn streaks_that_lack_room_are_drawn_again_with_more() {
    let scene = alike_streaks(8000);
    on_device(|device| {
        let mut small = renderer(device, &scene, 1);
        small.submit(&scene).expect("a frame");
        let lost = small.finish().expect("a report").counts.overflow;
        assert!(lost > 0, "the control: all of it fits");
        let report = renderer(device, &scene, 1).draw(&scene).expect("a frame");
        assert!(report.room > 1 && report.counts.overflow == 0, "{report:?}");
    });
}

/// The window draws like this: it waits for no frame, and goes on showing the image that it began with.
#[test]
fn frames_in_flight_get_more_room_too() {
    let scene = layers();
    on_device(|device| {
        let mut renderer = renderer(device, &scene, 1);
        let shown = renderer.display().expect("an image").raw();
        for _ in 0..8 {
            renderer.submit(&scene).expect("a frame");
        }
        let report = renderer.finish().expect("a report");
        assert!(report.room > 1 && report.counts.overflow == 0, "{report:?}");
        assert_eq!(renderer.display().expect("an image").raw(), shown);
    });
}

/// Where the device has no more, the frame is what it is, and says so.
#[test]
fn a_full_device_is_told_and_drawn_with() {
    let scene = layers();
    on_adjusted_device(
        |report| report.max_allocation = 6 << 20,
        |device| {
            let mut renderer = renderer(device, &scene, 1);
            let report = renderer.draw(&scene).expect("a frame");
            assert!(report.counts.overflow > 0, "{report:?}");
        },
    );
}

/// Rain whose larger drops are streaks over hundreds of tiles each.
fn towards() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/towards.toml");
    let mut scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    // All streaks are drawn: few that stand for many would have room.
    scene.model.thinned_px = Some(0.001);
    scene
}

/// Lists that are short get more room where others have all that one binding holds: here those of large drops, of which
/// there are few.
#[test]
fn full_lists_do_not_keep_others_from_growing() {
    on_adjusted_device(
        |report| report.limits.max_storage_buffer_range = 8 << 20,
        |device| {
            let report = renderer(device, &towards(), 1).draw(&towards()).expect("a frame");
            assert!(report.room > 1, "the control: all of it fits");
            assert_eq!(report.counts.overflow, 0, "{report:?}");
        },
    );
}

/// What a device has no room for at once is drawn in parts, with the bytes of the whole; where an exposure is derived, its
/// sums are found in parts before.
#[test]
fn a_picture_that_a_device_has_no_room_for_is_drawn_in_parts() {
    let scene = towards();
    let (mut whole_pixels, mut whole_bytes) = (Vec::new(), Vec::new());
    on_device(|device| {
        let mut renderer = renderer(device, &scene, 2);
        let report = renderer.draw(&scene).expect("a frame");
        assert_eq!(report.counts.overflow, 0, "{report:?}");
        whole_pixels = renderer.read_radiance().expect("pixels").pixels;
        whole_bytes = renderer.read_display().expect("pixels");
    });
    on_adjusted_device(
        |report| report.max_allocation = 24 << 20,
        |device| {
            for output in [Output::Display, Output::Radiance] {
                let environment = ramps();
                let plan = plan(&scene, &environment, output).expect("a plan");
                let mut parts = Parts::new(device, &environment, &plan);
                let (_, report) = parts.draw_window(&scene).expect("a frame");
                assert!(report.counts.overflow > 0, "the control: all of it fits");

                let width = scene.image.width;
                let mut pixels = empty_picture(scene.image).pixels;
                let mut bytes = vec![[0u8; 3]; pixels.len()];
                let (mut lost, mut taken) = (0, 0);
                let one = Grid { columns: 1, rows: 1 };
                parts
                    .draw_all(&scene, one, &mut |origin, renderer, report| {
                        lost += report.counts.overflow;
                        taken += 1;
                        let part = renderer.read_radiance()?;
                        place(&mut pixels, width, origin, &part.pixels, part.width);
                        if output == Output::Display {
                            let shown = renderer.read_display()?;
                            place(
                                &mut bytes,
                                width,
                                origin,
                                bytemuck::cast_slice(&shown),
                                part.width,
                            );
                        }
                        Ok(())
                    })
                    .expect("parts");
                assert!(lost == 0 && taken > 1, "{lost} lost in {taken} parts");
                assert!(pixels == whole_pixels, "the parts differ from the whole");
                let is_exposed_so = bytes.as_flattened() == &whole_bytes[..];
                assert!(
                    is_exposed_so || output != Output::Display,
                    "the parts are exposed otherwise"
                );
            }
        },
    );
}
