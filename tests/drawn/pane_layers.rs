//! Layers of a pane: against the reference, against the picture, and against where a drop must be.

use glam::DVec3;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth};
use raindrops::renderer::parts::{Grid, Parts};
use raindrops::scene::Scene;
use raindrops::scene::model::{PaneModel, Preset};

use crate::common::picture::picture_of;
use crate::common::{on_device, waves};
use crate::layers::layers;
use crate::pane_drawn::{MIXED, SQUARE_ON, STEEP, scene, text};

const ASLANT: &str = "distance = 0.3\ntilt = 40.0\nthickness = 0.01";

#[test]
fn covers_numbers_and_depths_are_those_of_the_reference() {
    let wide = "aperture = 0.04\nfocus = inf";
    on_device(|device| {
        for (name, preset, camera, pane, drops) in [
            ("square on", Preset::Exact, "", SQUARE_ON, MIXED.as_slice()),
            ("overhang", Preset::Exact, "", ASLANT, &STEEP),
            ("lens", Preset::Exact, wide, ASLANT, &MIXED),
            ("fast", Preset::Fast, "", SQUARE_ON, &MIXED),
            ("fast, lens", Preset::Fast, wide, ASLANT, &MIXED),
        ] {
            let mut scene = scene(&text(camera, pane, drops));
            let sky = waves();
            let truth = Truth { samples: 64, ..Truth::default() };
            let traced = Tracer::new(&scene, &sky, truth).trace(&|_| ());
            scene.model.take_preset(preset);
            scene.model.samples = if preset == Preset::Exact { Some(64) } else { None };
            let found = layers(device, &scene, &scene);
            let (mut apart, mut covered, mut others, mut opacity) = (0.0_f64, 0, 0, 0.0_f64);
            for (at, truth) in traced.on_pane.iter().enumerate() {
                apart += f64::from((found.glass[at].to_f32() - truth.share).abs());
                opacity += f64::from((found.color[at][3].to_f32() - traced.opacity[at]).abs());
                if truth.share < 0.9 {
                    continue;
                }
                covered += 1;
                // If drops have one depth, either is the nearest.
                let is_told = (found.depth[at] - truth.depth).abs() < 1e-5 * truth.depth;
                let is_it = found.id[at] == u64::from(truth.number);
                others += u32::from(!is_told || !is_it);
            }
            let pixels = traced.on_pane.len() as f64;
            let (apart, opacity) = (apart / pixels, opacity / pixels);
            println!(
                "{name}: cover {apart:.4}, opacity {opacity:.4}, {others} of {covered} others"
            );
            let most = if preset == Preset::Exact { 0.01 } else { 0.02 };
            assert!(apart < most && opacity < most, "{name}: {apart}, {opacity}");
            assert!(covered > 5 && others * 50 <= covered, "{name}: {others} of {covered}");
        }
    });
}

/// Over what is seen without rain and without glass they are the picture; rain behind the glass is dimmed as the picture's is.
#[test]
fn over_the_sky_they_are_the_picture() {
    let rain = "[[drop]]\ncenter = [0.1, 0.1, -1.0]\nradius = 0.1\n[[drop]]\ncenter = [-0.2, -0.1, -1.0]\nradius = 0.15\n";
    let sky = waves();
    on_device(|device| {
        for camera in ["", "aperture = 0.03\nfocus = 2.0"] {
            let mut scene = scene(&format!("{rain}{}", text(camera, SQUARE_ON, &MIXED)));
            let drawn = picture_of(device, &scene, &sky);
            let found = layers(device, &scene, &scene);
            scene.model.pane = Some(PaneModel::None);
            let without_glass = layers(device, &scene, &scene);
            assert!(without_glass.glass.is_empty() && without_glass.count == found.count);
            let behind = picture_of(device, &scene.without_rain(), &sky);
            let over = found.over(&behind);
            for (at, (over, drawn)) in over.pixels.iter().zip(&drawn.pixels).enumerate() {
                // Three roundings to float16: light, opacity, picture.
                let allowed = (behind.pixels[at] + drawn.abs() + 0.1) / 1024.0;
                assert!((*over - *drawn).abs().cmple(allowed).all(), "{at}: {over}, not {drawn}");
                if found.glass[at].to_f32() == 0.0 {
                    // Number and depth of rain are as they were; behind a drop on the glass they are its own.
                    assert_eq!(
                        (found.id[at], found.depth[at]),
                        (without_glass.id[at], without_glass.depth[at])
                    );
                } else {
                    assert!(found.depth[at] < 0.31 && found.id[at] > 0);
                }
            }
            let seen = |id: u64| found.id.iter().filter(|found| **found == id).count();
            assert!(seen(1) > 20 && found.count.iter().any(|count| *count > 0));
        }
    });
}

/// A pane that goes along with the camera does not move in the picture; one that stands moves by its depth.
#[test]
fn drops_move_as_the_pane_does() {
    let step = DVec3::new(0.01, -0.005, 0.02);
    let moved = |scene: &Scene| {
        let mut until = scene.clone();
        until.camera.position += step;
        until.camera.target += step;
        until
    };
    on_device(|device| {
        let fixed = scene(&text("", "distance = 0.3", &MIXED));
        let found = layers(device, &fixed, &moved(&fixed));
        let still = |motion: &[half::f16; 2]| motion.iter().all(|part| part.to_f32().abs() < 1e-3);
        assert!(found.glass.iter().any(|share| share.to_f32() == 1.0));
        assert!(found.motion.iter().all(still));

        let standing = scene(&text("", SQUARE_ON, &MIXED));
        let found = layers(device, &standing, &moved(&standing));
        // The pane is in z = 0 and u to the right; the camera looks along -z from 0.3.
        let focal = 32.0 / 20.0_f64.to_radians().tan();
        let mut held = 0;
        for at in 0..found.id.len() {
            let Some([u, v, ..]) = MIXED.get((found.id[at] as usize).wrapping_sub(1)) else {
                continue;
            };
            let seen = |from: DVec3| {
                let depth = from.z;
                (focal * (u - from.x) / depth, -focal * (v - from.y) / depth)
            };
            let (from, to) =
                (seen(DVec3::new(0.0, 0.0, 0.3)), seen(DVec3::new(0.0, 0.0, 0.3) + step));
            let [right, down] = found.motion[at].map(|part| f64::from(part.to_f32()));
            let apart = (right - (to.0 - from.0)).abs().max((down - (to.1 - from.1)).abs());
            assert!(apart < 5e-3, "{at}: {right}, {down} for {from:?} to {to:?}");
            held += 1;
        }
        assert!(held > 100, "{held}");
    });
}

#[test]
fn parts_are_the_whole() {
    let scene = scene(&text("aperture = 0.04\nfocus = 2.0", ASLANT, &STEEP));
    on_device(|device| {
        let sky = waves();
        let plan = plan(&scene, &sky, Output::Layers).expect("a plan");
        let mut parts = Parts::new(device, &sky, &plan);
        let whole = parts.layers(&scene).expect("layers").0;
        let grid = Grid { columns: 2, rows: 3 };
        assert!(whole == parts.layers_by(&scene, grid).expect("layers").0);
        assert!(whole.glass.iter().any(|share| share.to_f32() > 0.0));
    });
}
