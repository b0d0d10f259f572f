//! Placed drops in motion: at every instant what a drop at rest there would be.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::{on_device, picture};

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
    picture::renderer(device, scene, &slope())
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

/// Drops that are far beside the picture in the middle of the exposure, and near its middle at the end.
fn from_beyond(axis_ratio: Option<f64>) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (128, 128);
    scene.model.preset = Preset::Fast;
    // By pictures: as many rays as are affordable would be traced else.
    scene.model.samples = Some(1);
    (scene.camera.vertical_fov, scene.camera.shutter) = (30.0, 0.1);
    for (number, [x, y]) in [[1.0, 0.1], [-1.0, -0.1], [0.1, 1.0], [-0.1, -1.0]].iter().enumerate()
    {
        let depth = 20.0 + number as f64;
        let beside = depth * 27f64.to_radians().tan() * DVec3::new(*x, *y, 0.0);
        let way = -1.8 * beside;
        let sphere = PlacedDrop::sphere(beside - 0.5 * way - depth * DVec3::Z, 0.0235 * depth);
        scene.drops.push(PlacedDrop { velocity: way / 0.1, axis_ratio, ..sphere });
    }
    scene
}

/// What they show is known there, too: before a white sky they cannot be told from it, and before another they can. A part of
/// the picture, far from the edge that they are shown as from, shows the same, whichever is drawn first.
#[test]
fn drops_that_come_from_beyond_the_picture_have_their_light() {
    let white = Environment::constant(Vec3::ONE);
    on_device(|device| {
        for axis_ratio in [None, Some(0.7)] {
            let scene = from_beyond(axis_ratio);
            let draw =
                |sky: &Environment, scene: &Scene| picture::picture_of(device, scene, sky).pixels;
            let most = |a: &[Vec3], b: &[Vec3]| {
                a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
            };
            let dry = Scene { drops: Vec::new(), ..scene.clone() };
            let off = most(&draw(&white, &scene), &draw(&white, &dry));
            let mut middle = scene.clone();
            middle.camera.window = [0.375, 0.375, 0.625, 0.625];
            let part = draw(&slope(), &middle);
            let whole = draw(&slope(), &scene);
            let shown = most(&whole, &draw(&slope(), &dry));
            println!("{axis_ratio:?}: {off}, and {shown} before another sky");
            assert!(shown > 0.1, "the control: {shown}");
            // Usually 0, and 0.0044 of flattened ones: steps of a half and of nine bits.
            assert!(off < 8e-3, "{axis_ratio:?}: {off}");
            let piece: Vec<_> =
                whole.chunks(128).skip(48).take(32).flat_map(|row| &row[48..80]).copied().collect();
            assert!(part == piece, "{axis_ratio:?}: off by {}", most(&part, &piece));
        }
    });
}
