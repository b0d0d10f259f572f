//! Exposure and lens of the reference: against closed forms, against sums that are written out here, and
//! against the mean of many instants.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::reference::{Eye, Hit, Pyramid, Sample, Sobol, Traced, Tracer, Truth, of_scene};
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common::Random;

/// Focal length in pixels and depth of the drops below: a tenth of a degree of view, where a sphere is a
/// disc.
const FOCAL: f64 = 20_000.0;
const DEPTH: f64 = 2000.0;
/// Scene units a pixel at that depth.
const PIXEL: f64 = DEPTH / FOCAL;

fn white() -> Environment {
    Environment::constant(Vec3::ONE)
}

/// A square picture by a long lens. The middle of its middle pixel is on the axis.
fn far_scene(edge: u32) -> Scene {
    assert_eq!(edge % 2, 1);
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (edge, edge);
    scene.camera.vertical_fov = 2.0 * (0.5 * f64::from(edge) / FOCAL).atan().to_degrees();
    scene
}

/// A disc of `radius` pixels at `at`, right and up of the picture's middle, that moves by `way` pixels around
/// it while the shutter is open.
fn disc(radius: f64, at: [f64; 2], way: [f64; 2]) -> PlacedDrop {
    let [x, y] = [0, 1].map(|axis| (at[axis] - 0.5 * way[axis]) * PIXEL);
    PlacedDrop {
        velocity: DVec3::new(way[0], way[1], 0.0) * PIXEL,
        ..PlacedDrop::sphere(DVec3::new(x, y, -DEPTH), radius * PIXEL)
    }
}

fn traced(scene: &Scene, samples: u32) -> Traced {
    let environment = white();
    Tracer::new(scene, &environment, Truth { samples, ..Truth::default() }).trace(&|_| ())
}

/// Coverage of the pixel `right` and `up` of the middle one.
fn covered(traced: &Traced, right: i32, up: i32) -> f64 {
    let edge = traced.picture.width as i32;
    f64::from(traced.coverage[((edge / 2 - up) * edge + edge / 2 + right) as usize])
}

/// Each pixel's coverage by a moving disc: the share of a fine grid of places and moments that it holds.
fn coverage_by_grid(radius: f64, way: [f64; 2], pixel: [f64; 2]) -> f64 {
    const PLACES: i32 = 100;
    const MOMENTS: i32 = 2000;
    let middle = |number: i32, of: i32| (f64::from(number) + 0.5) / f64::from(of) - 0.5;
    let mut held = 0_u64;
    for moment in 0..MOMENTS {
        let center = way.map(|way| way * middle(moment, MOMENTS));
        if (center[0] - pixel[0]).hypot(center[1] - pixel[1]) > radius + 0.75 {
            continue;
        }
        for place in 0..PLACES * PLACES {
            let x = pixel[0] + middle(place % PLACES, PLACES) - center[0];
            let y = pixel[1] + middle(place / PLACES, PLACES) - center[1];
            held += u64::from(x * x + y * y < radius * radius);
        }
    }
    held as f64 / f64::from(PLACES * PLACES) / f64::from(MOMENTS)
}

#[test]
fn a_streak_covers_what_it_should() {
    // Pixel centre from the streak's middle, length, angle, radius, exact coverage.
    let cases = [
        ([0.0, 0.0], 8.0, 90.0_f64, 0.25, 0.024559),
        ([0.3, 3.0], 8.0, 80.0, 0.25, 0.024577),
        ([0.6, -1.2], 4.0, 60.0, 1.0, 0.096775),
        ([0.0, 4.0], 8.0, 90.0, 0.25, 0.012279),
    ];
    for (pixel, length, angle, radius, exact) in cases {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let way = [length * cosine, length * sine];
        // The sum written out here is the number that was computed elsewhere.
        let by_grid = coverage_by_grid(radius, way, pixel);
        assert!((by_grid - exact).abs() < 2e-4, "{by_grid} is not {exact}");
        // One pixel with many samples; then all, where the disc is seen whole however it moves.
        let mut scene = far_scene(1);
        scene.drops = vec![disc(radius, pixel.map(|offset| -offset), way)];
        scene.camera.shutter = 1.0;
        let found = covered(&traced(&scene, 1 << 17), 0, 0);
        assert!((found - exact).abs() < 3e-4, "{pixel:?}: {found} is not {exact}");
        let mut whole = Scene { drops: scene.drops, ..far_scene(21) };
        whole.camera.shutter = 1.0;
        let traced = traced(&whole, 1024);
        let sum: f64 = traced.coverage.iter().map(|&share| f64::from(share)).sum();
        assert!((sum / (PI * radius * radius) - 1.0).abs() < 0.06, "{sum}");
    }
}

