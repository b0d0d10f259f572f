//! What a host is asked for and promised: requirements, refusals, room.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;
use raindrops::device::{Device, Features, HostImage, ImageState, requirements};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{Blend, FrameInput, HostMotion, Lighting, RainField, View, ViewInfo};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::{Preset, Simulation};
use raindrops::scene::{PlacedDrop, Scene};

use crate::common;
use crate::embedded::{Embedded, environment, host, on_host, says, scene, view_for, view_of};
use crate::motion_depth::asked;

/// What a view is refused, or a frame, before anything is recorded.
#[test]
fn what_does_not_fit_is_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let made = |info: &ViewInfo| view_of(device, &scene, info);
        let info = ViewInfo::default();
        says(made(&ViewInfo { frames_in_flight: 0, ..info }), "one frame in flight at least");
        let format = vk::Format::R32_UINT;
        says(made(&ViewInfo { format, ..info }), "R32_UINT is none of R16G16B16A16_SFLOAT");
        let lighting = Arc::new(Lighting::new(device, &environment()).expect("light"));
        let rain = Arc::new(RainField::new(device, &scene));
        let by_plan = |scene: &Scene, output| {
            let plan = plan(scene, &environment(), output).expect("a plan");
            View::new(&lighting, &rain, scene, &plan, &info)
        };
        says(by_plan(&scene, Output::Display), "Output::Radiance");
        // It was made for tiles alone, so it lacks what the paper's drops need.
        let mut paper = scene.clone();
        paper.model.preset = Preset::Paper;
        says(
            by_plan(&paper, Output::Radiance),
            "largePoints, shaderStorageImageWriteWithoutFormat",
        );
        paper.model.simulation = Some(Simulation::Stored);
        says(by_plan(&paper, Output::Radiance), "simulation integer");

        let mut embedded = Embedded::new(host, device, &scene, &info);
        let good = embedded.output();
        let commands = embedded.commands[0];
        host.begin(commands);
        let mut refused = |slot, scene: &Scene, output, words| {
            // SAFETY: nothing is submitted.
            says(
                unsafe { embedded.view.record(commands, slot, &FrameInput::new(scene, output)) },
                words,
            );
        };
        refused(2, &scene, good, "no slot 2: the view has 2");
        let mut other = scene.clone();
        other.seed += 1;
        refused(0, &other, good, "other drops");
        refused(
            0,
            &scene,
            HostImage { size: (96, 65), ..good },
            "96 x 65 texels; the view has 96 x 64",
        );
        let samples = vk::SampleCountFlags::TYPE_4;
        refused(0, &scene, HostImage { samples, ..good }, "TYPE_4 samples a texel");
        let format = vk::Format::R8G8B8A8_UNORM;
        refused(0, &scene, HostImage { format, ..good }, "R8G8B8A8_UNORM; the view was made for");
        let exit = ImageState::UNDEFINED;
        refused(0, &scene, HostImage { exit, ..good }, "handed back in layout UNDEFINED");
        let view = vk::ImageView::null();
        refused(0, &scene, HostImage { view, ..good }, "null");
        refused(0, &Scene { time: f64::NAN, ..scene.clone() }, good, "time = NaN");
        let mut lying = scene.clone();
        lying.camera.vertical_fov = 0.0;
        refused(0, &lying, good, "vertical_fov = 0");
        host.end(commands);

        // Motion and depth: an image of its own for each, where they were asked for.
        let since = |camera, image| HostMotion::since(camera, 0.0, image);
        let camera = scene.camera;
        let nan = Camera { position: DVec3::NAN, ..camera };
        let mut both = view_of(device, &scene, &asked()).expect("a view");
        let motion = HostImage { format: vk::Format::R32G32_SFLOAT, ..good };
        let empty = HostImage { entry: ImageState::UNDEFINED, ..motion };
        let held = HostImage { entry: ImageState::SAMPLED, ..motion };
        let depth = HostImage { format: vk::Format::R32_SFLOAT, ..held };
        let input = FrameInput::new(&scene, good);
        for (input, words) in [
            (input, "name an image for it"),
            (input.moved(since(camera, good)), "R16G16B16A16_SFLOAT; the view was made for R32G32"),
            (input.moved(since(camera, empty)), "holds nothing"),
            (
                input.moved(since(nan, held)).nearest(depth),
                "the frame before: camera: the first of position",
            ),
            (input.moved(HostMotion::since(camera, f64::NAN, held)).nearest(depth), "not finite"),
            (input.moved(since(camera, held)), "draw nearest depth; name an image for it"),
        ] {
            // SAFETY: nothing is recorded.
            says(unsafe { both.record(commands, 0, &input) }, words);
        }
        // SAFETY: nothing is recorded.
        let unasked = unsafe { embedded.view.record(commands, 0, &input.nearest(depth)) };
        says(unasked, "made for no nearest depth");
        let format = Some(vk::Format::R8G8B8A8_UNORM);
        says(made(&ViewInfo { motion: format, ..info }), "is none of R16G16_SFLOAT");

        embedded.record(host, 0, &scene);
        host.begin(embedded.commands[1]);
        // SAFETY: nothing is submitted.
        let twice = unsafe {
            embedded.view.record(embedded.commands[1], 0, &FrameInput::new(&scene, good))
        };
        says(twice, "slot 0 is taken");
        host.end(embedded.commands[1]);
        let over = ViewInfo { blend: Blend::Over, ..info };
        says(view_of(device, &scene, &over), "plan for Output::Layers");
        let before = ViewInfo { has_color: true, ..over };
        says(view_for(device, &scene, Output::Layers, &before), "Output::Radiance");
        let mut over = view_for(device, &scene, Output::Layers, &over).expect("a view");
        // SAFETY: nothing is recorded.
        let lost = unsafe { over.record(commands, 0, &FrameInput::new(&scene, good)) };
        says(lost, "holds nothing");
        host.destroy_image(embedded.target);
    });
}

