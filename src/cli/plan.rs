//! `raindrops plan`: which passes and models the scene requires, and why.

use clap::Args;

use super::options::{BackgroundArgs, ModelArgs, SceneArgs};
use super::{Answer, plain, print, say_doubt};
use crate::plan::{Axes, Output, plan};

/// Print which passes and models a scene needs, and why
#[derive(Args)]
pub struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    background: BackgroundArgs,
    #[command(flatten)]
    model: ModelArgs,
}

/// Runs the command.
pub fn run(args: &PlanArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    args.background.apply(&mut scene)?;
    let environment = super::open_environment(&scene)?;
    let plan = plan(&scene, &environment, Output::Display)?;
    say_doubt(&plan);
    for (name, value) in Axes::of(&scene, &plan).values() {
        let why = match name.as_str() {
            "preset" => plan.why.as_deref(),
            "cutoff_px" => plan.cutoff.as_ref().map(|cutoff| cutoff.why.as_str()),
            "shape" => Some(plan.shape.why.as_str()),
            _ => None,
        };
        let why = why.map_or(String::new(), |why| format!(": {why}"));
        print(format_args!("{name:21} {}{why}", plain(&value)))?;
    }
    print("passes")?;
    for (name, reason) in &plan.passes {
        print(format_args!("  {name:14} {reason}"))?;
    }
    Ok(Answer::Yes)
}
