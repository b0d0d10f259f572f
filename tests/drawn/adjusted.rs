//! Devices that take less than the one at hand, tried by changing what it reports: what finds no room is
//! counted, drop by drop, and the paths that other devices take draw the same bytes.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, DeviceReport, Machine, PointRules};
use raindrops::passes::counters::Counts;
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::rain::cull::count_visible;
use raindrops::renderer::Renderer;
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

use crate::common::{on_adjusted_device, on_device, painted, picture, with_halo};

/// What a frame counts.
fn counts(device: &Arc<Device>, scene: &Scene) -> Counts {
    let white = Environment::constant(Vec3::ONE);
    picture::frame(&mut by_small_pictures(device, scene, &white, Output::Radiance), scene).1
}

/// The largest pictures of far drops are more than a device of short bindings allocates.
fn by_small_pictures(
    device: &Arc<Device>,
    scene: &Scene,
    light: &Environment,
    output: Output,
) -> Renderer {
    let mut plan = plan(scene, light, output).expect("a plan");
    plan.light.picture_level = 4;
    Renderer::new(device, scene, light, &plan).expect("a renderer")
}

/// Drops of `radius` pixels about the middles of the image's tiles of 4 x 2 pixels, or `aside` of them, tile
/// after tile and layer behind layer; seen along -z through 90 degrees.
fn on_tiles(count: u32, image: ImageSize, radius: f64, aside: (f64, f64), preset: Preset) -> Scene {
    let mut scene = Scene { rain: None, image, ..Scene::default() };
    scene.model.preset = preset;
    let focal = 0.5 * f64::from(image.height);
    let (across, down) = (image.width / 4, image.height / 2);
    scene.drops = (0..count)
        .map(|number| {
            let (tile, layer) = (number % (across * down), number / (across * down));
            let x = f64::from(4 * (tile % across)) + 2.0 + aside.0 - 0.5 * f64::from(image.width);
            let y = f64::from(2 * (tile / across)) + 1.0 + aside.1 - 0.5 * f64::from(image.height);
            let depth = 1000.0 + f64::from(layer);
            let center = DVec3::new(x / focal, -y / focal, -1.0) * depth;
            PlacedDrop::sphere(center, radius * depth / focal)
        })
        .collect();
    scene
}

/// So many drops are lost on an adjusted device, none on the device as it is.
#[track_caller]
fn loses(adjust: impl FnOnce(&mut DeviceReport), scene: &Scene, lost: u64) {
    let visible = scene.drops.len() as u64;
    on_device(|device| {
        let found = counts(device, scene);
        assert_eq!((found.visible, found.overflow), (visible, 0), "the control: {found:?}");
    });
    on_adjusted_device(adjust, |device| {
        let found = counts(device, scene);
        assert_eq!((found.visible, found.overflow), (visible, lost), "{found:?}");
    });
}

/// The paper's drops that are larger than a point: here all, as this device draws no point.
#[test]
fn quads_without_room_are_counted() {
    let mut scene = crate::common::by_paper(&Scene {
        rain: Some(RainSettings { count: 30_000, ..RainSettings::default() }),
        image: ImageSize { width: 32, height: 32 },
        ..Scene::default()
    });
    scene.model.mask_size = 16;
    let visible = count_visible(&scene);
    let adjust = |report: &mut DeviceReport| report.limits.max_storage_buffer_range = 32 << 10;
    on_adjusted_device(adjust, |device| {
        let rules = PointRules { limit_px: 0.0, draws_off_screen: true };
        device.point_rules.set(rules).expect("not yet probed");
        let found = counts(device, &scene);
        // Records of 16 bytes.
        assert_eq!(
            (found.visible, found.large, found.overflow),
            (visible, visible, visible - 2048),
            "{found:?}"
        );
    });
}

