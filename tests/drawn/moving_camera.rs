//! A camera that moves while the shutter is open: its picture is that of a camera at rest with every velocity, wind
//! included, less the camera's.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::plan::Output;
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::Renderer;
use raindrops::scene::film::PaceKey;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

use crate::common::picture::{light_rain, moving, renderer_of, square};
use crate::common::{emptied_folder, on_device, run, waves};

const VELOCITY: DVec3 = DVec3::new(3.0, 0.7, -13.9);

fn by_camera(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera.velocity = Some(VELOCITY);
    scene
}

/// The scene seen from a camera at rest in the air that comes towards it: at the scene's time it is where the moving one is,
/// from where the air was at time 0.
fn by_air(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera = scene.camera.moved_by(-VELOCITY * scene.time);
    scene.drops.iter_mut().for_each(|drop| drop.velocity -= VELOCITY);
    if let Some(rain) = &mut scene.rain {
        rain.velocity -= VELOCITY;
        rain.real.iter_mut().for_each(|rain| rain.wind -= VELOCITY * scene.metres);
    }
    scene
}

fn exposed(preset: Preset) -> Scene {
    let mut scene = square(48);
    scene.model.take_preset(preset);
    scene.camera.shutter = 1.0 / 60.0;
    scene.camera.position = DVec3::new(0.3, 1.7, 0.1);
    scene.camera.target = DVec3::new(0.9, 1.5, -5.0);
    scene.camera.vertical_fov = 50.0;
    scene
}

/// Small, large and flat ones, at rest and in motion.
fn placed(preset: Preset) -> Scene {
    let mut scene = exposed(preset);
    let at = |number: u32, step: f64| (f64::from(number) * step).fract() - 0.5;
    scene.drops = (1..60)
        .map(|number| PlacedDrop {
            axis_ratio: (number % 3 == 0).then_some(0.8),
            ..moving(
                [
                    6.0 * at(number, 0.618),
                    1.7 + 5.0 * at(number, 0.414),
                    -3.0 - f64::from(number % 7),
                ],
                [at(number, 0.3), -9.0 * f64::from(number % 2), at(number, 0.7)],
                0.004 * f64::from(1 + number % 40),
            )
        })
        .collect();
    scene
}

fn weather(preset: Preset) -> Scene {
    let mut scene = exposed(preset);
    (scene.time, scene.metres) = (2.5, 0.5);
    let wind = DVec3::new(3.0, 0.0, 1.0);
    let rain = RealRain { rate: 60.0, extent: 6.0, wind, ..RealRain::default() };
    scene.rain = Some(RainSettings::of(rain));
    scene
}

fn boxed(preset: Preset) -> Scene {
    let time = 2.5;
    Scene { time, rain: Some(light_rain()), ..exposed(preset) }
}

fn drawn(device: &Arc<Device>, scene: &Scene, output: Output) -> Renderer {
    let sky = waves();
    let mut renderer = renderer_of(device, scene, &sky, output);
    let camera = scene.camera.moved_by(scene.camera_motion());
    let until = Scene { time: scene.time + scene.exposed(), camera, ..scene.clone() };
    renderer.draw_until(scene, &until).expect("a frame");
    renderer
}

fn layers_of(device: &Arc<Device>, scene: &Scene) -> Layers {
    drawn(device, scene, Output::Layers).read_layers().expect("layers")
}

fn picture_of(device: &Arc<Device>, scene: &Scene) -> Picture {
    drawn(device, scene, Output::Radiance).read_radiance().expect("a picture")
}

fn traced(scene: &Scene, samples: u32) -> Picture {
    Tracer::new(scene, &waves(), Truth { samples, ..Truth::default() }).picture()
}

/// Root of the mean squared difference, over the mean.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).length_squared());
    let mean: Vec3 = a.pixels.iter().sum();
    (squares.sum::<f32>() / a.pixels.len() as f32).sqrt() * a.pixels.len() as f32 / mean.length()
}

#[test]
fn placed_drops_at_time_0_are_the_same_to_the_byte() {
    let scene = placed(Preset::Fast);
    assert_eq!(traced(&by_camera(&scene), 1), traced(&by_air(&scene), 1));
    assert_ne!(traced(&scene, 1), traced(&by_air(&scene), 1));
    on_device(|device| {
        for preset in [Preset::Fast, Preset::Exact] {
            let scene = placed(preset);
            let (camera, air) = (by_camera(&scene), by_air(&scene));
            let layers = layers_of(device, &air);
            assert!(layers_of(device, &camera) == layers, "{preset}");
            assert!(picture_of(device, &camera) == picture_of(device, &air), "{preset}");
            assert!(layers.id.iter().any(|id| *id != 0), "{preset}: no drops");
            assert!(
                layers_of(device, &scene) != layers,
                "{preset}: the camera's motion does nothing"
            );
        }
    });
}

