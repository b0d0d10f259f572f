//! Real rain as a picture sees it: on the CPU against the law and against every cell near the camera, on the device
//! against the CPU.

use std::sync::Arc;

use crate::common::bow::{self, DISC, INDEX, bow_of_a_point, over_the_disc};
use crate::common::picture::{draw, renderer, renderer_of};
use crate::common::{on_device, painted};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::plan::{Cutoff, Output, plan};
use raindrops::rain::cull::{Sight, Visibility};
use raindrops::rain::field::{Field, MOST_GROUPS, MOST_SLABS};
use raindrops::rain::tick_of_seconds;
use raindrops::rain::visibility::Frustum;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::model::{DropShape, FarRain, Motion, Preset, Weights};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::water::Index;
use raindrops::scene::{ImageSize, RainSettings, Scene};

/// Rain before a camera that looks aslant, with drops of over 0.2 pixels.
fn aslant(rate: f64) -> Scene {
    let mut scene = Scene {
        seed: 7,
        time: 12.345,
        rain: Some(RainSettings::of(RealRain { rate, extent: 60.0, ..RealRain::default() })),
        image: ImageSize { width: 320, height: 200 },
        ..Scene::default()
    };
    scene.camera.position = DVec3::new(3.3, 1.6, -7.7);
    scene.camera.target = DVec3::new(5.0, 2.5, -10.0);
    scene.camera.vertical_fov = 50.0;
    scene.model.preset = Preset::Fast;
    scene.model.cutoff_px = Some(0.2);
    scene
}

fn in_view(scene: &Scene) -> u64 {
    let cutoff_px = scene.model.cutoff_px.expect("a cut-off");
    Field::of(scene).expect("rain").count_visible(scene, cutoff_px)
}

#[test]
fn as_many_drops_are_in_view_as_the_law_has() {
    // Many pictures of other rain, so that the error is small.
    let mut scene = aslant(50.0);
    let pictures = 40;
    let mut found = 0;
    for seed in 0..pictures {
        scene.seed = seed;
        found += in_view(&scene);
    }
    let rain = scene.real_rain().expect("rain");
    let frustum = Frustum::of(&scene.view(), rain.extent);
    let expected = pictures as f64 * frustum.drops_above(&rain.law(), 0.2);
    // Drops whose centre is just beyond the picture's edge count as in view: a pixel more all around.
    let off = found as f64 - expected;
    assert!(off > -4.0 * expected.sqrt() && off < 0.02 * expected, "{found}, not {expected}");
}

/// Each drop near the camera, found by looking into all cells around it.
fn brute_force(scene: &Scene) -> Vec<[u32; 3]> {
    let rain = scene.real_rain().expect("rain");
    let view = scene.view();
    let sight = Sight::new(&view, 0.0);
    let mut found = Vec::new();
    for lattice in rain.lattices(scene.seed) {
        let camera = lattice.place(scene.camera.position, tick_of_seconds(scene.time));
        let far = view.focal_px * lattice.radius / 0.2 * 1.3 + 2.0 * lattice.edge();
        let cells = (far / lattice.edge()).ceil() as i64;
        for number in 0..(2 * cells + 1).pow(3) {
            let along = |n: i64| n % (2 * cells + 1) - cells;
            let edge = 2 * cells + 1;
            let offset = [along(number), along(number / edge), along(number / edge / edge)];
            let cell = [0, 1, 2].map(|axis: usize| camera.cell[axis].wrapping_add(offset[axis]));
            for drop in lattice.drops(cell) {
                let at = lattice.between(&camera, &drop.place);
                let depth = -at.dot(view.back);
                let radius = 0.5e-3 * drop.diameter_mm();
                let seen = sight.visibility(sight.view_space(at.as_vec3()), radius as f32);
                if seen == Visibility::Visible && radius * view.focal_px >= 0.2 * depth {
                    found.push((at * 1e4).round().as_ivec3().to_array().map(|x| x as u32));
                }
            }
        }
    }
    found.sort_unstable();
    found
}

