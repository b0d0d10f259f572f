//! Rain in a host's frame: what it asks of the device, what it records and what not, what it refuses, and that its
//! picture is the one that `render` makes. The host is the one of `examples/host_ash`.

mod common;
#[path = "../examples/host_ash/host.rs"]
mod host;

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

use ash::vk;
use glam::{DVec3, Vec3};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use half::f16;
use raindrops::device::{Device, Features, HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::{box_filter, rel_mse};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    Blend, FrameInput, FrameReport, HostEnvironment, Lighting, LiveInfo, RainField, Renderer, View,
    ViewInfo,
};
use raindrops::scene::model::{Preset, Simulation};
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use host::{Host, Texture};

const SIZE: (u32, u32) = (96, 64);

fn scene(preset: Preset) -> Scene {
    let mut scene = Scene::default();
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.image = ImageSize { width: SIZE.0, height: SIZE.1 };
    scene.rain.get_or_insert_default().count = 20_000;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.2, 0.1, -5.0), 1.0)];
    scene
}

/// A sky with a sun.
fn environment() -> Environment {
    let sun = DVec3::new(0.3, 0.4, -1.0).normalize();
    common::painted(256, move |d| {
        let sky = Vec3::new(0.4, 0.6, 1.0) * (0.6 + 0.4 * d.y as f32);
        if d.dot(sun) > 0.9998 { Vec3::splat(3e3) } else { sky }
    })
}

fn wanted() -> Option<String> {
    std::env::var("RAINDROPS_TEST_DEVICE").ok()
}

fn host(preset: Preset) -> Host {
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.expect("Vulkan");
    Host::new(entry, &requirements(preset), true, wanted().as_deref())
}

/// Rain on a host's device, and an image to draw it into.
struct Embedded {
    view: View,
    target: Texture,
    commands: Vec<vk::CommandBuffer>,
}

fn view_of(device: &Arc<Device>, scene: &Scene, info: &ViewInfo) -> raindrops::Result<View> {
    let environment = environment();
    let plan = plan(scene, &environment, Output::Radiance)?;
    let lighting = Arc::new(Lighting::new(device, &environment)?);
    View::new(&lighting, &Arc::new(RainField::new(device, scene)), scene, &plan, info)
}

impl Embedded {
    fn new(host: &Host, device: &Arc<Device>, scene: &Scene, info: &ViewInfo) -> Self {
        let view = view_of(device, scene, info).expect("a view");
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let target = host.image(info.format, SIZE, 1, usage);
        let commands = (0..info.frames_in_flight).map(|_| host.commands()).collect();
        Self { view, target, commands }
    }

    /// The target, which comes without content and goes as a source of copies.
    fn output(&self) -> HostImage {
        let target = &self.target;
        HostImage {
            entry: ImageState { stages: vk::PipelineStageFlags2::COPY, ..ImageState::UNDEFINED },
            exit: ImageState::COPY_SOURCE,
            ..HostImage::color(target.image, target.view, target.format, target.size)
        }
    }

    /// Records a frame into a slot's command buffer.
    fn record(&mut self, host: &Host, slot: usize, scene: &Scene) {
        let (commands, output) = (self.commands[slot], self.output());
        host.begin(commands);
        // SAFETY: the image is as it is described; the frames are submitted in order, or never.
        let recorded = unsafe { self.view.record(commands, slot, &FrameInput::new(scene, output)) };
        recorded.expect("a recording");
        host.end(commands);
    }

    /// A frame that is submitted and waited for.
    fn frame(&mut self, host: &Host, slot: usize, scene: &Scene) -> (Vec<[f16; 4]>, FrameReport) {
        self.record(host, slot, scene);
        let fence = host.fence();
        host.submit(self.commands[slot], fence);
        host.wait(fence);
        host.destroy_fence(fence);
        // SAFETY: the fence was signalled.
        let report =
            unsafe { self.view.retired(slot) }.expect("a report").expect("it was executed");
        (self.read(host), report)
    }

