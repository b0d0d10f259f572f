//! The frames of the example: the host draws its scene, then rain is recorded into the same command buffer.

#![allow(dead_code, reason = "the example and a test use a part of this each")]

use std::sync::Arc;

use ash::vk;
use glam::DVec3;
use half::f16;
use raindrops::device::{Device, HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    DepthConvention, FrameInput, FrameReport, HostEnvironment, HostMotion, Lighting, LiveInfo,
    RainField, View, ViewInfo,
};
use raindrops::scene::camera::Camera;
use raindrops::scene::matrices::ClipSpace;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

use super::fountain::Fountain;
use super::ground::{self, Ground};
use super::host::{Host, Texture};

/// What the last frame looks like, and what was said of it.
pub struct Outcome {
    /// With rain, and the host's own picture and depth without.
    pub picture: Vec<[f16; 4]>,
    pub color: Vec<[f16; 4]>,
    pub depth: Vec<f32>,
    /// How far each pixel's nearest drop has moved since the frame before, in pixels back to there, and its depth; 0 where none is.
    pub motion: Vec<[f16; 2]>,
    pub nearest: Vec<f32>,
    /// The drops of the host's own, as its buffer has them.
    pub particles: Vec<u8>,
    /// The rain's scene of that frame.
    pub scene: Scene,
    pub projected: DepthConvention,
    pub environment: Environment,
    pub report: FrameReport,
    pub messages: Vec<String>,
}

/// The host's sky, as the drops show it.
pub fn environment() -> Environment {
    use std::f64::consts::{PI, TAU};
    const HEIGHT: u32 = 256;
    let texels = (0..2 * HEIGHT * HEIGHT).map(|index| {
        let (column, row) =
            (f64::from(index % (2 * HEIGHT)) + 0.5, f64::from(index / (2 * HEIGHT)) + 0.5);
        let (azimuth, polar) =
            (TAU * (column / f64::from(2 * HEIGHT) - 0.5), PI * row / f64::from(HEIGHT));
        ground::sky(DVec3::new(
            polar.sin() * azimuth.sin(),
            polar.cos(),
            -polar.sin() * azimuth.cos(),
        ))
    });
    Environment::from_texels("the host's sky", 2 * HEIGHT, HEIGHT, texels.collect())
        .expect("an image")
}

/// No rain yet, for pictures of a size.
fn dry((width, height): (u32, u32)) -> Scene {
    let mut scene = Scene { image: ImageSize { width, height }, ..Scene::default() };
    scene.model.preset = Preset::Fast;
    scene
}

/// Real rain, in millimetres an hour, in an instant.
pub fn real_rain(size: (u32, u32), rate: f64) -> Scene {
    let rain = RainSettings::of(RealRain { rate, ..RealRain::default() });
    Scene { rain: Some(rain), ..dry(size) }
}

/// Rain for effect: large drops in a box around the camera that moves with it, and two that hang in the air.
pub fn large_drops(size: (u32, u32)) -> Scene {
    let mut scene = dry(size);
    scene.rain = Some(RainSettings {
        count: 9000,
        half_extent: DVec3::new(5.0, 3.0, 5.0),
        radius: 0.016,
        velocity: DVec3::new(0.4, -3.0, 0.0),
        ..RainSettings::default()
    });
    let hanging = [(DVec3::new(-0.62, 1.0, -0.9), 0.16), (DVec3::new(0.55, 0.9, -2.9), 0.2)];
    scene.drops = hanging.map(|(center, radius)| PlacedDrop::sphere(center, radius)).into();
    scene
}

/// No rain, but a fountain of so many drops.
pub fn fountain(size: (u32, u32), drops: u32) -> Scene {
    Scene { rain: None, host_particles: drops, ..dry(size) }
}

/// What the drops show.
#[derive(Clone, Copy, PartialEq)]
pub enum Around {
    /// The sky, computed once.
    Painted,
    /// The sky, drawn into a cube map with every frame.
    Sky,
    /// Sky, ground and boxes, drawn into a cube map with every frame.
    Scene,
}

/// The cube map that the host draws around a point in the rain.
struct Cube {
    color: Texture,
    depth: Texture,
}

impl Cube {
    const EDGE: u32 = 128;

    fn new(host: &Host) -> Self {
        use vk::ImageUsageFlags as Usage;
        let size = (Self::EDGE, Self::EDGE);
        let usage = Usage::COLOR_ATTACHMENT | Usage::SAMPLED;
        let color = host.image(ground::COLOR, size, 6, usage);
        let depth = host.image(ground::DEPTH, size, 1, Usage::DEPTH_STENCIL_ATTACHMENT);
        Self { color, depth }
    }

