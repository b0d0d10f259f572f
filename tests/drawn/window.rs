//! A picture drawn in parts equals the whole: by tiles to the byte, whatever lies across the parts' edges.

use std::sync::Arc;

use crate::common::{on_adjusted_device, on_device, painted};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Machine};
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::rain::cull::count_visible;
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::parts::{Grid, Parts, empty_picture, place};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

const WIDTH: u32 = 136;
const HEIGHT: u32 = 120;

/// Small drops, large ones across all edges, and one beside the camera.
fn scene(preset: Preset) -> Scene {
    let mut scene = Scene { image: ImageSize { width: WIDTH, height: HEIGHT }, ..Scene::default() };
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.camera.target = DVec3::new(0.2, -0.1, -1.0);
    let rain = scene.rain.get_or_insert_default();
    rain.count = 30_000;
    rain.half_extent = DVec3::splat(60.0);
    rain.radius = 0.4;
    let at = |x, y, z, radius| PlacedDrop::sphere(DVec3::new(x, y, z), radius);
    scene.drops = vec![at(0.7, -0.3, -4.0, 1.0), at(-0.6, 0.9, -3.0, 0.3), at(1.2, 0.2, -0.6, 0.7)];
    scene
}

fn environment() -> Environment {
    let texel =
        |at: u32| Vec3::new(1.0, 0.3, 0.5) * (0.2 + (at.wrapping_mul(2_654_435_769) >> 28) as f32);
    // A bare sun, up and ahead: its images are drawn apart.
    let sun = |at: u32| if at == 10 * 64 + 36 { Vec3::splat(4e4) } else { texel(at) };
    let texels = (0..32 * 64).map(sun).collect();
    Environment::from_texels("pieces", 64, 32, texels).expect("an environment")
}

/// A picture by the parts of a grid, and the drops in view of them.
fn drawn(device: &Arc<Device>, scene: &Scene, output: Output, grid: Grid) -> (Drawn, u64) {
    drawn_in(device, &environment(), scene, output, grid)
}

/// [`drawn`] in another light.
fn drawn_in(
    device: &Arc<Device>,
    environment: &Environment,
    scene: &Scene,
    output: Output,
    grid: Grid,
) -> (Drawn, u64) {
    let plan = plan(scene, environment, output).expect("a plan");
    let mut parts = Parts::new(device, environment, &plan);
    let mut radiance = empty_picture(scene.image);
    let mut shown = vec![[0; 3]; radiance.pixels.len()];
    let mut visible = 0;
    let take = &mut |origin,
                     renderer: &raindrops::renderer::Renderer,
                     report: raindrops::renderer::FrameReport| {
        visible += report.counts.visible;
        let part = renderer.read_radiance()?;
        place(&mut radiance.pixels, WIDTH, origin, &part.pixels, part.width);
        if output == Output::Display {
            let bytes = renderer.read_display()?;
            place(&mut shown, WIDTH, origin, bytemuck::cast_slice(&bytes), part.width);
        }
        Ok(())
    };
    parts.draw_all(scene, grid, take).expect("parts");
    (Drawn { radiance, shown }, visible)
}

struct Drawn {
    radiance: Picture,
    shown: Vec<[u8; 3]>,
}

/// Whether the parts are the whole, and the first pixel that is not.
fn first_difference<T: PartialEq>(a: &[T], b: &[T]) -> Option<(u32, u32)> {
    let at = a.iter().zip(b).position(|(a, b)| a != b)? as u32;
    Some((at % WIDTH, at / WIDTH))
}

const WHOLE: Grid = Grid { columns: 1, rows: 1 };

#[test]
fn parts_are_the_whole_to_the_byte() {
    for (preset, machine) in [(Preset::Fast, Machine::Gpu), (Preset::Exact, Machine::Cpu)] {
        on_adjusted_device(
            |report| report.machine = machine,
            |device| {
                let mut scene = scene(preset);
                scene.model.samples = Some(if preset == Preset::Exact { 4 } else { 1 });
                let (whole, in_view) = drawn(device, &scene, Output::Display, WHOLE);
                assert!(whole.shown.iter().any(|p| (40..220).contains(&p[0])), "nothing to see");
                let grid = Grid { columns: 3, rows: 2 };
                let (parts, in_parts) = drawn(device, &scene, Output::Display, grid);
                let found = first_difference(&whole.radiance.pixels, &parts.radiance.pixels);
                assert_eq!(found, None, "{preset}: radiance");
                let found = first_difference(&whole.shown, &parts.shown);
                assert_eq!(found, None, "{preset}: display");
                // Each part passes over what the others show.
                assert!(in_parts < 2 * in_view, "{in_parts} drops in view of the parts, {in_view}");
            },
        );
    }
}

