//! What does not fit into a view's lists is told, and our own frames are then drawn again with more room.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::gpu::Device;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
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

/// A renderer by a plan with `room`.
fn renderer(device: &Arc<Device>, scene: &Scene, room: u32) -> Renderer {
    let environment =
        painted(64, |d| Vec3::new(1.5 + d.x as f32, 1.5 + d.y as f32, 1.5 + d.z as f32));
    let mut plan = plan(scene, &environment, Output::Display).expect("a plan");
    plan.room = room;
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

/// As the window does, which waits for no frame; it goes on showing the image that it began with.
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
