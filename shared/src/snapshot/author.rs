//! The authoritative side of a chain of snapshots.
//!
//! Owns the rounding of the clay to the quantum; the clay itself stays with the room.
//! Invariant: after a snapshot the pot's radii are those of the steps that were published.

use alloc::vec::Vec;

use super::grid::{self, Quantum, round_tile, untouched_grids};
use super::motion::Moment;
use super::publisher::Publisher;
use super::record::windows;
use super::{PotRecord, Touched, Version};
use crate::clay::{Pot, Surface};

/// The change from one snapshot to the next, encoded once for every subscriber.
#[derive(Clone, Debug)]
pub struct Delta {
    /// The snapshot that it leads to.
    pub version: Version,
    /// The tiles that changed.
    pub bytes: Vec<u8>,
}

/// Publishes the snapshots of one pot.
#[derive(Clone, Debug)]
pub struct Author {
    pub(super) publisher: Publisher,
    steps: Vec<u16>,
}

impl Author {
    /// Starts the chain at version 0 with an untouched pot, which it rounds to the quantum.
    #[must_use]
    pub fn new(pot: &mut Pot) -> Self {
        Self { publisher: Publisher::new(untouched_grids(pot, Quantum::FINEST)), steps: Vec::new() }
    }

    /// Starts the chain with the clay of a record on an untouched pot of the same grid.
    ///
    /// Version 0 stays the pot that everybody can make; what differs from it is version 1, which reaches those who come
    /// later as any version does.
    #[must_use]
    pub fn starting_from(pot: &mut Pot, record: &PotRecord) -> Self {
        let mut author = Self::new(pot);
        let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
        for (surface, window) in windows(pot) {
            touched.add_window(surface, window);
        }
        record.lay_on(pot);
        // nobody is there yet to whom the change could be sent
        author.publish_untold(pot, &mut touched, Moment::default());
        author
    }

    /// The newest snapshot.
    #[must_use]
    pub const fn latest(&self) -> Version {
        self.publisher.latest()
    }

    /// Digest of the newest snapshot.
    #[must_use]
    pub fn digest(&self) -> u64 {
        grid::digest(self.publisher.grids())
    }

    /// Takes a snapshot of the touched tiles, which are then forgotten; `None` when nothing changed by a quantum.
    ///
    /// The pot's radii in those tiles are rounded to the quantum, so that what was sent is what is: a creep of less
    /// than half a quantum between two snapshots is dropped on both sides alike.
    pub fn publish(&mut self, pot: &mut Pot, touched: &mut Touched, now: Moment) -> Option<Delta> {
        self.stage(pot, touched);
        self.publisher.finish(now)
    }

    /// The same when nobody needs the delta, which is then not made: whoever wants the next one needs a keyframe first.
    pub fn publish_untold(&mut self, pot: &mut Pot, touched: &mut Touched, now: Moment) -> Option<Version> {
        self.stage(pot, touched);
        self.publisher.finish_untold(now)
    }

    fn stage(&mut self, pot: &mut Pot, touched: &mut Touched) {
        for (surface, tile, window) in touched.iter() {
            round_tile(&mut pot.surfaces_mut()[surface], window, &mut self.steps);
            self.publisher.stage(surface, tile, &self.steps);
        }
        pot.settle(touched.iter().map(|(surface, _, window)| (surface, window)));
        touched.clear();
    }

    /// Every tile that changed since `have`: leads from `have` to the newest snapshot. For who `goes_on` with deltas, also
    /// what the next one builds upon.
    #[must_use]
    pub fn keyframe(&self, have: Version, goes_on: bool) -> Vec<u8> {
        self.publisher.keyframe(goes_on, |surface, tile| self.publisher.version_of(surface, tile) > have)
    }

    /// The same with every tile that differs from a replica's at `have`, and how many those are.
    ///
    /// `tiles` is [`super::Replica::tile_digests`] at that version. A tile that has not changed since is the same today as it was
    /// then, and all others are in the keyframe anyway: so there is no need to remember how it was. `None` when it is not a
    /// list of this pot's tiles.
    #[must_use]
    pub fn mend(&self, have: Version, tiles: &[u8], goes_on: bool) -> Option<(Vec<u8>, u16)> {
        self.publisher.mend(have, tiles, goes_on)
    }
}
