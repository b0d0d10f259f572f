//! The stage at which two frames first differ: none between two runs, and the right one where something
//! is changed on purpose.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::measure::drivers::{Apart, apart};
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::renderer::stages::Stages;
use raindrops::scene::{ImageSize, RainSettings, Scene};

fn ramps(blue: f32) -> Environment {
    let texel = |index: u32| Vec3::new(index as f32 / 2048.0, (index % 64) as f32 / 64.0, blue);
    let texels = (0..64 * 32).map(texel).collect();
    Environment::from_texels("ramps", 64, 32, texels).expect("an image")
}

fn frame(device: &Arc<Device>, scene: &Scene, environment: &Environment) -> (Stages, Picture) {
    let plan =
        plan(&crate::common::by_paper(scene), environment, Output::Radiance).expect("a plan");
    let stages = Stages::draw(device, scene, environment, &plan).expect("stages");
    let mut renderer = Renderer::new(device, scene, environment, &plan).expect("a renderer");
    renderer.submit(scene).expect("a frame");
    (stages, renderer.read_radiance().expect("radiance"))
}

#[test]
fn the_stage_that_differs_is_named() {
    crate::common::on_device(|device| {
        let mut scene = Scene {
            image: ImageSize { width: 96, height: 64 },
            rain: Some(RainSettings {
                count: 300,
                half_extent: DVec3::splat(20.0),
                ..Default::default()
            }),
            ..Scene::default()
        };
        scene.model.mask_size = 128;
        let (stages, picture) = frame(device, &scene, &ramps(0.3));
        let differing = |other: &(Stages, Picture)| {
            let apart: Vec<Apart> = apart((&stages, &picture), (&other.0, &other.1));
            println!("{apart:?}");
            apart.iter().find(|apart| apart.differs()).map(|apart| apart.stage.to_string())
        };
        let first = |scene: &Scene, environment: &Environment| {
            differing(&frame(device, scene, environment))
        };
        assert_eq!(first(&scene, &ramps(0.3)), None, "the same");
        let mut changed = scene.clone();
        changed.time = 0.1;
        assert_eq!(first(&changed, &ramps(0.3)), Some("positions".to_string()));
        changed = scene.clone();
        changed.camera.vertical_fov = 88.0;
        assert_eq!(first(&changed, &ramps(0.3)), Some("footprint".to_string()));
        let mut turned = frame(device, &scene, &ramps(0.3));
        turned.0.pictures[1].iter_mut().for_each(|direction| direction[0] += 0.01);
        assert_eq!(differing(&turned), Some("direction".to_string()));
        assert_eq!(first(&scene, &ramps(0.35)), Some("radiance".to_string()));
    });
}
