//! `raindrops survey`: what a device is, how fast it draws and how truly, in a few minutes and one folder that can be sent.
//!
//! Each step is a process of its own, so that a driver that fails in one leaves the others; what failed is in the result.

mod pictures;
mod steps;

use std::ffi::OsString;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Args;
use serde::Serialize;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use self::pictures::{Seen, cases};
use self::steps::{Step, steps};
use super::device::choose_device;
use super::interrupt::heed_interrupts;
use super::rounds::process::Arm;
use super::tell::{say, warning};
use super::{Answer, command_line, print, progress, write_json};
use crate::Error;
use crate::files::{whole_path, write_whole};
use crate::gpu::{Instance, Validation};
use crate::measure::Host;
use crate::measure::bench::{Build, DeviceHead};

/// Version of the format of its result.
const SCHEMA: &str = "raindrops-survey/1";
/// Seconds that all steps together have where `--max-time` is not given.
const USUAL_TIME_S: f64 = 480.0;

/// Measure a device in a few minutes: one folder and one zip file to send
///
/// What drawing shows of the driver, Table II, `exact`, the passes as they are laid out for the other kind of
/// machine, real rain at rest and exposed, three pictures held against kept references, a small trade-off, and a page of all.
#[derive(Args)]
#[command(after_help = "Example:
  raindrops survey -o my-card

Send my-card.zip to whoever compares devices; `raindrops report my-card/*.json other/*.json -o both.html` sets two beside each other.")]
pub struct SurveyArgs {
    /// Folder to write into; beside it DIR.zip
    #[arg(short, long, value_name = "DIR", default_value = "survey")]
    output: PathBuf,
    /// Time for all, and with more than eight minutes for each step in proportion; steps that no longer fit are left out, and
    /// named
    #[arg(long, value_name = "TIME", default_value = "8m", value_parser = humantime::parse_duration)]
    max_time: Duration,
    /// Only these steps, comma-separated, by the names of their files: devices, table-2, drop-fast, …
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    only: Vec<String>,
    /// Vulkan device: a part of its name or driver, or its index in `raindrops devices`
    #[arg(long, value_name = "NAME|INDEX", env = DEVICE, hide_env_values = true)]
    device: Option<String>,
}

/// How the device reaches the processes of the steps.
const DEVICE: &str = "RAINDROPS_DEVICE";

/// A step is not begun with less time left: to open a device alone takes a second or two.
const LEAST: Duration = Duration::from_secs(5);

impl SurveyArgs {
    /// Time for a step that has `most` of the eight minutes.
    fn time_of(&self, most: Duration) -> Duration {
        let times = (self.max_time.as_secs_f64() / USUAL_TIME_S).max(1.0);
        Duration::try_from_secs_f64(most.as_secs_f64() * times).unwrap_or(Duration::MAX)
    }

    fn takes(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|wanted| wanted == name)
    }

    /// Refuses a step that there is not.
    fn check(&self, steps: &[Step]) -> anyhow::Result<()> {
        let names = || steps.iter().map(|step| step.name).chain(cases().map(|case| case.name));
        match self.only.iter().find(|wanted| !names().any(|name| name == **wanted)) {
            None => Ok(()),
            Some(unknown) => {
                let names: Vec<_> = names().collect();
                anyhow::bail!("--only {unknown}: there are {}", names.join(", "))
            }
        }
    }
}

/// What is written as `survey.json`.
#[derive(Serialize)]
struct Report {
    schema: &'static str,
    device: DeviceHead,
    build: Build,
    host: Host,
    command: String,
    steps: Vec<Done>,
    pictures: Vec<Seen>,
}

/// A step that was done, or was to be.
#[derive(Serialize)]
struct Done {
    name: &'static str,
    seconds: f64,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    failed: Option<String>,
}

/// Runs the command.
pub fn run(args: &SurveyArgs) -> anyhow::Result<Answer> {
    let folder = std::fs::create_dir_all(&args.output)
        .and_then(|()| whole_path(&args.output))
        .map_err(|error| Error::write(&args.output, error))?;
    let host = Host::now();
    let instance = Instance::new(Validation::Off)?;
    let report = choose_device(&instance, args.device.as_deref())?;
    say!("device: {}", report.summary());
    heed_interrupts()?;

    let mut survey = Survey::new(args, folder)?;
    let mut steps = steps(report.machine);
    args.check(&steps)?;
    steps.retain(|step| args.takes(step.name));
    let bar = progress(steps.len() as u64 + 2, "steps");
    for step in steps {
        bar.set_message(step.name);
        survey.step(&step)?;
        bar.inc(1);
    }
    bar.set_message("pictures");
    let pictures = survey.pictures()?;
    bar.inc(1);
    bar.set_message("report");
    survey.page()?;
    bar.finish_and_clear();

    let Survey { folder, done, mut files, .. } = survey;
    let written = Report {
        schema: SCHEMA,
        device: DeviceHead::of(&report),
        build: Build::this(),
        host,
        command: command_line(),
        steps: done,
        pictures,
    };
    files.push(folder.join("survey.json"));
    write_json(files.last(), &written)?;
    let packed = pack(&folder, files)?;
    print(tell(&written))?;
    print(format!("{}, and all of it in {}", folder.display(), packed.display()))?;
    let is_whole = written.steps.iter().all(|step| step.failed.is_none());
    let is_true = written.pictures.iter().all(Seen::holds);
    Ok(if is_whole && is_true { Answer::Yes } else { Answer::No })
}

