//! Rain as layers: over a plate they are the picture that is drawn before it; numbers, depths and motions are those of
//! the drops as the CPU finds them, from frame to frame and from eye to eye.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::picture::plate::Plate;
use raindrops::picture::sidecar::{DropRecord, drops_in_view};
use raindrops::plan::{Output, plan};
use raindrops::renderer::parts::{Grid, Parts};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, Population, RainSettings, Scene};

use crate::common::picture::{picture_of, renderer_of};
use crate::common::{documented_keys, emptied_folder, on_device, run, waves, write_scene};

const EDGE: u32 = 128;

fn base(preset: Preset) -> Scene {
    let mut scene = Scene { rain: None, time: 0.7, ..Scene::default() };
    (scene.image.width, scene.image.height) = (EDGE, EDGE);
    scene.model.take_preset(preset);
    scene
}

/// Small drops in a box that falls, and large ones by hand, one of which moves.
fn in_a_box(preset: Preset) -> Scene {
    let mut scene = base(preset);
    let half_extent = DVec3::splat(100.0);
    scene.rain = Some(RainSettings { count: 20_000, half_extent, ..RainSettings::default() });
    let moving = PlacedDrop {
        velocity: DVec3::new(9.0, 3.0, -4.0),
        ..PlacedDrop::sphere(DVec3::new(0.5, 0.2, -9.0), 1.0)
    };
    scene.drops = vec![moving, PlacedDrop::sphere(DVec3::new(-3.0, 1.0, -8.0), 2.0)];
    scene
}

/// Two populations, which fall differently.
fn of_two(preset: Preset) -> Scene {
    let mut scene = in_a_box(preset);
    let (half_extent, velocity) = (DVec3::splat(80.0), DVec3::new(5.0, 30.0, -8.0));
    let other = Population { seed: None, count: 10_000, half_extent, radius: 0.7, velocity };
    scene.rain.get_or_insert_default().others[0] = Some(other);
    scene
}

/// Real rain, with the wind.
fn real(preset: Preset) -> Scene {
    let mut scene = base(preset);
    scene.camera.vertical_fov = 40.0;
    let wind = DVec3::new(3.0, 0.0, 1.0);
    let rain = RealRain { rate: 100.0, extent: 200.0, wind, ..RealRain::default() };
    scene.rain = Some(RainSettings::of(rain));
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.02, 0.0, -0.5), 0.02)];
    scene
}

/// The layers of a frame that is exposed until this scene.
pub fn layers(device: &Arc<Device>, scene: &Scene, until: &Scene) -> Layers {
    let sky = waves();
    let mut renderer = renderer_of(device, scene, &sky, Output::Layers);
    renderer.draw_until(scene, until).expect("a frame");
    renderer.read_layers().expect("layers")
}

fn plate(scene: &mut Scene, name: &str) -> Picture {
    let folder = emptied_folder(&format!("layers/{name}"));
    let pixel = |at: u32| Vec3::new((at % 7) as f32, (at / EDGE % 5) as f32, 2.0);
    let pixels = (0..EDGE * EDGE).map(pixel).collect();
    let picture = Picture { width: EDGE, height: EDGE, pixels };
    picture.write_exr(&folder.join("plate.exr")).expect("a plate");
    scene.background.color = Some(folder.join("plate.exr"));
    let mut depth = Layers::empty(EDGE, EDGE);
    let far = |at: usize| if at % EDGE as usize > 60 { 1e6 } else { 8.5 };
    depth.depth.iter_mut().enumerate().for_each(|(at, depth)| *depth = far(at));
    depth.write_depth(&folder.join("depth.exr")).expect("a depth");
    scene.background.depth = Some(folder.join("depth.exr"));
    picture
}

#[test]
fn over_a_plate_they_are_the_picture_before_it() {
    on_device(|device| {
        for (name, mut scene) in [
            ("fast", in_a_box(Preset::Fast)),
            ("exact", in_a_box(Preset::Exact)),
            ("real", real(Preset::Fast)),
        ] {
            let behind = plate(&mut scene, name);
            let sky = waves();
            let drawn = picture_of(device, &scene, &sky);
            let rain = layers(device, &scene, &scene);
            let over = rain.over(&behind);
            let mut covered = 0;
            let all = over.pixels.iter().zip(&drawn.pixels).zip(&behind.pixels).zip(&rain.color);
            for (((over, drawn), plate), [.., alpha]) in all {
                // Three roundings to float16: light, opacity, picture.
                let allowed = (*plate + drawn.abs() + 0.1) / 1024.0;
                assert!((*over - *drawn).abs().cmple(allowed).all(), "{name}: {over}, not {drawn}");
                covered += u32::from(alpha.to_f32() > 0.5);
            }
            assert!(covered > 200, "{name}: {covered}");
            // The control: without its plate the rain is another picture.
            assert!(
                rain.over(&Picture { pixels: vec![Vec3::ZERO; behind.pixels.len()], ..behind })
                    != drawn
            );
        }
    });
}

