//! How scripted potters work, as it is said on the command line.
//!
//! Owns names, defaults and bounds; opens nothing.
//! Invariant: a flag that was given and that nobody follows can be named.

use std::path::PathBuf;

use anyhow::ensure;
use clap::{Args, ValueEnum};
use pottery_client::flags::number_from;

/// What is taken where nothing is said.
const POTTERS: u16 = 3;
const SECONDS: f64 = 10.0;
const OUT: &str = "studio-out";

#[derive(Args, Clone, Debug)]
pub(crate) struct HeadlessFlags {
    /// Work without a window
    #[arg(long)]
    pub(crate) headless: bool,
    /// Scripted potters (headless) [default: 3]
    #[arg(long, value_parser = number_from(1_u16, 16))]
    potters: Option<u16>,
    /// How long they work, s (headless) [default: 10]
    #[arg(long, value_parser = number_from(0.5, 86_400.0))]
    seconds: Option<f64>,
    /// Folder for pot.pot, pot.stl, pot.png and session.json (headless) [default: studio-out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Stroke file that a potter replays instead of its own; repeat it for more potters (headless)
    #[arg(long, value_name = "FILE")]
    pub(crate) stroke: Vec<PathBuf>,
    /// Whether scripted hands follow their stroke exactly or as a hand that the clay pushes back (headless) [default: scripted]
    #[arg(long, value_enum)]
    hand: Option<HandKind>,
}

/// How a scripted hand holds its tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum HandKind {
    /// Exactly on the stroke, whatever it feels
    Scripted,
    /// Mass, spring and damper between the stroke and the tool
    Simulated,
}

impl HeadlessFlags {
    /// How many potters there are.
    ///
    /// # Errors
    /// When more strokes are given.
    pub(crate) fn potters(&self) -> anyhow::Result<usize> {
        let potters = self.potters.unwrap_or(POTTERS);
        let strokes = self.stroke.len();
        let noun = if potters == 1 { "potter" } else { "potters" };
        ensure!(
            strokes <= usize::from(potters),
            "{strokes} strokes are too many for {potters} {noun}; raise --potters"
        );
        Ok(potters.into())
    }

    /// How long they work.
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds.unwrap_or(SECONDS)
    }

    /// The folder for what comes of it.
    pub(crate) fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| OUT.into())
    }

    pub(crate) fn hand(&self) -> HandKind {
        self.hand.unwrap_or(HandKind::Scripted)
    }

    /// The flags that were given and that nobody in a window follows.
    pub(crate) fn given(&self) -> Vec<&'static str> {
        let flags = [
            ("--potters", self.potters.is_some()),
            ("--seconds", self.seconds.is_some()),
            ("--out", self.out.is_some()),
            ("--stroke", !self.stroke.is_empty()),
            ("--hand", self.hand.is_some()),
        ];
        flags.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name).collect()
    }
}
