//! The part of a grid that a press touches, and the displacement it asks for there.
//!
//! Owns the wrap at θ = 0: a window may start before the seam and end behind it.
//! Invariant: a window lies within its grid, and no column of the grid stands in it twice.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;

use super::GridShape;
use super::contact::{Contacts, Stretch};
use super::faceted::Cutter;
use super::folds::Fold;
use super::joint::Joint;
use super::lanes::{Eight, LANES, Simd, SimdBase, Vectors};
use super::rim::RimScratch;
use super::series::Braced;

/// Tools that bend a wall together without allocating.
const JOINT_TOOLS: usize = 8;

/// A rectangle of elements; columns wrap round the pot, rows do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// First column, in `0..shape.columns()`.
    pub first_column: u32,
    /// Number of columns, at most the whole ring.
    pub columns: u32,
    /// First row.
    pub first_row: u32,
    /// Number of rows.
    pub rows: u32,
}

impl Window {
    /// The window from `column - half_columns` to `column + half_columns` and over rows `first_row..=last_row`,
    /// clipped to the grid; empty when no row lies within.
    #[must_use]
    pub fn around(shape: GridShape, column: i64, half_columns: u32, first_row: i64, last_row: i64) -> Self {
        let first_row = first_row.max(0);
        let last_row = last_row.min(i64::from(shape.rows()) - 1);
        if last_row < first_row {
            return Self::default();
        }
        let rows = (last_row - first_row + 1) as u32;
        let columns = half_columns.saturating_mul(2).saturating_add(1);
        let (first_column, columns) = if columns >= shape.columns() {
            (0, shape.columns())
        } else {
            (shape.wrap(column - i64::from(half_columns)), columns)
        };
        Self { first_column, columns, first_row: first_row as u32, rows }
    }

    /// This window grown by `columns` on both sides and `rows` above and below, clipped to the grid.
    #[must_use]
    pub fn grown(self, shape: GridShape, columns: u32, rows: u32) -> Self {
        if self.is_empty() {
            return self;
        }
        let first_row = self.first_row.saturating_sub(rows);
        let end_row = (self.first_row + self.rows + rows).min(shape.rows());
        let wide = self.columns + 2 * columns;
        let (first_column, wide) = if wide >= shape.columns() {
            (0, shape.columns())
        } else {
            (shape.wrap(i64::from(self.first_column) - i64::from(columns)), wide)
        };
        Self { first_column, columns: wide, first_row, rows: end_row - first_row }
    }

    /// This window grown to rows that are multiples of `step`, as far as the grid goes.
    #[must_use]
    pub fn aligned(self, rows: u32, step: u32) -> Self {
        let first_row = self.first_row / step * step;
        let end_row = self.end_row().next_multiple_of(step).min(rows);
        Self { first_row, rows: end_row - first_row, ..self }
    }

    /// The row after its last one.
    #[must_use]
    pub const fn end_row(self) -> u32 {
        self.first_row + self.rows
    }

    /// Whether the window holds no element.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.columns == 0 || self.rows == 0
    }

    /// Number of elements in the window.
    #[must_use]
    pub const fn elements(self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Whether an element lies in both windows.
    #[must_use]
    pub fn meets(self, other: Self, shape: GridShape) -> bool {
        let begins_within = |one: Self, other: Self| one.local_column(shape, other.first_column).is_some();
        !self.is_empty()
            && !other.is_empty()
            && self.first_row < other.end_row()
            && other.first_row < self.end_row()
            && (begins_within(self, other) || begins_within(other, self))
    }

    /// The grid's columns that the window covers, in order round the pot.
    pub fn grid_columns(self, shape: GridShape) -> impl Iterator<Item = u32> + Clone {
        (0..self.columns).map(move |local| {
            let column = self.first_column + local;
            if column < shape.columns() { column } else { column - shape.columns() }
        })
    }

    /// The window's own number of a grid column, when the window covers it.
    #[must_use]
    pub fn local_column(self, shape: GridShape, column: u32) -> Option<u32> {
        let ring = if column < self.first_column { shape.columns() } else { 0 };
        let local = column + ring - self.first_column;
        (local < self.columns).then_some(local)
    }
}

/// What one press asks of the clay: a change of radius for every element of its window.
#[derive(Clone, Debug, Default)]
pub struct Footprint {
    window: Window,
    /// `[window.columns][window.rows]`, each column from a whole eight on, and whatever is left of larger windows, m; negative
    /// pushes towards the axis.
    delta_m: Vec<[f32; LANES]>,
    /// Rows of each of the window's columns beyond which nothing is displaced.
    spans: Vec<Range<u32>>,
    /// Share of what it displaces by which the skin on the other side of a wall goes with the one that is pressed.
    pub(super) follows: f32,
    /// How it folds a wall.
    pub(super) fold: Option<Fold>,
    pub(super) scratch: Scratch,
}

/// What a method needs between its passes, kept so that no step allocates.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    pub(super) vectors: Vectors,
    pub(super) contacts: Contacts,
    pub(super) boundary: Vec<Boundary>,
    /// What yields, chunk by chunk of the contacts.
    pub(super) pushes: Vec<Push>,
    pub(super) row_kernel: Vec<f32>,
    pub(super) rim: RimScratch,
    /// How a wall has given way under this press among others, once they were braced; the contacts are then found already.
    pub(super) braced: Option<Braced>,
    pub(super) joint: Joint,
    /// The convex tools, lent by the sub-step for the time of a press with one.
    pub(super) cutter: Option<Box<Cutter>>,
}

