//! The authoritative side of a chain of snapshots.
//!
//! Owns versions, and the encoding of deltas and keyframes; the clay itself stays with the room.
//! Invariant: a tile's version is that of the last snapshot in which it changed.

use alloc::vec::Vec;

use super::coder::Encoder;
use super::grid::QuantisedGrid;
use super::record::windows;
use super::residual::{Differences, Models};
use super::{PotRecord, Touched, Version, dequantise, quantise};
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
#[derive(Debug)]
pub struct Author {
    grids: Vec<QuantisedGrid>,
    /// `[surface][tile]`.
    versions: Vec<Vec<Version>>,
    latest: Version,
    old: Vec<u16>,
    new: Vec<u16>,
    differences: Differences,
}

impl Author {
    /// Starts the chain at version 0 with an untouched pot, which it rounds to the quantum.
    #[must_use]
    pub fn new(pot: &mut Pot) -> Self {
        let grids = untouched_grids(pot);
        let versions = grids.iter().map(|grid| alloc::vec![Version(0); grid.layout().tiles() as usize]).collect();
        Self { grids, versions, latest: Version(0), old: Vec::new(), new: Vec::new(), differences: Vec::new() }
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
        author.publish(pot, &mut touched);
        author
    }

    /// The newest snapshot.
    #[must_use]
    pub const fn latest(&self) -> Version {
        self.latest
    }

    /// Digest of the newest snapshot.
    #[must_use]
    pub fn digest(&self) -> u64 {
        digest(&self.grids)
    }

    /// Takes a snapshot of the touched tiles, which are then forgotten; `None` when nothing changed by a quantum.
    ///
    /// The pot's radii in those tiles are rounded to the quantum, so that what was sent is what is: a creep of less
    /// than half a quantum between two snapshots is dropped on both sides alike.
    pub fn publish(&mut self, pot: &mut Pot, touched: &mut Touched) -> Option<Delta> {
        let version = self.latest.next();
        let mut encoder = Encoder::new();
        let mut models = Models::new();
        let mut first_unsent = (0, 0);
        let mut any = false;
        for (surface, tile, window) in touched.iter() {
            let grid = &mut self.grids[surface];
            grid.tile_into(tile, &mut self.old);
            self.new.clear();
            let clay = &mut pot.surfaces_mut()[surface];
            for column in window.first_column..window.first_column + window.columns {
                for row in window.first_row..window.first_row + window.rows {
                    let step = quantise(clay.column_m(column)[row as usize]);
                    clay.set_radius(column, row, dequantise(step));
                    self.new.push(step);
                }
            }
            if !grid.replace_tile(tile, &self.new) {
                continue;
            }
            any = true;
            self.versions[surface][tile as usize] = version;
            self.differences.clear();
            self.differences.extend(self.new.iter().zip(&self.old).map(|(&new, &old)| i32::from(new) - i32::from(old)));
            code_surface_gap(&mut encoder, &mut models, &mut first_unsent, (surface, tile));
            models.tile(&mut encoder, window.rows as usize, &mut self.differences);
        }
        pot.settle(touched.iter().map(|(surface, _, window)| (surface, window)));
        touched.clear();
        if !any {
            return None;
        }
        end_of_tiles(&mut encoder, &mut models, first_unsent.0, self.grids.len());
        self.latest = version;
        Some(Delta { version, bytes: encoder.finish() })
    }

    /// Every tile that changed since `have`, as differences to the untouched pot: leads from `have` to the newest.
    #[must_use]
    pub fn keyframe(&self, have: Version) -> Vec<u8> {
        let mut encoder = Encoder::new();
        let mut models = Models::new();
        let mut first_unsent = (0, 0);
        let (mut values, mut differences) = (Vec::new(), Vec::new());
        for (surface, versions) in self.versions.iter().enumerate() {
            for (tile, _) in (0u32..).zip(versions).filter(|(_, version)| **version > have) {
                let grid = &self.grids[surface];
                grid.tile_into(tile, &mut values);
                differences.clear();
                differences.extend(values.iter().map(|&value| i32::from(value) - i32::from(grid.initial())));
                code_surface_gap(&mut encoder, &mut models, &mut first_unsent, (surface, tile));
                models.tile(&mut encoder, grid.layout().window(tile).rows as usize, &mut differences);
            }
        }
        end_of_tiles(&mut encoder, &mut models, first_unsent.0, self.grids.len());
        encoder.finish()
    }
}

/// The grids of an untouched pot, whose radii are rounded to the quantum.
pub(super) fn untouched_grids(pot: &mut Pot) -> Vec<QuantisedGrid> {
    let round = |surface: &mut crate::clay::Surface| {
        let initial_m = surface.radii_m()[0];
        let grid = QuantisedGrid::untouched(surface.shape(), initial_m);
        for column in 0..surface.shape().columns() {
            for row in 0..surface.shape().rows() {
                surface.set_radius(column, row, dequantise(quantise(initial_m)));
            }
        }
        surface.take_as_untouched();
        grid
    };
    pot.surfaces_mut().iter_mut().map(round).collect()
}

/// Digest over all surfaces of a pot, in order.
pub(super) fn digest(grids: &[QuantisedGrid]) -> u64 {
    grids.iter().fold(0_u64, |sum, grid| sum.rotate_left(1) ^ grid.digest())
}

/// Says which tile comes next: ends the surfaces passed over, then the gap to the tile.
fn code_surface_gap(encoder: &mut Encoder, models: &mut Models, first_unsent: &mut (usize, u32), tile: (usize, u32)) {
    while first_unsent.0 < tile.0 {
        models.tile_gap(encoder, None);
        *first_unsent = (first_unsent.0 + 1, 0);
    }
    models.tile_gap(encoder, Some(tile.1 - first_unsent.1));
    first_unsent.1 = tile.1 + 1;
}

fn end_of_tiles(encoder: &mut Encoder, models: &mut Models, surface: usize, surfaces: usize) {
    for _ in surface..surfaces {
        models.tile_gap(encoder, None);
    }
}
