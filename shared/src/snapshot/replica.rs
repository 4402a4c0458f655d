//! A copy of the authoritative clay, kept by deltas and keyframes.
//!
//! Owns the checks of what a peer sent; applies a message whole or not at all.
//! Invariant: the pot is exactly the author's snapshot of `version`, as far as its quantum goes.

use alloc::vec::Vec;

use super::chain::Chain;
use super::grid::{self, QuantisedGrid, Quantum, round_tile, untouched_grids};
use super::models::Models;
use super::plane::Plane;
use super::{Touched, Transcript, Version};
use crate::clay::{Conditions, Pot, SubStep, Vectors, with_vectors};
use crate::coding::{Decoder, Symbols};

/// Why a snapshot message was not applied; the replica is as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// The delta does not follow what is held; ask for what is missing.
    #[error("a delta to {delta} does not follow {held}")]
    NotNext {
        /// Where the delta leads.
        delta: Version,
        /// What is held.
        held: Version,
    },
    /// What deltas build upon is not known, since the last snapshot was not come to by a delta; ask for a keyframe.
    #[error("a delta to {delta} builds upon deltas that were not taken")]
    Unlearned {
        /// Where the delta leads.
        delta: Version,
    },
    /// The bytes are no list of tiles of this pot; drop them and ask for what is missing.
    #[error("the {bytes} bytes are no list of tiles of this pot")]
    Malformed {
        /// Length of the message.
        bytes: usize,
    },
}

/// A follower of one wheel's chain of snapshots.
#[derive(Debug)]
pub struct Replica {
    pot: Pot,
    grids: Vec<QuantisedGrid>,
    version: Version,
    chain: Chain,
    /// Whether the chain remembers what the author's does.
    is_learned: bool,
}

impl Replica {
    /// A replica at version 0, the untouched pot.
    #[must_use]
    pub fn new(pot: Pot) -> Self {
        Self::with_quantum(pot, Quantum::FINEST)
    }

    /// The same for a chain of another quantum.
    #[must_use]
    pub fn with_quantum(mut pot: Pot, quantum: Quantum) -> Self {
        let grids = untouched_grids(&mut pot, quantum);
        let chain = Chain::new(grids.iter().map(QuantisedGrid::layout));
        Self { pot, grids, version: Version(0), chain, is_learned: true }
    }

    /// The clay at this version.
    #[must_use]
    pub const fn pot(&self) -> &Pot {
        &self.pot
    }

    /// The snapshot held.
    #[must_use]
    pub const fn version(&self) -> Version {
        self.version
    }

    /// Whether it can take the next delta; if not, it needs a keyframe with what deltas build upon.
    #[must_use]
    pub const fn takes_deltas(&self) -> bool {
        self.is_learned
    }

    /// Takes what is held for no snapshot of the author's any longer: nothing leads on from it, and only the whole pot replaces it, of whatever
    /// version.
    pub const fn distrust(&mut self) {
        (self.version, self.is_learned) = (Version(0), false);
    }

    /// Digest of the snapshot held.
    #[must_use]
    pub fn digest(&self) -> u64 {
        grid::digest(&self.grids)
    }

    /// Digest of a tile as it is held.
    ///
    /// # Panics
    /// When there is no such surface or tile.
    #[must_use]
    pub fn tile_digest(&self, surface: usize, tile: u32) -> u64 {
        self.grids[surface].tile_digest(tile)
    }

    /// The lowest 16 bits of every tile's digest, two bytes a tile with the low one first: what [`super::Author::mend`] compares.
    #[must_use]
    pub fn tile_digests(&self) -> Vec<u8> {
        self.grids.iter().flat_map(QuantisedGrid::short_digests).flat_map(u16::to_le_bytes).collect()
    }

    /// Moves on by one delta and adds the changed tiles to `touched`.
    ///
    /// # Errors
    /// [`SnapshotError`]; the replica is then unchanged.
    pub fn apply_delta(&mut self, version: Version, bytes: &[u8], touched: &mut Touched) -> Result<(), SnapshotError> {
        if version != self.version.next() {
            return Err(SnapshotError::NotNext { delta: version, held: self.version });
        }
        if !self.is_learned {
            return Err(SnapshotError::Unlearned { delta: version });
        }
        self.chain.decode(bytes).map_err(|_| SnapshotError::Malformed { bytes: bytes.len() })?;
        let current = core::mem::take(&mut self.chain.current);
        self.commit(version, &current, touched);
        self.chain.current = current;
        self.chain.advance();
        Ok(())
    }

