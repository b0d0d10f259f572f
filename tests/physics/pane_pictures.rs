//! Pictures through a pane, by the reference: what a dry pane does, what a drop takes of the light, the lens, the plate, rain
//! behind it; against closed forms, and light that knows where it comes from.

use glam::{DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::optics::Cap;
use raindrops::picture::Picture;
use raindrops::picture::plate::Plate;
use raindrops::reference::{Eye, Samples, Traced, Tracer, Truth};
use raindrops::scene::Scene;

use crate::pane::{GLASS, WATER, close, dry, incident, light, same, scene, telling, world};

fn picture(scene: &Scene, environment: &Environment, truth: Truth) -> Traced {
    Tracer::new(scene, environment, truth).trace(&|_| ())
}

#[test]
fn a_dry_pane_dims_and_does_nothing_else() {
    let environment = telling();
    let camera = "position = [0.1, 0.2, 1]\ntarget = [0.4, 0.3, 0]\nvertical_fov = 80";
    let mut with = scene("thickness = 0.005", "", camera);
    (with.image.width, with.image.height) = (24, 16);
    let mut without = with.clone();
    without.pane = None;
    let truth = Truth { samples: 1, ..Truth::default() };
    let [dimmed, bright] = [&with, &without].map(|scene| picture(scene, &environment, truth));
    let (eye, samples) = (Eye::of_scene(&with), Samples::new(1, 0, false));
    let mut places = Vec::new();
    for (number, (dimmed, bright)) in
        (0..).zip(dimmed.picture.pixels.iter().zip(&bright.picture.pixels))
    {
        samples.of_pixel(number, &mut places);
        let ray = eye.ray(number % 24, number / 24, &places[0]);
        let through = dry(-ray.direction.z);
        let apart = (dimmed.as_dvec3() - through * bright.as_dvec3()).abs().max_element();
        assert!(apart < 1e-6, "{number}: {dimmed} for {bright}");
    }
    for (opacity, coverage) in dimmed.opacity.iter().zip(&dimmed.coverage) {
        assert!((0.08..0.5).contains(opacity) && *coverage == 0.0);
    }
    if let Some(pane) = &mut with.pane {
        pane.index = 1.0;
    }
    let clear = picture(&with, &environment, truth);
    for (clear, bright) in clear.picture.pixels.iter().zip(&bright.picture.pixels) {
        assert!((*clear - *bright).abs().max_element() < 1e-6);
    }
    for (i, wanted) in [(0.0, 0.918_318), (30.0, 0.915_446), (60.0, 0.830_693), (80.0, 0.437_866)] {
        let white = Environment::constant(Vec3::ONE);
        let found = light("", "", incident(i, 0.0), DVec2::new(30.0, 0.0), &white, 8).x;
        close(found, wanted, 1e-6, "T");
        close(dry(f64::to_radians(i).cos()), wanted, 1e-6, "T of the test");
    }
}

#[test]
fn a_thick_pane_shifts_where_a_drop_is_seen() {
    let white = Environment::constant(Vec3::ONE);
    let way = incident(60.0, 0.0);
    // Straight on the ray would come to x = 0; 5 mm of glass shift it back by 5.193822 mm.
    let eye = world(-0.1 * way);
    let seen = |x: f64| {
        let drop = format!("[[pane.drop]]\nat = [{x:?}, 0]\nradius = 3e-9");
        let camera = format!("position = [{:?}, {:?}, {:?}]", eye.x, eye.y, eye.z);
        let scene = scene("thickness = 0.005", &drop, &camera);
        let seen = Tracer::new(&scene, &white, Truth::default()).radiance_along(world(way)).x;
        (seen - 0.830_693).abs() > 1e-3
    };
    assert!(seen(-5.193_822e-3));
    assert!(!seen(-5.193_832e-3) && !seen(-5.193_812e-3) && !seen(0.0));
}

/// One drop of radius 1 from afar, all of it in the picture, at an angle to the normal.
fn from_afar(drops: &str, inside: f64, angle: f64) -> Scene {
    let eye = world(-400.0 * incident(angle, 0.0));
    let camera = format!(
        "position = [{:?}, {:?}, {:?}]\ntarget = [0, 0, 0]\nvertical_fov = 0.46",
        eye.x, eye.y, eye.z
    );
    let mut scene =
        scene(&format!("thickness = 0.0\ninside = [{inside}, {inside}, {inside}]"), drops, &camera);
    (scene.image.width, scene.image.height) = (40, 40);
    scene
}

#[test]
fn a_furnace_stays_white() {
    let white = Environment::constant(Vec3::ONE);
    let one =
        |angle: f64| format!("[[pane.drop]]\nat = [0, 0]\nradius = 1\ncontact_angle = {angle}");
    let mixed = "[[pane.drop]]\nat = [-0.5, 0]\nradius = 0.5\ncontact_angle = 35\n[[pane.drop]]\nat = [0.5, 0.3]\nradius = 0.4\n\
                 contact_angle = 80\n[[pane.drop]]\nat = [0.3, -0.7]\nradius = 0.3\ncontact_angle = 100";
    for (drops, angle, orders, worst, mean) in [
        (one(60.0), 0.0, 8, 1e-4, 1e-6),
        (one(90.0), 0.0, 8, 0.5, 2e-2),
        (mixed.to_string(), 50.0, 8, 0.5, 2e-3),
        (mixed.to_string(), 50.0, 300, 1e-3, 1e-5),
    ] {
        let truth = Truth { samples: 4, internal_reflections: orders, ..Truth::default() };
        let pixels = picture(&from_afar(&drops, 1.0, angle), &white, truth).picture.pixels;
        let lost: Vec<f64> = pixels.iter().map(|pixel| 1.0 - f64::from(pixel.x)).collect();
        let (most, least) =
            (lost.iter().copied().fold(0.0, f64::max), lost.iter().copied().fold(0.0, f64::min));
        assert!(most < worst && least > -1e-6, "{drops}: {most} {least}");
        let average = lost.iter().sum::<f64>() / lost.len() as f64;
        assert!(average.abs() < mean, "{drops}: {average}");
    }
    // The control: where the inside is dark, what goes there is missing, and no more than that.
    let truth = Truth { samples: 16, ..Truth::default() };
    let Traced { picture, coverage, .. } = picture(&from_afar(&one(60.0), 0.0, 0.0), &white, truth);
    let sum: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel.x)).sum();
    let covered: f64 = coverage.iter().map(|share| f64::from(*share)).sum();
    let beside = 0.918_318 * (picture.pixels.len() as f64 - covered);
    let of_drop = (sum - beside) / covered / (0.957_420 * 0.995_704);
    close(of_drop, budget(60.0).sky, 3e-3, "budget");
}

