//! The example of a host with a scene of its own: silent under validation, rain before and behind its boxes as the
//! reference has it with the same colour and depth.

#[path = "../../examples/host_ash/src/fountain.rs"]
mod fountain;
#[path = "../../examples/host_ash/src/frame.rs"]
mod frame;
#[path = "../../examples/host_ash/src/ground.rs"]
mod ground;

use frame::{Around, Outcome};
use glam::{DVec3, Vec3};
use half::f16;
use raindrops::device::{Device, requirements};
use raindrops::picture::Picture;
use raindrops::picture::metrics::{box_filter, rel_mse};
use raindrops::picture::plate::{Depth, Plate};
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::background::DepthKind;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::host;

const SIZE: (u32, u32) = (240, 136);

/// Runs the example, with the shaders that `tests/house/mutants.rs` has put a fault in.
fn run(frames: usize, jitter: bool, around: Around) -> Outcome {
    run_scene(frame::large_drops(SIZE), frames, jitter, around)
}

fn run_scene(scene: Scene, frames: usize, jitter: bool, around: Around) -> Outcome {
    let _alone = crate::common::layer::alone();
    let (required, wanted) = (requirements(Preset::Fast), std::env::var("RAINDROPS_TEST_DEVICE"));
    // SAFETY: the system's loader.
    let entry = unsafe { ash::Entry::load() }.expect("Vulkan");
    let host = host::Host::new(entry, &required, true, wanted.ok().as_deref());
    // SAFETY: all that `lent` says is so, and the host is dropped after everything that is made from it.
    let device = unsafe { Device::import(host.lent(), &required) }.expect("the device");
    // SAFETY: the compiler made them; a fault that is put in changes no interface.
    unsafe { device.replace_shaders(crate::common::replaced_shaders()) };
    let outcome = frame::draw(&host, &device, scene, frames, jitter, around);
    drop(device);
    Outcome { messages: host.messages(), ..outcome }
}

/// Real rain is drawn as well: more where more falls, and without a message.
#[test]
fn real_rain_falls_among_the_boxes() {
    let changed = |rate: f64| {
        let outcome = run_scene(frame::real_rain(SIZE, rate), 3, false, Around::Scene);
        assert_eq!(outcome.messages, Vec::<String>::new());
        assert_eq!(outcome.report.counts.overflow, 0);
        let drops = outcome.nearest.iter().filter(|depth| **depth != 0.0).count();
        assert!(outcome.report.counts.visible > 0 && drops > 0, "{rate} mm/h");
        // Far rain dims the sky and the ground beyond the boxes.
        let (with, without) = (picture(&outcome.picture), picture(&outcome.color));
        let pairs = with.pixels.iter().zip(&without.pixels);
        pairs.map(|(a, b)| f64::from((*a - *b).abs().max_element())).sum::<f64>()
    };
    let (light, heavy) = (changed(2.0), changed(50.0));
    assert!(heavy > 2.0 * light && light > 0.0, "{light} {heavy}");
}

fn picture(pixels: &[[f16; 4]]) -> Picture {
    let light = |p: &[f16; 4]| Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32());
    Picture { width: SIZE.0, height: SIZE.1, pixels: pixels.iter().map(light).collect() }
}

/// How far a stored depth is.
fn distance(stored: &f32) -> f64 {
    ground::NEAR / f64::from(*stored)
}

/// The reference's picture of a scene's drops before the host's colour, hidden by its depth, of which each distance becomes
/// another.
fn reference(outcome: &Outcome, scene: &Scene, depth: fn(f64) -> f64) -> Picture {
    let values = outcome.depth.iter().map(distance).map(depth).collect();
    let depth = Depth { values, kind: DepthKind::Planar };
    let truth = Truth { samples: 64, ..Truth::default() };
    let tracer = Tracer::new(scene, &outcome.environment, truth);
    tracer.before(Plate::new(Some(picture(&outcome.color)), Some(depth))).picture()
}

