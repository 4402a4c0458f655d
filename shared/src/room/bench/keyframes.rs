//! Clay that is told whole, or as far as it differs: to newcomers, to who missed too much, to who holds something else.
//!
//! Owns what is answered to who asks; what goes to everybody is `pulses`'.
//! Invariant: who asks for what is on its way over a full line gets no second one of it.

use alloc::vec::Vec;
use core::ops::Range;

use super::pulses::lead_on;
use super::{Bench, Outbox, Whole};
use crate::protocol::{self, Keyframe};
use crate::room::{Lane, PeerId, Transmit};
use crate::session::Telling;
use crate::snapshot::Version;
use crate::units::Tick;

/// Snapshots after which a keyframe is made anew for those who come: a quarter of a second.
const WHOLE_VERSIONS_MAX: u32 = 15;
/// Ticks that a keyframe may take before it is sent once more, and over a line that is full.
const ANSWER_TICKS: i64 = 300;
const ANSWER_TICKS_FULL: i64 = 1000;

impl Bench {
    /// Answers a request for a keyframe, unless one that answers it too is still on its way over a line that is full.
    pub(in crate::room) fn answer_resync(&mut self, peer: PeerId, have: u32, now: Tick, outbox: &mut Outbox) {
        // who asks for all of it, and not for what it has missed, holds something else
        if have > 0 && self.is_coming(peer, have, now) {
            return;
        }
        let latest = self.author.latest().0;
        let Some(seat) = self.seats.get_mut(&peer) else { return };
        seat.answered = Some((have..latest, now));
        self.resync(peer, have, outbox);
    }

    /// Whether a keyframe that leads on from `have` was sent so lately that it may still be on its way.
    fn is_coming(&self, peer: PeerId, have: u32, now: Tick) -> bool {
        let Some(seat) = self.seats.get(&peer) else { return false };
        let answer_ticks = if seat.telling == Telling::Asked { ANSWER_TICKS_FULL } else { ANSWER_TICKS };
        // what leads on from an older one leads on from this one as well, which may have come by pulses that were still on their way
        let is_coming = |(over, at): &(Range<u32>, Tick)| over.contains(&have) && now.since(*at) < answer_ticks;
        seat.answered.as_ref().is_some_and(is_coming)
    }

    /// Says again what leads on from `have`: with the next pulse, or in a keyframe when that is no longer kept.
    pub(in crate::room) fn say_again(&mut self, peer: PeerId, have: u32, now: Tick, outbox: &mut Outbox) {
        self.note_loss(peer, now);
        let Some(seat) = self.seats.get_mut(&peer) else { return };
        if (seat.retells || seat.telling != Telling::Asked) && lead_on(&self.ways, Version(have), seat.retells) {
            seat.again_from = Some(Version(have));
        } else if !self.is_coming(peer, have, now) {
            self.answer_resync(peer, have, now, outbox);
        }
    }

    /// Whether there is no such snapshot yet: nobody holds it, and nothing leads on from it.
    pub(in crate::room) const fn never_was(&self, have: u32) -> bool {
        have > self.author.latest().0
    }

    /// Sends one peer everything newer than `have`.
    pub(in crate::room) fn resync(&mut self, peer: PeerId, have: u32, outbox: &mut Outbox) {
        if have == 0 {
            return self.send_whole(peer, outbox);
        }
        self.send_keyframe(peer, have, 0, self.author.keyframe(Version(have), self.goes_on(peer)), outbox);
    }

    /// Sends one peer the whole pot. A class comes at once, and a keyframe takes long to make: who has not got one yet may get one
    /// that was made a moment ago, and with the next pulse what has happened since.
    pub(super) fn send_whole(&mut self, peer: PeerId, outbox: &mut Outbox) {
        let (goes_on, latest) = (self.goes_on(peer), self.author.latest());
        let Some(seat) = self.seats.get_mut(&peer) else { return };
        let acknowledged = seat.acknowledged;
        let is_new = core::mem::take(&mut seat.is_new) && acknowledged == 0;
        let whole = &mut self.wholes[usize::from(goes_on)];
        whole.take_if(|whole| {
            let is_recent = is_new && latest.0.saturating_sub(whole.version.0) <= WHOLE_VERSIONS_MAX;
            whole.version != latest && !(is_recent && lead_on(&self.ways, whole.version, seat.retells))
        });
        let whole = whole.get_or_insert_with(|| Whole {
            version: latest,
            tick: self.snapshot_tick,
            bytes: self.author.keyframe(Version(0), goes_on),
        });
        if whole.version < latest {
            seat.again_from = Some(whole.version);
        }
        // clay that has not changed since is clay of the latest snapshot too
        let tick = if whole.version == latest { self.snapshot_tick } else { whole.tick };
        let keyframe = Keyframe {
            version: whole.version.0,
            since: 0,
            tick: tick.0,
            acknowledged,
            sight: None,
            mended: 0,
            goes_on,
            bytes: whole.bytes.clone(),
        };
        outbox.push_back(Transmit { to: peer, lane: Lane::Keyframe(protocol::encode(&keyframe)) });
    }

    /// The same, with what differs from what the peer holds; says how many tiles do. What cannot be compared is sent whole.
    pub(in crate::room) fn mend(&mut self, peer: PeerId, have: u32, tiles: &[u8], outbox: &mut Outbox) -> u64 {
        let is_known = have > 0 && have <= self.author.latest().0;
        let mend = if is_known { self.author.mend(Version(have), tiles, self.goes_on(peer)) } else { None };
        let Some((bytes, mended)) = mend else {
            self.resync(peer, 0, outbox);
            return 0;
        };
        self.send_keyframe(peer, have, mended, bytes, outbox);
        u64::from(mended)
    }

    fn goes_on(&self, peer: PeerId) -> bool {
        self.seats.get(&peer).is_some_and(|seat| !seat.retells)
    }

    pub(super) fn send_keyframe(&self, peer: PeerId, since: u32, mended: u16, bytes: Vec<u8>, outbox: &mut Outbox) {
        let keyframe = Keyframe {
            version: self.author.latest().0,
            since,
            tick: self.snapshot_tick.0,
            acknowledged: self.seats.get(&peer).map_or(0, |seat| seat.acknowledged),
            sight: None,
            mended,
            goes_on: self.goes_on(peer),
            bytes,
        };
        outbox.push_back(Transmit { to: peer, lane: Lane::Keyframe(protocol::encode(&keyframe)) });
    }
}
