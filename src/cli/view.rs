//! `raindrops view`: a window onto the rain.

use std::path::PathBuf;

use clap::Args;

use super::Answer;
use super::device::{DeviceArgs, wanted_machine};
use super::options::{ModelArgs, SceneArgs};
use super::tell::{Kind, line, note, remark};
use crate::gpu::Validation;
use crate::scene::camera::WHOLE;
use crate::view::{Options, run as open_window};

/// Open a window: fly, stop time, change models, see their times
///
/// Keys: W A S D Q E fly, arrows or dragging look around, Space stops time, comma and full stop
/// step, [ and ] slow down and speed up, R runs backwards, F flies up to a drop, 1 2 3 4 choose the
/// preset, B puts a second model beside it, F12 keeps a screenshot, Ctrl S a scene file, H hides the
/// panel, which lists them all, Esc closes. Drop an environment image or a scene file on it.
#[derive(Args)]
pub struct ViewArgs {
    /// Begin with time stopped
    #[arg(long)]
    paused: bool,
    /// Begin without the panel
    #[arg(long)]
    no_panel: bool,
    /// Do not wait for the screen: draw as many frames as the device can
    #[arg(long)]
    no_vsync: bool,
    /// Folder for screenshots and scene files
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &ViewArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    if scene.camera.window != WHOLE {
        note!("the window shows the whole picture, not the scene's camera.window");
        scene = scene.whole();
    }
    if !args.output.is_dir() {
        anyhow::bail!("--output {}: there is no such folder", args.output.display());
    }
    open_window(Options {
        scene,
        name: args.scene.name(),
        device: args.device.device.clone(),
        machine: wanted_machine()?,
        validation: if args.device.validate { Validation::On } else { Validation::Off },
        paused: args.paused,
        panel: !args.no_panel,
        vsync: !args.no_vsync,
        keep_in: args.output.clone(),
        say: |text| line(Kind::Progress, text),
        remark,
    })?;
    Ok(Answer::Yes)
}