    /// Moves on by one snapshot, by pressing again what was pressed, and adds the changed tiles to `touched`.
    ///
    /// The clay is then the author's if all conditions of the time are known; the digest shows it. The replica takes no
    /// delta afterwards until a keyframe brings what those build upon.
    ///
    /// # Errors
    /// [`SnapshotError::NotNext`]; the replica is then unchanged.
    pub fn retell(
        &mut self,
        version: Version,
        transcript: &Transcript,
        conditions: &Conditions,
        substep: &mut SubStep,
        touched: &mut Touched,
    ) -> Result<(), SnapshotError> {
        if version != self.version.next() {
            return Err(SnapshotError::NotNext { delta: version, held: self.version });
        }
        let mut pressed = touched.emptied();
        let mut presses = Vec::new();
        for sub_step in transcript.sub_steps() {
            presses.clear();
            presses.extend(sub_step.iter().map(|told| conditions.press(&told.sample, told.before.as_ref())));
            substep.advance(&mut self.pot, &presses, conditions.method, |surface, window| {
                pressed.add_window(surface, window);
            });
        }
        let mut steps = Vec::new();
        for (surface, tile, window) in pressed.iter() {
            round_tile(&mut self.pot.surfaces_mut()[surface], window, &mut steps);
            if self.grids[surface].replace_tile(tile, &steps, &mut self.chain.current[surface]) {
                touched.add(surface, tile);
            }
        }
        self.pot.settle(pressed.iter().map(|(surface, _, window)| (surface, window)));
        self.chain.drop_current();
        self.is_learned = false;
        self.version = version;
        Ok(())
    }

    /// Moves to the snapshot of a keyframe and adds the changed tiles to `touched`; an older one changes nothing.
    ///
    /// `since` is the version the keyframe starts from; from version 0, a tile it does not name is untouched clay. It
    /// `goes_on` when it brings what the next delta builds upon.
    ///
    /// # Errors
    /// [`SnapshotError::Malformed`]; the replica is then unchanged.
    pub fn apply_keyframe(
        &mut self,
        version: Version,
        since: Version,
        bytes: &[u8],
        goes_on: bool,
        touched: &mut Touched,
    ) -> Result<(), SnapshotError> {
        if version < self.version {
            return Ok(());
        }
        if since > self.version {
            return Err(SnapshotError::NotNext { delta: since, held: self.version });
        }
        let malformed = SnapshotError::Malformed { bytes: bytes.len() };
        let (mut planes, chain) = self.read_keyframe(bytes, goes_on).ok_or(malformed)?;
        for (grid, plane) in self.grids.iter().zip(&mut planes) {
            if since == Version(0) {
                (0..grid.layout().tiles()).for_each(|tile| plane.add(tile));
            }
            for at in 0..plane.tiles().len() {
                grid.against_untouched(plane.tiles()[at], plane);
            }
        }
        self.commit(version, &planes, touched);
        (self.chain, self.is_learned) = (chain, goes_on);
        Ok(())
    }

    /// Differences to the untouched pot, and what the chain goes on from.
    fn read_keyframe(&self, bytes: &[u8], goes_on: bool) -> Option<(Vec<Plane>, Chain)> {
        let layouts = || self.grids.iter().map(QuantisedGrid::layout);
        let mut planes: Vec<_> = layouts().map(Plane::unchanged).collect();
        let mut chain = Chain::new(layouts());
        let mut models = Models::new();
        let mut decoder = Chain::code_alone(Decoder::new(bytes), &mut models, &mut planes).ok()?;
        if goes_on {
            decoder = chain.code_state(decoder, &mut models).ok()?;
        }
        planes.iter_mut().for_each(Plane::sum_up);
        (!decoder.is_exhausted() && !decoder.has_rest()).then_some((planes, chain))
    }

    /// Adds differences to the clay.
    fn commit(&mut self, version: Version, planes: &[Plane], touched: &mut Touched) {
        let vectors = Vectors::default();
        for (surface, (grid, plane)) in self.grids.iter_mut().zip(planes).enumerate() {
            let quantum = grid.quantum();
            let clay = &mut self.pot.surfaces_mut()[surface];
            for &tile in plane.tiles() {
                let mut any = false;
                with_vectors!(vectors, simd => grid.add_tile(tile, plane, |column, first_row, steps| {
                    clay.set_run(column, first_row, steps, |step| quantum.radius_m(step));
                    any = true;
                }));
                if any {
                    touched.add(surface, tile);
                }
            }
        }
        // how much clay stands where was kept all along
        self.pot.settle(core::iter::empty());
        self.version = version;
    }
}
