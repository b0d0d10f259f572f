//! A pane of glass and the drops on it as the GPU draws them: against the reference, and against the picture without it.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::plate::Plate;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::parts::{Grid, Parts};
use raindrops::scene::Scene;
use raindrops::scene::model::{PaneModel, Preset};

use crate::common::picture::{against, frame, picture_of, renderer};
use crate::common::{on_device, waves};

const EDGE: u32 = 64;

/// Drops of several angles before a camera that looks along the normal; keys of tables that come first.
pub fn text(camera: &str, pane: &str, drops: &[[f64; 4]]) -> String {
    let drops = drops.iter().map(|[u, v, radius, angle]| {
        format!("[[pane.drop]]\nat = [{u}, {v}]\nradius = {radius}\ncontact_angle = {angle}\n")
    });
    let drops: String = drops.collect();
    format!(
        "[image]\nwidth = {EDGE}\nheight = {EDGE}\n[camera]\nposition = [0, 0, 0.3]\ntarget = [0, 0, 0]\nvertical_fov = 40.0\n\
         {camera}\n[pane]\ninside = [0.3, 0.2, 0.1]\n{pane}\n{drops}"
    )
}

pub fn scene(text: &str) -> Scene {
    let mut scene =
        Scene::parse(text, "pane.toml").unwrap_or_else(|error| panic!("{error}: {text}"));
    scene.model.preset = Preset::Exact;
    scene.model.samples = Some(64);
    scene
}

pub const SQUARE_ON: &str = "point = [0, 0, 0]\nnormal = [0, 0, -1]\nthickness = 0.004";
pub const MIXED: [[f64; 4]; 5] = [
    [0.0, 0.0, 0.025, 60.0],
    [-0.06, 0.05, 0.02, 35.0],
    [0.06, 0.04, 0.02, 90.0],
    [0.05, -0.06, 0.015, 75.0],
    [-0.05, -0.05, 0.004, 50.0],
];
pub const STEEP: [[f64; 4]; 4] = [
    [0.0, 0.0, 0.025, 100.0],
    [-0.06, 0.05, 0.02, 110.0],
    [0.06, 0.04, 0.02, 95.0],
    [0.04, -0.06, 0.015, 60.0],
];

fn truth(scene: &Scene, environment: &Environment, plate: &Plate) -> Picture {
    let truth = Truth { samples: 64, ..Truth::default() };
    Tracer::new(scene, environment, truth).before(plate.clone()).picture()
}

fn rel_mse(truth: &Picture, picture: &Picture) -> f64 {
    against(truth, picture).pixels.rel_mse
}

/// Holds `exact` by 64 rays against the reference, and says how far the first exit alone is off.
fn is_true(name: &str, text: &str) {
    let environment = waves();
    on_device(|device| {
        let mut scene = scene(text);
        let truth = truth(&scene, &environment, &Plate::default());
        let off = rel_mse(&truth, &picture_of(device, &scene, &environment));
        scene.model.pane = Some(PaneModel::FirstExit);
        let first = rel_mse(&truth, &picture_of(device, &scene, &environment));
        scene.model.pane = Some(PaneModel::None);
        let without = rel_mse(&truth, &picture_of(device, &scene, &environment));
        println!("{name}: relMSE {off:.5}, first exit {first:.5}, without {without:.5}");
        assert!(off < 1e-3, "{name}: {off}");
        assert!(without > 10.0 * off, "{name}: {without} without a pane, {off} with it");
        assert!(first > off, "{name}: {first} by the first exit, {off}");
    });
}

#[test]
fn drops_square_on_are_those_of_the_reference() {
    let bright = text("", SQUARE_ON, &MIXED);
    is_true("square on", &bright);
    // Where all is dark within, the little that comes back beside a drop is all that lights its crescents.
    is_true("dark within", &bright.replace("inside = [0.3, 0.2, 0.1]", "inside = [0, 0, 0]"));
}

#[test]
fn drops_on_a_thick_pane_aslant_are_those_of_the_reference() {
    is_true("aslant", &text("", "distance = 0.3\ntilt = 55.0\nthickness = 0.03", &MIXED));
}

#[test]
fn drops_out_of_focus_are_those_of_the_reference() {
    for (ratio, aperture) in [(1.0, 0.04), (3.0, 0.12)] {
        let camera = format!("aperture = {aperture}\nfocus = inf");
        let drops = MIXED.map(|[u, v, _, angle]| [u, v, 0.02, angle]);
        is_true(&format!("c = {ratio} r"), &text(&camera, SQUARE_ON, &drops));
    }
}