/// Splats, one a drop: fifteen of sixteen nodes of 32 bytes that a binding holds are theirs.
#[test]
fn splats_without_room_are_counted() {
    let image = ImageSize { width: 256, height: 128 };
    // Whole clusters: each has places for 16 drops. Their own records, and one for each cluster, just fit.
    let scene = on_tiles(246_400, image, 0.3, (0.0, 0.0), Preset::Fast);
    let adjust = |report: &mut DeviceReport| report.limits.max_storage_buffer_range = 8 << 20;
    loses(adjust, &scene, 246_400 - 262_144 / 16 * 15);
}

/// Drops that are no splats: as many as 64 workgroups of 64 invocations take.
#[test]
fn larger_drops_without_room_are_counted() {
    let image = ImageSize { width: 128, height: 64 };
    let scene = on_tiles(5000, image, 0.3, (0.0, 0.0), Preset::Exact);
    let adjust = |report: &mut DeviceReport| report.limits.max_compute_work_group_count[0] = 64;
    loses(adjust, &scene, 5000 - 4096);
}

/// Blocks, one for each tile of a larger drop: an eighth of an allocation holds 12,288 pairs of nodes.
#[test]
fn blocks_without_room_are_counted() {
    let adjust = |report: &mut DeviceReport| report.max_allocation = 6 << 20;
    let image = ImageSize { width: 128, height: 64 };
    // About the corner that four tiles share, but for the last column and row.
    let mut scene = on_tiles(3400, image, 0.3, (2.0, 1.0), Preset::Exact);
    scene.drops.retain(|drop| {
        let place = drop.center / -drop.center.z * 32.0;
        place.x < 63.0 && place.y > -31.0
    });
    loses(adjust, &scene, scene.drops.len() as u64 - 12_288 / 4);

    // One behind the other in the middle, of 16 x 16 pixels: a workgroup gives out the blocks of each.
    scene.drops = (0..400)
        .map(|layer| {
            let (slope, depth) = (7.9f64 / 32.0, 500.0 + f64::from(layer));
            let radius = depth * slope / (1.0 + slope * slope).sqrt();
            PlacedDrop::sphere(DVec3::new(0.0, 0.0, -depth), radius)
        })
        .collect();
    loses(adjust, &scene, 400 - 12_288 / 32);
}

/// Streaks along a diagonal of the picture, one behind the other: each takes as many links as any other.
pub fn alike_streaks(count: u32) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    scene.image = ImageSize { width: 256, height: 256 };
    scene.model.preset = Preset::Fast;
    scene.camera.shutter = 1.0;
    scene.drops = (0..count)
        .map(|layer| {
            let depth = 1000.0 + 0.01 * f64::from(layer);
            let place = |x: f64, y: f64| depth / 128.0 * DVec3::new(x, y, 0.0);
            let start = place(-98.3, -101.6) - depth * DVec3::Z;
            PlacedDrop { velocity: place(190.0, 150.0), ..PlacedDrop::sphere(start, depth / 320.0) }
        })
        .collect();
    scene
}

/// With each quarter of a mebibyte there is room for as many more of them, of eight bytes a link.
#[test]
fn streaks_without_room_are_counted() {
    let (scene, white) = (alike_streaks(13_000), Environment::constant(Vec3::ONE));
    let mut plan = plan(&scene, &white, Output::Radiance).expect("a plan");
    plan.room = 8;
    plan.light.picture_level = 4;
    let lost = [24, 25, 26].map(|quarters: u32| {
        let mut lost = 0;
        on_adjusted_device(
            |report| report.limits.max_storage_buffer_range = quarters << 18,
            |device| {
                let mut renderer =
                    Renderer::new(device, &scene, &white, &plan).expect("a renderer");
                renderer.submit(&scene).expect("a frame");
                lost = renderer.finish().expect("a report").counts.overflow;
            },
        );
        lost
    });
    println!("{lost:?} lost");
    let [a, b] = [lost[0].saturating_sub(lost[1]), lost[1].saturating_sub(lost[2])];
    assert!(a > 200 && a.abs_diff(b) <= 1, "{lost:?}");
    // 24 times as many find room, but for the cells' first links.
    let held = (13_000 - lost[0]) as f64 / (24.0 * a as f64);
    assert!((held - 1.0).abs() < 0.02, "{lost:?}");
}

