//! `raindrops sky`: writes the sky that the program computes, which is also the bundled one.

use std::path::PathBuf;

use clap::Args;

use super::{Answer, Format};
use crate::environment::sky::{BUNDLED_WIDTH, picture};
use crate::picture::{srgb_byte, write_png};

/// Write the computed sky, latitude-longitude: .exr (float16) or .png (clipped at 1, 8 bit)
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
    let format = Format::of(&args.output)?;
    let sky = picture(args.width);
    match format {
        Format::Exr => sky.write_exr_f16(&args.output)?,
        // Low dynamic range: radiance over 1 clips, as in a photograph.
        Format::Png => {
            let bytes: Vec<u8> =
                sky.pixels.iter().flat_map(|p| p.to_array().map(srgb_byte)).collect();
            write_png(&args.output, sky.width, sky.height, &bytes)?;
        }
    }
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
