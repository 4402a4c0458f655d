//! The clay as it travels: quantised grids, versions, and the codec of their changes.
//!
//! Knows no connection: who gets which bytes is the room's affair. Snapshots form one chain a wheel: version n is
//! version n − 1 plus one delta, encoded once for everybody.
//! Invariant: at a snapshot the authoritative radii are those of their quantum steps (kept within the surface's bounds),
//! so that author and replica hold the same clay, bit for bit.

mod author;
mod chain;
mod coder;
mod grid;
mod kept;
mod ledger;
mod magnitude;
mod models;
mod motion;
mod plane;
mod publisher;
mod record;
mod replica;
mod sweep;
mod tier;
mod tiles;
mod transcript;

use crate::units::Tick;

pub use author::{Author, Delta};
pub use grid::{QUANTUM_M, Quantum, dequantise, quantise};
pub use kept::KeptClay;
pub(crate) use kept::{lay, steps_of};
pub use ledger::Ledger;
pub use motion::Moment;
pub use record::{PotRecord, RecordError};
pub use replica::{Replica, SnapshotError};
pub use tier::{Detail, Tier};
pub use tiles::{TILE_SIDE, TileLayout, Touched};
pub use transcript::{Pressed, Transcript};

/// Number of a snapshot in the chain of its wheel; 0 is the untouched pot that everybody can make by themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version(pub u32);

impl Version {
    /// The version that follows.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0 + 1)
    }
}

/// When snapshots are taken: a pure function of the tick, so that a predictor rounds where the author does.
#[derive(Clone, Copy, Debug)]
pub struct SnapshotClock;

impl SnapshotClock {
    /// Snapshots in a second.
    pub const PER_SECOND: u64 = 60;

    /// Snapshots taken up to the end of a tick.
    #[must_use]
    pub const fn count(tick: Tick) -> u64 {
        tick.0.saturating_add(1).saturating_mul(Self::PER_SECOND) / Tick::PER_SECOND
    }

    /// Whether a snapshot is taken at the end of a tick.
    #[must_use]
    pub const fn is_due(tick: Tick) -> bool {
        tick.0 > 0 && Self::any_within(Tick(tick.0 - 1), tick)
    }

    /// Whether a snapshot is taken at the end of any tick after `from`, up to and with `to`.
    #[must_use]
    pub const fn any_within(from: Tick, to: Tick) -> bool {
        Self::count(to) > Self::count(from)
    }
}

impl core::fmt::Display for Version {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "version {}", self.0)
    }
}
