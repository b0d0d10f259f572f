//! `raindrops devices`: every Vulkan device, what it is and what it lacks; with `--probe`, what it does.

use std::path::PathBuf;

use clap::{Args, ValueEnum as _};
use serde_json::json;

use super::rounds::environment::unfit_driver_files;
use super::tell::{remark, warning};
use super::{Answer, print_beside, write_json};
use crate::Error;
use crate::gpu::disk_cache::user_folder;
use crate::gpu::probe::{Findings, Points, Rounding};
use crate::gpu::{Device, DeviceReport, Instance, Validation};
use crate::measure::costs::{Ranked, ranked};
use crate::plan::requirements;
use crate::scene::model::Preset;
use crate::thousands::{thousands, thousands_of};

/// List the Vulkan devices: driver, limits, missing features
#[derive(Args)]
pub struct DevicesArgs {
    /// Find out by drawing what each device does with points, texture levels, float16 and timestamps
    #[arg(long)]
    probe: bool,
    /// Write what was found as JSON; `-` is stdout
    #[arg(long, value_name = "FILE", requires = "probe")]
    json: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &DevicesArgs) -> anyhow::Result<Answer> {
    let instance = Instance::new(Validation::Off)?;
    let devices = ranked(&instance, user_folder().as_deref(), remark)?;
    if devices.is_empty() {
        return Err(Error::NoDevice.into());
    }
    unfit_driver_files().iter().for_each(|problem| warning!("{problem}"));
    let mut probed = Vec::new();
    for (index, Ranked { report, frame_ms }) in devices.into_iter().enumerate() {
        print_beside(args.json.as_ref(), describe(index, &report, frame_ms))?;
        if args.probe && report.missing.is_empty() {
            let findings = Findings::of(&Device::open(&instance, report.clone())?)?;
            print_beside(args.json.as_ref(), tell(&findings))?;
            let (device, driver) = (&report.name, &report.driver);
            let driver_info = &report.driver_info;
            probed.push(json!({
                "device": device, "driver": driver, "driver_info": driver_info, "found": findings,
            }));
        }
    }
    write_json(args.json.as_ref(), &probed)?;
    Ok(Answer::Yes)
}

fn describe(index: usize, device: &DeviceReport, frame_ms: Option<f64>) -> String {
    let limits = &device.limits;
    let [rounding, reconvergence] = device.promises.words();
    let fit = fit(device);
    let speed = frame_ms.map_or(String::new(), |ms| {
        format!(
            "\n   speed           about {} ms for a frame of a million drops by preset fast (measured once, then kept)",
            thousands_of(ms, 0)
        )
    });
    format!(
        "{index}: {} ({})
   driver          {} {}
   Vulkan          {}
   point size      {} to {} px, in steps of {}
   largest image   {} px
   memory          {} MiB at once
   storage buffer  {} MiB a binding ({:.1} M drops; more go in chunks)
   timestamps      {} ns a tick
   float32         {rounding}
   invocations     {reconvergence}
   fit             {fit}{speed}",
        device.name,
        device.kind,
        device.driver,
        device.driver_info,
        device.api_version,
        limits.point_size_range[0],
        limits.point_size_range[1],
        limits.point_size_granularity,
        thousands(limits.max_image_dimension2_d.into()),
        thousands(device.max_allocation >> 20),
        thousands(u64::from(limits.max_storage_buffer_range >> 20)),
        f64::from(limits.max_storage_buffer_range / 16) / 1e6,
        limits.timestamp_period,
    )
}

/// Which presets it can draw, and what it lacks for the others.
fn fit(device: &DeviceReport) -> String {
    if !device.missing.is_empty() {
        return format!("no, it lacks {}", device.missing.join(", "));
    }
    // `auto` takes points only where a scene asks for them.
    let others = Preset::value_variants().iter().filter(|preset| **preset != Preset::Auto);
    let others = others.filter_map(|preset| {
        let lacks = device.lacks(&requirements(*preset));
        (!lacks.is_empty()).then(|| format!("{} lacks {}", preset.name(), lacks.join(", ")))
    });
    let others: Vec<_> = others.collect();
    if others.is_empty() { "yes".into() } else { format!("yes, but {}", others.join("; ")) }
}

/// What was found, in words.
fn tell(findings: &Findings) -> String {
    let Findings { points, sampling, halves, clock } = findings;
    let rounded = |rounding: Rounding| match rounding {
        Rounding::Nearest => "to the nearest",
        Rounding::TowardZero => "towards zero",
        Rounding::Other => "by a rule of its own",
    };
    let points =
        points.as_ref().map_or("points          none: it lacks largePoints".into(), tell_points);
    let clock = match clock {
        None => "none".into(),
        Some(clock) => format!(
            "{:.0} % of the CPU's time; {:.0} % of it on the pass that works: {}",
            100.0 * clock.share_of_wall,
            100.0 * clock.share_of_heavy,
            if clock.is_sound() { "sound" } else { "not to be trusted pass by pass" }
        ),
    };
    format!(
        "   found by drawing:
   {points}
   texture levels  given: off by {:.4}, implied: by {:.4}; {} blends of two levels in 32 steps
   texture filter  {} blends of two texels in 512 steps
   float16         written {}, packed {}; 65,520 becomes {}; denormals {}; least alpha that shows 2^{}
   timestamps      {clock}",
        sampling.explicit_level_error,
        sampling.implicit_level_error,
        sampling.blends_a_level,
        sampling.blends_a_texel,
        rounded(halves.written),
        rounded(halves.packed),
        halves.overflow,
        if halves.keeps_denormals { "kept" } else { "lost" },
        halves.least_alpha_log2,
    )
}

fn tell_points(points: &Points) -> String {
    let drawn = |draws: bool| if draws { "drawn" } else { "clipped" };
    let [least, most] = points.sub_pixel;
    format!(
        "points          to {} px at their size; asked for {} px: {} px wide
   off screen      a point whose centre is off the viewport is {} (claimed: {})
   sub-pixel       a point of 0.3 px is {least} to {most} pixels
   coordinates     off by {:.4} px at most; {} places a pixel, {} sizes a pixel or more",
        points.limit_px,
        points.claimed_px[1] + 64.0,
        points.beyond_limit_px,
        drawn(points.draws_off_screen),
        drawn(points.claims_to_draw_off_screen),
        points.coordinate_error_px,
        16 * points.places_a_sixteenth,
        points.sizes_a_pixel,
    )
}