#[test]
fn the_cells_in_view_hold_every_drop_in_view() {
    let mut scene = aslant(100.0);
    scene.image = ImageSize { width: 160, height: 100 };
    for (target, up) in [
        (DVec3::new(5.0, 2.5, -10.0), DVec3::Y),
        (DVec3::new(3.3, 9.0, -7.7), DVec3::Z),
        (DVec3::new(-3.0, 0.0, -7.6), DVec3::Y),
    ] {
        scene.camera.target = target;
        scene.camera.up = up;
        assert_eq!(in_view(&scene), brute_force(&scene).len() as u64, "towards {target}");
    }
}

#[test]
fn the_device_finds_the_drops_that_the_cpu_finds() {
    on_device(|device| {
        // The last: drops end where the rain ends.
        for (rate, time, cutoff, extent) in [
            (25.0, 12.345, 0.2, 60.0),
            (100.0, -1e9, 0.05, 60.0),
            (1.0, 0.0, 0.1, 60.0),
            (25.0, 3.0, 0.02, 3.0),
        ] {
            let mut scene = aslant(rate);
            scene.rain.get_or_insert_default().real.as_mut().expect("rain").extent = extent;
            scene.time = time;
            scene.model.cutoff_px = Some(cutoff);
            scene.camera.position += DVec3::new(1e9, 0.0, -1e9);
            scene.camera.target += DVec3::new(1e9, 0.0, -1e9);
            let white = Environment::constant(Vec3::ONE);
            let mut renderer = renderer(device, &scene, &white);
            renderer.submit(&scene).expect("a frame");
            let report = renderer.finish().expect("a report");
            assert_eq!(report.counts.visible, in_view(&scene), "{rate} mm/h at {time} s");
            assert_eq!(report.counts.overflow, 0);
        }
    });
}

/// A lens of 0.2° sees so deep that the cells in view are too many: the drops over a larger cut-off are drawn.
#[test]
fn cells_that_cannot_be_numbered_move_into_the_medium() {
    let mut scene = aslant(25.0);
    scene.rain.get_or_insert_default().real.as_mut().expect("rain").extent = f64::INFINITY;
    scene.image = ImageSize { width: 1024, height: 1024 };
    scene.camera.vertical_fov = 0.2;
    scene.model.cutoff_px = Some(0.02);
    let seen = Field::of(&scene).expect("rain").seen(&scene, 0.02);
    assert!(seen.cutoff_px > 0.02 && seen.medium.is_some(), "{}", seen.cutoff_px);
    assert!(seen.slabs.len() <= MOST_SLABS && seen.groups() as usize <= MOST_GROUPS);
    let white = Environment::constant(Vec3::ONE);
    let cutoff = plan(&scene, &white, Output::Radiance).expect("a plan").cutoff.expect("a cut-off");
    let planned = Field::of(&scene).expect("rain").seen(&scene, cutoff.px);
    assert_eq!(cutoff.px as f32, planned.cutoff_px);
    assert!(cutoff.why.contains("more cells of the rain than can be numbered"), "{}", cutoff.why);
    // A usual lens sees what was asked for.
    scene.camera.vertical_fov = 60.0;
    assert_eq!(Field::of(&scene).expect("rain").seen(&scene, 0.05).cutoff_px, 0.05);
}

