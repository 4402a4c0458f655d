//! The clay as it travels: quantised grids, versions, and the codec of their changes.
//!
//! Knows no connection: who gets which bytes is the room's affair. Snapshots form one chain a wheel: version n is
//! version n − 1 plus one delta, encoded once for everybody.
//! Invariant: at a snapshot the authoritative radii are those of their quantum steps (kept within the surface's bounds),
//! so that author and replica hold the same clay, bit for bit.

mod author;
mod chain;
mod detail;
mod grid;
mod kept;
mod ledger;
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
pub use detail::{Band, Detail, DetailError};
pub use grid::{QUANTUM_M, Quantum, dequantise, quantise, tile_digest};
pub use kept::KeptClay;
pub(crate) use kept::{lay, steps_of};
pub use ledger::Ledger;
pub use motion::Moment;
pub use record::{PotRecord, RecordError};
pub use replica::{Replica, SnapshotError};
pub use tier::Tier;
pub use tiles::{TILE_SIDE, TileLayout, Touched};
pub use transcript::{Pressed, Transcript};

/// Number of a snapshot in the chain of its wheel; 0 is the untouched pot that everybody can make by themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version(pub u32);

impl Version {
    /// The version that follows. After the last there is, which a wheel comes to in two years and a false word at once, it is 0, to
    /// which nothing leads.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0.wrapping_add(1))
    }
}

/// When snapshots of a wheel are taken: a pure function of the tick, so that a predictor rounds where the author does.
///
/// Wheels take theirs at different times, so that a server does not do the work of all of them at once; the default is the first wheel's.
///
/// ```
/// use pottery_shared::snapshot::SnapshotClock;
/// use pottery_shared::units::Tick;
///
/// let due = |wheel| (0..50).map(Tick).filter(|tick| SnapshotClock::of_wheel(wheel).is_due(*tick)).map(|tick| tick.0).collect::<Vec<_>>();
/// assert_eq!((due(0), due(1)), (vec![16, 33, 49], vec![8, 25, 41]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SnapshotClock {
    /// Ticks by which this wheel's are taken earlier than the first one's.
    ahead: u8,
}

impl SnapshotClock {
    /// Snapshots in a second.
    pub const PER_SECOND: u64 = 60;
    /// Ticks by which wheels are ahead, in turn: as far from those before as can be, and two ticks apart.
    const AHEAD: [u8; 8] = [0, 8, 4, 12, 2, 10, 6, 14];

    /// That of a wheel, counted from zero.
    #[must_use]
    pub const fn of_wheel(wheel: usize) -> Self {
        Self { ahead: Self::AHEAD[wheel % Self::AHEAD.len()] }
    }

    /// That of a wheel whose snapshots are so many ticks ahead; `None` when that is more than the time between two.
    #[must_use]
    pub const fn with_ahead(ahead: u8) -> Option<Self> {
        if (ahead as u64 + 1) * Self::PER_SECOND < Tick::PER_SECOND { Some(Self { ahead }) } else { None }
    }

    /// Ticks by which snapshots are taken earlier than at the first wheel.
    #[must_use]
    pub const fn ahead(self) -> u8 {
        self.ahead
    }

    /// Snapshots taken up to the end of a tick.
    #[must_use]
    pub const fn count(self, tick: Tick) -> u64 {
        tick.0.saturating_add(1 + self.ahead as u64).saturating_mul(Self::PER_SECOND) / Tick::PER_SECOND
    }

    /// Whether a snapshot is taken at the end of a tick.
    #[must_use]
    pub const fn is_due(self, tick: Tick) -> bool {
        tick.0 > 0 && self.any_within(Tick(tick.0 - 1), tick)
    }

    /// Whether a snapshot is taken at the end of any tick after `from`, up to and with `to`.
    #[must_use]
    pub const fn any_within(self, from: Tick, to: Tick) -> bool {
        self.count(to) > self.count(from)
    }
}

impl core::fmt::Display for Version {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "version {}", self.0)
    }
}