#[test]
fn rain_among_a_hosts_boxes_is_the_references() {
    let outcome = run(5, true, Around::Painted);
    assert_eq!(outcome.messages, Vec::<String>::new());
    assert_eq!(outcome.report.counts.overflow, 0);

    let drawn = picture(&outcome.picture);
    let without = picture(&outcome.color);
    let reference = |depth| reference(&outcome, &outcome.scene, depth);
    // What is told of drops: none is behind the host's boxes, and they fall.
    let (mut told, mut falls) = (0, 0);
    for ((nearest, motion), stored) in
        outcome.nearest.iter().zip(&outcome.motion).zip(&outcome.depth)
    {
        assert!(*nearest != 0.0 || *motion == [f16::ZERO; 2]);
        // A drop's front may be nearer than its centre, by 0.2 at most.
        assert!(f64::from(*nearest) < distance(stored) + 0.2, "{nearest} is behind {stored}");
        told += u32::from(*nearest != 0.0);
        falls += u32::from(motion[1].to_f32() < -0.5);
    }
    println!("{told} pixels with a drop, {falls} with one that falls");
    assert!(told > 3000 && falls > told / 2);

    let blurred = |picture: &Picture| box_filter(picture);
    let truth = blurred(&reference(|distance| distance));
    let error = rel_mse(&truth, &blurred(&drawn), None);
    // The controls: without rain, and with rain that nothing hides, the error is several times as large.
    let no_rain = rel_mse(&truth, &blurred(&without), None);
    let unhidden = rel_mse(&truth, &blurred(&reference(|_| f64::INFINITY)), None);
    println!(
        "relMSE of 8 x 8 boxes: {error:.5}; without rain {no_rain:.5}; with nothing hidden {unhidden:.5}"
    );
    assert!(error < 0.2 * no_rain && error < 0.2 * unhidden);
}

/// Drops show what the host has drawn into its cube map in the same frame: its sky as if it had been computed, and boxes.
#[test]
fn drops_show_what_is_around_them() {
    let shown = |around| {
        let outcome = run(3, false, around);
        assert_eq!(outcome.messages, Vec::<String>::new());
        println!("{:?}", &outcome.report.passes_ms[..2]);
        picture(&outcome.picture)
    };
    let (painted, sky) = (shown(Around::Painted), shown(Around::Sky));
    let scene = shown(Around::Scene);
    let error = |picture| rel_mse(&box_filter(&painted), &box_filter(picture), None);
    println!(
        "relMSE of 8 x 8 boxes: the sky's cube map {:.6}, the scene's {:.6}",
        error(&sky),
        error(&scene)
    );
    assert!(error(&sky) < 0.1 * error(&scene));
}

/// The drops of the host's own, which it has simulated on the device, as the reference draws them by what its buffer holds.
#[test]
fn a_hosts_fountain_is_the_references() {
    const DROPS: u32 = 1500;
    let outcome = run_scene(frame::fountain(SIZE, DROPS), 4, false, Around::Painted);
    assert_eq!(outcome.messages, Vec::<String>::new());
    let counts = outcome.report.counts;
    assert!(counts.visible > 1000 && counts.overflow + counts.unfit + counts.beyond == 0);
    let words: Vec<[f32; 8]> = bytemuck::pod_collect_to_vec(&outcome.particles);
    assert_eq!(words.len() as u32, DROPS);
    // They collide with the ground: none is in it, and some go up from it again more slowly than they were thrown.
    let lowest = words.iter().map(|[_, y, _, radius, ..]| y - radius).fold(f32::MAX, f32::min);
    let rebound =
        words.iter().filter(|[_, y, _, _, _, up, ..]| *y < 0.05 && *up > 0.3 && *up < 2.0);
    assert!(lowest > -1e-3 && rebound.count() > 10, "{lowest}");

    let shown = |beside: f64| {
        let place = |[x, y, z, radius, ..]: &[f32; 8]| {
            let center = DVec3::new(f64::from(*x) + beside, (*y).into(), (*z).into());
            PlacedDrop::sphere(center, (*radius).into())
        };
        let drops = words.iter().map(place).collect();
        Scene { drops, host_particles: 0, ..outcome.scene.clone() }
    };
    let traced = |scene: &Scene| box_filter(&reference(&outcome, scene, |distance| distance));
    let truth = traced(&shown(0.0));
    let error = |other: &Picture| rel_mse(&truth, other, None);
    let drawn = error(&box_filter(&picture(&outcome.picture)));
    // The controls: no drops, and drops a hand's breadth beside.
    let (none, aside) = (error(&box_filter(&picture(&outcome.color))), error(&traced(&shown(0.1))));
    println!("relMSE of 8 x 8 boxes: {drawn:.5}; without {none:.5}; beside {aside:.5}");
    assert!(drawn < 0.2 * none && drawn < 0.2 * aside);
}
