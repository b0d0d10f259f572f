//! Shelter: which drops a surface keeps off, drop by drop, on GPU, CPU and in the reference, against geometry that is written out
//! here: a line meets the box of a texel's column or it does not.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::picture::Picture;
use raindrops::picture::heights::{HeightMap, NOTHING};
use raindrops::picture::layers::Layers;
use raindrops::plan::{Output, plan};
use raindrops::rain::cull::count_visible;
use raindrops::rain::field::{Field, ShownDrop};
use raindrops::rain::tick_of_seconds;
use raindrops::reference::{Ray, Tracer, Tree, Truth, of_scene};
use raindrops::renderer::Lighting;
use raindrops::renderer::tile_stages::TileStages;
use raindrops::scene::model::{FarRain, Preset};
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{Population, RainSettings, Scene, Shelter};

use crate::common::picture::{draw, renderer, renderer_of, square};
use crate::common::{Random, on_device, waves};
use crate::tile_entries::lists;

const FROM: [f64; 2] = [-700.0, -500.0];
const TO: [f64; 2] = [600.0, 400.0];

/// Columns of all heights beside each other, and holes: 13 by 7, so that no level of the map has pairs.
fn city() -> HeightMap {
    let mut random = Random(5);
    let height = |number: usize| {
        let share = random.unit();
        if number.is_multiple_of(5) { NOTHING } else { (700.0 * share - 300.0) as f32 }
    };
    HeightMap { columns: 13, rows: 7, heights: (0..13 * 7).map(height).collect() }
}

/// Whether a place is sheltered from drops of a velocity: some column is met by what is behind it on its line of fall.
fn is_sheltered(shelter: &Shelter, place: DVec3, velocity: DVec3) -> bool {
    let map = shelter.map().expect("a map");
    let edge = [
        (shelter.to[0] - shelter.from[0]) / map.columns as f64,
        (shelter.to[1] - shelter.from[1]) / map.rows as f64,
    ];
    (0..map.columns * map.rows).any(|number| {
        let (column, row) = (number % map.columns, number / map.columns);
        let low =
            [shelter.from[0] + edge[0] * column as f64, shelter.from[1] + edge[1] * row as f64];
        // Seconds ago.
        let (mut since, mut until) = (0.0_f64, f64::INFINITY);
        for (axis, at, speed) in [(0, place.x, velocity.x), (1, place.z, velocity.z)] {
            let ends = [low[axis], low[axis] + edge[axis]];
            if speed == 0.0 {
                if at < ends[0] || at >= ends[1] {
                    return false;
                }
                continue;
            }
            let times = ends.map(|end| (at - end) / speed);
            since = since.max(times[0].min(times[1]));
            until = until.min(times[0].max(times[1]));
        }
        since <= until && place.y - velocity.y * since <= f64::from(map.heights[number])
    })
}

/// Three populations in the wind, one of which falls upright, under the [`city`].
fn boxes() -> Scene {
    let population = |count, velocity| Population {
        seed: None,
        count,
        half_extent: DVec3::splat(1025.0),
        radius: 1.0,
        velocity,
    };
    let rain = RainSettings {
        count: 12_000,
        velocity: DVec3::new(4.0, -9.0, 2.0),
        others: [
            Some(population(8_000, DVec3::new(0.0, -5.0, 0.0))),
            Some(population(8_000, DVec3::new(-30.0, -2.0, -7.0))),
            None,
        ],
        ..RainSettings::default()
    };
    let mut scene = square(96);
    scene.rain = Some(rain);
    scene.time = 3.25;
    scene.camera.position = DVec3::new(350.0, 120.0, 900.0);
    scene.camera.target = DVec3::new(-100.0, -50.0, -300.0);
    scene.camera.vertical_fov = 70.0;
    scene
}

fn under(map: HeightMap, mut scene: Scene) -> Scene {
    scene.shelter = Some(Shelter::of(map, FROM, TO));
    scene.validate("a test").expect("a valid scene");
    scene
}

/// Indices of the drops on the tiles of a scene.
fn drawn(device: &Arc<Device>, scene: &Scene) -> BTreeSet<u32> {
    let white = Environment::constant(Vec3::ONE);
    let plan = plan(scene, &white, Output::Radiance).expect("a plan");
    let lighting = Lighting::new(device, &white).expect("light");
    let stages = TileStages::draw(&lighting, scene, &plan).expect("stages");
    lists(&stages).into_iter().flat_map(|(_, list)| list).map(|entry| entry.key.1).collect()
}

