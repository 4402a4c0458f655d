//! `accuracy-chart`: what the methods make of a press, in figures that can be held against a reference.
//!
//! Owns the command line; each command has a file of its own.
//! Invariant: whatever makes no sense is refused in one sentence before anything is written.

mod chart;
mod dent;
mod failures;
mod finite_elements;
mod fit;
mod guidance;
mod network;
mod progress;
mod stability;
mod transform;

use std::path::Path;
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand};
use pottery_files::flags::first_sentence;
use pottery_files::sentence::sentence;
use pottery_tests::printed::remark;

const EXAMPLES: &str = "\
Examples:
  accuracy-chart --out chart --quick
      every figure and picture in a few minutes; begin with chart/index.md
  accuracy-chart dent --method ours --depth-mm 2 --release --out dent.csv
      what stays of one press, as theta_rad,z_mm,u_r_mm of every element
  accuracy-chart dent --method improved --rpm 60 --feed-mm-per-rev 3 --turns 2 --out groove.csv
      the same after two turns of the wheel
  accuracy-chart dent --method ours --rpm 600 --feed-mm-per-rev 0.5 --turns 60 --profile --out groove.csv
      a groove along a fast wheel, which is advanced as a profile wherever that is within a percent of the depth
  accuracy-chart failures --out failures
      which method kicks, sinks, loses clay or breaks, and by how much
  accuracy-chart stability --out stability
      which method trembles in a hand, gives energy back or jolts, and how stiff it may be at which delay
  accuracy-chart guidance --out guidance
      what a student feels of a teacher through a bad network, and how much nearer it brings the tool
  accuracy-chart network --out network --quick
      how far predicted clay is off over bad lines, and what a byte of the network buys
  accuracy-chart transform --out transform
      what a picture costs with vertices made by the processor, as the paper's original did, and by the graphics card
  accuracy-chart fit
      where the constants of the studio's own clay come from, and how near they bring it";

/// Holds every method of deforming clay, and some yardsticks, against finite-element dents: how long a step takes, and
/// how far the dent, the force and the volume are from the reference.
#[derive(Debug, Parser)]
#[command(name = "accuracy-chart", version, after_help = EXAMPLES)]
#[command(allow_negative_numbers = true, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    chart: Option<chart::ChartFlags>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure everything and write figures and pictures into a folder, as without a command
    Chart(chart::ChartFlags),
    /// Press a sphere at mid-height into a still pot and write the outer surface
    #[command(allow_negative_numbers = true)]
    Dent(dent::DentFlags),
    /// Put every method through what makes methods fail, and print and write the table
    Failures(failures::FailuresFlags),
    /// Put every method into simulated hands, and print and write how firmly they can hold on
    Stability(stability::StabilityFlags),
    /// Give every way of guidance to simulated students, and print and write what it helps
    Guidance(guidance::GuidanceFlags),
    /// Play sessions over a network in memory, and write how far predicted clay is off and what bytes buy
    Network(network::NetworkFlags),
    /// Draw a pot that is being pressed, with its vertices made by the processor and by the graphics card
    Transform(transform::TransformFlags),
    /// Make a case of the finite-element reference again; from minutes to hours
    FiniteElements(finite_elements::FiniteElementsFlags),
    /// Fit the studio's own clay to the finite-element dents again, and print the constants beside those in use
    Fit(fit::FitFlags),
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(said) if !said.use_stderr() => said.exit(),
        Err(wrong) => {
            let program = Arguments::command();
            let commands = program.get_subcommands().map(clap::Command::get_name);
            return refused(&first_sentence(&wrong.to_string(), commands));
        }
    };
    let done = match (arguments.command, arguments.chart) {
        (Some(Command::Dent(flags)), _) => dent::run(&flags),
        (Some(Command::Failures(flags)), _) => failures::run(&flags),
        (Some(Command::Stability(flags)), _) => stability::run(&flags),
        (Some(Command::Guidance(flags)), _) => guidance::run(&flags),
        (Some(Command::Network(flags)), _) => network::run(&flags),
        (Some(Command::Transform(flags)), _) => transform::run(&flags),
        (Some(Command::FiniteElements(flags)), _) => finite_elements::run(&flags),
        (Some(Command::Fit(flags)), _) => fit::run(&flags),
        (Some(Command::Chart(flags)), _) | (None, Some(flags)) => chart::run(&flags),
        (None, None) => Err("say where the files shall go, with --out DIR (see --help)".into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&sentence(error.as_ref())),
    }
}

/// Makes the folder that files shall go to.
fn make_folder(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| {
        format!("the folder {} cannot be made: {}; choose another with --out", folder.display(), sentence(&error))
    })
}

/// Whether a name has these words in it, in any case.
fn has(name: &str, words: &str) -> bool {
    name.to_lowercase().contains(&words.to_lowercase())
}

fn refused(why: &dyn std::fmt::Display) -> ExitCode {
    remark(format_args!("accuracy-chart: {why}"));
    ExitCode::from(2)
}
