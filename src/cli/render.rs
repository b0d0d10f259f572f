//! `raindrops render`: one frame or a numbered sequence, as EXR or PNG.

use std::path::PathBuf;

use clap::Args;

use super::options::{BackgroundArgs, DeviceArgs, ModelArgs, SceneArgs, resolve};
use super::sequence::{Sequence, heed_interrupts, is_interrupted};
use super::{Answer, Format, drops, progress, say_doubt, waiting};
use crate::picture::write_png;
use crate::plan::{Output, plan_by};
use crate::renderer::{FrameReport, Renderer};
use crate::scene::model::Simulation;

/// Render one frame, or a numbered sequence
#[derive(Args)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    background: BackgroundArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Picture to write: .exr (linear radiance, float32) or .png (tone mapped, sRGB, 8 bit)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of frames; left out: as many as the scene's film has. Over 1, files are numbered:
    /// rain.png becomes rain-0000.png …
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Frames a second; negative runs backwards, from the last key if there are any [default: the film's, or 30]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Keep the frames of this scene that are there, and render the others
    #[arg(long)]
    resume: bool,
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    args.background.apply(&mut scene)?;
    if let Some(fps) = args.fps {
        scene.film.fps = fps;
        scene.validate("--fps")?;
    }
    let output = match Format::of(&args.output)? {
        Format::Exr => Output::Radiance,
        Format::Png => Output::Display,
    };
    let environment = super::open_environment(&scene)?;
    let frames = args.frames.unwrap_or_else(|| scene.film.frames());
    let mut sequence = (frames > 1).then(|| Sequence::new(&args.output, args.resume));
    // What is there was made by these models, and goes on by them.
    let kept = match &mut sequence {
        Some(sequence) => sequence.resume(&scene, &environment)?,
        None => None,
    };
    let is_there = |number: u32| sequence.as_ref().is_some_and(|all| all.has(number));
    let missing: Vec<u32> = (0..frames).filter(|number| !is_there(*number)).collect();
    if missing.is_empty() {
        eprintln!("all {frames} frames are there");
        return Ok(Answer::Yes);
    }
    let device = args.device.open()?;
    let choice = match kept {
        Some(kept) => kept,
        None => resolve(&device, &scene.film.frame(&scene, 0), &environment)?,
    };
    let plan = plan_by(&scene, choice.as_ref(), output)?;
    say_doubt(&plan);
    if args.resume && plan.simulation == Simulation::Stored {
        anyhow::bail!(
            "--resume: stored positions come from the frame before; render from the beginning, or \
             with --simulation integer"
        );
    }
    let mut renderer =
        waiting("preparing the renderer", || Renderer::new(&device, &scene, &environment, &plan))?;
    if let Some(sequence) = &sequence {
        sequence.begin(&scene, &environment, choice.as_ref())?;
    }
    if sequence.is_some() {
        heed_interrupts()?;
    }

    let bar = progress(missing.len() as u64, "frames");
    let mut report = FrameReport::default();
    for (done, number) in missing.iter().enumerate() {
        if is_interrupted() {
            let left = missing.len() - done;
            anyhow::bail!("interrupted: {left} of {frames} frames are missing; --resume goes on");
        }
        renderer.submit(&scene.film.frame(&scene, *number))?;
        report = renderer.finish()?;
        let path = sequence.as_ref().map_or(args.output.clone(), |all| all.path(*number));
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
    eprintln!("{}, {} in view", drops(scene.drop_count().into()), report.counts.visible);
    super::say_undrawn(&report.counts);
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}
