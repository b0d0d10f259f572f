//! `raindrops completions`: what a shell needs to complete commands, options and model names.

use clap::Args;
use clap_complete::Shell;

use super::{Answer, print};

/// Print completions for a shell
///
/// bash: raindrops completions bash > ~/.local/share/bash-completion/completions/raindrops
/// zsh:  raindrops completions zsh > DIR/_raindrops, with DIR in $fpath
/// fish: raindrops completions fish > ~/.config/fish/completions/raindrops.fish
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the command; `cli` is the whole command line.
pub fn run(args: &CompletionsArgs, cli: &mut clap::Command) -> anyhow::Result<Answer> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, cli, "raindrops", &mut script);
    print(String::from_utf8_lossy(&script).trim_end())?;
    Ok(Answer::Yes)
}
