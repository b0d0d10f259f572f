//! Placed drops in motion: at every instant what a drop at rest there would be.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::on_device;

/// Brighter to the right and above, so that a drop's picture tells how it stands.
fn slope() -> Environment {
    let texel = |i: u32| Vec3::new((i % 64) as f32 + 1.0, 40.0, 33.0 - (i / 64) as f32);
    Environment::from_texels("slope", 64, 32, (0..64 * 32).map(texel).collect()).expect("an image")
}

/// A large drop, a near one and a small one, in different motion, at `time`.
fn moving(time: f64, preset: Preset) -> Scene {
    let mut scene = Scene { rain: None, time, ..Scene::default() };
    (scene.image.width, scene.image.height) = (64, 48);
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    for (at, radius, velocity) in [
        ([-2.0, 0.5, -8.0], 1.0, [0.0, -9.0, 0.0]),
        ([1.0, 1.0, -3.0], 0.3, [3.0, 2.0, -1.0]),
        ([9.0, -3.0, -40.0], 0.5, [0.0, 0.0, 25.0]),
    ] {
        let velocity = DVec3::from(velocity);
        // There at this time, whenever that is.
        let center = DVec3::from(at) - velocity * time;
        scene.drops.push(PlacedDrop { velocity, ..PlacedDrop::sphere(center, radius) });
    }
    scene
}

fn at_rest(scene: &Scene) -> Scene {
    let rest = |drop: &PlacedDrop| PlacedDrop::sphere(drop.center_at(scene.time), drop.radius);
    Scene { time: 0.0, drops: scene.drops.iter().map(rest).collect(), ..scene.clone() }
}

fn renderer(device: &Arc<Device>, scene: &Scene) -> Renderer {
    let environment = slope();
    let plan = plan(scene, &environment, Output::Radiance).expect("a plan");
    Renderer::new(device, scene, &environment, &plan).expect("a renderer")
}

fn picture(renderer: &mut Renderer, scene: &Scene) -> Picture {
    renderer.submit(scene).expect("a frame");
    assert_eq!(renderer.finish().expect("a report").counts.visible, 3);
    renderer.read_radiance().expect("radiance")
}

#[test]
fn a_moving_drop_is_where_it_should_be() {
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact, Preset::Paper] {
            for time in [0.125, -7.0, 3.0e6] {
                // 3e6 s: 27,000 km of fall, to the last bit of float64.
                let scene = moving(time, preset);
                let rest = at_rest(&scene);
                // The frame before shows another time.
                let before = Scene { time: time - 0.5, ..scene.clone() };
                let mut moved = renderer(device, &before);
                moved.submit(&before).expect("a frame");
                assert_eq!(
                    picture(&mut moved, &scene),
                    picture(&mut renderer(device, &rest), &rest),
                    "{preset} at {time}"
                );
            }
        }
    });
}
