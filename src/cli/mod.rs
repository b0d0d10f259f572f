//! The `raindrops` command: one file a command, and what they share.
//!
//! Exit status: 0 done, 1 a check that was asked for fails (a bound is exceeded),
//! 2 an error, in one line on stderr, 130 interrupted. Results go to stdout or to `-o`, progress to stderr.

mod aliases;
mod bench;
mod compare;
mod compare_devices;
mod completions;
mod dataset;
mod device;
mod devices;
mod errors;
mod format;
mod interrupt;
mod man;
mod mask;
mod options;
mod pane;
mod plan;
mod progress;
mod rain;
mod reference;
mod render;
mod report;
mod rounds;
mod schema;
mod sequence;
mod sky;
mod survey;
mod tell;
mod tradeoff;
mod verdict;
#[cfg(feature = "view")]
mod view;

use std::borrow::Cow;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use self::interrupt::Interrupted;
use self::progress::{progress, waiting};
use self::rounds::environment::unfit_driver_files;
use self::tell::{Kind, TellArgs, failure, once, remark_once, warning};
use crate::environment::Environment;
use crate::environment::guess::is_guessed;
use crate::files::write_whole;
use crate::gpu::BUFFER_BYTES;
use crate::passes::counters::Counts;
use crate::passes::tiles::PIXELS;
use crate::picture::Picture;
use crate::picture::plate::Plate;
use crate::plan::FramePlan;
use crate::remark::{Remark, Severity};
use crate::renderer::lost_light;
use crate::scene::Scene;
use crate::{Error, Result};

/// What the help ends with.
const STATUS: &str = "Examples:
  raindrops view assets/scenes/rain.toml --drops 200000
  raindrops render assets/scenes/dusk.toml -o dusk.png
  raindrops bench --preset paper,fast --drops 125000

`raindrops COMMAND --help` explains each option and its values, -h is shorter.
`--color auto|always|never` colours help and messages.
Exit status: 0 done, 1 a check fails, 2 an error, 130 interrupted.";

/// The commands by purpose, as the help lists them.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Look", &["view", "render", "dataset", "sky", "mask"]),
    ("Ask", &["plan", "rain", "pane", "devices", "schema"]),
    ("Measure truth", &["reference", "compare", "errors"]),
    ("Measure time", &["bench", "survey", "tradeoff", "compare-devices", "verdict", "report"]),
    ("Shell", &["completions", "man", "help"]),
];

/// Raindrops rendered as raindrops, at real-time rates, with the error known.
#[derive(Parser)]
#[command(name = "raindrops", version, max_term_width = 100, after_help = STATUS)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    tell: TellArgs,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(feature = "view")]
    View(view::ViewArgs),
    Render(render::RenderArgs),
    Dataset(dataset::DatasetArgs),
    Sky(sky::SkyArgs),
    Mask(mask::MaskArgs),
    Plan(plan::PlanArgs),
    Rain(rain::RainArgs),
    Pane(pane::PaneArgs),
    Devices(devices::DevicesArgs),
    Schema(schema::SchemaArgs),
    Reference(reference::ReferenceArgs),
    Compare(compare::CompareArgs),
    Errors(errors::ErrorsArgs),
    Bench(bench::BenchArgs),
    Survey(survey::SurveyArgs),
    Tradeoff(tradeoff::TradeoffArgs),
    CompareDevices(compare_devices::CompareDevicesArgs),
    Verdict(verdict::VerdictArgs),
    Report(report::ReportArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

/// The command line, its commands in groups.
fn command_by_groups() -> clap::Command {
    let mut command = Cli::command();
    command.build();
    let mut groups = String::new();
    for (title, names) in GROUPS {
        groups.push_str(&format!("{title}:\n"));
        let found = names.iter().filter_map(|name| command.find_subcommand(name));
        for found in found {
            let about = found.get_about().map(ToString::to_string).unwrap_or_default();
            groups.push_str(&format!("  {:<16} {about}\n", found.get_name()));
        }
        groups.push('\n');
    }
    let template = "{about}\n\n{usage-heading} {usage}\n\n".to_string() + &groups;
    Cli::command().help_template(template + "Options:\n{options}{after-help}")
}

/// What a command answers when it did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Done, or "yes".
    Yes,
    /// The check that was asked for fails.
    No,
}

/// Parses the command line, runs the command and turns its outcome into the exit status.
pub fn main() -> ExitCode {
    let color = tell::color_of(words());
    let command = command_by_groups().color(color);
    let parsed = command
        .try_get_matches()
        .and_then(|given| Cli::from_arg_matches(&given).map(|cli| (cli, given)));
    let (cli, given) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            tell::paint(color);
            return refuse(&error);
        }
    };
    cli.tell.apply();
    let outcome: anyhow::Result<Answer> = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Dataset(args) => dataset::run(&args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(&args),
        Command::Bench(args) => bench::run(&args, &given),
        Command::Survey(args) => survey::run(&args),
        Command::Mask(args) => mask::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Rain(args) => rain::run(&args),
        Command::Pane(args) => pane::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Schema(_) => schema::run(),
        Command::Sky(args) => sky::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::CompareDevices(args) => compare_devices::run(&args),
        Command::Completions(args) => completions::run(&args, &mut Cli::command()),
        Command::Man(args) => man::run(&args, Cli::command()),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Verdict(args) => verdict::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Errors(args) => errors::run(&args),
    };
    match outcome {
        Ok(Answer::Yes) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(error) => {
            // `{:#}` puts the chain of causes on one line.
            let hint = error.downcast_ref().map_or(Cow::Borrowed(""), hint);
            failure!("{}{hint}", format!("{error:#}").replace('\n', " "));
            ExitCode::from(if error.is::<Interrupted>() { Interrupted::STATUS } else { 2 })
        }
    }
}

