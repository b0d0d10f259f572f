//! `raindrops compare`: how far a picture is from the truth, as figures or as a check.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use glam::Vec3;
use serde_json::json;

use super::tell::{failure, remark_once};
use super::{Answer, Format, print_beside, write_json};
use crate::picture::metrics::{Comparison, Metrics, compare};
use crate::picture::read::{Decoded, Request};
use crate::picture::tone_map::{Exposure, exposure_of};
use crate::picture::{Picture, srgb_byte, write_png};
use crate::scene::model::Operator;
use crate::scene::{Scene, ToneMap};
use crate::thousands::thousands_of;

/// Print how far a picture is from the truth; check bounds
///
/// Without a bound it only prints. With bounds it exits with status 1 if one is exceeded.
#[derive(Args)]
#[command(after_help = "Example:
  raindrops compare truth.exr fast.exr --max-flip 0.05 --difference difference.png")]
pub struct CompareArgs {
    /// The truth: EXR or HDR (radiance), PNG or JPEG (display values)
    #[arg(value_name = "TRUTH")]
    a: PathBuf,
    /// The picture to compare with it, of the same kind and size
    #[arg(value_name = "PICTURE")]
    b: PathBuf,
    /// Exit with status 1 if the mean FLIP error is over this
    #[arg(long, value_name = "X")]
    max_flip: Option<f64>,
    /// Exit with status 1 if relMSE is over this
    #[arg(long, value_name = "X")]
    max_rel_mse: Option<f64>,
    /// Exit with status 1 if PSNR is under this, in decibels
    #[arg(long, value_name = "X")]
    min_psnr: Option<f64>,
    /// Exit with status 1 if a channel of a pixel errs by more than this, in linear radiance
    #[arg(long, alias = "max-error", value_name = "X")]
    max_channel_error: Option<f64>,
    /// Take relMSE and the largest error only over the pixels that are over 0 in this picture
    /// (`reference --coverage` writes one)
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    /// Layer of OpenEXR pictures of several [default: the finished picture]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Tone mapping operator before PSNR and FLIP, for radiance
    #[arg(long, value_enum, value_name = "NAME", default_value = "photographic")]
    tone_map: Operator,
    /// Luminance to which the truth's log-average is scaled before the curve
    #[arg(long, value_name = "X", default_value_t = ToneMap::default().key)]
    key: f64,
    /// Fixed factor on linear radiance before the curve, instead of the exposure derived from the truth
    #[arg(long, value_name = "X", allow_negative_numbers = true, conflicts_with = "key")]
    exposure: Option<f64>,
    /// Write the figures as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the FLIP error of each pixel as .png, false-coloured from black (none) to white (1)
    #[arg(long, value_name = "FILE")]
    difference: Option<PathBuf>,
}

/// Compares, prints, writes, and answers whether all bounds hold.
pub fn run(args: &CompareArgs) -> anyhow::Result<Answer> {
    let tone_map = ToneMap { operator: args.tone_map, key: args.key, exposure: args.exposure };
    Scene { tone_map, ..Scene::default() }.validate("command line")?;
    super::check_folders([&args.json])?;
    if let Some(path) = &args.difference
        && Format::of(path)? != Format::Png
    {
        bail!("--difference {}: write it as .png", path.display());
    }
    let a = read(&args.a, args.layer.as_deref())?;
    let b = read(&args.b, args.layer.as_deref())?;
    let shown = a.is_display;
    if b.is_display != shown {
        bail!(
            "{} and {} cannot be compared: one holds radiance, the other display values",
            args.a.display(),
            args.b.display()
        );
    }
    let (a, b) = (a.picture, b.picture);
    check_size(&args.b, &b, &a, &args.a)?;
    let mask = match &args.mask {
        None => None,
        Some(path) => {
            let mask = read(path, None)?.picture;
            check_size(path, &mask, &a, &args.a)?;
            let mask: Vec<f32> = mask.pixels.iter().map(|pixel| pixel.max_element()).collect();
            if !mask.iter().any(|share| *share > 0.0) {
                bail!("--mask {}: it has no pixel over 0, so nothing is compared", path.display());
            }
            Some(mask)
        }
    };
    // Display values have been tone mapped already.
    let exposure = if shown { Exposure::Clipped(1.0) } else { exposure_of(&tone_map, &a) };
    let comparison = compare(&a, &b, mask.as_deref(), exposure);

    print_all(&comparison, args.json.as_ref())?;
    write_json(args.json.as_ref(), &figures(&comparison))?;
    if let Some(path) = &args.difference {
        let srgb: Vec<u8> = comparison.flip_map.iter().flat_map(|&e| false_color(e)).collect();
        write_png(path, a.width, a.height, &srgb)?;
    }
    Ok(if holds(args, &comparison.pixels) { Answer::Yes } else { Answer::No })
}

