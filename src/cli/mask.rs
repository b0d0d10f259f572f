//! `raindrops mask`: the mask's levels as EXR and as the paper's Figure 5, and Table I.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use glam::Vec3;

use super::device::DeviceArgs;
use super::{Answer, print, progress};
use crate::optics::{level_distance, level_half_angle};
use crate::passes::mask::{Mask, MaskLevel};
use crate::picture::Picture;
use crate::plan::Light;
use crate::scene::model::Optics;
use crate::{Error, Result};

/// Write the paper's mask, level by level, and print Table I
#[derive(Args)]
pub struct MaskArgs {
    /// Folder to write into; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Storage of the mask
    #[arg(long, value_name = "NAME", default_value_t = Optics::Mask, value_parser = masks())]
    optics: Optics,
    /// Edge of the finest level in texels
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = parse_size)]
    mask_size: u32,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &MaskArgs) -> anyhow::Result<Answer> {
    let device = args.device.open()?;
    let mask = Mask::trace(&device, args.mask_size, args.optics, &Light::default())?;
    std::fs::create_dir_all(&args.output).map_err(|error| Error::write(&args.output, error))?;
    print("level  texels  aperture angle  drop distance")?;
    let bar = progress(u64::from(mask.image.levels), "levels");
    let mut chain = Vec::new();
    for level in 0..mask.image.levels {
        print(format_args!(
            "{level:5}  {:6}  {:13.4}°  {:13.4}",
            args.mask_size >> level,
            level_half_angle(level).to_degrees(),
            level_distance(level)
        ))?;
        let texels = mask.read(&device, level)?;
        write_level(args, level, &texels)?;
        chain.push(texels);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let folder = args.output.display();
    print(format_args!(
        "{folder}/figure-5.png shows them all: from above reflected, transmitted, reflectance, coverage, levels from left to right; \
         of a direction red is its x, green its y, blue its z (towards the camera), -1 to 1 as 0 to 1, as sRGB"
    ))?;
    print(format_args!(
        "{folder}/level-NN-NAME.exr has the numbers of a level, float32: any viewer of EXR, such as tev"
    ))?;
    figure_5(&chain).write_png(&args.output.join("figure-5.png"))?;
    print(format_args!(
        "{:.2} MB of texels ({}), {:.2} MB of device memory",
        mask.texel_bytes() as f64 / 1e6,
        args.optics,
        mask.image.bytes as f64 / 1e6
    ))?;
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

/// The four quantities of a level, each as a picture of its own.
fn write_level(args: &MaskArgs, level: u32, texels: &MaskLevel) -> Result<()> {
    let size = args.mask_size >> level;
    for (name, pixel) in QUANTITIES {
        let pixels = texels.reflection.iter().zip(&texels.transmission).map(|(r, t)| pixel(r, t));
        let picture = Picture { width: size, height: size, pixels: pixels.collect() };
        picture.write_exr(&args.output.join(format!("level-{level:02}-{name}.exr")))?;
    }
    Ok(())
}

/// A picture of one quantity, from a texel of the reflection and of the transmission layer.
type Quantity = fn(&[f32; 4], &[f32; 4]) -> Vec3;

const QUANTITIES: [(&str, Quantity); 4] = [
    ("reflected", |r, _| Vec3::new(r[0], r[1], r[2])),
    ("transmitted", |_, t| Vec3::new(t[0], t[1], t[2])),
    ("reflectance", |r, _| Vec3::splat(r[3])),
    ("coverage", |_, t| Vec3::splat(t[3])),
];

/// The paper's Figure 5: a row a quantity, its levels from left to right; directions from -1 to 1
/// as colours from 0 to 1, and black where nothing is covered.
fn figure_5(chain: &[MaskLevel]) -> Picture {
    const FIRST_EDGE: u32 = 256;
    // Start with the level that is at most so large.
    let first = chain.iter().position(|level| level.size <= FIRST_EDGE).unwrap_or(0);
    let edge = chain[first].size;
    let (width, height) = (2 * edge, 4 * edge);
    let mut pixels = vec![Vec3::ZERO; (width * height) as usize];
    for (row, (name, pixel)) in (0..).zip(QUANTITIES) {
        let mut left = 0;
        for level in &chain[first..] {
            for y in 0..level.size {
                for x in 0..level.size {
                    let at = (y * level.size + x) as usize;
                    let (r, t) = (&level.reflection[at], &level.transmission[at]);
                    let value = pixel(r, t);
                    let is_direction = matches!(name, "reflected" | "transmitted");
                    let color = if is_direction { 0.5 * value + 0.5 } else { value };
                    let covered = if name == "coverage" { 1.0 } else { t[3] };
                    pixels[((row * edge + y) * width + left + x) as usize] = color * covered;
                }
            }
            left += level.size;
        }
    }
    Picture { width, height, pixels }
}

/// The optics that have a mask, by name.
fn masks() -> impl TypedValueParser<Value = Optics> {
    let names = Optics::value_variants().iter().filter(|optics| optics.is_mask());
    PossibleValuesParser::new(names.filter_map(Optics::to_possible_value))
        .try_map(|name| Optics::from_str(&name, false))
}

fn parse_size(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(size) if size.is_power_of_two() && size <= 4096 => Ok(size),
        _ => Err("not a power of two from 1 to 4096".into()),
    }
}
