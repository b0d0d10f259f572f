//! One fresh process: started, waited for, and never left behind.

use std::ffi::OsString;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};

use super::environment::Variables;
use super::tree::Tree;
use crate::cli::interrupt::{Interrupted, is_interrupted, set_at_work};
use crate::measure::bench::{Report, read};

/// How often a process that runs is asked whether it has ended.
const PATIENCE: Duration = Duration::from_millis(10);
/// Bytes of what a process said last that are looked through for its error.
const LAST_WORDS: u64 = 4096;

/// A program with its arguments and its own environment.
#[derive(Clone, Debug)]
pub struct Arm {
    /// What it is called in results: its environment, its binary, its device.
    pub label: String,
    /// The program.
    pub program: PathBuf,
    /// Variables over those of this process.
    pub variables: Variables,
    /// Options of this arm alone.
    pub options: Vec<OsString>,
}

impl Arm {
    /// Runs `bench` in a fresh process and reads its result.
    pub fn bench(&self, arguments: &[OsString], timeout: Duration) -> anyhow::Result<Report> {
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let path = folder.path().join("result.json");
        let mut all = vec![OsString::from("bench")];
        all.extend_from_slice(arguments);
        all.extend(["--json".into(), path.clone().into_os_string()]);
        let last_words = self.run(&all, timeout)?;
        if !path.exists() {
            bail!("{} ended without a result: {last_words}", self.name());
        }
        let mut reports = read(&path).map_err(|error| {
            // The folder is gone by the time that this is read.
            let reason = error.to_string();
            let reason =
                reason.rsplit_once("result.json: ").map_or(reason.as_str(), |(_, why)| why);
            anyhow::anyhow!("{} wrote a result that cannot be read: {reason}", self.name())
        })?;
        match (reports.pop(), reports.len()) {
            (Some(report), 0) => Ok(report),
            _ => bail!("{} measured several devices; choose one by --device", self.name()),
        }
    }

    /// Runs `render` in a fresh process, which writes `picture`.
    pub fn render(
        &self,
        arguments: &[OsString],
        picture: &Path,
        timeout: Duration,
    ) -> anyhow::Result<()> {
        let mut all = vec![OsString::from("render")];
        all.extend_from_slice(arguments);
        all.extend(["-o".into(), picture.into()]);
        let last_words = self.run(&all, timeout)?;
        if !picture.exists() {
            bail!("{} ended without a picture: {last_words}", self.name());
        }
        Ok(())
    }

    fn name(&self) -> String {
        format!("{} ({})", self.program.display(), self.label)
    }

    /// Runs it to its end, or ends it where it takes longer than `timeout`; gives what it said last.
    pub fn run(&self, arguments: &[OsString], timeout: Duration) -> anyhow::Result<String> {
        // A file, not a pipe: whatever it says, it never waits for us.
        let mut said = tempfile::tempfile().context("no temporary file")?;
        let mut command = Command::new(&self.program);
        command
            .args(arguments)
            .args(&self.options)
            .envs(self.variables.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(said.try_clone().context("no temporary file")?);
        let mut running = Running::start(command)
            .with_context(|| format!("{} does not start", self.program.display()))?;
        let status = running.wait(timeout);
        drop(running);
        let last_words = last_words(&mut said);
        match status? {
            None => bail!(
                "{} was ended: it took longer than {} s (--timeout)",
                self.name(),
                timeout.as_secs_f64()
            ),
            // A check that fails, such as drops in view, is no reason to lose a round's times.
            Some(status) if matches!(status.code(), Some(0 | 1)) => Ok(last_words),
            Some(status) => bail!("{} failed ({status}): {last_words}", self.name()),
        }
    }
}

/// The line of what it said that tells most: its error, or the last one.
fn last_words(said: &mut File) -> String {
    let mut bytes = Vec::new();
    let end = said.seek(SeekFrom::End(0)).unwrap_or(0);
    let from = SeekFrom::Start(end.saturating_sub(LAST_WORDS));
    if said.seek(from).is_err() || said.take(LAST_WORDS).read_to_end(&mut bytes).is_err() {
        return "what it said cannot be read".into();
    }
    let text = String::from_utf8_lossy(&bytes);
    let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
    let error = lines().rfind(|line| line.starts_with("raindrops: "));
    shortened(error.or_else(|| lines().next_back()).unwrap_or("it said nothing"))
}

/// A line of up to 600 characters; of a longer one its first words.
fn shortened(line: &str) -> String {
    let Some((end, _)) = line.char_indices().nth(600) else { return line.into() };
    let words = line[..end].rfind(' ').unwrap_or(end);
    format!("{} …", &line[..words])
}

/// A process and all that it started, ended when this goes.
struct Running {
    child: Child,
    tree: Tree,
    has_ended: bool,
}

impl Running {
    fn start(command: Command) -> std::io::Result<Self> {
        set_at_work(true);
        let started = Tree::start(command);
        set_at_work(started.is_ok());
        started.map(|(child, tree)| Self { child, tree, has_ended: false })
    }

    /// Waits until it has ended; none if that took longer than `timeout`.
    fn wait(&mut self, timeout: Duration) -> anyhow::Result<Option<ExitStatus>> {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().context("it cannot be waited for")? {
                self.has_ended = true;
                return Ok(Some(status));
            }
            if is_interrupted() {
                bail!(Interrupted);
            }
            if start.elapsed() > timeout {
                return Ok(None);
            }
            std::thread::sleep(PATIENCE);
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Once it was waited for, its number may be another's.
        if !self.has_ended {
            self.tree.end();
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        set_at_work(false);
    }
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn a_long_line_ends_between_words() {
        let line = |words: usize| vec!["ärger"; words].join(" ");
        assert_eq!(shortened(&line(100)), line(100));
        assert_eq!(shortened(&line(101)), format!("{} …", line(100)));
        assert_eq!(shortened(&"x".repeat(700)), format!("{} …", "x".repeat(600)));
    }
}
