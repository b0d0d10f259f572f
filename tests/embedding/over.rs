//! Rain alone in a host's image: premultiplied, or laid over what the image holds.

use std::sync::Arc;

use ash::vk;
use glam::Vec3;
use half::f16;
use raindrops::device::{Device, HostImage, ImageState};
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{Blend, FrameInput, Renderer, ViewInfo};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common;
use crate::embedded::{SIZE, environment, on_host, scene, view_for};
use crate::host::Host;

/// What the image holds before: bright, so that it shows where it is not hidden.
fn plate() -> Picture {
    let pixel = |at: u32| Vec3::new((at % 7) as f32, (at / SIZE.0 % 5) as f32, 2.0);
    let pixels = (0..SIZE.0 * SIZE.1).map(pixel).collect();
    Picture { width: SIZE.0, height: SIZE.1, pixels }
}

/// A frame of rain alone by a host, into an image that holds the plate.
fn by_host(host: &Host, device: &Arc<Device>, scene: &Scene, blend: Blend) -> Vec<[f16; 4]> {
    use vk::ImageUsageFlags as Usage;
    let info = ViewInfo { blend, ..ViewInfo::default() };
    let mut view = view_for(device, scene, Output::Layers, &info).expect("a view");
    let usage = Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
    let target = host.image(info.format, SIZE, 1, usage | Usage::SAMPLED);
    let held = plate().pixels;
    let held: Vec<[f16; 4]> =
        held.iter().map(|p| p.extend(1.0).to_array().map(f16::from_f32)).collect();
    host.write(&target, bytemuck::cast_slice(&held));
    let output = HostImage {
        entry: ImageState::SAMPLED,
        exit: ImageState::COPY_SOURCE,
        ..HostImage::color(target.image, target.view, target.format, target.size)
    };
    host.once(|commands| {
        // SAFETY: the image is as described; it is submitted once.
        unsafe { view.record(commands, 0, &FrameInput::new(scene, output)) }.expect("a recording");
    });
    let bytes = host.read(&target, 8 * u64::from(SIZE.0 * SIZE.1));
    drop(view);
    host.destroy_image(target);
    bytemuck::pod_collect_to_vec(&bytes)
}

fn layers(scene: &Scene) -> Layers {
    let mut layers = None;
    common::on_device(|device| {
        let plan = plan(scene, &environment(), Output::Layers).expect("a plan");
        let made = Renderer::new(device, scene, &environment(), &plan);
        let mut renderer = made.expect("a renderer");
        renderer.submit(scene).expect("a frame");
        layers = Some(renderer.read_layers().expect("layers"));
    });
    layers.expect("drawn")
}

/// The result is what light and opacity of the layers say, within float16's rounding of the blended sum, and as opaque as the image was.
#[test]
fn rain_is_laid_over_what_the_image_holds() {
    let mut real = scene(Preset::Fast);
    let heavy = RealRain { rate: 200.0, extent: 60.0, ..RealRain::default() };
    real.rain = Some(RainSettings::of(heavy));
    real.drops = vec![PlacedDrop::sphere(glam::DVec3::new(0.02, 0.0, -0.5), 0.1)];
    for (name, scene) in [("box", scene(Preset::Fast)), ("real rain", real)] {
        let rain = layers(&scene);
        let (over, plate) = (rain.over(&plate()), plate());
        on_host(Preset::Fast, |host, device| {
            let found = by_host(host, device, &scene, Blend::Over);
            let (mut hidden, mut free) = (0, 0);
            for (at, pixel) in found.iter().enumerate() {
                let [r, g, b, a] = pixel.map(f16::to_f32);
                let (found, expected) = (Vec3::new(r, g, b), over.pixels[at]);
                // Roundings of what is added and of the sum, on llvmpipe towards 0.
                let allowed = (expected.abs() + plate.pixels[at]) / 1024.0 + 1e-4;
                let off = (found - expected).abs();
                assert!(off.cmple(allowed).all(), "{name}: {at} is {found}, not {expected}");
                assert!((a - 1.0).abs() < 1e-3, "{name}: {at} has opacity {a}");
                let opacity = rain.color[at][3].to_f32();
                hidden += u32::from(opacity > 0.5);
                free += u32::from(opacity < 0.5);
            }
            println!("{name}: {hidden} pixels hidden, {free} free");
            assert!(hidden > 20 && free > 100, "{name}: {hidden}, {free}");
            let alone = by_host(host, device, &scene, Blend::Replace);
            assert!(alone == rain.color, "{name}: rain alone is another");
        });
    }
}
