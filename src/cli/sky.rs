//! `raindrops sky`: writes the sky that the program computes, which is also the bundled one.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;

use super::tell::say;
use super::{Answer, Format};
use crate::environment::sky::{BUNDLED_WIDTH, ELEVATIONS, Sun, picture};

/// Write the computed sky as an environment
///
/// It is latitude-longitude: .exr (float16), or .png (clipped at 1, 8 bit).
#[derive(Args)]
pub struct SkyArgs {
    /// File to write
    #[arg(short, long, value_name = "FILE", default_value = "sky.exr")]
    output: PathBuf,
    /// Size in texels, twice as wide as high [default: 512x256]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<u32>,
    /// Texels across, an older name
    #[arg(long, hide = true, value_name = "N", value_parser = parse_width, conflicts_with = "size")]
    width: Option<u32>,
    /// The sun's height above the horizon, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = Sun::default().elevation,
          value_parser = |text: &str| parse_degrees(text, ELEVATIONS))]
    sun_elevation: f64,
    /// The sun's direction, degrees to the right of -z; 180 is behind a camera that looks along -z
    #[arg(long, value_name = "DEGREES", default_value_t = Sun::default().azimuth, allow_negative_numbers = true,
          value_parser = |text: &str| parse_degrees(text, -360.0..=360.0))]
    sun_azimuth: f64,
}

/// Runs the command.
pub fn run(args: &SkyArgs) -> anyhow::Result<Answer> {
    let format = Format::of(&args.output)?;
    let sun = Sun { elevation: args.sun_elevation, azimuth: args.sun_azimuth };
    let sky = picture(args.size.or(args.width).unwrap_or(BUNDLED_WIDTH), sun);
    match format {
        Format::Exr => super::write_half(&sky, &args.output)?,
        // Low dynamic range: radiance over 1 clips, as in a photograph.
        Format::Png => sky.write_png(&args.output)?,
    }
    say!("wrote {} ({} x {})", args.output.display(), sky.width, sky.height);
    Ok(Answer::Yes)
}

/// `2048x1024` to 2048.
fn parse_size(text: &str) -> Result<u32, String> {
    let (width, height) = text.split_once(['x', 'X']).ok_or("not a size like 2048x1024")?;
    let width = parse_width(width)?;
    match height.parse::<u32>() {
        Ok(height) if width == 2 * height => Ok(width),
        _ => Err(format!("not twice as wide as high, such as {width}x{}", width / 2)),
    }
}

fn parse_width(text: &str) -> Result<u32, String> {
    let limits = 16..=crate::environment::MAX_WIDTH;
    match text.parse() {
        Ok(width) if limits.contains(&width) && width % 2 == 0 => Ok(width),
        _ => Err(format!("not an even number from {} to {}", limits.start(), limits.end())),
    }
}

fn parse_degrees(text: &str, within: RangeInclusive<f64>) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if within.contains(&degrees) => Ok(degrees),
        _ => Err(format!("not within {} to {} degrees", within.start(), within.end())),
    }
}