/// What yields of a chunk of the contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    /// By how much this step moves the element, m; zero where the tool does not touch.
    pub(super) delta_m: Eight,
    /// Share of the rim that an element takes: less the more it is pressed, none where it yields.
    pub(super) rising: Eight,
    /// Share of the pressure on an element times the tool's area on it, over the area of an element at radius 1.
    pub(super) carried: Eight,
}

impl Push {
    pub(super) const NONE: Self = Self { delta_m: Eight::ZERO, rising: Eight::ZERO, carried: Eight::ZERO };
}

/// A touched element beside an untouched one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boundary {
    pub(super) local_column: u32,
    pub(super) row: u32,
    /// This step's push, m.
    pub(super) push_m: f32,
    /// Radius of the element, m.
    pub(super) radius_m: f32,
}

impl Footprint {
    /// A footprint that will hold any window of `shape` without allocating again.
    #[must_use]
    pub fn for_grid(shape: GridShape) -> Self {
        let elements = shape.elements();
        let eights = shape.columns() as usize * (shape.rows() as usize).div_ceil(LANES);
        let scratch = Scratch {
            vectors: Vectors::default(),
            boundary: Vec::with_capacity(elements),
            contacts: Contacts::with_room(shape),
            pushes: Vec::with_capacity(eights),
            rim: RimScratch::with_room(shape),
            row_kernel: Vec::with_capacity(2 * shape.rows() as usize + 1 + 2 * LANES),
            braced: None,
            joint: Joint::with_room(JOINT_TOOLS),
            cutter: None,
        };
        Self {
            window: Window::default(),
            delta_m: Vec::with_capacity(eights),
            spans: Vec::with_capacity(shape.columns() as usize),
            follows: 1.0,
            fold: None,
            scratch,
        }
    }

    /// The same with other vectors.
    pub(super) fn using(mut self, vectors: Vectors) -> Self {
        self.scratch.vectors = vectors;
        self
    }

    /// Empties the footprint and lays it over `window`, all displacements zero.
    pub fn reset(&mut self, window: Window) {
        self.lay(window);
        let eights = window.columns as usize * self.column_eights();
        self.delta_m[..eights].fill([0.0; LANES]);
        self.spans.fill(0..window.rows);
    }

    /// Lays the footprint over `window`, none of whose elements is displaced until [`Footprint::narrow`] gives them out: what
    /// is not displaced need not be cleared.
    pub(super) fn lay(&mut self, window: Window) {
        (self.window, self.follows, self.fold) = (window, 1.0, None);
        let eights = window.columns as usize * self.column_eights();
        if self.delta_m.len() < eights {
            self.delta_m.resize(eights, [0.0; LANES]);
        }
        self.spans.clear();
        self.spans.resize(window.columns as usize, 0..0);
    }

    /// Eights that a column takes.
    const fn column_eights(&self) -> usize {
        (self.window.rows as usize).div_ceil(LANES)
    }

    /// Takes eights of a column for those that may be displaced, and gives them to be written, every one.
    #[inline(always)]
    pub(super) fn narrow(&mut self, local: usize, eights: Range<usize>) -> &mut [[f32; LANES]] {
        let end = ((eights.end * LANES) as u32).min(self.window.rows);
        self.spans[local] = (eights.start * LANES) as u32..end;
        let start = local * self.column_eights();
        &mut self.delta_m[start + eights.start..start + eights.end]
    }

    /// The rows of the window's column `local` that may be displaced, and their displacements, m.
    ///
    /// # Panics
    /// When the window has no such column.
    #[inline]
    #[must_use]
    pub fn span(&self, local: u32) -> (Range<usize>, &[f32]) {
        let Range { start, end } = self.spans[local as usize];
        let rows = start as usize..end as usize;
        (rows.clone(), &self.column(local)[rows])
    }

    /// The same, to be changed.
    pub(super) fn span_mut(&mut self, local: u32) -> (Range<usize>, &mut [f32]) {
        let Range { start, end } = self.spans[local as usize];
        let rows = start as usize..end as usize;
        (rows.clone(), &mut self.column_mut(local)[rows])
    }

    /// All displacements of the window's column `local` in a footprint that was [`Footprint::reset`], foot to rim, m.
    pub(super) fn column(&self, local: u32) -> &[f32] {
        let start = local as usize * self.column_eights();
        &self.delta_m[start..].as_flattened()[..self.window.rows as usize]
    }

    /// The elements it covers.
    #[must_use]
    pub const fn window(&self) -> Window {
        self.window
    }

    /// The same in whole eights, the last of which may end beyond the window.
    #[inline(always)]
    pub(super) fn column_eights_mut(&mut self, local: u32) -> &mut [[f32; LANES]] {
        let (start, eights) = (local as usize * self.column_eights(), self.column_eights());
        &mut self.delta_m[start..start + eights]
    }

    /// Writes `share` of the penetration wherever the tool touches; the window must cover it from a whole eight on.
    #[inline(always)]
    pub(super) fn write<S: Simd>(&mut self, simd: S, shape: GridShape, stretch: &Stretch<'_>, share: f32) {
        let Some(local) = self.window.local_column(shape, stretch.column.column) else { return };
        let start = local as usize * self.column_eights();
        let first = (stretch.column.first_row - self.window.first_row) as usize / LANES;
        for (delta_m, chunk) in self.delta_m[start + first..].iter_mut().zip(stretch.chunks) {
            *delta_m = (chunk.penetration_m.on(simd) * share).to_array();
        }
    }

    /// Displacements of the window's column `local`, foot to rim, m; of a footprint that was [`Footprint::reset`] all of them
    /// count.
    ///
    /// # Panics
    /// When the window has no such column.
    pub fn column_mut(&mut self, local: u32) -> &mut [f32] {
        let start = local as usize * self.column_eights();
        &mut self.delta_m[start..].as_flattened_mut()[..self.window.rows as usize]
    }
}
