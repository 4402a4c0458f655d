//! `accuracy-chart network`: how far predicted clay is off, and what a byte buys.
//!
//! Owns its flags and what is shown while it runs; measurements, files and pictures are the library's.
//! Invariant: a session that cannot be gone through is refused before the folder is made, and nothing is measured before both.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use pottery_tests::chart::network::{NetworkExtent, files, measure};
use pottery_tests::chart::{ChartError, csv};
use pottery_tests::printed::{Printed, remark};

const MEANING: &str = "\
What it writes:
  prediction.csv, .png      the clay under a hand against what the room made of the same samples, over way and back, loss, and how
                            much two tools overlap
  subscription.csv, .png    bytes a second against quantum and rate, and how far what is seen is off
  codecs.csv, .png          a snapshot in our codec, in simpler ones, and at least
  *.session                 the sessions that were recorded for it; 'pottery-studio replay FILE' shows them
How:
  The real server with its recorder and the real clients, joined by a network in memory, in virtual time.
What to choose:
  Where a line of subscription.png runs level, a finer quantum buys nothing any more: the clay is older than it is coarse.";

#[derive(clap::Args, Debug)]
#[command(after_help = MEANING)]
pub(crate) struct NetworkFlags {
    /// Folder for the figures, the pictures and the sessions; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Under two minutes: fewer lines, sessions and quanta, and shorter ones
    #[arg(long)]
    quick: bool,
    /// A session of your own to put through the codecs as well; may be given again
    #[arg(long, value_name = "FILE")]
    session: Vec<PathBuf>,
}

/// Measures, draws, writes, and prints the tables.
pub(crate) fn run(flags: &NetworkFlags) -> Result<(), Box<dyn std::error::Error>> {
    let extent = if flags.quick { NetworkExtent::quick() } else { NetworkExtent::full() };
    let begin = Instant::now();
    let figures = crate::progress::shown(begin, |progress| measure(&extent, &flags.out, &flags.session, progress))??;
    for (name, bytes) in files(&figures)? {
        let path = flags.out.join(name);
        std::fs::write(&path, bytes).map_err(|source| ChartError::Write { path, source })?;
    }
    write!(Printed, "{}", csv::text(&figures.prediction))?;
    write!(Printed, "{}", csv::text(&figures.subscription))?;
    write!(Printed, "{}", csv::text(&figures.codecs))?;
    remark(format_args!("{}: after {:.0} s", flags.out.display(), begin.elapsed().as_secs_f64()));
    Ok(())
}
