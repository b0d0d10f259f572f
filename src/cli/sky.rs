//! `raindrops sky`: writes the sky that the program computes, which is also the bundled one.

use std::path::PathBuf;

use clap::Args;

use super::{Answer, Format};
use crate::environment::sky::{BUNDLED_WIDTH, ELEVATIONS, Sun, picture};
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
    /// The sun's height above the horizon, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = Sun::default().elevation, value_parser = parse_elevation)]
    sun_elevation: f64,
    /// Where the sun is, degrees to the right of -z; behind a camera that looks along -z: 180
    #[arg(long, value_name = "DEGREES", default_value_t = Sun::default().azimuth, allow_negative_numbers = true,
          value_parser = parse_azimuth)]
    sun_azimuth: f64,
}

/// Runs the command.
pub fn run(args: &SkyArgs) -> anyhow::Result<Answer> {
    let format = Format::of(&args.output)?;
    let sun = Sun { elevation: args.sun_elevation, azimuth: args.sun_azimuth };
    let sky = picture(args.width, sun);
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

fn parse_elevation(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if ELEVATIONS.contains(&degrees) => Ok(degrees),
        _ => Err(format!("not within {} to {} degrees", ELEVATIONS.start(), ELEVATIONS.end())),
    }
}

fn parse_azimuth(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if (-360.0..=360.0).contains(&degrees) => Ok(degrees),
        _ => Err("not within -360 to 360 degrees".into()),
    }
}
