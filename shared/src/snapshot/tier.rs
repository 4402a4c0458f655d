//! A second chain of the same clay: coarser, rarer or of a part of the tiles, for those who need no more.
//!
//! Follows an author and changes no clay. How often it publishes and for whom is the room's affair.
//! Invariant: its tiles hold the author's steps at its last snapshot, rounded to its own quantum.

use alloc::vec::Vec;

use super::grid::{self, QuantisedGrid, Quantum};
use super::motion::Moment;
use super::publisher::Publisher;
use super::{Author, Delta, Version};

/// Publishes an author's clay at a quantum of its own.
///
/// Whoever follows it needs a replica of the same quantum, [`super::Replica::with_quantum`].
#[derive(Clone, Debug)]
pub struct Tier {
    publisher: Publisher,
    quantum: Quantum,
    /// Tiles that are left out, by number through all surfaces; none when it is empty.
    is_left_out: Vec<bool>,
    /// The author's snapshot that it has.
    seen: Version,
    steps: Vec<u16>,
}

impl Tier {
    /// Starts a chain at version 0, the untouched pot, of the tiles for which `is_wanted` says so; they are counted
    /// through all surfaces.
    #[must_use]
    pub fn new(author: &Author, quantum: Quantum, is_wanted: impl FnMut(u32) -> bool) -> Self {
        let grids: Vec<_> = author.publisher.grids().iter().map(|grid| grid.coarse_untouched(quantum)).collect();
        let mut is_wanted = is_wanted;
        let is_left_out = (0..grid::tiles(&grids)).map(|tile| !is_wanted(tile)).collect();
        Self { publisher: Publisher::new(grids), quantum, is_left_out, seen: Version(0), steps: Vec::new() }
    }

    /// The newest snapshot of this chain, whose versions are its own.
    #[must_use]
    pub const fn latest(&self) -> Version {
        self.publisher.latest()
    }

    /// Digest of the newest snapshot.
    #[must_use]
    pub fn digest(&self) -> u64 {
        grid::digest(self.publisher.grids())
    }

    /// Takes a snapshot of what the author's newest holds; `None` when nothing changed by a quantum.
    pub fn publish(&mut self, author: &Author, now: Moment) -> Option<Delta> {
        let mut first_tile = 0;
        for (surface, source) in author.publisher.grids().iter().enumerate() {
            for tile in 0..source.layout().tiles() {
                let is_left_out = self.is_left_out[(first_tile + tile) as usize];
                if is_left_out || author.publisher.version_of(surface, tile) <= self.seen {
                    continue;
                }
                source.tile_into(tile, &mut self.steps);
                for step in &mut self.steps {
                    *step = self.quantum.coarsen(*step);
                }
                self.publisher.stage(surface, tile, &self.steps);
            }
            first_tile += source.layout().tiles();
        }
        self.seen = author.latest();
        self.publisher.finish(now)
    }

    /// As [`Author::keyframe`], of this chain.
    #[must_use]
    pub fn keyframe(&self, have: Version) -> Vec<u8> {
        self.publisher.keyframe(have, true)
    }
}

impl QuantisedGrid {
    /// The same surface untouched, at another quantum.
    fn coarse_untouched(&self, quantum: Quantum) -> Self {
        Self::untouched(self.layout().shape(), self.quantum().radius_m(self.initial()), quantum)
    }
}
