//! `accuracy-chart failures`: what each method comes to where methods fail.
//!
//! Owns its flags and what it prints; scenarios and files are the library's.
//! Invariant: a name that fits no scenario is refused before anything is run.

use std::io::Write;
use std::path::PathBuf;

use pottery_tests::failures::{self, SCENARIOS, Scenario};
use pottery_tests::printed::{Printed, remark};

#[derive(clap::Args, Debug)]
pub(crate) struct FailuresFlags {
    /// Folder for failures.csv and failures.md; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Only scenarios that have these words in their names, in any case
    #[arg(long, value_name = "WORDS")]
    only: Option<String>,
}

/// Puts every method through the scenarios, writes the table and prints it.
pub(crate) fn run(flags: &FailuresFlags) -> Result<(), Box<dyn std::error::Error>> {
    let chosen = |scenario: &Scenario| flags.only.as_ref().is_none_or(|words| crate::has(scenario.name, words));
    if !SCENARIOS.iter().any(chosen) {
        let names: Vec<_> = SCENARIOS.iter().map(|scenario| scenario.name).collect();
        return Err(format!("no scenario has such a name; there are: {}", names.join("; ")).into());
    }
    crate::make_folder(&flags.out)?;
    let outcomes = failures::run(chosen, |scenario| remark(scenario.name));
    failures::write(&outcomes, &flags.out)?;
    writeln!(Printed, "{}", failures::table(&outcomes))?;
    Ok(())
}