/// The picture of `scene` in an environment, linear.
fn picture(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> Picture {
    draw(&mut renderer(device, scene, environment), scene).0
}

#[test]
fn rain_and_medium_in_white_are_white() {
    on_device(|device| {
        let mut scene = aslant(100.0);
        scene.rain.get_or_insert_default().real.as_mut().expect("rain").extent = f64::INFINITY;
        scene.model.weights = Some(Weights::Conserving);
        for preset in [Preset::Fast, Preset::Exact] {
            scene.model.preset = preset;
            let picture = picture(device, &scene, &Environment::constant(Vec3::ONE));
            for (number, pixel) in picture.pixels.iter().enumerate() {
                assert!((*pixel - 1.0).abs().max_element() < 8e-3, "{preset}: {number} is {pixel}");
            }
        }
    });
}

/// Drops are white before black, so a pixel is their opacity, nearly. Mean of a picture, and its standard deviation.
fn opacity(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> (f64, f64) {
    let picture = picture(device, scene, environment);
    let opacities: Vec<f64> = picture.pixels.iter().map(|pixel| f64::from(pixel.y)).collect();
    let mean = opacities.iter().sum::<f64>() / opacities.len() as f64;
    let squares = opacities.iter().map(|opacity| (opacity - mean).powi(2)).sum::<f64>();
    (mean, (squares / opacities.len() as f64).sqrt())
}

#[test]
fn a_medium_is_as_opaque_as_its_drops() {
    on_device(|device| {
        // Flattened drops are narrower seen level than from below.
        let (level, up) = (-DVec3::Z, DVec3::new(0.0, 0.98, -0.2));
        for (rate, fov, extent, toward) in [
            (5.0, 2.0, 40.0, level),
            (25.0, 4.0, 40.0, level),
            (100.0, 3.0, 40.0, level),
            (100.0, 3.0, 40.0, up),
            (100.0, 90.0, 5.0, level),
        ] {
            let inside = 20f64.to_radians().cos() * toward.length();
            let black = painted(1024, |d| Vec3::splat(f32::from(d.dot(toward) < inside)));
            let mut scene = aslant(rate);
            scene.rain.get_or_insert_default().real.as_mut().expect("rain").extent = extent;
            scene.image = ImageSize { width: 64, height: 64 };
            scene.camera.target = scene.camera.position + toward;
            scene.camera.vertical_fov = fov;
            let pictures = 3;
            let mut means = [0.0; 2];
            let mut errors = [0.0; 2];
            for (kind, far_rain) in [FarRain::Medium, FarRain::Drops].into_iter().enumerate() {
                scene.model.far_rain = Some(far_rain);
                scene.model.cutoff_px = (far_rain == FarRain::Medium).then_some(0.5);
                for seed in 0..pictures {
                    scene.seed = seed;
                    let (mean, deviation) = opacity(device, &scene, &black);
                    means[kind] += mean / pictures as f64;
                    errors[kind] += (deviation / 64.0 / pictures as f64).powi(2);
                }
            }
            let error = (errors[0] + errors[1]).sqrt();
            let off = (means[0] - means[1]).abs();
            println!("{rate} mm/h, {fov}°, {toward}: {means:?}, error {error}");
            assert!(off < 4.0 * error, "{rate} mm/h, {fov}°: {means:?}, error {error}");
        }
    });
}

/// The rain has no drop that is drawn by itself: as much light passes as its law's extinction lets through.
#[test]
fn a_medium_of_all_drops_is_as_opaque_as_its_law_says() {
    on_device(|device| {
        let mut scene = aslant(25.0);
        let rain = scene.rain.get_or_insert_default().real.as_mut().expect("rain");
        (rain.extent, rain.shape) = (400.0, DropShape::Sphere);
        let expected = 1.0 - (-rain.law().extinction() * rain.extent).exp();
        scene.image = ImageSize { width: 16, height: 16 };
        scene.model.far_rain = Some(FarRain::Medium);
        scene.model.cutoff_px = Some(1e3);
        let white = Environment::constant(Vec3::ONE);
        let mut renderer = renderer_of(device, &scene, &white, Output::Layers);
        renderer.submit(&scene).expect("a frame");
        for [.., alpha] in renderer.read_layers().expect("layers").color {
            let off = alpha.to_f64() / expected - 1.0;
            assert!(off.abs() < 0.004, "{alpha}, not {expected}");
        }
    });
}

/// Rain so dense that nothing behind it shows, as the reference has its light.
#[test]
fn far_rain_has_the_light_of_far_drops() {
    let sky = painted(256, |d| Vec3::new(1.0 + 0.9 * d.y as f32, 1.0 - 0.9 * d.x as f32, 1.0));
    let mut scene = aslant(2000.0);
    let rain = scene.rain.get_or_insert_default().real.as_mut().expect("rain");
    (rain.extent, rain.shape) = (1e5, DropShape::Sphere);
    scene.image = ImageSize { width: 24, height: 16 };
    scene.model.cutoff_px = Some(1.0);
    // Nearer than this are the drops that would be shown by themselves.
    scene.camera.near = 0.2;
    let truth = Truth { samples: 600, rain_to: Some(0.01), ..Truth::default() };
    let expected = Tracer::new(&scene, &sky, truth).picture();
    on_device(|device| {
        let found = picture(device, &scene, &sky);
        for (number, (found, expected)) in found.pixels.iter().zip(&expected.pixels).enumerate() {
            let off = (*found - *expected).abs().max_element() / expected.max_element();
            assert!(off < 0.03, "{number}: {found}, not {expected}");
        }
        // The sum over all pixels has less of the reference's noise.
        let [found, expected] =
            [found, expected].map(|picture| picture.pixels.iter().sum::<Vec3>());
        let off = (found / expected - 1.0).abs().max_element();
        println!("the light is off by {off:.4}");
        assert!(off < 0.006, "off by {off}");
    });
}

#[test]
fn the_cut_off_follows_contrast_and_error() {
    let cutoff = |scene: &Scene, sky: &Environment| {
        Cutoff::of(scene, &scene.real_rain().expect("rain"), sky).px
    };
    let mut scene = aslant(25.0);
    scene.model.cutoff_px = None;
    // Black and white have the most contrast that there is, half.
    let sky = painted(256, |d| if d.y > 0.0 { Vec3::splat(1e6) } else { Vec3::ZERO });
    let is = |found: f64, covered: f64| {
        let radius = (covered / std::f64::consts::PI).sqrt();
        assert!((found / radius - 1.0).abs() < 0.05, "{found}, not {radius}");
    };
    is(cutoff(&scene, &sky), 2.0 / 255.0);
    is(cutoff(&scene, &Environment::constant(Vec3::ONE)), 10.0 / 255.0);
    scene.model.error = Some(0.05);
    is(cutoff(&scene, &sky), 2.0 * 0.05);
    scene.model.error = None;
    // Streaks are seen together, before an even sky too; slow motion keeps its drops. Shorter exposures have drops.
    scene.camera.shutter = 1e-4;
    is(cutoff(&scene, &Environment::constant(Vec3::ONE)), 10.0 / 255.0);
    scene.camera.shutter = 0.02;
    is(cutoff(&scene, &sky), 2.0 / 255.0);
    is(cutoff(&scene, &Environment::constant(Vec3::ONE)), 1.0 / 0.45 / 255.0);
    scene.pace = 1e-3;
    is(cutoff(&scene, &Environment::constant(Vec3::ONE)), 1.0 / 0.45 / 255.0);
    scene.model.motion = Some(Motion::Instant);
    is(cutoff(&scene, &Environment::constant(Vec3::ONE)), 10.0 / 255.0);
}

#[test]
fn the_bow_stands_where_it_should() {
    let sun = DVec3::new(0.0, 0.3, 1.0).normalize();
    let sky = |d: DVec3| {
        let is_sun = d.dot(sun) > DISC.to_radians().cos();
        Vec3::splat(if is_sun { 1e5 } else { 0.1 })
    };
    let environment = painted(4096, sky);
    on_device(|device| {
        let mut scene = aslant(25.0);
        scene.rain.get_or_insert_default().real.as_mut().expect("rain").extent = 3000.0;
        scene.water.index = Some(Index::One(INDEX));
        scene.image = ImageSize { width: 16, height: 1200 };
        // The middle of the picture is 42° over the antisolar point.
        let up = DVec3::Y.reject_from(sun).normalize();
        let (sine, cosine) = 42f64.to_radians().sin_cos();
        scene.camera.target = scene.camera.position - 10.0 * (cosine * sun - sine * up);
        scene.camera.vertical_fov = 10.0;
        scene.model.cutoff_px = Some(1.0);
        let picture = picture(device, &scene, &environment);
        let view = scene.view();
        let of_row = |row: usize| -> f32 {
            let mut row: Vec<f32> = (0..16).map(|x| picture.pixels[16 * row + x].y).collect();
            // No drop: the median.
            row.sort_by(f32::total_cmp);
            row[8]
        };
        let brightest = (0..1200).max_by(|a, b| of_row(*a).total_cmp(&of_row(*b))).expect("rows");
        let found = view.ray(8.0, brightest as f64 + 0.5).dot(-sun).acos().to_degrees();
        let expected = bow::brightest(&over_the_disc(&bow_of_a_point()));
        assert!((found - expected).abs() < 0.1, "{found}°, not {expected}°");
    });
}
