//! `raindrops man`: manual pages, one for the program and one for each command.

use std::path::PathBuf;

use clap::Args;
use clap_mangen::Man;

use super::Answer;
use super::tell::say;
use crate::Error;
use crate::files::write_whole;

/// Write the manual pages
///
/// man -l DIR/raindrops.1 shows the first. Copied to ~/.local/share/man/man1 they are found by name.
#[derive(Args)]
pub struct ManArgs {
    /// Folder to write into; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the command; `cli` is the whole command line.
pub fn run(args: &ManArgs, mut cli: clap::Command) -> anyhow::Result<Answer> {
    std::fs::create_dir_all(&args.output).map_err(|error| Error::write(&args.output, error))?;
    cli.build();
    let mut pages = vec![("raindrops".to_string(), cli.clone())];
    for command in cli.get_subcommands().filter(|command| command.get_name() != "help") {
        pages.push((format!("raindrops-{}", command.get_name()), command.clone()));
    }
    let count = pages.len();
    for (name, command) in pages {
        let path = args.output.join(format!("{name}.1"));
        let mut text = Vec::new();
        let page = Man::new(command.display_name(&name)).title(name);
        page.render(&mut text).map_err(|error| Error::write(&path, error))?;
        write_whole(&path, &text)?;
    }
    say!("wrote {count} pages into {}", args.output.display());
    Ok(Answer::Yes)
}
