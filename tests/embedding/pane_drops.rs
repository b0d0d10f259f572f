//! Drops on a pane in a buffer of a host's: drawn as those of the scene, by a count on the device, renewed while frames are under
//! way; what does not fit is left out and counted.

use std::sync::Arc;

use ash::vk;
use glam::DVec2;
use half::f16;
use raindrops::device::Device;
use raindrops::renderer::{
    FrameInput, FrameReport, HostPaneDrops, PaneDropLayout, ParticleCount, Renderer, ViewInfo,
};
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;
use raindrops::scene::pane::{Pane, PaneDrop};

use crate::common;
use crate::embedded::{Embedded, on_host, says, scene, view_of};
use crate::host::{Host, Mapped};
use crate::particles::renewed_frames;

type Picture = Vec<[f16; 4]>;

/// Bytes before the first drop, and its values in an order of the host's own, with room between.
const OFFSET: u64 = 20;
const LAYOUT: PaneDropLayout =
    PaneDropLayout { stride: 28, at: 8, radius: 4, contact_angle: Some(20) };
/// The outermost drops have their middles on its edges.
const WITHIN: [DVec2; 2] = [DVec2::new(-0.224609375, -0.15625), DVec2::new(0.2421875, 0.15625)];
const LARGEST: (f32, f32) = (0.0078125, 150.0);

/// Drops side by side in rows, none of which touches another, in numbers that float32 holds.
fn rows(count: u32) -> Vec<PaneDrop> {
    let each = |number: u32| {
        let [x, y, some] = [number % 24, number / 24, number * 7 % 16].map(f64::from);
        let at = 0.01953125 * DVec2::new(x - 11.5, y - 8.0) + 2e-4 * some;
        PaneDrop {
            at: at.as_vec2().as_dvec2(),
            radius: (8.0 + some / 2.0) / 2048.0,
            contact_angle: Some(30.0 + 8.0 * some),
        }
    };
    (0..count).map(each).collect()
}

/// Their bytes, with others in between that mean nothing.
fn bytes_of(drops: &[PaneDrop]) -> Vec<u8> {
    let mut bytes = vec![0x7f; OFFSET as usize];
    for PaneDrop { at, radius, contact_angle } in drops {
        let [u, v] = at.as_vec2().to_array();
        let angle = contact_angle.unwrap_or(60.0) as f32;
        let words = [f32::NAN, *radius as f32, u, v, f32::NAN, angle, f32::NAN];
        bytes.extend_from_slice(bytemuck::cast_slice(&words));
    }
    bytes
}

/// A buffer with drops, and what a frame is told of it.
fn uploaded(host: &Host, drops: &[PaneDrop], count: ParticleCount) -> (Mapped, HostPaneDrops) {
    // A buffer holds one at least, whatever its count.
    let bytes = if drops.is_empty() { bytes_of(&rows(1)) } else { bytes_of(drops) };
    let buffer = host.buffer(bytes.len() as u64, vk::BufferUsageFlags::STORAGE_BUFFER);
    buffer.put(0, &bytes);
    let own = own_of(&buffer, buffer.bytes - OFFSET, count);
    (buffer, own)
}

fn own_of(buffer: &Mapped, bytes: u64, count: ParticleCount) -> HostPaneDrops {
    let own = HostPaneDrops::new((buffer.raw, bytes), LAYOUT, count, WITHIN, LARGEST);
    HostPaneDrops { offset: OFFSET, ..own }
}

/// A pane before a drop in the air, in focus or not, with room for drops of a host's.
fn glass(preset: Preset, aperture: f64, most: u32) -> Scene {
    let mut scene = scene(preset);
    (scene.rain, scene.host_pane_drops) = (None, most);
    (scene.camera.aperture, scene.camera.focus) = (aperture, 5.0);
    scene.pane = Some(Pane { distance: Some(0.3), tilt: Some(20.0), ..Pane::default() });
    scene
}

/// A frame by a view that is there, of these drops.
fn drawn(
    host: &Host,
    view: &mut Embedded,
    scene: &Scene,
    drops: &[PaneDrop],
) -> (Picture, FrameReport) {
    let (buffer, own) = uploaded(host, drops, ParticleCount::Number(drops.len() as u32));
    let found = shown(host, view, scene, own);
    host.destroy_buffer(buffer);
    found
}