/// Streaks in which a bare sun draws lines, across the parts' edges and not.
#[test]
fn parts_have_the_lines_of_the_whole() {
    let sun = DVec3::new(0.3, 0.2, -1.0).normalize();
    let lit = painted(1024, |d| Vec3::splat(if d.dot(sun) > 0.9999 { 3000.0 } else { 0.2 }));
    let dark = painted(64, |_| Vec3::splat(0.2));
    on_device(|device| {
        let mut scene = Scene { rain: None, ..scene(Preset::Fast) };
        scene.camera.shutter = 1.0;
        scene.drops = (0..12)
            .map(|number| {
                let turn = 0.6 * f64::from(number);
                let center = 12.0 * DVec3::new((2.1 * turn).sin(), (3.4 * turn).sin(), 0.0);
                let center = center + DVec3::new(0.0, 0.0, -20.0);
                let velocity = 20.0 * DVec3::new(turn.cos(), turn.sin(), 0.0);
                let radius = 1.0 + 0.1 * f64::from(number);
                PlacedDrop { velocity, ..PlacedDrop::sphere(center - 0.5 * velocity, radius) }
            })
            .collect();
        let by = |light, grid| drawn_in(device, light, &scene, Output::Radiance, grid).0.radiance;
        let (whole, without) = (by(&lit, WHOLE), by(&dark, WHOLE));
        let pairs = whole.pixels.iter().zip(&without.pixels);
        let brighter = pairs.filter(|(a, b)| a.x > b.x + 0.1).count();
        assert!(brighter > 100, "the control: {brighter} pixels show the sun");
        let parts = by(&lit, Grid { columns: 3, rows: 2 });
        assert_eq!(first_difference(&whole.pixels, &parts.pixels), None);
    });
}

/// Flattened drops of real rain, whose rays are spread by chance: exposed, and through a lens.
#[test]
fn parts_of_real_rain_have_the_chances_of_the_whole() {
    on_device(|device| {
        for (preset, rate, shutter, aperture) in [
            (Preset::Fast, 300.0, 1e-3, 0.0),
            (Preset::Fast, 300.0, 1.0 / 60.0, 0.0),
            (Preset::Exact, 60.0, 1e-3, 0.0),
            (Preset::Exact, 60.0, 0.0, 0.02),
        ] {
            let rain =
                RealRain { rate, diameters: [3.0, 6.0], extent: 20.0, ..RealRain::default() };
            let mut scene = Scene { drops: Vec::new(), ..scene(preset) };
            scene.rain = Some(RainSettings::of(rain));
            scene.camera.vertical_fov = 10.0;
            (scene.camera.shutter, scene.camera.aperture) = (shutter, aperture);
            scene.model.samples = Some(2);
            let by = |scene: &Scene, grid| drawn(device, scene, Output::Radiance, grid).0.radiance;
            let whole = by(&scene, WHOLE);
            let dry = by(&Scene { rain: None, ..scene.clone() }, WHOLE);
            let pairs = whole.pixels.iter().zip(&dry.pixels);
            let seen = pairs.filter(|(a, b)| (**a - **b).abs().max_element() > 0.1).count();
            assert!(seen > 100, "the control: drops are seen in {seen} pixels");
            let parts = by(&scene, Grid { columns: 3, rows: 2 });
            let found = first_difference(&whole.pixels, &parts.pixels);
            assert_eq!(found, None, "{preset}, shutter {shutter}, aperture {aperture}");
        }
    });
}

