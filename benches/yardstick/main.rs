//! What this machine's CPU can do at the paper's benchmark scene, as a yardstick for Vulkan drivers
//! that run on it: `cargo bench --bench yardstick`.
//!
//! A renderer in plain Rust on all cores, for this scene alone: drops in clusters, culled eight at a
//! time, sorted into tiles and composited front to back by distance and index; the sky behind; the
//! photographic operator. Drops under a pixel of area show the mean colour of a drop in their
//! direction, those up to a radius of 4 pixels a prefiltered picture, those above the closed form.
//!
//! It prints milliseconds a frame, medians of `FRAMES` frames that follow each other by 1/60 s. With
//! `YARDSTICK_PNG=FILE` it also writes the picture of each count at time 0, numbered by it.

mod frame;
mod kernel;
mod light;
mod tile;

use std::path::PathBuf;
use std::time::Instant;

use raindrops::environment::Environment;
use raindrops::measure::statistics::{median, quantile};
use raindrops::picture::write_png;
use raindrops::rain::cull::count_visible;
use raindrops::scene::Scene;

use crate::frame::{Frame, Stages};

/// Frames measured a count.
const FRAMES: usize = 31;
/// Frames before that.
const WARM_UP: usize = 4;

fn main() -> raindrops::Result<()> {
    let environment = Environment::bundled()?;
    println!("drops      in view       ms       p10-p90   cull + bin   composite   tone map");
    for count in [125_000, 1_000_000, 4_000_000] {
        let mut scene = Scene::default();
        scene.rain.get_or_insert_default().count = count;
        let mut frame = Frame::new(&scene, &environment);
        let visible = frame.draw(&scene).visible;
        assert_eq!(visible, count_visible(&scene), "the drops in view of {count}");
        if let Some(path) = std::env::var_os("YARDSTICK_PNG") {
            let path = PathBuf::from(path);
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let path = path.with_file_name(format!("{stem}-{count}.png"));
            write_png(&path, scene.image.width, scene.image.height, &frame.srgb())?;
        }
        let mut samples: Vec<Stages> = Vec::new();
        let mut frames_ms = Vec::new();
        for number in 0..WARM_UP + FRAMES {
            scene.time += 1.0 / 60.0;
            let before = Instant::now();
            let stages = frame.draw(&scene);
            if number >= WARM_UP {
                frames_ms.push(before.elapsed().as_secs_f64() * 1e3);
                samples.push(stages);
            }
        }
        let stage = |of: fn(&Stages) -> f64| median(&samples.iter().map(of).collect::<Vec<_>>());
        println!(
            "{count:<10} {visible:<8} {:7.2} {:7.2}-{:<7.2} {:9.2} {:11.2} {:10.2}",
            median(&frames_ms),
            quantile(&frames_ms, 0.1),
            quantile(&frames_ms, 0.9),
            stage(|s| s.bin_ms),
            stage(|s| s.composite_ms),
            stage(|s| s.tone_map_ms),
        );
    }
    Ok(())
}
