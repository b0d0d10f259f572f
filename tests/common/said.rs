//! What a run of the command has said on stderr, by the kind of its lines.
//!
//! How many lines there are depends on the machine: a busy one adds progress and warnings, one with several drivers notes. So
//! a test asks for the lines of a kind, and looks at all lines only for what must be there.

use std::process::Output;

/// What stands before an error, and before a reason why a check fails.
pub const FAILURE: &str = "raindrops: ";
/// What stands before a warning.
pub const WARNING: &str = "warning: ";

/// All of it.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The lines of a kind in a text, without what they begin with.
pub fn lines(said: &str, kind: &str) -> Vec<String> {
    said.lines().filter_map(|line| line.strip_prefix(kind).map(String::from)).collect()
}

/// Why a run failed, which is one line; it must have ended with this status.
#[track_caller]
pub fn failure(output: &Output, status: i32) -> String {
    let said = said(output);
    assert_eq!(output.status.code(), Some(status), "{said}");
    let [line] = &lines(&said, FAILURE)[..] else { panic!("not one error: {said}") };
    line.clone()
}
