//! The order of a delta's symbols: band by band of tiles round the pot, then column by column over their tiles.
//!
//! A band is the tiles above one another. A column of a tile is two strips of eight elements; where nothing changed in a
//! strip, one bit says so. Written once for both directions.
//! Invariant: nothing is asked of an element but what the other end knows when it comes to the same place.

use alloc::vec::Vec;
use core::ops::Range;

use wide::{i16x8, i32x8};

use super::models::{Models, Outlook, PACES, STRIP, level};
use super::motion::{Foretold, PARTS, Turned, eight, padded_rows};
use super::plane::Plane;
use super::tiles::TILE_SIDE;
use crate::coding::Symbols;

/// What hints and misses are limited to, in parts of a quantum.
const HINT_MAX: i16 = 8191;
/// Parts of a quantum above which a strip is of the next pace.
const PACE_PARTS: [i16; PACES - 1] = [6, 20, 60];
/// A strip with an element below it and one above.
const WIDE: usize = STRIP + 2;

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
    #[inline(always)]
    pub(super) fn code<S: Symbols>(
        &mut self,
        mut symbols: S,
        models: &mut Models,
        turned: &Turned,
        plane: &mut Plane,
    ) -> Result<S, Exhausted> {
        let layout = plane.layout();
        let length = padded_rows(layout.shape());
        self.before.clear(length);
        self.here.clear(length);
        turned.mark_into(&mut self.is_foretold);
        let mut next_band = 0;
        for first_tile in (0..layout.tiles()).step_by(layout.tile_rows() as usize) {
            self.code_tiles(&mut symbols, models, plane, first_tile);
            let window = layout.window(first_tile);
            let Some(rows) = self.rows(plane) else { continue };
            if next_band != window.first_column {
                self.here.clear(length);
            }
            next_band = window.first_column + window.columns;
            self.foretold.begin(turned, window.first_column..next_band, rows);
            for column in window.first_column..next_band {
                self.foretold.advance();
                core::mem::swap(&mut self.before, &mut self.here);
                // all columns of a band have the same tiles, whose rows are written anew; those before it may have others
                if column < window.first_column + 2 {
                    self.here.clear(length);
                }
                self.code_column(&mut symbols, models, plane.column_mut(column));
                if symbols.is_exhausted() {
                    return Err(Exhausted);
                }
            }
        }
        Ok(symbols)
    }

    /// Which tiles of a band changed: leaves their numbers within it in `tile_rows`.
    #[inline(always)]
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

    #[inline(always)]
    fn code_column(&mut self, symbols: &mut impl Symbols, models: &mut Models, column: &mut [i16]) {
        for at in 0..self.tile_rows.len() {
            let first_row = (self.tile_rows[at] * TILE_SIDE) as usize;
            let end_row = (first_row + TILE_SIDE as usize).min(column.len());
            for (number, part) in column[first_row..end_row].chunks_mut(STRIP).enumerate() {
                let row = first_row + number * STRIP;
                if let Some(strip) = part.first_chunk_mut() {
                    self.code_strip(symbols, models, strip, STRIP, row);
                } else {
                    // nothing is foretold above the rim
                    let mut strip = [0; STRIP];
                    strip[..part.len()].copy_from_slice(part);
                    self.code_strip(symbols, models, &mut strip, part.len(), row);
                    part.copy_from_slice(&strip[..part.len()]);
                }
            }
        }
    }

    /// A strip of so many elements that begins at a row.
    #[inline(always)]
    fn code_strip(
        &mut self,
        symbols: &mut impl Symbols,
        models: &mut Models,
        strip: &mut [i16; STRIP],
        length: usize,
        row: usize,
    ) {
        let foretold = self.foretold.here(row + 1);
        // half a quantum or more; less than that counts as one, if there is anything
        let expected = match (count(foretold.abs().simd_gt(i16x8::splat(PARTS as i16 / 2 - 1))), foretold) {
            (0, foretold) => usize::from(foretold != i16x8::splat(0)),
            (more, _) => (more + 1).min(5),
        };
        let changed = STRIP - count(eight(&self.before.differences, row + 1).simd_eq(i16x8::splat(0)));
        let below = self.here.differences[row] != 0;
        if models.strip(symbols, *strip != [0; STRIP], expected, changed, below) {
            self.code_elements(symbols, models, strip, length, row);
        } else {
            put(&mut self.here.differences, row + 1, i16x8::splat(0));
            put(&mut self.here.unforeseen, row + 1, limited(i16x8::splat(0).saturating_sub(foretold)));
            self.here.misses[row + 1..][..STRIP].fill(0);
        }
    }

    /// The elements of one strip that begins at a row.
    #[inline(always)]
    fn code_elements<S: Symbols>(
        &mut self,
        symbols: &mut S,
        models: &mut Models,
        strip: &mut [i16; STRIP],
        length: usize,
        row: usize,
    ) {
        let (low, middle, high) = (self.foretold.here(row), self.foretold.here(row + 1), self.foretold.here(row + 2));
        let [along, up, curved_along, curved_up] =
            slopes(low, middle, high, self.foretold.before(row + 1), self.foretold.after(row + 1));
        let left = |from: usize| eight(&self.before.unforeseen, row + from);
        let hints = [left(1), left(0), left(2), along, up, curved_along, curved_up];
        let pace = pace(middle);
        let (sums, weight_below) = models.weights[pace].sums(&hints);
        let near: &[u16; WIDE] = self.before.misses[row..].first_chunk().expect("columns are padded");
        let misses: [u32; STRIP] =
            core::array::from_fn(|at| 2 * u32::from(near[at + 1]) + u32::from(near[at]) + u32::from(near[at + 2]));
        let changed = !eight(&self.before.differences, row + 1).simd_eq(i16x8::splat(0));
        let something = !middle.simd_eq(i16x8::splat(0));
        let kinds = ((changed & i16x8::splat(4)) | (something & i16x8::splat(1))).to_array();
        let foretold = middle.to_array();
        let predict = |at: usize, unforeseen_below: i16| {
            i32::from(foretold[at]) + ((sums[at] + weight_below * i32::from(unforeseen_below)) >> 13)
        };
        let mut errors = [0; STRIP];
        let unforeseen_below: i16x8;
        if S::IS_GIVEN {
            // nothing waits for a symbol, so that a processor can work on all at once; the first is that of the element below
            let (mut unforeseen, mut missed) = ([0_i16; STRIP + 1], [0_u16; STRIP + 1]);
            (unforeseen[0], missed[0]) = (self.here.unforeseen[row], self.here.misses[row]);
            (0..STRIP).for_each(|at| unforeseen[at + 1] = less(strip[at], foretold[at]));
            let predicted: [i32; STRIP] = core::array::from_fn(|at| predict(at, unforeseen[at]));
            let off: [i32; STRIP] = core::array::from_fn(|at| i32::from(strip[at]) * PARTS - predicted[at]);
            (0..STRIP).for_each(|at| missed[at + 1] = miss(off[at]));
            if length < STRIP {
                missed[length + 1..].fill(0);
            }
            let outlooks = predicted.map(Outlook::new);
            let offs: [i32; STRIP] = core::array::from_fn(|at| outlooks[at].off(strip[at]));
            errors = core::array::from_fn(|at| if offs[at] == 0 { 0 } else { off[at] });
            let places: [u32; STRIP] = core::array::from_fn(|at| outlooks[at].place(kinds[at] as u32));
            let levels: [u32; STRIP] = core::array::from_fn(|at| level(misses[at] + 2 * u32::from(missed[at])));
            let contexts: [u32; STRIP] = core::array::from_fn(|at| levels[at] + places[at]);
            for (&context, &off) in contexts.iter().zip(&offs).take(length) {
                models.off(symbols, context, off);
            }
            put(&mut self.here.differences, row + 1, i16x8::new(*strip));
            put(&mut self.here.unforeseen, row + 1, eight(&unforeseen, 1));
            self.here.misses[row + 1..][..STRIP].copy_from_slice(&missed[1..]);
            unforeseen_below = eight(&unforeseen, 0);
        } else {
            // what is known is written one by one, since the next strip waits for the last of it
            let padded = "columns are padded";
            let differences: &mut [i16; STRIP] = self.here.differences[row + 1..].first_chunk_mut().expect(padded);
            let unforeseen: &mut [i16; STRIP + 1] = self.here.unforeseen[row..].first_chunk_mut().expect(padded);
            let missed: &mut [u16; STRIP + 1] = self.here.misses[row..].first_chunk_mut().expect(padded);
            let (mut below, mut missed_below) = (unforeseen[0], u32::from(missed[0]));
            for at in 0..length.min(STRIP) {
                let predicted = predict(at, below);
                let outlook = Outlook::new(predicted);
                let context = level(misses[at] + 2 * missed_below) + outlook.place(kinds[at] as u32);
                let coded = models.off(symbols, context, 0);
                let difference = outlook.difference(coded);
                let off = i32::from(difference) * PARTS - predicted;
                errors[at] = if coded == 0 { 0 } else { off };
                (strip[at], differences[at]) = (difference, difference);
                // more than is kept is in the same context
                (below, missed_below) = (less(difference, foretold[at]), off.unsigned_abs());
                (unforeseen[at + 1], missed[at + 1]) = (below, miss(off));
            }
            unforeseen_below = eight(unforeseen, 0);
        }
        let errors = i16x8::from_i32x8_saturate(i32x8::new(errors));
        if errors != i16x8::splat(0) {
            let [first, second, third, fourth, fifth, sixth, seventh] = hints;
            let mut hints = [first, second, third, fourth, fifth, sixth, seventh, unforeseen_below];
            if length < STRIP {
                let there = i16x8::new(core::array::from_fn(|at| if at < length { -1 } else { 0 }));
                hints = hints.map(|hint| hint & there);
            }
            models.weights[pace].learn(&hints, errors);
        }
    }
}

