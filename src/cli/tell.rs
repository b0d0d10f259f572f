//! What the command says on stderr beside its results: how much of it, and in which colours.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::{Args, ColorChoice};
use console::Style;

use crate::remark::{Remark, Severity};

/// Options of every command.
#[derive(Args)]
#[command(next_help_heading = "Messages")]
pub struct TellArgs {
    /// Print warnings and errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Also print what takes time, and a frame's passes
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Colours in help and messages
    #[arg(
        long,
        global = true,
        value_enum,
        value_name = "WHEN",
        default_value = "auto",
        hide = true
    )]
    color: ColorChoice,
}

const QUIET: u8 = 0;
const USUAL: u8 = 1;
const VERBOSE: u8 = 2;
static VOLUME: AtomicU8 = AtomicU8::new(USUAL);

impl TellArgs {
    /// From now on messages are as these options have them.
    pub fn apply(&self) {
        let volume = match (self.quiet, self.verbose) {
            (true, _) => QUIET,
            (_, true) => VERBOSE,
            _ => USUAL,
        };
        VOLUME.store(volume, Ordering::Relaxed);
        paint(self.color);
    }
}

/// From now on messages have colours or not; `auto`: on a terminal, unless NO_COLOR is set.
pub fn paint(color: ColorChoice) {
    match color {
        ColorChoice::Auto => {}
        choice => console::set_colors_enabled_stderr(choice == ColorChoice::Always),
    }
}

/// The colours that the command line asks for, before it is parsed: help is printed by the parser, and what it refuses
/// is an error in colours, too.
pub fn color_of(mut words: impl Iterator<Item = String>) -> ColorChoice {
    let word = words.find(|word| word == "--color" || word.starts_with("--color="));
    let value = match word {
        Some(word) if word == "--color" => words.next(),
        word => word.and_then(|word| word.strip_prefix("--color=").map(String::from)),
    };
    value.and_then(|value| value.parse().ok()).unwrap_or(ColorChoice::Auto)
}

/// Whether only warnings and errors are asked for.
pub fn is_quiet() -> bool {
    VOLUME.load(Ordering::Relaxed) == QUIET
}

/// What a line on stderr is. It decides on the line's label and whether the line is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What was done, and how far it is.
    Progress,
    /// What is worth saying beside a result.
    Remark(Severity),
    /// An error, or a check that fails.
    Failure,
}

impl Kind {
    /// Whether a line of this kind is printed at a volume.
    fn is_printed(self, volume: u8) -> bool {
        match self {
            Self::Remark(Severity::Detail) => volume == VERBOSE,
            Self::Progress | Self::Remark(Severity::Note) => volume != QUIET,
            Self::Remark(Severity::Warning) | Self::Failure => true,
        }
    }

    /// What stands before the text.
    fn label(self) -> Option<(&'static str, Style)> {
        let style = Style::new().bold().for_stderr();
        match self {
            Self::Progress | Self::Remark(Severity::Detail) => None,
            Self::Remark(Severity::Note) => Some(("note:", style.cyan())),
            Self::Remark(Severity::Warning) => Some(("warning:", style.yellow())),
            Self::Failure => Some(("raindrops:", style.red())),
        }
    }
}

/// Prints a line of a kind, without its label.
pub fn line(kind: Kind, text: &str) {
    if !kind.is_printed(VOLUME.load(Ordering::Relaxed)) {
        return;
    }
    match kind.label() {
        Some((label, style)) => eprintln!("{} {text}", style.apply_to(label)),
        None => eprintln!("{text}"),
    }
}

/// Prints a remark.
pub fn remark(remark: &Remark) {
    line(Kind::Remark(remark.severity), &remark.text);
}

/// Prints a line as [`line`](fn@line) does, unless this run has printed it already.
pub fn once(kind: Kind, text: String) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    // Whoever panicked while it was locked has left a whole set.
    let is_new = SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone());
    if is_new {
        line(kind, &text);
    }
}

/// Prints what is worth saying of a thing, unless this run has printed it already.
pub fn remark_once(of: &str, remark: &Remark) {
    once(Kind::Remark(remark.severity), format!("{of}: {remark}"));
}

/// A time as an estimate is told: `48 s`, `3 min`.
pub fn about(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 90.0 => format!("{} s", seconds.ceil()),
        seconds => format!("{} min", (seconds / 60.0).ceil()),
    }
}

/// Prints what was done or how far it is, formatted; see [`Kind`].
macro_rules! say {
    ($($argument:tt)*) => {
        $crate::cli::tell::line($crate::cli::tell::Kind::Progress, &format!($($argument)*))
    };
}
pub(super) use say;

/// Prints what only `-v` shows, formatted.
macro_rules! detail {
    ($($argument:tt)*) => {
        $crate::cli::tell::remark(&$crate::remark::Remark::detail(format!($($argument)*)))
    };
}
pub(super) use detail;

/// Prints a note, formatted.
macro_rules! note {
    ($($argument:tt)*) => {
        $crate::cli::tell::remark(&$crate::remark::Remark::note(format!($($argument)*)))
    };
}
pub(super) use note;

/// Prints a warning, formatted.
macro_rules! warning {
    ($($argument:tt)*) => {
        $crate::cli::tell::remark(&$crate::remark::Remark::warning(format!($($argument)*)))
    };
}
pub(super) use warning;

/// Prints an error, or why a check fails, formatted.
macro_rules! failure {
    ($($argument:tt)*) => {
        $crate::cli::tell::line($crate::cli::tell::Kind::Failure, &format!($($argument)*))
    };
}
pub(super) use failure;

#[cfg(test)]
mod tests {
    use super::*;

    /// A line is what it was printed as, whatever it begins with.
    #[test]
    fn a_line_is_printed_by_its_kind() {
        let volumes = |kind: Kind| [QUIET, USUAL, VERBOSE].map(|volume| kind.is_printed(volume));
        assert_eq!(volumes(Kind::Failure), [true; 3]);
        assert_eq!(volumes(Kind::Remark(Severity::Warning)), [true; 3]);
        assert_eq!(volumes(Kind::Remark(Severity::Note)), [false, true, true]);
        assert_eq!(volumes(Kind::Progress), [false, true, true]);
        assert_eq!(volumes(Kind::Remark(Severity::Detail)), [false, false, true]);
        let label = |kind: Kind| kind.label().map(|(label, _)| label);
        assert_eq!(label(Kind::Failure), Some("raindrops:"));
        assert_eq!(label(Kind::Remark(Severity::Warning)), Some("warning:"));
        assert_eq!(label(Kind::Remark(Severity::Note)), Some("note:"));
        assert_eq!(label(Kind::Progress), None);
        assert_eq!(label(Kind::Remark(Severity::Detail)), None);
    }

    #[test]
    fn times_are_rounded_up() {
        assert_eq!([0.4, 89.2, 121.0].map(about), ["1 s", "90 s", "3 min"]);
    }

    #[test]
    fn colors_are_known_before_the_command_line_is_parsed() {
        let of = |line: &str| color_of(line.split(' ').map(String::from));
        assert_eq!(of("raindrops render --help"), ColorChoice::Auto);
        assert_eq!(of("raindrops --color never --help"), ColorChoice::Never);
        assert_eq!(of("raindrops render --color=always -h"), ColorChoice::Always);
        assert_eq!(of("raindrops --color"), ColorChoice::Auto);
    }
}
