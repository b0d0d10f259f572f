//! Ctrl-C during long computations: they run on a thread of their own, while the caller's listens for signals.

use std::panic::resume_unwind;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::process::lock;

/// Whether what runs is to end early. Python gives signals to one thread, but a Ctrl-C is meant for all that runs.
static STOP: AtomicBool = AtomicBool::new(false);
/// How many computations run.
static RUNNING: Mutex<u32> = Mutex::new(0);

/// How long a signal waits at most.
const TURN: Duration = Duration::from_millis(50);

/// Whether a computation is to end early.
pub fn stop() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// What `work` makes, without the interpreter's lock; `work` asks [`stop`] now and then.
///
/// # Errors
/// What a handler of signals has raised, such as `KeyboardInterrupt`, in whichever thread.
pub fn listening<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    *lock(&RUNNING) += 1;
    let mut signal = None;
    let made = py.detach(|| {
        thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            let running = scope.spawn(move || {
                let made = work();
                drop(done);
                made
            });
            while let Err(RecvTimeoutError::Timeout) = is_done.recv_timeout(TURN) {
                if let Err(raised) = Python::attach(|py| py.check_signals()) {
                    STOP.store(true, Ordering::Relaxed);
                    signal = Some(raised);
                }
            }
            running.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    });
    let was_stopped = stop();
    let mut running = lock(&RUNNING);
    *running -= 1;
    if *running == 0 {
        STOP.store(false, Ordering::Relaxed);
    }
    match signal {
        Some(raised) => Err(raised),
        None if was_stopped => Err(pyo3::exceptions::PyKeyboardInterrupt::new_err("interrupted")),
        None => Ok(made),
    }
}