#[test]
fn a_white_drop_on_black_has_the_opacity_of_its_streak() {
    // 2 r / ℓ, which is D / (v T), in the middle of a streak that is wider than a pixel.
    for (radius, length) in [(4.0, 20.0), (4.0, 80.0), (1.5, 30.0)] {
        let mut scene = far_scene(31);
        scene.drops = vec![disc(radius, [0.0, 0.0], [0.0, length])];
        scene.camera.shutter = 1.0;
        let [black, white] = [Environment::constant(Vec3::ZERO), white()];
        let truth = Truth { samples: 1024, ..Truth::default() };
        let color = raindrops::picture::Picture {
            width: 31,
            height: 31,
            pixels: vec![Vec3::ZERO; 31 * 31],
        };
        let plate = raindrops::picture::plate::Plate::new(Some(color), None);
        let on_black = Tracer::new(&scene, &white, truth).before(plate).trace(&|_| ());
        let middle = f64::from(on_black.picture.pixels[15 * 31 + 15].x);
        // The chord's mean over the pixel's width: by its second derivative, r (1 - 1/(24 r²)).
        let opacity = 2.0 * radius * (1.0 - 1.0 / (24.0 * radius * radius)) / length;
        assert!((middle / opacity - 1.0).abs() < 0.03, "{middle} is not {opacity}");
        // The control: black drops on the white furnace's plate are not there.
        assert_eq!(Tracer::new(&scene, &black, truth).picture().pixels[15 * 31 + 15], Vec3::ZERO);
    }
}

#[test]
fn blurred_discs_cover_what_they_should() {
    // Blur-circle radii in pixels: f (A/2) |1/z - 1/focus|.
    let blur = |focal: f64, aperture: f64, depth: f64, focus: f64| {
        focal * 0.5 * aperture * (1.0 / depth - 1.0 / focus).abs()
    };
    assert!((blur(886.81001, 7.4e-3, 1.0, 5.0) - 2.624958).abs() < 1e-4);
    assert!((blur(886.81001, 2.6e-3, 3.0, f64::INFINITY) - 0.384284).abs() < 1e-4);
    // Ten times the size of the table's, so that a pixel is nearly a point of it: radius, blur, distance,
    // coverage. In focus before it, and at infinity.
    for (radius, circle, at, expected) in
        [(10.0, 30.0, 0, 0.111111), (10.0, 30.0, 25, 0.086458), (20.0, 15.0, 10, 0.834888)]
    {
        for focus in [0.4 * DEPTH, f64::INFINITY] {
            let mut scene = far_scene(101);
            scene.drops = vec![disc(radius, [0.0, 0.0], [0.0, 0.0])];
            scene.camera.focus = focus;
            scene.camera.aperture = circle / blur(FOCAL, 1.0, DEPTH, focus);
            let traced = traced(&scene, 128);
            for (right, up) in [(at, 0), (0, at), (-at, 0), (0, -at)] {
                let found = covered(&traced, right, up);
                // A pixel has 128 samples; and the curve within a pixel.
                assert!((found - expected).abs() < 0.025, "focus {focus}: {found}, {expected}");
            }
            let sum: f64 = traced.coverage.iter().map(|&share| f64::from(share)).sum();
            // Some 3000 pixels of a ninth, each off by up to 0.03.
            assert!((sum / (PI * radius * radius) - 1.0).abs() < 0.015, "{sum}");
        }
    }
    // In focus, a lens of any size draws the pinhole's picture.
    let mut scene = far_scene(31);
    scene.drops = vec![disc(10.0, [0.0, 0.0], [0.0, 0.0])];
    let sharp = traced(&scene, 1024);
    (scene.camera.focus, scene.camera.aperture) = (DEPTH, 30.0);
    let focused = traced(&scene, 1024);
    for (a, b) in sharp.coverage.iter().zip(&focused.coverage) {
        assert!((a - b).abs() < 0.03, "{a} {b}");
    }
}

