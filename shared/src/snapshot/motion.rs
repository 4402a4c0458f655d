//! How far the wheel turned from one delta to the next, and the last delta turned on by as much.
//!
//! The tool stands in the room while the pot turns under it, so that what changes now is what changed last, a few columns
//! farther. Integers only.
//! Invariant: author and replica turn the same delta to the same numbers.

use alloc::vec::Vec;

use wide::{i16x8, u16x8};

use super::plane::Plane;
use crate::clay::{GridShape, Phase};
use crate::coding::{BitModel, Symbols};
use crate::units::Tick;

/// When a snapshot is taken, and how the wheel stands then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// The tick at whose end it is taken.
    pub tick: Tick,
    /// The wheel's phase at that tick.
    pub phase: Phase,
}

/// How far the wheel turned and how long the clay changed from one delta to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Motion {
    /// Part of a turn, 2¹⁶ a whole one.
    turn: u16,
    /// Ticks, as many as a byte holds.
    ticks: u8,
}

impl Motion {
    /// From the wheel's phase at the last delta to the one now, in which clay changed for so many ticks.
    pub(super) fn new(before: Phase, now: Phase, ticks: u64) -> Self {
        let turn = now.0.wrapping_sub(before.0).wrapping_add(1 << 15) >> 16;
        Self { turn: turn as u16, ticks: ticks.min(255) as u8 }
    }
}

/// The last delta's motion and those that came before it, since snapshots are taken in a rhythm of few.
#[derive(Clone, Debug)]
pub(super) struct Motions {
    /// Motion of the last delta.
    pub(super) last: Motion,
    /// The latest two that differ, latest first.
    recent: [Motion; 2],
    is_known: [BitModel; 2],
}

impl Motions {
    pub(super) const fn new() -> Self {
        let still = Motion { turn: 0, ticks: 0 };
        Self { last: still, recent: [still; 2], is_known: [BitModel::EVEN; 2] }
    }

    pub(super) fn code(&mut self, symbols: &mut impl Symbols, motion: Motion) -> Motion {
        let [first, second] = self.recent;
        let [is_first, is_second] = &mut self.is_known;
        let motion = if symbols.bit(is_first, motion == first) {
            first
        } else if symbols.bit(is_second, motion == second) {
            second
        } else {
            Self::code_raw(symbols, motion)
        };
        if motion != first {
            self.recent = [motion, first];
        }
        motion
    }

    fn code_raw(symbols: &mut impl Symbols, motion: Motion) -> Motion {
        let turn = symbols.raw(motion.turn.into(), 16) as u16;
        Motion { turn, ticks: symbols.raw(motion.ticks.into(), 8) as u8 }
    }

    /// Codes what it holds, so that another can go on from there.
    pub(super) fn code_state(&mut self, symbols: &mut impl Symbols) {
        for motion in core::iter::once(&mut self.last).chain(&mut self.recent) {
            *motion = Self::code_raw(symbols, *motion);
        }
        let is_slowest = &mut BitModel::EVEN.clone();
        for model in &mut self.is_known {
            model.code_state(symbols, is_slowest);
        }
    }
}

/// Parts of a quantum in which a foretold difference is counted.
pub(super) const PARTS: i32 = 8;
/// Largest difference that is foretold, in quanta.
const FORETOLD_MAX: i16 = 1023;

/// The last delta of a surface, turned on and scaled to the time that passed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned<'a> {
    last: &'a Plane,
    columns: u32,
    /// Columns from where something is foretold to where it was, the rest in 2⁻¹⁵.
    step: u32,
    rest: i16,
    /// 2⁻¹⁵ by which more, or less, changes than last time, since more or less time passed.
    more: i16,
}

impl<'a> Turned<'a> {
    pub(super) fn new(last: &'a Plane, before: Motion, motion: Motion) -> Self {
        let columns = last.layout().shape().columns();
        let way = u32::from(motion.turn) * columns;
        let more = match (i32::from(before.ticks), i32::from(motion.ticks)) {
            (0, _) | (_, 0) => 0,
            // at most half or twice as much
            (before, now) => ((now - before) * (1 << 15) / before).clamp(-(1 << 14), (1 << 15) - 1) as i16,
        };
        Self { last, columns, step: way >> 16, rest: (way >> 1 & 0x7fff) as i16, more }
    }

    /// Says of which tiles something is foretold.
    pub(super) fn mark_into(&self, is_foretold: &mut Vec<bool>) {
        let layout = self.last.layout();
        is_foretold.clear();
        is_foretold.resize(layout.tiles() as usize, false);
        for &tile in self.last.tiles() {
            let window = layout.window(tile);
            // one more before it, since what is foretold lies between two columns
            let first = window.first_column + 2 * self.columns - self.step - 1;
            for along in [0, window.columns / 2, window.columns] {
                let column = (first + along) % self.columns;
                is_foretold[layout.tile_at(column, window.first_row) as usize] = true;
            }
        }
    }

