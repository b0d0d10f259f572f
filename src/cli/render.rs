//! `raindrops render`: one frame or a numbered sequence, as EXR or PNG.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::device::resolve;
use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::PictureArgs;
use super::rounds::stages::{self, paper_stages};
use super::sequence::Sequence;
use super::tell::{detail, note, say, warning};
use super::{Answer, Format, progress, say_doubt, waiting};
use crate::passes::counters::Counts;
use crate::picture::layers::Layers;
use crate::picture::sidecar::Sidecar;
use crate::picture::{Picture, write_png};
use crate::plan::{Cutoff, FramePlan, Output, plan_by};
use crate::renderer::parts::{Grid, HALVES, Parts};
use crate::renderer::{FrameReport, Renderer};
use crate::scene::model::{Operator, Simulation};
use crate::scene::{ImageSize, Scene};
use crate::thousands::{counted, thousands};

/// Draw one frame, or a numbered sequence
#[derive(Args)]
#[command(after_help = "Examples:
  raindrops render assets/scenes/dusk.toml -o dusk.png
  raindrops render --drops 200000 --preset exact --size 640x360 -o rain.exr
  raindrops render assets/scenes/film.toml -o film/rain.png --resume")]
pub struct RenderArgs {
    /// Picture to write: .exr (linear radiance, float32) or .png (tone mapped, sRGB, 8 bit)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of frames [default: the film's]. Over 1, files are numbered: rain.png becomes rain-0000.png …
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Draw one frame of the film or sequence alone, from 0 on, into a file without a number
    #[arg(long, value_name = "N", conflicts_with_all = ["frames", "resume"], value_parser = clap::value_parser!(u32).range(..i64::from(u32::MAX)))]
    frame: Option<u32>,
    /// Frames a second; negative runs backwards, from the last key if there are any [default: the film's, or 30]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Draw the picture in this many parts, with the same result: for pictures larger than the device's images
    #[arg(long, value_name = "CxR", value_parser = parse_grid)]
    tiles: Option<Grid>,
    /// Write the rain without background, for a compositor: premultiplied, with depth, motion, number and count of
    /// drops at each pixel, and a .json file with camera and drops
    #[arg(long)]
    layers: bool,
    /// Write the stages of the paper's frame of it, for another process of this program
    #[arg(long, value_name = "FILE", hide = true)]
    stages: Option<PathBuf>,
    /// Keep the frames of this scene that exist, and draw the others
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    picture: PictureArgs,
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> anyhow::Result<Answer> {
    let mut scene = args.picture.load()?;
    if let Some(fps) = args.fps {
        scene.film.fps = fps;
        scene.validate("--fps")?;
    }
    let output = output_of(args)?;
    let environment = super::open_environment(&scene)?;
    let frames = match args.frame {
        Some(_) => 1,
        None => args.frames.unwrap_or_else(|| scene.film.frames()),
    };
    let mut sequence =
        (frames > 1).then(|| Sequence::new(&args.output, args.resume, args.layers, frames));
    // What is there was made by these models, and goes on by them.
    let kept = match &mut sequence {
        Some(sequence) => sequence.resume(&scene, &environment)?,
        None => None,
    };
    let is_there = |number: u32| sequence.as_ref().is_some_and(|all| all.has(number));
    let first = args.frame.unwrap_or(0);
    let missing: Vec<u32> =
        (first..first.saturating_add(frames)).filter(|number| !is_there(*number)).collect();
    if missing.is_empty() {
        say!("{} made already", counted(frames.into(), "frame"));
        return Ok(Answer::Yes);
    }
    if output == Output::Layers && scene.placed().any(|drop| drop.id == Some(u32::MAX)) {
        note!("a particle of id 0 is number {} in layers, where 0 is no drop", u32::MAX);
    }
    // A sequence that ends early is refused before anything is written.
    scene.find_particles(missing.iter().copied())?;
    let device = args.picture.device.open()?;
    if let Some(path) = &args.stages
        && let Some((stages, picture)) = paper_stages(&device, &scene, &environment)?
    {
        stages::write(path, &stages, &picture)?;
    }
    let choice = match kept {
        Some(kept) => kept,
        None => resolve(&device, &scene.film.frame(&scene, 0).whole(), &environment)?,
    };
    let plan = plan_by(&scene, &environment, choice.as_ref(), output)?;
    say_doubt(&plan);
    plan.passes.iter().for_each(|(name, reason)| detail!("pass {name}: {reason}"));
    if (args.resume || first > 0) && plan.simulation == Simulation::Stored {
        anyhow::bail!(
            "{}: stored positions come from the frame before; render from the beginning, or with --simulation integer",
            if args.resume { "--resume" } else { "--frame" }
        );
    }
    let mut parts = Parts::new(&device, &environment, &plan);
    if args.tiles.is_none() {
        waiting("preparing the renderer", || parts.prepare(&scene))?;
    }
    if output != Output::Layers {
        super::say_depth_alone(&scene);
    }
    if output == Output::Display {
        say_curve_on_photograph(&scene)?;
    }
    if let Some(sequence) = &sequence {
        sequence.begin(&scene, &environment, choice.as_ref())?;
    }
    if sequence.is_some() {
        heed_interrupts()?;
    }

    let drawn =
        draw(args, &scene, (&missing, frames), sequence.as_ref(), &mut parts, &plan, output)?;
    tell(&scene, &plan, &drawn);
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

/// Says on stderr that a photograph will not keep its colours.
fn say_curve_on_photograph(scene: &Scene) -> crate::Result<()> {
    if let Some(file) = &scene.background.color
        && scene.tone_map.operator == Operator::Photographic
        && Picture::is_display(file)?
    {
        note!(
            "the background is a picture of 8 bits, which the tone mapping changes; --tone-map none keeps its colours"
        );
    }
    Ok(())
}

/// What is drawn, by the picture's name.
fn output_of(args: &RenderArgs) -> anyhow::Result<Output> {
    Ok(match (Format::of(&args.output)?, args.layers) {
        (Format::Exr, false) => Output::Radiance,
        (Format::Exr, true) => Output::Layers,
        (Format::Png, false) => Output::Display,
        (Format::Png, true) => {
            anyhow::bail!("{}: layers are written as .exr", args.output.display())
        }
    })
}

/// What became of all frames.
struct Drawn {
    last: FrameReport,
    undrawn: Counts,
    /// The largest of all, as is the cut-off.
    room: u32,
    cutoff_px: f32,
}

/// Draws and writes the frames of these numbers, of so many in all.
fn draw(
    args: &RenderArgs,
    scene: &Scene,
    (missing, frames): (&[u32], u32),
    sequence: Option<&Sequence>,
    parts: &mut Parts<'_>,
    plan: &FramePlan,
    output: Output,
) -> anyhow::Result<Drawn> {
    if let (Some(all), [first, .., last]) = (sequence, missing) {
        let (first, last) = (all.path(*first), all.path(*last));
        say!(
            "{} to write: {} to {}",
            counted(missing.len() as u64, "frame"),
            first.display(),
            last.display()
        );
    }
    let bar = progress(missing.len() as u64, "frames");
    let (last, undrawn) = (FrameReport::default(), Counts::default());
    let mut drawn = Drawn { last, undrawn, room: 1, cutoff_px: 0.0 };
    let mut grid = args.tiles;
    for (done, number) in missing.iter().enumerate() {
        if is_interrupted() {
            let left = missing.len() - done;
            let left =
                format!("{left} of {} missing; --resume goes on", counted(frames.into(), "frame"));
            return Err(Interrupted).context(left);
        }
        let mut frame = scene.film.frame(scene, *number);
        frame.read_particles()?;
        let until_frame = scene.motion_end(&frame, *number);
        let until = (until_frame.time, plan.cutoff.as_ref().map_or(0.0, Cutoff::single_px));
        parts.move_until(until_frame);
        let path = sequence.map_or(args.output.clone(), |all| all.path(*number));
        let whole = match grid {
            Some(_) => None,
            None => draw_whole(parts, &frame, until, output, &path)?,
        };
        let report = match whole {
            Some(report) => report,
            None => {
                // Where one lacks room, the frames after it are like it.
                let grid = *grid.get_or_insert(HALVES);
                draw_parts(parts, &frame, until, grid, output, &path)?
            }
        };
        drawn.cutoff_px = drawn.cutoff_px.max(report.cutoff_px.unwrap_or(0.0));
        drawn.undrawn.add(&report.counts);
        drawn.room = drawn.room.max(report.room);
        drawn.last = report;
        if let (0, Some(most)) = (done, parts.clips_background()) {
            warning!(
                "the background is brighter than {most}, which is clipped: it is stored as the environment is"
            );
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(drawn)
}

/// Draws a picture at once and writes it; `None` if the device has no room for it, and parts of it can be drawn.
fn draw_whole(
    parts: &mut Parts<'_>,
    frame: &Scene,
    until: (f64, f64),
    output: Output,
    path: &Path,
) -> crate::Result<Option<FrameReport>> {
    let can_part = parts.can_part(frame);
    let (renderer, report) = parts.draw_window(frame)?;
    if report.lacks_room() && can_part {
        note!("more on the picture's tiles than the device has room for at once: drawn in parts");
        return Ok(None);
    }
    write(renderer, frame, until, output, path)?;
    Ok(Some(report))
}

/// Says what was drawn and what was not.
fn tell(scene: &Scene, plan: &FramePlan, drawn: &Drawn) {
    let all = match scene.real_rain() {
        Some(rain) => format!("rain of {} mm/h", rain.rate),
        None => counted(scene.drop_count().into(), "drop"),
    };
    say!(
        "{all}, {} in view (hidden ones and those under a pixel included)",
        thousands(drawn.last.counts.visible)
    );
    drawn.last.passes_ms.iter().for_each(|(name, ms)| detail!("pass {name}: {ms:.2} ms"));
    super::say_undrawn(&drawn.undrawn, drawn.room);
    let planned = plan.cutoff.as_ref().map_or(0.0, |cutoff| cutoff.px as f32);
    if drawn.cutoff_px > planned {
        note!(
            "drops under {} px of radius are part of the medium, not only those under {planned} px: \
             more cells of the rain than can be numbered",
            drawn.cutoff_px
        );
    }
}

/// `2x2` to a grid of parts.
pub(super) fn parse_grid(text: &str) -> Result<Grid, String> {
    let number = |text: &str| text.parse().ok().filter(|number: &u32| *number > 0);
    text.split_once(['x', 'X'])
        .and_then(|(columns, rows)| Some(Grid { columns: number(columns)?, rows: number(rows)? }))
        .ok_or_else(|| format!("'{text}' is not a number of parts like 2x2"))
}

/// Writes layers, and before them what stands beside them: where layers are, all of it is.
pub(super) fn write_layers(
    layers: &Layers,
    scene: &Scene,
    (until, cutoff_px): (f64, f64),
    path: &Path,
) -> crate::Result<usize> {
    let beside = Sidecar::of(scene, until, cutoff_px);
    beside.write(&path.with_extension("json"))?;
    layers.write_exr(path)?;
    Ok(beside.drops.len())
}

/// Writes what a renderer has drawn.
fn write(
    renderer: &Renderer,
    scene: &Scene,
    until: (f64, f64),
    output: Output,
    path: &Path,
) -> crate::Result<()> {
    match output {
        Output::Layers => write_layers(&renderer.read_layers()?, scene, until, path).map(|_| ()),
        Output::Radiance => renderer.read_radiance()?.write_exr(path),
        Output::Display => {
            let (width, height) = scene.picture_size();
            write_png(path, width, height, &renderer.read_display()?)
        }
    }
}

/// Draws a picture part by part and writes it whole.
fn draw_parts(
    parts: &mut Parts<'_>,
    scene: &Scene,
    until: (f64, f64),
    grid: Grid,
    output: Output,
    path: &Path,
) -> crate::Result<FrameReport> {
    match output {
        Output::Layers => {
            let (layers, report) = parts.layers_by(scene, grid)?;
            write_layers(&layers, scene, until, path)?;
            Ok(report)
        }
        Output::Radiance => {
            let (radiance, report) = parts.radiance_by(scene, grid)?;
            radiance.write_exr(path)?;
            Ok(report)
        }
        Output::Display => {
            let (shown, report) = parts.display_by(scene, grid)?;
            let ImageSize { width, height } = scene.image;
            write_png(path, width, height, &shown)?;
            Ok(report)
        }
    }
}
