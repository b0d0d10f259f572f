//! `raindrops reference`: a scene by the float64 ray tracer.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use glam::Vec3;

use super::options::{BackgroundArgs, SceneArgs};
use super::tell::note;
use super::{Answer, Format, progress};
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::picture::tone_map;
use crate::reference::{Tracer, Truth, Weights, usual_bound};
use crate::scene::Scene;
use crate::scene::camera::WHOLE;

/// Steps of the progress bar.
const STEPS: f64 = 1000.0;

/// Trace the scene with a float64 ray tracer on the CPU
///
/// The result is what other pictures are compared with: docs/truth.md.
#[derive(Args)]
#[command(after_help = "Example:
  raindrops reference assets/scenes/drop.toml --size 256x256 --samples 64 -o truth.exr")]
pub struct ReferenceArgs {
    /// Frame of the scene's film, from 0 on [default: the scene at its time]
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Frames a second of the film, as for render [default: the film's, or 30]
    #[arg(long, value_name = "F", allow_negative_numbers = true, requires = "frame")]
    fps: Option<f64>,
    /// Picture to write: .exr linear radiance in float32, .png tone mapped
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = Truth::default().samples,
          value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    samples: u32,
    /// Highest number of reflections inside a drop that is followed
    #[arg(long, value_name = "K", default_value_t = Truth::default().internal_reflections,
          value_parser = clap::value_parser!(u32).range(0..=1000))]
    internal_reflections: u32,
    /// Weights of light after reflections. physical: F and (1-F)² F^k; conserving: the last reflection carries the rest;
    /// paper: F and 1-F, without internal reflections
    #[arg(long, value_enum, value_name = "NAME", default_value = "physical")]
    weights: Weights,
    /// Leave out the light that drops reflect on the outside
    #[arg(long)]
    no_reflection: bool,
    /// Let light that leaves a drop pass through this many further drops
    #[arg(long, value_name = "N", default_value_t = 0,
          value_parser = clap::value_parser!(u32).range(0..=16))]
    drops_see_drops: u32,
    /// Do not compute the images of small bright sources in drops: samples then meet them by chance
    #[arg(long)]
    no_glints: bool,
    /// Distance to which real rain is traced drop by drop, beyond it a medium [default: as far as the picture
    /// holds 30 million drops: 32 m of 25 mm/h at 60 degrees]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, value_parser = parse_distance)]
    rain_to: Option<f64>,
    /// Seed of the samples' places (--seed is that of the drops)
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample_seed: u64,
    /// Also write which part of each pixel drops cover, as EXR, for `compare --mask`; a medium covers nothing
    #[arg(long, value_name = "FILE")]
    coverage: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    background: BackgroundArgs,
}

/// Traces the scene and writes the picture.
pub fn run(args: &ReferenceArgs) -> anyhow::Result<Answer> {
    // A long computation must not end in a name that cannot be written.
    let format = Format::of(&args.output)?;
    if let Some(path) = &args.coverage
        && Format::of(path)? != Format::Exr
    {
        bail!("--coverage {}: write it as .exr", path.display());
    }
    let mut scene = args.scene.load()?;
    args.background.apply(&mut scene)?;
    if let Some(fps) = args.fps {
        scene.film.fps = fps;
        scene.validate("--fps")?;
    }
    if let Some(number) = args.frame {
        scene = scene.film.frame(&scene, number);
        if scene.pane.is_some() {
            // A camera on its way may come through a pane that stands.
            scene.validate(&format!("frame {number}"))?;
        }
        scene.read_particles()?;
    }
    let plate = Plate::of(&scene)?;
    if format == Format::Png && scene.camera.window != WHOLE && scene.tone_map.derives_exposure() {
        bail!(
            "{}: the exposure of a window is the whole picture's, which is not traced; give --exposure, or \
             write .exr",
            args.output.display()
        );
    }
    let environment = super::open_environment(&scene)?;
    let truth = Truth {
        samples: args.samples,
        seed: args.sample_seed,
        internal_reflections: args.internal_reflections,
        weights: args.weights,
        reflection: !args.no_reflection,
        drops_see_drops: args.drops_see_drops,
        glints: !args.no_glints,
        rain_to: args.rain_to,
    };
    say_rain(&scene, args)?;
    super::say_depth_alone(&scene);
    let bar = progress(STEPS as u64, "%");
    let tracer = Tracer::new(&scene, &environment, truth).before(plate);
    let traced = tracer.trace(&|share| bar.set_position((share * STEPS) as u64));
    bar.finish_and_clear();

    match format {
        Format::Exr => traced.picture.write_exr(&args.output)?,
        Format::Png => {
            let exposure = tone_map::exposure_of(&scene.tone_map, &traced.picture);
            tone_map::display(exposure, &traced.picture).write_png(&args.output)?;
        }
    }
    if let Some(path) = &args.coverage {
        let pixels = traced.coverage.iter().map(|&share| Vec3::splat(share)).collect();
        Picture { pixels, ..traced.picture }.write_exr(path)?;
    }
    Ok(Answer::Yes)
}

/// A distance in metres, 0 included.
fn parse_distance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(metres) if metres >= 0.0 => Ok(metres),
        _ => Err("give metres, 0 or more".into()),
    }
}

/// Says how real rain is traced, or why it cannot be.
fn say_rain(scene: &Scene, args: &ReferenceArgs) -> anyhow::Result<()> {
    let Some((rain, bound)) = scene.real_rain().zip(usual_bound(scene)) else {
        if args.rain_to.is_some() {
            bail!("--rain-to is for real rain; give --rate 25, or a scene with rain.rate");
        }
        return Ok(());
    };
    if args.drops_see_drops > 0 {
        bail!(
            "--drops-see-drops: drops of real rain are not held in memory, and show the environment only"
        );
    }
    let bound = args.rain_to.unwrap_or(bound);
    if bound.is_infinite() && rain.extent.is_infinite() {
        bail!("--rain-to inf: this rain has no end; give metres, or --extent");
    }
    if bound < rain.extent {
        note!(
            "rain is traced drop by drop to {bound:.1} m, beyond it as a medium; it may take minutes \
             (--rain-to {:.0} is quicker)",
            (0.5 * bound).max(1.0)
        );
    }
    Ok(())
}