/// What the last delta did not foretell of a difference, in parts of a quantum.
#[inline(always)]
fn less(difference: i16, foretold: i16) -> i16 {
    (i32::from(difference) * PARTS - i32::from(foretold)).clamp((-HINT_MAX).into(), HINT_MAX.into()) as i16
}

/// How far off, as it is kept.
#[inline(always)]
fn miss(off: i32) -> u16 {
    off.unsigned_abs().min(1 << 14) as u16
}

/// By which weights a strip is corrected: clay that moves fast is foretold otherwise than clay that creeps.
#[inline(always)]
fn pace(foretold: i16x8) -> usize {
    let most = foretold.abs();
    PACE_PARTS.into_iter().filter(|&parts| most.simd_gt(i16x8::splat(parts)).to_bitmask() != 0).count()
}

/// How many lanes a comparison holds in.
#[inline(always)]
fn count(holds: i16x8) -> usize {
    holds.to_bitmask().count_ones() as usize
}

#[inline(always)]
fn put(column: &mut [i16], row: usize, values: i16x8) {
    column[row..][..STRIP].copy_from_slice(values.as_array());
}

#[inline(always)]
fn limited(values: i16x8) -> i16x8 {
    values.min(i16x8::splat(HINT_MAX)).max(i16x8::splat(-HINT_MAX))
}

/// Slopes and curvatures of what is foretold of a strip, round the pot and upwards.
#[inline(always)]
fn slopes(low: i16x8, middle: i16x8, high: i16x8, before: i16x8, after: i16x8) -> [i16x8; 4] {
    let twice = middle.saturating_add(middle);
    [
        limited(after.saturating_sub(before) >> 1),
        limited(high.saturating_sub(low) >> 1),
        limited(after.saturating_add(before).saturating_sub(twice)),
        limited(high.saturating_add(low).saturating_sub(twice)),
    ]
}
