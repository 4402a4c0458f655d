//! The quantised grid: what author and replica must agree on, with its digest.
//!
//! Owns quantisation and the per-tile digests; knows no versions and no wire.
//! Invariant: `digest` is always the digest of `values`.

use alloc::vec::Vec;

use crate::clay::{Digest, GridShape, Surface, Window};

use super::TileLayout;

/// Step between two radii that can travel.
pub const QUANTUM_M: f32 = Surface::STEP_M;

/// The nearest step to a radius; 16 bits reach 250 mm.
#[must_use]
pub fn quantise(radius_m: f32) -> u16 {
    // the cast cuts off and saturates
    (radius_m * (1.0 / QUANTUM_M) + 0.5) as u16
}

/// The radius of a step, exact.
#[must_use]
pub const fn dequantise(step: u16) -> f32 {
    step as f32 * QUANTUM_M
}

/// One surface in quantum steps.
#[derive(Clone, Debug)]
pub(super) struct QuantisedGrid {
    layout: TileLayout,
    /// The step of every element of the untouched surface.
    initial: u16,
    /// `[columns][rows]`.
    values: Vec<u16>,
    tile_digests: Vec<u64>,
    digest: u64,
}

impl QuantisedGrid {
    pub(super) fn untouched(shape: GridShape, radius_m: f32) -> Self {
        let initial = quantise(radius_m);
        let mut grid = Self {
            layout: TileLayout::new(shape),
            initial,
            values: alloc::vec![initial; shape.elements()],
            tile_digests: Vec::new(),
            digest: 0,
        };
        for tile in 0..grid.layout.tiles() {
            let tile_digest = grid.digest_of(tile);
            grid.tile_digests.push(tile_digest);
            grid.digest = grid.digest.wrapping_add(tile_digest);
        }
        grid
    }

    pub(super) const fn layout(&self) -> TileLayout {
        self.layout
    }

    pub(super) const fn initial(&self) -> u16 {
        self.initial
    }

    /// Sum of the tiles' digests, each of which covers its own number.
    pub(super) const fn digest(&self) -> u64 {
        self.digest
    }

    fn digest_of(&self, tile: u32) -> u64 {
        let mut digest = Digest::default();
        digest.add(tile);
        for column in self.columns(self.layout.window(tile)) {
            for &value in column {
                digest.add(u32::from(value));
            }
        }
        digest.finish()
    }

    /// The window's columns, foot to rim.
    fn columns(&self, window: Window) -> impl Iterator<Item = &[u16]> {
        let rows = self.layout.shape().rows() as usize;
        (window.first_column..window.first_column + window.columns).map(move |column| {
            let start = column as usize * rows + window.first_row as usize;
            &self.values[start..start + window.rows as usize]
        })
    }

    /// Copies a tile's values out, column by column.
    pub(super) fn tile_into(&self, tile: u32, values: &mut Vec<u16>) {
        values.clear();
        for column in self.columns(self.layout.window(tile)) {
            values.extend_from_slice(column);
        }
    }

    /// Replaces a tile's values; true when any differed.
    pub(super) fn replace_tile(&mut self, tile: u32, values: &[u16]) -> bool {
        let window = self.layout.window(tile);
        let rows = self.layout.shape().rows() as usize;
        let mut changed = false;
        let columns = window.first_column..window.first_column + window.columns;
        for (column, new) in columns.zip(values.chunks_exact(window.rows as usize)) {
            let start = column as usize * rows + window.first_row as usize;
            let old = &mut self.values[start..start + new.len()];
            changed |= old != new;
            old.copy_from_slice(new);
        }
        if changed {
            let tile_digest = self.digest_of(tile);
            let old = core::mem::replace(&mut self.tile_digests[tile as usize], tile_digest);
            self.digest = self.digest.wrapping_sub(old).wrapping_add(tile_digest);
        }
        changed
    }
}