/// Reads a picture as it is, and says what of it.
fn read(path: &Path, layer: Option<&str>) -> crate::Result<Decoded> {
    let decoded = Decoded::read(path, Request::new("--layer").layer(layer))?;
    for remark in &decoded.remarks {
        remark_once(&path.display().to_string(), remark);
    }
    Ok(decoded)
}

/// Refuses a picture that is not as large as `a`, which stands in `a_path`.
fn check_size(path: &Path, picture: &Picture, a: &Picture, a_path: &Path) -> anyhow::Result<()> {
    if (picture.width, picture.height) != (a.width, a.height) {
        bail!(
            "{} is {} x {}, but {} is {} x {}: sizes must agree",
            path.display(),
            picture.width,
            picture.height,
            a_path.display(),
            a.width,
            a.height
        );
    }
    Ok(())
}

/// Whether all bounds hold; says on stderr which do not.
fn holds(args: &CompareArgs, metrics: &Metrics) -> bool {
    let mut all = true;
    // Negated comparisons: a figure or a bound that is no number does not hold.
    let mut check = |name: &str, value: f64, bound: Option<f64>, least: bool| {
        if let Some(bound) = bound {
            let holds = if least { value >= bound } else { value <= bound };
            if !holds {
                let side = if least { "under" } else { "over" };
                failure!("{name} is {value:.6}, {side} the bound {bound}");
            }
            all &= holds;
        }
    };
    check("FLIP", metrics.flip, args.max_flip, false);
    check("relMSE", metrics.rel_mse, args.max_rel_mse, false);
    check("PSNR", metrics.psnr_db, args.min_psnr, true);
    check("largest error", metrics.max_error, args.max_channel_error, false);
    all
}

fn print_all(comparison: &Comparison, json: Option<&PathBuf>) -> crate::Result<()> {
    let print = |line: std::fmt::Arguments<'_>| print_beside(json, line);
    let Comparison { pixels, boxes, mean_a, mean_b, .. } = comparison;
    let figures = [
        ("relMSE", pixels.rel_mse, boxes.rel_mse),
        ("PSNR (dB)", pixels.psnr_db, boxes.psnr_db),
        ("FLIP mean", pixels.flip, boxes.flip),
        ("FLIP 99 %", pixels.flip_p99, boxes.flip_p99),
        ("largest error", pixels.max_error, boxes.max_error),
    ];
    for (name, pixel, boxed) in figures {
        let [pixel, boxed] = [pixel, boxed].map(|figure| thousands_of(figure, 6));
        print(format_args!("{name:<16}{pixel:>14}{boxed:>14}"))?;
    }
    print(format_args!("(left: pixel by pixel; right: after an 8 x 8 box filter)"))?;
    let (x, y) = pixels.max_error_at;
    print(format_args!("largest error at column {x}, row {y} from the upper left"))?;
    print(format_args!("mean luminance  {mean_a:>14.6}{mean_b:>14.6}  (A, B)"))
}

fn figures(comparison: &Comparison) -> serde_json::Value {
    let Comparison { pixels, boxes, mean_a, mean_b, .. } = comparison;
    json!({
        "rel_mse": pixels.rel_mse,
        "psnr_db": pixels.psnr_db,
        "flip": pixels.flip,
        "flip_p99": pixels.flip_p99,
        "max_error": pixels.max_error,
        "max_error_at": pixels.max_error_at,
        "mean_a": mean_a,
        "mean_b": mean_b,
        "box_8x8": {
            "rel_mse": boxes.rel_mse,
            "psnr_db": boxes.psnr_db,
            "flip": boxes.flip,
            "flip_p99": boxes.flip_p99,
            "max_error": boxes.max_error,
        },
    })
}

/// sRGB bytes of an error 0 to 1: black, violet at 1/16, red at 1/4, yellow at 9/16, white at 1, so that a greater error is
/// always the lighter. They are evenly spaced over its square root: most errors are under 0.1, which would all be black.
pub(super) fn false_color(error: f64) -> [u8; 3] {
    const STOPS: [Vec3; 5] = [
        Vec3::ZERO,
        Vec3::new(0.12, 0.01, 0.35),
        Vec3::new(0.75, 0.06, 0.12),
        Vec3::new(1.0, 0.65, 0.1),
        Vec3::ONE,
    ];
    let at = error.clamp(0.0, 1.0).sqrt() as f32 * (STOPS.len() - 1) as f32;
    let below = (at as usize).min(STOPS.len() - 2);
    let color = STOPS[below].lerp(STOPS[below + 1], at - below as f32);
    color.to_array().map(srgb_byte)
}
