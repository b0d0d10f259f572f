//! What a host's images may be: a depth by any convention and with any content, a picture in any format.

use std::sync::Arc;

use ash::vk;
use glam::Vec3;
use half::f16;
use raindrops::device::{Device, HostImage, ImageState};
use raindrops::picture::srgb_of_linear;
use raindrops::renderer::{DepthConvention, FrameInput, ViewInfo};
use raindrops::scene::Scene;
use raindrops::scene::background::DepthKind;
use raindrops::scene::model::Preset;

use crate::embedded::{Embedded, SIZE, on_host, scene};
use crate::host::Host;
use crate::motion_depth::Filled;

const PIXELS: usize = (SIZE.0 * SIZE.1) as usize;

/// A frame into an image of `format`, behind a depth if there is one; its bytes.
fn drawn(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    (format, texel): (vk::Format, u64),
    depth: Option<(HostImage, DepthConvention)>,
) -> Vec<u8> {
    let info = ViewInfo { format, has_depth: depth.is_some(), ..ViewInfo::default() };
    let mut embedded = Embedded::new(host, device, scene, &info);
    let mut input = FrameInput::new(scene, embedded.output());
    if let Some((image, convention)) = depth {
        input = input.hidden_by(image, convention);
    }
    embedded.draw(host, 0, &input);
    let bytes = host.read(&embedded.target, texel * PIXELS as u64);
    drop(embedded.view);
    host.destroy_image(embedded.target);
    bytes
}

fn as_light(bytes: &[u8]) -> Vec<Vec3> {
    let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(bytes);
    texels.iter().map(|texel| Vec3::from_slice(texel)).collect()
}

const LIGHT: (vk::Format, u64) = (vk::Format::R32G32B32A32_SFLOAT, 16);

/// A negative colour and NaN behind the drops are black.
#[test]
fn a_colour_that_is_no_light_is_black() {
    let scene = scene(Preset::Fast);
    on_host(Preset::Fast, |host, device| {
        let before = |texel: [f32; 4]| {
            let image = Filled::new(host, vk::Format::R32G32B32A32_SFLOAT, &texel);
            let color = HostImage { exit: ImageState::SAMPLED, ..image.image() };
            let info = ViewInfo { format: LIGHT.0, has_color: true, ..ViewInfo::default() };
            let mut embedded = Embedded::new(host, device, &scene, &info);
            let input = FrameInput::new(&scene, embedded.output()).before(color, 1.0);
            embedded.draw(host, 0, &input);
            let light = as_light(&host.read(&embedded.target, LIGHT.1 * PIXELS as u64));
            drop(embedded.view);
            host.destroy_image(embedded.target);
            host.destroy_image(image.0);
            light
        };
        let expected = before([0.0, 0.0, 0.5, 1.0]);
        assert!(expected.iter().any(|light| *light != Vec3::new(0.0, 0.0, 0.5)), "no drop shows");
        for [red, green] in [[f32::NAN, -3.0], [-1e-6, f32::NEG_INFINITY], [-0.0, -0.4]] {
            assert!(before([red, green, 0.5, 1.0]) == expected, "{red}, {green}");
        }
    });
}

/// A slanted wall through the drops, as five kinds of depth tell it.
#[test]
fn a_depth_hides_alike_by_every_convention() {
    let scene = scene(Preset::Fast);
    let view = scene.view();
    let (near, far) = (0.5, 400.0);
    let wall = |at: usize| 6.0 + 0.5 * (at as u32 % SIZE.0) as f32;
    let length = |at: usize| {
        let (x, y) = (at as u32 % SIZE.0, at as u32 / SIZE.0);
        let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (1.0 / -ray.normalize().dot(view.back)) as f32
    };
    let scale = far / (near - far);
    type Stored<'a> = Box<dyn Fn(usize) -> f32 + 'a>;
    let kinds: [(DepthConvention, Stored); 5] = [
        (DepthConvention::linear(1.0, DepthKind::Planar), Box::new(wall)),
        (DepthConvention::linear(2.0, DepthKind::Planar), Box::new(|at| 0.5 * wall(at))),
        (DepthConvention::linear(1.0, DepthKind::Radial), Box::new(|at| wall(at) * length(at))),
        (DepthConvention::projected(0.0, near), Box::new(|at| near / wall(at))),
        (
            DepthConvention::projected(scale, scale * near),
            Box::new(|at| (scale * near - scale * wall(at)) / wall(at)),
        ),
    ];
    on_host(Preset::Fast, |host, device| {
        let without = as_light(&drawn(host, device, &scene, LIGHT, None));
        let differ = |a: &[Vec3], b: &[Vec3]| {
            a.iter().zip(b).filter(|(a, b)| (**a - **b).abs().max_element() > 0.01).count()
        };
        let mut first = None;
        for (convention, stored) in kinds {
            let image = Filled::new(host, vk::Format::R32_SFLOAT, &[0.0]);
            let depths: Vec<f32> = (0..PIXELS).map(stored).collect();
            host.write(&image.0, bytemuck::cast_slice(&depths));
            let depth = HostImage {
                exit: ImageState::SAMPLED,
                entry: ImageState::SAMPLED,
                ..image.image()
            };
            let picture = as_light(&drawn(host, device, &scene, LIGHT, Some((depth, convention))));
            host.destroy_image(image.0);
            let first = first.get_or_insert_with(|| picture.clone());
            let (off, hidden) = (differ(&picture, first), differ(&picture, &without));
            println!("{convention:?}: {off} pixels off, {hidden} hidden");
            assert!(off < PIXELS / 200, "{convention:?}: {off} pixels are others");
            assert!(hidden > PIXELS / 10, "{convention:?} hides {hidden} pixels");
        }
    });
}