/// Where a random drop in a box is, and its velocity.
fn place(scene: &Scene, index: u32) -> (DVec3, DVec3) {
    let mut number = index;
    for rain in scene.populations() {
        if number < rain.count {
            let seen = rain.seen_from(scene.camera.position, tick_of_seconds(scene.time));
            return (scene.camera.position + seen.drop_at(number).as_dvec3(), rain.velocity);
        }
        number -= rain.count;
    }
    panic!("no drop {index}");
}

fn count_of(device: &Arc<Device>, scene: &Scene) -> u64 {
    let white = Environment::constant(Vec3::ONE);
    draw(&mut renderer(device, scene, &white), scene).1.visible
}

#[test]
fn each_drop_is_drawn_if_nothing_is_on_its_way() {
    let open = boxes();
    let sheltered = under(city(), open.clone());
    let shelter = sheltered.shelter.as_ref().expect("a shelter");
    on_device(|device| {
        let (before, found) = (drawn(device, &open), drawn(device, &sheltered));
        let is_dry = |index: &&u32| {
            let (place, velocity) = place(&open, **index);
            is_sheltered(shelter, place, velocity)
        };
        let dry = before.iter().filter(is_dry).count();
        assert!(dry > 300 && before.len() - dry > 300, "{dry} of {} are sheltered", before.len());
        let expected: BTreeSet<u32> =
            before.iter().filter(|index| !is_dry(index)).copied().collect();
        let off: Vec<_> = found.symmetric_difference(&expected).take(9).collect();
        assert!(off.is_empty(), "{off:?} are drawn, or left out, by mistake");
        assert_eq!(count_of(device, &sheltered), count_visible(&sheltered));
        // While the shutter is open the middle decides, for the CPU as well.
        let mut exposed = sheltered.clone();
        exposed.camera.shutter = 1.0;
        exposed.camera.velocity = Some(DVec3::new(5.0, 1.0, -3.0));
        assert_eq!(count_of(device, &exposed), count_visible(&exposed));
    });
}

#[test]
fn the_reference_has_the_same_drops() {
    let sheltered = under(city(), boxes());
    let shelter = sheltered.shelter.as_ref().expect("a shelter");
    let place_of = |center: DVec3| sheltered.camera.position + center;
    let open = of_scene(&boxes());
    let velocity = |population: u32| sheltered.populations()[population as usize].velocity;
    let expected = open
        .all
        .iter()
        .filter(|drop| !is_sheltered(shelter, place_of(drop.center), velocity(drop.population)));
    assert!(expected.copied().eq(of_scene(&sheltered).all));

    // While the shutter is open each is there until it meets a surface; where time runs backwards, from then on.
    let mut exposed = sheltered.clone();
    exposed.camera.shutter = 8.0;
    for pace in [1.0, -1.0] {
        exposed.pace = pace;
        let drops = of_scene(&exposed);
        let tree = Tree::new(drops.clone());
        let mut met = 0;
        for (number, drop) in (0..).zip(&drops.all) {
            let velocity = velocity(drop.population);
            for moment in [0.0, 0.3, 0.6, 0.999] {
                let place = place_of(drop.center) + moment * exposed.exposed() * velocity;
                let expected = !is_sheltered(shelter, place, velocity);
                assert_eq!(drops.is_there(number, moment), expected, "drop {number} at {moment}");
                let center = drops.center(drop, moment);
                let ray = Ray { origin: center + 9.0 * DVec3::Z, direction: DVec3::NEG_Z, moment };
                let is_in_box = center.abs().max_element() < 1025.0;
                assert_eq!(tree.meet(number, &ray).is_some(), expected && is_in_box);
                met += u32::from(!expected);
            }
        }
        assert!(met > 100, "{met} meet a surface");
    }
}

/// A half-plane of a roof: all that is at x under 0.
fn half_plane(height: f32) -> HeightMap {
    let of = |column: usize| if column < 32 { height } else { NOTHING };
    HeightMap { columns: 64, rows: 1, heights: (0..64).map(of).collect() }
}

/// Real rain in wind, beside and under a roof.
fn weather() -> Scene {
    let wind = DVec3::new(4.0, 0.0, 0.0);
    let rain = RealRain { rate: 60.0, extent: 9.0, wind, ..RealRain::default() };
    let mut scene = square(96);
    (scene.seed, scene.time) = (3, 1.5);
    scene.metres = 0.5;
    scene.rain = Some(RainSettings::of(rain));
    scene.camera.position = DVec3::new(2.0, 1.5, 9.0);
    scene.camera.target = DVec3::new(0.5, 2.0, -10.0);
    scene.camera.vertical_fov = 60.0;
    scene.model.cutoff_px = Some(0.05);
    scene
}

