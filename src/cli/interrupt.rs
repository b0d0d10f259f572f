//! Ctrl-C and SIGTERM, respected between frames and between processes, so that what is written is whole.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

use crate::files::between_files;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// A process of ours is under way, which must be ended before this one.
static AT_WORK: AtomicBool = AtomicBool::new(false);

/// It was asked to end.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

impl Interrupted {
    /// Exit status of a command that was interrupted, as shells have it.
    pub const STATUS: u8 = 130;
}

/// From now on [`is_interrupted`] reports an interrupt; a second one ends this process at once, but not while it has
/// another under way.
///
/// # Errors
/// If there can be no handler.
pub fn heed_interrupts() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) && !AT_WORK.load(Ordering::SeqCst) {
            let _held = between_files();
            end_at_once(Interrupted::STATUS.into());
        }
    })
    .context("no handler of interrupts")
}

/// Ends this process without the destructors of libraries: a driver's would run beside its own threads, and lavapipe then
/// crashes once in some dozens of times.
#[cfg(unix)]
fn end_at_once(status: i32) -> ! {
    // SAFETY: it has no conditions.
    unsafe { nix::libc::_exit(status) }
}

/// Ends the process as the Unix function does. `ExitProcess` would end the other threads first and then run the destructors, which may wait for what those held.
#[cfg(windows)]
fn end_at_once(status: i32) -> ! {
    use windows_sys::Win32::System::Threading::{GetCurrentProcess, TerminateProcess};
    // SAFETY: the handle is this process's own.
    unsafe { TerminateProcess(GetCurrentProcess(), status as u32) };
    // Not reached, unless the system refuses.
    std::process::exit(status)
}

/// Whether it was asked to end.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// Says whether a process of ours is under way.
pub fn set_at_work(is_at_work: bool) {
    AT_WORK.store(is_at_work, Ordering::SeqCst);
}
