//! Rain in a frame of somebody else's: a small Vulkan program of its own (`host.rs`), with a scene of its own
//! (`ground.rs`), records rain into its command buffers (`frame.rs`), under validation with synchronization checks.
//!
//! `cargo run --release -p host_ash` draws large drops, for effect, and writes `host_ash.png`. With a rate in millimetres an
//! hour, as in `cargo run --release -p host_ash 25`, it draws real rain; with `fountain`, drops that it simulates itself
//! (`fountain.rs`). `RAINDROPS_DEVICE`: a part of a device's name.

mod fountain;
mod frame;
mod ground;
mod host;

use std::path::Path;
use std::process::ExitCode;

use glam::Vec3;
use raindrops::picture::{srgb_byte, write_png};

const SIZE: (u32, u32) = (960, 540);
const FOUNTAIN: (u32, u32) = (1280, 720);

fn main() -> ExitCode {
    let wanted = std::env::var("RAINDROPS_DEVICE").ok();
    let argument = std::env::args().nth(1);
    let scene = match argument.as_deref().map(|word| (word, word.parse::<f64>())) {
        None => frame::large_drops(SIZE),
        Some(("fountain", _)) => frame::fountain(FOUNTAIN, fountain::DROPS),
        Some((_, Ok(rate))) if rate > 0.0 && rate <= 200.0 => frame::real_rain(SIZE, rate),
        Some(_) => {
            eprintln!(
                "host_ash: give no argument, fountain, or a rate of rain over 0 and up to 200 mm/h"
            );
            return ExitCode::from(2);
        }
    };
    let size = (scene.image.width, scene.image.height);
    let outcome = frame::run(scene, 8, true, frame::Around::Scene, wanted.as_deref());
    let report = &outcome.report;
    println!(
        "{} drops in view, {} that had no room",
        commas(report.counts.visible),
        commas(report.counts.overflow)
    );
    outcome.report.counts.remarks(1).iter().for_each(|remark| println!("{}", remark.text));
    for (pass, ms) in &report.passes_ms {
        println!("{pass:>16} {ms:8.3} ms");
    }
    println!("{} messages of the validation layer", outcome.messages.len());
    outcome.messages.iter().for_each(|message| println!("{message}"));

    // The host's own tone mapping.
    let display = |pixel: &[half::f16; 4]| {
        let light = Vec3::new(pixel[0].to_f32(), pixel[1].to_f32(), pixel[2].to_f32());
        (light / (1.0 + light)).to_array().map(srgb_byte)
    };
    let srgb: Vec<u8> = outcome.picture.iter().flat_map(display).collect();
    let written = write_png(Path::new("host_ash.png"), size.0, size.1, &srgb);
    match &written {
        Ok(()) => println!("host_ash.png is written"),
        Err(error) => println!("{error}"),
    }
    if outcome.messages.is_empty() && written.is_ok() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// With a comma at each thousand: `1,547`.
fn commas(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&[u8]> = digits.as_bytes().rchunks(3).rev().collect();
    String::from_utf8(groups.join(&b',')).expect("digits")
}
