//! Prints small faults of a source in Rust or GLSL, each wherever it fits, as JSON: what a hand slips on, by no author's
//! choice.
//!
//! `cargo run --manifest-path tests/generator/Cargo.toml -- FILE`. A package of its own: what it needs of the parsers would
//! make every build of the tests slower.

mod glsl;
mod rust;

use std::ops::Range;

use serde::Serialize;

/// A fault: what stands in a place of the source instead.
#[derive(Serialize)]
struct Fault {
    /// Bytes of the source.
    place: Range<usize>,
    put: String,
    line: usize,
}

fn main() {
    let path = std::env::args().nth(1).expect("the name of a source");
    let source = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let faults = if path.ends_with(".rs") { rust::faults(&source) } else { glsl::faults(&source) };
    println!("{}", serde_json::to_string(&faults).expect("JSON"));
}
