//! `raindrops sky`: writes the sky that the program computes, which is also the bundled one.

use std::path::PathBuf;

use clap::Args;

use super::Answer;
use crate::sky::{BUNDLED_WIDTH, picture};

/// Write the computed sky: a latitude-longitude EXR, float16
#[derive(Args)]
pub struct SkyArgs {
    /// File to write
    #[arg(short, long, value_name = "FILE", default_value = "sky.exr")]
    output: PathBuf,
    /// Texels across, twice those down
    #[arg(long, value_name = "N", default_value_t = BUNDLED_WIDTH, value_parser = parse_width)]
    width: u32,
}

/// Runs the command.
pub fn run(args: &SkyArgs) -> anyhow::Result<Answer> {
    let sky = picture(args.width);
    sky.write_exr_f16(&args.output)?;
    eprintln!("wrote {} ({} x {})", args.output.display(), sky.width, sky.height);
    Ok(Answer::Yes)
}

fn parse_width(text: &str) -> Result<u32, String> {
    let limits = 16..=crate::environment::MAX_WIDTH;
    match text.parse() {
        Ok(width) if limits.contains(&width) && width % 2 == 0 => Ok(width),
        _ => Err(format!("not an even number from {} to {}", limits.start(), limits.end())),
    }
}