    /// Writes what is foretold for the given rows of a column, in parts of a quantum.
    #[inline(always)]
    pub(super) fn column_into(&self, column: u32, rows: core::ops::Range<usize>, foretold: &mut [i16]) {
        let from = (column % self.columns + self.step) % self.columns;
        let near = &self.last.column(from)[rows.clone()];
        let far = &self.last.column((from + 1) % self.columns)[rows];
        let (whole, last) = foretold[..near.len()].as_chunks_mut::<8>();
        let ((whole_near, last_near), (whole_far, last_far)) = (near.as_chunks::<8>(), far.as_chunks::<8>());
        for ((values, &near), &far) in whole.iter_mut().zip(whole_near).zip(whole_far) {
            *values = self.foretold(i16x8::new(near), i16x8::new(far)).to_array();
        }
        if !last.is_empty() {
            let eight = |rows: &[i16]| i16x8::new(core::array::from_fn(|at| rows.get(at).copied().unwrap_or(0)));
            let values = self.foretold(eight(last_near), eight(last_far)).to_array();
            last.copy_from_slice(&values[..last.len()]);
        }
    }

    /// What is foretold between elements of two columns.
    #[inline(always)]
    fn foretold(&self, near: i16x8, far: i16x8) -> i16x8 {
        // most elements stay as they are
        if near | far == i16x8::splat(0) {
            return i16x8::splat(0);
        }
        let in_parts = |quanta: i16x8| {
            quanta.min(i16x8::splat(FORETOLD_MAX)).max(i16x8::splat(-FORETOLD_MAX)) * i16x8::splat(PARTS as i16)
        };
        let (near, far) = (in_parts(near), in_parts(far));
        let between = near + part(far - near, self.rest);
        between + part(between, self.more)
    }
}

/// So many 2⁻¹⁵ of numbers below 2¹⁴, rounded to the nearest.
#[inline(always)]
fn part(of: i16x8, share: i16) -> i16x8 {
    let (low, high) = (of + of).mul_keep_low_high(i16x8::splat(share));
    let rounded: u16x8 = low >> 15;
    high + rounded.cast_signed()
}

/// Rows of a column with one below, one above and what eight lanes may reach beyond.
pub(super) const fn padded_rows(shape: GridShape) -> usize {
    shape.rows() as usize + 2 + 8
}

/// What is foretold of a band's columns and one on either side, padded.
#[derive(Clone, Debug, Default)]
pub(super) struct Foretold {
    /// `[columns][padded rows]`.
    columns: Vec<i16>,
    rows: usize,
    /// Where the middle one of three neighbouring columns begins.
    middle: usize,
}

impl Foretold {
    /// Works out a band's columns, all of them before the first is asked for; `rows` are those that will be.
    #[inline(always)]
    pub(super) fn begin(&mut self, turned: &Turned, band: core::ops::Range<u32>, rows: core::ops::Range<usize>) {
        let length = padded_rows(turned.last.layout().shape());
        if self.rows != length {
            self.columns.clear();
            self.rows = length;
        }
        let columns = band.start + turned.columns - 1..band.end + turned.columns + 1;
        // what stays from another band is in rows that nobody asks for, and the padding is never written
        self.columns.resize(self.columns.len().max(columns.len() * length), 0);
        for (foretold, column) in self.columns.chunks_exact_mut(length).zip(columns) {
            turned.column_into(column, rows.clone(), &mut foretold[rows.start + 1..]);
        }
        self.middle = 0;
    }

    /// Moves on by a column, from the one before the band on.
    #[inline(always)]
    pub(super) const fn advance(&mut self) {
        self.middle += self.rows;
    }

    /// Eight rows of the column before, from a padded one on.
    #[inline(always)]
    pub(super) fn before(&self, row: usize) -> i16x8 {
        eight(&self.columns, self.middle - self.rows + row)
    }

    /// The same of the middle one.
    #[inline(always)]
    pub(super) fn here(&self, row: usize) -> i16x8 {
        eight(&self.columns, self.middle + row)
    }

    /// The same of the one after it.
    #[inline(always)]
    pub(super) fn after(&self, row: usize) -> i16x8 {
        eight(&self.columns, self.middle + self.rows + row)
    }
}

/// Eight rows of a padded column, from one on.
#[inline(always)]
pub(super) fn eight(column: &[i16], row: usize) -> i16x8 {
    i16x8::new(*column[row..].first_chunk().expect("columns are padded"))
}