fn shown(
    host: &Host,
    view: &mut Embedded,
    scene: &Scene,
    own: HostPaneDrops,
) -> (Picture, FrameReport) {
    let input = FrameInput::new(scene, view.output()).with_drops_on_pane(own);
    let report = view.draw(host, 0, &input);
    (view.read(host), report)
}

/// Runs with a view of a scene.
fn on_view(host: &Host, device: &Arc<Device>, scene: &Scene, run: impl FnOnce(&mut Embedded)) {
    let mut view = Embedded::new(host, device, scene, &ViewInfo::default());
    run(&mut view);
    host.destroy_image(view.target);
}

/// How far two pictures are apart: the squares of the differences over those of the first, and the pixels that differ at all.
fn apart(expected: &Picture, found: &Picture) -> (f64, usize) {
    let each = |pixels: &Picture| -> Vec<f64> {
        pixels.iter().flatten().map(|part| part.to_f64()).collect()
    };
    let (a, b) = (each(expected), each(found));
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
    let differ = expected.iter().zip(found).filter(|(a, b)| a != b).count();
    (squares / a.iter().map(|a| a * a).sum::<f64>(), differ)
}

/// In focus and out of it the picture is that of the same drops in the scene, but for what float32 loses of places and caps. It does
/// not depend on who comes first: in focus not even on the order in the buffer.
#[test]
fn drops_of_a_host_are_those_of_the_scene() {
    let drops = rows(384);
    for (preset, aperture) in
        [(Preset::Fast, 0.0), (Preset::Fast, 0.02), (Preset::Exact, 0.0), (Preset::Exact, 0.02)]
    {
        on_host(preset, |host, device| {
            let dry = glass(preset, aperture, 0);
            let mut wet = dry.clone();
            wet.pane.as_mut().expect("a pane").drops.clone_from(&drops);
            let (mut expected, mut bare) = (Picture::new(), Picture::new());
            on_view(host, device, &dry, |view| {
                bare = view.frame(host, 0, &dry).0;
                view.view.renew_pane(&wet).expect("drops");
                expected = view.frame(host, 1, &wet).0;
            });
            let by_host = glass(preset, aperture, 400);
            on_view(host, device, &by_host, |view| {
                let (found, report) = drawn(host, view, &by_host, &drops);
                let (off, differ) = apart(&expected, &found);
                println!("{preset}, aperture {aperture}: {off:.1e}, {differ} pixels differ");
                let counts = report.counts;
                assert_eq!((counts.unfit, counts.beyond, counts.overflow), (0, 0, 0));
                assert!(report.passes_ms.iter().any(|(name, _)| *name == "pane drops"));
                assert!(
                    off < 3e-9 && apart(&bare, &expected).0 > 1e-2,
                    "{preset}, {aperture}: {off}"
                );
                assert!(drawn(host, view, &by_host, &drops).0 == found, "another run");
                let backwards: Vec<_> = drops.iter().rev().copied().collect();
                let other = drawn(host, view, &by_host, &backwards).0;
                let (off, differ) = apart(&found, &other);
                println!("backwards {off:.1e}, {differ} pixels differ");
                assert!(if aperture == 0.0 { differ == 0 } else { off < 1e-8 }, "backwards: {off}");
                // Without a drop it is the dry pane.
                assert!(drawn(host, view, &by_host, &[]).0 == bare, "drops where there are none");
            });
        });
    }
}

/// What is no drop is left out and counted, whatever is wrong with it.
#[test]
fn what_is_no_drop_on_a_pane_is_left_out_and_counted() {
    let good = rows(200);
    let ok = PaneDrop { at: DVec2::new(0.0, 0.15), radius: 0.0078125, contact_angle: Some(90.0) };
    let (at, sized) = (|at| PaneDrop { at, ..ok }, |radius| PaneDrop { radius, ..ok });
    let steep = |angle: f64| PaneDrop { contact_angle: Some(angle), ..ok };
    let bad = [
        at(DVec2::new(f64::NAN, 0.1)),
        at(DVec2::new(0.0, f64::NEG_INFINITY)),
        at(DVec2::new(0.2501, 0.1)),
        at(DVec2::new(0.0, -0.1876)),
        sized(f64::NAN),
        sized(0.0),
        sized(-0.005),
        sized(0.0079),
        sized(f64::INFINITY),
        steep(f64::NAN),
        steep(0.9),
        steep(151.0),
        steep(180.0),
    ];
    // By their numbers drops out of focus are summed up, so the others come last.
    let mixed = [&good[..], &bad[..]].concat();
    for aperture in [0.0, 0.02] {
        let scene = glass(Preset::Fast, aperture, mixed.len() as u32);
        on_host(Preset::Fast, |host, device| {
            on_view(host, device, &scene, |view| {
                let (expected, report) = drawn(host, view, &scene, &good);
                assert_eq!((report.counts.unfit, report.counts.beyond), (0, 0));
                let (found, report) = drawn(host, view, &scene, &mixed);
                assert_eq!((report.counts.unfit, report.counts.beyond), (bad.len() as u64, 0));
                assert!(found == expected, "what is no drop shows");
                // The control: the drop that all of them are but for one value shows.
                let (shown, report) = drawn(host, view, &scene, &[&good[..], &[ok]].concat());
                assert!(shown != expected && report.counts.unfit == 0);
            });
        });
    }
}

