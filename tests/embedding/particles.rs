//! Particles in a buffer of a host's: drawn as placed drops are, by a count on the device, renewed while frames are under way;
//! what does not fit is left out and counted.

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};
use half::f16;
use raindrops::device::{Device, HostImage, ImageState};
use raindrops::plan::Output;
use raindrops::renderer::{
    FrameInput, FrameReport, HostMotion, HostParticles, ParticleCount, ParticleLayout, ViewInfo,
};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use crate::common;
use crate::embedded::{Embedded, SIZE, on_host, says, scene, view_for, view_of};
use crate::host::{Host, Mapped};
use crate::motion_depth::{Filled, asked};

/// Bytes before the first particle, and its values in an order of the host's own, with room between.
const OFFSET: u64 = 20;
const LAYOUT: ParticleLayout =
    ParticleLayout { stride: 44, position: 28, radius: 4, velocity: Some(12), id: Some(0) };
/// So far from the world's origin that float32 loses digits of a place.
const BASE: Vec3 = Vec3::new(4096.0, 0.0, 0.0);
const LIMITS: ([DVec3; 2], f32) =
    ([DVec3::new(4032.0, -64.0, -64.0), DVec3::new(4160.0, 64.0, 64.0)], 2.0);

/// A particle whose numbers float32 holds, and sums of them as well.
#[derive(Clone, Copy)]
struct Particle {
    position: Vec3,
    radius: f32,
    velocity: Vec3,
    id: u32,
}

/// Particles before the camera and around it, in no order.
fn cloud(count: u32) -> Vec<Particle> {
    let mut state = 7_u32;
    let mut next = move |steps: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % steps
    };
    let each = |id| {
        let mut part = |half: u32| (next(128 * half) as f32 - (64 * half) as f32) / 64.0;
        let position = BASE + Vec3::new(part(12), part(8), part(8) - 9.0);
        // In half of 2⁻⁴ s it goes on by a digit beyond those of its place.
        let velocity = Vec3::new(part(16), part(16), part(16)) + 2_f32.powi(-12);
        Particle { position, radius: (12.0 + part(8)) / 64.0, velocity, id: 1_000_000 + 7 * id }
    };
    (0..count).map(each).collect()
}

/// Their bytes, with others in between that mean nothing.
fn bytes_of(particles: &[Particle]) -> Vec<u8> {
    let mut bytes = vec![0x7f; OFFSET as usize];
    for Particle { position, radius, velocity, id } in particles {
        let mut words = [f32::NAN.to_bits(); 11];
        (words[0], words[1]) = (*id, radius.to_bits());
        words[3..6].copy_from_slice(&velocity.to_array().map(f32::to_bits));
        words[7..10].copy_from_slice(&position.to_array().map(f32::to_bits));
        bytes.extend_from_slice(bytemuck::cast_slice(&words));
    }
    bytes
}

fn placed(particles: &[Particle]) -> impl Iterator<Item = PlacedDrop> {
    let of = |p: &Particle| PlacedDrop {
        center: p.position.as_dvec3(),
        radius: p.radius.into(),
        velocity: p.velocity.as_dvec3(),
        id: Some(p.id),
        ..PlacedDrop::default()
    };
    particles.iter().map(of)
}

/// A buffer with particles, and what a frame is told of it.
fn uploaded(host: &Host, bytes: &[u8], count: ParticleCount) -> (Mapped, HostParticles) {
    let buffer = host.buffer(bytes.len() as u64, vk::BufferUsageFlags::STORAGE_BUFFER);
    buffer.put(0, bytes);
    let (within, largest) = LIMITS;
    let whole = (buffer.raw, buffer.bytes - OFFSET);
    let particles = HostParticles::new(whole, LAYOUT, count, within, largest);
    (buffer, HostParticles { offset: OFFSET, ..particles })
}