    /// Draws all faces, and says how the image is left.
    fn draw(
        &self,
        host: &Host,
        commands: vk::CommandBuffer,
        ground: &Ground,
        middle: DVec3,
        blocks: &[ground::Block],
    ) -> HostEnvironment {
        let (color, depth) = (&self.color, &self.depth);
        let before = ImageState { layout: vk::ImageLayout::UNDEFINED, ..ImageState::SAMPLED };
        ground::barrier(host, commands, color, [before, ImageState::COLOR_ATTACHMENT]);
        let used =
            ImageState { layout: vk::ImageLayout::UNDEFINED, ..ImageState::DEPTH_ATTACHMENT };
        for (face, view) in color.faces.iter().enumerate() {
            ground::barrier(host, commands, depth, [used, ImageState::DEPTH_ATTACHMENT]);
            let to_clip = ground::to_face(middle, face);
            ground.draw(host, commands, [*view, depth.view], color.size, (to_clip, middle), blocks);
        }
        let mut image = HostImage::color(color.image, color.view, color.format, color.size);
        image.range.layer_count = 6;
        image.exit = ImageState::SAMPLED;
        HostEnvironment::new(image)
    }
}

/// Draws so many frames of a scene's rain, with two in flight, and reads the last. `jitter`: whether the projection moves by parts of a
/// pixel, as for temporal anti-aliasing.
pub fn run(
    scene: Scene,
    frames: usize,
    jitter: bool,
    around: Around,
    wanted: Option<&str>,
) -> Outcome {
    // What the device must have is known before it is made.
    let required = requirements(Preset::Fast);
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.expect("Vulkan");
    let host = Host::new(entry, &required, true, wanted);
    // SAFETY: all that `lent` says is so, and the host is dropped after everything that is made from it.
    let device = unsafe { Device::import(host.lent(), &required) }.expect("the device");
    let outcome = draw(&host, &device, scene, frames, jitter, around);
    drop(device);
    let messages = host.messages();
    Outcome { messages, ..outcome }
}