/// Drops that there was no room for are counted, and there is room after the view has grown, which a frame under way
/// does not notice.
#[test]
fn what_did_not_fit_is_reported_and_the_view_grows() {
    let mut scene = scene(Preset::Fast);
    scene.rain = None;
    let drop = |number: i32| {
        PlacedDrop::sphere(DVec3::new(0.0, 0.0, -2.0 - 0.001 * f64::from(number)), 1.5)
    };
    scene.drops = (0..100).map(drop).collect();
    on_host(Preset::Fast, |host, device| {
        let mut embedded = Embedded::new(host, device, &scene, &ViewInfo::default());
        let (_, report) = embedded.frame(host, 0, &scene);
        assert!(report.counts.overflow > 0, "{:?}", report.counts);
        embedded.record(host, 1, &scene);
        embedded.view.grow().expect("room");
        embedded.view.grow().expect("room");
        // The frame under way is executed, and told.
        host.run(embedded.commands[1]);
        // SAFETY: it was waited for.
        let late = unsafe { embedded.view.retired(1) }.expect("no error").expect("it was executed");
        assert!(late.counts.overflow > 0, "{:?}", late.counts);
        let (_, report) = embedded.frame(host, 0, &scene);
        assert_eq!(report.counts.overflow, 0, "{:?}", report.counts);
        // Its slot's next recording is not taken for it.
        embedded.record(host, 1, &scene);
        // SAFETY: it is never submitted.
        assert_eq!(unsafe { embedded.view.retired(1) }.expect("no error"), None);
        host.destroy_image(embedded.target);
    });
}

#[test]
fn requirements_are_known_before_the_device() {
    let _alone = crate::common::layer::alone();
    let named = |preset| {
        let features = requirements(preset).features.named();
        features.into_iter().filter(|(_, wanted)| *wanted).map(|(name, _)| name).collect::<Vec<_>>()
    };
    let of_13 = [
        "timelineSemaphore",
        "hostQueryReset",
        "dynamicRendering",
        "synchronization2",
        "maintenance4",
        "shaderDemoteToHelperInvocation",
    ];
    let of_paper = ["largePoints", "shaderStorageImageWriteWithoutFormat"];
    assert_eq!(named(Preset::Fast), of_13);
    assert_eq!(named(Preset::Exact), of_13);
    assert_eq!(named(Preset::Paper), [&of_paper[..], &of_13].concat());
    assert!(requirements(Preset::Paper).extensions.is_empty());
    // Our own devices are made with what every preset needs.
    common::on_device(|device| {
        assert_eq!(device.report.features, requirements(Preset::Paper).features)
    });

    // A host that has enabled less is told what.
    let host = host(Preset::Fast);
    let refused = |lent, required| {
        // SAFETY: it is refused, so nothing is made on it.
        let made = unsafe { Device::import(lent, &required) };
        made.map(drop).expect_err("a refusal").to_string()
    };
    let lacking = |features, api_version| {
        let mut lent = host.lent();
        (lent.features, lent.api_version) = (features, api_version);
        refused(lent, requirements(Preset::Fast))
    };
    let features = Features { maintenance4: false, dynamic_rendering: false, ..host.features };
    assert!(
        lacking(features, vk::API_VERSION_1_3)
            .contains("lacks dynamicRendering, maintenance4 as its host made it:")
    );
    assert!(
        lacking(host.features, vk::API_VERSION_1_2)
            .contains("lacks Vulkan 1.3 as its host made it:")
    );
    // So is one whose device has lower limits: here than nobody has.
    let mut limits = requirements(Preset::Fast);
    assert_eq!((limits.workgroup_invocations, limits.storage_buffers_per_stage), (256, 24));
    (limits.workgroup_invocations, limits.storage_buffers_per_stage) = (u32::MAX, u32::MAX);
    let line = refused(host.lent(), limits);
    let expected =
        "lacks workgroups of 256 invocations, 24 storage buffers a stage as its host made it:";
    assert!(line.contains(expected), "{line}");
    assert_eq!(host.messages(), Vec::<String>::new());
}
