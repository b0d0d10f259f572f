//! How far long work is: a bar on a terminal, lines where there is none.

use std::io::IsTerminal as _;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::tell::{detail, is_quiet, say};

/// How often a line says how far work is, where there is no terminal for a bar.
const EVERY: Duration = Duration::from_secs(30);

/// A progress bar on stderr; where that is no terminal, a line from time to time. With the unit `%` it says which part of
/// the length is done.
pub(super) fn progress(length: u64, unit: &str) -> ProgressBar {
    let template = match unit {
        "%" => "{bar:40} {percent} % {msg} [{elapsed} < {eta}]",
        _ => "{bar:40} {pos}/{len} {unit} {msg} [{elapsed} < {eta}]",
    };
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let style = style.with_key("unit", {
        let unit = unit.to_string();
        move |_: &ProgressState, f: &mut dyn std::fmt::Write| {
            let _ = f.write_str(&unit);
        }
    });
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length).with_style(style);
    if !std::io::stderr().is_terminal() {
        let (weak, unit) = (bar.downgrade(), unit.to_string());
        // It ends with the bar.
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(EVERY);
                let Some(bar) = weak.upgrade().filter(|bar| !bar.is_finished()) else { return };
                let (at, message, s) = (bar.position(), bar.message(), bar.elapsed().as_secs());
                let done = match unit.as_str() {
                    "%" => format!("{} %", 100 * at / length.max(1)),
                    _ => format!("{at} of {length} {unit}"),
                };
                let message = if message.is_empty() { message } else { format!(": {message}") };
                say!("{done} after {s} s{message}");
            }
        });
    }
    bar
}

/// Does some work; if it takes long, says on stderr what it is, then how long it has taken so far. With `-v` also at the
/// end.
pub(super) fn waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let (done, is_done) = std::sync::mpsc::channel::<()>();
    let since = Instant::now();
    let outcome = std::thread::scope(|scope| {
        scope.spawn(move || {
            let mut patience = Duration::from_secs(1);
            while is_done.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                say!("{what}: {:.0} s", since.elapsed().as_secs_f64());
                patience = Duration::from_secs(10);
            }
        });
        let outcome = work();
        drop(done);
        outcome
    });
    detail!("{what}: done in {:.2} s", since.elapsed().as_secs_f64());
    outcome
}