fn by_number(scene: &Scene) -> HashMap<u64, DropRecord> {
    let plan = plan(scene, &waves(), Output::Layers).expect("a plan");
    let drops = drops_in_view(scene, plan.cutoff.map_or(0.0, |cutoff| cutoff.px));
    let count = drops.len();
    let map: HashMap<_, _> = drops.into_iter().map(|drop| (drop.number, drop)).collect();
    assert_eq!(map.len(), count, "two drops have one number");
    map
}

/// Holds every pixel's number, depth and motion against the drops on the CPU, at both times and from another eye. What a
/// scene's depth hides is nobody's nearest.
fn hold_against_the_cpu(device: &Arc<Device>, name: &str, scene: &Scene) {
    let mut until = Scene { time: scene.time + 1.0 / 30.0, ..scene.clone() };
    until.camera.position += DVec3::new(0.02, 0.01, -0.03);
    until.camera.principal = [0.53, 0.48];
    let mut right = scene.clone();
    right.camera.position.x += 0.065;
    right.camera.target.x += 0.065;
    let found = layers(device, scene, &until);
    let (other_eye, next) = (layers(device, &right, &right), layers(device, &until, &until));
    let plate = Plate::of(scene).expect("a plate");
    let wall = |at: usize| plate.depth().map_or(f64::INFINITY, |depth| depth.values[at]);
    let (now, then, from_right) = (by_number(scene), by_number(&until), by_number(&right));
    let (view, view_then) = (scene.view(), until.view());
    let (mut drops, mut moved) = (HashSet::new(), 0);
    for at in 0..(EDGE * EDGE) as usize {
        let (id, depth, [x, y]) =
            (found.id[at], found.depth[at], found.motion[at].map(|m| m.to_f64()));
        assert_eq!(id == 0, found.count[at] == 0);
        if id == 0 {
            assert!(depth.is_infinite() && x == 0.0 && y == 0.0);
            continue;
        }
        let drop = now.get(&id).unwrap_or_else(|| panic!("{name}: no drop has number {id:#x}"));
        let [left, top, end_x, end_y] = drop.pixels;
        let (column, row) = (at as u32 % EDGE, at as u32 / EDGE);
        // A splat's box of equal area may reach a pixel farther than the outline.
        let is_within = column + 1 >= left && column <= end_x && row + 1 >= top && row <= end_y;
        assert!(is_within, "{name}: {column}, {row} is not in {:?}", drop.pixels);
        let planar = -(drop.center - view.position).dot(view.back);
        assert!((f64::from(depth) - planar).abs() < 1e-4 * planar, "{name}: {depth}, not {planar}");
        // Its front is no farther from the eye than its middle, less its radius.
        assert!(planar - drop.radius < wall(at) * (1.0 + 1e-5), "{name}: {id:#x} is hidden");
        drops.insert(id);
        // One that has left its box meanwhile is at its other side.
        if let Some(then) = then.get(&id).filter(|then| then.center.distance(drop.center) < 40.0) {
            let place = |view: &raindrops::scene::projection::View, center: DVec3| {
                view.point(center - view.position).0
            };
            let expected: DVec2 = place(&view_then, then.center) - place(&view, drop.center);
            let error = (DVec2::new(x, y) - expected).length();
            assert!(
                error < 2e-3 + expected.length() / 1024.0,
                "{name}: ({x}, {y}), not {expected}"
            );
            moved += u32::from(expected.length() > 0.2);
        }
    }
    // No drop is before the one that is told where its middle is seen.
    let mut middles = 0;
    for drop in now.values() {
        let place = view.point(drop.center - view.position).0.floor();
        let is_inside = place.cmpge(DVec2::ZERO).all() && place.max_element() < f64::from(EDGE);
        let far = -(drop.center - view.position).dot(view.back) + drop.radius;
        let at = || place.y as usize * EDGE as usize + place.x as usize;
        let is_near = drop.center.distance(view.position) < 2.0 * drop.radius;
        if !is_inside || is_near || far > 0.99 * wall(at()) {
            continue;
        }
        let at = at();
        assert!(found.id[at] != 0, "{name}: nothing over the middle of {:#x}", drop.number);
        let told = &now[&found.id[at]];
        let [told_far, far] = [told, drop].map(|d| d.center.distance(view.position));
        assert!(
            told_far < (far + told.radius) * (1.0 + 1e-5),
            "{name}: {:#x} at {told_far} hides {:#x} at {far}",
            told.number,
            drop.number
        );
        middles += 1;
    }
    assert!(middles > 500, "{name}: {middles}");
    // From the right eye the same drops are elsewhere, but where they are in the world; in the next frame they have fallen
    // on as they fall.
    let seconds = until.time - scene.time;
    let both =
        [(other_eye, from_right, 0.0), (next, then, seconds)].map(|(other, known, seconds)| {
            let seen: HashSet<u64> = other.id.iter().copied().filter(|id| *id != 0).collect();
            let mut both = 0;
            for id in &seen {
                let drop =
                    known.get(id).unwrap_or_else(|| panic!("{name}: no drop has number {id:#x}"));
                if let Some(same) = now.get(id) {
                    let expected = same.center + same.velocity * seconds;
                    // A drop of a box comes back on its other side.
                    let off = drop.center - expected;
                    let sizes = scene.populations().into_iter().map(|rain| 2.0 * rain.half_extent);
                    let apart = sizes
                        .map(|size| (off - size * (off / size).round()).length())
                        .fold(off.length(), f64::min);
                    assert!(apart < 1e-4 * drop.center.length().max(1.0), "{name}: {apart} apart");
                    both += u32::from(drops.contains(id));
                }
            }
            both
        });
    println!(
        "{name}: {} drops, {moved} pixels in motion, {both:?} drops in both eyes and both frames",
        drops.len()
    );
    assert!(drops.len() > 100 && moved > 100 && both.iter().all(|both| *both > 60), "{name}");
}

