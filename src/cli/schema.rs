//! `raindrops schema`: what editors and other programs need to complete and check scene files.

use clap::Args;

use super::{Answer, print};
use crate::scene::schema;

/// Print what a scene file may hold, as a JSON Schema: every key, its meaning, range and default
///
/// An editor that knows TOML by schemas (Taplo, Even Better TOML) completes a scene whose first line names the file:
/// #:schema scene.schema.json
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct SchemaArgs {}

/// Runs the command.
pub fn run() -> anyhow::Result<Answer> {
    print(serde_json::to_string_pretty(&schema())?)?;
    Ok(Answer::Yes)
}
