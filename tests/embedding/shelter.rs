//! A shelter by a host's image: the drops and the medium of the same map in memory, whatever way the host's camera stands;
//! renewed with each frame; and what is refused.

use std::sync::Arc;

use ash::vk;
use glam::dcamera::rh::{proj, view::look_at_mat4};
use glam::{DMat4, DVec2, DVec3, DVec4};
use half::f16;
use raindrops::device::{Device, HostImage, ImageState};
use raindrops::picture::heights::{HeightMap, NOTHING};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{FrameInput, HostShelter, Renderer, ViewInfo};
use raindrops::scene::matrices::ClipSpace;
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{RainSettings, Scene, Shelter};

use crate::common;
use crate::embedded::{Embedded, SIZE, environment, on_host, says, scene, view_of};
use crate::host::{Host, Texture};

/// Where the map is, its columns and rows, and the largest and the smallest height that a camera above sees; float32 holds
/// all that is computed of them.
const FROM: [f64; 2] = [-32.0, -64.0];
const TO: [f64; 2] = [32.0, 0.0];
const COLUMNS: usize = 19;
const ROWS: usize = 6;
const SEEN: [f64; 2] = [16.0, -16.0];

/// Drops in a slanting wind, of a size that single ones are told by.
fn boxes() -> Scene {
    let mut scene = scene(Preset::Fast);
    let rain = scene.rain.get_or_insert_default();
    (rain.count, rain.half_extent, rain.radius) = (20_000, DVec3::splat(60.0), 0.3);
    rain.velocity = DVec3::new(4.0, -9.0, 2.0);
    scene
}

/// Real rain, seen far away as a medium.
fn weather() -> Scene {
    let mut scene = scene(Preset::Fast);
    let wind = DVec3::new(3.0, 0.0, 1.0);
    scene.rain =
        Some(RainSettings::of(RealRain { rate: 80.0, extent: 90.0, wind, ..RealRain::default() }));
    scene
}

/// Towers with holes between, another map for each number.
fn map(number: usize) -> HeightMap {
    let of = |index: usize| match (index + number) * 7 % 5 {
        0 => NOTHING,
        part => ((index * 13 + 29 * number) % 27 + part) as f32 * 0.5 - 9.0,
    };
    HeightMap { columns: COLUMNS, rows: ROWS, heights: (0..COLUMNS * ROWS).map(of).collect() }
}

fn under(scene: &Scene, shelter: Shelter) -> Scene {
    Scene { shelter: Some(shelter), ..scene.clone() }
}

fn by_host(scene: &Scene) -> Scene {
    under(scene, Shelter::of_host(COLUMNS as u32, ROWS as u32))
}

fn in_memory(scene: &Scene, map: HeightMap) -> Scene {
    under(scene, Shelter::of(map, FROM, TO))
}

/// A host's image of numbers, to be sampled.
fn uploaded(host: &Host, format: vk::Format, size: [usize; 2], numbers: &[f32]) -> Texture {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let image = host.image(format, (size[0] as u32, size[1] as u32), 1, usage);
    host.write(&image, bytemuck::cast_slice(numbers));
    image
}

fn sampled(texture: &Texture) -> HostImage {
    let Texture { image, view, format, size, .. } = *texture;
    let of = if format == vk::Format::D32_SFLOAT { HostImage::depth } else { HostImage::color };
    let (entry, exit) = (ImageState::SAMPLED, ImageState::SAMPLED);
    HostImage { entry, exit, ..of(image, view, format, size) }
}

fn heights_of(host: &Host, map: &HeightMap) -> (Texture, HostShelter) {
    let format = vk::Format::R32_SFLOAT;
    let texture = uploaded(host, format, [map.columns, map.rows], &map.heights);
    let shelter = HostShelter::of_heights(sampled(&texture), FROM.into(), TO.into());
    (texture, shelter)
}