/// What the user of the command can do about an error of the library: by which package or option.
fn hint(error: &Error) -> Cow<'static, str> {
    if let Error::Environment { path, problem } = error
        && problem.starts_with("cannot be read")
        && path.is_relative()
    {
        return format!(
            "; looked for as {}: a scene's paths are relative to the scene's folder, those of options to the working folder",
            std::path::absolute(path).as_ref().unwrap_or(path).display()
        )
        .into();
    }
    if let Error::File { doing: "read", path, .. } = error
        && path.is_relative()
        && !path.exists()
    {
        let path = std::path::absolute(path);
        return path.map_or("".into(), |path| format!("; looked for as {}", path.display()).into());
    }
    if let (Error::NoDevice, Some(problem)) = (error, unfit_driver_files().first()) {
        return format!("; {problem}").into();
    }
    if let Error::Limit { what: PIXELS, wanted, limit, .. } = error {
        let parts = (*wanted as f64 / *limit as f64).sqrt().ceil();
        return format!("; --tiles {parts}x{parts} of render and dataset draws it in parts").into();
    }
    if let Error::Limit { what: BUFFER_BYTES, .. } = error {
        return "; a smaller --size or fewer drops need less; --tiles 2x2 of render and dataset draws a large picture or its layers in parts".into();
    }
    Cow::Borrowed(match error {
        Error::NoLoader(_) if cfg!(windows) => {
            "; the graphics card's driver brings vulkan-1.dll, and a CPU driver stands in for one (docs/windows.md)"
        }
        Error::NoLoader(_) => "; install libvulkan1 (Debian, Ubuntu: scripts/setup.sh does)",
        Error::NoDevice | Error::NoCard { .. } if cfg!(windows) => {
            "; install the graphics card's driver, or a CPU driver (docs/windows.md); with VK_LOADER_DEBUG=driver the loader says \
             why a driver that is there is not taken"
        }
        Error::NoDevice | Error::NoCard { .. } => {
            "; mesa-vulkan-drivers (Debian, Ubuntu) has lavapipe, which needs no GPU: scripts/setup.sh installs it; \
             with VK_LOADER_DEBUG=driver the loader says why a driver that is there is not taken"
        }
        Error::DeviceLacks { .. } => "; --device chooses, raindrops devices lists them",
        Error::Validation(problem) if problem.contains("not installed") => {
            " (Debian, Ubuntu: vulkan-validationlayers; Windows: the Vulkan SDK)"
        }
        _ => "",
    })
}

/// What the parser says: help and version as they are, an error in one line. Nothing at all on the
/// command line asks for help, but is an error too.
fn refuse(error: &clap::Error) -> ExitCode {
    use clap::error::ErrorKind;
    if let ErrorKind::DisplayHelp
    | ErrorKind::DisplayVersion
    | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand = error.kind()
    {
        // A reader that has gone away is no error.
        let _ = error.print();
        return ExitCode::from(error.exit_code() as u8);
    }
    let text = error.to_string();
    let problem: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    let problem = problem.join(" ").replace(" tip: ", "; ");
    let example = match error.kind() {
        ErrorKind::MissingRequiredArgument => output_example(&problem),
        _ => "",
    };
    failure!("{}{example} (see --help)", problem.trim_start_matches("error: "));
    ExitCode::from(2)
}

/// What to do about a command line that does not name what to write.
fn output_example(problem: &str) -> &'static str {
    let examples = [
        ("--output <FILE.html>", "; name the page to write, such as -o report.html"),
        ("--output <FILE>", "; name the picture to write, such as -o rain.png"),
        ("--output <DIR>", "; name the folder to write into, such as -o out"),
    ];
    let found = examples.into_iter().find(|(option, _)| problem.contains(option));
    found.map_or("", |(_, example)| example)
}

