//! `raindrops pane`: the drops on a scene's pane.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::options::SceneArgs;
use super::rain::line;
use super::tell::{note, warning};
use super::{Answer, print};
use crate::files::write_whole;
use crate::optics::Cap;
use crate::pane::population::Tally;
use crate::pane::retention::Retention;
use crate::scene::Scene;
use crate::scene::pane::{Pane, PaneDrop};
use crate::thousands::thousands;

/// Print the drops on a scene's pane, and figures of them
#[derive(Args)]
#[command(after_help = "Example:
  raindrops pane assets/scenes/window.toml -o drops.toml")]
pub struct PaneArgs {
    /// Write the drops as `[[pane.drop]]`, in scene units, for a scene file or another tracer
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
}

/// Runs the command.
pub fn run(args: &PaneArgs) -> anyhow::Result<Answer> {
    let scene = args.scene.load()?;
    let Some(pane) = &scene.pane else {
        bail!("{} has no pane: give [pane], with point and normal or distance", args.scene.name());
    };
    super::check_folders([&args.output])?;
    let mut rained = scene.pane_population();
    if let Some(rained) = &mut rained {
        rained.go_on_to(pane.age());
    }
    let drops = scene.pane_drops_of(rained.as_ref());
    show_drops(&scene, pane, &drops)?;
    if let Some(rained) = &rained {
        show_rain(&scene, pane, rained.tally)?;
    }
    if let Some(file) = &args.output {
        write_whole(file, listed(&drops)?.as_bytes())?;
    }
    Ok(Answer::Yes)
}

/// The drops as text of a scene file.
fn listed(drops: &[PaneDrop]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for PaneDrop { at, radius, contact_angle } in drops {
        write!(text, "[[pane.drop]]\nat = [{:?}, {:?}]\nradius = {radius:?}\n", at.x, at.y)?;
        if let Some(angle) = contact_angle {
            writeln!(text, "contact_angle = {angle:?}")?;
        }
        text.push('\n');
    }
    Ok(text)
}

/// Figures of the drops that are there.
fn show_drops(scene: &Scene, pane: &Pane, drops: &[PaneDrop]) -> crate::Result<()> {
    print(format_args!("{:24} {:>12}", "drops", thousands(drops.len() as u64)))?;
    let of_discs = |value: &dyn Fn(&PaneDrop) -> f64| {
        let discs = drops.iter().map(|drop| drop.radius * drop.radius);
        let sum: f64 = drops.iter().map(|drop| value(drop) * drop.radius * drop.radius).sum();
        if drops.is_empty() { 0.0 } else { sum / discs.sum::<f64>() }
    };
    let millimetres = 1e3 * scene.metres;
    let radii: f64 = drops.iter().map(|drop| drop.radius).sum();
    line("mean contact radius", millimetres * radii / drops.len().max(1) as f64, "mm")?;
    if pane.has_population()
        && let Ok((from, to)) = scene.pane_extent()
    {
        let area = (to - from).element_product();
        let discs: f64 = drops.iter().map(|drop| PI * (drop.radius * scene.metres).powi(2)).sum();
        line("cover", discs / area, "of the pane's extent")?;
        line("drops a cm²", drops.len() as f64 / (1e4 * area), "")?;
    }
    let (Some(face), index) = (scene.pane_face(), scene.indices()[1]) else { return Ok(()) };
    let eye = face.to_local(scene.camera.position - face.point);
    let dark = |drop: &PaneDrop| {
        let cap = Cap { radius: drop.radius, angle: pane.angle_of(drop) };
        cap.dark_share((drop.at.extend(0.0) - eye).normalize(), index)
    };
    line("total reflection", of_discs(&dark), "of the discs, as the camera sees them")
}

/// Figures of the rain that made them.
fn show_rain(scene: &Scene, pane: &Pane, tally: Tally) -> crate::Result<()> {
    let (Some(face), [advancing, receding]) = (scene.pane_face(), pane.angles()) else {
        return Ok(());
    };
    let flux = scene.pane_flux();
    let of_flux =
        |value: &dyn Fn(&crate::pane::arrivals::Flux) -> f64| flux.as_ref().map_or(0.0, value);
    if of_flux(&|flux| flux.number()) == 0.0 {
        warning!(
            "pane: no rain reaches the wet face: nothing falls (rate), or the pane moves away from it (velocity, wind, normal)"
        );
    }
    line("arriving", 1e-4 * of_flux(&|flux| flux.number()), "drops a cm² and second")?;
    line("arriving", of_flux(&|flux| flux.water()), "mm/h")?;
    line("κ", of_flux(&|flux| flux.cover(pane.contact_angle)), "contact area a second")?;
    let slides = Retention::new(face.slope_sine(), [advancing, receding]);
    let volume = slides.critical_volume(pane.contact_angle);
    if volume.is_finite() {
        line("slides from", 1e9 * volume, "mm³ on")?;
        line(
            "that is from",
            1e3 * Cap::of_volume(volume, pane.contact_angle).radius,
            "mm of contact radius on",
        )?;
    } else {
        note!("pane: it is level: no drop slides");
    }
    match tally.first_slide {
        Some(time) => line("first slide", time, "s after it was wiped")?,
        None => print(format_args!("{:24} {:>12} within {} s", "first slide", "none", pane.age()))?,
    }
    line("water that came", 1e9 * tally.water_in, "mm³")?;
    line("water that left", 1e9 * tally.water_out, "mm³")
}