/// Drops of every kind and size: splats, blocks and rays, in order and not, before one another.
fn every_kind() -> Scene {
    let half_extent = DVec3::splat(120.0);
    let mut scene = Scene {
        rain: Some(RainSettings { count: 60_000, half_extent, ..RainSettings::default() }),
        drops: vec![PlacedDrop::sphere(DVec3::new(0.5, 0.3, -3.0), 0.8)],
        image: ImageSize { width: 250, height: 131 },
        ..Scene::default()
    };
    scene.model.preset = Preset::Fast;
    scene
}

struct Frame {
    counts: Counts,
    radiance: Picture,
    display: Vec<u8>,
}

impl PartialEq for Frame {
    /// To the byte; but the sum of logarithms, in another order, may move what is shown by a level.
    fn eq(&self, other: &Self) -> bool {
        let mut shown = self.display.iter().zip(&other.display);
        self.counts == other.counts
            && self.radiance == other.radiance
            && shown.all(|(a, b)| a.abs_diff(*b) <= 1)
    }
}

fn waves() -> Environment {
    painted(256, |d| (3.0 * d).as_vec3().exp())
}

fn frame(device: &Arc<Device>, scene: &Scene) -> Frame {
    frame_in(device, scene, &waves())
}

fn frame_in(device: &Arc<Device>, scene: &Scene, light: &Environment) -> Frame {
    frame_of(picture::renderer_of(device, scene, light, Output::Display), scene)
}

fn frame_of(mut renderer: Renderer, scene: &Scene) -> Frame {
    renderer.submit(scene).expect("a frame");
    let counts = renderer.finish().expect("a report").counts;
    let radiance = renderer.read_radiance().expect("radiance");
    Frame { counts, radiance, display: renderer.read_display().expect("display") }
}

