//! `accuracy-chart finite-elements`: makes a case of the finite-element reference again.
//!
//! Owns its flags and its files; the calculation is the library's.
//! Invariant: a file appears under its name only when it is complete.

use std::io::Write;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use pottery_files::sentence::sentence;
use pottery_tests::printed::Printed;
use pottery_tests::yardstick::fem::cases;

#[derive(clap::Args, Debug)]
pub(crate) struct FiniteElementsFlags {
    /// Which case
    #[arg(long, value_parser = PossibleValuesParser::new(cases::all().into_iter().map(|(name, _)| name)))]
    case: String,
    /// Folder for its tables; made if missing
    #[arg(long)]
    out: PathBuf,
}

/// Calculates the case and writes its tables as they come.
pub(crate) fn run(flags: &FiniteElementsFlags) -> Result<(), Box<dyn std::error::Error>> {
    let unwritable = |error: std::io::Error| format!("{} cannot be written: {}", flags.out.display(), sentence(&error));
    std::fs::create_dir_all(&flags.out).map_err(unwritable)?;
    let (mut failed, mut told) = (None, Ok(()));
    cases::make(&flags.case, |file| match std::fs::write(flags.out.join(&file.name), &file.text) {
        Ok(()) if told.is_ok() => told = writeln!(Printed, "{}", file.name),
        Ok(()) => {}
        Err(error) => failed = failed.take().or(Some(error)),
    })?;
    failed.map_or(Ok(()), |error| Err(unwritable(error)))?;
    Ok(told?)
}