/// A frame of a new view.
fn drawn(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    shelter: Option<HostShelter>,
) -> Vec<[f16; 4]> {
    let mut embedded = Embedded::new(host, device, scene, &ViewInfo::default());
    let picture = frame(&mut embedded, host, 0, scene, shelter);
    drop(embedded.view);
    host.destroy_image(embedded.target);
    picture
}

fn frame(
    embedded: &mut Embedded,
    host: &Host,
    slot: usize,
    scene: &Scene,
    shelter: Option<HostShelter>,
) -> Vec<[f16; 4]> {
    let mut input = FrameInput::new(scene, embedded.output());
    input.shelter = shelter;
    embedded.draw(host, slot, &input);
    embedded.read(host)
}

#[test]
fn heights_of_a_host_are_those_of_a_map_in_memory() {
    let map = map(0);
    on_host(Preset::Fast, |host, device| {
        // NaN, infinities and what is beyond all heights are no surface, as what is under them.
        let none = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e9, -2e9, NOTHING];
        let mut numbers = none.iter().cycle();
        let stored = map.heights.iter().map(|height| match *height == NOTHING {
            true => *numbers.next().expect("without end"),
            false => *height,
        });
        let stored = HeightMap { heights: stored.collect(), ..map.clone() };
        let (texture, shelter) = heights_of(host, &stored);
        for scene in [boxes(), weather()] {
            let expected = drawn(host, device, &in_memory(&scene, map.clone()), None);
            assert!(drawn(host, device, &by_host(&scene), Some(shelter)) == expected);
            assert!(expected != drawn(host, device, &scene, None), "nothing is sheltered");
        }
        // Where nothing is, the rain is that without a shelter, and so is all of it beyond the map.
        let nothing = HeightMap { heights: vec![f32::NAN; COLUMNS * ROWS], ..map.clone() };
        let (empty, of_nothing) = heights_of(host, &nothing);
        let away = HostShelter { corners: [DVec2::splat(900.0), DVec2::splat(999.0)], ..shelter };
        let open = drawn(host, device, &boxes(), None);
        for shelter in [of_nothing, away] {
            assert!(drawn(host, device, &by_host(&boxes()), Some(shelter)) == open);
        }
        [texture, empty].into_iter().for_each(|image| host.destroy_image(image));
    });
}

/// Any way that an engine's camera above may be turned, its clip space upside down or not, its depth reversed or not.
#[test]
fn depth_from_above_is_those_heights() {
    let map = map(1);
    let [middle, half] = [0.5 * (FROM[1] + TO[1]), 0.5 * (TO[1] - FROM[1])];
    let ups = [DVec3::NEG_Z, DVec3::X, DVec3::Z, DVec3::NEG_X];
    on_host(Preset::Fast, |host, device| {
        let scene = by_host(&boxes());
        let expected = drawn(host, device, &in_memory(&boxes(), map.clone()), None);
        let mut embedded = Embedded::new(host, device, &scene, &ViewInfo::default());
        for number in 0..16 {
            let (up, is_reversed) = (ups[number % 4], number % 2 == number / 8);
            let eye = DVec3::new(0.0, SEEN[0], middle);
            let seen = look_at_mat4(eye, eye - DVec3::Y, up);
            // Half of all cameras see the world mirrored.
            let side = if number / 4 % 2 == 0 { half } else { -half };
            let (clip_space, orthographic) = match number / 2 % 2 {
                0 => (
                    ClipSpace::YDown,
                    proj::vulkan::orthographic as fn(f64, f64, f64, f64, f64, f64) -> DMat4,
                ),
                _ => (ClipSpace::YUp, proj::directx::orthographic as _),
            };
            let projection = orthographic(-side, side, -half, half, 0.0, SEEN[0] - SEEN[1]);
            let reversed =
                DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::NEG_Z, DVec4::new(0.0, 0.0, 1.0, 1.0));
            let matrix = if is_reversed { reversed } else { DMat4::IDENTITY } * projection * seen;

            // What such a camera sees of the texels.
            let is_turned = up.x != 0.0;
            let size = if is_turned { [ROWS, COLUMNS] } else { [COLUMNS, ROWS] };
            let mut numbers = vec![if is_reversed { 0.0_f32 } else { 1.0 }; COLUMNS * ROWS];
            for (index, height) in
                map.heights.iter().enumerate().filter(|(_, height)| **height != NOTHING)
            {
                let part = |at: usize, all: usize, axis: usize| {
                    FROM[axis] + (TO[axis] - FROM[axis]) * (at as f64 + 0.5) / all as f64
                };
                let [x, z] = [part(index % COLUMNS, COLUMNS, 0), part(index / COLUMNS, ROWS, 1)];
                let clip = matrix * DVec4::new(x, f64::from(*height), z, 1.0);
                let down = if clip_space == ClipSpace::YDown { clip.y } else { -clip.y };
                let texel = |clip: f64, size: usize| ((0.5 + 0.5 * clip) * size as f64) as usize;
                numbers[texel(down, size[1]) * size[0] + texel(clip.x, size[0])] = clip.z as f32;
            }
            let format = if number < 8 { vk::Format::D32_SFLOAT } else { vk::Format::R32_SFLOAT };
            let texture = uploaded(host, format, size, &numbers);
            let shelter = HostShelter::from_above(sampled(&texture), matrix, clip_space);
            let shelter = shelter.expect("a camera that looks down");
            let found = frame(&mut embedded, host, number % 2, &scene, Some(shelter));
            assert!(
                found == expected,
                "camera {number}: up {up}, {clip_space:?}, reversed: {is_reversed}"
            );
            host.destroy_image(texture);
        }
        drop(embedded.view);
        host.destroy_image(embedded.target);
    });
}

