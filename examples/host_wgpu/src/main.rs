//! Rain in a frame of wgpu's: the scene of `examples/host_ash`, drawn by wgpu, with rain recorded into a command encoder of
//! wgpu's through its Vulkan hooks.
//!
//! `cargo run` in this folder writes `host_wgpu.png` and fails on any message of the validation layer. `RAINDROPS_DEVICE`:
//! a part of a device's name.

mod gpu;

use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

use glam::{DMat4, DVec3, DVec4, Vec3};
use half::f16;
use raindrops::ash::vk;
use raindrops::device::{HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::picture::{srgb_byte, write_png};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{FrameInput, Lighting, RainField, View, ViewInfo};
use raindrops::scene::camera::Camera;
use raindrops::scene::matrices::ClipSpace;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};
use wgpu::hal::api::Vulkan;

const SIZE: (u32, u32) = (480, 270);
const FRAMES: usize = 4;
const NEAR: f64 = 0.05;
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What wgpu and the validation layer say, which wgpu hands to `log`.
static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());
struct Listener;

impl log::Log for Listener {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }
    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            MESSAGES.lock().expect("no panic").push(record.args().to_string());
        }
    }
    fn flush(&self) {}
}

fn sky(d: DVec3) -> Vec3 {
    let sun = DVec3::new(0.5, 0.55, -0.67).normalize();
    let up = d.y.clamp(-1.0, 1.0) as f32;
    match up {
        _ if d.dot(sun) > 0.9997 => Vec3::splat(900.0),
        up if up < 0.0 => Vec3::new(0.16, 0.15, 0.13) * (1.0 + 0.5 * up),
        up => Vec3::new(0.85, 0.9, 1.0).lerp(Vec3::new(0.22, 0.42, 0.9), up.sqrt()),
    }
}

fn environment() -> Environment {
    use std::f64::consts::{PI, TAU};
    let texels = (0..512 * 256).map(|index| {
        let (column, row) = (f64::from(index % 512) + 0.5, f64::from(index / 512) + 0.5);
        let (azimuth, polar) = (TAU * (column / 512.0 - 0.5), PI * row / 256.0);
        sky(DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos()))
    });
    Environment::from_texels("the host's sky", 512, 256, texels.collect()).expect("an image")
}