#[test]
fn numbers_depths_and_motions_are_those_of_the_drops() {
    on_device(|device| {
        hold_against_the_cpu(device, "box, fast", &in_a_box(Preset::Fast));
        hold_against_the_cpu(device, "box, exact", &in_a_box(Preset::Exact));
        hold_against_the_cpu(device, "two populations", &of_two(Preset::Fast));
        hold_against_the_cpu(device, "real", &real(Preset::Fast));
        hold_against_the_cpu(device, "real, exact", &real(Preset::Exact));
        for preset in [Preset::Fast, Preset::Exact] {
            let mut before_a_wall = in_a_box(preset);
            plate(&mut before_a_wall, "numbers");
            before_a_wall.background.color = None;
            hold_against_the_cpu(device, &format!("before a wall, {preset}"), &before_a_wall);
        }
        // Beyond 2^32 cells of the smallest from where the cells begin to count.
        let mut far = real(Preset::Fast);
        let away = DVec3::new(3e8, 40.0, -7e8);
        far.camera.position += away;
        far.camera.target += away;
        far.drops.clear();
        hold_against_the_cpu(device, "real, far away", &far);
    });
}

#[test]
fn a_drop_that_is_behind_the_camera_by_then_has_no_motion() {
    on_device(|device| {
        let mut scene = base(Preset::Fast);
        scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.5, 0.2, -2.0), 0.3)];
        let moved = |motion: [half::f16; 2]| motion.map(|m| m.to_f64()) != [0.0; 2];
        for (forward, expected) in [(1.0, true), (4.0, false)] {
            let mut until = scene.clone();
            until.camera.position.z -= forward;
            until.camera.target.z -= forward;
            let found = layers(device, &scene, &until);
            let told = found.id.iter().zip(&found.motion).filter(|(id, _)| **id != 0);
            let moves: Vec<bool> = told.map(|(_, motion)| moved(*motion)).collect();
            assert!(moves.len() > 50 && moves.iter().all(|is| *is == expected), "{forward}");
        }
    });
}

/// A way of half a pixel: no streak, but a splat that tells its place otherwise than one at rest.
#[test]
fn drops_that_move_a_little_have_layers_where_they_are_seen() {
    let mut scene = in_a_box(Preset::Fast);
    scene.drops.clear();
    scene.camera.shutter = 0.001;
    on_device(|device| {
        let until = Scene { time: scene.time + scene.camera.shutter, ..scene.clone() };
        let found = layers(device, &scene, &until);
        let mut covered = 0;
        for (count, [.., alpha]) in found.count.iter().zip(&found.color) {
            let is_seen = alpha.to_f32() > 0.004;
            assert!(!is_seen || *count > 0, "opacity {alpha}, and no drop");
            covered += u32::from(is_seen);
        }
        let told = found.count.iter().filter(|count| **count > 0).count();
        println!("{covered} pixels of {told} with drops are covered");
        assert!(covered > 500 && told < covered as usize * 3 / 2, "{covered} of {told}");
    });
}