#[test]
fn rain_is_the_same_but_for_rounding() {
    on_device(|device| {
        for (name, scene) in [("real", weather(Preset::Fast)), ("in a box", boxed(Preset::Fast))] {
            let [a, b, at_rest] = [by_camera(&scene), by_air(&scene), scene].map(|scene| {
                let layers = layers_of(device, &scene);
                let ImageSize { width, height } = scene.image;
                let sky =
                    Picture { width, height, pixels: vec![Vec3::ONE; (width * height) as usize] };
                (layers.over(&sky), layers)
            });
            let same = a.1.id.iter().zip(&b.1.id).filter(|(a, b)| a == b).count();
            let moved = a.1.motion.iter().zip(&b.1.motion).filter(|(a, b)| {
                [0, 1].iter().any(|&i| (a[i].to_f32() - b[i].to_f32()).abs() > 0.02)
            });
            let (far, control) = (apart(&a.0, &b.0), apart(&at_rest.0, &b.0));
            let moved = moved.count();
            println!("{name}: {far:.5}, at rest {control:.5}; {same} the same, {moved} off");
            assert!(far < 0.05 * control, "{name}: {far}, {control}");
            let all = a.1.id.len();
            assert!(same > all * 98 / 100 && moved < all / 50, "{name}: {same} {moved}");
        }
    });
    for (name, scene) in [("real", weather(Preset::Fast)), ("in a box", boxed(Preset::Fast))] {
        let of = |scene: &Scene| {
            let mut small = scene.clone();
            (small.image.width, small.image.height) = (16, 16);
            traced(&small, 4)
        };
        let b = of(&by_air(&scene));
        let (far, control) = (apart(&of(&by_camera(&scene)), &b), apart(&of(&scene), &b));
        println!("reference, {name}: {far:.6}, at rest {control:.5}");
        assert!(far < 0.02 * control, "reference, {name}: {far}, {control}");
    }
}

/// A car at 13.9 m/s, two seconds after it began to drive.
const DRIVE: &str = "seed = 3
[camera]
vertical_fov = 40
near = 1.0
shutter = 0.01
[image]
width = 160
height = 120
[environment]
radiance = [1, 1, 1]
[rain]
rate = 50
extent = 8
[film]
fps = 10
[[film.camera]]
at = 0.0
position = [0, 1.7, 0]
target = [0, 1.7, -100]
[[film.camera]]
at = 10.0
position = [0, 1.7, -139]
target = [0, 1.7, -239]
";

/// Where there is a drop: pixels from the middle, half the width being 80; the channels `Z` and `motion.X`, in such pixels.
fn depth_and_motion(path: &Path) -> Vec<(f64, f64, f64)> {
    let image = crate::common::exr_layer(path);
    let values = |name: &str| -> Vec<f64> {
        let all = &image.layer_data.channel_data.list;
        let found = all.iter().find(|channel| channel.name.to_string() == name);
        found.expect("a channel").sample_data.values_as_f32().map(f64::from).collect()
    };
    let width = image.layer_data.size.width();
    let both = values("Z").into_iter().zip(values("motion.X")).enumerate();
    let pixel = 160.0 / width as f64;
    let right = |at: usize| ((at % width) as f64 + 0.5) * pixel - 80.0;
    let drops = both.filter(|(_, (depth, _))| depth.is_finite());
    drops.map(|(at, (depth, motion))| (right(at), depth, motion * pixel)).collect()
}

/// The pictures are those that the command writes.
#[test]
fn streaks_spread_from_where_a_car_drives_to() {
    let folder = emptied_folder("moving-camera");
    std::fs::write(folder.join("drive.toml"), DRIVE).expect("a scene");
    // A path of two keys goes as 3 t^2 - 2 t^3, whose slope at a fifth is 24/25.
    let way = 0.96 * 13.9 * 0.01;
    let edges = |arguments: &[&str]| {
        let all = ["render", "drive.toml", "--frame", "20", "--layers", "-o", "rain.exr"];
        let (is_done, said) = run(&folder, &[&all, arguments].concat());
        assert!(is_done, "{said}");
        let mut sides = [(0.0, 0); 2];
        let mut farthest = 0.0_f64;
        for (x, depth, found) in depth_and_motion(&folder.join("rain.exr")) {
            // From the middle of the exposure on; the pixel is on the streak, not always in its middle.
            farthest =
                farthest.max((found - x * way / (depth - way)).abs() / (1.0 + 0.5 * found.abs()));
            if x.abs() > 72.0 {
                let side = &mut sides[usize::from(x > 0.0)];
                *side = (side.0 + found, side.1 + 1);
            }
        }
        let [left, right] = sides.map(|(sum, count)| sum / f64::from(count));
        println!(
            "{arguments:?}: {left:.2} px at the left edge, {right:.2} at the right one, off by {farthest:.2}"
        );
        (left, right, farthest)
    };
    // Drops 1 to 8 m away move by 1.3 to 12 pixels. Before even light no single drop shows, so few would be drawn one by one.
    let many = ["--preset", "exact", "--set", "model.cutoff_px=0.1"];
    let (left, right, farthest) = edges(&many);
    assert!((-12.0..=-1.3).contains(&left) && (1.3..=12.0).contains(&right) && farthest < 1.0);
    let (left, right, _) = edges(&[&many[..], &["--set", "camera.velocity=[0,0,0]"]].concat());
    assert!(left.abs() < 0.1 && right.abs() < 0.1, "{left} {right}");
}

/// While the pace is 0 the drops stand, and the camera goes on.
#[test]
fn a_camera_moves_through_drops_that_stand() {
    let mut scene = placed(Preset::Fast);
    scene.film.pace = vec![PaceKey { at: 0.0, rate: 0.0 }];
    let frame = scene.film.frame(&by_camera(&scene), 5);
    let mut stopped = by_camera(&scene);
    stopped.film = Default::default();
    stopped.drops.iter_mut().for_each(|drop| drop.velocity = DVec3::ZERO);
    assert_eq!(traced(&frame, 1), traced(&stopped, 1));
    on_device(|device| {
        // The still takes the models of a film, whose drops may stand.
        stopped.film = scene.film.clone();
        assert!(layers_of(device, &frame) == layers_of(device, &stopped));
    });
}