/// Over what the view or the buffer has room for a count is cut, and reported; what is in memory beyond is not drawn.
#[test]
fn a_count_of_drops_on_a_pane_is_kept_to_the_room() {
    let drops = rows(384);
    let scene = glass(Preset::Fast, 0.0, 300);
    on_host(Preset::Fast, |host, device| {
        let counts = host.buffer(128, vk::BufferUsageFlags::STORAGE_BUFFER);
        let on_device = ParticleCount::OnDevice(counts.raw, 68);
        let (buffer, own) = uploaded(host, &drops, on_device);
        // The last value of the 250th drop ends its bytes; nothing is after it.
        let cut = HostPaneDrops { bytes: 28 * 249 + 24, ..own };
        on_view(host, device, &scene, |view| {
            for (claimed, own, taken) in [
                (0, own, 0),
                (3, own, 3),
                (300, own, 300),
                (301, own, 300),
                (250, cut, 250),
                (251, cut, 250),
                (u32::MAX, cut, 250),
            ] {
                counts.put(68, &claimed.to_ne_bytes());
                let (found, report) = shown(host, view, &scene, own);
                let beyond = u64::from(claimed - taken);
                assert_eq!((report.counts.beyond, report.counts.unfit), (beyond, 0), "{claimed}");
                let expected = drawn(host, view, &scene, &drops[..taken as usize]).0;
                assert!(found == expected, "a count of {claimed}");
            }
        });
        [buffer, counts].into_iter().for_each(|buffer| host.destroy_buffer(buffer));
    });
}

/// The first of drops that overlap is in front, whoever comes first. They may need more room than there is: what has none is counted,
/// cell by cell.
#[test]
fn drops_that_overlap_stay_within_the_room() {
    let at = DVec2::new(0.0234375, 0.0078125);
    let piled = |number: u32| PaneDrop {
        at,
        radius: 0.0078125,
        contact_angle: Some(if number == 0 { 90.0 } else { 60.0 }),
    };
    let piled: Vec<_> = (0..50).map(piled).collect();
    on_host(Preset::Fast, |host, device| {
        for aperture in [0.0, 0.02] {
            let scene = glass(Preset::Fast, aperture, 60);
            on_view(host, device, &scene, |view| {
                let rows = rows(60);
                let (expected, _) = drawn(host, view, &scene, &rows);
                let (found, report) = drawn(host, view, &scene, &piled);
                assert_eq!(report.counts.overflow, 0);
                let alone = drawn(host, view, &scene, &piled[..1]).0;
                assert!(aperture > 0.0 || found == alone, "another drop is before the first");
                // In a small box, where none overhangs, each is in some seventy cells.
                let (buffer, own) = uploaded(host, &piled, ParticleCount::Number(50));
                let within = [at - 0.0009765625, at + 0.0009765625];
                let own = HostPaneDrops { within, largest_angle: 90.0, ..own };
                let (found, report) = shown(host, view, &scene, own);
                let counts = report.counts;
                assert!(counts.overflow > 1000 && counts.unfit + counts.beyond == 0, "{counts:?}");
                assert_eq!(counts.overflow % 50, 0, "a cell has room for some of its numbers");
                let (again, report) = shown(host, view, &scene, own);
                assert!(again == found && report.counts == counts, "another run");
                host.destroy_buffer(buffer);
                assert!(drawn(host, view, &scene, &rows).0 == expected, "something of it is left");
            });
        }
    });
}

/// The drops of a frame: other places, and fewer.
fn renewed(frame: usize) -> Vec<PaneDrop> {
    let mut drops = rows(384 - 31 * frame as u32);
    drops.iter_mut().for_each(|drop| drop.at.x += 0.001953125 * frame as f64);
    drops
}

