//! A frame of rain by the library: from a scene to a picture, in the order in which data flows.
//!
//! `cargo run --release --example one_frame` writes `one_frame.png` and says what was drawn.

use std::path::Path;

use raindrops::device::{Device, Instance, Validation};
use raindrops::environment::Environment;
use raindrops::picture::write_png;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, ModelChoice, RainSettings, Scene};

fn main() -> raindrops::Result<()> {
    // What to show. Everything has a default: the paper's scene, seen by the camera along -z.
    let scene = Scene {
        time: 12.5,
        image: ImageSize { width: 960, height: 540 },
        rain: Some(RainSettings { count: 200_000, ..RainSettings::default() }),
        model: ModelChoice { preset: Preset::Fast, ..ModelChoice::default() },
        ..Scene::default()
    };
    let environment = Environment::open(&scene.environment)?;

    // What that requires: passes and models, each with its reason.
    let plan = plan(&scene, &environment, Output::Display)?;
    for (pass, reason) in &plan.passes {
        println!("{pass}: {reason}");
    }

    // Where it is drawn: the fittest Vulkan device.
    let instance = Instance::new(Validation::Off)?;
    let device = Device::open(&instance, instance.choose(None)?)?;
    let mut renderer = Renderer::new(&device, &scene, &environment, &plan)?;

    // A frame. Camera, time and tone mapping key may differ from one to the next.
    renderer.submit(&scene)?;
    let report = renderer.finish()?;
    println!("{} of {} drops in view", report.counts.visible, scene.drop_count());
    for (pass, ms) in &report.passes_ms {
        println!("{pass}: {ms:.2} ms");
    }
    let path = Path::new("one_frame.png");
    write_png(path, scene.image.width, scene.image.height, &renderer.read_display()?)
}
