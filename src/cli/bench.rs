//! `raindrops bench`
use super::Answer;
use clap::Args;
/// Bench
#[derive(Args)]
pub struct BenchArgs {}
/// Runs the command.
pub fn run(_: &BenchArgs) -> anyhow::Result<Answer> {
    Ok(Answer::Yes)
}
