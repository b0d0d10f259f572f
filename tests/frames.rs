//! Frames in flight: submitted without waiting, they are the frames that waiting gives.

mod common;

use std::process::Command;

use raindrops::environment::Environment;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Simulation;
use raindrops::scene::{ImageSize, RainSettings, Scene};

/// Many frames are submitted as fast as the queue takes them; the last is the picture of its moment.
#[test]
fn frames_in_flight_do_not_mix() {
    common::on_device(|device| {
        let mut scene = Scene {
            rain: Some(RainSettings { count: 50_000, ..RainSettings::default() }),
            image: ImageSize { width: 200, height: 150 },
            ..Scene::default()
        };
        let sky = Environment::bundled().expect("the sky");
        let plan = plan(&common::by_paper(&scene), &sky, Output::Display).expect("a plan");
        let mut renderer = Renderer::new(device, &scene, &sky, &plan).expect("a renderer");
        let mut picture = |in_flight: u32, time: f64| {
            for number in (0..=in_flight).rev() {
                scene.time = time - 0.1 * f64::from(number);
                renderer.submit(&scene).expect("a frame");
            }
            let counts = renderer.finish().expect("a report").counts;
            (counts, renderer.read_display().expect("display"))
        };
        let alone = picture(0, 3.0);
        assert!(alone != picture(0, 2.0), "the control: another moment looks different");
        for in_flight in [1, 2, 7] {
            assert!(alone == picture(in_flight, 3.0), "{in_flight} frames before it change it");
        }
    });
}

/// Makes the layer check hazards between submissions, which it does not do unless told so.
const ACROSS_SUBMISSIONS: (&str, &str) =
    ("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT");

/// Frames alone, without a read-back between them: the layer does not understand that the CPU's wait
/// for a timeline semaphore makes memory free for another use, and would call that a hazard.
#[test]
#[ignore = "run by `no_hazard_between_frames`, in an environment of its own"]
fn frames_without_waiting() {
    common::on_device(|device| {
        let mut scene = Scene {
            rain: Some(RainSettings { count: 1000, ..RainSettings::default() }),
            image: ImageSize { width: 64, height: 64 },
            ..Scene::default()
        };
        let white = Environment::constant(glam::Vec3::ONE);
        for simulation in [Simulation::Integer, Simulation::Stored] {
            scene.model.simulation = Some(simulation);
            let plan = plan(&common::by_paper(&scene), &white, Output::Display).expect("a plan");
            let mut renderer = Renderer::new(device, &scene, &white, &plan).expect("a renderer");
            for _ in 0..6 {
                scene.time += 0.1;
                renderer.submit(&scene).expect("a frame");
            }
            renderer.finish().expect("a report");
        }
    });
}

#[test]
fn no_hazard_between_frames() {
    let (name, value) = ACROSS_SUBMISSIONS;
    let output = Command::new(std::env::current_exe().expect("this test"))
        .args(["--ignored", "--exact", "frames_without_waiting"])
        .env(name, value)
        .output()
        .expect("this test starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("1 passed"), "it ran: {said}");
}