/// A scene of few drops at first.
fn dry(preset: Preset) -> Scene {
    let mut scene = scene(preset);
    scene.rain = None;
    scene.drops[0].center += BASE.as_dvec3();
    scene.camera.position += BASE.as_dvec3();
    scene.camera.target += BASE.as_dvec3();
    scene
}

/// The scene of [`dry`] while the shutter is open, by a camera that moves.
fn exposed(preset: Preset) -> Scene {
    let mut scene = dry(preset);
    // Half of every motion is a sum of powers of two, which no float32 rounds.
    scene.camera.shutter = 0.0625;
    scene.camera.velocity = Some(DVec3::new(0.5, 0.0, -1.0));
    scene
}

#[derive(PartialEq)]
struct Drawn {
    picture: Vec<[f16; 4]>,
    motion: Vec<[f32; 2]>,
    depth: Vec<f32>,
    number: Vec<u32>,
}

/// A frame with all that a host may ask for.
fn drawn(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    particles: Option<HostParticles>,
) -> (Drawn, FrameReport) {
    let info = ViewInfo { nearest_number: Some(vk::Format::R32_UINT), ..asked() };
    let mut embedded = Embedded::new(host, device, scene, &info);
    let motion = Filled::new(host, vk::Format::R32G32_SFLOAT, &[0.0; 2]);
    let depth = Filled::new(host, vk::Format::R32_SFLOAT, &[0.0]);
    let number = Filled::new(host, vk::Format::R32_UINT, &[0.0]);
    let since = HostMotion::since(scene.camera, scene.time - 0.125, motion.image());
    let output = embedded.output();
    let input = FrameInput::new(scene, output).moved(since).nearest(depth.image());
    let mut input = input.numbered(number.image());
    input.particles = particles;
    let report = embedded.draw(host, 0, &input);
    let pixels = u64::from(SIZE.0 * SIZE.1);
    let drawn = Drawn {
        picture: embedded.read(host),
        motion: bytemuck::pod_collect_to_vec(&host.read(&motion.0, 8 * pixels)),
        depth: bytemuck::pod_collect_to_vec(&host.read(&depth.0, 4 * pixels)),
        number: bytemuck::pod_collect_to_vec(&host.read(&number.0, 4 * pixels)),
    };
    drop(embedded.view);
    let images = [embedded.target, motion.0, depth.0, number.0];
    images.into_iter().for_each(|image| host.destroy_image(image));
    (drawn, report)
}

/// At rest, and with a shutter, a lens, rain beside them and a camera that moves: picture, motion, depth and numbers are those
/// of the same drops in the scene, bit for bit.
#[test]
fn particles_are_drawn_as_placed_drops() {
    let mut particles = cloud(333);
    // A cluster whose drops have their centres over the picture's upper edge, and reach into it.
    let edge = 5.0 * dry(Preset::Fast).view().tan_edges()[1].abs() as f32;
    for (number, particle) in particles[..16].iter_mut().enumerate() {
        let (x, y) = (0.25 * number as f32 - 2.0, (64.0 * edge).ceil() / 64.0 + 0.25);
        (particle.position, particle.radius) = (BASE + Vec3::new(x, y, -5.0), 0.5);
    }
    let beside = |preset| {
        let mut scene = exposed(preset);
        scene.rain = Some(RainSettings { count: 2000, ..RainSettings::default() });
        (scene.camera.aperture, scene.camera.focus) = (0.05, 6.0);
        scene
    };
    let real = |preset| {
        let mut scene = exposed(preset);
        scene.rain = Some(RainSettings::of(RealRain { rate: 5.0, ..RealRain::default() }));
        scene
    };
    type Make = fn(Preset) -> Scene;
    let scenes: [(&str, Make); 4] =
        [("at rest", dry), ("exposed", exposed), ("beside others", beside), ("real rain", real)];
    for preset in [Preset::Fast, Preset::Exact] {
        on_host(preset, |host, device| {
            let bytes = bytes_of(&particles);
            let (buffer, own) = uploaded(host, &bytes, ParticleCount::Number(333));
            let scenes = if preset == Preset::Fast { &scenes[..] } else { &scenes[..2] };
            for (name, scene) in scenes {
                let mut by_host = scene(preset);
                let mut by_scene = by_host.clone();
                by_host.host_particles = 333;
                by_scene.drops.extend(placed(&particles));
                let (expected, report) = drawn(host, device, &by_scene, None);
                let (found, own_report) = drawn(host, device, &by_host, Some(own));
                let counts = own_report.counts;
                assert_eq!(counts, report.counts, "{preset}, {name}");
                assert!(counts.visible > 200 && counts.overflow == 0, "{counts:?}");
                let seen = |number: &&u32| {
                    **number >= 1_000_000 && (**number - 1_000_000).is_multiple_of(7)
                };
                assert!(found.number.iter().filter(seen).count() > 500, "{preset}, {name}");
                let differ = found.picture.iter().zip(&expected.picture).filter(|(a, b)| a != b);
                assert_eq!(differ.count(), 0, "{preset}, {name}: pixels that differ");
                assert!(found == expected, "{preset}, {name}: motion, depth or number");
            }
            host.destroy_buffer(buffer);
        });
    }
}

