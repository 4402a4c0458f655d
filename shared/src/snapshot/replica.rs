//! A copy of the authoritative clay, kept by deltas and keyframes.
//!
//! Owns the checks of what a peer sent; applies a message whole or not at all.
//! Invariant: the pot is exactly the author's snapshot of `version`.

use alloc::vec::Vec;

use super::author::{digest, untouched_grids};
use super::coder::Decoder;
use super::grid::QuantisedGrid;
use super::residual::Models;
use super::{Touched, Transcript, Version, dequantise, quantise};
use crate::clay::{Conditions, Pot, SubStep};

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
    decoded: Vec<(usize, u32, Vec<u16>)>,
}

impl Replica {
    /// A replica at version 0, the untouched pot.
    #[must_use]
    pub fn new(mut pot: Pot) -> Self {
        let grids = untouched_grids(&mut pot);
        Self { pot, grids, version: Version(0), decoded: Vec::new() }
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

    /// Digest of the snapshot held.
    #[must_use]
    pub fn digest(&self) -> u64 {
        digest(&self.grids)
    }

    /// Moves on by one delta and adds the changed tiles to `touched`.
    ///
    /// # Errors
    /// [`SnapshotError`]; the replica is then unchanged.
    pub fn apply_delta(&mut self, version: Version, bytes: &[u8], touched: &mut Touched) -> Result<(), SnapshotError> {
        if version != self.version.next() {
            return Err(SnapshotError::NotNext { delta: version, held: self.version });
        }
        self.decode(bytes, |grid, tile, old| grid.tile_into(tile, old))?;
        self.commit(version, touched);
        Ok(())
    }

    /// Moves on by one snapshot, by pressing again what was pressed, and adds the changed tiles to `touched`.
    ///
    /// The clay is then the author's if all conditions of the time are known; the digest shows it.
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
            steps.clear();
            let clay = &mut self.pot.surfaces_mut()[surface];
            for column in window.first_column..window.first_column + window.columns {
                for row in window.first_row..window.first_row + window.rows {
                    let step = quantise(clay.column_m(column)[row as usize]);
                    clay.set_radius(column, row, dequantise(step));
                    steps.push(step);
                }
            }
            if self.grids[surface].replace_tile(tile, &steps) {
                touched.add(surface, tile);
            }
        }
        self.pot.settle(pressed.iter().map(|(surface, _, window)| (surface, window)));
        self.version = version;
        Ok(())
    }

    /// Moves to the snapshot of a keyframe and adds the changed tiles to `touched`; an older one changes nothing.
    ///
    /// `since` is the version the keyframe starts from; from version 0, a tile it does not name is untouched clay.
    ///
    /// # Errors
    /// [`SnapshotError::Malformed`]; the replica is then unchanged.
    pub fn apply_keyframe(
        &mut self,
        version: Version,
        since: Version,
        bytes: &[u8],
        touched: &mut Touched,
    ) -> Result<(), SnapshotError> {
        if version < self.version {
            return Ok(());
        }
        if since > self.version {
            return Err(SnapshotError::NotNext { delta: since, held: self.version });
        }
        self.decode(bytes, |grid, tile, old| {
            old.clear();
            old.resize(grid.layout().window(tile).elements(), grid.initial());
        })?;
        if since == Version(0) {
            self.add_untouched_tiles();
        }
        self.commit(version, touched);
        Ok(())
    }

    fn decode(&mut self, bytes: &[u8], base: impl Fn(&QuantisedGrid, u32, &mut Vec<u16>)) -> Result<(), SnapshotError> {
        let malformed = SnapshotError::Malformed { bytes: bytes.len() };
        let mut decoder = Decoder::new(bytes);
        let mut models = Models::new();
        let mut differences = Vec::new();
        self.decoded.clear();
        for (surface, grid) in self.grids.iter().enumerate() {
            let mut next = 0_u32;
            while let Some(gap) = models.tile_gap(&mut decoder, None) {
                let tile = next.saturating_add(gap);
                if tile >= grid.layout().tiles() || decoder.is_exhausted() {
                    return Err(malformed);
                }
                next = tile + 1;
                let mut values = Vec::new();
                base(grid, tile, &mut values);
                differences.clear();
                differences.resize(values.len(), 0);
                models.tile(&mut decoder, grid.layout().window(tile).rows as usize, &mut differences);
                for (value, &difference) in values.iter_mut().zip(&differences) {
                    *value = u16::try_from(i32::from(*value).wrapping_add(difference)).map_err(|_| malformed)?;
                }
                self.decoded.push((surface, tile, values));
            }
        }
        if decoder.is_exhausted() || decoder.has_rest() {
            return Err(malformed);
        }
        Ok(())
    }

    /// Adds every tile that the message did not name, as untouched clay.
    fn add_untouched_tiles(&mut self) {
        let named: alloc::collections::BTreeSet<_> =
            self.decoded.iter().map(|(surface, tile, _)| (*surface, *tile)).collect();
        for (surface, grid) in self.grids.iter().enumerate() {
            for tile in (0..grid.layout().tiles()).filter(|&tile| !named.contains(&(surface, tile))) {
                let untouched = alloc::vec![grid.initial(); grid.layout().window(tile).elements()];
                self.decoded.push((surface, tile, untouched));
            }
        }
    }

    fn commit(&mut self, version: Version, touched: &mut Touched) {
        let mut changed = Vec::new();
        for (surface, tile, values) in self.decoded.drain(..) {
            let grid = &mut self.grids[surface];
            if !grid.replace_tile(tile, &values) {
                continue;
            }
            touched.add(surface, tile);
            let window = grid.layout().window(tile);
            changed.push((surface, window));
            let clay = &mut self.pot.surfaces_mut()[surface];
            let mut values = values.into_iter();
            for column in window.first_column..window.first_column + window.columns {
                for (row, value) in (window.first_row..window.first_row + window.rows).zip(&mut values) {
                    clay.set_radius(column, row, dequantise(value));
                }
            }
        }
        self.pot.settle(changed.iter().copied());
        self.version = version;
    }
}
