//! `bench --duration 1h`: one row without a break, with frame time, memory and clock over time.

use std::time::Duration;

use super::{BenchArgs, begun, check_counts, is_papers, write};
use crate::cli::device::{choose_device, open_device, resolve};
use crate::cli::format::Format;
use crate::cli::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use crate::cli::tell::{note, say};
use crate::cli::{Answer, open_environment, print, progress, say_doubt};
use crate::files::write_whole;
use crate::measure::bench::{Amount, OverTime, Row, Stretch, Variant, Watch, long_plot, watch};
use crate::measure::clocks::Clock;
use crate::plan::{Output, plan_by};
use crate::scene::Scene;
use crate::scene::model::Preset;

/// The least and the most that may be asked for.
const LEAST: Duration = Duration::from_secs(1);
const MOST: Duration = Duration::from_secs(30 * 24 * 3600);
/// What is measured where neither scene nor number of drops is given: a row of Table II.
const USUAL_DROPS: u32 = 1_000_000;
/// Lines on stderr of how it goes.
const LINES: f64 = 10.0;

/// `90s`, `1h`: how long to measure.
pub(super) fn parse_duration(text: &str) -> Result<Duration, String> {
    let found = humantime::parse_duration(text)
        .map_err(|_| format!("'{text}' is not a time such as 90s, 15m or 1h"))?;
    if !(LEAST..=MOST).contains(&found) {
        return Err(format!("'{text}' is not within 1s to 30days"));
    }
    Ok(found)
}

/// Runs the command.
pub(super) fn run(args: &BenchArgs, scene: &Scene, duration: Duration) -> anyhow::Result<Answer> {
    let wanted = args.device.device.as_deref();
    if wanted == Some("all") {
        anyhow::bail!("--duration measures one device; choose it by --device");
    }
    let (mut scene, preset) = (scene.clone(), one_preset(args, scene)?);
    if let Some(amount) = one_amount(args)? {
        amount.apply(&mut scene)?;
    }
    scene.model.take_preset(preset);
    scene.validate("command line")?;
    let environment = open_environment(&scene)?;
    let instance = args.device.instance()?;
    let device = open_device(&instance, choose_device(&instance, wanted)?)?;
    heed_interrupts()?;

    let mut report = begun(&device, &environment);
    let clock = Clock::of(&report.device);
    say!("clock: {}", clock.source());
    let choice = resolve(&device, &scene, &environment)?;
    let plan = plan_by(&scene, &environment, choice.as_ref(), Output::Display)?;
    say_doubt(&plan);
    let variant = Variant { plan, scene: scene.clone() };

    let seconds = duration.as_secs_f64();
    let bar = progress(duration.as_secs().max(1), "s");
    let mut next_line = seconds / LINES;
    let mut tell = |stretch: &Stretch| {
        bar.set_position(stretch.to_s as u64);
        bar.set_message(line_of(stretch));
        if stretch.to_s >= next_line {
            bar.suspend(|| say!("{:.0} s: {}", stretch.to_s, line_of(stretch)));
            while next_line <= stretch.to_s {
                next_line += seconds / LINES;
            }
        }
    };
    let watching = Watch { duration, clock: &clock, tell: &mut tell, stop: &is_interrupted };
    let watched = watch(&device, &environment, &variant, watching)?;
    bar.finish_and_clear();
    let ended = match (watched.failed, is_interrupted()) {
        (Some(error), _) => Some(anyhow::Error::from(error)),
        (None, true) => Some(Interrupted.into()),
        (None, false) => None,
    };
    if watched.stretches.is_empty() {
        return Err(ended.unwrap_or_else(|| anyhow::anyhow!("no frame was measured")));
    }

    let over_time = OverTime::of(seconds, watched.stretches, clock.source());
    let from = over_time.steady_from_s.unwrap_or(0.0);
    let mut measured = watched.measured;
    measured.samples_ms = watched.samples.since(from);
    measured.passes_ms =
        watched.passes.iter().map(|(name, samples)| (*name, samples.since(from))).collect();
    let mut row = Row::new(&variant, &environment, &measured, report.start.clone());
    let lines = lines(&over_time);
    row.over_time = Some(over_time);
    report.rows.push(row);
    write(args, is_papers(&scene), &report, std::iter::once(&report))?;
    if args.gate.format == Format::Table && !args.gate.is_json() {
        lines.into_iter().try_for_each(print)?;
    }
    if let (Some(path), Some(svg)) = (&args.svg, long_plot(&report)?) {
        write_whole(path, svg.as_bytes())?;
    }
    if let Some(error) = ended {
        return Err(error);
    }
    let agrees = check_counts(&scene, &report)?;
    instance.expect_silence()?;
    Ok(if agrees { Answer::Yes } else { Answer::No })
}