/// Fills a depth image that nothing has used, and leaves it as it is said to come.
fn fill(host: &Host, commands: vk::CommandBuffer, image: &HostImage, depth: f32) {
    let change = |before: ImageState, after: ImageState| {
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(before.stages)
            .src_access_mask(before.access)
            .dst_stage_mask(after.stages)
            .dst_access_mask(after.access)
            .old_layout(before.layout)
            .new_layout(after.layout)
            .image(image.image)
            .subresource_range(image.range)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
        // SAFETY: the image is the host's, and the commands are outside of any rendering.
        unsafe { host.device.cmd_pipeline_barrier2(commands, &info) };
    };
    let target = ImageState::COPY_TARGET;
    change(ImageState::UNDEFINED, target);
    let value = vk::ClearDepthStencilValue { depth, stencil: 7 };
    let (layout, ranges) = (target.layout, [image.range]);
    // SAFETY: likewise, and the image is in that layout.
    unsafe {
        host.device.cmd_clear_depth_stencil_image(commands, image.image, layout, &value, &ranges);
    }
    change(target, image.entry);
}

/// Most drops are behind a wall at 12, in whichever format it is.
#[test]
fn a_depth_with_stencil_hides_as_one_without() {
    use vk::ImageUsageFlags as Usage;
    let scene = scene(Preset::Fast);
    let usage = Usage::DEPTH_STENCIL_ATTACHMENT | Usage::SAMPLED | Usage::TRANSFER_DST;
    on_host(Preset::Fast, |host, device| {
        let without = as_light(&drawn(host, device, &scene, LIGHT, None));
        let hidden = [vk::Format::D32_SFLOAT, vk::Format::D32_SFLOAT_S8_UINT].map(|format| {
            let texture = host.image(format, SIZE, 1, usage);
            let image = HostImage::depth(texture.image, texture.view, format, SIZE);
            host.once(|commands| fill(host, commands, &image, 0.1 / 12.0));
            let depth = (image, DepthConvention::projected(0.0, 0.1));
            let picture = as_light(&drawn(host, device, &scene, LIGHT, Some(depth)));
            host.destroy_image(texture);
            picture
        });
        assert!(hidden[0] != without, "nothing is hidden");
        assert!(hidden[0] == hidden[1], "a stencil beside it changes the picture");
    });
}

/// Where the stored number is not finite nothing is; a distance of 0 or less hides every drop.
#[test]
fn a_depth_that_is_no_distance_does_no_harm() {
    let scene = scene(Preset::Fast);
    let kinds = [
        DepthConvention::linear(1.0, DepthKind::Planar),
        DepthConvention::linear(1.0, DepthKind::Radial),
        DepthConvention::projected(0.0, 0.1),
    ];
    on_host(Preset::Fast, |host, device| {
        let without = as_light(&drawn(host, device, &scene, LIGHT, None));
        let empty = Scene { rain: None, drops: Vec::new(), ..scene.clone() };
        let sky = as_light(&drawn(host, device, &empty, LIGHT, None));
        assert!(sky != without);
        for convention in kinds {
            let is_projected = convention == kinds[2];
            for (stored, hides) in [
                (f32::NAN, false),
                (f32::INFINITY, false),
                (f32::NEG_INFINITY, false),
                (-400.0, !is_projected),
                (0.0, !is_projected),
            ] {
                let image = Filled::new(host, vk::Format::R32_SFLOAT, &[stored]);
                let depth = HostImage {
                    exit: ImageState::SAMPLED,
                    entry: ImageState::SAMPLED,
                    ..image.image()
                };
                let bytes = drawn(host, device, &scene, LIGHT, Some((depth, convention)));
                host.destroy_image(image.0);
                let expected = if hides { &sky } else { &without };
                let found = as_light(&bytes);
                let differ = found.iter().zip(expected).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "{convention:?}: {stored}");
            }
        }
    });
}