    fn read(&self, host: &Host) -> Vec<[f16; 4]> {
        let bytes = host.read(&self.target, 8 * u64::from(SIZE.0 * SIZE.1));
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

/// Runs a test on a host of its own, and fails if the layer says anything.
fn on_host(preset: Preset, test: impl FnOnce(&Host, &Arc<Device>)) {
    let host = host(preset);
    // SAFETY: the host outlives all that is made on its device, and is idle then.
    let device = unsafe { Device::import(host.lent(), &requirements(preset)) }.expect("a device");
    test(&host, &device);
    assert_eq!(Arc::strong_count(&device), 1, "something outlives its test");
    drop(device);
    // The device is still there.
    host.once(|_| ());
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// The pictures of `render`, as the host's format holds them.
fn rendered(scenes: &[Scene]) -> Vec<Vec<[f16; 4]>> {
    let mut pictures = Vec::new();
    common::on_device(|device| {
        let environment = environment();
        let plan = plan(&scenes[0], &environment, Output::Radiance).expect("a plan");
        let made = Renderer::new(device, &scenes[0], &environment, &plan);
        let mut renderer = made.expect("a renderer");
        for scene in scenes {
            renderer.submit(scene).expect("a frame");
            let picture = renderer.read_radiance().expect("a picture");
            let pixels = picture.pixels.iter();
            pictures.push(pixels.map(|p| p.extend(1.0).to_array().map(f16::from_f32)).collect());
        }
    });
    pictures
}

/// A camera that stands, turns, stands, and turns back, while the rain falls.
fn film(preset: Preset) -> Vec<Scene> {
    let aims = [0.0, 0.0, 0.4, 0.4, 0.4, 0.0];
    let frames = aims.iter().enumerate().map(|(number, aim)| {
        let mut scene = scene(preset);
        scene.camera.target.x += aim;
        scene.time = 0.02 * number as f64;
        scene
    });
    frames.collect()
}

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
                // The paper's blending adds up in no order.
                let differ = picture.iter().zip(&expected[number]).filter(|(a, b)| a != b).count();
                let most = if preset == Preset::Paper { picture.len() / 50 } else { 0 };
                assert!(differ <= most, "{preset} frame {number}: {differ} pixels differ");
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

/// What a view is refused, or a frame, before anything is recorded.
#[test]
fn what_does_not_fit_is_refused() {
    on_host(Preset::Fast, |host, device| {
        let scene = scene(Preset::Fast);
        let says = |result: raindrops::Result<()>, words: &str| {
            let line = result.expect_err("a refusal").to_string();
            println!("{line}");
            assert!(line.contains(words) && !line.contains('\n'), "'{line}' says not '{words}'");
        };
        let made = |info: &ViewInfo| view_of(device, &scene, info).map(drop);
        let info = ViewInfo::default();
        says(made(&ViewInfo { frames_in_flight: 0, ..info }), "one frame in flight at least");
        let format = vk::Format::R32_UINT;
        says(made(&ViewInfo { format, ..info }), "R32_UINT is none of R16G16B16A16_SFLOAT");
        let lighting = Arc::new(Lighting::new(device, &environment()).expect("light"));
        let rain = Arc::new(RainField::new(device, &scene));
        let by_plan = |scene: &Scene, output| {
            let plan = plan(scene, &environment(), output).expect("a plan");
            View::new(&lighting, &rain, scene, &plan, &info).map(drop)
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
        host.end(commands);

        embedded.record(host, 0, &scene);
        host.begin(embedded.commands[1]);
        // SAFETY: nothing is submitted.
        let twice = unsafe {
            embedded.view.record(embedded.commands[1], 0, &FrameInput::new(&scene, good))
        };
        says(twice, "slot 0 is taken");
        host.end(embedded.commands[1]);
        let over = ViewInfo { blend: Blend::Over, ..info };
        let mut over = view_of(device, &scene, &over).expect("a view");
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
        let (_, report) = embedded.frame(host, 0, &scene);
        assert_eq!(report.counts.overflow, 0, "{:?}", report.counts);
        // SAFETY: it is never submitted.
        assert_eq!(unsafe { embedded.view.retired(1) }.expect("no error"), None);
        host.destroy_image(embedded.target);
    });
}

#[test]
fn requirements_are_known_before_the_device() {
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
    let lacking = |features, api_version| {
        let mut lent = host.lent();
        (lent.features, lent.api_version) = (features, api_version);
        // SAFETY: it is refused, so nothing is made on it.
        let made = unsafe { Device::import(lent, &requirements(Preset::Fast)) };
        made.map(drop).expect_err("a refusal").to_string()
    };
    let features = Features { maintenance4: false, dynamic_rendering: false, ..host.features };
    assert!(
        lacking(features, vk::API_VERSION_1_3).contains("lacks dynamicRendering, maintenance4:")
    );
    assert!(lacking(host.features, vk::API_VERSION_1_2).contains("lacks Vulkan 1.3:"));
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// Set-up takes memory from the host's allocator and the queue under the host's lock.
#[test]
fn memory_and_queue_are_the_hosts() {
    let host = host(Preset::Fast);
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: host.instance.clone(),
        device: host.device.clone(),
        physical_device: host.physical,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    });
    let allocator = Arc::new(Mutex::new(allocator.expect("an allocator")));
    let calls = Arc::new(AtomicUsize::new(0));
    let (mut lent, counted) = (host.lent(), calls.clone());
    lent.allocator = Some(allocator.clone());
    lent.queue_lock = Some(Arc::new(move |work: &mut dyn FnMut()| {
        counted.fetch_add(1, SeqCst);
        work();
    }));
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(lent, &requirements(Preset::Fast)) }.expect("a device");
    let scene = scene(Preset::Fast);
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    let bytes = || allocator.lock().expect("no panic").generate_report().total_allocated_bytes;
    assert!(bytes() > 1 << 20, "{} bytes", bytes());
    let of_set_up = calls.load(SeqCst);
    assert!(of_set_up > 3, "{of_set_up}");
    embedded.frame(&host, 0, &scene);
    assert_eq!(calls.load(SeqCst), of_set_up, "a frame does not use the queue");
    host.destroy_image(embedded.target);
    drop(embedded.view);
    drop(device);
    assert_eq!(bytes(), 0);
    assert_eq!(Arc::strong_count(&allocator), 1);
    drop(allocator);
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// Calls that a frame must not make, and its host must not see; each with a counter.
macro_rules! counted {
    ($($name:ident)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook(a: usize, b: usize, c: usize, d: usize, e: usize, f: usize) -> usize {
                CALLS.fetch_add(1, SeqCst);
                // SAFETY: the layer's function of this name: its arguments are six words at most, none of them a float.
                unsafe {
                    let real: unsafe extern "system" fn(usize, usize, usize, usize, usize, usize) -> usize =
                        std::mem::transmute(REAL.load(SeqCst));
                    real(a, b, c, d, e, f)
                }
            }
        })*

        fn hook_of(name: &CStr) -> Option<(*const c_void, &'static AtomicUsize)> {
            match name.to_str().ok()? {
                $(stringify!($name) => Some(($name::hook as *const c_void, &$name::REAL)),)*
                _ => None,
            }
        }
    };
}

static CALLS: AtomicUsize = AtomicUsize::new(0);

counted! {
    vkQueueSubmit vkQueueSubmit2 vkQueueWaitIdle vkDeviceWaitIdle vkGetDeviceQueue vkGetDeviceQueue2
    vkWaitForFences vkWaitSemaphores vkCreateFence vkCreateSemaphore vkGetSemaphoreCounterValue
    vkAllocateMemory vkFreeMemory vkMapMemory vkCreateBuffer vkCreateBufferView vkCreateImage vkCreateImageView
    vkCreateSampler vkCreateShaderModule vkCreateComputePipelines vkCreateGraphicsPipelines vkCreatePipelineLayout
    vkCreateDescriptorSetLayout vkCreateDescriptorPool vkAllocateDescriptorSets vkUpdateDescriptorSets
    vkCreateQueryPool vkCreateCommandPool vkAllocateCommandBuffers vkBeginCommandBuffer vkEndCommandBuffer
    vkResetCommandPool vkDestroyBuffer vkDestroyImage vkDestroyDevice
}

#[test]
fn a_frame_records_and_does_nothing_else() {
    let entry = common::hooks::entry(hook_of);
    let host = Host::new(entry, &requirements(Preset::Fast), true, wanted().as_deref());
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(host.lent(), &requirements(Preset::Fast)) };
    let device = device.expect("a device");
    let mut scene = scene(Preset::Fast);
    let before_set_up = CALLS.load(SeqCst);
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    // The control: set-up makes many.
    assert!(CALLS.load(SeqCst) - before_set_up > 100, "{}", CALLS.load(SeqCst) - before_set_up);
    let fences = [host.fence(), host.fence()];
    for number in 0..6 {
        let slot = number % 2;
        scene.time += 0.01;
        scene.camera.target.x += 0.1;
        let (commands, output) = (embedded.commands[slot], embedded.output());
        if number > 1 {
            host.wait(fences[slot]);
        }
        let before = CALLS.load(SeqCst);
        // SAFETY: the slot's fence was signalled, or it was never recorded.
        let report = unsafe { embedded.view.retired(slot) }.expect("a report");
        assert_eq!(CALLS.load(SeqCst), before, "frame {number} retired");
        assert_eq!(report.is_some(), number > 1);
        host.begin(commands);
        let before = CALLS.load(SeqCst);
        let input = FrameInput::new(&scene, output);
        // SAFETY: the image is as described; the frames are submitted in order.
        unsafe { embedded.view.record(commands, slot, &input) }.expect("a recording");
        assert_eq!(CALLS.load(SeqCst), before, "frame {number}");
        host.end(commands);
        host.submit(commands, fences[slot]);
    }
    for fence in fences {
        host.wait(fence);
        host.destroy_fence(fence);
    }
    // Slots that have not retired keep what they use, and dropping waits for nothing.
    let waits = [&vkDeviceWaitIdle::REAL, &vkDestroyDevice::REAL].map(|real| real.load(SeqCst));
    assert!(waits.iter().all(|real| *real != 0));
    host.destroy_image(embedded.target);
    drop(embedded.view);
    drop(device);
    host.once(|_| ());
    assert_eq!(host.messages(), Vec::<String>::new());
}
