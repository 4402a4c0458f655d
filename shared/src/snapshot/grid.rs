//! The quantised grid: what author and replica must agree on, with its digest.
//!
//! Owns quantisation and the per-tile digests; knows no versions and no wire.
//! Invariant: `digest` is always the digest of `values`.

use alloc::vec::Vec;

use crate::clay::{Digest, GridShape, Pot, Surface, Window};

use super::plane::Plane;
use super::{TILE_SIDE, TileLayout};

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
#[inline(always)]
pub const fn dequantise(step: u16) -> f32 {
    step as f32 * QUANTUM_M
}

/// How coarse the radii of a chain are: so many steps of [`QUANTUM_M`] are one of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Quantum(u16);

impl Quantum {
    /// As the author holds them: 3.8 µm.
    pub const FINEST: Self = Self(1);
    /// 11.4 µm: what a spectator cannot tell from the finest.
    pub const SPECTATOR: Self = Self(3);
    /// Coarsest: 0.98 mm.
    pub(super) const STEPS_MAX: u16 = 256;

    /// A quantum of so many of the finest, between 1 and 256 of them.
    #[must_use]
    pub const fn of_steps(steps: u16) -> Self {
        match steps {
            0 => Self::FINEST,
            1..=Self::STEPS_MAX => Self(steps),
            _ => Self(Self::STEPS_MAX),
        }
    }

    /// How many of the finest it is.
    #[must_use]
    pub const fn steps(self) -> u16 {
        self.0
    }

    /// Its length, m.
    #[must_use]
    pub fn metres(self) -> f32 {
        f32::from(self.0) * QUANTUM_M
    }

    /// The nearest of its own steps to one of the finest.
    pub(super) const fn coarsen(self, step: u16) -> u16 {
        ((step as u32 + self.0 as u32 / 2) / self.0 as u32) as u16
    }

    /// The radius of one of its own steps, exact.
    #[inline(always)]
    pub(super) fn radius_m(self, step: u16) -> f32 {
        dequantise(step.saturating_mul(self.0))
    }
}

/// One surface in quantum steps.
#[derive(Clone, Debug)]
pub(super) struct QuantisedGrid {
    layout: TileLayout,
    quantum: Quantum,
    /// The step of every element of the untouched surface.
    initial: u16,
    /// `[columns][rows]`.
    values: Vec<u16>,
    tile_digests: Vec<u64>,
    digest: u64,
}

