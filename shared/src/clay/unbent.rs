//! Contacts as they were found, and what of them is left where a wall has given way.
//!
//! Owns what a balance needs to look at the same contacts again; how a wall gives way is `series`'s, where it comes to rest `joint`'s.
//! Invariant: what is left has the same chunks in the same places, so that sums over it have the same bits as over all that was found.

use alloc::vec::Vec;

use super::contact::{Chunk, Column, Tally};
use super::lanes::{Eight, Simd, SimdBase, splat};
use super::series::GivenWay;

/// Contacts as they were found.
#[derive(Clone, Debug, Default)]
pub(super) struct Unbent {
    /// Each with its largest penetration, m.
    columns: Vec<(Column, f32)>,
    /// Penetrations of all chunks, m.
    penetrations_m: Vec<Eight>,
}

impl Unbent {
    /// Room for so many columns and chunks.
    pub(super) fn with_room(columns: usize, chunks: usize) -> Self {
        Self { columns: Vec::with_capacity(columns), penetrations_m: Vec::with_capacity(chunks) }
    }

    /// Whether nothing is kept.
    pub(super) const fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.columns.clear();
    }

    /// The largest penetration, m.
    pub(super) fn deepest_m(&self) -> f32 {
        self.columns.iter().fold(0.0, |deepest_m, column| deepest_m.max(column.1))
    }

    /// Keeps what was found.
    #[inline(always)]
    pub(super) fn keep<S: Simd>(&mut self, simd: S, columns: &[Column], chunks: &[Chunk]) {
        self.penetrations_m.clear();
        self.penetrations_m.extend(chunks.iter().map(|chunk| chunk.penetration_m));
        for column in columns {
            let mut deepest_m = splat(simd, 0.0);
            for lanes in &self.penetrations_m[column.chunks()] {
                deepest_m = deepest_m.max(lanes.on(simd));
            }
            self.columns.push((*column, deepest_m.to_array().into_iter().fold(0.0, f32::max)));
        }
    }

    /// Puts what is left of the penetrations where a wall has given way in the place of those there are, and of the columns and their chunks those that
    /// are touched then.
    #[inline(always)]
    pub(super) fn leave<S: Simd>(
        &self,
        simd: S,
        way: &GivenWay,
        columns: &mut Vec<Column>,
        chunks: &mut [Chunk],
        above_m: &[Eight],
    ) -> Tally<S> {
        let mut tally = Tally::new(simd);
        let least_m = way.least_m();
        columns.clear();
        for &(column, deepest_m) in &self.columns {
            // most of them, where a wall gives way by more than is left
            if deepest_m <= least_m {
                continue;
            }
            let chunks = &mut chunks[column.chunks()];
            let found_m = self.penetrations_m[column.chunks()].iter().zip(&above_m[column.heights()]);
            let (at, mut first, mut end) = (column.chunks().start as u32, u32::MAX, 0);
            for (number, (chunk, (found_m, above))) in (0..).zip(chunks.iter_mut().zip(found_m)) {
                let left_m = way.rest(&column, [chunk.radius_m.on(simd), above.on(simd)], found_m.on(simd));
                chunk.penetration_m = left_m.into();
                if tally.add(left_m, column.share) {
                    first = first.min(number);
                    end = number + 1;
                }
            }
            if end > 0 {
                columns.push(column.with_chunks(first..end, at));
            }
        }
        tally
    }
}