fn rain() -> Scene {
    let (width, height) = SIZE;
    let mut scene = Scene { image: ImageSize { width, height }, ..Scene::default() };
    scene.model.preset = Preset::Fast;
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

/// The uniform buffer of `ground.wgsl` at a time.
fn frame(to_clip: DMat4, eye: DVec3, time: f64) -> Vec<f32> {
    let moving = Vec3::new((2.0 * (1.4 * time).sin()) as f32, 0.6, -3.2);
    let blocks = [
        (Vec3::new(0.0, -0.5, 0.0), Vec3::new(60.0, 0.5, 60.0), Vec3::new(0.5, 0.48, 0.44), 0.0),
        (Vec3::new(-1.6, 0.9, -4.5), Vec3::new(0.6, 0.9, 0.6), Vec3::new(0.75, 0.25, 0.18), 0.0),
        (Vec3::new(1.9, 0.5, -2.2), Vec3::splat(0.5), Vec3::new(0.2, 0.5, 0.3), 0.0),
        (moving, Vec3::splat(0.35), Vec3::new(0.9, 0.75, 0.2), 0.0),
        (eye.as_vec3(), Vec3::splat(10.0), Vec3::ZERO, 1.0),
    ];
    let mut values = to_clip.as_mat4().to_cols_array().to_vec();
    for (middle, half, color, is_sky) in blocks {
        for vector in [middle.extend(is_sky), half.extend(0.0), color.extend(1.0)] {
            values.extend(vector.to_array());
        }
    }
    values
}

/// wgpu's clip space has its upper edge at y = 1; depth is reversed and infinite.
fn matrices(eye: DVec3, target: DVec3) -> (DMat4, DMat4) {
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let to_world = glam::DMat3::from_cols(right, right.cross(forward), -forward);
    let view = DMat4::from_mat3(to_world.transpose()) * DMat4::from_translation(-eye);
    let focal = 1.0 / 30.0_f64.to_radians().tan();
    let projection = DMat4::from_cols(
        DVec4::new(focal * f64::from(SIZE.1) / f64::from(SIZE.0), 0.0, 0.0, 0.0),
        DVec4::new(0.0, focal, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 0.0, -1.0),
        DVec4::new(0.0, 0.0, NEAR, 0.0),
    );
    (view, projection)
}

fn texture(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// A texture of wgpu's in the state that `transition_resources` has brought it into, and is to be left in.
///
/// # Safety
/// That of `HostImage` in `View::record`.
unsafe fn lent(
    texture: &wgpu::Texture,
    view: &wgpu::TextureView,
    layout: vk::ImageLayout,
) -> HostImage {
    // SAFETY: the handles are used as long as wgpu keeps them.
    let (image, view) = unsafe {
        let image = texture.as_hal::<Vulkan>().expect("Vulkan").raw_handle();
        (image, view.as_hal::<Vulkan>().expect("Vulkan").raw_handle())
    };
    // wgpu's barriers order all stages that read or write in this state.
    let state = ImageState {
        layout,
        stages: vk::PipelineStageFlags2::ALL_COMMANDS,
        access: vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
    };
    let image = match texture.format() {
        DEPTH => HostImage::depth(image, view, vk::Format::D32_SFLOAT, SIZE),
        _ => HostImage::color(image, view, vk::Format::R16G16B16A16_SFLOAT, SIZE),
    };
    HostImage { entry: state, exit: state, ..image }
}

fn main() -> ExitCode {
    // Before anything of Vulkan is loaded, and before there are threads.
    // SAFETY: as said.
    unsafe {
        std::env::set_var(
            "VK_LAYER_ENABLES",
            "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT",
        );
    }
    log::set_logger(&Listener).expect("the first logger");
    log::set_max_level(log::LevelFilter::Warn);
    let wanted = std::env::var("RAINDROPS_DEVICE").ok();
    let picture = draw(&gpu::adapter(wanted.as_deref()));
    let messages = MESSAGES.lock().expect("no panic");
    println!("{} messages", messages.len());
    messages.iter().for_each(|message| println!("{message}"));

    let display = |pixel: &[f16]| {
        let light = Vec3::new(pixel[0].to_f32(), pixel[1].to_f32(), pixel[2].to_f32());
        (light / (1.0 + light)).to_array().map(srgb_byte)
    };
    let srgb: Vec<u8> = picture.chunks_exact(4).flat_map(display).collect();
    let written = write_png(Path::new("host_wgpu.png"), SIZE.0, SIZE.1, &srgb);
    if let Err(error) = &written {
        println!("{error}");
    }
    if messages.is_empty() && written.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn draw(adapter: &wgpu::Adapter) -> Vec<f16> {
    let required = requirements(Preset::Fast);
    let (device, queue) = gpu::open(adapter, &required);
    // SAFETY: opened with these requirements; it is idle at the end of this function, where the rain goes first.
    let shared = unsafe { gpu::lend(&device, &required) };

    use wgpu::TextureUsages as Usage;
    let color = texture(&device, COLOR, Usage::TEXTURE_BINDING);
    let depth = texture(&device, DEPTH, Usage::TEXTURE_BINDING);
    let output = texture(&device, COLOR, Usage::COPY_SRC);
    let [color_view, depth_view, output_view] =
        [&color, &depth, &output].map(|texture| texture.create_view(&Default::default()));
    let module = device.create_shader_module(wgpu::include_wgsl!("ground.wgsl"));
    let uniform = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 64 + 5 * 48,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
    });

    // Rain: set up once, on wgpu's queue.
    let mut scene = rain();
    let environment = environment();
    let plan = plan(&scene, &environment, Output::Radiance).expect("a plan");
    let lighting = Arc::new(Lighting::new(&shared, &environment).expect("light"));
    let field = Arc::new(RainField::new(&shared, &scene));
    let info = ViewInfo { has_color: true, has_depth: true, ..ViewInfo::default() };
    let mut view = View::new(&lighting, &field, &scene, &plan, &info).expect("a view");

    let wait = |submission| {
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        device.poll(poll).expect("the queue");
    };
    // wgpu clears what it has never seen written, when it is first read; it does not see what the rain writes.
    let mut first = device.create_command_encoder(&Default::default());
    drop(first.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &output_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        })],
        ..Default::default()
    }));
    queue.submit([first.finish()]);

    let mut submissions: [Option<wgpu::SubmissionIndex>; 2] = [None, None];
    for number in 0..FRAMES {
        let slot = number % 2;
        if let Some(submission) = submissions[slot].take() {
            wait(submission);
            // SAFETY: the submission is done.
            unsafe { view.retired(slot) }.expect("a report");
        }
        let eye = DVec3::new(0.0, 1.2, 1.2);
        let (to_eye, projection) = matrices(eye, DVec3::new(0.0, 0.8, -3.0));
        let (camera, mapping) =
            Camera::from_matrices(to_eye, projection, SIZE, ClipSpace::YUp).expect("a camera");
        (scene.camera, scene.time) = (camera, number as f64 / 30.0);
        let values = frame(projection * to_eye, eye, scene.time);
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        queue.write_buffer(&uniform, 0, &bytes);

        let encoder = || device.create_command_encoder(&Default::default());
        let mut own = encoder();
        {
            let mut pass = own.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: None,
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color_view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_view,
                    // 0 is infinitely far.
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..36, 0..5);
        }
        // wgpu is told which states the rain expects, and so leaves the textures in.
        let mut states = encoder();
        let state = |texture, state| wgpu::TextureTransition { texture, selector: None, state };
        let textures = [
            state(&color, wgpu::TextureUses::RESOURCE),
            state(&depth, wgpu::TextureUses::RESOURCE),
            state(&output, wgpu::TextureUses::COLOR_TARGET),
        ];
        states.transition_resources(std::iter::empty(), textures.into_iter());

        let mut raining = encoder();
        // SAFETY: the textures are in these layouts; frames are submitted in order, once each.
        unsafe {
            let color = lent(&color, &color_view, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
            let depth = lent(&depth, &depth_view, vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL);
            let output = lent(&output, &output_view, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
            let input =
                FrameInput::new(&scene, output).before(color, 1.0).hidden_by(depth, mapping.into());
            raining.as_hal_mut::<Vulkan, _, _>(|encoder| {
                let commands = encoder.expect("Vulkan").raw_handle();
                view.record(commands, slot, &input).expect("a recording");
            });
        }
        let all = [own, states, raining].map(wgpu::CommandEncoder::finish);
        submissions[slot] = Some(queue.submit(all));
    }

    // The last frame, for the CPU; rows are padded to 256 bytes.
    let row = (8 * SIZE.0).next_multiple_of(256);
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * SIZE.1),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut copy = device.create_command_encoder(&Default::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    copy.copy_texture_to_buffer(
        output.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &read, layout },
        output.size(),
    );
    wait(queue.submit([copy.finish()]));
    for slot in 0..2 {
        // SAFETY: all submissions are done.
        let report = unsafe { view.retired(slot) }.expect("a report");
        if let Some(report) = report {
            let passes: Vec<_> = report.passes_ms.iter().map(|(name, _)| *name).collect();
            println!("{} drops in view; recorded: {}", report.counts.visible, passes.join(", "));
        }
    }
    read.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("a mapping"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the queue");
    let bytes = read.get_mapped_range(..).expect("a mapping");
    let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]);
    let rows = bytes.chunks_exact(row as usize);
    rows.flat_map(|row| row[..8 * SIZE.0 as usize].chunks_exact(2).map(half)).collect()
}