/// Numbers without ids go on from those of the scene's own drops.
#[test]
fn particles_without_ids_are_numbered_by_their_place() {
    let particles = cloud(40);
    let mut by_host = dry(Preset::Fast);
    by_host.host_particles = 40;
    let mut by_scene = dry(Preset::Fast);
    by_scene.drops.extend(placed(&particles).map(|drop| PlacedDrop { id: None, ..drop }));
    on_host(Preset::Fast, |host, device| {
        let (buffer, own) = uploaded(host, &bytes_of(&particles), ParticleCount::Number(40));
        let own = HostParticles { layout: ParticleLayout { id: None, ..LAYOUT }, ..own };
        let (found, _) = drawn(host, device, &by_host, Some(own));
        let (expected, _) = drawn(host, device, &by_scene, None);
        assert!(found.number == expected.number && found.number.iter().any(|n| *n > 2));
        host.destroy_buffer(buffer);
    });
}

/// What is no drop is left out and counted, whatever is wrong with it.
#[test]
fn what_is_no_drop_is_left_out_and_counted() {
    let good = cloud(60);
    let ok = Particle { position: BASE - 5.0 * Vec3::Z, ..good[0] };
    let at = |position| Particle { position, ..ok };
    let bad = [
        at(Vec3::new(f32::NAN, 0.0, -5.0)),
        at(Vec3::new(4096.0, f32::INFINITY, -5.0)),
        at(Vec3::new(4096.0, 0.0, -64.5)),
        at(Vec3::new(4160.5, 0.0, -5.0)),
        Particle { radius: -0.5, ..ok },
        Particle { radius: 0.0, ..ok },
        Particle { radius: f32::NAN, ..ok },
        Particle { radius: f32::INFINITY, ..ok },
        Particle { radius: 2.5, ..ok },
        Particle { velocity: Vec3::new(0.0, f32::NAN, 0.0), ..ok },
        Particle { velocity: Vec3::splat(f32::NEG_INFINITY), ..ok },
    ];
    // Some share a cluster with drops, others have their own. (They come last: by their numbers drops have their samples.)
    let mixed: Vec<_> = [&good[..], &bad[..], &bad[..], &bad[..]].concat();
    let mut scene = dry(Preset::Fast);
    scene.camera.shutter = 0.0625;
    scene.host_particles = mixed.len() as u32;
    on_host(Preset::Fast, |host, device| {
        let by = |particles: &[Particle]| {
            let count = ParticleCount::Number(particles.len() as u32);
            let (buffer, own) = uploaded(host, &bytes_of(particles), count);
            let drawn = drawn(host, device, &scene, Some(own));
            host.destroy_buffer(buffer);
            drawn
        };
        let (expected, report) = by(&good);
        assert_eq!((report.counts.unfit, report.counts.beyond), (0, 0));
        let visible = report.counts.visible;
        let (found, report) = by(&mixed);
        assert_eq!((report.counts.unfit, report.counts.beyond), (33, 0));
        assert_eq!(report.counts.visible, visible);
        assert!(found == expected, "a particle that is no drop shows");
        let remarks = report.counts.remarks(1);
        assert!(remarks.iter().any(|remark| remark.text.contains("33 drops not drawn")));
        // The control: the drop that all of them are but for one value shows.
        let (shown, _) = by(&[&mixed[..mixed.len() - 1], &[ok]].concat());
        assert!(shown != expected);
    });
}

