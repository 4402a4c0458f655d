//! A second chain of the same clay: coarser, rarer or of a part of the tiles, for those who need no more.
//!
//! Follows an author and changes no clay. When it publishes and for whom is the room's affair.
//! Invariant: its elements hold the mean of the author's at its last snapshot, rounded to its own quantum; what is no skin is as the author has it.

use alloc::vec::Vec;

use super::detail::Detail;
use super::grid::{self, QuantisedGrid, Quantum};
use super::motion::Moment;
use super::publisher::Publisher;
use super::{Author, Delta, TILE_SIDE, Version};
use crate::clay::{GridShape, Window};

/// Publishes an author's clay at a detail: at a quantum and on a grid of its own.
///
/// Whoever follows it needs a replica of the same quantum and grid, [`super::Replica::with_quantum`].
#[derive(Clone, Debug)]
pub struct Tier {
    publisher: Publisher,
    detail: Detail,
    /// Whether somebody comes, for whom the next snapshot brings rows that the detail leaves out up to date as well.
    has_newcomer: bool,
    /// The author's snapshot that it has.
    seen: Version,
    steps: Vec<u16>,
}

/// Most surfaces of a pot that are skins: they come first.
const SKINS: usize = 2;

impl Tier {
    /// Starts a chain at version 0, the untouched pot.
    #[must_use]
    pub fn new(author: &Author, detail: Detail) -> Self {
        let all = author.publisher.grids().iter().enumerate();
        let grids = all.map(|(number, grid)| grid.coarse_untouched(number < SKINS, detail)).collect();
        let publisher = Publisher::new(grids);
        Self { publisher, detail, has_newcomer: true, seen: Version(0), steps: Vec::new() }
    }

    /// The same with a first snapshot that follows `before`; version 0 stays the untouched pot. So no version of a
    /// chain that ended before is one of this.
    #[must_use]
    pub fn after(before: Version, author: &Author, detail: Detail) -> Self {
        let mut tier = Self::new(author, detail);
        tier.publisher.begin_after(before);
        tier
    }

    /// Somebody comes who has not seen the rows that are left out: the next snapshot brings them up to date.
    pub const fn note_newcomer(&mut self) {
        self.has_newcomer = true;
    }

    /// Whether one has come since the last snapshot.
    #[must_use]
    pub const fn has_newcomer(&self) -> bool {
        self.has_newcomer
    }

    /// The newest snapshot of this chain, whose versions are its own.
    #[must_use]
    pub const fn latest(&self) -> Version {
        self.publisher.latest()
    }

    /// Digest of the newest snapshot.
    #[must_use]
    pub fn digest(&self) -> u64 {
        grid::digest(self.publisher.grids())
    }

    /// Takes a snapshot of what the author's newest holds; `None` when nothing changed by a quantum.
    pub fn publish(&mut self, author: &Author, now: Moment) -> Option<Delta> {
        let is_for_all_rows = core::mem::take(&mut self.has_newcomer);
        for (surface, source) in author.publisher.grids().iter().enumerate() {
            let grid = &self.publisher.grids()[surface];
            let (layout, quantum) = (grid.layout(), grid.quantum());
            let blocks = Blocks { fine: source.layout().shape(), coarse: layout.shape() };
            let is_newer = |of: u32| author.publisher.version_of(surface, of) > self.seen;
            for tile in 0..layout.tiles() {
                let window = layout.window(tile);
                // what was left out so far may be of any age
                let is_shown = surface >= SKINS || self.detail.band().holds(tile % layout.tile_rows());
                let is_due = match is_shown {
                    true => blocks.any_tile(window, source, is_newer),
                    false => is_for_all_rows,
                };
                if is_due {
                    blocks.means_into(window, source, quantum, &mut self.steps);
                    self.publisher.stage(surface, tile, &self.steps);
                }
            }
        }
        self.seen = author.latest();
        self.publisher.finish(now)
    }

    /// As [`Author::mend`], of this chain, for who goes on with its deltas.
    #[must_use]
    pub fn mend(&self, have: Version, tiles: &[u8]) -> Option<(Vec<u8>, u16)> {
        self.publisher.mend(have, tiles, true)
    }

    /// As [`Author::keyframe`], of this chain, for who goes on with its deltas.
    #[must_use]
    pub fn keyframe(&self, have: Version) -> Vec<u8> {
        self.publisher.keyframe(true, |surface, tile| self.publisher.version_of(surface, tile) > have)
    }
}

/// Which elements of a fine grid make one of a coarse one.
#[derive(Clone, Copy, Debug)]
struct Blocks {
    fine: GridShape,
    coarse: GridShape,
}

impl Blocks {
    fn columns(self, column: u32) -> core::ops::Range<u32> {
        part(column, self.coarse.columns(), self.fine.columns())
    }

    fn rows(self, row: u32) -> core::ops::Range<u32> {
        part(row, self.coarse.rows(), self.fine.rows())
    }

    /// Whether `is_so` holds for any of the source's tiles under a window of the coarse grid.
    fn any_tile(self, window: Window, source: &QuantisedGrid, mut is_so: impl FnMut(u32) -> bool) -> bool {
        let first_column = self.columns(window.first_column).start / TILE_SIDE;
        let last_column = (self.columns(window.first_column + window.columns - 1).end - 1) / TILE_SIDE;
        let first_row = self.rows(window.first_row).start / TILE_SIDE;
        let last_row = (self.rows(window.end_row() - 1).end - 1) / TILE_SIDE;
        (first_column..=last_column).any(|column| {
            (first_row..=last_row).any(|row| is_so(source.layout().tile_at(column * TILE_SIDE, row * TILE_SIDE)))
        })
    }

    /// The mean steps of a window of the coarse grid, column by column, rounded to a quantum.
    fn means_into(self, window: Window, source: &QuantisedGrid, quantum: Quantum, steps: &mut Vec<u16>) {
        steps.clear();
        for column in window.first_column..window.first_column + window.columns {
            if self.fine == self.coarse {
                let rows = window.first_row as usize..window.end_row() as usize;
                steps.extend(source.column(column)[rows].iter().map(|&step| quantum.coarsen(step)));
                continue;
            }
            for row in window.first_row..window.end_row() {
                let rows = self.rows(row);
                let rows = rows.start as usize..rows.end as usize;
                let (mut sum, mut count) = (0_u64, 0_u64);
                for column in self.columns(column) {
                    let under = &source.column(column)[rows.clone()];
                    sum += under.iter().map(|&step| u64::from(step)).sum::<u64>();
                    count += under.len() as u64;
                }
                steps.push(quantum.coarsen(((sum + count / 2) / count) as u16));
            }
        }
    }
}

/// The part of `fine` elements that is number `at` of `coarse`.
const fn part(at: u32, coarse: u32, fine: u32) -> core::ops::Range<u32> {
    at * fine / coarse..(at + 1) * fine / coarse
}

impl QuantisedGrid {
    /// The same surface untouched, at a detail; what is no skin keeps its grid and its quantum.
    fn coarse_untouched(&self, is_skin: bool, detail: Detail) -> Self {
        let (shape, untouched_m) = (self.layout().shape(), self.quantum().radius_m(self.initial()));
        if is_skin {
            Self::untouched(detail.grid_of(shape), untouched_m, detail.quantum())
        } else {
            Self::untouched(shape, untouched_m, self.quantum())
        }
    }
}
