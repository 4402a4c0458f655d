//! Which wheels somebody looks on at, and how closely, as it is said on the command line.
//!
//! Owns names and bounds; asks nobody.
//! Invariant: what is chosen can be asked for of any server.

use anyhow::ensure;
use clap::{Args, ValueEnum};
use pottery_shared::snapshot::{Detail, QUANTUM_M, Quantum, SnapshotClock};

#[derive(Args, Clone, Debug)]
pub(crate) struct WatchFlags {
    /// Look on instead of working: at all wheels as small pictures, or closely at one
    #[arg(long, value_enum, value_name = "DETAIL", conflicts_with = "record")]
    watch: Option<WatchName>,
    /// How fine the clay is told to who looks on at one wheel, µm: 3.9 to 970, for a line that carries little; with it nothing is pressed
    /// again
    #[arg(long, value_name = "UM", requires = "watch", value_parser = quantum)]
    watch_quantum: Option<Quantum>,
    /// How often the clay is told to who looks on at one wheel, Hz: 1 to 60, or the next above of 60 divided by a whole number; with it nothing
    /// is pressed again
    #[arg(long, value_name = "HZ", requires = "watch", value_parser = every)]
    watch_rate: Option<u8>,
}

/// How closely somebody looks on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum WatchName {
    /// Every element, 30 times a second: what is pressed is pressed again, or, where that is too much, the clay to 11 µm
    Spectator,
    /// In small pictures, as fine and as often as their size shows; headless, a coarse grid 5 times a second
    Gallery,
}

impl WatchName {
    pub(crate) const fn detail(self) -> Detail {
        match self {
            Self::Spectator => Detail::RETOLD,
            Self::Gallery => Detail::GALLERY,
        }
    }
}

impl WatchFlags {
    /// What somebody is told who only looks on.
    pub(crate) fn detail(&self) -> anyhow::Result<Option<Detail>> {
        let Some(watch) = self.watch else { return Ok(None) };
        if self.watch_quantum.is_none() && self.watch_rate.is_none() {
            return Ok(Some(watch.detail()));
        }
        ensure!(
            watch == WatchName::Spectator,
            "small pictures are told what their size can show: leave --watch-quantum and --watch-rate out, or say --watch spectator"
        );
        let every = self.watch_rate.unwrap_or(Detail::SPECTATOR.every() as u8);
        Ok(Some(Detail::new(self.watch_quantum.unwrap_or(Quantum::SPECTATOR), 1, every)?.with_tools()))
    }
}

/// A quantum, rounded down to one that there is.
fn quantum(text: &str) -> Result<Quantum, String> {
    let step_um = f64::from(QUANTUM_M) * 1e6;
    let steps = text.parse::<f64>().map(|um| um / step_um).ok();
    let steps = steps.filter(|steps| (1.0..257.0).contains(steps)).ok_or("choose a number of µm from 3.9 to 970")?;
    Ok(Quantum::of_steps(steps as u16))
}

/// Of how many snapshots one is told, for the next rate above that there is.
fn every(text: &str) -> Result<u8, String> {
    let per_second = SnapshotClock::PER_SECOND as f64;
    let rate = text.parse::<f64>().ok().filter(|rate| (1.0..=per_second).contains(rate));
    Ok((per_second / rate.ok_or("choose a number of times a second from 1 to 60")?).floor() as u8)
}
