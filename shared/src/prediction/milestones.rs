//! What the predicted clay was at snapshots that are not confirmed yet.
//!
//! Owns the comparison of a confirmed snapshot with what was predicted for it; knows no samples and presses nothing.
//! Invariant: milestones stand in ascending order, and each holds every tile that own presses changed since the one before.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use crate::clay::Pot;
use crate::snapshot::{Replica, Touched, tile_digest};
use crate::units::Tick;

/// Clay at a snapshot in which own presses count for the first time.
#[derive(Debug)]
struct Milestone {
    /// Ticks of the first and the last of them.
    first: Tick,
    last: Tick,
    /// The tiles that they changed, and the digests of those as they were then, in their order.
    tiles: Touched,
    digests: Vec<u64>,
}

/// What own presses have made of the clay, snapshot by snapshot.
#[derive(Debug)]
pub(super) struct Milestones {
    passed: VecDeque<Milestone>,
    /// Tick of the first press since the last snapshot that changed anything.
    open: Option<Tick>,
    /// Those that were passed, to be filled again.
    spare: Vec<Milestone>,
    /// Tiles that have been compared.
    seen: Touched,
}

impl Milestones {
    /// None, over the surfaces of a set of tiles.
    pub(super) fn none(tiles: &Touched) -> Self {
        Self { passed: VecDeque::new(), open: None, spare: Vec::new(), seen: tiles.emptied() }
    }

    pub(super) fn clear(&mut self) {
        self.open = None;
        self.spare.extend(self.passed.drain(..));
    }

    /// Notes a press at a tick that changed the clay, before the next snapshot.
    pub(super) fn open(&mut self, tick: Tick) {
        self.open.get_or_insert(tick);
    }

    /// Notes the clay at a snapshot up to which own presses, the last of them no later than at a tick, changed some tiles.
    pub(super) fn pass(&mut self, last: Tick, tiles: &Touched, pot: &Pot) {
        let first = self.open.take().unwrap_or(last);
        let mut milestone = self.spare.pop().unwrap_or_else(|| Milestone {
            first,
            last,
            tiles: self.seen.emptied(),
            digests: Vec::new(),
        });
        (milestone.first, milestone.last) = (first, last);
        milestone.tiles.clear();
        milestone.tiles.add_all(tiles);
        milestone.digests.clear();
        let digest = |(surface, tile, _)| tile_digest(&pot.surfaces()[surface], tile);
        milestone.digests.extend(tiles.iter().map(digest));
        self.passed.push_back(milestone);
    }

    /// Whether the clay at the snapshot of a tick was what a replica of it holds, where `news` is what has changed there since the replica's last
    /// snapshot that was as predicted.
    pub(super) fn are_confirmed(&mut self, replica: &Replica, at: Tick, news: &Touched) -> bool {
        let is_between = |milestone: &Milestone| milestone.first <= at && milestone.last > at;
        if self.open.is_some_and(|first| first <= at) || self.passed.iter().any(is_between) {
            return false;
        }
        self.seen.clear();
        // of a tile that was changed more than once the last counts
        for milestone in self.passed.iter().rev().skip_while(|milestone| milestone.last > at) {
            for ((surface, tile, _), digest) in milestone.tiles.iter().zip(&milestone.digests) {
                if !self.seen.holds(surface, tile) && replica.tile_digest(surface, tile) != *digest {
                    return false;
                }
            }
            self.seen.add_all(&milestone.tiles);
        }
        news.is_within(&self.seen)
    }

    /// Forgets what is confirmed, and adds the tiles of the rest to a set.
    pub(super) fn forget(&mut self, at: Tick, ahead: &mut Touched) {
        while let Some(milestone) = self.passed.pop_front_if(|first| first.last <= at) {
            self.spare.push(milestone);
        }
        self.passed.iter().for_each(|milestone| ahead.add_all(&milestone.tiles));
    }
}
