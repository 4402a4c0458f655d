//! `accuracy-chart transform`: what the way from radii to a picture costs, on every graphics adapter that is here.
//!
//! Owns its flags and what it prints; the measurement and the files are the library's.
//! Invariant: a name that fits no adapter is refused before the folder is made.

use std::io::Write;
use std::path::PathBuf;

use indicatif::{ProgressBar, ProgressStyle};
use pottery_client::render::Gpu;
use pottery_tests::chart::machine::Machine;
use pottery_tests::chart::{ChartError, transform};
use pottery_tests::printed::Printed;

#[derive(clap::Args, Debug)]
pub(crate) struct TransformFlags {
    /// Folder for transform.csv, transform.md and transform.png; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Up to 144,000 elements only, and fewer pictures
    #[arg(long)]
    quick: bool,
    /// Only adapters that have these words in their names, in any case
    #[arg(long, value_name = "WORDS")]
    adapter: Option<String>,
    /// Written into the files as the day of the measurement
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = crate::chart::date)]
    date: Option<String>,
}

/// Measures on every adapter, writes the files and prints the table.
pub(crate) fn run(flags: &TransformFlags) -> Result<(), Box<dyn std::error::Error>> {
    let mut adapters = Gpu::every();
    let names: Vec<_> = adapters.iter().map(|gpu| gpu.name().to_owned()).collect();
    adapters.retain(|gpu| flags.adapter.as_ref().is_none_or(|words| crate::has(gpu.name(), words)));
    match (adapters.is_empty(), names.is_empty()) {
        (true, true) => {
            let why = "no graphics adapter was found: install a driver, on Debian `apt install mesa-vulkan-drivers`";
            return Err(why.into());
        }
        (true, false) => return Err(format!("no adapter has such a name; there are: {}", names.join("; ")).into()),
        _ => {}
    }
    crate::make_folder(&flags.out)?;
    let grids = transform::grids(flags.quick);
    let bar = ProgressBar::new((grids.len() * adapters.len()) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:32.green} {pos}/{len} {msg}")?);
    let mut figures = Vec::new();
    for gpu in &adapters {
        for &grid in &grids {
            bar.set_message(format!("{} x {} on {}", grid.columns(), grid.rows(), gpu.name()));
            figures.extend(transform::measure(gpu, grid, flags.quick)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let machine = Machine::this(flags.date.clone());
    for (name, bytes) in transform::files(&figures, &machine)? {
        let path = flags.out.join(name);
        std::fs::write(&path, bytes).map_err(|source| ChartError::Write { path, source })?;
    }
    Ok(writeln!(Printed, "{}", transform::page(&figures, &machine))?)
}
