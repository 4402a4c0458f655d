//! The grid cut into square tiles, and sets of them.
//!
//! Owns the arithmetic between elements and tiles; knows no radii.
//! Invariant: every element belongs to exactly one tile.

use alloc::vec::Vec;

use crate::clay::{GridShape, Window};

/// Elements along the side of a tile; the last tiles of a grid may be smaller.
pub const TILE_SIDE: u32 = 16;

/// How a grid is cut into tiles. Tile numbers run as elements do: `[tile columns][tile rows]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLayout {
    shape: GridShape,
    tile_columns: u32,
    tile_rows: u32,
}

impl TileLayout {
    /// The tiles of a grid.
    #[must_use]
    pub const fn new(shape: GridShape) -> Self {
        Self { shape, tile_columns: shape.columns().div_ceil(TILE_SIDE), tile_rows: shape.rows().div_ceil(TILE_SIDE) }
    }

    /// Number of tiles.
    #[must_use]
    pub const fn tiles(&self) -> u32 {
        self.tile_columns * self.tile_rows
    }

    /// The grid that is cut.
    #[must_use]
    pub const fn shape(&self) -> GridShape {
        self.shape
    }

    /// Tiles above one another.
    pub(super) const fn tile_rows(&self) -> u32 {
        self.tile_rows
    }

    /// The tile that holds an element.
    pub(super) const fn tile_at(&self, column: u32, row: u32) -> u32 {
        column / TILE_SIDE * self.tile_rows + row / TILE_SIDE
    }

    /// The elements of a tile.
    #[must_use]
    pub fn window(&self, tile: u32) -> Window {
        let first_column = tile / self.tile_rows * TILE_SIDE;
        let first_row = tile % self.tile_rows * TILE_SIDE;
        Window {
            first_column,
            columns: TILE_SIDE.min(self.shape.columns() - first_column),
            first_row,
            rows: TILE_SIDE.min(self.shape.rows() - first_row),
        }
    }
}

/// A set of tiles over all surfaces of a pot.
#[derive(Clone, Debug, Default)]
pub struct Touched {
    layouts: Vec<TileLayout>,
    /// One bit a tile, per surface.
    bits: Vec<Vec<u64>>,
}

impl Touched {
    /// The empty set over surfaces of the given shapes.
    #[must_use]
    pub fn none(shapes: impl Iterator<Item = GridShape>) -> Self {
        let layouts: Vec<_> = shapes.map(TileLayout::new).collect();
        let bits = layouts.iter().map(|layout| alloc::vec![0; layout.tiles().div_ceil(64) as usize]).collect();
        Self { layouts, bits }
    }

    /// Adds every tile that a window of a surface touches.
    ///
    /// # Panics
    /// When there is no such surface.
    pub fn add_window(&mut self, surface: usize, window: Window) {
        if window.is_empty() {
            return;
        }
        let layout = self.layouts[surface];
        let first_tile_row = window.first_row / TILE_SIDE;
        let last_tile_row = (window.first_row + window.rows - 1) / TILE_SIDE;
        let (mut column, mut left) = (window.first_column, window.columns);
        while left > 0 {
            let tile_column = column / TILE_SIDE;
            for tile_row in first_tile_row..=last_tile_row {
                self.add(surface, tile_column * layout.tile_rows + tile_row);
            }
            // the last one round the pot may be narrower
            let end = ((tile_column + 1) * TILE_SIDE).min(layout.shape.columns());
            left -= (end - column).min(left);
            column = if end < layout.shape.columns() { end } else { 0 };
        }
    }

    /// Adds one tile.
    ///
    /// # Panics
    /// When there is no such surface or tile.
    pub fn add(&mut self, surface: usize, tile: u32) {
        self.bits[surface][(tile / 64) as usize] |= 1 << (tile % 64);
    }

    /// Whether a tile is in the set.
    ///
    /// # Panics
    /// When there is no such surface or tile.
    #[must_use]
    pub fn holds(&self, surface: usize, tile: u32) -> bool {
        self.bits[surface][(tile / 64) as usize] >> (tile % 64) & 1 == 1
    }

    /// Whether every tile is in another set over the same surfaces too.
    #[must_use]
    pub fn is_within(&self, other: &Self) -> bool {
        self.bits.iter().flatten().zip(other.bits.iter().flatten()).all(|(mine, theirs)| mine & !theirs == 0)
    }

    /// Adds every tile of another set over the same surfaces.
    pub fn add_all(&mut self, other: &Self) {
        for (mine, theirs) in self.bits.iter_mut().flatten().zip(other.bits.iter().flatten()) {
            *mine |= theirs;
        }
    }

    /// The empty set over the same surfaces.
    #[must_use]
    pub fn emptied(&self) -> Self {
        Self::none(self.layouts.iter().map(TileLayout::shape))
    }

    /// Removes every tile.
    pub fn clear(&mut self) {
        self.bits.iter_mut().flatten().for_each(|word| *word = 0);
    }

    /// Whether no tile is in the set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bits.iter().flatten().all(|&word| word == 0)
    }

    /// Rectangles that cover the tiles of one surface, one for each run of neighbouring tile columns.
    ///
    /// # Panics
    /// When there is no such surface.
    #[must_use]
    pub fn rectangles(&self, surface: usize) -> Vec<Window> {
        let mut rectangles: Vec<Window> = Vec::new();
        for (_, _, tile) in self.iter().filter(|(of, _, _)| *of == surface) {
            match rectangles.last_mut() {
                Some(last) if last.first_column + last.columns >= tile.first_column => {
                    let end_row = (last.first_row + last.rows).max(tile.first_row + tile.rows);
                    last.first_row = last.first_row.min(tile.first_row);
                    last.rows = end_row - last.first_row;
                    last.columns = tile.first_column + tile.columns - last.first_column;
                }
                _ => rectangles.push(tile),
            }
        }
        rectangles
    }

    /// Every tile in ascending order: surface, tile, its elements.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u32, Window)> + '_ {
        self.bits.iter().enumerate().flat_map(move |(surface, words)| {
            words.iter().enumerate().flat_map(move |(at, &word)| {
                (0..64u32).filter(move |bit| word >> bit & 1 == 1).map(move |bit| {
                    let tile = at as u32 * 64 + bit;
                    (surface, tile, self.layouts[surface].window(tile))
                })
            })
        })
    }
}