#[test]
fn drops_on_a_pane_are_renewed_while_frames_are_under_way() {
    let scene = glass(Preset::Fast, 0.02, 384);
    on_host(Preset::Fast, |host, device| {
        let room = OFFSET + 28 * 384;
        let bytes = |frame| (bytes_of(&renewed(frame)), renewed(frame).len() as u32);
        let pictures = renewed_frames(host, device, &scene, (room, &bytes), &|input, buffer| {
            let count = ParticleCount::OnDevice(buffer.raw, buffer.bytes - 4);
            input.with_drops_on_pane(own_of(buffer, buffer.bytes - OFFSET - 4, count))
        });
        on_view(host, device, &scene, |view| {
            for (number, picture) in pictures.iter().enumerate() {
                let (expected, _) = drawn(host, view, &scene, &renewed(number));
                assert!(*picture == expected, "frame {number}");
            }
        });
        assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    });
}

/// What a view or a frame is refused, in a line, before anything is recorded.
#[test]
fn drops_on_a_pane_that_cannot_be_read_are_refused() {
    let scene = glass(Preset::Fast, 0.0, 10);
    on_host(Preset::Fast, |host, device| {
        let info = ViewInfo::default();
        let mut other = scene.clone();
        other.pane.as_mut().expect("a pane").drops = rows(1);
        says(view_of(device, &other, &info), "instead of all others");
        let other = Scene { pane: None, ..scene.clone() };
        says(view_of(device, &other, &info), "there is none for the host's drops");
        let other = Scene { host_pane_drops: 1_000_000, ..scene.clone() };
        says(view_of(device, &other, &info), "host_pane_drops = 1000000 is over 524288");
        let mut other = scene.clone();
        other.model.preset = Preset::Auto;
        says(view_of(device, &other, &info), "take preset fast or exact");
        let (buffer, good) = uploaded(host, &rows(10), ParticleCount::Number(10));
        on_view(host, device, &scene, |view| {
            let output = view.output();
            let mut refused = |scene: &Scene, drops, words| {
                let mut input = FrameInput::new(scene, output);
                input.drops_on_pane = drops;
                // SAFETY: nothing is recorded.
                says(unsafe { view.view.record(vk::CommandBuffer::null(), 0, &input) }, words);
            };
            refused(&scene, None, "made for a host's drops on the pane; name them");
            let other = Scene { host_pane_drops: 9, ..scene.clone() };
            refused(&other, Some(good), "another number of a host's drops");
            let layout = |layout| Some(HostPaneDrops { layout, ..good });
            let within = |within| Some(HostPaneDrops { within, ..good });
            let largest = |largest_radius, largest_angle| {
                Some(HostPaneDrops { largest_radius, largest_angle, ..good })
            };
            refused(
                &scene,
                layout(PaneDropLayout { stride: 0, ..LAYOUT }),
                "the drops on the pane: offset 20 or stride 0",
            );
            refused(&scene, layout(PaneDropLayout { at: 24, ..LAYOUT }), "at at byte 24 takes 8");
            let angle = Some(26);
            refused(
                &scene,
                layout(PaneDropLayout { contact_angle: angle, ..LAYOUT }),
                "contact_angle at byte 26",
            );
            refused(&scene, within([DVec2::ONE, DVec2::ZERO]), "from the smaller to the larger");
            refused(&scene, within([DVec2::ZERO, DVec2::splat(1e300)]), "limits are finite");
            refused(&scene, largest(0.0, 90.0), "over 0 for the radius");
            refused(&scene, largest(0.1, 171.0), "1 to 170 degrees for the angle");
        });
        let without = glass(Preset::Fast, 0.0, 0);
        on_view(host, device, &without, |view| {
            let input = FrameInput::new(&without, view.output()).with_drops_on_pane(good);
            // SAFETY: nothing is recorded.
            let refused = unsafe { view.view.record(vk::CommandBuffer::null(), 0, &input) };
            says(refused, "made for no drops on the pane; set host_pane_drops");
        });
        host.destroy_buffer(buffer);
    });
    common::on_device(|device| {
        let environment = crate::embedded::environment();
        let plan = raindrops::plan::plan(&scene, &environment, raindrops::plan::Output::Radiance);
        let made = Renderer::new(device, &scene, &environment, &plan.expect("a plan"));
        says(made, "only frames of a host's show");
    });
}
