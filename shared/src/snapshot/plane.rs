//! What one snapshot changed on a surface: a difference for every element, and the tiles in which there are any.
//!
//! Differences are taken modulo 2¹⁶, so that any two steps have one and adding it leads from one to the other.
//! Invariant: outside of `tiles` every difference is zero.

use alloc::vec::Vec;

use super::tiles::{TILE_SIDE, TileLayout};

/// Differences of one surface.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    layout: TileLayout,
    /// `[columns][rows]`.
    differences: Vec<i16>,
    /// By tile number.
    is_changed: Vec<bool>,
    tiles: Vec<u32>,
}

impl Plane {
    pub(super) fn unchanged(layout: TileLayout) -> Self {
        Self {
            layout,
            differences: alloc::vec![0; layout.shape().elements()],
            is_changed: alloc::vec![false; layout.tiles() as usize],
            tiles: Vec::new(),
        }
    }

    pub(super) const fn layout(&self) -> TileLayout {
        self.layout
    }

    /// The tiles in which something changed, in the order in which they were added.
    pub(super) fn tiles(&self) -> &[u32] {
        &self.tiles
    }

    pub(super) fn is_changed(&self, tile: u32) -> bool {
        self.is_changed[tile as usize]
    }

    /// Notes that a tile has changed; its differences are to be written.
    pub(super) fn add(&mut self, tile: u32) {
        if !core::mem::replace(&mut self.is_changed[tile as usize], true) {
            self.tiles.push(tile);
        }
    }

    /// Differences of a whole column, foot to rim.
    pub(super) fn column(&self, column: u32) -> &[i16] {
        let rows = self.layout.shape().rows() as usize;
        &self.differences[column as usize * rows..][..rows]
    }

    pub(super) fn column_mut(&mut self, column: u32) -> &mut [i16] {
        let rows = self.layout.shape().rows() as usize;
        &mut self.differences[column as usize * rows..][..rows]
    }

    /// Puts in the place of every difference what it is more than the one before it round the pot: where a pot is pressed
    /// in deep, that is little.
    pub(super) fn steepen(&mut self) {
        for column in (1..self.layout.shape().columns()).rev() {
            self.along(column, i16::wrapping_sub);
        }
    }

    /// What [`Plane::steepen`] did, undone.
    pub(super) fn sum_up(&mut self) {
        for column in 1..self.layout.shape().columns() {
            self.along(column, i16::wrapping_add);
        }
    }

    fn along(&mut self, column: u32, put: impl Fn(i16, i16) -> i16) {
        let rows = self.layout.shape().rows() as usize;
        let (before, here) = self.differences[(column as usize - 1) * rows..][..2 * rows].split_at_mut(rows);
        let first_tile = self.layout.tile_at(column, 0) as usize;
        let is_changed = &self.is_changed[first_tile..][..self.layout.tile_rows() as usize];
        let tiles = here.chunks_mut(TILE_SIDE as usize).zip(before.chunks(TILE_SIDE as usize));
        for ((here, before), _) in tiles.zip(is_changed).filter(|(_, is_changed)| **is_changed) {
            for (here, &before) in here.iter_mut().zip(before) {
                *here = put(*here, before);
            }
        }
    }

    /// Becomes unchanged again.
    pub(super) fn clear(&mut self) {
        let mut tiles = core::mem::take(&mut self.tiles);
        for tile in tiles.drain(..) {
            self.is_changed[tile as usize] = false;
            let window = self.layout.window(tile);
            for column in window.first_column..window.first_column + window.columns {
                self.column_mut(column)[window.first_row as usize..window.end_row() as usize].fill(0);
            }
        }
        self.tiles = tiles;
    }
}