fn shown(scene: &Scene) -> Vec<ShownDrop> {
    let mut drops = Vec::new();
    let field = Field::of(scene).expect("rain");
    field.for_each_shown(scene, 0.05, &mut |drop| drops.push(drop));
    drops
}

#[test]
fn the_edge_of_a_roof_slants_class_by_class() {
    const HEIGHT: f64 = 5.0;
    let open = weather();
    let mut roofed = open.clone();
    let all = |x: f64| [x, -100.0];
    roofed.shelter = Some(Shelter::of(half_plane(HEIGHT as f32), all(-100.0), [100.0, 100.0]));
    roofed.validate("a test").expect("a valid scene");
    // Behind the edge the dry part is as wide as a drop is carried while it falls from there.
    let carried = |drop: &ShownDrop, place: DVec3| {
        drop.velocity.x / -drop.velocity.y * (HEIGHT - place.y).max(0.0)
    };
    let is_dry = |drop: &&ShownDrop| {
        let place = open.camera.position + drop.from_camera;
        place.y <= HEIGHT && place.x < carried(drop, place)
    };
    let before = shown(&open);
    let expected: Vec<u64> =
        before.iter().filter(|drop| !is_dry(drop)).map(|drop| drop.number).collect();
    let found: Vec<u64> = shown(&roofed).iter().map(|drop| drop.number).collect();
    assert!(found == expected, "{} of {}, not {}", found.len(), before.len(), expected.len());
    // Slow drops are carried farther; many of them are dry that are under no roof.
    let beside = before.iter().filter(is_dry).map(|drop| open.camera.position + drop.from_camera);
    let beside = beside.filter(|place| place.x > 0.5).count();
    assert!(beside > 1000 && expected.len() > 1000, "{beside} beside, {} left", expected.len());
    on_device(|device| {
        let cpu = Field::of(&roofed).expect("rain").count_visible(&roofed, 0.05);
        assert_eq!(count_of(device, &roofed), cpu);
    });
}

#[test]
fn placed_drops_are_under_a_roof_as_well() {
    let everywhere = HeightMap { columns: 1, rows: 1, heights: vec![1e6] };
    let mut scene = under(everywhere, boxes());
    scene.drops = vec![raindrops::scene::PlacedDrop::sphere(scene.camera.target, 50.0)];
    scene.shelter.as_mut().expect("a shelter").from = [-1e5; 2];
    scene.shelter.as_mut().expect("a shelter").to = [1e5; 2];
    let alone = Scene { rain: None, shelter: None, ..scene.clone() };
    on_device(|device| {
        let environment = waves();
        let picture = |scene| draw(&mut renderer(device, scene, &environment), scene).0;
        assert_eq!(picture(&scene), picture(&alone));
        assert_eq!(count_of(device, &scene), 1);
    });
    let truth = |scene: &Scene| {
        Tracer::new(scene, &waves(), Truth { samples: 1, ..Truth::default() }).picture()
    };
    assert_eq!(truth(&scene), truth(&alone));
}

/// Far rain as a medium alone, seen level along -z from the beginning of a roof that ends half-way to where the rain does.
fn fog() -> Scene {
    let rain = RealRain { rate: 100.0, extent: 400.0, ..RealRain::default() };
    let mut scene = square(16);
    scene.rain = Some(RainSettings::of(rain));
    scene.camera.position = DVec3::new(0.0, 1.5, 0.0);
    scene.camera.target = DVec3::new(0.0, 1.5, -1.0);
    scene.camera.vertical_fov = 1.0;
    scene.model.far_rain = Some(FarRain::Medium);
    scene.model.cutoff_px = Some(1.0);
    scene.camera.near = 399.0;
    scene
}

/// What passes on the mean, drawn and by the reference.
fn passes(device: &Arc<Device>, scene: &Scene) -> [f64; 2] {
    let white = Environment::constant(Vec3::ONE);
    let mut renderer = renderer_of(device, scene, &white, Output::Layers);
    renderer.submit(scene).expect("a frame");
    renderer.finish().expect("a report");
    let layers: Layers = renderer.read_layers().expect("layers");
    let pixels = f64::from(scene.image.width * scene.image.height);
    let opaque: f64 = layers.color.iter().map(|color| color[3].to_f64()).sum();
    let truth = Truth { samples: 1, rain_to: Some(0.0), ..Truth::default() };
    let traced = Tracer::new(scene, &white, truth).trace(&|_| ());
    let taken: f64 = traced.opacity.iter().map(|share| f64::from(*share)).sum();
    [1.0 - opaque / pixels, 1.0 - taken / pixels]
}

