//! Motion since the frame before and depth of each pixel's nearest drop, in a host's images.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;
use half::f16;
use raindrops::device::{Device, HostImage, ImageState};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{FrameInput, HostMotion, Renderer, ViewInfo};
use raindrops::scene::camera::Camera;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common;
use crate::embedded::{Embedded, SIZE, environment, on_host, rendered, scene};
use crate::host::{Host, Texture};

/// What the host has in its images before.
const OWN_MOTION: [f32; 2] = [7.0, -9.0];
const OWN_DEPTH: f32 = 1e6;

/// A view that draws both.
pub fn asked() -> ViewInfo {
    let (motion, depth) = (vk::Format::R32G32_SFLOAT, vk::Format::R32_SFLOAT);
    ViewInfo { motion: Some(motion), nearest_depth: Some(depth), ..ViewInfo::default() }
}

/// An image of the host's that is filled, and left as a source of copies.
pub struct Filled(pub Texture);

impl Filled {
    pub fn new(host: &Host, format: vk::Format, texel: &[f32]) -> Self {
        use vk::ImageUsageFlags as Usage;
        let usage = Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let image = host.image(format, SIZE, 1, usage | Usage::SAMPLED);
        host.write(&image, bytemuck::cast_slice(&texel.repeat((SIZE.0 * SIZE.1) as usize)));
        Self(image)
    }

    pub fn image(&self) -> HostImage {
        let Texture { image, view, format, size, .. } = self.0;
        let (entry, exit) = (ImageState::SAMPLED, ImageState::COPY_SOURCE);
        HostImage { entry, exit, ..HostImage::color(image, view, format, size) }
    }
}

/// Motion and depth of a frame pixel by pixel, and its picture.
struct Drawn {
    motion: Vec<[f32; 2]>,
    depth: Vec<f32>,
    picture: Vec<[f16; 4]>,
}

fn drawn(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    (before, time): (Camera, f64),
    pixel: [f32; 2],
) -> Drawn {
    let info = asked();
    let mut embedded = Embedded::new(host, device, scene, &info);
    let motion = Filled::new(host, vk::Format::R32G32_SFLOAT, &OWN_MOTION);
    let depth = Filled::new(host, vk::Format::R32_SFLOAT, &[OWN_DEPTH]);
    let moved = HostMotion { pixel, ..HostMotion::since(before, time, motion.image()) };
    let input = FrameInput::new(scene, embedded.output()).moved(moved).nearest(depth.image());
    embedded.draw(host, 0, &input);
    let pixels = u64::from(SIZE.0 * SIZE.1);
    let drawn = Drawn {
        motion: bytemuck::pod_collect_to_vec(&host.read(&motion.0, 8 * pixels)),
        depth: bytemuck::pod_collect_to_vec(&host.read(&depth.0, 4 * pixels)),
        picture: embedded.read(host),
    };
    drop(embedded.view);
    let images = [embedded.target, motion.0, depth.0];
    images.into_iter().for_each(|image| host.destroy_image(image));
    drawn
}

/// A drop that goes five pixels to the right and three up, one at rest, and a camera that goes sideways.
#[test]
fn motion_leads_back_to_where_the_drop_was() {
    // At depth 10 a scene unit is 3.2 pixels.
    let mut scene = scene(Preset::Fast);
    (scene.rain, scene.time) = (None, 0.4);
    let velocity = DVec3::new(5.0, 3.0, 0.0) / 3.2 / 0.1;
    let goes =
        PlacedDrop { velocity, ..PlacedDrop::sphere(-velocity * 0.4 - 10.0 * DVec3::Z, 1.0) };
    let rests = PlacedDrop::sphere(DVec3::new(6.0, 0.0, -8.0), 1.0);
    scene.drops = vec![goes, rests];
    let aside = |x: f64| {
        let (position, target) = (DVec3::new(x, 0.0, 0.0), DVec3::new(x, 0.0, -1.0));
        Camera { position, target, ..scene.camera }
    };
    let at = |x: u32, y: u32| (y * SIZE.0 + x) as usize;
    // In the middle, and 6/8 of the focal length beside it.
    let (first, second, none) = (at(48, 32), at(48 + 24, 32), at(5, 5));
    on_host(Preset::Fast, |host, device| {
        for (before, pixel, expected) in [
            (aside(0.0), [1.0, 1.0], [[-5.0, 3.0], [0.0, 0.0]]),
            (aside(-1.0), [1.0, 1.0], [[-5.0 + 3.2, 3.0], [4.0, 0.0]]),
            (aside(0.0), [1.0 / 96.0, -1.0 / 64.0], [[-5.0 / 96.0, -3.0 / 64.0], [0.0, 0.0]]),
        ] {
            let drawn = drawn(host, device, &scene, (before, 0.3), pixel);
            println!("{:?} {:?}", drawn.motion[first], drawn.motion[second]);
            for (place, expected) in [first, second].into_iter().zip(expected) {
                for (found, expected) in drawn.motion[place].into_iter().zip(expected) {
                    let error: f32 = found - expected;
                    assert!(
                        error.abs() <= expected.abs() / 1024.0 + 1e-5,
                        "{found}, not {expected}"
                    );
                }
            }
            assert!((drawn.depth[first] - 10.0).abs() < 1e-5, "{}", drawn.depth[first]);
            assert!((drawn.depth[second] - 8.0).abs() < 1e-5, "{}", drawn.depth[second]);
            // Where no drop is, what is the host's stays.
            assert_eq!((drawn.motion[none], drawn.depth[none]), (OWN_MOTION, OWN_DEPTH));
        }
    });
}

/// They are those of `render --layers` bit for bit; the picture is that of a view that is not asked for them.
#[test]
fn motion_and_depth_are_those_of_layers() {
    let mut now = scene(Preset::Fast);
    now.time = 0.5;
    let mut before = Scene { time: 0.48, ..now.clone() };
    before.camera.position += DVec3::new(0.3, 0.1, -0.2);
    let expected = &rendered(std::slice::from_ref(&now))[0];
    let mut layers = None;
    common::on_device(|device| {
        let plan = plan(&now, &environment(), Output::Layers).expect("a plan");
        let made = Renderer::new(device, &now, &environment(), &plan);
        let mut renderer = made.expect("a renderer");
        renderer.submit_until(&now, &before).expect("a frame");
        layers = Some(renderer.read_layers().expect("layers"));
    });
    let layers = layers.expect("drawn");
    on_host(Preset::Fast, |host, device| {
        let drawn = drawn(host, device, &now, (before.camera, before.time), [1.0; 2]);
        assert!(drawn.picture == *expected, "another picture");
        let mut drops = 0;
        for at in 0..(SIZE.0 * SIZE.1) as usize {
            let is_drop = layers.id[at] != 0;
            let motion = if is_drop { layers.motion[at].map(f16::to_f32) } else { OWN_MOTION };
            let depth = if is_drop { layers.depth[at] } else { OWN_DEPTH };
            assert_eq!((drawn.motion[at], drawn.depth[at]), (motion, depth), "pixel {at}");
            drops += u32::from(is_drop);
        }
        let pixels = SIZE.0 * SIZE.1;
        println!("{drops} of {pixels} pixels have a drop");
        assert!(drops > 500 && drops < pixels - 100, "{drops}");
    });
}
