//! Clay that is not the server's: how it is found out what differs, and how it comes right again.
//!
//! Owns when to ask and what was counted; the clay is the session's.
//! Invariant: from a difference on until clay has come that mends it, no snapshot is gone to, so that the version that was
//! told of is still the one held when the answer comes.

use core::time::Duration;

use crate::protocol::Request;
use crate::snapshot::{Replica, Version};

/// What was found and mended, or a sum of such counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MendCounts {
    /// How often the server was told what every tile is like.
    pub asked: u64,
    /// How often that did not help, and the whole pot was asked for.
    pub whole: u64,
    /// Tiles that differed and were sent.
    pub tiles: u64,
}

impl core::ops::AddAssign for MendCounts {
    fn add_assign(&mut self, other: Self) {
        let Self { asked, whole, tiles } = other;
        self.asked += asked;
        self.whole += whole;
        self.tiles = self.tiles.saturating_add(tiles);
    }
}

/// Where a client stands with clay that differs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mending {
    /// When it asks again, while it waits.
    ask_at: Option<Duration>,
    /// Times that it has asked since a digest last matched.
    times: u32,
    counts: MendCounts,
}

impl Mending {
    /// Times that it tells what its tiles are like before it asks for the whole pot: a tile may differ and have the same
    /// sixteen bits.
    const TILES_TIMES: u32 = 2;
    /// Time beside the round trip in which an answer is on its way; longer each time.
    const PATIENCE: Duration = Duration::from_millis(300);
    /// Longest time between two questions.
    const PATIENCE_MAX: Duration = Duration::from_secs(5);

    pub(super) const fn is_waiting(&self) -> bool {
        self.ask_at.is_some()
    }

    pub(super) const fn counts(&self) -> &MendCounts {
        &self.counts
    }

    /// What to ask for when the clay that is held differs.
    pub(super) fn begin(&mut self, replica: &Replica, now: Duration, round_trip: Duration) -> Request {
        self.times += 1;
        self.ask_at = Some(now + (round_trip + Self::PATIENCE * self.times).min(Self::PATIENCE_MAX));
        let tiles = replica.tile_digests();
        if self.times > Self::TILES_TIMES || tiles.len() > super::MEND_BYTES_MAX {
            self.counts.whole += 1;
            return Request::Resync { have: Version(0).0 };
        }
        self.counts.asked += 1;
        Request::Mend { have: replica.version().0, tiles }
    }

    /// The same again, when the answer does not come.
    pub(super) fn due(&mut self, replica: &Replica, now: Duration, round_trip: Duration) -> Option<Request> {
        (now >= self.ask_at?).then(|| self.begin(replica, now, round_trip))
    }

    /// Takes in that a keyframe was applied in which so many tiles had differed.
    pub(super) fn handle_keyframe(&mut self, tiles: u16) {
        self.ask_at = None;
        self.counts.tiles = self.counts.tiles.saturating_add(u64::from(tiles));
    }

    /// Takes in that the clay is the server's.
    pub(super) const fn handle_match(&mut self) {
        self.times = 0;
    }
}