#[test]
fn a_window_is_a_piece_of_the_whole_wherever_it_lies() {
    for preset in [Preset::Fast, Preset::Exact] {
        on_device(|device| {
            let mut scene = scene(preset);
            scene.model.samples = Some(1);
            let (whole, _) = drawn(device, &scene, Output::Display, WHOLE);
            // Not on tiles' edges; and smaller than a part that a whole is drawn in.
            for [left, top, right, bottom] in [[27, 33, 90, 70], [0, 61, WIDTH, 62]] {
                scene.camera.window = [
                    f64::from(left) / f64::from(WIDTH),
                    f64::from(top) / f64::from(HEIGHT),
                    f64::from(right) / f64::from(WIDTH),
                    f64::from(bottom) / f64::from(HEIGHT),
                ];
                let environment = environment();
                let plan = plan(&scene, &environment, Output::Display).expect("a plan");
                let mut parts = Parts::new(device, &environment, &plan);
                let (renderer, report) = parts.draw_window(&scene).expect("a window");
                assert_eq!(report.counts.visible, count_visible(&scene));
                let found = renderer.read_radiance().expect("a picture");
                let shown = renderer.read_display().expect("a picture");
                assert_eq!((found.width, found.height), (right - left, bottom - top));
                let pixels = found.pixels.iter().zip(shown.chunks_exact(3));
                for (at, (pixel, shown)) in (0..).zip(pixels) {
                    let (x, y) = (at % found.width + left, at / found.width + top);
                    let of_whole = (y * WIDTH + x) as usize;
                    assert_eq!(*pixel, whole.radiance.pixels[of_whole], "{preset}: {x}, {y}");
                    assert_eq!(shown, whole.shown[of_whole], "{preset}: {x}, {y}");
                }
            }
        });
    }
}

#[test]
fn the_papers_parts_show_the_same() {
    on_device(|device| {
        let scene = scene(Preset::Paper);
        let (whole, _) = drawn(device, &scene, Output::Display, WHOLE);
        let (parts, _) = drawn(device, &scene, Output::Display, Grid { columns: 2, rows: 2 });
        // Points are placed in fractions of a part, which round otherwise.
        let pairs = whole.shown.as_flattened().iter().zip(parts.shown.as_flattened());
        let differ = pairs.filter(|(a, b)| a.abs_diff(**b) > 2).count();
        let share = differ as f64 / (3 * WIDTH * HEIGHT) as f64;
        assert!(share < 0.02, "{share} of the bytes differ");
    });
}

#[test]
fn the_reference_takes_a_window() {
    let mut scene = scene(Preset::Exact);
    let environment = environment();
    let truth = Truth { samples: 4, ..Truth::default() };
    scene.drops.truncate(2);
    scene.rain.get_or_insert_default().count = 300;
    let whole = Tracer::new(&scene, &environment, truth).picture();
    scene.camera.window = [0.25, 0.5, 0.75, 1.0];
    let part = Tracer::new(&scene, &environment, truth).picture();
    assert_eq!((part.width, part.height), (WIDTH / 2, HEIGHT / 2));
    for (at, pixel) in (0..).zip(&part.pixels) {
        let (x, y) = (at % part.width + WIDTH / 4, at / part.width + HEIGHT / 2);
        assert_eq!(*pixel, whole.pixels[(y * WIDTH + x) as usize], "{x}, {y}");
    }
}

#[test]
fn a_window_falls_on_pixels() {
    let parse = |window: &str| {
        let text = format!("[image]\nwidth = 100\nheight = 10\n[camera]\nwindow = {window}\n");
        Scene::parse(&text, "scene.toml").map_err(|error| error.to_string())
    };
    for (bad, says) in [
        ("[0.0, 0.0, 0.505, 1.0]", "0.5"),
        ("[0.0, 0.33, 1.0, 1.0]", "0.3"),
        ("[0.5, 0.0, 0.5, 1.0]", "left to right"),
        ("[0.0, 0.5, 1.0, 0.2]", "top to bottom"),
        ("[-0.1, 0.0, 1.0, 1.0]", "the first of window = -0.1"),
        ("[0.0, 0.0, 1.0, nan]", "the fourth of window = NaN"),
    ] {
        let error = parse(bad).expect_err(bad);
        assert!(error.contains("scene.toml:5: camera: ") && error.contains("window"), "{error}");
        assert!(error.contains(says), "{error}");
    }
    let scene = parse("[0.25, 0.5, 0.75, 1.0]").expect("a scene");
    assert_eq!(scene.picture_size(), (50, 5));
}
