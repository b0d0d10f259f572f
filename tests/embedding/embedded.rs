//! Rain on a device of a host that is not ours, the one of `examples/host_ash`, as the tests draw it.

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};
use half::f16;
use raindrops::device::{Device, HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{FrameInput, FrameReport, Lighting, RainField, Renderer, View, ViewInfo};
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, Scene};

use crate::common;
use crate::common::layer::{alone, beside};
use crate::host::{Host, Texture};

pub const SIZE: (u32, u32) = (96, 64);

pub fn scene(preset: Preset) -> Scene {
    let mut scene = Scene::default();
    scene.model.preset = preset;
    scene.model.mask_size = 64;
    scene.image = ImageSize { width: SIZE.0, height: SIZE.1 };
    scene.rain.get_or_insert_default().count = 20_000;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.2, 0.1, -5.0), 1.0)];
    scene
}

/// A sky with a sun.
pub fn environment() -> Environment {
    let sun = DVec3::new(0.3, 0.4, -1.0).normalize();
    common::painted(256, move |d| {
        let sky = Vec3::new(0.4, 0.6, 1.0) * (0.6 + 0.4 * d.y as f32);
        if d.dot(sun) > 0.9998 { Vec3::splat(3e3) } else { sky }
    })
}

pub fn wanted() -> Option<String> {
    std::env::var("RAINDROPS_TEST_DEVICE").ok()
}

/// For whoever is [`alone`].
pub fn host(preset: Preset) -> Host {
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.expect("Vulkan");
    Host::new(entry, &requirements(preset), true, wanted().as_deref())
}

/// Rain on a host's device, and an image to draw it into.
pub struct Embedded {
    pub view: View,
    pub target: Texture,
    pub commands: Vec<vk::CommandBuffer>,
}

pub fn view_of(device: &Arc<Device>, scene: &Scene, info: &ViewInfo) -> raindrops::Result<View> {
    view_for(device, scene, Output::Radiance, info)
}

pub fn view_for(
    device: &Arc<Device>,
    scene: &Scene,
    output: Output,
    info: &ViewInfo,
) -> raindrops::Result<View> {
    let environment = environment();
    let plan = plan(scene, &environment, output)?;
    let lighting = Arc::new(Lighting::new(device, &environment)?);
    View::new(&lighting, &Arc::new(RainField::new(device, scene)), scene, &plan, info)
}

impl Embedded {
    pub fn new(host: &Host, device: &Arc<Device>, scene: &Scene, info: &ViewInfo) -> Self {
        let view = view_of(device, scene, info).expect("a view");
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let target = host.image(info.format, SIZE, 1, usage);
        let commands = (0..info.frames_in_flight).map(|_| host.commands()).collect();
        Self { view, target, commands }
    }

    /// The target, which comes without content and goes as a source of copies.
    pub fn output(&self) -> HostImage {
        let target = &self.target;
        HostImage {
            entry: ImageState { stages: vk::PipelineStageFlags2::COPY, ..ImageState::UNDEFINED },
            exit: ImageState::COPY_SOURCE,
            ..HostImage::color(target.image, target.view, target.format, target.size)
        }
    }

    /// Records a frame into a slot's command buffer.
    pub fn record(&mut self, host: &Host, slot: usize, scene: &Scene) {
        let (commands, output) = (self.commands[slot], self.output());
        host.begin(commands);
        // SAFETY: the image is as it is described; the frames are submitted in order, or never.
        let recorded = unsafe { self.view.record(commands, slot, &FrameInput::new(scene, output)) };
        recorded.expect("a recording");
        host.end(commands);
    }

    /// A frame that is submitted and waited for.
    pub fn frame(
        &mut self,
        host: &Host,
        slot: usize,
        scene: &Scene,
    ) -> (Vec<[f16; 4]>, FrameReport) {
        self.record(host, slot, scene);
        self.finish(host, slot)
    }

    /// Submits what was recorded into a slot, and waits for it.
    pub fn finish(&mut self, host: &Host, slot: usize) -> (Vec<[f16; 4]>, FrameReport) {
        host.run(self.commands[slot]);
        (self.read(host), self.executed(slot))
    }

    /// The report of a slot's frame, which was executed.
    fn executed(&mut self, slot: usize) -> FrameReport {
        // SAFETY: it was waited for.
        unsafe { self.view.retired(slot) }.expect("a report").expect("it was executed")
    }

    /// Records a frame of an input, submits it and waits for it.
    pub fn draw(&mut self, host: &Host, slot: usize, input: &FrameInput<'_>) -> FrameReport {
        host.once(|commands| {
            // SAFETY: images and buffers are as they are described; it is submitted once, after the frames before it.
            unsafe { self.view.record(commands, slot, input) }.expect("a recording");
        });
        self.executed(slot)
    }

    pub fn read(&self, host: &Host) -> Vec<[f16; 4]> {
        let bytes = host.read(&self.target, 8 * u64::from(SIZE.0 * SIZE.1));
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

/// Asserts that something is refused, in one line that has these words.
#[track_caller]
pub fn says<T>(result: raindrops::Result<T>, words: &str) {
    let line = result.map(drop).expect_err("a refusal").to_string();
    println!("{line}");
    assert!(line.contains(words) && !line.contains('\n'), "'{line}' says not '{words}'");
}

/// Runs a test on a host of its own, and fails if the layer says anything.
pub fn on_host(preset: Preset, test: impl FnOnce(&Host, &Arc<Device>)) {
    let host = {
        let _alone = alone();
        host(preset)
    };
    {
        let _beside = beside();
        // SAFETY: the host outlives all that is made on its device, and is idle then.
        let device =
            unsafe { Device::import(host.lent(), &requirements(preset)) }.expect("a device");
        // SAFETY: the compiler made them; a fault that is put in changes no interface.
        unsafe { device.replace_shaders(common::replaced_shaders()) };
        test(&host, &device);
        assert_eq!(Arc::strong_count(&device), 1, "something outlives its test");
        drop(device);
        // The device is still there.
        host.once(|_| ());
        assert_eq!(host.messages(), Vec::<String>::new());
    }
    let _alone = alone();
    drop(host);
}

/// The pictures of `render`, as the host's format holds them.
pub fn rendered(scenes: &[Scene]) -> Vec<Vec<[f16; 4]>> {
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
pub fn film(preset: Preset) -> Vec<Scene> {
    let aims = [0.0, 0.0, 0.4, 0.4, 0.4, 0.0];
    let frames = aims.iter().enumerate().map(|(number, aim)| {
        let mut scene = scene(preset);
        scene.camera.target.x += aim;
        scene.time = 0.02 * number as f64;
        scene
    });
    frames.collect()
}