/// Two frames under way at once, each with a map and a place of its own; the camera stands still, so the sky of far rain would
/// be kept if it did not change.
#[test]
fn each_frame_has_the_map_that_it_names() {
    on_host(Preset::Fast, |host, device| {
        for scene in [boxes(), weather()] {
            let maps = [0, 1, 2, 3].map(map);
            let named = maps.each_ref().map(|map| heights_of(host, map));
            let moved = |number: usize, at: [f64; 2]| [at[0] + number as f64, at[1]];
            let expected: Vec<_> = (0..4)
                .map(|number| {
                    let shelter =
                        Shelter::of(maps[number].clone(), moved(number, FROM), moved(number, TO));
                    drawn(host, device, &under(&scene, shelter), None)
                })
                .collect();
            assert!(expected.windows(2).all(|pair| pair[0] != pair[1]));
            let live = by_host(&scene);
            let mut view = view_of(device, &live, &ViewInfo::default()).expect("a view");
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
            let format = ViewInfo::default().format;
            let targets = [0; 4].map(|_| host.image(format, SIZE, 1, usage));
            let slots = [0; 2].map(|_| (host.commands(), host.fence()));
            for (number, target) in targets.iter().enumerate() {
                let (slot, (commands, fence)) = (number % 2, slots[number % 2]);
                if number >= 2 {
                    host.wait(fence);
                }
                // SAFETY: the slot's fence was signalled, or it was never recorded.
                unsafe { view.retired(slot) }.expect("a report");
                let corners = [moved(number, FROM).into(), moved(number, TO).into()];
                let output = HostImage {
                    entry: ImageState::UNDEFINED,
                    exit: ImageState::COPY_SOURCE,
                    ..HostImage::color(target.image, target.view, format, SIZE)
                };
                let shelter = HostShelter { corners, ..named[number].1 };
                let input = FrameInput::new(&live, output).under(shelter);
                host.begin(commands);
                // SAFETY: the images are as described; the frames are submitted in order.
                unsafe { view.record(commands, slot, &input) }.expect("a recording");
                host.end(commands);
                host.submit(commands, fence);
            }
            slots.iter().for_each(|(_, fence)| host.wait(*fence));
            slots.iter().for_each(|(_, fence)| host.destroy_fence(*fence));
            drop(view);
            for (number, target) in targets.into_iter().enumerate() {
                let found = host.read(&target, 8 * u64::from(SIZE.0 * SIZE.1));
                let found: Vec<[f16; 4]> = bytemuck::pod_collect_to_vec(&found);
                assert!(found == expected[number], "frame {number}");
                host.destroy_image(target);
            }
            named.into_iter().for_each(|(texture, _)| host.destroy_image(texture));
        }
    });
}