/// Streaks and blur: every number has its line, whose centre is that of the middle of the exposure, and whose box bounds
/// what is drawn.
#[test]
fn lines_bound_what_moves_and_is_out_of_focus() {
    // The last: by how many pixels a drop's smoothed edge, or its blur's, may reach beyond its box.
    let cases = [
        ("box", in_a_box(Preset::Exact), 0.05, 0.0, 1),
        ("real", real(Preset::Exact), 1.0 / 60.0, 0.0, 1),
        ("lens", in_a_box(Preset::Exact), 0.0, 3.0, 4),
    ];
    on_device(|device| {
        for (name, mut scene, shutter, aperture, margin) in cases {
            (scene.camera.shutter, scene.camera.aperture) = (shutter, aperture);
            scene.camera.focus = 30.0;
            let until = Scene { time: scene.time + shutter, ..scene.clone() };
            let (found, lines) = (layers(device, &scene, &until), by_number(&scene));
            let at_rest = Scene {
                camera: Camera { shutter: 0.0, aperture: 0.0, ..scene.camera },
                ..scene.clone()
            };
            let at_rest = by_number(&at_rest);
            let (view, mut farther, mut told) = (scene.view(), 0, HashSet::new());
            for at in (0..(EDGE * EDGE)).filter(|at| found.id[*at as usize] != 0) {
                let (id, depth) = (found.id[at as usize], f64::from(found.depth[at as usize]));
                let drop = lines.get(&id).unwrap_or_else(|| panic!("{name}: no line for {id:#x}"));
                let is_within = |[left, top, right, bottom]: [u32; 4]| {
                    let (column, row) = (at % EDGE, at / EDGE);
                    column + margin >= left
                        && column < right + margin
                        && row + margin >= top
                        && row < bottom + margin
                };
                assert!(is_within(drop.pixels), "{name}: pixel {at} is not in {drop:?}");
                let planar = -(drop.center - view.position).dot(view.back);
                assert!((depth - planar).abs() < 1e-4 * planar, "{name}: {depth}, not {planar}");
                farther += u32::from(at_rest.get(&id).is_none_or(|drop| !is_within(drop.pixels)));
                told.insert(id);
            }
            println!("{name}: {} drops; {farther} pixels beside the drop at rest", told.len());
            assert!(told.len() > 100 && farther > 100, "{name}");
        }
    });
}

#[test]
fn every_drop_over_a_pixel_is_counted() {
    let row = [(-1.2, -4.0), (0.0, -4.0), (0.0, -6.0), (1.4, -4.0), (1.4, -5.0), (1.4, -7.0)];
    // Larger than a splat, and splats.
    for radius in [0.3, 0.05] {
        let mut scene = base(Preset::Fast);
        let drop =
            |(x, z): (f64, f64)| PlacedDrop::sphere(DVec3::new(x * -z / 4.0, 0.0, z), radius);
        scene.drops = row.map(drop).to_vec();
        count_drops(scene);
    }
}

fn count_drops(mut scene: Scene) {
    on_device(|device| {
        let found = layers(device, &scene, &scene);
        let view = scene.view();
        let at = |x: f64| {
            let place = view.point(DVec3::new(x, 0.0, -4.0)).0;
            (place.y as u32 * EDGE + place.x as u32) as usize
        };
        // The nearest of each stack, by its place in the scene.
        for (x, count, number) in [(-1.2, 1, 1), (0.0, 2, 2), (1.4, 3, 4), (0.7, 0, 0)] {
            assert_eq!((found.count[at(x)], found.id[at(x)]), (count, number), "at {x}");
        }
        for (at, (count, [.., alpha])) in found.count.iter().zip(&found.color).enumerate() {
            assert_eq!(*count > 0, alpha.to_f32() > 0.0, "pixel {at}: {count} drops, {alpha}");
        }
        // Before the whole but the first of each stack.
        scene.background.depth = Some(emptied_folder("layers/count").join("depth.exr"));
        let mut depth = Layers::empty(EDGE, EDGE);
        depth.depth.fill(4.5);
        depth.write_depth(scene.background.depth.as_deref().expect("named")).expect("a depth");
        let found = layers(device, &scene, &scene);
        for (x, count) in [(-1.2, 1), (0.0, 1), (1.4, 1)] {
            assert_eq!(found.count[at(x)], count, "at {x}");
        }
    });
}

