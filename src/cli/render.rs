//! `raindrops render`: one frame or a numbered sequence, as EXR or PNG.

use std::path::{Path, PathBuf};

use clap::Args;

use super::options::{DeviceArgs, ModelArgs, SceneArgs};
use super::{Answer, progress};
use crate::picture::write_png;
use crate::plan::{Output, plan};
use crate::renderer::{FrameReport, Renderer};

/// Render one frame, or a numbered sequence
#[derive(Args)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Picture to write: .exr (linear radiance, float32) or .png (tone mapped, sRGB, 8 bit)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of frames; over 1, files are numbered: rain.png becomes rain-0000.png …
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Frames a second of scene time; negative runs backwards
    #[arg(long, value_name = "F", default_value_t = 30.0, allow_negative_numbers = true)]
    fps: f64,
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    let output = match args.output.extension().and_then(|e| e.to_str()) {
        Some("exr") => Output::Radiance,
        Some("png") => Output::Display,
        _ => anyhow::bail!("{}: name a picture .exr or .png", args.output.display()),
    };
    if !args.fps.is_finite() || args.fps == 0.0 {
        anyhow::bail!("--fps {}: give a finite number that is not 0", args.fps);
    }
    super::check_folder(&args.output)?;
    let environment = super::open_environment(&scene)?;
    let device = args.device.open()?;
    let mut renderer = Renderer::new(&device, &scene, &environment, &plan(&scene, output)?)?;

    let start = scene.time;
    let bar = progress(u64::from(args.frames), "frames");
    let mut report = FrameReport::default();
    for number in 0..args.frames {
        scene.time = start + f64::from(number) / args.fps;
        renderer.submit(&scene)?;
        report = renderer.finish()?;
        let path =
            if args.frames > 1 { numbered(&args.output, number) } else { args.output.clone() };
        match output {
            Output::Radiance => renderer.read_radiance()?.write_exr(&path)?,
            Output::Display => {
                let size = scene.image;
                write_png(&path, size.width, size.height, &renderer.read_display()?)?;
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    eprintln!("{} drops, {} in view", scene.drop_count(), report.counts.visible);
    super::say_undrawn(&report.counts);
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

/// `rain.png` and 7 to `rain-0007.png`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{number:04}.{extension}"))
}