/// Where the light comes from that enters a drop square on, as means over its disc.
#[derive(Default)]
struct Budget {
    first: f64,
    later: f64,
    beside: f64,
    inside: f64,
    caught: f64,
    /// All of the sky's, by way of the pane too.
    sky: f64,
}

/// By angles in the plane of the drop's axis, where all of a ray stays that meets it square on.
fn budget(angle: f64) -> Budget {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let (radius, center) = (1.0 / sine, -cosine / sine);
    let fresnel = |i: f64, index: f64| {
        let sine = i.sin() / index;
        if sine >= 1.0 {
            return (1.0, None);
        }
        if i < 1e-9 {
            return (((1.0 - index) / (1.0 + index)).powi(2), Some(0.0));
        }
        let t = sine.asin();
        let s = ((i - t).sin() / (i + t).sin()).powi(2);
        (0.5 * (s + ((i - t).tan() / (i + t).tan()).powi(2)), Some(t))
    };
    let mut sums = Budget::default();
    const PLACES: u32 = 4000;
    for number in 0..PLACES {
        // Rings of equal area.
        let mut x = ((f64::from(number) + 0.5) / f64::from(PLACES)).sqrt();
        let (mut z, mut left) = (0.0, 1.0 / f64::from(PLACES));
        // The ray's angle from the axis, positive towards +x.
        let mut way = 0.0_f64;
        for order in 0..=8 {
            let (dx, dz) = way.sin_cos();
            let b = x * dx + (z - center) * dz;
            let to_cap =
                -b + (b * b - x * x - (z - center).powi(2) + radius * radius).max(0.0).sqrt();
            let reflectance;
            if dz < 0.0 && -z / dz < to_cap {
                (x, z) = (x - z / dz * dx, 0.0);
                let i = (-dz).min(1.0).acos();
                let (f, in_glass) = fresnel(i, GLASS / WATER);
                reflectance = f;
                if let Some(in_glass) = in_glass {
                    let through = left * (1.0 - f);
                    let (back, is_out) = fresnel(in_glass, 1.0 / GLASS);
                    if is_out.is_none() {
                        sums.caught += through;
                    } else {
                        sums.beside += through * back / (1.0 + back);
                        sums.sky += through * back / (1.0 + back);
                        sums.inside += through / (1.0 + back);
                    }
                }
                way = std::f64::consts::PI - way;
            } else {
                (x, z) = (x + to_cap * dx, z + to_cap * dz);
                let normal = x.atan2(z - center);
                let i = (way - normal).sin().atan2((way - normal).cos());
                let (f, out) = fresnel(i.abs(), 1.0 / WATER);
                reflectance = f;
                if let Some(out) = out {
                    let through = left * (1.0 - f);
                    let up = (normal + out.copysign(i)).cos();
                    *(if order == 0 { &mut sums.first } else { &mut sums.later }) += through;
                    sums.sky += if up > 0.0 { through } else { through * (1.0 - dry(-up)) };
                }
                way = 2.0 * normal + std::f64::consts::PI - way;
            }
            left *= reflectance;
        }
    }
    sums
}