/// Edge of the pictures of [`busy_scene`].
const EDGE: u32 = 24;

/// Rain in a small box that it crosses within the exposure, placed drops of all shapes, near and far, oblique
/// and towards the camera.
fn busy_scene() -> Scene {
    let mut scene = Scene::default();
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene.camera.vertical_fov = 70.0;
    let velocity = DVec3::new(9.0, -30.0, 4.0);
    scene.rain = Some(RainSettings {
        count: 300,
        half_extent: DVec3::new(20.0, 14.0, 20.0),
        radius: 0.6,
        velocity,
        ..RainSettings::default()
    });
    let moving = |center: [f64; 3], velocity: [f64; 3], axis_ratio: f64| PlacedDrop {
        axis_ratio: Some(axis_ratio),
        velocity: velocity.into(),
        ..PlacedDrop::sphere(center.into(), 0.5)
    };
    scene.drops = vec![
        moving([-1.0, 1.0, -3.0], [1.5, -1.0, 0.0], 0.7),
        moving([0.4, 0.2, -6.0], [0.0, 0.0, 4.0], 1.0),
        moving([1.5, -0.5, -4.0], [-1.0, 1.0, -3.0], 1.5),
    ];
    scene
}

/// A slope of grey, brighter above.
fn slope() -> Environment {
    let row = |row: u32| vec![Vec3::splat(1.5 - row as f32 / 32.0); 64];
    Environment::from_texels("slope", 64, 32, (0..32).flat_map(row).collect()).expect("valid")
}

#[test]
fn an_exposure_is_the_mean_of_its_instants() {
    const INSTANTS: u32 = 128;
    let environment = slope();
    let trace = |scene: &Scene, samples: u32, seed: u64| -> Vec<DVec3> {
        let truth = Truth { samples, seed, ..Truth::default() };
        let Traced { picture, coverage, .. } =
            Tracer::new(scene, &environment, truth).trace(&|_| ());
        let both = picture.pixels.iter().zip(coverage);
        both.map(|(pixel, share)| DVec3::new(pixel.x.into(), pixel.y.into(), share.into()))
            .collect()
    };
    let (shutter, pace) = (0.5, -1.3);
    let mut scene = Scene { time: 3.0, pace, ..busy_scene() };
    let mut mean = vec![DVec3::ZERO; (EDGE * EDGE) as usize];
    for instant in 0..INSTANTS {
        let time = 3.0 + shutter * pace * (f64::from(instant) + 0.5) / f64::from(INSTANTS);
        let traced = trace(&Scene { time, ..scene.clone() }, 4, instant.into());
        for (sum, pixel) in mean.iter_mut().zip(traced) {
            *sum += pixel / f64::from(INSTANTS);
        }
    }
    let apart = |scene: &Scene| {
        let traced = trace(scene, 512, 0);
        let squares =
            traced.iter().zip(&mean).map(|(pixel, mean)| (*pixel - *mean).length_squared());
        (squares.sum::<f64>() / mean.len() as f64).sqrt()
    };
    scene.camera.shutter = shutter;
    let right = apart(&scene);
    // The controls: an exposure of another length, and the other way around.
    let short = apart(&Scene { pace: 0.8 * pace, ..scene.clone() });
    let backwards = apart(&Scene { pace: -pace, ..scene.clone() });
    println!("{right:.4}; shorter {short:.4}, backwards {backwards:.4}");
    assert!(right < 0.012 && short > 3.0 * right && backwards > 6.0 * right);
}