/// Its name, and what a report says on it.
type Side = (&'static str, fn(&mut DeviceReport));

/// Texel buffers and reading ahead are how CPU drivers are fed; a GPU, and a device of short texel buffers, have
/// passes without. Whichever the device at hand takes, both are drawn.
const SIDES: [Side; 4] = [
    ("no texel buffer", |report| report.limits.max_texel_buffer_elements = 4096),
    ("short texel buffers", |report| report.limits.max_texel_buffer_elements = 65_536),
    ("a GPU", |report| report.machine = Machine::Gpu),
    ("a CPU", |report| report.machine = Machine::Cpu),
];

/// What is drawn of each scene is the same on a device as it is and on each of `sides`; at another moment it is not.
fn draw_alike<T: PartialEq>(
    scenes: &[(&str, Scene)],
    sides: &[Side],
    draw: impl Fn(&Arc<Device>, &Scene) -> T,
) {
    let mut expected = Vec::new();
    on_device(|device| {
        expected.extend(scenes.iter().map(|(_, scene)| draw(device, scene)));
        let (_, scene) = &scenes[0];
        let later = Scene { time: scene.time + 0.1, ..scene.clone() };
        assert!(draw(device, &later) != expected[0], "the control");
    });
    for (side, adjust) in sides {
        on_adjusted_device(adjust, |device| {
            for ((what, scene), expected) in scenes.iter().zip(&expected) {
                assert!(draw(device, scene) == *expected, "{what} on {side} is another frame");
            }
        });
    }
}

#[test]
fn what_a_device_takes_does_not_show() {
    let placed = every_kind();
    // All of one size, for which the passes leave a loop out.
    let random = Scene { drops: Vec::new(), ..placed.clone() };
    let whole = |device: &Arc<Device>, scene: &Scene| {
        let drawn = frame(device, scene);
        let counts = drawn.counts;
        assert!(counts.visible > 5000 && counts.overflow == 0, "{counts:?}");
        drawn
    };
    draw_alike(&[("every kind", placed), ("one size", random)], &SIDES, whole);
}

/// Nor where drops move, are out of focus, are flattened or real rain, or are drawn by rays.
#[test]
fn what_a_device_takes_does_not_show_in_other_models() {
    let small = |preset| {
        let mut scene = every_kind();
        scene.image = ImageSize { width: 130, height: 71 };
        scene.model.preset = preset;
        scene
    };
    let base = small(Preset::Fast);
    let moving = Camera { shutter: 0.5, ..base.camera };
    let blurred = Camera { aperture: 4.0, focus: 30.0, ..base.camera };
    let mut flat = base.clone();
    flat.drops = (0..40)
        .map(|number| {
            let depth = 3.0 * 1.1f64.powi(number);
            let center = DVec3::new(f64::from(number % 5 - 2), f64::from(number % 3 - 1), -depth);
            PlacedDrop { axis_ratio: Some(0.7), ..PlacedDrop::sphere(center, 0.4) }
        })
        .collect();
    let rain = RealRain { rate: 100.0, extent: 60.0, ..RealRain::default() };
    let real = Scene { rain: Some(RainSettings::of(rain)), ..base.clone() };
    let scenes = [
        ("streaks", Scene { camera: moving, ..base.clone() }),
        ("discs", Scene { camera: blurred, ..base.clone() }),
        ("shapes", flat),
        ("real rain", real.clone()),
        ("streaks of real rain", Scene { camera: moving, ..real }),
        ("exact", small(Preset::Exact)),
    ];
    draw_alike(&scenes, &[SIDES[0], SIDES[2]], frame);
}

/// Nor where drops come out of order: lists of few entries, of many, and of more than a workgroup sorts.
#[test]
fn what_a_device_takes_does_not_show_where_lists_are_out_of_order() {
    let mut random = crate::common::Random(5);
    let mut tangled = |layers: u32| {
        let image = ImageSize { width: 16, height: 8 };
        let mut scene = on_tiles(layers * 16, image, 0.3, (0.0, 0.0), Preset::Fast);
        for drop in &mut scene.drops {
            // Anywhere on its tile, so that it matters which is nearer.
            let aside = DVec3::new(3.0 * random.unit() - 1.5, random.unit() - 0.5, 0.0) / 4.0;
            drop.center = (1.0 + random.unit()) * (drop.center - drop.center.z * aside);
            drop.radius *= drop.center.z / -1000.0;
            drop.velocity = DVec3::splat(100.0);
        }
        scene
    };
    let scenes = [("twenty", tangled(20)), ("hundreds", tangled(150)), ("many", tangled(900))];
    draw_alike(&scenes, &[SIDES[2], SIDES[3]], |device, scene| {
        let drawn = frame(device, scene);
        assert_eq!(drawn.counts.overflow, 0, "{:?}", drawn.counts);
        drawn
    });
}

/// Nor in drops of a pane, in focus and out of it.
#[test]
fn what_a_device_takes_does_not_show_on_a_pane() {
    let pane = |focus| {
        let text = format!(
            "[image]\nwidth = 96\nheight = 54\n[camera]\nvertical_fov = 4.0\naperture = 0.0015\nfocus = {focus}\n\
             [model]\npreset = \"fast\"\n[rain]\ncount = 20000\n\
             [pane]\ndistance = 0.3\ncontact_angle = 50.0\nseed = 3\nage = 45.0\nrate = 10.0\n\
             velocity = [0.0, 0.0, -5.0]\nextent = [0.1, 0.06]"
        );
        Scene::parse(&text, "pane.toml").expect("a scene")
    };
    let scenes = [("in focus", pane("0.3")), ("out of focus", pane("inf"))];
    draw_alike(&scenes, &[SIDES[0], SIDES[2]], frame);
}

/// Placed drops that move and are more than a binding holds, of which a dispatch does 131,072: each goes its own way.
#[test]
fn placed_drops_in_several_dispatches_go_their_own_ways() {
    let mut scene =
        on_tiles(150_000, ImageSize { width: 128, height: 64 }, 0.3, (0.0, 0.0), Preset::Fast);
    for (number, drop) in scene.drops.iter_mut().enumerate() {
        drop.velocity = DVec3::new((number % 7) as f64, (number % 11) as f64 - 5.0, 0.0);
    }
    scene.time = 0.5;
    scene.camera.shutter = 0.2;
    let short: Side = ("short bindings", |report| report.limits.max_storage_buffer_range = 8 << 20);
    draw_alike(&[("two dispatches", scene)], &[short], |device, scene| {
        frame_of(by_small_pictures(device, scene, &waves(), Output::Display), scene)
    });
}

/// Rays that are more than a dispatch does are found by further ones. On a device of 64 workgroups along an axis it does the
/// blocks of so many.
#[test]
fn rays_in_several_dispatches_have_the_same_bytes() {
    let image = ImageSize { width: 128, height: 64 };
    let mut scene = Scene { rain: None, image, ..Scene::default() };
    scene.model.preset = Preset::Exact;
    scene.model.samples = Some(1);
    scene.drops = (0..300)
        .map(|layer| {
            let depth = 500.0 + f64::from(layer);
            let center = DVec3::new(f64::from(layer % 20 - 10) * 0.03, 0.0, -1.0) * depth;
            PlacedDrop::sphere(center, 0.2 * depth)
        })
        .collect();
    let adjust = |report: &mut DeviceReport| report.limits.max_compute_work_group_count[0] = 64;
    let mut expected = None;
    on_device(|device| expected = Some(frame(device, &scene)));
    on_adjusted_device(adjust, |device| {
        let white = Environment::constant(Vec3::ONE);
        let mut renderer = picture::renderer(device, &scene, &white);
        let tiles = renderer.draw(&scene).expect("a frame").tiles.expect("tiles");
        assert!(tiles.ray_fragments > 2 * 64 * 32, "the control: {tiles:?}");
        let drawn = frame(device, &scene);
        assert_eq!(drawn.counts.overflow, 0);
        assert!(Some(drawn) == expected, "it is another frame");
    });
}

/// Nor in the images of a sun: in drops at rest, that move, out of focus; in one as large as half of the picture.
#[test]
fn what_a_device_takes_does_not_show_in_images_of_a_sun() {
    let mut base = every_kind();
    base.drops = (0..30)
        .map(|number| {
            let depth = 2.2 * 1.2f64.powi(number);
            let center = DVec3::new(f64::from(number % 7 - 3), f64::from(number % 4) - 1.5, -depth);
            PlacedDrop::sphere(center, 0.4)
        })
        // So large that its sun is drawn in dozens of parts.
        .chain([PlacedDrop::sphere(DVec3::new(0.4, 0.3, -3.2), 1.9)])
        .collect();
    let moving = Camera { shutter: 0.5, ..base.camera };
    let blurred = Camera { aperture: 1.0, focus: 8.0, ..base.camera };
    let scenes = [
        ("at rest", base.clone()),
        ("moving", Scene { camera: moving, ..base.clone() }),
        ("out of focus", Scene { camera: blurred, ..base.clone() }),
    ];
    let sunny = with_halo(DVec3::new(0.3, 0.4, -1.0).normalize());
    let in_sun = |device: &Arc<Device>, scene: &Scene| frame_in(device, scene, &sunny);
    on_device(|device| {
        let dark = painted(64, |_| Vec3::splat(0.5));
        let differs = in_sun(device, &base) != frame_in(device, &base, &dark);
        assert!(differs, "the control: the sun shows");
    });
    draw_alike(&scenes, &[SIDES[2], SIDES[3]], in_sun);
}

/// Nor in the layers for a compositor.
#[test]
fn what_a_device_takes_does_not_show_in_layers() {
    let layers = |device: &Arc<Device>, scene: &Scene| {
        let sky = painted(64, |d| (3.0 * d).as_vec3().exp());
        let mut renderer = picture::renderer_of(device, scene, &sky, Output::Layers);
        let until = Scene { time: scene.time + 0.1, ..scene.clone() };
        renderer.submit_until(scene, &until).expect("a frame");
        renderer.read_layers().expect("layers")
    };
    draw_alike(&[("layers", every_kind())], &[SIDES[0], SIDES[2]], layers);
}
