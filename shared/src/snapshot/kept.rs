//! Clay that is kept beside the clay of now: quantum steps in tiles, those that did not change shared with what was kept before.
//!
//! Knows no wire and no versions; what is kept, and for how long, is the room's affair.
//! Invariant: a pot on which it is laid is the pot that was kept, bit for bit.

use alloc::sync::Arc;
use alloc::vec::Vec;

use super::grid::{dequantise, quantise};
use super::{TileLayout, Touched};
use crate::clay::{Pot, Surface, Window};

/// The radii of a pot as a snapshot left them.
#[derive(Clone, Debug)]
pub struct KeptClay {
    /// `[surface][tile]`, each `[columns][rows]` of its window, quantum steps.
    tiles: Vec<Vec<Arc<[u16]>>>,
}

impl KeptClay {
    /// Keeps a pot whole.
    #[must_use]
    pub fn of(pot: &Pot) -> Self {
        let all = |surface: &Surface| {
            let layout = TileLayout::new(surface.shape());
            (0..layout.tiles()).map(|tile| steps_of(surface, layout.window(tile))).collect()
        };
        Self { tiles: pot.surfaces().iter().map(all).collect() }
    }

    /// Keeps a pot that differs from this one in the given tiles at most.
    ///
    /// # Panics
    /// When the pot is of another grid.
    #[must_use]
    pub fn after(&self, pot: &Pot, changed: &Touched) -> Self {
        let mut kept = self.clone();
        for (surface, tile, window) in changed.iter() {
            let steps = steps_of(&pot.surfaces()[surface], window);
            let tile = &mut kept.tiles[surface][tile as usize];
            if *tile != steps {
                *tile = steps;
            }
        }
        kept
    }

    /// Gives a pot of the same specification these radii, and adds the tiles in which it had others to `touched`.
    ///
    /// # Panics
    /// When the pot is of another grid.
    pub fn lay_on(&self, pot: &mut Pot, touched: &mut Touched) {
        let mut changed = Vec::new();
        for (number, (surface, tiles)) in pot.surfaces_mut().iter_mut().zip(&self.tiles).enumerate() {
            let layout = TileLayout::new(surface.shape());
            for (tile, steps) in (0..).zip(tiles) {
                let window = layout.window(tile);
                if lay(surface, window, steps) {
                    touched.add(number, tile);
                    changed.push((number, window));
                }
            }
        }
        pot.settle(changed.into_iter());
    }

    /// Bytes of the tiles that it does not share with another.
    #[must_use]
    pub fn unshared_bytes(&self, with: &Self) -> usize {
        let pairs = self.tiles.iter().flatten().zip(with.tiles.iter().flatten());
        pairs.filter(|(mine, theirs)| !Arc::ptr_eq(mine, theirs)).map(|(mine, _)| 2 * mine.len()).sum()
    }

    /// Bytes of all its tiles.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles.iter().flatten().map(|tile| 2 * tile.len()).sum()
    }

    /// Number of its tiles.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.tiles.iter().map(Vec::len).sum()
    }
}

/// The steps of a window, column by column.
pub(crate) fn steps_of(surface: &Surface, window: Window) -> Arc<[u16]> {
    let rows = window.first_row as usize..window.end_row() as usize;
    let columns = window.first_column..window.first_column + window.columns;
    // of a length that is known, so that it is asked for once and does not grow
    let mut steps: Arc<[u16]> = core::iter::repeat_n(0, rows.len() * columns.len()).collect();
    let filled = Arc::get_mut(&mut steps).expect("nobody else has it yet");
    for (column, filled) in columns.zip(filled.chunks_exact_mut(rows.len())) {
        let radii_m = &surface.column_m(column)[rows.clone()];
        filled.iter_mut().zip(radii_m).for_each(|(step, &radius_m)| *step = quantise(radius_m));
    }
    steps
}

/// Gives a window steps, column by column; false when it had them.
pub(crate) fn lay(surface: &mut Surface, window: Window, steps: &[u16]) -> bool {
    let mut any = false;
    let columns = window.first_column..window.first_column + window.columns;
    for (column, steps) in columns.zip(steps.chunks_exact(window.rows as usize)) {
        for (row, &step) in (window.first_row..).zip(steps) {
            let radius_m = dequantise(step);
            if surface.column_m(column)[row as usize] != radius_m {
                surface.set_radius(column, row, radius_m);
                any = true;
            }
        }
    }
    any
}
