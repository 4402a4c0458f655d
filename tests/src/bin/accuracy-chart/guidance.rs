//! `accuracy-chart guidance`: what a student feels of a teacher far away, and what it helps.
//!
//! Owns its flags and what it prints; lessons and files are the library's.
//! Invariant: what is printed is what is written.

use std::io::Write;
use std::path::PathBuf;

use pottery_tests::printed::Printed;
use pottery_tests::{chart, stability};

#[derive(clap::Args, Debug)]
pub(crate) struct GuidanceFlags {
    /// Folder for guidance.csv and guidance.png; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Gives every lesson to every hand, writes table and picture and prints the table.
pub(crate) fn run(flags: &GuidanceFlags) -> Result<(), Box<dyn std::error::Error>> {
    crate::make_folder(&flags.out)?;
    let figures = stability::measure_guidance();
    for (name, bytes) in chart::guidance::files(&figures)? {
        let path = flags.out.join(name);
        std::fs::write(&path, bytes).map_err(|source| chart::ChartError::Write { path, source })?;
    }
    Ok(write!(Printed, "{}", chart::csv::text(&figures))?)
}