#[test]
fn without_an_exposure_the_picture_is_the_instants_to_the_bit() {
    let environment = slope();
    let truth = Truth { samples: 5, ..Truth::default() };
    let mut scene = busy_scene();
    let instant = Tracer::new(&scene, &environment, truth).trace(&|_| ());
    // Nothing that is exposed moves; the pace is 0; the shutter opens for no time.
    scene.camera.shutter = 0.5;
    let hanging = Scene { pace: 0.0, ..scene.clone() };
    assert_eq!(Tracer::new(&hanging, &environment, truth).trace(&|_| ()), instant);
    scene.camera.shutter = 0.0;
    scene.camera.shutter_angle = Some(0.0);
    assert_eq!(Tracer::new(&scene, &environment, truth).trace(&|_| ()), instant);
    // The control.
    scene.camera.shutter_angle = Some(180.0);
    assert_ne!(Tracer::new(&scene, &environment, truth).trace(&|_| ()), instant);
    // An exposure so short that nothing moves differs by its samples alone.
    scene.camera.shutter_angle = None;
    scene.camera.shutter = 1e-9;
    let truth = Truth { samples: 1024, ..truth };
    let short = Tracer::new(&scene, &environment, truth).picture();
    scene.camera.shutter = 0.0;
    let long = Tracer::new(&scene, &environment, truth).picture();
    let squares = short.pixels.iter().zip(&long.pixels).map(|(a, b)| (*a - *b).length_squared());
    let rms = (squares.sum::<f32>() / (3 * EDGE * EDGE) as f32).sqrt();
    assert!(rms < 2e-3, "{rms}");
}

#[test]
fn an_exposure_does_not_depend_on_the_threads() {
    let environment = slope();
    let mut scene = busy_scene();
    (scene.camera.shutter, scene.camera.aperture) = (0.3, 0.2);
    let truth = Truth { samples: 5, ..Truth::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| Tracer::new(&scene, &environment, truth).trace(&|_| ()))
    };
    assert_eq!(on(1), on(3));
}

/// The rays of a tile meet what all rays may meet, wherever on the lens and whenever they start.
#[test]
fn a_tiles_candidates_hold_all_that_its_rays_meet() {
    let mut scene = busy_scene();
    scene.camera.shutter = 0.6;
    let mut random = Random(2);
    let mut met = 0;
    for (aperture, focus) in [(0.0, 5.0), (1.0, 3.0), (0.4, 0.7), (1.0, f64::INFINITY)] {
        (scene.camera.aperture, scene.camera.focus) = (aperture, focus);
        let environment = white();
        let tracer = Tracer::new(&scene, &environment, Truth::default());
        let eye = Eye::of_scene(&scene);
        let mut candidates = Vec::new();
        for tile in 0..9 {
            let (left, upper) = (tile % 3 * 8, tile / 3 * 8);
            let corner = |x: u32, y: u32| eye.view.ray(f64::from(left + x), f64::from(upper + y));
            let corners = [corner(0, 0), corner(8, 0), corner(8, 8), corner(0, 8)];
            let pyramid = Pyramid::between(corners).through(&eye);
            tracer.tree().within(&pyramid, f64::INFINITY, &mut candidates);
            for _ in 0..500 {
                let (radius, angle) = (random.unit().sqrt(), 2.0 * PI * random.unit());
                let lens = radius * glam::DVec2::from_angle(angle);
                let sample = Sample {
                    x: 8.0 * random.unit(),
                    y: 8.0 * random.unit(),
                    lens,
                    moment: random.unit(),
                };
                let ray = eye.ray(left, upper, &sample);
                let all = tracer.tree().first_hit(&ray, Hit::START, None);
                let of_tile = tracer.tree().first_hit_of(&candidates, &ray, Hit::START);
                assert_eq!(all, of_tile);
                // And what all drops, one by one, say.
                let numbers = 0..tracer.tree().drops().all.len() as u32;
                let brute = numbers
                    .filter_map(|drop| {
                        tracer.tree().meet(drop, &ray).map(|distance| Hit { distance, drop })
                    })
                    .fold(Hit::NONE, |a, b| if b < a { b } else { a });
                assert_eq!(all, brute);
                met += u32::from(all != Hit::NONE);
            }
        }
    }
    assert!(met > 3000, "only {met} met");
}