/// A colour as a format holds it: in 0 to 1 and by so many steps, or as floats of so many bits of fraction.
fn unpacked(format: vk::Format, texel: &[u8]) -> Vec3 {
    let word = || u32::from_le_bytes([texel[0], texel[1], texel[2], texel[3]]);
    let tens = |word: u32| [0, 10, 20].map(|shift| (word >> shift & 1023) as f32 / 1023.0);
    let bytes = || [texel[0], texel[1], texel[2]].map(|byte| f32::from(byte) / 255.0);
    let [a, b, c] = match format {
        vk::Format::A2B10G10R10_UNORM_PACK32 => tens(word()),
        vk::Format::A2R10G10B10_UNORM_PACK32 => tens(word()),
        // The upper bits of a float16 without its sign.
        vk::Format::B10G11R11_UFLOAT_PACK32 => [(0, 4, 2047), (11, 4, 2047), (22, 5, 1023)]
            .map(|(at, up, mask)| f16::from_bits(((word() >> at & mask) << up) as u16).to_f32()),
        vk::Format::R16G16B16A16_UNORM => {
            [0, 2, 4].map(|at| f32::from(u16::from_le_bytes([texel[at], texel[at + 1]])) / 65535.0)
        }
        vk::Format::R16G16B16A16_SFLOAT => {
            [0, 2, 4].map(|at| f16::from_le_bytes([texel[at], texel[at + 1]]).to_f32())
        }
        _ => bytes(),
    };
    let is_swapped = [
        vk::Format::A2R10G10B10_UNORM_PACK32,
        vk::Format::B8G8R8A8_UNORM,
        vk::Format::B8G8R8A8_SRGB,
    ];
    if is_swapped.contains(&format) { Vec3::new(c, b, a) } else { Vec3::new(a, b, c) }
}

#[test]
fn every_format_holds_the_picture() {
    use vk::Format as F;
    let scene = scene(Preset::Fast);
    on_host(Preset::Fast, |host, device| {
        let light = as_light(&drawn(host, device, &scene, LIGHT, None));
        let reds: f32 = light.iter().map(|light| light.x - light.z).sum();
        assert!(reds.abs() > 10.0, "channels that are swapped would not show");
        for (format, bytes, part) in [
            (F::R16G16B16A16_SFLOAT, 8, 1e-3),
            (F::B10G11R11_UFLOAT_PACK32, 4, 0.04),
            (F::A2B10G10R10_UNORM_PACK32, 4, 1.0 / 1023.0),
            (F::A2R10G10B10_UNORM_PACK32, 4, 1.0 / 1023.0),
            (F::R16G16B16A16_UNORM, 8, 1.0 / 65535.0),
            (F::R8G8B8A8_UNORM, 4, 1.0 / 255.0),
            (F::B8G8R8A8_UNORM, 4, 1.0 / 255.0),
            (F::R8G8B8A8_SRGB, 4, 1.5 / 255.0),
            (F::B8G8R8A8_SRGB, 4, 1.5 / 255.0),
        ] {
            let is_float = [F::R16G16B16A16_SFLOAT, F::B10G11R11_UFLOAT_PACK32].contains(&format);
            let is_srgb = [F::R8G8B8A8_SRGB, F::B8G8R8A8_SRGB].contains(&format);
            let picture = drawn(host, device, &scene, (format, bytes), None);
            for (texel, light) in picture.chunks(bytes as usize).zip(&light) {
                let found = unpacked(format, texel);
                let shown = light.clamp(Vec3::ZERO, Vec3::ONE);
                let expected = match (is_float, is_srgb) {
                    (true, _) => *light,
                    (_, true) => shown.to_array().map(srgb_of_linear).into(),
                    _ => shown,
                };
                let allowed = if is_float { part * (expected + 1e-3) } else { Vec3::splat(part) };
                assert!(
                    (found - expected).abs().cmple(allowed).all(),
                    "{format:?}: {found}, not {expected}"
                );
            }
        }
    });
}
