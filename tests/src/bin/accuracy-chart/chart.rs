//! `accuracy-chart --out DIR`: the whole chart.
//!
//! Owns its flags and what it prints; measurements, files and pictures are the library's.
//! Invariant: the folder is made before anything is measured, so that minutes are not spent for nothing.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use pottery_tests::chart;
use pottery_tests::chart::extent::Extent;
use pottery_tests::chart::machine::Machine;
use pottery_tests::printed::{Printed, remark};

#[derive(clap::Args, Debug)]
pub(crate) struct ChartFlags {
    /// Folder for the figures, the pictures and index.md, which shows them; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Under five minutes: fewer steps, travels and pitches
    #[arg(long)]
    quick: bool,
    /// Written into the files as the day of the measurement
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = date)]
    date: Option<String>,
}

const DATE_IS: &str = "write it like 2026-08-21";

/// A day there is, in the form of ISO 8601.
pub(crate) fn date(text: &str) -> Result<String, String> {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |part: &str, digits: usize| {
        let is_number = part.len() == digits && part.bytes().all(|sign| sign.is_ascii_digit());
        is_number.then(|| part.parse::<u32>().ok()).flatten()
    };
    let [year, month, day] = parts[..] else { return Err(DATE_IS.to_owned()) };
    let (Some(year), Some(month), Some(day)) = (number(year, 4), number(month, 2), number(day, 2)) else {
        return Err(DATE_IS.to_owned());
    };
    let days = match month {
        2 if year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400)) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return Err("there are twelve months".to_owned()),
    };
    if (1..=days).contains(&day) { Ok(text.to_owned()) } else { Err(format!("that month has {days} days")) }
}

/// Measures, draws and writes.
pub(crate) fn run(flags: &ChartFlags) -> Result<(), Box<dyn std::error::Error>> {
    crate::make_folder(&flags.out)?;
    let machine = Machine::this(flags.date.clone());
    if machine.profile == "debug" {
        remark(format_args!("accuracy-chart: this is a debug build, whose times say little; build it with --release"));
    }
    let extent = if flags.quick { Extent::quick() } else { Extent::full() };
    let begin = Instant::now();
    let figures = crate::progress::shown(begin, |progress| chart::measure(extent, machine, progress))??;
    let files = chart::write(&figures, &flags.out)?;
    let after_s = begin.elapsed().as_secs_f64();
    writeln!(Printed, "{} files in {}, after {after_s:.0} s", files.len(), flags.out.display())?;
    writeln!(Printed, "begin with {}", flags.out.join("index.md").display())?;
    Ok(())
}
