//! `raindrops plan`: which passes and models the scene requires, and why.

use clap::Args;

use super::options::{BackgroundArgs, ModelArgs, SceneArgs};
use super::{Answer, print, say_doubt};
use crate::plan::{Output, plan};

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
    let light = &plan.light;
    print(format_args!("preset      {}", plan.preset))?;
    if let Some(why) = &plan.why {
        print(format_args!("            {why}"))?;
    }
    match plan.optics.is_mask() {
        true => {
            print(format_args!("optics      {}, {} texels an edge", plan.optics, plan.mask_size))?
        }
        false => print(format_args!("optics      {}", plan.optics))?,
    }
    if let Some(cutoff) = &plan.cutoff {
        print(format_args!("cut-off     {} px of radius: {}", cutoff.px, cutoff.why))?;
    }
    print(format_args!("primitive   {}", plan.primitive))?;
    print(format_args!("order       {}", plan.order))?;
    print(format_args!("simulation  {}", plan.simulation))?;
    print(format_args!("samples     {} a pixel", plan.samples))?;
    let shape = &plan.shape;
    print(format_args!("shape       {}: {}", shape.model, shape.why))?;
    print(format_args!(
        "light       {} internal reflections, weights {}, fresnel {}, reflection {}, lookup {}",
        light.internal_reflections, light.weights, light.fresnel, light.reflection, light.lookup
    ))?;
    print("passes")?;
    for (name, reason) in &plan.passes {
        print(format_args!("  {name:14} {reason}"))?;
    }
    Ok(Answer::Yes)
}