/// The frames, on a device that was lent.
pub fn draw(
    host: &Host,
    device: &Arc<Device>,
    mut scene: Scene,
    frames: usize,
    jitter: bool,
    around: Around,
) -> Outcome {
    use vk::ImageUsageFlags as Usage;
    let size = (scene.image.width, scene.image.height);
    let (attached, read) = (Usage::COLOR_ATTACHMENT, Usage::SAMPLED | Usage::TRANSFER_SRC);
    let color = host.image(ground::COLOR, size, 1, attached | read);
    let depth = host.image(ground::DEPTH, size, 1, Usage::DEPTH_STENCIL_ATTACHMENT | read);
    let output = host.image(ground::COLOR, size, 1, attached | Usage::TRANSFER_SRC);
    // For a temporal upscaler.
    let told = attached | Usage::TRANSFER_DST | Usage::TRANSFER_SRC;
    let motion = host.image(vk::Format::R16G16_SFLOAT, size, 1, told);
    let nearest = host.image(vk::Format::R32_SFLOAT, size, 1, told);
    let ground = Ground::new(host);
    let count = scene.host_particles;
    let fountain = (count > 0).then(|| Fountain::new(host, count));

    // Set-up, once: the light, the drops, and a view of them for pictures of this size.
    let environment = environment();
    let plan = plan(&scene, &environment, Output::Radiance).expect("a plan");
    let cube = (around != Around::Painted).then(|| Cube::new(host));
    let lighting = match cube {
        None => Lighting::new(device, &environment),
        Some(_) => Lighting::live(device, LiveInfo::default()),
    };
    let lighting = Arc::new(lighting.expect("light"));
    let rain = Arc::new(RainField::new(device, &scene));
    let info = ViewInfo {
        has_color: true,
        has_depth: true,
        motion: Some(motion.format),
        nearest_depth: Some(nearest.format),
        ..ViewInfo::default()
    };
    let mut view = View::new(&lighting, &rain, &scene, &plan, &info).expect("a view");

    let slots = info.frames_in_flight;
    let commands: Vec<_> = (0..slots).map(|_| host.commands()).collect();
    let fences: Vec<_> = (0..slots).map(|_| host.fence()).collect();
    let mut projected = DepthConvention::projected(0.0, 0.0);
    let mut report = None;
    for number in 0..frames {
        let slot = number % slots;
        if number >= slots {
            host.wait(fences[slot]);
            // SAFETY: the slot's fence was signalled.
            unsafe { view.retired(slot) }.expect("a report");
        }

        // The host's camera: matrices, as it has them anyway.
        let time = number as f64 / 30.0;
        let eye = DVec3::new(0.0, 1.2, 1.2);
        let part = |base: usize| (number % base) as f64 / base as f64 - 0.5;
        let moved = if jitter { [part(2), part(3)] } else { [0.0; 2] };
        let to_eye = ground::view(eye, DVec3::new(0.0, 0.8, -3.0));
        let projection = ground::projection(60.0, size, moved);
        let (camera, mapping) =
            Camera::from_matrices(to_eye, projection, size, ClipSpace::YDown).expect("a camera");
        scene.camera = camera;
        scene.time = time;
        projected = mapping.into();

        let recorded = commands[slot];
        host.begin(recorded);
        // The host's own passes. The frame before has been copied from, or rather might have been.
        let before = ImageState { layout: vk::ImageLayout::UNDEFINED, ..ImageState::COPY_SOURCE };
        ground::barrier(host, recorded, &color, [before, ImageState::COLOR_ATTACHMENT]);
        ground::barrier(host, recorded, &depth, [before, ImageState::DEPTH_ATTACHMENT]);
        let views = [color.view, depth.view];
        let blocks = ground::blocks(time);
        ground.draw(host, recorded, views, size, (projection * to_eye, eye), &blocks);

        // The host's own vectors would stand here: a pixel without a drop keeps them.
        for image in [&motion, &nearest] {
            ground::clear(host, recorded, image, before, 0.0);
        }

        // Rain: each image with how it comes and how it is handed back.
        let handed_back = |image: HostImage| HostImage { exit: ImageState::COPY_SOURCE, ..image };
        let image = |make: fn(_, _, _, _) -> HostImage, texture: &Texture| {
            handed_back(make(texture.image, texture.view, texture.format, texture.size))
        };
        let target = HostImage { entry: before, ..image(HostImage::color, &output) };
        let input = FrameInput::new(&scene, target)
            .before(image(HostImage::color, &color), 1.0)
            .hidden_by(image(HostImage::depth, &depth), projected);
        // The camera stands still, and vectors are free of its jitter: they lead to the same camera.
        let [motion, nearest] = [&motion, &nearest].map(|told| HostImage {
            entry: ImageState::COPY_TARGET,
            ..image(HostImage::color, told)
        });
        let input =
            input.moved(HostMotion::since(camera, time - 1.0 / 30.0, motion)).nearest(nearest);
        let input = match &cube {
            None => input,
            Some(cube) => {
                let shown = if around == Around::Scene { &blocks[..] } else { &[] };
                input.around(cube.draw(host, recorded, &ground, DVec3::new(0.0, 1.0, -1.5), shown))
            }
        };
        let input = match &fountain {
            None => input,
            Some(fountain) => input.with_particles(fountain.record(host, recorded, time)),
        };
        // SAFETY: images and buffers are as described; frames are submitted in the order in which they are recorded.
        unsafe { view.record(recorded, slot, &input) }.expect("a recording");
        host.end(recorded);
        host.submit(recorded, fences[slot]);
    }
    for number in frames.saturating_sub(slots)..frames {
        let slot = number % slots;
        host.wait(fences[slot]);
        // SAFETY: the slot's fence was signalled.
        report = unsafe { view.retired(slot) }.expect("a report");
    }

    let pixels = u64::from(size.0) * u64::from(size.1);
    let outcome = Outcome {
        picture: bytemuck::pod_collect_to_vec(&host.read(&output, 8 * pixels)),
        color: bytemuck::pod_collect_to_vec(&host.read(&color, 8 * pixels)),
        depth: bytemuck::pod_collect_to_vec(&host.read(&depth, 4 * pixels)),
        motion: bytemuck::pod_collect_to_vec(&host.read(&motion, 4 * pixels)),
        nearest: bytemuck::pod_collect_to_vec(&host.read(&nearest, 4 * pixels)),
        particles: fountain.as_ref().map_or_else(Vec::new, Fountain::read),
        scene,
        projected,
        environment,
        report: report.expect("a frame"),
        messages: Vec::new(),
    };
    fences.into_iter().for_each(|fence| host.destroy_fence(fence));
    ground.destroy(host);
    fountain.into_iter().for_each(|fountain| fountain.destroy(host));
    let of_cube = cube.into_iter().flat_map(|cube| [cube.color, cube.depth]);
    [color, depth, output, motion, nearest]
        .into_iter()
        .chain(of_cube)
        .for_each(|texture| host.destroy_image(texture));
    outcome
}
