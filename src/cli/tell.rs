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
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value = "auto")]
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

/// Whether the passes and times of a frame are asked for.
pub fn is_verbose() -> bool {
    VOLUME.load(Ordering::Relaxed) == VERBOSE
}

/// Whether only warnings and errors are asked for.
pub fn is_quiet() -> bool {
    VOLUME.load(Ordering::Relaxed) == QUIET
}

/// Prints a line. What it begins with says what it is: `warning:`, `error:` and `raindrops:` are printed in any case,
/// other lines not with `-q`.
pub fn line(line: &str) {
    let label = |name: &str| line.strip_prefix(name).map(|rest| (name.to_string(), rest));
    let important = ["warning:", "error:", "raindrops:"].into_iter().find_map(label);
    let style = Style::new().bold().for_stderr();
    match important {
        Some((name, rest)) => {
            let style = if name == "warning:" { style.yellow() } else { style.red() };
            eprintln!("{}{rest}", style.apply_to(name));
        }
        None if is_quiet() => {}
        None => match label("note:") {
            Some((name, rest)) => eprintln!("{}{rest}", style.cyan().apply_to(name)),
            None => eprintln!("{line}"),
        },
    }
}

/// Prints a line as [`line`](fn@line) does, unless this run has printed it already.
pub fn once(text: String) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    // Whoever panicked while it was locked has left a whole set.
    let is_new = SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone());
    if is_new {
        line(&text);
    }
}

/// Prints what is worth saying of a thing, once in a run; details only where they are asked for.
pub fn remark(of: &str, remark: &Remark) {
    match remark.severity {
        Severity::Detail if !is_verbose() => {}
        Severity::Detail => once(format!("{of}: {remark}")),
        Severity::Note => once(format!("note: {of}: {remark}")),
        Severity::Warning => once(format!("warning: {of}: {remark}")),
    }
}

/// A time as an estimate is told: `48 s`, `3 min`.
pub fn about(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 90.0 => format!("{} s", seconds.ceil()),
        seconds => format!("{} min", (seconds / 60.0).ceil()),
    }
}

/// Prints a line on stderr, formatted; see [`line`](fn@line).
macro_rules! say {
    ($($argument:tt)*) => { $crate::cli::tell::line(&format!($($argument)*)) };
}
pub(super) use say;

/// As [`say!`], once in a run.
macro_rules! say_once {
    ($($argument:tt)*) => { $crate::cli::tell::once(format!($($argument)*)) };
}
pub(super) use say_once;

#[cfg(test)]
mod tests {
    use super::*;

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
