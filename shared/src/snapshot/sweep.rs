//! The order of a delta's symbols: band by band of tiles round the pot, then column by column over their tiles.
//!
//! A band is the tiles above one another. A column of a tile is two strips of eight elements; where nothing changed in a
//! strip, one bit says so. Written once for both directions.
//! Invariant: nothing is asked of an element but what the other end knows when it comes to the same place.

use alloc::vec::Vec;
use core::ops::Range;

use wide::i16x8;

use super::coder::Symbols;
use super::models::{Models, Outlook};
use super::motion::{Foretold, PARTS, Turned, padded_rows};
use super::plane::Plane;
use super::tiles::TILE_SIDE;

const STRIP: u32 = 8;
/// What hints and misses are limited to, in parts of a quantum.
const HINT_MAX: i16 = 8191;
/// A strip with an element below it and one above.
const WIDE: usize = STRIP as usize + 2;

/// The bytes end before the delta does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exhausted;

/// What is known of a column while it and the next are coded; a row stands below and one above.
#[derive(Clone, Debug, Default)]
struct Known {
    differences: Vec<i16>,
    /// Difference less what the last delta foretold, in parts of a quantum.
    unforeseen: Vec<i16>,
    /// How far the prediction was off, in parts of a quantum.
    misses: Vec<u16>,
}

impl Known {
    fn clear(&mut self, length: usize) {
        for part in [&mut self.differences, &mut self.unforeseen] {
            part.clear();
            part.resize(length, 0);
        }
        self.misses.clear();
        self.misses.resize(length, 0);
    }
}

/// Scratch of a sweep, kept so that a delta allocates nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Sweep {
    foretold: Foretold,
    before: Known,
    here: Known,
    /// By tile number.
    is_foretold: Vec<bool>,
    /// The changed tiles of a band, counted from its foot.
    tile_rows: Vec<u32>,
}

impl Sweep {
    /// Codes the differences of one surface; `plane` is read or filled.
    ///
    /// # Errors
    /// [`Exhausted`]; the plane then holds a part.
    pub(super) fn code(
        &mut self,
        symbols: &mut impl Symbols,
        models: &mut Models,
        turned: &Turned,
        plane: &mut Plane,
    ) -> Result<(), Exhausted> {
        let layout = plane.layout();
        let length = padded_rows(layout.shape());
        self.before.clear(length);
        self.here.clear(length);
        turned.mark_into(&mut self.is_foretold);
        let mut next_band = 0;
        for first_tile in (0..layout.tiles()).step_by(layout.tile_rows() as usize) {
            self.code_tiles(symbols, models, plane, first_tile);
            let window = layout.window(first_tile);
            let Some(rows) = self.rows(plane) else { continue };
            if next_band != window.first_column {
                self.here.clear(length);
            }
            next_band = window.first_column + window.columns;
            self.foretold.begin(turned, window.first_column, rows.clone());
            for column in window.first_column..next_band {
                self.foretold.advance(turned, column, rows.clone());
                core::mem::swap(&mut self.before, &mut self.here);
                self.here.clear(length);
                self.code_column(symbols, models, plane.column_mut(column));
                if symbols.is_exhausted() {
                    return Err(Exhausted);
                }
            }
        }
        Ok(())
    }

    /// Which tiles of a band changed: leaves their numbers within it in `tile_rows`.
    fn code_tiles(&mut self, symbols: &mut impl Symbols, models: &mut Models, plane: &mut Plane, first_tile: u32) {
        self.tile_rows.clear();
        let tiles = plane.layout().tile_rows();
        let is_foretold = self.is_foretold[first_tile as usize..][..tiles as usize].contains(&true);
        let any = (first_tile..first_tile + tiles).any(|tile| plane.is_changed(tile));
        if !symbols.bit(&mut models.band[usize::from(is_foretold)], any) {
            return;
        }
        let mut below = false;
        for tile_row in 0..tiles {
            let tile = first_tile + tile_row;
            let before = first_tile > 0 && plane.is_changed(tile - tiles);
            let context =
                usize::from(self.is_foretold[tile as usize]) * 4 + usize::from(before) * 2 + usize::from(below);
            below = symbols.bit(&mut models.tile[context], plane.is_changed(tile));
            if below {
                plane.add(tile);
                self.tile_rows.push(tile_row);
            }
        }
    }

    /// The rows that the band's tiles need of what is foretold, if it has any.
    fn rows(&self, plane: &Plane) -> Option<Range<usize>> {
        let (first, last) = (self.tile_rows.first()?, self.tile_rows.last()?);
        let first_row = (first * TILE_SIDE).saturating_sub(1);
        let end_row = ((last + 1) * TILE_SIDE + 1).min(plane.layout().shape().rows());
        Some(first_row as usize..end_row as usize)
    }

