//! The writing end of a chain of snapshots, at any quantum.
//!
//! Owns grids, versions and what the chain remembers; where the steps come from is for `author` and `tier` to know.
//! Invariant: a tile's version is that of the last snapshot in which it changed.

use alloc::vec::Vec;

use super::chain::Chain;
use super::grid::QuantisedGrid;
use super::models::Models;
use super::motion::{Moment, Motion};
use super::plane::Plane;
use super::{Delta, Version};
use crate::coding::Encoder;

/// Grids with their versions, and the deltas that lead from one to the next.
#[derive(Clone, Debug)]
pub(super) struct Publisher {
    grids: Vec<QuantisedGrid>,
    /// `[surface][tile]`.
    versions: Vec<Vec<Version>>,
    latest: Version,
    chain: Chain,
    /// When the last delta was made, and when one was last asked for.
    last: Moment,
    asked: Moment,
}

impl Publisher {
    pub(super) fn new(grids: Vec<QuantisedGrid>) -> Self {
        let versions = grids.iter().map(|grid| alloc::vec![Version(0); grid.layout().tiles() as usize]).collect();
        let chain = Chain::new(grids.iter().map(QuantisedGrid::layout));
        Self { grids, versions, latest: Version(0), chain, last: Moment::default(), asked: Moment::default() }
    }

    /// Numbers the snapshots from after a version on.
    pub(super) const fn begin_after(&mut self, before: Version) {
        self.latest = before;
    }

    pub(super) const fn latest(&self) -> Version {
        self.latest
    }

    pub(super) fn grids(&self) -> &[QuantisedGrid] {
        &self.grids
    }

    pub(super) fn version_of(&self, surface: usize, tile: u32) -> Version {
        self.versions[surface][tile as usize]
    }

    /// Takes the steps of one tile for the next snapshot, column by column.
    pub(super) fn stage(&mut self, surface: usize, tile: u32, steps: &[u16]) {
        if self.grids[surface].replace_tile(tile, steps, &mut self.chain.current[surface]) {
            self.versions[surface][tile as usize] = self.latest.next();
        }
    }

    /// The delta of all that was staged; `None` when nothing changed.
    pub(super) fn finish(&mut self, now: Moment) -> Option<Delta> {
        let motion = self.go_on(now)?;
        Some(Delta { version: self.latest, bytes: self.chain.encode(motion) })
    }

    /// The same without a word of what changed, which takes no time: whoever wants the next delta needs a keyframe first.
    pub(super) fn finish_untold(&mut self, now: Moment) -> Option<Version> {
        let motion = self.go_on(now)?;
        self.chain.skip(motion);
        Some(self.latest)
    }

    /// Goes on to the next version, unless nothing was staged; says how the wheel moved since the last one.
    fn go_on(&mut self, now: Moment) -> Option<Motion> {
        let motion = Motion::new(self.last.phase, now.phase, now.tick.0.saturating_sub(self.asked.tick.0));
        self.asked = now;
        if self.chain.current.iter().all(|plane| plane.tiles().is_empty()) {
            return None;
        }
        self.last = now;
        self.latest = self.latest.next();
        Some(motion)
    }

    /// Every tile of which `is_named` says so, by surface and number, as differences to the untouched pot. For who `goes_on` with
    /// deltas, also what the chain remembers.
    pub(super) fn keyframe(&self, goes_on: bool, is_named: impl Fn(usize, u32) -> bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut models = Models::new();
        let mut planes = Vec::new();
        for (surface, grid) in self.grids.iter().enumerate() {
            let mut plane = Plane::unchanged(grid.layout());
            for tile in 0..grid.layout().tiles() {
                if is_named(surface, tile) {
                    grid.since_untouched(tile, &mut plane);
                }
            }
            plane.steepen();
            planes.push(plane);
        }
        let encoder = Encoder::new(&mut bytes);
        let mut encoder = Chain::code_alone(encoder, &mut models, &mut planes).expect("writing meets no end");
        if goes_on {
            let mut chain = self.chain.clone();
            encoder = chain.code_state(encoder, &mut models).expect("writing meets no end");
        }
        encoder.finish();
        bytes
    }

    /// As [`super::Author::mend`].
    pub(super) fn mend(&self, have: Version, tiles: &[u8], goes_on: bool) -> Option<(Vec<u8>, u16)> {
        let mut differing = Vec::new();
        let mut held = tiles.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]]));
        for (surface, grid) in self.grids.iter().enumerate() {
            for (tile, digest) in (0..).zip(grid.short_digests()) {
                if held.next()? != digest && self.version_of(surface, tile) <= have {
                    differing.push((surface, tile));
                }
            }
        }
        if tiles.len() % 2 == 1 || held.next().is_some() {
            return None;
        }
        let bytes = self.keyframe(goes_on, |surface, tile| {
            self.version_of(surface, tile) > have || differing.binary_search(&(surface, tile)).is_ok()
        });
        Some((bytes, differing.len().min(usize::from(u16::MAX)) as u16))
    }
}
