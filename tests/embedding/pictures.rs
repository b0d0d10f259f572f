//! The picture in a host's frame is the one that `render` makes, with light that is renewed, too.

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};
use half::f16;
use raindrops::device::{HostImage, ImageState};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::{box_filter, rel_mse};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    FrameInput, FrameReport, HostEnvironment, Lighting, LiveInfo, RainField, View, ViewInfo,
};
use raindrops::scene::model::Preset;

use crate::common;
use crate::embedded::{Embedded, SIZE, environment, film, on_host, rendered, scene};
use crate::host::Texture;

#[test]
fn the_embedded_picture_is_that_of_render() {
    for preset in [Preset::Fast, Preset::Exact, Preset::Paper] {
        let scenes = film(preset);
        let expected = rendered(&scenes);
        on_host(preset, |host, device| {
            let info = ViewInfo { frames_in_flight: 3, ..ViewInfo::default() };
            let mut embedded = Embedded::new(host, device, &scenes[0], &info);
            for (number, scene) in scenes.iter().enumerate() {
                let (picture, report) = embedded.frame(host, number % 3, scene);
                assert!(report.counts.visible > 1000, "{:?}", report.counts);
                let differ = picture.iter().zip(&expected[number]).filter(|(a, b)| a != b).count();
                assert!(differ == 0, "{preset} frame {number}: {differ} pixels differ");
            }
            host.destroy_image(embedded.target);
        });
    }
}

/// What is recorded and thrown away leaves no trace: not in the picture, and not in what is kept from frame to frame.
#[test]
fn commands_that_are_never_submitted_do_no_harm() {
    let scenes = film(Preset::Fast);
    let expected = rendered(&scenes);
    on_host(Preset::Fast, |host, device| {
        let mut embedded = Embedded::new(host, device, &scenes[0], &ViewInfo::default());
        for (number, scene) in scenes.iter().enumerate() {
            // Of this view and of another, before each frame.
            for other in [number, (number + 2) % scenes.len()] {
                embedded.record(host, 1, &scenes[other]);
                // SAFETY: it is never submitted.
                let report = unsafe { embedded.view.retired(1) }.expect("no error");
                assert_eq!(report, None, "it was never executed");
            }
            let (picture, _) = embedded.frame(host, 0, scene);
            assert!(picture == expected[number], "frame {number}");
        }
        host.destroy_image(embedded.target);
    });
}

/// The control: without a sky of its own a frame of another view shows the wrong one. Here the sky is kept.
#[test]
fn a_view_that_stands_still_keeps_its_sky() {
    on_host(Preset::Fast, |host, device| {
        let still = scene(Preset::Fast);
        let mut embedded = Embedded::new(host, device, &still, &ViewInfo::default());
        let draws_sky =
            |report: FrameReport| report.passes_ms.iter().any(|(name, _)| *name == "sky");
        let drawn: Vec<bool> =
            (0..4).map(|frame| draws_sky(embedded.frame(host, frame % 2, &still).1)).collect();
        assert_eq!(drawn, [true, false, false, false]);
        host.destroy_image(embedded.target);
    });
}

/// Light that is renewed from an image is that of the same image when it is prepared on the CPU, sun and all; another
/// image shows in the frame that it is named with, and stays.
#[test]
fn renewed_light_is_that_of_the_same_environment() {
    let scene = scene(Preset::Fast);
    // The same, turned by a quarter.
    let (sky, turned) = (environment(), {
        let sky = environment();
        common::painted(256, move |d| sky.radiance(DVec3::new(-d.z, d.y, d.x)).as_vec3())
    });
    on_host(Preset::Fast, |host, device| {
        let rain = Arc::new(RainField::new(device, &scene));
        let plan = plan(&scene, &sky, Output::Radiance).expect("a plan");
        let by = |lighting| {
            let info = ViewInfo::default();
            View::new(&Arc::new(lighting), &rain, &scene, &plan, &info).expect("a view")
        };
        let of_cpu = |environment| {
            let view = by(Lighting::new(device, environment).expect("light"));
            let mut embedded = Embedded::new(host, device, &scene, &ViewInfo::default());
            embedded.view = view;
            let (picture, _) = embedded.frame(host, 0, &scene);
            host.destroy_image(embedded.target);
            as_picture(&picture)
        };
        let (expected, other) = (of_cpu(&sky), of_cpu(&turned));

        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let uploaded = |environment: &Environment| {
            let image = host.image(vk::Format::R16G16B16A16_SFLOAT, (256, 128), 1, usage);
            let texels = environment.texels().iter();
            let halves: Vec<[f16; 4]> =
                texels.map(|t| t.extend(1.0).to_array().map(f16::from_f32)).collect();
            host.write(&image, bytemuck::cast_slice(&halves));
            image
        };
        let images = [uploaded(&sky), uploaded(&turned)];
        let live = LiveInfo { height: 128, cube: false, ..LiveInfo::default() };
        let mut embedded = Embedded::new(host, device, &scene, &ViewInfo::default());
        embedded.view = by(Lighting::live(device, live).expect("light"));
        let mut frame = |number: usize, named: Option<usize>| {
            let output = embedded.output();
            let mut input = FrameInput::new(&scene, output);
            if let Some(named) = named {
                let Texture { image, view, format, size, .. } = images[named];
                let state = ImageState::SAMPLED;
                let image = HostImage {
                    entry: state,
                    exit: state,
                    ..HostImage::color(image, view, format, size)
                };
                input = input.around(HostEnvironment::new(image));
            }
            let (commands, fence) = (embedded.commands[number % 2], host.fence());
            host.begin(commands);
            // SAFETY: the images are as they are described; the frames are submitted in order.
            unsafe { embedded.view.record(commands, number % 2, &input) }.expect("a recording");
            host.end(commands);
            host.submit(commands, fence);
            host.wait(fence);
            host.destroy_fence(fence);
            // SAFETY: the fence was signalled.
            let report = unsafe { embedded.view.retired(number % 2) }.expect("a report");
            println!("{:?}", &report.expect("it was executed").passes_ms[..2]);
            as_picture(&embedded.read(host))
        };
        let error = |a: &Picture, b: &Picture| rel_mse(&box_filter(a), &box_filter(b), None);
        let first = frame(0, Some(0));
        let difference = error(&expected, &other);
        println!("relMSE {:.7}; of another environment {difference:.4}", error(&expected, &first));
        assert!(error(&expected, &first) < 0.002 * difference);
        let kept = frame(1, None);
        assert!(kept == first, "it stays");
        assert!(error(&other, &frame(2, Some(1))) < 0.002 * difference);
        host.destroy_image(embedded.target);
        drop(embedded.view);
        images.into_iter().for_each(|image| host.destroy_image(image));
    });
}

fn as_picture(pixels: &[[f16; 4]]) -> Picture {
    let light = |p: &[f16; 4]| Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32());
    Picture { width: SIZE.0, height: SIZE.1, pixels: pixels.iter().map(light).collect() }
}