/// The count is read on the device. Over what the view or the buffer has room for it is cut, and reported; what is in memory
/// beyond is not drawn.
#[test]
fn a_count_on_the_device_is_kept_to_the_room() {
    let mut particles = cloud(90);
    // A wall of a drop, in the buffer but beyond what is handed over.
    particles[70] = Particle { position: BASE - 4.0 * Vec3::Z, radius: 1.5, ..particles[70] };
    // With samples of their own: else a few drops in a scene have more rays than as few of many that there may be.
    let dry = || {
        let mut scene = dry(Preset::Fast);
        scene.model.samples = Some(1);
        scene
    };
    let mut scene = dry();
    scene.host_particles = 80;
    on_host(Preset::Fast, |host, device| {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let counts = host.buffer(128, usage);
        let on_device = ParticleCount::OnDevice(counts.raw, 68);
        let (buffer, own) = uploaded(host, &bytes_of(&particles), on_device);
        // The last value of the 70th particle ends its bytes; nothing is after it.
        let cut = HostParticles { bytes: 44 * 69 + 40, ..own };
        let by_scene = |count: usize| {
            let mut scene = dry();
            scene.drops.extend(placed(&particles[..count]));
            drawn(host, device, &scene, None).0
        };
        let (expected, wall) = (by_scene(70), by_scene(71));
        assert!(expected != wall);
        for (claimed, own, drops, beyond) in [
            (0, own, 0, 0),
            (3, own, 3, 0),
            (70, own, 70, 0),
            (80, own, 80, 0),
            (81, own, 80, 1),
            (70, cut, 70, 0),
            (71, cut, 70, 1),
            (u32::MAX, cut, 70, u64::from(u32::MAX) - 70),
        ] {
            counts.put(68, &claimed.to_ne_bytes());
            let (found, report) = drawn(host, device, &scene, Some(own));
            assert_eq!((report.counts.beyond, report.counts.unfit), (beyond, 0), "{claimed}");
            let expected = if drops == 70 { &expected } else { &by_scene(drops) };
            assert!(found == *expected, "a count of {claimed}");
        }
        // A number cuts off as many.
        let by_number = HostParticles { count: ParticleCount::Number(75), ..cut };
        let (found, report) = drawn(host, device, &scene, Some(by_number));
        assert!(found == expected && report.counts.beyond == 5);
        [buffer, counts].into_iter().for_each(|buffer| host.destroy_buffer(buffer));
    });
}

/// What the host's commands write of a frame: drops and their count, which ends the buffer.
fn renew(host: &Host, commands: vk::CommandBuffer, buffer: &Mapped, bytes: &[u8], count: u32) {
    // SAFETY: the command buffer is being recorded, and the buffer holds the words.
    unsafe {
        host.device.cmd_update_buffer(commands, buffer.raw, 0, bytes);
        host.device.cmd_update_buffer(commands, buffer.raw, buffer.bytes - 4, &count.to_ne_bytes());
    }
}

fn barrier(
    host: &Host,
    commands: vk::CommandBuffer,
    from: (vk::PipelineStageFlags2, vk::AccessFlags2),
    to: (vk::PipelineStageFlags2, vk::AccessFlags2),
) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(from.0)
        .src_access_mask(from.1)
        .dst_stage_mask(to.0)
        .dst_access_mask(to.1)];
    let info = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: the command buffer is being recorded, outside of any rendering.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &info) };
}

