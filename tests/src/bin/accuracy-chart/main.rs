//! `accuracy-chart`: what the methods make of a press, in figures that can be held against a reference.
//!
//! Owns the command line; each command has a file of its own.
//! Invariant: whatever makes no sense is refused in one sentence before anything is written.

mod dent;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Presses, measures and writes down what the clay's methods do.
#[derive(Debug, Parser)]
#[command(name = "accuracy-chart", version, allow_negative_numbers = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Press a sphere at mid-height into a still pot and write the outer surface
    #[command(allow_negative_numbers = true)]
    Dent(dent::DentFlags),
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(said) if !said.use_stderr() => said.exit(),
        Err(wrong) => return refused(&first_sentence(&wrong.to_string())),
    };
    let Command::Dent(flags) = arguments.command;
    match dent::run(&flags) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&error),
    }
}

fn refused(why: &dyn std::fmt::Display) -> ExitCode {
    eprintln!("accuracy-chart: {why}");
    ExitCode::from(2)
}

/// What clap says is wrong, without its usage and tips.
fn first_sentence(text: &str) -> String {
    let lines = text.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let joined = lines.collect::<Vec<_>>().join(" ");
    format!("{} (see --help)", joined.strip_prefix("error: ").unwrap_or(&joined))
}
