//! What a host's images are refused for: before anything is recorded, in one line.

use std::sync::Arc;

use ash::vk::{self, Handle as _};
use glam::Mat3;
use raindrops::device::{HostImage, ImageState};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    DepthConvention, FrameInput, HostEnvironment, HostMotion, Lighting, LiveInfo, RainField, View,
    ViewInfo,
};
use raindrops::scene::background::DepthKind;
use raindrops::scene::model::Preset;

use crate::embedded::{SIZE, environment, on_host, scene, view_of};
use crate::motion_depth::asked;

/// An image that is named and never used.
fn named(number: u64, format: vk::Format, size: (u32, u32)) -> HostImage {
    let (image, view) = (vk::Image::from_raw(number), vk::ImageView::from_raw(number));
    let state = ImageState::SAMPLED;
    HostImage { entry: state, exit: state, ..HostImage::color(image, view, format, size) }
}

/// What any image is refused for that is read or kept.
fn wrong(image: HostImage) -> [(HostImage, &'static str); 6] {
    let samples = vk::SampleCountFlags::TYPE_4;
    [
        (HostImage { size: (95, 64), ..image }, "95 x 64 texels"),
        (HostImage { samples, ..image }, "TYPE_4 samples a texel"),
        (HostImage { entry: ImageState::UNDEFINED, ..image }, "holds nothing"),
        (HostImage { exit: ImageState::UNDEFINED, ..image }, "handed back in layout"),
        (HostImage { format: vk::Format::R32_UINT, ..image }, "R32_UINT"),
        (HostImage { view: vk::ImageView::null(), ..image }, "null"),
    ]
}

/// Asserts that a frame is refused. The command buffer does not record, which the layer would say of any command.
#[track_caller]
fn assert_refused(
    view: &mut View,
    commands: vk::CommandBuffer,
    input: &FrameInput<'_>,
    words: &[&str],
) {
    // SAFETY: nothing is recorded.
    let refused = unsafe { view.record(commands, 0, input) };
    let line = refused.expect_err(words[0]).to_string();
    println!("{line}");
    assert!(words.iter().all(|words| line.contains(words)) && !line.contains('\n'), "{line}");
}

#[test]
fn a_background_that_does_not_fit_is_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let info = ViewInfo { has_color: true, has_depth: true, ..ViewInfo::default() };
        let mut view = view_of(device, &scene, &info).expect("a view");
        let commands = host.commands();
        let color = named(2, info.format, SIZE);
        let depth = named(3, vk::Format::D32_SFLOAT, SIZE);
        let linear = DepthConvention::linear(1.0, DepthKind::Planar);
        let input = FrameInput::new(&scene, named(1, info.format, SIZE));
        let full = |color: HostImage, radiance, depth: HostImage, convention| {
            input.before(color, radiance).hidden_by(depth, convention)
        };
        let colors =
            wrong(color).map(|(image, words)| (full(image, 1.0, depth, linear), "colour", words));
        let depths =
            wrong(depth).map(|(image, words)| (full(color, 1.0, image, linear), "depth", words));
        let nan = DepthConvention::projected(f32::NAN, 0.1);
        let others = [
            (full(color, f32::NAN, depth, linear), "colour", "not finite and over 0"),
            (full(color, 0.0, depth, linear), "colour", "not finite and over 0"),
            (full(color, 1.0, depth, nan), "depth", "not finite"),
            (input.before(color, 1.0), "depth", "name one"),
            (input.hidden_by(depth, linear), "colour", "name one"),
        ];
        for (input, image, words) in colors.into_iter().chain(depths).chain(others) {
            assert_refused(&mut view, commands, &input, &[image, words]);
        }
        let mut without = view_of(device, &scene, &ViewInfo::default()).expect("a view");
        let unasked = input.before(color, 1.0);
        assert_refused(&mut without, commands, &unasked, &["no background colour"]);
    });
}