#[test]
fn the_budget_of_the_tests_is_that_of_the_table() {
    for (angle, wanted) in [
        (60.0, [0.7005, 0.0271, 0.0155, 0.1891, 0.0678]),
        (90.0, [0.525, 0.024, 0.018, 0.396, 0.002]),
    ] {
        let Budget { first, later, beside, inside, caught, .. } = budget(angle);
        for (found, wanted) in [first, later, beside, inside, caught].into_iter().zip(wanted) {
            close(found, wanted, 6e-4, "share");
        }
    }
}

#[test]
fn a_lens_spreads_drops_and_loses_none() {
    let white = Environment::constant(Vec3::ONE);
    let covered = |aperture: f64| {
        let camera = format!(
            "position = [0, 0, 0.1]\ntarget = [0, 0, 0]\nvertical_fov = 3.004\nfocus = inf\naperture = {aperture}"
        );
        let drop = "[[pane.drop]]\nat = [0.0007, 0]\nradius = 0.0003\ncontact_angle = 40";
        let mut scene = scene("thickness = 0.0", drop, &camera);
        (scene.image.width, scene.image.height) = (24, 24);
        let truth = Truth { samples: 512, ..Truth::default() };
        let coverage = picture(&scene, &white, truth).coverage;
        // The drop's middle is in the sixteenth column.
        (
            coverage.iter().map(|share| f64::from(*share)).sum::<f64>(),
            f64::from(coverage[12 * 24 + 15]),
        )
    };
    let ((pinhole, sharp), (lens, blurred)) = (covered(0.0), covered(0.0015));
    assert!((lens / pinhole - 1.0).abs() < 0.03, "{lens} for {pinhole}");
    // (2a / A)² in the middle of the blurred disc.
    close(sharp, 1.0, 0.5, "sharp");
    close(blurred, 0.16, 0.02, "opacity in the middle");
}

#[test]
fn rain_is_behind_the_pane_alone() {
    let environment = telling();
    let camera = "position = [0, 0, 2]\ntarget = [0, 0, 0]\nvertical_fov = 30";
    let drop = |z: f64| format!("[[drop]]\ncenter = [0, 0, {z}]\nradius = 0.2");
    let mut behind = scene("thickness = 0.0", &drop(-1.0), camera);
    (behind.image.width, behind.image.height) = (24, 24);
    let sized = |text: &str, pane: bool| {
        let mut scene = scene("thickness = 0.0", text, camera);
        scene.image = behind.image;
        if !pane {
            scene.pane = None;
        }
        picture(&scene, &environment, Truth { samples: 1, glints: false, ..Truth::default() })
    };
    let (with, without, bare) =
        (sized(&drop(-1.0), true), sized(&drop(-1.0), false), sized("", true));
    let near = sized(&drop(1.0), true);
    assert_eq!(near.picture, bare.picture, "a drop on the camera's side is drawn");
    assert_ne!(with.picture, bare.picture);
    assert_eq!(with.coverage, without.coverage);
    let (eye, samples, mut places) =
        (Eye::of_scene(&behind), Samples::new(1, 0, false), Vec::new());
    for (number, (dimmed, bright)) in
        (0..).zip(with.picture.pixels.iter().zip(&without.picture.pixels))
    {
        samples.of_pixel(number, &mut places);
        let through = dry(-eye.ray(number % 24, number / 24, &places[0]).direction.z);
        let apart = (dimmed.as_dvec3() - through * bright.as_dvec3()).abs().max_element();
        assert!(apart < 1e-6, "{number}: {dimmed} for {bright}");
    }
}

