//! A pot file turned into what other programs read.
//!
//! Invariant: every ending is looked at before anything is written.

use std::path::PathBuf;

use pottery_client::export::{Format, export};
use pottery_client::pot_file::PotFile;

/// What to read, and what to write.
#[derive(Clone, Debug)]
pub(crate) struct Conversion {
    pub(crate) pot: PathBuf,
    pub(crate) out: Vec<PathBuf>,
}

/// Writes every file that is asked for.
pub(crate) fn run(conversion: &Conversion) -> anyhow::Result<()> {
    for path in &conversion.out {
        Format::of(path)?;
    }
    let pot = PotFile::read(&conversion.pot)?.pot().pot();
    for path in &conversion.out {
        export(&pot, path)?;
        say!("written    {}", path.display());
    }
    Ok(())
}