/// FLIP over the pixels whose picture without drops is another.
fn flip(truth: &Picture, picture: &Picture, without: &Picture) -> f64 {
    let found = against(truth, picture).flip_map;
    let shown = truth
        .pixels
        .iter()
        .zip(&without.pixels)
        .map(|(a, b)| (*a - *b).abs().max_element() > 0.005);
    let all: Vec<f64> =
        found.into_iter().zip(shown).filter(|(_, is)| *is).map(|(flip, _)| flip).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

/// A place and a size for each of many drops that stand apart.
fn spread(radius: f64, angle: f64) -> Vec<[f64; 4]> {
    let place = |number: i32| f64::from(number) * 4.0 * radius;
    let both = (-2..=2).flat_map(|u| (-2..=2).map(move |v| (u, v)));
    both.map(|(u, v)| {
        [place(u), place(v), radius * (1.0 + 0.15 * f64::from((u + 2 * v) % 3)), angle]
    })
    .collect()
}

#[test]
fn fast_is_nearly_as_near_as_exact() {
    let environment = waves();
    let aslant = "distance = 0.3\ntilt = 55.0\nthickness = 0.01";
    on_device(|device| {
        for (name, camera, pane, drops) in [
            ("in focus", "", SQUARE_ON, MIXED.to_vec()),
            ("c = r", "aperture = 0.02", SQUARE_ON, spread(0.01, 50.0)),
            ("c = 3 r", "aperture = 0.06", SQUARE_ON, spread(0.01, 60.0)),
            ("c = 0.8 r, aslant", "aperture = 0.02", aslant, spread(0.01, 35.0)),
            ("c = 1.3 r, overhang", "aperture = 0.03", aslant, spread(0.01, 95.0)),
            ("c = 0.4 r", "aperture = 0.02", SQUARE_ON, MIXED.to_vec()),
            ("small", "", SQUARE_ON, spread(0.009, 50.0)),
            ("small, aslant", "", aslant, spread(0.009, 35.0)),
        ] {
            let camera =
                if camera.is_empty() { String::new() } else { format!("{camera}\nfocus = inf") };
            let mut scene = scene(&text(&camera, pane, &drops));
            let truth = truth(&scene, &environment, &Plate::default());
            let exact = picture_of(device, &scene, &environment);
            scene.model.take_preset(Preset::Fast);
            scene.model.samples = None;
            let fast = picture_of(device, &scene, &environment);
            scene.model.pane = Some(PaneModel::Color);
            let color = picture_of(device, &scene, &environment);
            scene.pane.as_mut().expect("a pane").drops.clear();
            let without = picture_of(device, &scene, &environment);
            let [exact, fast, color] = [exact, fast, color]
                .map(|picture| (flip(&truth, &picture, &without), rel_mse(&truth, &picture)));
            println!("{name}: FLIP, relMSE exact {exact:.4?}, fast {fast:.4?}, colour {color:.4?}");
            assert!(fast.0 < exact.0 + 0.02, "{name}: FLIP {fast:?}, of exact {exact:?}");
        }
    });
}

/// A white drop before black: of its light none is lost, whatever the lens, and side by side they are as much as alone.
#[test]
fn blurs_of_drops_side_by_side_add_up() {
    let environment = Environment::constant(Vec3::ONE);
    on_device(|device| {
        let light = |preset: Preset, drops: &[[f64; 4]]| {
            let mut scene = scene(&text("aperture = 0.06\nfocus = inf", SQUARE_ON, drops));
            scene.model.take_preset(preset);
            scene.background.color = Some(crate::common::picture::black("pane-blurs", EDGE));
            let pane = scene.pane.as_mut().expect("a pane");
            (pane.inside, pane.index) = (DVec3::ZERO, 1.0);
            // Drops show the environment where the plate is not.
            crate::common::picture::sum(&picture_of(device, &scene, &environment))
        };
        let near = [[-0.011, 0.0, 0.01, 60.0], [0.011, 0.0, 0.01, 60.0]];
        for preset in [Preset::Fast, Preset::Exact] {
            let (one, other) = (light(preset, &near[..1]), light(preset, &near[1..]));
            let both = light(preset, &near);
            println!("{preset}: {one} and {other} alone, {both} together");
            assert!((both / (one + other) - 1.0).abs() < 0.01 && one > 0.0);
        }
    });
}

/// A sun beside the picture, in a drop out of focus: the lens makes a disc of it, with an edge.
#[test]
fn the_sun_in_a_drop_out_of_focus_is_a_disc() {
    let sun = DVec3::new(0.1, 0.5, -0.86).normalize();
    let sky = crate::common::painted(256, move |d| {
        Vec3::splat(if d.dot(sun) > 0.9995 { 1e4 } else { 0.0 })
    });
    on_device(|device| {
        for (number, radius) in [0.014, 0.02].into_iter().enumerate() {
            let drops = [[0.003 * number as f64, 0.002, radius, 60.0]];
            let camera = format!("aperture = {}\nfocus = inf", 2.0 * radius);
            let mut scene = scene(&text(&camera, SQUARE_ON, &drops));
            scene.model.take_preset(Preset::Fast);
            scene.background.color = Some(crate::common::picture::black("pane-sun", EDGE));
            scene.pane.as_mut().expect("a pane").inside = DVec3::ZERO;
            let picture = picture_of(device, &scene, &sky);
            let brightest = picture.pixels.iter().fold(0.0, |most: f32, pixel| most.max(pixel.y));
            let over = |part: f32| {
                picture.pixels.iter().filter(|pixel| pixel.y > part * brightest).count() as f64
            };
            let (edge, disc) = (over(0.15) - over(0.85), over(0.5));
            let wide = edge / (4.0 * std::f64::consts::PI * disc).sqrt();
            println!(
                "radius {radius}: a disc of {disc} pixels, whose edge is {wide:.2} pixels wide"
            );
            assert!(disc > 20.0 && wide < 1.6, "{disc} pixels, {wide}");
        }
    });
}

#[test]
fn drops_that_overhang_are_those_of_the_reference() {
    is_true("overhang", &text("", "distance = 0.3\ntilt = 40.0\nthickness = 0.01", &STEEP));
}

#[test]
fn a_pane_in_the_world_is_that_of_the_reference() {
    let pane =
        "point = [0.02, 0.01, -0.05]\nnormal = [0.5, 0.2, -0.9]\nthickness = 0.02\nindex = 1.7";
    let camera = "up = [0.3, 1.0, 0.0]";
    is_true("in the world", &text(camera, pane, &MIXED));
    let pane = "point = [0.0, 0.0, -0.3]\nnormal = [0.3, 0.1, -1.0]\nframe = \"camera\"";
    is_true("with the camera", &text(camera, pane, &MIXED));
    // Each colour by its own index.
    let colored = format!("[water]\nindex = [1.3, 1.35, 1.4]\n{}", text("", SQUARE_ON, &MIXED));
    is_true("coloured", &colored);
}

#[test]
fn a_pane_moves_while_the_camera_does() {
    let camera = "velocity = [0.3, 0.1, 0.0]\nshutter = 0.1";
    is_true("moving", &text(camera, SQUARE_ON, &MIXED));
}

#[test]
fn rain_is_behind_the_glass() {
    let drops = "[[drop]]\ncenter = [0.1, 0.1, -1.0]\nradius = 0.1\n[[drop]]\ncenter = [-0.2, -0.1, -1.0]\nradius = 0.15\n\
                 [[drop]]\ncenter = [0.02, 0.05, 0.2]\nradius = 0.01\n";
    is_true("rain behind", &format!("{drops}{}", text("", SQUARE_ON, &MIXED)));
}

#[test]
fn drops_show_the_plate_upside_down() {
    let environment = waves();
    let mut scene = scene(&text("", SQUARE_ON, &MIXED));
    let path = crate::common::kept_folder("pane").join("plate.exr");
    let pixel = |at: u32| {
        let (x, y) = ((at % EDGE) as f32 / EDGE as f32, (at / EDGE) as f32 / EDGE as f32);
        Vec3::new(x, 1.0 - y, if y < 0.5 { 2.0 } else { 0.1 })
    };
    let pixels = (0..EDGE * EDGE).map(pixel).collect();
    Picture { width: EDGE, height: EDGE, pixels }.write_exr(&path).expect("a file");
    scene.background.color = Some(path);
    let truth = truth(&scene, &environment, &Plate::of(&scene).expect("a plate"));
    on_device(|device| {
        let off = rel_mse(&truth, &picture_of(device, &scene, &environment));
        println!("plate: relMSE {off:.5}");
        assert!(off < 5e-3, "{off}");
        scene.background.color = None;
        let other = rel_mse(&truth, &picture_of(device, &scene, &environment));
        assert!(other > 0.1, "{other} before the environment");
    });
}

#[test]
fn a_dry_pane_dims_and_one_of_no_glass_does_nothing() {
    let environment = waves();
    on_device(|device| {
        let glass = scene(&text("", "distance = 0.3\ntilt = 30.0\nthickness = 0.01", &[]));
        let mut without = glass.clone();
        without.model.pane = Some(PaneModel::None);
        let bright = picture_of(device, &without, &environment);
        let dimmed = picture_of(device, &glass, &environment);
        let (view, normal) = (glass.view(), glass.pane_face().expect("a pane").normal);
        for (number, (dimmed, bright)) in (0..).zip(dimmed.pixels.iter().zip(&bright.pixels)) {
            let place = [number % EDGE, number / EDGE].map(|at| f64::from(at) + 0.5);
            let cosine: f64 = view.ray(place[0], place[1]).dot(normal);
            let (i, t) = (cosine.acos(), (cosine.acos().sin() / 1.52).asin());
            let (s, p) = ((i - t).sin() / (i + t).sin(), (i - t).tan() / (i + t).tan());
            let f = 0.5 * (s * s + p * p);
            let through = (1.0 - f) / (1.0 + f);
            let wanted = through * bright.as_dvec3() + (1.0 - through) * DVec3::new(0.3, 0.2, 0.1);
            let apart = ((dimmed.as_dvec3() - wanted) / wanted).abs().max_element();
            // Half a step of a half.
            assert!(apart < 5e-4, "{number}: {dimmed} for {wanted}");
        }
        let mut clear = glass.clone();
        clear.pane.as_mut().expect("a pane").index = 1.0;
        assert_eq!(picture_of(device, &clear, &environment), bright);
    });
}

#[test]
fn runs_and_parts_have_the_same_bytes() {
    let environment = waves();
    let camera = "aperture = 0.04\nfocus = 2.0";
    let scene = scene(&text(camera, "distance = 0.3\ntilt = 40.0\nthickness = 0.01", &STEEP));
    on_device(|device| {
        let plan = plan(&scene, &environment, Output::Display).expect("a plan");
        let mut parts = Parts::new(device, &environment, &plan);
        let mut drawn = BTreeSet::new();
        for _ in 0..3 {
            drawn.insert(parts.display(&scene).expect("drawn").0);
        }
        for (columns, rows) in [(2, 2), (3, 1)] {
            drawn.insert(parts.display_by(&scene, Grid { columns, rows }).expect("drawn").0);
        }
        assert_eq!(drawn.len(), 1, "{} pictures", drawn.len());
    });
}

/// What is exposed is the picture with the pane: black glass lets the rest be as bright as without it.
#[test]
fn an_exposure_is_that_of_the_picture_with_the_pane() {
    let environment = Environment::constant(Vec3::ONE);
    let glass = |index: f64| {
        scene(&text("", &format!("distance = 0.3\nindex = {index}\nthickness = 0.01"), &[]))
    };
    on_device(|device| {
        let shown = |index: f64| {
            let mut scene = glass(index);
            scene.pane.as_mut().expect("a pane").inside = DVec3::ZERO;
            let plan = plan(&scene, &environment, Output::Display).expect("a plan");
            let mut parts = Parts::new(device, &environment, &plan);
            parts.display(&scene).expect("drawn").0[3 * (EDGE * EDGE / 2 + EDGE / 2) as usize]
        };
        // Most of the light is lost, and made up for by the exposure.
        let (clear, dark) = (shown(1.0), shown(4.0));
        assert!(
            clear.abs_diff(dark) <= 1,
            "{clear} by no glass, {dark} by glass that reflects half"
        );
    });
}

#[test]
fn what_is_not_drawn_is_refused() {
    let environment = waves();
    let said = |scene: &Scene, output| match plan(scene, &environment, output) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let glass = scene(&text("", SQUARE_ON, &MIXED));
    assert_eq!(said(&glass, Output::Radiance), "");
    assert_eq!(said(&glass, Output::Layers), "");
    let mut paper = glass.clone();
    paper.model = Default::default();
    paper.model.preset = Preset::Paper;
    assert!(said(&paper, Output::Radiance).contains("tiles"));
    paper.model.pane = Some(PaneModel::None);
    assert_eq!(said(&paper, Output::Radiance), "");
    on_device(|device| {
        let mut renderer = renderer(device, &glass, &environment);
        let mut behind = glass.clone();
        behind.camera.position.z = -0.5;
        let refused = renderer.submit(&behind);
        assert!(refused.is_err_and(|error| error.to_string().contains("pane")));
        frame(&mut renderer, &glass);
    });
}