#[test]
fn a_drop_shows_the_plate_where_the_camera_has_it() {
    let environment = Environment::constant(Vec3::new(0.0, 0.0, 1.0));
    let camera = "position = [0, 0, 3]\ntarget = [0, 0, 0]\nvertical_fov = 30";
    let mut scene = scene("thickness = 0.0", "[[pane.drop]]\nat = [0, 0]\nradius = 1", camera);
    (scene.image.width, scene.image.height) = (8, 8);
    // Green grows upwards by steps of one.
    let pixels = (0..64).map(|number| Vec3::new(1.0, (7 - number / 8) as f32, 0.0)).collect();
    let plate = Plate::new(Some(Picture { width: 8, height: 8, pixels }), None);
    let seen = |x: f64, y: f64| {
        let mut scene = scene.clone();
        scene.camera.position = DVec3::new(x, y, 3.0);
        scene.camera.target = DVec3::new(x, y, 0.0);
        let truth = Truth { internal_reflections: 0, ..Truth::default() };
        Tracer::new(&scene, &environment, truth).before(plate.clone()).radiance_along(DVec3::NEG_Z)
    };
    let exit = |x: f64, y: f64| {
        let cap = Cap { radius: 1.0, angle: 60.0 };
        cap.first_exit(DVec3::Z, DVec3::new(x, y, 0.0), WATER, GLASS).expect("an exit")
    };
    let (near, far) = (exit(0.0, 0.5), exit(0.0, 0.75));
    // Seen 9.6 degrees down, upside down, between the middles of the pixels there.
    let down = -near.direction.y / near.direction.z / 15_f64.to_radians().tan();
    let green = 3.5 - 4.0 * down;
    same(seen(0.0, 0.5), near.weight * DVec3::new(1.0, green, 0.0), 1e-6, "plate");
    same(seen(0.0, 0.75), far.weight * DVec3::Z, 1e-6, "environment");
}

#[test]
fn each_colour_is_bent_by_its_own_index() {
    let environment = telling();
    let with = |index: &str| {
        let text = format!(
            "[water]\nindex = {index}\n[pane]\npoint = [0, 0, 0]\nnormal = [0, 0, -1]\n[[pane.drop]]\nat = [0, 0]\nradius = 1\n\
             [camera]\nposition = [0.3, 0.4, 2]"
        );
        let scene = Scene::parse(&text, "a.toml").expect("a scene");
        Tracer::new(&scene, &environment, Truth::default())
            .radiance_along(DVec3::new(0.0, -0.1, -1.0).normalize())
    };
    let all = with("[1.3, 1.34, 1.4]");
    for (axis, index) in ["1.3", "1.34", "1.4"].into_iter().enumerate() {
        assert_eq!(all[axis], with(index)[axis]);
    }
}

#[test]
fn a_pane_stays_in_the_world_or_goes_along() {
    let of = |frame: &str, x: f64| {
        let text = format!(
            "[pane]\nframe = \"{frame}\"\npoint = [0, 0, -1]\nnormal = [0, 0, -1]\nthickness = 0.0\n[[pane.drop]]\nat = [0, 0]\n\
             radius = 0.2\n[camera]\nposition = [{x}, 0, 0]\ntarget = [{x}, 0, -1]\nvertical_fov = 40\n[image]\nwidth = 16\nheight = 16"
        );
        let scene = Scene::parse(&text, "a.toml").expect("a scene");
        picture(&scene, &Environment::constant(Vec3::ONE), Truth { samples: 4, ..Truth::default() })
            .coverage
    };
    assert_eq!(of("camera", 0.5), of("camera", 0.0));
    assert_eq!(of("camera", 0.0), of("world", 0.0));
    assert_ne!(of("world", 0.2), of("world", 0.0));
    // By distance and tilt: the top leans towards the camera.
    let text =
        "[pane]\ndistance = 2.0\ntilt = 60.0\n[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 0]";
    let face = Scene::parse(text, "a.toml").expect("a scene").pane_face().expect("a face");
    let half = 3_f64.sqrt() / 2.0;
    same(face.point, DVec3::new(1.0, 1.0, -1.0), 1e-12, "point");
    same(face.normal, DVec3::new(0.0, half, -0.5), 1e-12, "normal");
    same(face.u, DVec3::X, 1e-12, "u");
    same(face.v, DVec3::new(0.0, 0.5, half), 1e-12, "v");
    // While the shutter is open a camera that drives leaves a pane of the world behind.
    let smeared = |frame: &str| {
        let text = format!(
            "[pane]\nframe = \"{frame}\"\npoint = [0, 0, -1]\nnormal = [0, 0, -1]\nthickness = 0.0\n[[pane.drop]]\nat = [0, 0]\n\
             radius = 0.1\n[camera]\nvertical_fov = 40\nshutter = 0.1\nvelocity = [2, 0, 0]\n[image]\nwidth = 16\nheight = 16"
        );
        let scene = Scene::parse(&text, "a.toml").expect("a scene");
        let traced = picture(&scene, &Environment::constant(Vec3::ONE), Truth::default());
        traced.coverage.iter().filter(|share| **share > 0.0).count()
    };
    assert!(smeared("world") > smeared("camera") + 4);
}