/// What each frame has in its buffer, and how many drops that is.
type Renewed<'a> = &'a dyn Fn(usize) -> (Vec<u8>, u32);

/// Draws frames of one buffer that the device renews, with room for so many bytes and a count, three in flight and never waited for
/// but for their slots; each into an image of its own.
pub fn renewed_frames(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    (room, renewed): (u64, Renewed<'_>),
    with: &dyn for<'a> Fn(FrameInput<'a>, &Mapped) -> FrameInput<'a>,
) -> Vec<Vec<[f16; 4]>> {
    use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
    let info = ViewInfo { frames_in_flight: 3, ..ViewInfo::default() };
    let mut view = view_of(device, scene, &info).expect("a view");
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let buffer = host.buffer(room + 4, usage);
    let slots: Vec<_> = (0..3).map(|_| (host.commands(), host.fence())).collect();
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let targets: Vec<_> = (0..7).map(|_| host.image(info.format, SIZE, 1, usage)).collect();
    for (number, target) in targets.iter().enumerate() {
        let (slot, (commands, fence)) = (number % 3, slots[number % 3]);
        if number >= 3 {
            host.wait(fence);
        }
        // SAFETY: the slot's fence was signalled, or it was never recorded.
        unsafe { view.retired(slot) }.expect("a report");
        host.begin(commands);
        let (read, written) = (
            (Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_READ),
            (Stage::CLEAR | Stage::COPY, Access::TRANSFER_WRITE),
        );
        barrier(host, commands, (read.0, Access::NONE), (written.0, Access::NONE));
        barrier(host, commands, written, written);
        let (bytes, count) = renewed(number);
        renew(host, commands, &buffer, &bytes, count);
        barrier(host, commands, written, read);
        let output = HostImage {
            exit: ImageState::COPY_SOURCE,
            ..HostImage::color(target.image, target.view, target.format, target.size)
        };
        let output = HostImage { entry: ImageState::UNDEFINED, ..output };
        let input = with(FrameInput::new(scene, output), &buffer);
        // SAFETY: image and buffer are as described; the frames are submitted in order.
        unsafe { view.record(commands, slot, &input) }.expect("a recording");
        host.end(commands);
        host.submit(commands, fence);
    }
    for slot in [1, 2, 0] {
        host.wait(slots[slot].1);
        host.destroy_fence(slots[slot].1);
    }
    drop(view);
    let read = targets.iter().map(|target| host.read(target, 8 * u64::from(SIZE.0 * SIZE.1)));
    let pictures = read.map(|bytes| bytemuck::pod_collect_to_vec(&bytes)).collect();
    targets.into_iter().for_each(|target| host.destroy_image(target));
    host.destroy_buffer(buffer);
    pictures
}

/// The particles of a frame: other places, and fewer.
fn renewed(frame: usize) -> Vec<Particle> {
    let mut particles = cloud(100 - 9 * frame as u32);
    particles.iter_mut().for_each(|particle| particle.position.x += 0.25 * frame as f32);
    particles
}

#[test]
fn particles_are_renewed_while_frames_are_under_way() {
    let mut scene = dry(Preset::Fast);
    scene.host_particles = 100;
    on_host(Preset::Fast, |host, device| {
        let bytes = |frame| (bytes_of(&renewed(frame)), renewed(frame).len() as u32);
        let room = OFFSET + 44 * 100;
        let pictures = renewed_frames(host, device, &scene, (room, &bytes), &|input, buffer| {
            let count = ParticleCount::OnDevice(buffer.raw, buffer.bytes - 4);
            let whole = (buffer.raw, buffer.bytes - OFFSET - 4);
            let own = HostParticles::new(whole, LAYOUT, count, LIMITS.0, LIMITS.1);
            input.with_particles(HostParticles { offset: OFFSET, ..own })
        });
        for (number, picture) in pictures.iter().enumerate() {
            let mut scene = dry(Preset::Fast);
            scene.drops.extend(placed(&renewed(number)));
            let mut embedded = Embedded::new(host, device, &scene, &ViewInfo::default());
            let (expected, _) = embedded.frame(host, 0, &scene);
            assert!(*picture == expected, "frame {number}");
            host.destroy_image(embedded.target);
        }
        assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    });
}

