//! When a snapshot is taken: on its beat, or as soon as what belongs into it is here.
//!
//! A prediction rounds the clay by the ticks that its own samples are stamped with. Where one hand alone presses, the room rounds between the same
//! samples, so that what was lost on the way and came late is pressed to the same clay, bit for bit. Several hands are not waited for.
//! Invariant: a wheel at which one hand alone presses is never rounded between two samples that belong into one snapshot, but after [`WAITS_MAX`].

use super::Bench;
use crate::room::PeerId;
use crate::units::Tick;

/// Ticks for which a snapshot waits at most: whoever is silent for longer is met by clay as the others have it.
const WAITS_MAX: i64 = 2_000;

/// Who has pressed since the last snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Pressers {
    #[default]
    Nobody,
    /// One hand, with the tick of its sample that was pressed last.
    One(PeerId, Tick),
    Several,
}

/// What a snapshot that is due waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    Nothing,
    /// Samples that are on their way, or lost.
    Samples,
    /// Its own beat: what was pressed since the one before belongs into the next.
    Later,
}

impl Pressers {
    pub(super) fn note(&mut self, peer: PeerId, tick: Tick) {
        *self = match *self {
            Self::Nobody => Self::One(peer, tick),
            Self::One(other, _) if other == peer => Self::One(peer, tick),
            Self::One(..) | Self::Several => Self::Several,
        };
    }
}

impl Bench {
    /// Whether the next sample of the hand that alone has pressed belongs into a later snapshot than those pressed so far.
    pub(super) fn is_crossing(&self, tick: Tick) -> bool {
        let Pressers::One(peer, last) = self.pressers else { return false };
        let next = self.seats.get(&peer).and_then(|seat| seat.peer.inputs().next_tick());
        let next = next.filter(|&next| next <= tick && !self.touched.is_empty());
        next.is_some_and(|next| self.clock.any_within(last.offset(-1), next.offset(-1)))
    }

    /// Notes that a snapshot is due, if it is; whether one is to be taken now.
    pub(super) fn is_time(&mut self, tick: Tick) -> bool {
        if self.clock.is_due(tick) {
            self.owed_since.get_or_insert(tick);
        }
        let Some(since) = self.owed_since else { return false };
        let (is_owed, is_time) = match self.awaited(tick) {
            Awaited::Nothing => (false, true),
            Awaited::Later => (false, false),
            Awaited::Samples => (tick.since(since) < WAITS_MAX, tick.since(since) >= WAITS_MAX),
        };
        if !is_owed {
            self.owed_since = None;
        }
        is_time
    }

    /// What the snapshot that is due waits for.
    fn awaited(&self, tick: Tick) -> Awaited {
        let Pressers::One(peer, last) = self.pressers else { return Awaited::Nothing };
        let seat = self.seats.get(&peer).filter(|seat| !seat.leaving && self.hold.counts(seat));
        let Some(seat) = seat.filter(|_| !self.touched.is_empty() && !self.history.has_work()) else {
            return Awaited::Nothing;
        };
        // the snapshot into which the last sample belongs
        match (last.0..=tick.0).map(Tick).find(|&at| self.clock.is_due(at)) {
            None => Awaited::Later,
            Some(due) if seat.peer.inputs().is_through(due) => Awaited::Nothing,
            Some(_) => Awaited::Samples,
        }
    }
}