#[test]
fn parts_are_the_whole() {
    let scene = in_a_box(Preset::Fast);
    let sky = waves();
    let plan = plan(&scene, &sky, Output::Layers).expect("a plan");
    on_device(|device| {
        let until = Scene { time: scene.time + 0.04, ..scene.clone() };
        let whole = layers(device, &scene, &until);
        let mut parts = Parts::new(device, &sky, &plan);
        parts.move_until(until);
        let mut together = Layers::empty(EDGE, EDGE);
        parts
            .draw_all(&scene, Grid { columns: 2, rows: 3 }, &mut |origin, renderer, _| {
                together.place(origin, &renderer.read_layers()?);
                Ok(())
            })
            .expect("parts");
        assert!(together == whole, "the parts are not the whole");
    });
}

#[test]
fn a_file_has_the_channels_that_compositors_read() {
    let folder = emptied_folder("layers/file");
    write_scene(&folder);
    let (is_done, said) =
        run(&folder, &["render", "scene.toml", "--layers", "--frames", "2", "-o", "rain.exr"]);
    assert!(is_done, "{said}");
    let image = crate::common::exr_layer(&folder.join("rain-0000.exr"));
    let list = &image.layer_data.channel_data.list;
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    let expected = [
        "A", "B", "G", "R", "Z", "count", "id", "id.high", "id.low", "id.top", "id24.X", "id24.Y",
        "id24.Z", "id_high", "motion.X", "motion.Y",
    ];
    assert_eq!(names, expected);
    let text = std::fs::read_to_string(folder.join("rain-0001.json")).expect("beside it");
    let beside: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(beside["format"], "raindrops-layers/1");
    documented_keys("raindrops-layers/1", &[&beside, &beside["camera"], &beside["drops"][0]]);
    assert!(beside["drops"].as_array().is_some_and(|drops| !drops.is_empty()));
    assert!((beside["time"].as_f64().expect("a time") - 1.0 / 30.0).abs() < 1e-9);
    assert!((beside["until"].as_f64().expect("a time") - 2.0 / 30.0).abs() < 1e-9);
    // A sequence of layers is not one of pictures.
    let (is_done, said) =
        run(&folder, &["render", "scene.toml", "--resume", "--frames", "2", "-o", "rain.exr"]);
    assert!(!is_done && said.contains("layers"), "{said}");
    for (arguments, told) in [
        (vec!["--layers", "-o", "rain.png"], "layers are written as .exr"),
        (vec!["--layers", "--preset", "fast", "--depth", "none.exr", "-o", "x.exr"], "none.exr"),
        (vec!["--layers", "--primitive", "point", "-o", "x.exr"], "tile"),
    ] {
        let (is_done, said) =
            run(&folder, &[&["render", "scene.toml"], arguments.as_slice()].concat());
        assert!(!is_done && said.contains(told), "{arguments:?}: {said}");
        assert!(!folder.join("x.exr").exists() && !folder.join("x.json").exists());
    }
}

/// Every number from channels of float32, as Blender and Nuke hold them.
#[test]
fn numbers_are_exact_in_float32() {
    let folder = emptied_folder("layers/float32");
    for (name, ids, parts) in [
        ("narrow", [0, 1, (1 << 24) + 1, u64::from(u32::MAX)], 2),
        ("wide", [0, (1 << 48) + 1, u64::MAX, 0x0123_4567_89ab_cdef], 3),
    ] {
        let mut layers = Layers::empty(2, 2);
        (layers.id, layers.has_wide_ids) = (ids.to_vec(), name == "wide");
        let path = folder.join(format!("{name}.exr"));
        layers.write_exr(&path).expect("written");
        let image = crate::common::exr_layer(&path);
        let list = &image.layer_data.channel_data.list;
        for family in [["id.low", "id.high", "id.top"], ["id24.X", "id24.Y", "id24.Z"]] {
            let mut found = [0_u64; 4];
            for (number, part) in family[..parts].iter().enumerate() {
                let channel = list.iter().find(|channel| channel.name.to_string() == *part);
                let exr::prelude::FlatSamples::F32(values) =
                    &channel.expect("a channel").sample_data
                else {
                    panic!("{part} is not float32");
                };
                for (found, value) in found.iter_mut().zip(values) {
                    assert_eq!(value.fract(), 0.0);
                    *found += (*value as u64) << (24 * number);
                }
            }
            assert_eq!(found, ids, "{name}");
            let is_there = |part: &&str| list.iter().any(|each| each.name.to_string() == *part);
            assert!(!family[parts..].iter().any(is_there), "{name}: {family:?}");
        }
    }
}