/// What a view or a frame is refused, in a line, before anything is recorded.
#[test]
fn particles_that_cannot_be_read_are_refused() {
    let mut scene = dry(Preset::Fast);
    scene.host_particles = 10;
    on_host(Preset::Fast, |host, device| {
        let info = ViewInfo::default();
        let mut auto = scene.clone();
        auto.model.preset = Preset::Auto;
        says(view_of(device, &auto, &info), "take preset fast or exact");
        let mut embedded = Embedded::new(host, device, &scene, &info);
        let (buffer, good) = uploaded(host, &bytes_of(&cloud(10)), ParticleCount::Number(10));
        let output = embedded.output();
        let mut refused = |particles, words| {
            let mut input = FrameInput::new(&scene, output);
            input.particles = particles;
            // SAFETY: nothing is recorded.
            says(unsafe { embedded.view.record(vk::CommandBuffer::null(), 0, &input) }, words);
        };
        refused(None, "made for a host's particles; name them");
        let null = vk::Buffer::null();
        let layout = |layout| Some(HostParticles { layout, ..good });
        let within = |within| Some(HostParticles { within, ..good });
        let count = |count| Some(HostParticles { count, ..good });
        refused(Some(HostParticles { buffer: null, ..good }), "their buffer is null");
        refused(Some(HostParticles { offset: 2, ..good }), "no multiple of 4");
        refused(Some(HostParticles { bytes: 39, ..good }), "39 bytes of their buffer hold not one");
        refused(layout(ParticleLayout { stride: 0, ..LAYOUT }), "stride 0");
        refused(layout(ParticleLayout { stride: 46, ..LAYOUT }), "stride 46");
        refused(layout(ParticleLayout { position: 36, ..LAYOUT }), "position at byte 36 takes 12");
        refused(layout(ParticleLayout { id: Some(6), ..LAYOUT }), "id at byte 6");
        refused(layout(ParticleLayout { radius: u32::MAX - 3, ..LAYOUT }), "radius at byte");
        refused(count(ParticleCount::OnDevice(null, 0)), "their count is in no buffer");
        refused(count(ParticleCount::OnDevice(buffer.raw, 3)), "at byte 3");
        refused(within([DVec3::ONE, DVec3::ZERO]), "from the smaller to the larger");
        refused(within([DVec3::NAN, DVec3::ZERO]), "limits are finite");
        refused(Some(HostParticles { largest_radius: 0.0, ..good }), "over 0 for the radius");
        // A view without them takes none, and only a host's view has them.
        let without = Scene { host_particles: 0, ..scene.clone() };
        let mut other = view_for(device, &without, Output::Radiance, &info).expect("a view");
        let input = FrameInput::new(&without, output).with_particles(good);
        // SAFETY: nothing is recorded.
        says(
            unsafe { other.record(vk::CommandBuffer::null(), 0, &input) },
            "made for no particles",
        );
        let input = FrameInput::new(&without, output);
        // SAFETY: nothing is recorded.
        says(unsafe { embedded.view.record(vk::CommandBuffer::null(), 0, &input) }, "other drops");
        host.destroy_image(embedded.target);
        host.destroy_buffer(buffer);
    });
    common::on_device(|device| {
        let environment = crate::embedded::environment();
        let plan = raindrops::plan::plan(&scene, &environment, Output::Radiance).expect("a plan");
        let made = raindrops::renderer::Renderer::new(device, &scene, &environment, &plan);
        says(made, "only frames of a host's show its particles");
    });
}
