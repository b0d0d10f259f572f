//! What an environment costs that a host renews: `cargo bench --bench renewal`.
//!
//! Frames of a host that name no environment, a latitude-longitude image of 1024 x 512 texels, and a cube map of 128
//! and of 512 texels an edge, in turn, 960 x 540 with 250,000 drops, on the first device; medians of GPU milliseconds by
//! pass, and of the time on the wall from recording until all is done.

#[path = "../examples/host_ash/src/host.rs"]
mod host;

use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use glam::DVec3;
use half::f16;
use host::{Host, Texture};
use raindrops::device::{Device, HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::measure::statistics::median;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    FrameInput, HostEnvironment, Lighting, LiveInfo, RainField, View, ViewInfo,
};
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, RainSettings, Scene};

const FRAMES: usize = 5;
const SIZE: ImageSize = ImageSize { width: 960, height: 540 };

/// A grey of an image's size, as halves, with a small sun.
fn texels(count: u32) -> Vec<[f16; 4]> {
    let light = |at| if at == count / 3 { 6e4 } else { 0.3 + 0.2 * ((at % 64) as f32 / 64.0) };
    (0..count).map(|at| [light(at), light(at), light(at), 1.0].map(f16::from_f32)).collect()
}

/// An image to be renewed from: a latitude-longitude image, or a cube map.
fn image(host: &Host, edge: u32, is_cube: bool) -> Texture {
    use vk::ImageUsageFlags as Usage;
    let (size, layers) = if is_cube { ((edge, edge), 6) } else { ((2 * edge, edge), 1) };
    let format = vk::Format::R16G16B16A16_SFLOAT;
    let image = host.image(format, size, layers, Usage::SAMPLED | Usage::TRANSFER_DST);
    host.write(&image, bytemuck::cast_slice(&texels(size.0 * size.1 * layers)));
    image
}

fn main() -> raindrops::Result<()> {
    let required = requirements(Preset::Fast);
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.expect("Vulkan");
    let host = Host::new(entry, &required, false, None);
    // SAFETY: all that `lent` says is so, and the host outlives what is made on its device.
    let device = unsafe { Device::import(host.lent(), &required) }?;
    println!("{}", device.report.summary());

    let rain = RainSettings {
        count: 250_000,
        half_extent: DVec3::splat(600.0),
        ..RainSettings::default()
    };
    let mut scene = Scene { image: SIZE, rain: Some(rain), ..Scene::default() };
    scene.model.preset = Preset::Fast;
    let sky = Environment::constant(glam::Vec3::ONE);
    let plan = plan(&scene, &sky, Output::Radiance)?;
    let field = Arc::new(RainField::new(&device, &scene));
    let info = ViewInfo { frames_in_flight: 1, ..ViewInfo::default() };
    let size = (SIZE.width, SIZE.height);
    let target = host.image(info.format, size, 1, vk::ImageUsageFlags::COLOR_ATTACHMENT);
    let output = HostImage::color(target.image, target.view, target.format, target.size);
    let output = HostImage { entry: ImageState::UNDEFINED, ..output };

    // What the light is kept as, and the image's edge.
    let arms = [
        ("no renewal", 512, None),
        ("latitude-longitude, 1024 x 512", 512, Some((512, false))),
        ("cube map of 128, kept as 512 x 256", 256, Some((128, true))),
        ("cube map of 512, kept as 1024 x 512", 512, Some((512, true))),
    ];
    for (name, height, named) in arms {
        let is_cube = named.is_some_and(|(_, is_cube)| is_cube);
        let live = LiveInfo { height, cube: is_cube, ..LiveInfo::default() };
        let lighting = Arc::new(Lighting::live(&device, live)?);
        let mut view = View::new(&lighting, &field, &scene, &plan, &info)?;
        let named = named.map(|(edge, is_cube)| image(&host, edge, is_cube));
        let environment = named.as_ref().map(|texture| {
            let mut image =
                HostImage::color(texture.image, texture.view, texture.format, texture.size);
            image.range.layer_count = texture.layers;
            (image.entry, image.exit) = (ImageState::SAMPLED, ImageState::SAMPLED);
            HostEnvironment::new(image)
        });
        let mut times: Vec<(&str, Vec<f64>)> = Vec::new();
        // The first compiles.
        for number in 0..=FRAMES {
            scene.time += 1.0 / 60.0;
            let mut input = FrameInput::new(&scene, output);
            input.environment = environment;
            let mut recorded = Ok(());
            let start = Instant::now();
            // SAFETY: the images are as described; frames are submitted in order, each waited for.
            host.once(|commands| recorded = unsafe { view.record(commands, 0, &input) });
            recorded?;
            let wall = start.elapsed().as_secs_f64() * 1e3;
            // SAFETY: its commands are done.
            let report = unsafe { view.retired(0) }?.expect("it was executed");
            let passes = report.passes_ms.into_iter().chain([("wall clock", wall)]);
            for (pass, ms) in passes.filter(|_| number > 0) {
                match times.iter_mut().find(|(known, _)| *known == pass) {
                    Some((_, times)) => times.push(ms),
                    None => times.push((pass, vec![ms])),
                }
            }
        }
        println!("\n{name}");
        for (pass, times) in &times {
            println!("{pass:>14} {:9.1} ms", median(times));
        }
        drop((view, lighting));
        named.into_iter().for_each(|texture| host.destroy_image(texture));
    }
    host.destroy_image(target);
    drop(field);
    drop(device);
    Ok(())
}
