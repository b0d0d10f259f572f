//! Rain inside a frame of your own: the renderer's picture is an image on the device, which your own
//! commands may read. Here they shrink it into the middle of a grey image, as a mirror or a window
//! of a larger scene would.
//!
//! Its image, buffer and commands come from `raindrops::gpu` and `raindrops::passes`. These are this package's own
//! tools: they are hidden and may change with any version. In your program make them with ash, as
//! `examples/host_ash` does, which needs the public interface alone. There the rain is drawn into your image by
//! `renderer::View`, within your own commands (`docs/embedding.md`).
//!
//! `cargo run --release --example your_frame` writes `your_frame.png`.

use std::path::Path;

use ash::vk;
use raindrops::environment::Environment;
use raindrops::gpu::{
    Buffer, Commands, Device, Image, ImageInfo, Instance, Use, Validation, copy_to_buffer,
    image_barrier, image_discard, memory_barrier,
};
use raindrops::passes::tone_map::DISPLAY;
use raindrops::picture::write_png;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::{ImageSize, Scene};

const SIZE: u32 = 512;

fn main() -> raindrops::Result<()> {
    let image = ImageSize { width: SIZE, height: SIZE };
    let scene = Scene { image, ..Scene::default() };
    let environment = Environment::open(&scene.environment)?;
    let instance = Instance::new(Validation::Off)?;
    let device = &Device::open(&instance, instance.choose(None)?)?;
    let plan = plan(&scene, &environment, Output::Display)?;
    let mut renderer = Renderer::new(device, &scene, &environment, &plan)?;

    // Your own target, and a buffer to look at it with the CPU.
    let usage = vk::ImageUsageFlags::TRANSFER_DST
        | vk::ImageUsageFlags::TRANSFER_SRC
        | vk::ImageUsageFlags::SAMPLED;
    let target = Image::new(device, &ImageInfo::flat("yours", [SIZE; 2], DISPLAY, usage))?;
    let count = (SIZE * SIZE) as usize;
    let read = Buffer::readback(device, "yours, read", 4 * count as u64)?;

    // The rain's frame is on its way to the queue; what is submitted after it comes after it.
    renderer.submit(&scene)?;
    let rain = renderer.display().expect("the plan was for a display output");
    let layers = vk::ImageSubresourceLayers::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .layer_count(1);
    let corner = |x: u32, y: u32| vk::Offset3D { x: x as i32, y: y as i32, z: 1 };
    let origin = vk::Offset3D::default();
    let region = [vk::ImageBlit {
        src_subresource: layers,
        src_offsets: [origin, corner(SIZE, SIZE)],
        dst_subresource: layers,
        dst_offsets: [
            vk::Offset3D { z: 0, ..corner(SIZE / 4, SIZE / 4) },
            corner(3 * SIZE / 4, 3 * SIZE / 4),
        ],
    }];
    Commands::once(device, "yours", |commands| {
        let (from, to) = (Use::TransferRead, Use::TransferWrite);
        image_discard(device, commands, &target, &[Use::Nothing], to);
        // It is handed over as a colour attachment, and wants to be handed back as one.
        image_barrier(device, commands, rain, Use::ColorAttachment, from);
        let grey = vk::ClearColorValue { float32: [0.2, 0.2, 0.2, 1.0] };
        let whole = [vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(1)];
        let (source, destination) =
            (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        // SAFETY: both images are in these layouts, and the regions lie within them.
        unsafe {
            device.raw().cmd_clear_color_image(
                commands.raw(),
                target.raw(),
                destination,
                &grey,
                &whole,
            );
            image_barrier(device, commands, &target, to, to);
            device.raw().cmd_blit_image(
                commands.raw(),
                rain.raw(),
                source,
                target.raw(),
                destination,
                &region,
                vk::Filter::LINEAR,
            );
        }
        image_barrier(device, commands, rain, from, Use::ColorAttachment);
        image_barrier(device, commands, &target, to, from);
        copy_to_buffer(device, commands, (&target, 0), (&read, 0));
        memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
    })?;
    let pixels: Vec<[u8; 4]> = read.read(count);
    let srgb: Vec<u8> = pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    write_png(Path::new("your_frame.png"), SIZE, SIZE, &srgb)
}