/// What is in focus is where the pinhole sees it, and a lens sees the sky blurred.
#[test]
fn a_lens_blurs_the_environment() {
    // White above the horizon, black below.
    let texels = (0..512 * 256).map(|index| Vec3::splat(f32::from(u8::from(index / 512 < 128))));
    let sky = Environment::from_texels("halves", 512, 256, texels.collect()).expect("valid");
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (9, 65);
    (scene.camera.aperture, scene.camera.focus) = (1.0, 1.0);
    let truth = Truth { samples: 256, ..Truth::default() };
    let picture = Tracer::new(&scene, &sky, truth).picture();
    let focal = scene.view().focal_px;
    for row in 0..65 {
        // A ray rises where its lens place is below the place in focus: share of the disc of radius 1/2.
        let height = ((32.0 - f64::from(row)) / focal / 0.5).clamp(-1.0, 1.0);
        let expected = 0.5 + (height.asin() + height * (1.0 - height * height).sqrt()) / PI;
        let found = f64::from(picture.pixels[row as usize * 9 + 4].x);
        assert!((found - expected).abs() < 0.02, "row {row}: {found}, {expected}");
    }
}

#[test]
fn drops_that_cross_a_wall_come_in_at_the_other() {
    let mut scene = busy_scene();
    scene.camera.shutter = 3.0;
    scene.drops.clear();
    let drops = of_scene(&scene);
    let half_extent = DVec3::new(20.0, 14.0, 20.0);
    assert!(drops.all.len() > 5 * 300, "{} images", drops.all.len());
    for step in 0..=40 {
        let moment = (f64::from(step) + 0.5) / 41.0;
        let inside = drops.all.iter().filter(|drop| {
            let center = drops.center(drop, moment);
            center.cmpge(-half_extent).all() && center.cmplt(half_extent).all()
        });
        // Each drop by one image at every moment.
        assert_eq!(inside.count(), 300);
    }
}

#[test]
fn sobol_points_fill_every_dimension_and_pair() {
    for pixel in [0, 1, 77] {
        let points: Vec<_> = Sobol::new(256, 3).points(pixel).collect();
        for axis in 0..5 {
            let mut strata: Vec<_> = points.iter().map(|p| (p[axis] * 256.0) as u32).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..256).collect::<Vec<_>>(), "axis {axis}");
        }
        // Place in the pixel: one point in each of the 16 x 16 cells, and of all other elementary ones.
        for (columns, rows) in [(16.0, 16.0), (4.0, 64.0), (128.0, 2.0)] {
            let mut cells: Vec<_> = points
                .iter()
                .map(|p| (p[1] * rows) as u32 * columns as u32 + (p[0] * columns) as u32)
                .collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..256).collect::<Vec<_>>());
        }
        // Other pairs: no cell of 8 x 8 holds over thrice its share.
        for (a, b) in [(0, 2), (1, 2), (2, 3), (2, 4), (3, 4), (0, 3), (1, 4)] {
            let mut cells = [0; 64];
            for p in &points {
                cells[(p[a] * 8.0) as usize * 8 + (p[b] * 8.0) as usize] += 1;
            }
            assert!(cells.iter().all(|&count| count <= 12), "{a} {b}: {cells:?}");
        }
    }
    // Unbiased, one point by itself, and different in every pixel.
    let mean: DVec3 = (0..4096)
        .map(|pixel| {
            let point = Sobol::new(1, 3).points(pixel).next().expect("a point");
            DVec3::new(point[0], point[2], point[4])
        })
        .sum::<DVec3>()
        / 4096.0;
    assert!((mean - 0.5).abs().max_element() < 5.0 * 0.29 / 64.0, "{mean}");
}

/// Less noise than of samples that are stratified in no way: that is what the points are for.
#[test]
fn the_noise_of_a_streak_is_under_that_of_chance() {
    let mut scene = far_scene(31);
    scene.drops = vec![disc(1.0, [0.3, 0.2], [9.0, 14.0])];
    scene.camera.shutter = 1.0;
    let environment = white();
    let picture = |seed| {
        let truth = Truth { samples: 256, seed, ..Truth::default() };
        Tracer::new(&scene, &environment, truth).trace(&|_| ()).coverage
    };
    let (a, b) = (picture(1), picture(2));
    let (mut squares, mut by_chance) = (0.0, 0.0);
    for (a, b) in a.iter().zip(&b).map(|(a, b)| (f64::from(*a), f64::from(*b))) {
        let share = 0.5 * (a + b);
        squares += (a - b).powi(2);
        by_chance += 2.0 * share * (1.0 - share) / 256.0;
    }
    let ratio = (squares / by_chance).sqrt();
    println!("{ratio:.3} of the noise of chance");
    assert!(ratio < 0.75, "{ratio}");
}