impl QuantisedGrid {
    pub(super) fn untouched(shape: GridShape, radius_m: f32, quantum: Quantum) -> Self {
        let initial = quantum.coarsen(quantise(radius_m));
        let mut grid = Self {
            layout: TileLayout::new(shape),
            quantum,
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

    pub(super) const fn quantum(&self) -> Quantum {
        self.quantum
    }

    pub(super) const fn initial(&self) -> u16 {
        self.initial
    }

    /// Sum of the tiles' digests, each of which covers its own number.
    pub(super) const fn digest(&self) -> u64 {
        self.digest
    }

    /// The lowest 16 bits of every tile's digest.
    pub(super) fn short_digests(&self) -> impl Iterator<Item = u16> {
        self.tile_digests.iter().map(|&digest| digest as u16)
    }

    fn digest_of(&self, tile: u32) -> u64 {
        digest_of(tile, self.columns(self.layout.window(tile)))
    }

    /// Digest of a tile.
    pub(super) fn tile_digest(&self, tile: u32) -> u64 {
        self.tile_digests[tile as usize]
    }

    /// The window's columns, foot to rim.
    fn columns(&self, window: Window) -> impl Iterator<Item = &[u16]> {
        let rows = window.first_row as usize..window.end_row() as usize;
        (window.first_column..window.first_column + window.columns)
            .map(move |column| &self.column(column)[rows.clone()])
    }

    /// A whole column, foot to rim.
    pub(super) fn column(&self, column: u32) -> &[u16] {
        let rows = self.layout.shape().rows() as usize;
        &self.values[column as usize * rows..][..rows]
    }

    /// Writes a tile's differences to the untouched surface.
    pub(super) fn since_untouched(&self, tile: u32, plane: &mut Plane) {
        plane.add(tile);
        let window = self.layout.window(tile);
        let rows = window.first_row as usize..window.end_row() as usize;
        for column in window.first_column..window.first_column + window.columns {
            let differences = &mut plane.column_mut(column)[rows.clone()];
            for (difference, value) in differences.iter_mut().zip(&self.column(column)[rows.clone()]) {
                *difference = value.wrapping_sub(self.initial) as i16;
            }
        }
    }

    /// Turns a tile's differences to the untouched surface into those to what the tile holds; true when there are any.
    pub(super) fn against_untouched(&self, tile: u32, plane: &mut Plane) -> bool {
        let window = self.layout.window(tile);
        let rows = window.first_row as usize..window.end_row() as usize;
        let mut any = false;
        for column in window.first_column..window.first_column + window.columns {
            let differences = &mut plane.column_mut(column)[rows.clone()];
            for (difference, value) in differences.iter_mut().zip(&self.column(column)[rows.clone()]) {
                let new = self.initial.wrapping_add(*difference as u16);
                *difference = new.wrapping_sub(*value) as i16;
                any |= *difference != 0;
            }
        }
        any
    }

    /// Replaces a tile's values and notes the differences to what they were; true when there are any.
    pub(super) fn replace_tile(&mut self, tile: u32, values: &[u16], plane: &mut Plane) -> bool {
        let window = self.layout.window(tile);
        // compared column by column, so that a processor can do it many at once
        if self.columns(window).eq(values.chunks_exact(window.rows as usize)) {
            return false;
        }
        plane.add(tile);
        let (all_rows, rows) =
            (self.layout.shape().rows() as usize, window.first_row as usize..window.end_row() as usize);
        let columns = window.first_column..window.first_column + window.columns;
        for (column, new) in columns.zip(values.chunks_exact(window.rows as usize)) {
            let old = &mut self.values[column as usize * all_rows..][rows.clone()];
            let differences = &mut plane.column_mut(column)[rows.clone()];
            for ((old, &new), difference) in old.iter_mut().zip(new).zip(differences) {
                *difference = new.wrapping_sub(*old) as i16;
                *old = new;
            }
        }
        self.note(tile);
        true
    }

    /// Adds the differences of a tile, and tells `changed` of every column of it in which there are any: its number, the first row, and
    /// all new values there.
    #[inline(always)]
    pub(super) fn add_tile(&mut self, tile: u32, plane: &Plane, mut changed: impl FnMut(u32, u32, &[u16])) {
        let window = self.layout.window(tile);
        let all_rows = self.layout.shape().rows() as usize;
        let rows = window.first_row as usize..window.end_row() as usize;
        for column in window.first_column..window.first_column + window.columns {
            let differences = &plane.column(column)[rows.clone()];
            if differences.iter().fold(0, |any, difference| any | difference) == 0 {
                continue;
            }
            let values = &mut self.values[column as usize * all_rows..][rows.clone()];
            for (value, &difference) in values.iter_mut().zip(differences) {
                *value = value.wrapping_add(difference as u16);
            }
            changed(column, window.first_row, values);
        }
        self.note(tile);
    }

    fn note(&mut self, tile: u32) {
        let tile_digest = self.digest_of(tile);
        let old = core::mem::replace(&mut self.tile_digests[tile as usize], tile_digest);
        self.digest = self.digest.wrapping_sub(old).wrapping_add(tile_digest);
    }
}

/// The grids of an untouched pot, whose radii are rounded to the quantum; what is no skin always has the finest.
pub(super) fn untouched_grids(pot: &mut Pot, quantum: Quantum) -> Vec<QuantisedGrid> {
    let skins = pot.spec().skins();
    let round = |(number, surface): (usize, &mut Surface)| {
        let quantum = if number < skins { quantum } else { Quantum::FINEST };
        let grid = QuantisedGrid::untouched(surface.shape(), surface.radii_m()[0], quantum);
        for column in 0..surface.shape().columns() {
            for row in 0..surface.shape().rows() {
                surface.set_radius(column, row, quantum.radius_m(grid.initial));
            }
        }
        surface.take_as_untouched();
        grid
    };
    pot.surfaces_mut().iter_mut().enumerate().map(round).collect()
}

/// Rounds a window's radii to the quantum and says their steps, column by column.
pub(super) fn round_tile(clay: &mut Surface, window: Window, steps: &mut Vec<u16>) {
    steps.clear();
    let rows = window.first_row as usize..window.end_row() as usize;
    for column in window.first_column..window.first_column + window.columns {
        steps.extend(clay.column_m(column)[rows.clone()].iter().map(|&radius_m| quantise(radius_m)));
    }
    clay.change_window(window, |radius_m| dequantise(quantise(radius_m)));
}

/// Digest of a tile with such columns.
fn digest_of<C: AsRef<[u16]>>(tile: u32, columns: impl Iterator<Item = C>) -> u64 {
    let mut digest = Digest::default();
    digest.add(tile);
    for column in columns {
        let (twos, last) = column.as_ref().as_chunks();
        for &[first, second] in twos {
            digest.add(u32::from(first) << 16 | u32::from(second));
        }
        last.iter().for_each(|&value| digest.add(value.into()));
    }
    digest.finish()
}

/// Digest of a surface's tile, as [`super::Replica::tile_digest`] tells it of the same clay at the finest quantum.
#[must_use]
pub fn tile_digest(clay: &Surface, tile: u32) -> u64 {
    let window = TileLayout::new(clay.shape()).window(tile);
    let (first_row, rows) = (window.first_row as usize, window.rows as usize);
    let columns = window.first_column..window.first_column + window.columns;
    digest_of(
        tile,
        columns.map(|column| {
            let mut steps = [0; TILE_SIDE as usize];
            let radii_m = &clay.column_m(column)[first_row..][..rows];
            steps.iter_mut().zip(radii_m).for_each(|(step, &radius_m)| *step = quantise(radius_m));
            Column { steps, rows }
        }),
    )
}

/// A tile's column, of so many rows.
struct Column {
    steps: [u16; TILE_SIDE as usize],
    rows: usize,
}

impl AsRef<[u16]> for Column {
    fn as_ref(&self) -> &[u16] {
        &self.steps[..self.rows]
    }
}

/// Digest over all surfaces of a pot, in order.
pub(super) fn digest(grids: &[QuantisedGrid]) -> u64 {
    grids.iter().fold(0_u64, |sum, grid| sum.rotate_left(1) ^ grid.digest())
}