/// A survey under way.
struct Survey<'a> {
    args: &'a SurveyArgs,
    folder: PathBuf,
    program: PathBuf,
    since: Instant,
    done: Vec<Done>,
    /// What it wrote: the folder may hold other things.
    files: Vec<PathBuf>,
}

impl<'a> Survey<'a> {
    fn new(args: &'a SurveyArgs, folder: PathBuf) -> anyhow::Result<Self> {
        let program = std::env::current_exe().context("this program's file is not known")?;
        let (done, files) = (Vec::new(), Vec::new());
        Ok(Self { args, folder, program, since: Instant::now(), done, files })
    }

    /// Runs a step of its own result.
    fn step(&mut self, step: &Step) -> anyhow::Result<bool> {
        let result = step.result(&self.folder);
        self.take(step.name, &step.arguments(&result), &step.variables, step.most, result)
    }

    /// Runs the program with `arguments`, which write `file`, for at most `most`; whether it did what it was to do. Only an
    /// interrupt is an error.
    fn take(
        &mut self,
        name: &'static str,
        arguments: &[OsString],
        variables: &[(&str, &str)],
        most: Duration,
        file: PathBuf,
    ) -> anyhow::Result<bool> {
        let (start, left) =
            (Instant::now(), self.args.max_time.saturating_sub(self.since.elapsed()));
        let arm = Arm {
            label: name.into(),
            program: self.program.clone(),
            variables: variables
                .iter()
                .copied()
                .chain(self.args.device.as_deref().map(|device| (DEVICE, device)))
                .map(|(name, value)| (name.into(), value.into()))
                .collect(),
            options: Vec::new(),
        };
        let failed = match left < LEAST {
            true => Some(format!(
                "left out: --max-time {} is over",
                humantime::format_duration(self.args.max_time)
            )),
            false => match arm.run(arguments, self.args.time_of(most).min(left)) {
                Err(error) if error.is::<super::Interrupted>() => return Err(error),
                outcome => outcome.err().map(|error| format!("{error:#}")),
            },
        };
        if let Some(why) = &failed {
            warning!("{name}: {why}");
        }
        let is_done = failed.is_none();
        if is_done {
            self.files.push(file);
        }
        self.done.push(Done { name, seconds: start.elapsed().as_secs_f64(), failed });
        Ok(is_done)
    }

    /// Draws the three scenes by each preset that can draw them, and compares them with their references.
    fn pictures(&mut self) -> anyhow::Result<Vec<Seen>> {
        let mut all = Vec::new();
        self.files.extend(pictures::prepare(&self.folder)?);
        for case in cases().filter(|case| self.args.takes(case.name)) {
            let (arguments, file) = (case.arguments(&self.folder), case.file(&self.folder));
            if self.take(case.name, &arguments, &[], Duration::from_secs(60), file)? {
                all.push(case.compare(&self.folder)?);
            }
        }
        Ok(all)
    }

    /// All that was measured, as a page.
    fn page(&mut self) -> anyhow::Result<()> {
        let is_reported = |path: &&PathBuf| {
            path.extension().is_some_and(|kind| kind == "json") && !path.ends_with("devices.json")
        };
        let results: Vec<_> = self.files.iter().filter(is_reported).cloned().collect();
        if results.is_empty() {
            return Ok(());
        }
        let page = self.folder.join("report.html");
        let mut arguments = vec!["report".into(), "-o".into(), page.clone().into()];
        arguments.extend(results.into_iter().map(PathBuf::into_os_string));
        self.take("report", &arguments, &[], Duration::from_secs(60), page).map(|_| ())
    }
}

/// Packs the files of a folder into a zip file beside it; gives its path.
fn pack(folder: &Path, mut files: Vec<PathBuf>) -> anyhow::Result<PathBuf> {
    let mut path = folder.to_owned().into_os_string();
    path.push(".zip");
    let path = PathBuf::from(path);
    files.sort();
    let mut packed = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        let bytes = std::fs::read(&file).map_err(|error| Error::read(&file, error))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        packed.start_file(name, SimpleFileOptions::default())?;
        packed.write_all(&bytes)?;
    }
    write_whole(&path, packed.finish()?.get_ref())?;
    Ok(path)
}

/// The pictures as a table, and what failed.
fn tell(report: &Report) -> String {
    let mut lines = vec!["picture            mean FLIP   at most".to_string()];
    for seen in &report.pictures {
        let over = if seen.holds() { "" } else { "   OVER" };
        lines.push(format!("{:<18} {:>9.4} {:>9.4}{over}", seen.name, seen.flip, seen.most_flip));
    }
    for step in &report.steps {
        if let Some(why) = &step.failed {
            lines.push(format!("{} failed: {why}", step.name));
        }
    }
    let seconds: f64 = report.steps.iter().map(|step| step.seconds).sum();
    lines.push(format!("{} steps in {seconds:.0} s", report.steps.len()));
    lines.join("\n")
}