#[test]
fn images_of_motion_and_depth_that_do_not_fit_are_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let mut view = view_of(device, &scene, &asked()).expect("a view");
        let commands = host.commands();
        let input = FrameInput::new(&scene, named(1, asked().format, SIZE));
        let motion = named(2, vk::Format::R32G32_SFLOAT, SIZE);
        let depth = named(3, vk::Format::R32_SFLOAT, SIZE);
        let since = |image| HostMotion::since(scene.camera, 0.0, image);
        for (image, words) in wrong(motion) {
            let input = input.moved(since(image)).nearest(depth);
            assert_refused(&mut view, commands, &input, &["motion", words]);
        }
        for (image, words) in wrong(depth) {
            let input = input.moved(since(motion)).nearest(image);
            assert_refused(&mut view, commands, &input, &["nearest depth", words]);
        }
    });
}

#[test]
fn an_environment_that_does_not_fit_is_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let plan = plan(&scene, &environment(), Output::Radiance).expect("a plan");
        let rain = Arc::new(RainField::new(device, &scene));
        let commands = host.commands();
        let size = (64, 64);
        let image = named(2, vk::Format::R16G16B16A16_SFLOAT, size);
        let layers = |count| {
            let mut image = image;
            image.range.layer_count = count;
            image
        };
        let input = FrameInput::new(&scene, named(1, ViewInfo::default().format, SIZE));
        let mut fixed = view_of(device, &scene, &ViewInfo::default()).expect("a view");
        let around = input.around(HostEnvironment::new(image));
        assert_refused(&mut fixed, commands, &around, &["Lighting::live"]);
        for (cube, good, bad) in [(true, 6, 1), (false, 1, 6)] {
            let info = LiveInfo { height: 16, cube, ..LiveInfo::default() };
            let light = Arc::new(Lighting::live(device, info).expect("light"));
            let made = View::new(&light, &rain, &scene, &plan, &ViewInfo::default());
            let mut view = made.expect("a view");
            let others = wrong(layers(good)).map(|(image, words)| match words {
                // It may have any size but none.
                "95 x 64 texels" => (HostImage { size: (0, 64), ..image }, "no texels"),
                _ => (image, words),
            });
            let images = others.into_iter().chain([(layers(bad), "the light was made for one")]);
            let environment = HostEnvironment::new(layers(good));
            let of_image =
                images.map(|(image, words)| (HostEnvironment { image, ..environment }, words));
            let twice = Mat3::from_diagonal(glam::Vec3::splat(2.0));
            let others = [
                (HostEnvironment { to_image: twice, ..environment }, "neither a rotation"),
                (HostEnvironment { to_image: Mat3::NAN, ..environment }, "neither a rotation"),
                (HostEnvironment { radiance: -1.0, ..environment }, "not finite and over 0"),
                (HostEnvironment { radiance: f32::NAN, ..environment }, "not finite and over 0"),
            ];
            for (around, words) in of_image.chain(others) {
                let input = input.around(around);
                assert_refused(&mut view, commands, &input, &["the environment", words]);
            }
        }
    });
}

/// Each pair of what a frame takes.
#[test]
fn one_image_for_two_things_is_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let plan = plan(&scene, &environment(), Output::Radiance).expect("a plan");
        let rain = Arc::new(RainField::new(device, &scene));
        let live = LiveInfo { height: 16, cube: false, ..LiveInfo::default() };
        let light = Arc::new(Lighting::live(device, live).expect("light"));
        let info = ViewInfo { has_color: true, has_depth: true, ..asked() };
        let mut view = View::new(&light, &rain, &scene, &plan, &info).expect("a view");
        let commands = host.commands();
        let things = [
            ("the output", info.format),
            ("the background colour", info.format),
            ("the background depth", vk::Format::D32_SFLOAT),
            ("the environment", info.format),
            ("motion", vk::Format::R32G32_SFLOAT),
            ("nearest depth", vk::Format::R32_SFLOAT),
        ];
        for second in 1..things.len() {
            for first in 0..second {
                let image = |at: usize| {
                    let number = if at == second { first } else { at };
                    named(1 + number as u64, things[at].1, SIZE)
                };
                let input = FrameInput::new(&scene, image(0))
                    .before(image(1), 1.0)
                    .hidden_by(image(2), DepthConvention::linear(1.0, DepthKind::Planar))
                    .around(HostEnvironment::new(image(3)))
                    .moved(HostMotion::since(scene.camera, 0.0, image(4)))
                    .nearest(image(5));
                let words = [things[first].0, things[second].0, "are one image"];
                assert_refused(&mut view, commands, &input, &words);
            }
        }
    });
}
