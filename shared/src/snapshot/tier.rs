//! A second chain of the same clay: coarser, rarer or of a part of the tiles, for those who need no more.
//!
//! Follows an author and changes no clay. When it publishes and for whom is the room's affair.
//! Invariant: its elements hold the mean of the author's at its last snapshot, rounded to its own quantum.

use alloc::vec::Vec;

use super::grid::{self, QuantisedGrid, Quantum};
use super::motion::Moment;
use super::publisher::Publisher;
use super::{Author, Delta, TILE_SIDE, Version};
use crate::clay::{GridShape, Window};

/// How much of a wheel somebody sees who does not work at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Detail {
    /// Who looks on at one wheel: every element, thirty times a second, to 11 µm.
    Spectator,
    /// One of many wheels in small pictures: elements four times as large each way, five times a second, to 61 µm.
    Gallery,
    /// Who looks on at one wheel and keeps up with pressing again what is pressed there: the author's clay itself, thirty times a
    /// second, for about half of the spectator's bytes.
    Retold,
}

impl Detail {
    /// All of them, by their number.
    pub const ALL: [Self; 3] = [Self::Spectator, Self::Gallery, Self::Retold];

    /// Its number in messages.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The one of that number, if there is one.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// How fine its radii are.
    #[must_use]
    pub fn quantum(self) -> Quantum {
        match self {
            Self::Spectator => Quantum::SPECTATOR,
            Self::Gallery => Quantum::of_steps(16),
            Self::Retold => Quantum::FINEST,
        }
    }

    /// Elements of the author's that are one of its own, each way.
    #[must_use]
    pub const fn fold(self) -> u32 {
        match self {
            Self::Spectator | Self::Retold => 1,
            Self::Gallery => 4,
        }
    }

    /// It is published with every so many of the author's snapshots.
    #[must_use]
    pub const fn every(self) -> u64 {
        match self {
            Self::Spectator | Self::Retold => 2,
            Self::Gallery => 12,
        }
    }

    /// Whether it shows tools, and so tells of those that people bring.
    #[must_use]
    pub const fn shows_tools(self) -> bool {
        !matches!(self, Self::Gallery)
    }

    /// Its grid, where the author's is `shape`.
    #[must_use]
    pub fn grid_of(self, shape: GridShape) -> GridShape {
        folded(shape, self.fold())
    }
}

/// A grid with elements `fold` times as large each way, as far as a grid may be as coarse as that.
fn folded(shape: GridShape, fold: u32) -> GridShape {
    GridShape::new((shape.columns() / fold).max(8), (shape.rows() / fold).max(4)).unwrap_or(shape)
}

/// Publishes an author's clay at a quantum and on a grid of its own.
///
/// Whoever follows it needs a replica of the same quantum and grid, [`super::Replica::with_quantum`].
#[derive(Clone, Debug)]
pub struct Tier {
    publisher: Publisher,
    quantum: Quantum,
    /// Tiles that are left out, by number through all surfaces; none when it is empty.
    is_left_out: Vec<bool>,
    /// The author's snapshot that it has.
    seen: Version,
    steps: Vec<u16>,
}

impl Tier {
    /// Starts a chain at version 0, the untouched pot, of the tiles for which `is_wanted` says so; they are counted
    /// through all surfaces. An element is `fold` of the author's each way.
    #[must_use]
    pub fn new(author: &Author, quantum: Quantum, fold: u32, is_wanted: impl FnMut(u32) -> bool) -> Self {
        let grids: Vec<_> = author.publisher.grids().iter().map(|grid| grid.coarse_untouched(quantum, fold)).collect();
        let mut is_wanted = is_wanted;
        let is_left_out = (0..grid::tiles(&grids)).map(|tile| !is_wanted(tile)).collect();
        Self { publisher: Publisher::new(grids), quantum, is_left_out, seen: Version(0), steps: Vec::new() }
    }

    /// A chain of all tiles whose first snapshot follows `before`; version 0 stays the untouched pot. So no version of a
    /// chain that ended before is one of this.
    #[must_use]
    pub fn after(before: Version, author: &Author, detail: Detail) -> Self {
        let mut tier = Self::new(author, detail.quantum(), detail.fold(), |_| true);
        tier.publisher.begin_after(before);
        tier
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
        let mut first_tile = 0;
        for (surface, source) in author.publisher.grids().iter().enumerate() {
            let layout = self.publisher.grids()[surface].layout();
            for tile in 0..layout.tiles() {
                let window = layout.window(tile);
                let blocks = Blocks { fine: source.layout().shape(), coarse: layout.shape() };
                let is_left_out = self.is_left_out[(first_tile + tile) as usize];
                if is_left_out
                    || !blocks.any_tile(window, source, |of| author.publisher.version_of(surface, of) > self.seen)
                {
                    continue;
                }
                blocks.means_into(window, source, self.quantum, &mut self.steps);
                self.publisher.stage(surface, tile, &self.steps);
            }
            first_tile += layout.tiles();
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
    /// The same surface untouched, at another quantum and on a coarser grid.
    fn coarse_untouched(&self, quantum: Quantum, fold: u32) -> Self {
        let shape = folded(self.layout().shape(), fold);
        Self::untouched(shape, self.quantum().radius_m(self.initial()), quantum)
    }
}
