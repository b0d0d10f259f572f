//! Data sets by the command: shards that are the whole, a plate that is stored once, and what is refused.

use std::path::{Path, PathBuf};

use glam::Vec3;
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::picture::plate::Plate;
use raindrops::scene::background::Background;

use crate::common::{documented_keys, emptied_folder, run, write_scene};

/// Every file of a folder, by its path within it.
pub fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.is_file() {
                let name = path.strip_prefix(folder).expect("within").to_path_buf();
                found.push((name, std::fs::read(&path).expect("a file")));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn shards_together_are_the_data_set() {
    let folder = emptied_folder("data-sets/shards");
    write_scene(&folder);
    let make = |output: &str, shard: &str| {
        let views = ["--views", "3", "--rates", "5,50", "--shard", shard, "-o", output];
        let (is_done, said) =
            run(&folder, &[&["dataset", "scene.toml"], views.as_slice()].concat());
        assert!(is_done, "{said}");
    };
    make("whole", "1/1");
    make("parts", "2/2");
    assert!(!folder.join("parts/manifest.jsonl").exists());
    make("parts", "1/2");
    let whole = files(&folder.join("whole"));
    assert_eq!(whole.len(), 2 + 3 * 6);
    // A set that is there whole is of its scene, too.
    let other = ["--views", "3", "--rates", "5,60", "-o", "whole"];
    let (is_done, said) = run(&folder, &[&["dataset", "scene.toml"], other.as_slice()].concat());
    assert!(!is_done && said.contains("50.0") && said.contains("60.0"), "{said}");
    assert!(whole == files(&folder.join("parts")), "the shards are not the whole");
    // What is missing is made again.
    std::fs::remove_dir_all(folder.join("parts/00001")).expect("removed");
    make("parts", "1/1");
    assert!(whole == files(&folder.join("parts")));
    let manifest =
        std::fs::read_to_string(folder.join("whole/manifest.jsonl")).expect("a manifest");
    let rates: Vec<f64> = manifest
        .lines()
        .map(|line| {
            let record: serde_json::Value = serde_json::from_str(line).expect("JSON");
            let file = record["files"]["rainy"].as_str().expect("a file");
            assert!(folder.join("whole").join(file).exists());
            documented_keys("raindrops-dataset/1", &[&record, &record["files"]]);
            assert!(record["optics"].is_string() && record["samples"].as_u64() > Some(0));
            assert!(record["cutoff_px"].as_f64() > Some(0.0), "{record}");
            record["rate_mm_h"].as_f64().expect("a rate")
        })
        .collect();
    assert!(rates.len() == 3 && rates.iter().all(|rate| (5.0..=50.0).contains(rate)), "{rates:?}");
    assert!(rates[0] != rates[1]);
    for (arguments, told) in [
        (vec!["--shard", "0/2"], "shard"),
        (vec!["--shard", "3/2"], "shard"),
        (vec!["--rates", "9,3"], "two numbers"),
        (vec!["--rates", "2,5000"], "rate = 5000"),
        (vec!["--turn", "400"], "0 to 180"),
        (vec!["--views", "0"], "--views"),
        (vec!["--depth", "none.exr"], "none.exr"),
        (vec!["--turn", "9", "--depth", "none.exr"], "leave it out"),
        (vec!["--preset", "paper"], "take preset fast"),
        (vec!["--tiles", "99x2"], "99 x 2 parts"),
    ] {
        let all = [&["dataset", "scene.toml", "-o", "bad"], arguments.as_slice()].concat();
        let (is_done, said) = run(&folder, &all);
        assert!(!is_done && said.contains(told), "{arguments:?}: {said}");
        let problems = said.lines().filter(|line| line.starts_with("raindrops:")).count();
        assert!(problems == 1 && !folder.join("bad").exists(), "{said}");
    }
    // Three rates, a part of the range each; 10 for the factor of ten, so by their logarithms.
    let mut places: Vec<f64> = rates.iter().map(|rate| (rate / 5.0).log10()).collect();
    places.sort_by(f64::total_cmp);
    let gaps = [places[1] - places[0], places[2] - places[1], 1.0 + places[0] - places[2]];
    assert!(gaps.iter().all(|gap| *gap > 0.2), "{rates:?}");
    // Without lists of drops, nothing else differs.
    let bare = ["--views", "1", "--rates", "5,50", "--no-drop-lists", "-o", "bare"];
    let (is_done, said) = run(&folder, &[&["dataset", "scene.toml"], bare.as_slice()].concat());
    assert!(is_done, "{said}");
    let (bare, of_whole) = (folder.join("bare/00000"), folder.join("whole/00000"));
    assert!(!bare.join("layers.json").exists());
    let read = |path: PathBuf| std::fs::read(path).expect("a file");
    assert!(read(bare.join("layers.exr")) == read(of_whole.join("layers.exr")));
    let line = String::from_utf8(read(bare.join("view.json"))).expect("text");
    assert!(!line.contains("\"drops\""), "{line}");
    // With masks there is a file more in each view, and the rest is the same; in parts, too.
    let make_masks = |output: &str, more: &[&str]| {
        let masked = ["--views", "3", "--rates", "5,50", "--masks", "-o", output];
        let all = [&["dataset", "scene.toml"], &masked[..], more].concat();
        let (is_done, said) = run(&folder, &all);
        assert!(is_done, "{said}");
        files(&folder.join(output))
    };
    let masked = make_masks("masked", &[]);
    assert!(
        masked == make_masks("masked-parts", &["--tiles", "2x3"]),
        "the parts are not the whole"
    );
    assert_eq!(masked.len(), whole.len() + 3);
    let is_picture = |(path, _): &&(PathBuf, Vec<u8>)| {
        path.extension().is_some_and(|e| e == "exr") && !path.ends_with("mask.exr")
    };
    assert!(masked.iter().filter(is_picture).eq(whole.iter().filter(is_picture)));
    let line = std::fs::read_to_string(folder.join("masked/00002/view.json")).expect("a line");
    let record: serde_json::Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(record["files"]["mask"], "00002/mask.exr");
    documented_keys("raindrops-dataset/1", &[&record, &record["files"]]);
    masks_are_of_drops_over_their_medium(&folder);
    // A view's own scene draws it again.
    let again = ["render", "whole/00001/scene.toml", "--layers", "-o", "again.exr"];
    let (is_done, said) = run(&folder, &again);
    assert!(is_done, "{said}");
    let of_view = folder.join("whole/00001/layers.exr");
    assert!(read(folder.join("again.exr")) == read(of_view), "the view is another");
    let (is_done, said) = run(&folder, &["dataset", "scene.toml", "--views", "4", "-o", "whole"]);
    assert!(!is_done && said.contains("something else"), "{said}");
}

/// The view's own scene with its rain as a medium, drawn by `render`, says what the masks are.
fn masks_are_of_drops_over_their_medium(folder: &Path) {
    let scene = folder.join("masked/00002/scene.toml");
    let text = std::fs::read_to_string(&scene).expect("a scene");
    let mut toml: toml::Table = text.parse().expect("TOML");
    let camera = toml["camera"].as_table_mut().expect("a camera");
    camera.insert("near".into(), 1e4.into());
    std::fs::write(folder.join("misty.toml"), toml.to_string()).expect("a scene");
    let misty = ["render", "misty.toml", "--layers", "--far-rain", "medium", "--cutoff-px", "1"];
    let (is_done, said) = run(folder, &[&misty[..], &["-o", "misty.exr"]].concat());
    assert!(is_done, "{said}");
    let view = |name: &str| folder.join("masked/00002").join(name);
    let of = |path: &Path, name: &str| channel(path, name);
    let clean = ["R", "G", "B"].map(|name| of(&view("clean.exr"), name));
    let seen = |path: &Path| -> (Vec<f32>, Vec<f32>) {
        let passes: Vec<f32> = of(path, "A").iter().map(|a| 1.0 - a).collect();
        let colors = ["R", "G", "B"].map(|name| of(path, name));
        let light = |at: usize| {
            let color = |c: usize| colors[c][at] + passes[at] * clean[c][at];
            0.2126 * color(0) + 0.7152 * color(1) + 0.0722 * color(2)
        };
        let light = (0..passes.len()).map(light).collect();
        (passes, light)
    };
    let ((rain, rainy), (medium, misty)) =
        (seen(&view("layers.exr")), seen(&folder.join("misty.exr")));
    let mean = misty.iter().sum::<f32>() / misty.len() as f32;
    let (opacity, contrast) = (of(&view("mask.exr"), "opacity"), of(&view("mask.exr"), "contrast"));
    for at in 0..rain.len() {
        let share = 1.0 - rain[at] / medium[at];
        assert!((opacity[at] - share).abs() < 1e-3, "{at}: {} {share}", opacity[at]);
        let apart = (rainy[at] - misty[at]).abs() / (misty[at] + 0.02 * mean);
        assert!(
            (contrast[at] - apart).abs() < 2e-3 * (1.0 + apart),
            "{at}: {} {apart}",
            contrast[at]
        );
    }
    // Drops are in the view, and haze is not taken for them.
    let single = of(&view("layers.exr"), "count");
    let mean = |has_drop: bool| {
        let all = opacity.iter().zip(&single).filter(|(_, count)| (**count > 0.0) == has_drop);
        let (sum, count) = all.fold((0.0, 0), |(sum, n), (opacity, _)| (sum + opacity, n + 1));
        sum / count as f32
    };
    assert!(mean(true) > 0.01 && mean(false).abs() < 0.01, "{} {}", mean(true), mean(false));
}

/// A channel of an EXR.
fn channel(path: &Path, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_first_flat_layer_from_file(path).expect("an EXR");
    let channels = image.layer_data.channel_data.list;
    let found = channels.iter().find(|channel| channel.name.eq(name)).expect("the channel");
    found.sample_data.values_as_f32().collect()
}

/// The plate and its depth are stored once, whichever shard comes first, and nothing behind it is drawn.
#[test]
fn a_data_set_before_a_plate_has_the_plate_once() {
    let folder = emptied_folder("data-sets/plates");
    write_scene(&folder);
    let pixels: Vec<Vec3> = (0..48 * 32).map(|at| Vec3::new((at % 7) as f32, 1.0, 2.0)).collect();
    let photo = Picture { width: 48, height: 32, pixels };
    photo.write_exr(&folder.join("photo.exr")).expect("a plate");
    let mut depth = Layers::empty(48, 32);
    depth
        .depth
        .iter_mut()
        .enumerate()
        .for_each(|(at, z)| *z = if at % 48 < 24 { 0.01 } else { 40.0 });
    depth.write_depth(&folder.join("depth.exr")).expect("a depth");
    let make = |output: &str, shard: &str| {
        let arguments =
            ["dataset", "scene.toml", "--background", "photo.exr", "--depth", "depth.exr"];
        let of = ["--views", "2", "--shard", shard, "-o", output];
        let (is_done, said) = run(&folder, &[&arguments[..], &of].concat());
        assert!(is_done && said.contains("is guessed from photo.exr"), "{said}");
    };
    make("whole", "1/1");
    make("parts", "2/2");
    make("parts", "1/2");
    // Elsewhere the same files are the same.
    std::fs::create_dir_all(folder.join("moved")).expect("a folder");
    for name in ["photo.exr", "depth.exr"] {
        std::fs::copy(folder.join(name), folder.join("moved").join(name)).expect("copied");
    }
    let moved = ["--background", "moved/photo.exr", "--depth", "moved/depth.exr"];
    let again = [&["dataset", "scene.toml", "--views", "2", "-o", "whole"], &moved[..]].concat();
    let (is_done, said) = run(&folder, &again);
    assert!(is_done, "{said}");
    let whole = files(&folder.join("whole"));
    assert_eq!(whole.len(), 2 + 2 + 2 * 5);
    assert!(whole == files(&folder.join("parts")), "the shards are not the whole");
    let set = folder.join("whole");
    let clean = Picture::read(&set.join("plate/clean.exr")).expect("the plate");
    // Float16 holds these.
    assert!(clean == photo, "without rain it is the plate");
    let manifest = std::fs::read_to_string(set.join("manifest.jsonl")).expect("a manifest");
    for line in manifest.lines() {
        let record: serde_json::Value = serde_json::from_str(line).expect("JSON");
        let file = |name: &str| set.join(record["files"][name].as_str().expect("a file"));
        assert_eq!(file("clean"), set.join("plate/clean.exr"));
        let stored = Background { depth: Some(file("depth")), ..Background::default() };
        let stored = Plate::open(&stored, 48, 32).expect("a depth");
        let expected = depth.depth.iter().map(|z| f64::from(*z));
        assert!(stored.depth().is_some_and(|stored| stored.values.iter().copied().eq(expected)));
        // A wall at a hundredth of a metre hides all.
        let rainy = Picture::read(&file("rainy")).expect("a picture");
        let differ = |half: u32| {
            let all = rainy.pixels.iter().zip(&clean.pixels).enumerate();
            all.filter(|(at, (a, b))| *at as u32 % 48 / 24 == half && a != b).count()
        };
        assert!(differ(0) == 0 && differ(1) > 20, "{} and {} pixels", differ(0), differ(1));
    }
}

/// `--shutter` takes the place of both of the scene's keys, and what is drawn is exposed for it.
#[test]
fn an_exposure_is_given_by_an_option() {
    let folder = emptied_folder("data-sets/shutter");
    write_scene(&folder);
    let text = std::fs::read_to_string(folder.join("scene.toml")).expect("a scene");
    let scene = |name: &str, key: &str| {
        std::fs::write(folder.join(name), format!("{text}[camera]\n{key}\n")).expect("a scene");
    };
    scene("exposed.toml", "shutter = 0.02");
    scene("angle.toml", "shutter_angle = 90.0");
    let draw = |arguments: &[&str]| {
        let rain = ["--rate", "150", "-o", "rain.exr"];
        let (is_done, said) = run(&folder, &[&["render"], arguments, &rain].concat());
        assert!(is_done, "{said}");
        std::fs::read(folder.join("rain.exr")).expect("a picture")
    };
    let (instant, exposed) = (draw(&["scene.toml"]), draw(&["exposed.toml"]));
    assert!(instant != exposed && exposed == draw(&["angle.toml", "--shutter", "1/50"]));
    assert!(instant == draw(&["exposed.toml", "--shutter", "0"]));
    for wrong in ["1/0", "-0.1", "1/60s"] {
        let shutter = format!("--shutter={wrong}");
        let (is_done, said) = run(&folder, &["render", "scene.toml", &shutter, "-o", "no.exr"]);
        assert!(!is_done && said.contains("is no time such as 1/60"), "{said}");
    }
}

/// Where there is no medium, masks are those of the drops alone: of drops in a box, and of real rain without its far part.
#[test]
fn masks_without_a_medium_are_the_opacity() {
    let folder = emptied_folder("data-sets/no-medium");
    write_scene(&folder);
    let text = "[image]\nwidth = 48\nheight = 32\n[rain]\ncount = 3000\nhalf_extent = [20.0, 20.0, 20.0]\nradius = 0.1\n[model]\npreset = \"fast\"\n";
    std::fs::write(folder.join("box.toml"), text).expect("a scene");
    for (scene, more) in
        [("box.toml", &[][..]), ("scene.toml", &["--rate", "200", "--far-rain", "none"])]
    {
        let output = format!("{scene}-set");
        let views = ["dataset", scene, "--masks", "--views", "1", "-o", &output];
        let (is_done, said) = run(&folder, &[&views[..], more].concat());
        assert!(is_done, "{said}");
        let view = |name: &str| folder.join(&output).join("00000").join(name);
        let covered = channel(&view("layers.exr"), "A");
        assert!(covered.iter().any(|a| *a > 0.1) && covered.contains(&0.0), "{scene}");
        let opacity = channel(&view("mask.exr"), "opacity");
        let largest = opacity.iter().zip(&covered).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(largest < 1e-3, "{scene}: {largest}");
        let contrast = channel(&view("mask.exr"), "contrast");
        // Light of a glint may fall beside its drop.
        let beside = contrast.iter().zip(&covered).filter(|(seen, a)| **a == 0.0 && **seen > 1e-3);
        assert!(beside.count() < 8, "{scene}");
    }
}

/// Drops that are larger than a pixel are in no medium, and wholly in the masks.
#[test]
fn near_drops_are_in_the_masks() {
    let folder = emptied_folder("data-sets/near");
    write_scene(&folder);
    let large = ["--size", "480x320", "--rate", "200", "--diameters", "3,6"];
    let set = ["dataset", "scene.toml", "--masks", "--views", "1", "--turn", "0", "-o", "set"];
    let (is_done, said) = run(&folder, &[&set[..], &large].concat());
    assert!(is_done, "{said}");
    let view = |name: &str| folder.join("set/00000").join(name);
    let covered = channel(&view("layers.exr"), "A");
    let opacity = channel(&view("mask.exr"), "opacity");
    let within = opacity.iter().zip(&covered).filter(|(_, a)| **a > 0.99).map(|(of, _)| of);
    let (count, least) = within.fold((0, 1.0f32), |(n, least), of| (n + 1, least.min(*of)));
    assert!(count > 20 && least > 0.9, "{count} pixels, {least}");
}

/// A drop of 60 degrees on a pane of no thickness square on covers a disc. Its middle and radius by hand: of 64 pixels at 40 degrees
/// a length of 1 at a depth of 1 has 32 / tan(20).
#[test]
fn drops_on_a_pane_are_apart_from_rain() {
    let folder = emptied_folder("data-sets/pane");
    let scene = "seed = 3\n[image]\nwidth = 64\nheight = 64\n[camera]\nposition = [0, 0, 0.3]\ntarget = [0, 0, 0]\n\
                 vertical_fov = 40.0\n[[drop]]\ncenter = [0, 0.2, -1]\nradius = 0.15\n[pane]\npoint = [0, 0, 0]\n\
                 normal = [0, 0, -1]\nthickness = 0\ninside = [0.5, 0.5, 0.5]\n[[pane.drop]]\nat = [-0.03, 0.02]\nradius = 0.025\n\
                 contact_angle = 60.0\n";
    std::fs::write(folder.join("pane.toml"), scene).expect("a scene");
    let arguments =
        ["dataset", "pane.toml", "--views", "1", "--masks", "--preset", "exact", "-o", "set"];
    let (is_done, said) = run(&folder, &arguments);
    assert!(is_done, "{said}");
    let set = folder.join("set");
    let line = std::fs::read_to_string(set.join("manifest.jsonl")).expect("a manifest");
    let record: serde_json::Value = serde_json::from_str(&line).expect("JSON");
    documented_keys("raindrops-dataset/1", &[&record, &record["files"]]);
    let beside = std::fs::read_to_string(set.join("00000/layers.json")).expect("a file");
    let beside: serde_json::Value = serde_json::from_str(&beside).expect("JSON");
    documented_keys("raindrops-layers/1", &[&beside, &beside["pane"], &beside["pane"]["drops"][0]]);

    let focal = 32.0 / 20.0_f64.to_radians().tan() / 0.3;
    let (across, down, radius) = (32.0 - 0.03 * focal, 32.0 - 0.02 * focal, 0.025 * focal);
    let file = |name: &str| set.join(record["files"][name].as_str().expect("a file"));
    let glass = channel(&file("mask"), "pane");
    assert_eq!(glass, channel(&file("layers"), "pane.A"));
    let (mut sum, mut touched) = (0.0, 0);
    for (at, share) in glass.iter().enumerate() {
        let (x, y) = ((at % 64) as f64 + 0.5, (at / 64) as f64 + 0.5);
        let apart = (x - across).hypot(y - down) - radius;
        if apart.abs() > 0.75 {
            assert_eq!(*share, if apart < 0.0 { 1.0 } else { 0.0 }, "{x}, {y}");
        }
        sum += f64::from(*share);
        touched += u32::from(*share > 0.0);
    }
    let area = std::f64::consts::PI * radius * radius;
    assert!((sum / area - 1.0).abs() < 0.01, "{sum} for {area}");
    assert!((record["pane_cover"].as_f64().expect("a share") - sum / 4096.0).abs() < 1e-6);
    assert_eq!((&record["pane_pixels"], &record["pane_drops"]), (&touched.into(), &1.into()));

    // The drop in the air is in the other channels; the mask has what of it is not behind the drop on the glass.
    let (opacity, count) = (channel(&file("mask"), "opacity"), channel(&file("layers"), "count"));
    let is_hidden = |(glass, air): (&f32, &f32)| *air <= 1.0 - glass + 2e-3;
    assert!(glass.iter().zip(&opacity).all(is_hidden));
    assert!(opacity.iter().filter(|share| **share > 0.99).count() > 100);
    let behind = count.iter().zip(&glass).filter(|(count, glass)| **count > 0.0 && **glass == 1.0);
    assert!(behind.count() > 20);

    // Clean is what is behind through the dry pane: the drop aside, the picture is that where no rain is.
    let [clean, behind, rainy] =
        ["clean", "behind", "rainy"].map(|name| Picture::read(&file(name)).expect("a picture"));
    let mut without = 0;
    for at in 0..4096 {
        assert_ne!(clean.pixels[at], behind.pixels[at]);
        let apart = (rainy.pixels[at] - clean.pixels[at]).abs().max_element();
        if glass[at] == 0.0 && opacity[at] == 0.0 {
            assert!(apart < 2e-3 * clean.pixels[at].max_element(), "{at}: {apart}");
            without += 1;
        }
    }
    assert!(without > 2000, "{without}");
}

/// Through a pane that the scene does not have: another age and other drops in each view.
#[test]
fn views_look_through_a_pane_that_was_wiped_some_time_ago() {
    let folder = emptied_folder("data-sets/wiped");
    let scene = "[image]\nwidth = 48\nheight = 48\n[rain]\nrate = 20.0\nextent = 3.0\n";
    std::fs::write(folder.join("rain.toml"), scene).expect("a scene");
    let arguments = ["dataset", "rain.toml", "--views", "4", "--preset", "fast", "--no-drop-lists"];
    let (is_done, said) =
        run(&folder, &[&arguments[..], &["--pane-ages", "2,32", "-o", "set"]].concat());
    assert!(is_done, "{said}");
    let set = folder.join("set");
    let lines = std::fs::read_to_string(set.join("manifest.jsonl")).expect("a manifest");
    let records: Vec<serde_json::Value> =
        lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    documented_keys("raindrops-dataset/1", &[&records[0], &records[0]["files"]]);
    let figures = |name: &str| {
        let figure = |record: &serde_json::Value| record[name].as_f64().expect("a number");
        let mut found: Vec<f64> = records.iter().map(figure).collect();
        found.sort_by(f64::total_cmp);
        found
    };
    // Four ages, spread over the four doublings: by the logarithm.
    let ages = figures("pane_age_s");
    assert!(ages[0] >= 2.0 && ages[3] <= 32.0 && ages[3] > 6.0 * ages[0], "{ages:?}");
    assert!(ages[1] < 12.0, "{ages:?}");
    let covers = figures("pane_cover");
    assert!(covers[0] > 0.0 && covers[3] > 2.0 * covers[0] && covers[3] < 0.6, "{covers:?}");
    // Each view as a scene has the pane that was drawn.
    let text = std::fs::read_to_string(set.join("00002/scene.toml")).expect("a scene");
    let age = records[2]["pane_age_s"].as_f64().expect("an age");
    let view = raindrops::scene::Scene::parse(&text, "scene.toml").expect("a scene");
    let pane = view.pane.expect("a pane");
    assert_eq!((pane.age, pane.distance, pane.tilt), (Some(age), Some(0.2), Some(30.0)));
    // Another range is another set.
    let (is_done, said) =
        run(&folder, &[&arguments[..], &["--pane-ages", "2,40", "-o", "set"]].concat());
    assert!(!is_done && said.contains("32.0") && said.contains("40.0"), "{said}");
    let (is_done, said) =
        run(&folder, &[&arguments[..], &["--pane-ages", "2,1e9", "-o", "x"]].concat());
    assert!(!is_done && said.contains("--pane-ages") && !folder.join("x").exists(), "{said}");
}
