//! `raindrops plan`: which passes and models the scene requires, and why.

use clap::Args;

use super::options::{ModelArgs, SceneArgs};
use super::{Answer, print};
use crate::plan::{Output, plan};

/// Say which passes and models the scene requires, and why
#[derive(Args)]
pub struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    model: ModelArgs,
}

/// Runs the command.
pub fn run(args: &PlanArgs) -> anyhow::Result<Answer> {
    let mut scene = args.scene.load()?;
    args.model.apply(&mut scene)?;
    let plan = plan(&scene, Output::Display)?;
    print(format_args!("preset      {}", plan.preset))?;
    print(format_args!("optics      {}, {} texels an edge", plan.optics, plan.mask_size))?;
    print(format_args!("primitive   {}", plan.primitive))?;
    print(format_args!("order       {}", plan.order))?;
    print(format_args!("simulation  {}", plan.simulation))?;
    print("passes")?;
    for (name, reason) in &plan.passes {
        print(format_args!("  {name:14} {reason}"))?;
    }
    Ok(Answer::Yes)
}
