//! Binning, fragments and composite of the frame by tiles, each against its serial implementation (`tile_serial.rs`), on
//! random drops and on extreme ones.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use half::f16;
use raindrops::plan::{Output, plan};
use raindrops::rain::clusters::{CLUSTER, Clusters};
use raindrops::rain::cull::drops_with_visibility;
use raindrops::renderer::Lighting;
use raindrops::renderer::tile_stages::TileStages;
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Population, RainSettings, Scene};

use crate::common::{Random, on_device, waves};
use crate::tile_entries::{Entry, PIXELS, lists, pixel, square};
use crate::tile_serial::{Kind, Shown, drops_in_view, over};

/// The last tiles have pixels beyond the edges.
const IMAGE: ImageSize = ImageSize { width: 94, height: 63 };

struct Case {
    name: String,
    scene: Scene,
    drops: Vec<Shown>,
    stages: TileStages,
    lists: Vec<([u32; 2], Vec<Entry>)>,
    /// The picture without drops.
    sky: Vec<[f16; 4]>,
}

/// All scenes, drawn once for the tests of this file.
fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| {
        let (mut cases, sky) = (Vec::new(), waves());
        on_device(|device| {
            let lighting = Lighting::new(device, &sky).expect("light");
            let draw = |scene: &Scene| {
                let plan = plan(scene, &sky, Output::Radiance).expect("a plan");
                (TileStages::draw(&lighting, scene, &plan).expect("stages"), plan)
            };
            for (name, scene) in scenes() {
                scene.validate(&name).expect("a valid scene");
                let (stages, plan) = draw(&scene);
                let (without, _) = draw(&Scene { rain: None, drops: Vec::new(), ..scene.clone() });
                let (drops, lists) = (drops_in_view(&scene, &plan), lists(&stages));
                cases.push(Case { name, scene, drops, stages, lists, sky: without.radiance });
            }
        });
        cases
    })
}

/// A view without drops.
fn empty(vertical_fov: f64, preset: Preset) -> Scene {
    let camera = Camera { vertical_fov, ..Camera::default() };
    let mut scene = Scene { rain: None, image: IMAGE, camera, ..Scene::default() };
    scene.model.preset = preset;
    scene
}

/// Adds a drop at a place in the picture, of a radius in pixels in its middle.
fn add(scene: &mut Scene, pixel: DVec2, radius_px: f64, depth: f64) {
    let (view, scale) = (scene.view(), depth / scene.view().focal_px);
    let plane = (pixel - view.principal) * scale;
    let center = view.position + plane.x * view.right - plane.y * view.up - depth * view.back;
    scene.drops.push(PlacedDrop::sphere(center, radius_px * scale));
}