    fn code_column(&mut self, symbols: &mut impl Symbols, models: &mut Models, column: &mut [i16]) {
        for at in 0..self.tile_rows.len() {
            let first_row = self.tile_rows[at] * TILE_SIDE;
            let end_row = (first_row + TILE_SIDE).min(column.len() as u32);
            for strip in (first_row..end_row).step_by(STRIP as usize) {
                let rows = strip as usize..(strip + STRIP).min(end_row) as usize;
                self.code_strip(symbols, models, column, rows);
            }
        }
    }

    fn code_strip(&mut self, symbols: &mut impl Symbols, models: &mut Models, column: &mut [i16], rows: Range<usize>) {
        let padded = rows.start + 1..rows.end + 1;
        let foretold = &self.foretold.here[padded.clone()];
        // half a quantum or more; less than that counts as one, if there is anything
        let certain = foretold.iter().filter(|value| i32::from(value.unsigned_abs()) >= PARTS / 2).count();
        let foretold = match certain {
            0 => usize::from(foretold.iter().any(|&value| value != 0)),
            more => (more + 1).min(5),
        };
        let before = self.before.differences[padded.clone()].iter().filter(|&&value| value != 0).count();
        let below = self.here.differences[rows.start] != 0;
        let any = column[rows.clone()].iter().any(|&value| value != 0);
        if models.strip(symbols, any, foretold, before, below) {
            self.code_elements(symbols, models, &mut column[rows.clone()], rows.start);
        } else {
            let unforeseen = &mut self.here.unforeseen[padded.clone()];
            for (unforeseen, &foretold) in unforeseen.iter_mut().zip(&self.foretold.here[padded]) {
                *unforeseen = foretold.saturating_neg().clamp(-HINT_MAX, HINT_MAX);
            }
        }
    }

    /// The elements of one strip that begins at a row.
    #[inline]
    fn code_elements(&mut self, symbols: &mut impl Symbols, models: &mut Models, strip: &mut [i16], row: usize) {
        let (low, middle, high) = (self.foretold.here(row), self.foretold.here(row + 1), self.foretold.here(row + 2));
        let slopes = slopes(low, middle, high, self.foretold.before(row + 1), self.foretold.after(row + 1));
        let foretold = middle.to_array();
        let left: &[i16; WIDE] = self.before.unforeseen[row..].first_chunk().expect("columns are padded");
        let misses: &[u16; WIDE] = self.before.misses[row..].first_chunk().expect("columns are padded");
        let before: &[i16; WIDE] = self.before.differences[row..].first_chunk().expect("columns are padded");
        let (mut unforeseen_below, mut miss_below) = (self.here.unforeseen[row], self.here.misses[row]);
        for (at, difference) in strip.iter_mut().enumerate().take(STRIP as usize) {
            let [along, up, curved_along, curved_up] = slopes.map(|slope| slope[at]);
            let outlook = Outlook {
                foretold: i32::from(foretold[at]),
                hints: i16x8::new([
                    left[at + 1],
                    left[at],
                    left[at + 2],
                    along,
                    up,
                    curved_along,
                    curved_up,
                    unforeseen_below,
                ]),
                misses: 2 * (u32::from(misses[at + 1]) + u32::from(miss_below))
                    + u32::from(misses[at])
                    + u32::from(misses[at + 2]),
                after_change: before[at + 1] != 0,
            };
            let (coded, error) = models.element(symbols, &outlook, *difference);
            *difference = coded;
            let unforeseen = i32::from(coded) * PARTS - outlook.foretold;
            unforeseen_below = unforeseen.clamp((-HINT_MAX).into(), HINT_MAX.into()) as i16;
            miss_below = error.unsigned_abs().min(1 << 14) as u16;
            self.here.differences[row + at + 1] = coded;
            self.here.unforeseen[row + at + 1] = unforeseen_below;
            self.here.misses[row + at + 1] = miss_below;
        }
    }
}

/// Slopes and curvatures of what is foretold of a strip, round the pot and upwards.
fn slopes(low: i16x8, middle: i16x8, high: i16x8, before: i16x8, after: i16x8) -> [[i16; 8]; 4] {
    let most = i16x8::splat(HINT_MAX);
    let twice = middle.saturating_add(middle);
    let values: [i16x8; 4] = [
        after.saturating_sub(before) >> 1,
        high.saturating_sub(low) >> 1,
        after.saturating_add(before).saturating_sub(twice),
        high.saturating_add(low).saturating_sub(twice),
    ];
    values.map(|value| value.min(most).max(-most).to_array())
}
