//! The commands as a shell runs them: what they print, write, refuse, and how they end.

#[path = "../common/mod.rs"]
mod common;

mod bench;
mod command_line;
mod compare_command;
mod data_sets;
mod full_disk;
mod long_bench;
mod messages;
mod rain_command;
mod readers;
mod recipes;
mod rounds;
mod sequences;
mod survey;
mod tradeoff_command;