fn random(seed: u64, preset: Preset) -> Scene {
    let mut random = Random(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let mut scene = empty(between(2.0, 25.0), preset);
    scene.camera.position = DVec3::new(between(-9.0, 9.0), between(-9.0, 9.0), 4.0);
    scene.camera.target = DVec3::new(between(-9.0, 9.0), between(-9.0, 9.0), 0.0);
    // Every third seed fades what is near.
    (scene.camera.near, scene.camera.near_fade) =
        (0.0, if seed.is_multiple_of(3) { 300.0 } else { 0.0 });
    let size = DVec2::new(IMAGE.width.into(), IMAGE.height.into());
    for _ in 0..300 {
        let place = size * DVec2::new(between(-0.1, 1.1), between(-0.1, 1.1));
        let (radius, depth) = (0.2 * between(0.0, 4.4).exp(), 100.0 * between(0.0, 2.2).exp());
        add(&mut scene, place, radius, depth);
    }
    scene
}

fn scenes() -> Vec<(String, Scene)> {
    let (fast, exact) = (Preset::Fast, Preset::Exact);
    let mut scenes: Vec<_> = [(1, fast), (2, fast), (3, fast), (4, exact)]
        .map(|(seed, preset)| (format!("random drops {seed}"), random(seed, preset)))
        .into();
    let mut draw = |name: &str, scene| scenes.push((name.into(), scene));
    let lattice = |count: u32| (0..count * count).map(move |n| (n % count, n / count));

    let mut small = empty(10.0, fast);
    for (n, (x, y)) in lattice(24).enumerate() {
        let place = DVec2::new(3.91 * f64::from(x), 2.63 * f64::from(y));
        add(&mut small, place, 0.5, 900.0 + n as f64);
    }
    draw("half a pixel", small);

    let mut large = empty(60.0, fast);
    for (n, (x, y)) in lattice(3).enumerate() {
        let place = DVec2::new(47.0 * f64::from(x), 31.5 * f64::from(y));
        add(&mut large, place, 31.0, 10.0 + n as f64);
    }
    draw("half the screen", large);

    for (name, radii) in
        [("on borders of tiles", [0.5, 1.0, 1.25, 4.0]), ("halves", [0.25, 0.75, 1.4, 6.0])]
    {
        let mut borders = empty(5.0, fast);
        for (n, (x, y)) in lattice(20).enumerate() {
            let place = DVec2::new(4.0 * f64::from(x + 2), 2.0 * f64::from(y + 5));
            add(&mut borders, place, radii[n % 4], 500.0 + n as f64);
        }
        draw(name, borders);
    }

    let mut edges = empty(12.0, fast);
    for (n, (x, y)) in lattice(9).enumerate() {
        let place = DVec2::new(11.75 * f64::from(x), 7.875 * f64::from(y));
        let radius = [0.3, 1.0, 1.6, 5.0][n % 4];
        // About the edges, on both sides and the corners.
        let aside = DVec2::new([-1.0, 0.0, 0.0, 1.0][n % 4], [0.0, 1.0, -1.0, 0.0][n % 4]) * radius;
        if x % 8 == 0 || y % 8 == 0 {
            add(&mut edges, place + aside, radius, 700.0 + n as f64);
        }
    }
    draw("at the screen's edges", edges);

    // Mirror images have the same distance, and all are there twice.
    let mut ties = empty(10.0, fast);
    let middle = ties.view().principal;
    for n in 0..240u32 {
        let sign = DVec2::new([1.0, -1.0][n as usize % 2], [1.0, -1.0][n as usize / 2 % 2]);
        let aside = sign * DVec2::new(0.3 + f64::from(n / 12), 0.2 + 0.4 * f64::from(n / 8));
        add(&mut ties, middle + aside, [1.2, 2.5, 0.6][n as usize / 4 % 3], 800.0);
    }
    ties.drops.extend(ties.drops.clone());
    draw("equally far", ties);

    // Thousands before one another, in no order.
    let mut long = empty(5.0, fast);
    for n in 0..3000u32 {
        let place = middle + 0.01 * DVec2::new(f64::from(n % 97), f64::from(n % 61));
        let radius = if n % 50 == 0 { 3.0 } else { 0.15 };
        add(&mut long, place, radius, 3000.0 + f64::from(n * 1237 % 3000));
    }
    draw("long lists", long);

    let mut beside = empty(90.0, fast);
    for center in [[1.3, 0.2, -0.6], [-1.1, 0.3, -0.1], [0.9, -0.9, 0.2], [-0.9, -2.2, -1.5]] {
        beside.drops.push(PlacedDrop::sphere(center.into(), 1.0));
    }
    draw("beside the camera", beside);

    for (seed, radius) in [(5, 0.6), (6, 0.05)] {
        let mut rain = empty(70.0, fast);
        let (count, half_extent) = (20_000, DVec3::splat(50.0));
        rain.rain = Some(RainSettings { count, half_extent, radius, ..RainSettings::default() });
        (rain.seed, rain.time) = (seed, 7.7);
        draw(&format!("rain of radius {radius}"), rain);
    }

    // A large drop's tangents are shorter than those of a small one that is as far.
    let mut two = empty(70.0, fast);
    let small = RainSettings {
        count: 4000,
        half_extent: DVec3::splat(50.0),
        radius: 0.6,
        ..RainSettings::default()
    };
    let RainSettings { half_extent, velocity, .. } = small;
    let large = Population { seed: None, count: 400, half_extent, radius: 4.0, velocity };
    two.rain = Some(RainSettings { others: [Some(large), None, None], ..small });
    draw("rain of two radii", two);
    scenes
}

#[test]
fn binning_enters_each_drop_into_the_tiles_that_it_touches() {
    for case in cases() {
        let mut entered = BTreeSet::new();
        for (tile, list) in &case.lists {
            for entry in list {
                let is_new = entered.insert((entry.key.1, *tile));
                assert!(is_new, "{}: {:?} is there twice", case.name, entry.key);
            }
        }
        let all = entered.len();
        for (tile, _) in &case.lists {
            let corner = square(pixel(*tile, 0)).low;
            for drop in &case.drops {
                let around = drop.outline.grown(1.0);
                let tile_end = corner + DVec2::new(4.0, 2.0);
                if around.high.cmplt(corner).any() || around.low.cmpgt(tile_end).any() {
                    continue;
                }
                let pixels = || (0..PIXELS).map(|number| pixel(*tile, number));
                let is_drawn = |[x, y]: &[u32; 2]| *x < IMAGE.width && *y < IMAGE.height;
                let is_entered = entered.remove(&(drop.index, *tile));
                let least = drop.tolerance();
                let must = || pixels().filter(is_drawn).any(|p| drop.coverage(square(p)) > least);
                let may = || pixels().any(|p| drop.may_reach(square(p)));
                let what =
                    || format!("{}: drop {} ({:?}) in {tile:?}", case.name, drop.index, drop.kind);
                assert!(is_entered || !must(), "{} is missing", what());
                assert!(!is_entered || may(), "{} is not there", what());
            }
        }
        assert!(entered.is_empty(), "{}: of drops not in view: {entered:?}", case.name);
        println!("{}: {all} entries of {} drops", case.name, case.drops.len());
        assert!(all >= 8, "{}: nothing to see", case.name);
    }
}

/// Clusters come band after band of depth, the farthest first, each of the same volume in any pixel's view.
#[test]
fn binning_takes_slabs_of_depth_in_order() {
    for case in cases().iter().filter(|case| case.scene.populations().len() == 1) {
        let clusters = Clusters::new(&case.scene.populations(), &[]);
        let extent = case.scene.populations()[0].half_extent.z;
        let depths: Vec<f64> =
            drops_with_visibility(&case.scene).map(|(v, ..)| -f64::from(v.z)).collect();
        // The first and the last band that each drop's cluster may be in: its box is rounded.
        let mut bands = BTreeMap::new();
        for cluster in clusters.order.chunks(CLUSTER as usize) {
            let of = || cluster.iter().filter_map(|index| depths.get(*index as usize)).copied();
            let [low, high] = [of().fold(f64::MAX, f64::min), of().fold(f64::MIN, f64::max)];
            let band = |off: f64| {
                let share = (0.5 * (low + high) / extent + off).clamp(0.0, 1.0);
                (share.powi(3) * f64::from(case.stages.bands)) as u32
            };
            // Some are on both sides of the box's far end.
            let both = if high - low > extent { [0, u32::MAX] } else { [band(-2e-3), band(2e-3)] };
            bands.extend(cluster.iter().map(|index| (*index, both)));
        }
        let mut steps = 0;
        for (tile, list) in &case.lists {
            // Entries that came with the larger drops, after all bands, are first.
            let by_bands = list.iter().filter(|entry| entry.node < clusters.order.len() as u32);
            let mut nearest = 0;
            for entry in by_bands {
                let [first, last] = bands[&entry.key.1];
                assert!(last >= nearest, "{}, {tile:?}: {:?} is too near", case.name, entry.key);
                steps += u32::from(first > nearest);
                nearest = nearest.max(first);
            }
        }
        println!("{}: {} bands, {steps} steps", case.name, case.stages.bands);
        assert!(case.stages.bands > 3 && steps > 300, "{}: {steps}", case.name);
    }
}

#[test]
fn fragments_are_what_covers_a_pixel_in_order() {
    for case in cases() {
        let drops: BTreeMap<u32, &Shown> =
            case.drops.iter().map(|drop| (drop.index, drop)).collect();
        let mut worst = BTreeMap::new();
        for (tile, list) in &case.lists {
            let mut list: Vec<_> = list.iter().map(|entry| (entry, drops[&entry.key.1])).collect();
            list.sort_by_key(|(entry, _)| entry.key);
            for (entry, drop) in &list {
                let what = || format!("{}: drop {} in {tile:?}", case.name, drop.index);
                assert_eq!(entry.is_splat(), drop.kind == Kind::Splat, "{}", what());
                for number in 0..PIXELS {
                    let (found, square) =
                        (entry.coverage(*tile, number), square(pixel(*tile, number)));
                    let exact = drop.coverage(square);
                    let off = (found - exact).abs();
                    let most = worst.entry(format!("{:?}", drop.kind)).or_insert(0f64);
                    *most = most.max(off);
                    assert!(off < drop.tolerance(), "{}, {number}: {found}, not {exact}", what());
                }
            }
            for pair in list.windows(2) {
                let [(_, near), (_, far)] = pair else { continue };
                let middle = square(pixel(*tile, 0)).low + DVec2::new(2.0, 1.0);
                let [near_is, far_is] = [near, far].map(|drop| drop.order_in(middle));
                let are_told = near.distance2 == near_is && far.distance2 == far_is;
                // A front that is nearly touched has fewer digits in float32.
                let rounding = if are_told { 1e-6 } else { 1e-5 };
                let is_before = near_is < far_is * (1.0 + rounding);
                assert!(is_before, "{}, {tile:?}: {} before {}", case.name, near.index, far.index);
                let is_tie = are_told && near_is == far_is;
                assert!(!is_tie || near.index < far.index, "{}: {}", case.name, near.index);
            }
        }
        println!("{}: off by {worst:.4?}", case.name);
    }
}

/// How far a picture is from that of the entries in an order, relative.
fn apart(case: &Case, in_order: impl Fn(&mut [&Entry])) -> f64 {
    let light = |half: [f16; 4]| DVec3::new(half[0].to_f64(), half[1].to_f64(), half[2].to_f64());
    let mut worst = 0f64;
    for (tile, list) in &case.lists {
        let mut list: Vec<&Entry> = list.iter().collect();
        in_order(&mut list);
        for number in 0..PIXELS {
            let [x, y] = pixel(*tile, number);
            if x >= IMAGE.width || y >= IMAGE.height {
                continue;
            }
            let at = (y * IMAGE.width + x) as usize;
            let fragments = list.iter().map(|entry| {
                (entry.light(*tile, number, &case.stages.splats), entry.coverage(*tile, number))
            });
            let exact = over(fragments, light(case.sky[at]));
            let off = (light(case.stages.radiance[at]) - exact).abs() / exact;
            worst = worst.max(off.max_element());
        }
    }
    worst
}

#[test]
fn the_composite_is_front_to_back_over_the_sky() {
    let mut turned = 0;
    for case in cases() {
        let off = apart(case, |list| list.sort_by_key(|entry| entry.key));
        println!("{}: off by {off:.1e}", case.name);
        // A half has eleven digits; some devices cut them off.
        assert!(off < 1.5e-3, "{}: {off}", case.name);
        // The control: back to front.
        turned += usize::from(apart(case, |list| list.sort_by_key(|e| Reverse(e.key))) > 0.01);
    }
    assert!(turned >= 9, "in {turned} scenes the order shows");
}
