//! `accuracy-chart stability`: how firmly a hand can hold on to the clay of each method.
//!
//! Owns its flags and what it prints; scenarios, edges and files are the library's.
//! Invariant: a name that fits no scenario is refused before anything is run.

use std::io::Write;
use std::path::PathBuf;

use pottery_tests::failures::{self, Scenario};
use pottery_tests::printed::{Printed, remark};
use pottery_tests::stability::{self, Edges, PLANE_DELAYS_S, SCENARIOS, Stage};

#[derive(clap::Args, Debug)]
pub(crate) struct StabilityFlags {
    /// Folder for stability.csv, stability.md, stability-plane.csv, stability-plane.png, stability-clay.csv and stability-far.csv; made when it
    /// is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Only scenarios that have these words in their names, in any case, and neither plane nor the tables beside it
    #[arg(long, value_name = "WORDS")]
    only: Option<String>,
    /// Stages of ours that are left out, to see what each is for
    #[arg(long, value_name = "STAGE", value_delimiter = ',')]
    without: Vec<Stage>,
}

/// Puts every method through the scenarios, writes table and edges and prints the table.
pub(crate) fn run(flags: &StabilityFlags) -> Result<(), Box<dyn std::error::Error>> {
    let chosen = |scenario: &Scenario| flags.only.as_ref().is_none_or(|words| crate::has(scenario.name, words));
    if !SCENARIOS.iter().any(chosen) {
        let names: Vec<_> = SCENARIOS.iter().map(|scenario| scenario.name).collect();
        return Err(format!("no scenario has such a name; there are: {}", names.join("; ")).into());
    }
    crate::make_folder(&flags.out)?;
    stability::leave_out(&flags.without);
    let outcomes = failures::run_of(SCENARIOS, chosen, |scenario| remark(scenario.name));
    let edges = flags.only.is_none().then(|| Edges::measure(&PLANE_DELAYS_S));
    stability::write(&outcomes, edges.as_ref(), &flags.out)?;
    writeln!(Printed, "{}", failures::table(&outcomes))?;
    Ok(())
}