/// The preset to measure; several in turn would each be cold again.
fn one_preset(args: &BenchArgs, scene: &Scene) -> anyhow::Result<Preset> {
    match args.preset.as_slice() {
        [one] => Ok(*one),
        [] if args.scene.is_some() => Ok(scene.model.preset),
        [] => Ok(if args.rain.is_empty() { Preset::Paper } else { Preset::Fast }),
        _ => anyhow::bail!(
            "--duration measures one preset; several are measured one after the other"
        ),
    }
}

/// How much rain; none: the scene's.
fn one_amount(args: &BenchArgs) -> anyhow::Result<Option<Amount>> {
    if args.scene.is_none() && args.drops.is_empty() && args.rain.is_empty() {
        note!("{USUAL_DROPS} drops; a scene, --drops or --rain chooses");
        return Ok(Some(Amount::Drops(USUAL_DROPS)));
    }
    match args.series().as_slice() {
        [one] => Ok(*one),
        _ => anyhow::bail!("--duration measures one number of drops or one rate"),
    }
}

fn line_of(stretch: &Stretch) -> String {
    let memory = stretch.resident_bytes.map(|bytes| format!(", {} MiB", bytes >> 20));
    let clock = stretch.clock_mhz.map(|mhz| format!(", {mhz:.0} MHz"));
    let load = stretch.load.map(|load| format!(", load {load}"));
    let more = [memory, clock, load].into_iter().flatten().collect::<String>();
    format!("{:.2} ms a frame{more}", stretch.median_ms)
}

/// What it came to, in words.
fn lines(over_time: &OverTime) -> Vec<String> {
    let mut lines = Vec::new();
    let percent = |part: f64| format!("{:+.1} %", 100.0 * part);
    lines.push(match (over_time.steady_from_s, over_time.before_ms, over_time.steady_ms) {
        (Some(from), Some(before), Some(steady)) => format!(
            "steady from {from:.0} s on: {steady:.2} ms a frame, {} over the {before:.2} ms before; the figures above are of then",
            percent(steady / before - 1.0)
        ),
        (Some(_), None, Some(steady)) => format!("steady from the beginning: {steady:.2} ms a frame"),
        _ => "frame times did not become steady; the figures above are of the whole".into(),
    });
    let clear =
        |counts: bool| if counts { "clear" } else { "may be chance, or too small to count" };
    lines.extend(over_time.frame_time.map(|trend| {
        format!("frame time: {} since then ({})", percent(trend.change), clear(trend.counts))
    }));
    lines.extend(over_time.memory.map(|trend| {
        let mib = |bytes: f64| bytes / f64::from(1 << 20);
        format!(
            "memory: {:+.1} MiB since then, {:+.1} MiB an hour ({})",
            mib(trend.change),
            mib(trend.per_hour),
            clear(trend.counts)
        )
    }));
    lines.push(format!("clock: {}", over_time.clock));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        assert_eq!(parse_duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("1h 30m"), Ok(Duration::from_secs(5400)));
        for wrong in ["", "0", "0s", "-5s", "999ms", "5", "soon", "inf", "nan", "31days", "1e9h"] {
            let problem = parse_duration(wrong).expect_err(wrong);
            assert!(problem.contains(wrong) && !problem.contains('\n'), "{problem}");
        }
    }
}
