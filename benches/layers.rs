//! What layers, and a depth behind the drops, cost: `cargo bench --bench layers`.
//!
//! Frames of a picture, of its layers and of the picture before a depth in turn, 960 x 540, on the first device; medians
//! of GPU milliseconds, all passes together. Encoding is not in them.

use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::{Device, Instance, Validation};
use raindrops::measure::statistics::median;
use raindrops::picture::layers::Layers;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, RainSettings, Scene};

/// Frames of each; those before have the sky to draw.
const FRAMES: usize = 31;
const WARM_UP: usize = 4;
const IMAGE: ImageSize = ImageSize { width: 960, height: 540 };

/// A quarter of a million drops in a box, and real rain of 25 mm/h.
fn scenes() -> [(&'static str, Scene); 2] {
    let base = Scene { image: IMAGE, ..Scene::default() };
    let count = RainSettings {
        count: 250_000,
        half_extent: DVec3::splat(600.0),
        ..RainSettings::default()
    };
    let real = RainSettings::of(RealRain { rate: 25.0, extent: 300.0, ..RealRain::default() });
    [("drops in a box", count), ("25 mm/h", real)]
        .map(|(name, rain)| (name, Scene { rain: Some(rain), ..base.clone() }))
}

fn main() -> raindrops::Result<()> {
    let sky = Environment::bundled()?;
    let instance = Instance::new(Validation::Off)?;
    let device = Device::open(&instance, instance.choose(None)?)?;
    println!("{}", device.report.summary());
    println!("{:16}{:>9}{:>16}{:>16}", "scene", "ms", "with layers", "with a depth");
    let folder = tempfile::tempdir().expect("a folder");
    for (name, scene) in scenes() {
        let mut depth = Layers::empty(IMAGE.width, IMAGE.height);
        depth.depth.fill(1e6);
        let mut deep = scene.clone();
        deep.background.depth = Some(folder.path().join("depth.exr"));
        depth.write_depth(&folder.path().join("depth.exr"))?;
        let arm = |scene: &Scene, output| -> raindrops::Result<_> {
            let plan = plan(scene, &sky, output)?;
            Ok((scene.clone(), Renderer::new(&device, scene, &sky, &plan)?, Vec::new()))
        };
        let mut arms = [
            arm(&scene, Output::Radiance)?,
            arm(&scene, Output::Layers)?,
            arm(&deep, Output::Radiance)?,
        ];
        for number in 0..WARM_UP + FRAMES {
            for (scene, renderer, times) in &mut arms {
                scene.time += 1.0 / 60.0;
                let report = renderer.draw(scene)?;
                if number >= WARM_UP {
                    times.push(report.passes_ms.iter().map(|(_, ms)| ms).sum::<f64>());
                }
            }
        }
        let [plain, layers, deep] = arms.map(|(.., times)| median(&times));
        let [of_layers, of_depth] = [layers, deep].map(|ms| ms / plain);
        println!("{name:16}{plain:9.1}{layers:9.1} {of_layers:5.2}x{deep:9.1} {of_depth:5.2}x");
    }
    Ok(())
}
