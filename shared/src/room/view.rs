//! A wheel as those see it who only look on: one chain at one detail, made once for all of them.
//!
//! Owns the chain and the latest ways along it; who gets what, and when, is for `audience` to say.
//! Invariant: ways are kept without a gap up to the newest snapshot.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use super::pieces::{WAYS_MAX, fragments};
use crate::protocol::{DATAGRAM_MAX, Fragment, FragmentOf};
use crate::snapshot::{Author, Detail, Moment, Tier, Version};
use crate::units::Tick;

/// Bytes of missed snapshots up to which they are sent one by one; a keyframe of what changed in more is shorter.
const MISSED_BYTES_MAX: usize = 4096;

/// One wheel at one detail.
#[derive(Debug)]
pub(super) struct View {
    tier: Tier,
    ways: VecDeque<(Version, Vec<Fragment>)>,
    /// The tick of the newest snapshot.
    tick: Tick,
}

impl View {
    /// A view whose versions come after those of the one before.
    pub(super) fn after(before: Version, author: &Author, detail: Detail, now: Moment) -> Self {
        let mut view = Self { tier: Tier::after(before, author, detail), ways: VecDeque::new(), tick: now.tick };
        view.publish(author, now);
        view
    }

    pub(super) fn publish(&mut self, author: &Author, now: Moment) {
        self.tick = now.tick;
        if let Some(delta) = self.tier.publish(author, now) {
            if self.ways.len() == WAYS_MAX {
                self.ways.pop_front();
            }
            self.ways
                .push_back((delta.version, fragments(delta.version, FragmentOf::Delta, &delta.bytes, DATAGRAM_MAX)));
        }
    }

    /// Somebody comes, for whom the next of the author's snapshots is one of this as well.
    pub(super) const fn note_newcomer(&mut self) {
        self.tier.note_newcomer();
    }

    pub(super) const fn has_newcomer(&self) -> bool {
        self.tier.has_newcomer()
    }

    pub(super) const fn latest(&self) -> Version {
        self.tier.latest()
    }

    pub(super) const fn tick(&self) -> Tick {
        self.tick
    }

    pub(super) fn digest(&self) -> u64 {
        self.tier.digest()
    }

    /// The pieces that lead on from a version, when they are few and kept.
    pub(super) fn ways_from(&self, from: Version) -> Option<impl Iterator<Item = &Fragment>> {
        let missed = self.latest().0.checked_sub(from.0)? as usize;
        let skipped = self.ways.len().checked_sub(missed)?;
        let pieces = || self.ways.iter().skip(skipped).flat_map(|(_, fragments)| fragments);
        let bytes: usize = pieces().map(|piece| piece.bytes.len()).sum();
        (missed <= 1 || bytes <= MISSED_BYTES_MAX).then(pieces)
    }

    /// As [`Tier::mend`].
    pub(super) fn mend(&self, have: Version, tiles: &[u8]) -> Option<(Vec<u8>, u16)> {
        self.tier.mend(have, tiles)
    }

    /// As [`Tier::keyframe`].
    pub(super) fn keyframe(&self, have: Version) -> Vec<u8> {
        self.tier.keyframe(have)
    }
}
