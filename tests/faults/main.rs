//! What goes wrong beneath the program, and what must not grow: a process of its own, as calls are replaced and memory is
//! the process's.

#[path = "../common/mod.rs"]
mod common;

mod failing_calls;
mod leaks;
mod validation;