/// Opens the scene's environment and says on stderr what had to be mended in it; once in a run, which may open it for
/// several scenes.
fn open_environment(scene: &Scene) -> Result<Environment> {
    let is_guessed = is_guessed(scene);
    let file = match &scene.background.color {
        Some(plate) if is_guessed => plate,
        _ => scene.environment.file.as_deref().unwrap_or(Path::new("the sky")),
    };
    let environment = waiting(&format!("reading {}", file.display()), || Environment::of(scene))?;
    if is_guessed {
        let text = format!(
            "no environment is given: what the drops show is guessed from {}, continued around the camera; a sun or \
             lamp that is not in it is missing (--environment gives a panorama)",
            file.display()
        );
        once(Kind::Remark(Severity::Note), text);
    }
    let name = format!("environment {}", environment.name());
    environment.remarks().iter().for_each(|remark| remark_once(&name, remark));
    if !environment.mended().is_nothing() {
        once(Kind::Progress, format!("{name}: {}", environment.mended()));
    }
    for (file, remark) in Plate::of(scene)?.remarks() {
        remark_once(&format!("background {}", file.display()), remark);
    }
    let lost = lost_light(&environment);
    if lost > 0.0 {
        let text = format!(
            "texels over 10⁹ times the mean of the others are stored as that much; the sky and drops drawn as \
             points lose {:.3} % of its light",
            100.0 * lost
        );
        remark_once(&name, &Remark::warning(text));
    }
    Ok(environment)
}

/// Writes a picture as halves, and says once in a run if it is brighter than they can hold.
fn write_half(picture: &Picture, path: &Path) -> Result<()> {
    if picture.write_exr_f16(path)? {
        let text = "radiance over 65,504 is stored as that much in pictures of halves";
        once(Kind::Remark(Severity::Warning), text.into());
    }
    Ok(())
}

/// Says on stderr that drops will be hidden by what a picture does not show.
fn say_depth_alone(scene: &Scene) {
    if scene.background.depth.is_some() && scene.background.color.is_none() {
        warning!(
            "a depth without a background: drops are hidden behind things that the picture does not show; \
             --background shows it"
        );
    }
}

/// Says on stderr which drops were left out of frames, and why; and whether their lists had to be larger than usual, by
/// a factor of `room`.
fn say_undrawn(counts: &Counts, room: u32) {
    counts.remarks(room).iter().for_each(tell::remark);
}

/// The words of the command line; a path need not be text.
fn words() -> impl Iterator<Item = String> {
    std::env::args_os().map(|word| word.to_string_lossy().into_owned())
}

/// This process's command line, quoted as a shell needs it, the program by its name alone.
fn command_line() -> String {
    let words: Vec<String> = ["raindrops".to_string()].into_iter().chain(words().skip(1)).collect();
    // No argument of a process holds the one character that cannot be quoted.
    shlex::try_join(words.iter().map(String::as_str)).unwrap_or_else(|_| words.join(" "))
}

/// Says on stderr that a plan may not keep the error that was accepted, or leaves something out of layers.
fn say_doubt(plan: &FramePlan) {
    plan.remarks().iter().for_each(tell::remark);
}

/// Seconds that a measurement takes.
fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    match text.parse() {
        Ok(seconds) if f64::is_finite(seconds) && seconds >= 0.0 => Ok(seconds),
        _ => Err("not a finite number of at least 0".into()),
    }
}

/// What a picture is written as.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    /// Linear radiance.
    Exr,
    /// Display values.
    Png,
}

impl Format {
    /// By the file's extension, before the work; its folder must exist.
    fn of(path: &Path) -> anyhow::Result<Self> {
        let extension = path.extension().and_then(|extension| extension.to_str());
        let format = match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("exr") => Self::Exr,
            Some("png") => Self::Png,
            _ => anyhow::bail!("{}: name a picture .exr or .png", path.display()),
        };
        check_folder(path)?;
        Ok(format)
    }
}

/// Fails before the work, rather than after it, if the folder of a result is not there.
fn check_folder(path: &Path) -> Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(Error::write(path, format!("there is no folder {}", folder.display())))
        }
        _ => Ok(()),
    }
}

/// Like [`check_folder`], for each file that was asked for.
fn check_folders<const N: usize>(files: [&Option<PathBuf>; N]) -> Result<()> {
    files.into_iter().flatten().try_for_each(|file| check_folder(file))
}

/// A name or number of JSON without quotes; `-` for none.
fn plain(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Null => "-".into(),
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Writes figures as JSON where they were asked for; `-` is stdout.
fn write_json(path: Option<&PathBuf>, value: &impl serde::Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut text =
        serde_json::to_string_pretty(value).map_err(|error| Error::write(path, error))?;
    if path.as_os_str() == "-" {
        return print(text);
    }
    text.push('\n');
    write_whole(path, text.as_bytes())
}

/// Prints a line for people, if stdout is not the JSON's alone.
fn print_beside(json: Option<&PathBuf>, line: impl std::fmt::Display) -> Result<()> {
    if json.is_some_and(|path| path.as_os_str() == "-") {
        return Ok(());
    }
    print(line)
}

/// Prints a line to stdout. A reader that has gone away (`| head`) is no error, and the command goes
/// on: files are still to be written, and there is an answer to be given.
fn print(line: impl std::fmt::Display) -> Result<()> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(|error| Error::write(Path::new("stdout"), error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_is_in_one_group() {
        let mut command = Cli::command();
        command.build();
        let mut of_groups: Vec<_> =
            GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        if !cfg!(feature = "view") {
            of_groups.retain(|name| *name != "view");
        }
        let mut all: Vec<_> = command.get_subcommands().map(clap::Command::get_name).collect();
        of_groups.sort_unstable();
        all.sort_unstable();
        assert_eq!(of_groups, all);
    }

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