/// What a view or a frame is refused, in a line, before anything is recorded.
#[test]
fn a_shelter_that_cannot_be_read_is_refused() {
    let open = scene(Preset::Fast);
    let live = by_host(&open);
    common::on_device(|device| {
        let plan = plan(&live, &environment(), Output::Radiance).expect("a plan");
        let made = Renderer::new(device, &live, &environment(), &plan);
        says(made, "only frames of a host's have its shelter");
    });
    let none = under(&open, Shelter::of_host(4, 0)).validate("a test");
    says(none, "one column and one row at least");
    on_host(Preset::Fast, |host, device| {
        let wide = under(&open, Shelter::of_host(1 << 20, 4));
        let made = view_of(device, &wide, &ViewInfo::default());
        says(made, "1,048,576");

        let mut embedded = Embedded::new(host, device, &live, &ViewInfo::default());
        let (texture, good) = heights_of(host, &map(0));
        let output = embedded.output();
        let commands = host.commands();
        host.begin(commands);
        let mut refused = |scene: &Scene, shelter: Option<HostShelter>, words: &str| {
            let mut input = FrameInput::new(scene, output);
            input.shelter = shelter;
            // SAFETY: nothing is submitted.
            let result = unsafe { embedded.view.record(commands, 0, &input) };
            says(result, words);
        };
        let of = |change: &dyn Fn(&mut HostShelter)| {
            let mut shelter = good;
            change(&mut shelter);
            Some(shelter)
        };
        refused(&live, None, "name its map");
        refused(&open, Some(good), "made for another shelter");
        refused(&live, of(&|s| s.image.size.0 += 1), "20 x 6 texels; the view has 19 x 6");
        refused(&live, of(&|s| s.is_turned = true), "19 x 6 texels; the view has 6 x 19");
        refused(
            &live,
            of(&|s| s.image.format = vk::Format::R8G8B8A8_UNORM),
            "neither height nor depth",
        );
        refused(&live, of(&|s| s.image.entry = ImageState::UNDEFINED), "which holds nothing");
        refused(&live, of(&|s| s.image.view = vk::ImageView::null()), "null");
        refused(&live, of(&|s| s.image.image = output.image), "are one image");
        refused(&live, of(&|s| s.corners[1].y = s.corners[0].y), "apart along x and z");
        refused(&live, of(&|s| s.corners[1].x = f64::NAN), "finite corners");
        refused(&live, of(&|s| s.heights = [2.0, 2.0]), "two finite heights");
        host.end(commands);
        drop(embedded.view);

        let seen = look_at_mat4(DVec3::Y, DVec3::ZERO, DVec3::X);
        let flat = proj::vulkan::orthographic(-8.0, 8.0, -8.0, 8.0, 0.0, 32.0);
        let refused = |matrix: DMat4, words: &str| {
            let made = HostShelter::from_above(good.image, matrix, ClipSpace::YDown);
            says(made, words);
        };
        refused(proj::vulkan::perspective(1.0, 1.0, 0.1, 9.0) * seen, "orthographic");
        refused(flat * seen * DMat4::from_rotation_y(0.1), "along x or z");
        refused(flat * DMat4::from_rotation_x(0.1) * seen, "straight down");
        refused(flat, "straight down");
        refused(flat * f64::NAN, "not finite");

        // A view without one takes none.
        let mut without = Embedded::new(host, device, &open, &ViewInfo::default());
        let input = FrameInput::new(&open, without.output()).under(good);
        // SAFETY: nothing is recorded.
        let result = unsafe { without.view.record(commands, 0, &input) };
        says(result, "Shelter::of_host");
        drop(without.view);
        [embedded.target, without.target, texture]
            .into_iter()
            .for_each(|image| host.destroy_image(image));
    });
}
