//! The `raindrops` command: parse, dispatch, exit status.

use std::process::ExitCode;

fn main() -> ExitCode {
    raindrops::cli::main()
}