#[test]
fn half_a_sheltered_ray_has_the_transmittance_of_its_other_half() {
    on_device(|device| {
        let open = fog();
        let all = passes(device, &open);
        let mut half = open.clone();
        half.rain.as_mut().and_then(|rain| rain.real.as_mut()).expect("rain").extent = 200.0;
        let near = passes(device, &half);
        let roof = |from: f64, to: f64, wind: f64| {
            let mut scene = open.clone();
            let rain = scene.rain.as_mut().and_then(|rain| rain.real.as_mut()).expect("rain");
            rain.wind = DVec3::new(0.0, 0.0, wind);
            let map = HeightMap { columns: 4, rows: 50, heights: vec![12.0; 200] };
            scene.shelter = Some(Shelter::of(map, [-40.0, -to], [40.0, -from]));
            scene.validate("a test").expect("a valid scene");
            passes(device, &scene)
        };
        // The near half is sheltered, then the far one.
        for way in 0..2 {
            let (first, second) = (near[way], all[way] / near[way]);
            let found = [roof(0.0, 200.0, 0.0), roof(200.0, 400.0, 0.0)].map(|both| both[way]);
            assert!((found[0] / second - 1.0).abs() < 0.005, "{way}: {} for {second}", found[0]);
            assert!((found[1] / first - 1.0).abs() < 0.005, "{way}: {} for {first}", found[1]);
            assert!(all[way] < 0.4 && first > 0.5, "{all:?} {near:?}: nothing is told");
        }
        // Wind from behind carries the edge of the dry part away; drawn by the mean velocity, traced class by class.
        let [drawn, traced] = roof(0.0, 200.0, -10.0);
        let lee = (drawn / (all[0] / near[0])).ln() / -(all[0] / near[0]).ln() * 200.0;
        // From 10.5 m above at 10 m/s and some 6 m/s down: 17 m.
        assert!((12.0..22.0).contains(&lee), "carried by {lee} m");
        assert!((drawn / traced - 1.0).abs() < 0.005, "{drawn} drawn, {traced} traced");
    });
}

#[test]
fn pictures_are_those_of_the_reference() {
    let mut scene = under(city(), boxes());
    (scene.image.width, scene.image.height) = (32, 32);
    scene.rain.as_mut().expect("rain").radius = 15.0;
    scene.model.take_preset(Preset::Exact);
    let environment = waves();
    let truth = Truth { samples: 64, ..Truth::default() };
    let open = Scene { shelter: None, ..scene.clone() };
    // What the shelter changes, so that the samples' noise in other drops does not count.
    let changed = |open: &Picture, sheltered: &Picture| -> Vec<Vec3> {
        open.pixels
            .iter()
            .zip(&sheltered.pixels)
            .map(|(open, sheltered)| *open - *sheltered)
            .collect()
    };
    let size = |all: &mut dyn Iterator<Item = Vec3>| {
        all.map(|pixel| f64::from(pixel.length_squared())).sum::<f64>().sqrt()
    };
    on_device(|device| {
        let drawn = |scene: &Scene| draw(&mut renderer(device, scene, &environment), scene).0;
        let traced = |scene: &Scene| Tracer::new(scene, &environment, truth).picture();
        let found = changed(&drawn(&open), &drawn(&scene));
        let expected = changed(&traced(&open), &traced(&scene));
        let off = size(&mut found.iter().zip(&expected).map(|(a, b)| *a - *b));
        let all = size(&mut expected.iter().copied());
        // Usual: 0.34, as of all rain together 0.14. Of other drops it would be over 1.
        assert!(off < 0.45 * all, "{off} of {all}");
    });
}

/// The sky is kept while the view stays; what is sheltered of it changes where the camera goes.
#[test]
fn the_sheltered_medium_goes_with_the_camera() {
    let map = HeightMap { columns: 4, rows: 50, heights: vec![12.0; 200] };
    let mut scene = fog();
    scene.shelter = Some(Shelter::of(map, [-40.0, -200.0], [40.0, 0.0]));
    let mut moved = scene.clone();
    moved.camera.position.x += 60.0;
    moved.camera.target.x += 60.0;
    let environment = waves();
    on_device(|device| {
        let mut one = renderer(device, &scene, &environment);
        let (first, second) = (draw(&mut one, &scene).0, draw(&mut one, &moved).0);
        assert_eq!(second, draw(&mut renderer(device, &moved, &environment), &moved).0);
        assert_ne!(first, second);
        // What a shelter is of is fixed with the view.
        let other = Scene { shelter: None, ..scene.clone() };
        let error = one.submit(&other).expect_err("another shelter").to_string();
        assert!(error.contains("made for another shelter"), "{error}");
    });
}
