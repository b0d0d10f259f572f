//! What is made once stays: another size of picture, a second view, another preset make only what they alone need;
//! and a frame of what a renderer was not made for is refused.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::{Device, MadeCounts};
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{Lighting, RainField, Renderer};
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use crate::common::picture::{frame, renderer_of};

/// Another scene.
type Change = fn(&mut Scene);

/// Drops of both kinds, in light that has a bright source.
fn scene(preset: Preset) -> Scene {
    let mut scene = Scene::default();
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.image = ImageSize { width: 64, height: 48 };
    scene.rain.get_or_insert_default().count = 3000;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.2, 0.1, -30.0), 1.0)];
    scene
}

fn sun() -> Environment {
    let toward = DVec3::new(0.3, 0.4, -1.0).normalize();
    let radiance = |d: DVec3| if d.dot(toward) > 0.9998 { Vec3::splat(1e4) } else { Vec3::ONE };
    crate::common::painted(512, radiance)
}

/// A renderer that has drawn the scene, and its picture.
fn drawn(
    lighting: &Arc<Lighting>,
    rain: &Arc<RainField>,
    environment: &Environment,
    scene: &Scene,
) -> (Renderer, Picture) {
    let plan = plan(scene, environment, Output::Display).expect("a plan");
    let mut renderer = Renderer::of(lighting, rain, scene, &plan).expect("a renderer");
    renderer.submit(scene).expect("a frame");
    let picture = renderer.read_radiance().expect("radiance");
    (renderer, picture)
}

/// What was made beyond `before`.
fn since(device: &Device, before: MadeCounts) -> [u32; 4] {
    let now = device.made();
    [
        now.environments - before.environments,
        now.tables - before.tables,
        now.sorts - before.sorts,
        now.pipelines - before.pipelines,
    ]
}

#[test]
fn only_what_is_new_is_made() {
    let environment = sun();
    crate::common::on_fresh_device(|device| {
        let before = device.made();
        let lighting = Arc::new(Lighting::new(device, &environment).expect("light"));
        let fast = scene(Preset::Fast);
        let rain = Arc::new(RainField::new(device, &fast));
        let (first, picture) = drawn(&lighting, &rain, &environment, &fast);
        let [environments, tables, sorts, pipelines] = since(device, before);
        // The whole sky, and the one without its sun for the drops.
        assert_eq!([environments, tables, sorts], [2, 1, 1]);
        assert!(pipelines > 10, "{pipelines}");

        // Twenty sizes, each beside the one before, as in a window; some with lists of other bands and regions.
        let before = device.made();
        let mut last = first;
        for number in 0..20 {
            let mut resized = fast.clone();
            resized.image = ImageSize { width: 40 + 57 * number, height: 30 + 41 * (number % 7) };
            last = drawn(&lighting, &rain, &environment, &resized).0;
        }
        let back = drawn(&lighting, &rain, &environment, &fast).1;
        assert_eq!(since(device, before), [0; 4], "20 resizes");
        assert!(back == picture, "back at the first size it is another picture");

        // Another preset beside it: its mask and its pipelines. Back again: nothing.
        let paper = scene(Preset::Paper);
        let (second, by_paper) = drawn(&lighting, &rain, &environment, &paper);
        let [environments, tables, sorts, pipelines] = since(device, before);
        assert_eq!([environments, tables, sorts], [0, 1, 0], "a split view");
        assert!(pipelines > 0);
        let before = device.made();
        let mut resized = paper.clone();
        resized.image = ImageSize { width: 80, height: 33 };
        for scene in [&fast, &paper, &resized] {
            drawn(&lighting, &rain, &environment, scene);
        }
        assert_eq!(since(device, before), [0; 4], "there and back");
        drop((last, second));

        // What is shared draws what a renderer of its own draws.
        for (scene, shared) in [(&fast, &picture), (&paper, &by_paper)] {
            let mut own = renderer_of(device, scene, &environment, Output::Display);
            assert!(frame(&mut own, scene).0 == *shared);
        }
        // The control: they are counted.
        let [environments, tables, sorts, pipelines] = since(device, before);
        assert_eq!([environments, tables, sorts, pipelines], [3, 2, 1, 0]);
    });
}

/// At 4 million drops, without drawing the frame: their sort takes long, and so does a table.
#[test]
fn a_resize_makes_nothing_of_many_drops_anew() {
    let _alone = crate::common::layer::alone();
    let environment = Environment::bundled().expect("the sky");
    let mut scene = scene(Preset::Fast);
    scene.rain.get_or_insert_default().count = 4_000_000;
    scene.image = ImageSize { width: 1024, height: 768 };
    let instance = crate::common::validated_instance();
    let device = Device::open(&instance, crate::common::chosen(&instance)).expect("a device");
    let plan = plan(&scene, &environment, Output::Display).expect("a plan");
    let before = device.made();
    let first = Renderer::new(&device, &scene, &environment, &plan).expect("a renderer");
    // The control.
    let [environments, tables, sorts, pipelines] = since(&device, before);
    assert!(environments > 0 && tables > 0 && sorts > 0 && pipelines > 0);
    let mut shown = (first.lighting().clone(), first.rain().clone());
    let before = device.made();
    for number in 1..6 {
        scene.image.width += 64 * number;
        let (lighting, rain) = &shown;
        let resized = Renderer::of(lighting, rain, &scene, &plan).expect("a renderer");
        shown = (resized.lighting().clone(), resized.rain().clone());
    }
    assert_eq!(since(&device, before), [0; 4]);
}

#[test]
fn a_frame_of_something_else_is_refused() {
    let white = Environment::constant(Vec3::ONE);
    crate::common::on_device(|device| {
        let made_for = scene(Preset::Fast);
        let plan = plan(&made_for, &white, Output::Display).expect("a plan");
        let mut renderer = Renderer::new(device, &made_for, &white, &plan).expect("a renderer");
        let changes: [(&str, Change); 7] = [
            ("64 x 48 pixels", |scene| scene.image.width = 128),
            ("drops", |scene| scene.rain.get_or_insert_default().count += 1),
            ("drops", |scene| scene.rain = None),
            ("drops", |scene| scene.drops[0].radius = 2.0),
            ("seed", |scene| scene.seed += 1),
            ("environment", |scene| scene.environment.radiance = Some(Vec3::ONE)),
            ("models", |scene| scene.model.preset = Preset::Exact),
        ];
        for (word, change) in changes {
            let mut other = made_for.clone();
            change(&mut other);
            let error = renderer.submit(&other).expect_err(word).to_string();
            assert!(error.contains(word) && !error.contains('\n'), "{error}");
        }
        // Nor is the rain of another scene taken, or one of another device.
        let mut other = made_for.clone();
        other.seed += 1;
        let rain = Arc::new(RainField::new(device, &other));
        let refused = Renderer::of(renderer.lighting(), &rain, &made_for, &plan).map(|_| ());
        assert!(refused.expect_err("refused").to_string().contains("rain"));
        // The control: what may differ does.
        let mut later = made_for.clone();
        later.time += 1.0;
        later.camera.position.x += 1.0;
        later.tone_map.key *= 2.0;
        renderer.submit(&later).expect("a frame");
    });
}