#[test]
fn many_drops_are_found_as_by_trying_all() {
    // By the grid against one drop at a time: what is covered is covered by one of them.
    let white = Environment::constant(Vec3::ONE);
    let drop = |number: u32| {
        let part = |factor: u32| f64::from(number * factor % 83) / 83.0;
        format!(
            "[[pane.drop]]\nat = [{:?}, {:?}]\nradius = {:?}\ncontact_angle = {:?}\n",
            -0.8 + 0.2 * f64::from(number % 9),
            -0.8 + 0.2 * f64::from(number / 9),
            0.02 + 0.07 * part(17),
            30.0 + 80.0 * part(31)
        )
    };
    let covered = |drops: &str| {
        let mut scene = scene(
            "thickness = 0.0",
            drops,
            "position = [1.2, 0.8, 1]\ntarget = [0, 0, 0]\nvertical_fov = 60",
        );
        (scene.image.width, scene.image.height) = (32, 32);
        picture(&scene, &white, Truth { samples: 1, internal_reflections: 0, ..Truth::default() })
            .coverage
    };
    let all = covered(&(0..81).map(drop).collect::<String>());
    let mut each = vec![0.0_f32; all.len()];
    for number in 0..81 {
        each.iter_mut().zip(covered(&drop(number))).for_each(|(any, one)| *any = any.max(one));
    }
    assert!(all.iter().sum::<f32>() > 50.0);
    assert_eq!(all, each);
}

#[test]
fn real_rain_is_seen_through_the_pane_and_begins_behind_it() {
    let environment = telling();
    let traced = |keys: &str, bound: f64| {
        let text = format!(
            "[water]\nindex = {WATER}\n[rain]\nrate = 100.0\nextent = 6.0\n{keys}\n[camera]\nvertical_fov = 40\n[image]\nwidth = 16\n\
             height = 16"
        );
        let scene = Scene::parse(&text, "a.toml").expect("a scene");
        let truth = Truth { samples: 16, rain_to: Some(bound), ..Truth::default() };
        picture(&scene, &environment, truth)
    };
    let pane = |distance: f64, index: f64| {
        format!("[pane]\ndistance = {distance}\nthickness = 0.0\nindex = {index}")
    };
    let sum = |of: &[f32]| of.iter().sum::<f32>();
    let (bare, near, far) =
        (traced("", 6.0), traced(&pane(0.001, 1.0), 6.0), traced(&pane(5.0, 1.0), 6.0));
    // No glass just before the lens changes nothing.
    assert_eq!(Traced { on_pane: Vec::new(), ..near }, bare);
    assert!(sum(&bare.coverage) > 1.0);
    assert!(sum(&far.coverage) < 0.3 * sum(&bare.coverage), "drops before the pane are drawn");
    // Glass dims rain and sky alike.
    let glass = traced(&pane(0.001, GLASS), 6.0);
    assert_eq!(glass.coverage, bare.coverage);
    for (dimmed, bright) in glass.picture.pixels.iter().zip(&bare.picture.pixels) {
        // Within the picture T is 0.9183 to 0.9179.
        assert!((*dimmed / *bright - 0.918).abs().max_element() < 1.5e-3);
    }
    // The medium, too, is outside alone: of 6 m along a ray those beyond the pane.
    let (all, part) = (traced("", 0.0), traced(&pane(5.0, 1.0), 0.0));
    let view =
        Scene::parse("[camera]\nvertical_fov = 40\n[image]\nwidth = 16\nheight = 16", "a.toml")
            .expect("a scene")
            .view();
    let places =
        (0..256).map(|number| (f64::from(number % 16) + 0.5, f64::from(number / 16) + 0.5));
    let beyond = places.map(|(x, y)| 1.0 + 5.0 / 6.0 / view.ray(x, y).z).sum::<f64>() / 256.0;
    let share = f64::from(sum(&part.opacity) / sum(&all.opacity));
    assert!((share - beyond).abs() < 0.005, "{share} for {beyond}");
}
