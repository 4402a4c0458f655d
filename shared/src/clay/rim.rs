//! The rim that rises beside a dent: its shape, where it lies, and how it is laid over the clay.
//!
//! Owns what a press of the studio's own method moves; what yields is told by `plastic`, where it goes by `uptake`.
//! Invariant: no element that yields rises.

use core::f32::consts::PI;

use alloc::vec::Vec;
use core::ops::Range;

use super::contact::{Column, Contacts, nearest_turn};
use super::ellipse::{Ellipse, Step};
use super::lanes::{
    Eight, LANES, Select, Simd, SimdBase, SimdCvtTruncate, SimdFloat, counted, f32x8, i32x8, positive, root, splat,
};
use super::plastic::Slide;
use super::uptake::{Taker, Uptake};
use super::window::Push;
use super::{GridShape, Window};

/// A rim about an ellipse.
///
/// `κ(q²) = s²·(1 − σ + σ·s²)` with `s = (Q − q²)/(Q − 1)`, for 1 < q² < Q, up to which it rises where the tool does not touch; σ is the
/// share of sliding, before which the crest is sharper. `∫ κ = π·a_θ·a_z·(Q − 1)·(1/3 − σ·2/15)`. It ends without an edge and asks
/// for no quotient. It is weighted by `1 + x + α·(q_θ² − q_z²)`, no less than 0: x is the distance in
/// the direction of sliding over the half axis times the share of sliding, since clay rises before the tool and not in its groove;
/// α tells by how much more it rises to the sides where the pot curves away from the tool. What is cut off at 0 raises 2 % of the
/// rim of a sliding tool, 7 % where it goes along the pot with α = ¼.
pub(super) struct Rim {
    pub(super) dent: Ellipse,
    /// Volume that rises, m³; negative where the rim of an inner dent grows towards the axis.
    pub(super) volume_m3: f32,
    pub(super) shape: RimShape,
    /// Height of the tool's centre, m.
    pub(super) tool_z_m: f32,
}

/// What a rim looks like, in half axes of its ellipse.
#[derive(Clone, Copy)]
pub(super) struct RimShape {
    /// Q.
    pub(super) end: f32,
    /// σ.
    pub(super) slides: f32,
    /// α.
    pub(super) around: f32,
    /// Direction of sliding along the arc and up, as long as its share.
    pub(super) along: f32,
    pub(super) up: f32,
}

impl RimShape {
    pub(super) fn new(slide: Slide, around: f32, width: f32) -> Self {
        let Slide { along, up, share } = slide;
        Self { end: 1.0 + width, slides: share, around, along, up }
    }

    /// The rim's `∫ κ`, in areas of its ellipse.
    pub(super) fn area(&self) -> f32 {
        (self.end - 1.0) * (1.0 / 3.0 - self.slides * (2.0 / 15.0))
    }

    /// The s of κ as `start − q²·slope`.
    pub(super) fn line(&self) -> (f32, f32) {
        let slope = 1.0 / (self.end - 1.0);
        (self.end * slope, slope)
    }
}

impl Rim {
    /// Where the rim begins, in q²: it rises from here to q² = 1, so that no element is raised or not by a hair.
    pub(super) const BEGIN: f32 = 0.75;

    /// Begins a target over rim and contact, and lays into it the rim and what yields, chunk by chunk of the contact; the window.
    #[inline(always)]
    pub(super) fn lay<S: Simd>(
        &self,
        simd: S,
        (grid, step): (GridShape, Step),
        contacts: &Contacts,
        pushes: &[Push],
        RimScratch { rows, raised, pressed }: &mut RimScratch,
        mut uptake: impl Uptake<S>,
    ) -> Window {
        let (dent, end) = (&self.dent, self.shape.end);
        let centre_rad = contacts.angle_rad + dent.arc_m / dent.radius_m;
        let centre_z = self.tool_z_m + dent.above_m;
        let middle = libm::roundf(centre_rad / step.column_rad);
        let window = self.window((grid, &step), contacts, middle as i64, centre_z);
        uptake.begin(window);
        let crest_m = self.volume_m3 / (PI * dent.half_arc_m * dent.half_height_m * self.shape.area());
        self.fill_rows(simd, step.row_m, window, centre_z, rows);
        let kernel = Kernel::new(&self.shape, crest_m);
        // where each column is raised is found before any is, so that none waits for it
        raised.clear();
        let half_columns = (window.columns / 2) as i32;
        let off_rad = centre_rad - middle * step.column_rad;
        let arc_per_rad = dent.radius_m / dent.half_arc_m;
        let half_height_m = dent.half_height_m;
        let (zero, one, chunks) = (splat(simd, 0.0), i32x8::splat(simd, 1), i32x8::splat(simd, rows.len() as i32));
        let lattice = ChunkRows::new(window, step.row_m);
        for local in (0..window.columns).step_by(LANES) {
            let away_rad = if window.columns == grid.columns() {
                let turned = |lane: usize| nearest_turn((local as usize + lane) as f32 * step.column_rad - centre_rad);
                f32x8::load_array(simd, core::array::from_fn(turned))
            } else {
                counted(simd, (local as i32 - half_columns) as f32) * step.column_rad - off_rad
            };
            let arcs = away_rad * arc_per_rad;
            let left = splat(simd, end) - arcs * arcs;
            let outer_m = left.max(zero).sqrt() * half_height_m;
            let centre = splat(simd, centre_z);
            let from = lattice.chunk(centre - outer_m).min(chunks);
            let to = (lattice.chunk(centre + outer_m) + one).min(chunks);
            let to = positive(left).select(to, from).max(from);
            let [from, to] = [from, to].map(|chunks| chunks.to_array());
            raised.push(Raised { arcs: arcs.into(), from, to });
        }
        let chunks_of = |column: &Column| {
            let chunk = |row: u32| (row - window.first_row) / LANES as u32;
            chunk(column.first_row)..chunk(column.end_row())
        };
        let columns = contacts.columns();
        pressed.clear();
        pressed.resize(window.columns as usize, Pressed::NOT);
        let mut found = 0;
        for (number, column) in columns.iter().enumerate() {
            let chunks = chunks_of(column);
            if let Some(local) = window.local_column(grid, column.column) {
                pressed[local as usize].add(number, &chunks, found);
            }
            found += chunks.len();
        }
        let inwards = self.volume_m3 < 0.0;
        for (raised, (eight, pressed)) in raised.iter().zip(pressed.chunks(LANES).enumerate()) {
            let places = raised.arcs.0.iter().zip(raised.from).zip(raised.to);
            for ((lane, pressed), ((arc, from), to)) in pressed.iter().enumerate().zip(places) {
                let start = (from as u32).min(pressed.chunks[0]) as usize;
                let all = start..(to as u32).max(pressed.chunks[1]) as usize;
                let rise = kernel.column(simd, &self.shape, *arc);
                let rows = &rows[all.clone()];
                let (lanes, taker) = uptake.column(LANES * eight + lane, all);
                let stretch = |at: usize, part: &Column| {
                    let chunks = chunks_of(part);
                    (chunks.start as usize - start, &pushes[at..at + chunks.len()])
                };
                let first = match pressed.columns {
                    0 => Default::default(),
                    1 => stretch(pressed.pushes, &columns[pressed.first]),
                    _ => {
                        let parts = || {
                            let parts = &columns[pressed.first..pressed.first + pressed.columns];
                            parts.iter().scan(pressed.pushes, |at, part| {
                                let stretch = stretch(*at, part);
                                *at += stretch.1.len();
                                Some(stretch)
                            })
                        };
                        rise.lay_parts(simd, rows, parts, lanes, taker);
                        continue;
                    }
                };
                match (rise.begins, inwards) {
                    (true, false) => rise.lay::<_, true, false>(simd, rows, first, lanes, taker),
                    (false, false) => rise.lay::<_, false, false>(simd, rows, first, lanes, taker),
                    (true, true) => rise.lay::<_, true, true>(simd, rows, first, lanes, taker),
                    (false, true) => rise.lay::<_, false, true>(simd, rows, first, lanes, taker),
                }
            }
        }
        window
    }

    /// Where the rows of a window stand in the rim.
    #[inline(always)]
    fn fill_rows<S: Simd>(&self, simd: S, row_m: f32, window: Window, centre_z: f32, rows: &mut Vec<RimRow>) {
        let half_m = self.dent.half_height_m;
        let (per_row, first) = (row_m / half_m, centre_z / half_m);
        let (_, slope) = self.shape.line();
        rows.clear();
        for row in (window.first_row..window.end_row()).step_by(LANES) {
            let up = counted(simd, row as f32) * per_row - first;
            let ahead = up * (self.shape.up - up * self.shape.around);
            rows.push(RimRow { fallen: (up * up * slope).into(), ahead: ahead.into() });
        }
    }

    /// Every element within the rim's outer end or in the contact.
    fn window(&self, (grid, step): (GridShape, &Step), contacts: &Contacts, middle: i64, centre_z: f32) -> Window {
        let dent = &self.dent;
        let end = root(self.shape.end);
        let reach_m = end * dent.half_height_m;
        let row = |z_m: f32| libm::floorf(z_m / step.row_m) as i64;
        let (mut first_row, mut last_row) = (row(centre_z - reach_m), row(centre_z + reach_m) + 1);
        let mut reach_rad = end * dent.half_arc_m / dent.radius_m;
        for column in contacts.columns() {
            first_row = first_row.min(i64::from(column.first_row));
            last_row = last_row.max(i64::from(column.end_row()) - 1);
            // a ray may be up to a column away from the middle of what it is a part of
            let off_rad = if column.share < 1.0 { step.column_rad } else { 0.0 };
            reach_rad = reach_rad.max((column.angle_rad - dent.arc_m / dent.radius_m).abs() + off_rad);
        }
        // the middle stands within half a column of its own
        let half_columns = (reach_rad / step.column_rad + 0.501) as u32;
        Window::around(grid, middle, half_columns, first_row, last_row).aligned(grid.rows(), LANES as u32)
    }
}

/// What a rim needs between its passes.
#[derive(Clone, Debug, Default)]
pub(super) struct RimScratch {
    rows: Vec<RimRow>,
    raised: Vec<Raised>,
    pressed: Vec<Pressed>,
}

impl RimScratch {
    /// Room for any rim on `shape`.
    pub(super) fn with_room(shape: GridShape) -> Self {
        Self {
            rows: Vec::with_capacity(shape.rows() as usize / LANES + 2),
            raised: Vec::with_capacity((shape.columns() as usize).div_ceil(LANES)),
            pressed: Vec::with_capacity(shape.columns() as usize),
        }
    }
}

/// Where heights stand among the chunks of a window.
struct ChunkRows {
    per_m: f32,
    first: f32,
}

impl ChunkRows {
    fn new(window: Window, row_m: f32) -> Self {
        Self { per_m: 1.0 / row_m * (1.0 / LANES as f32), first: (window.first_row as usize / LANES) as f32 }
    }

    /// The chunk in which each height is, the first one where it is below: an eighth of a number is exact, and so is what is left of
    /// it beyond a smaller one.
    #[inline(always)]
    fn chunk<S: Simd>(&self, height_m: f32x8<S>) -> i32x8<S> {
        i32x8::truncate_from((height_m * self.per_m - self.first).max(splat(height_m.simd, 0.0)))
    }
}

/// Eight columns of a rim: half axes aside of its middle, and from which chunk to before which each is raised.
#[derive(Clone, Debug)]
struct Raised {
    arcs: Eight,
    from: [i32; LANES],
    to: [i32; LANES],
}

/// What of a column is pressed.
#[derive(Clone, Debug)]
struct Pressed {
    /// From its first chunk to before its last.
    chunks: [u32; 2],
    /// The first of the contact's columns that is this one, how many are, and where they stand among what yields.
    first: usize,
    columns: usize,
    pushes: usize,
}

impl Pressed {
    const NOT: Self = Self { chunks: [u32::MAX, 0], first: 0, columns: 0, pushes: 0 };

    /// Adds that a contact's column of some number presses chunks, and where that stands among what yields.
    fn add(&mut self, number: usize, chunks: &Range<u32>, pushes: usize) {
        if self.columns == 0 {
            (self.first, self.pushes) = (number, pushes);
        }
        self.columns = number + 1 - self.first;
        self.chunks = [self.chunks[0].min(chunks.start), self.chunks[1].max(chunks.end)];
    }
}

/// Eight rows of a rim: how far the line of its [`Kernel`] has fallen up to their height, and what they add to the rim's weight.
#[derive(Clone, Copy, Debug)]
struct RimRow {
    fallen: Eight,
    ahead: Eight,
}

/// κ of a column as `s²·(blunt + sharp·s²)`, s a line in the square of the height, with the height of the crest in both factors.
struct Kernel {
    start: f32,
    slope: f32,
    blunt_m: f32,
    sharp_m: f32,
}

impl Kernel {
    fn new(shape: &RimShape, crest_m: f32) -> Self {
        let (start, slope) = shape.line();
        Self { start, slope, blunt_m: (1.0 - shape.slides) * crest_m, sharp_m: shape.slides * crest_m }
    }

    /// The same in a column that stands so many half axes aside of the middle.
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, shape: &RimShape, arc: f32) -> Rise<S> {
        let arc2 = arc * arc;
        Rise {
            line: self.start - arc2 * self.slope,
            beside: 1.0 + shape.along * arc + shape.around * arc2,
            blunt_m: self.blunt_m,
            sharp_m: self.sharp_m,
            begins: arc2 < 1.0,
            at_begin: splat(simd, self.start - Rim::BEGIN * self.slope),
            by_line: 1.0 / ((1.0 - Rim::BEGIN) * self.slope),
        }
    }
}

/// A rim in one column.
struct Rise<S: Simd> {
    /// The line of its [`Kernel`] at the height of the middle.
    line: f32,
    /// What stands aside adds to the rim's weight.
    beside: f32,
    blunt_m: f32,
    sharp_m: f32,
    /// Whether the rim begins in this column, where the line has fallen to `at_begin`.
    begins: bool,
    at_begin: f32x8<S>,
    by_line: f32,
}

/// What of a contact's column yields, from a place among the chunks that change in it.
type Yielding<'a> = (usize, &'a [Push]);

impl<S: Simd> Rise<S> {
    /// Lays all chunks that change into a column, of which the rim raises those that no tool touches one way.
    #[inline(always)]
    fn lay<T: Taker<S>, const BEGINS: bool, const INWARDS: bool>(
        &self,
        simd: S,
        rows: &[RimRow],
        (start, pushes): Yielding<'_>,
        lanes: &mut [[f32; LANES]],
        taker: &mut T,
    ) {
        let (under, lanes) = lanes.split_at_mut(start);
        let (within, above) = lanes.split_at_mut(pushes.len());
        let (rows_under, rows) = rows.split_at(start);
        let (rows_within, rows_above) = rows.split_at(pushes.len());
        for (lanes, row) in under.iter_mut().zip(rows_under) {
            taker.raise::<INWARDS>(lanes, self.raised_m::<BEGINS>(simd, row));
        }
        for ((lanes, row), push) in within.iter_mut().zip(rows_within).zip(pushes) {
            let push_m = self.raised_m::<BEGINS>(simd, row) * push.rising.on(simd) + push.delta_m.on(simd);
            taker.take(lanes, push_m);
        }
        for (lanes, row) in above.iter_mut().zip(rows_above) {
            taker.raise::<INWARDS>(lanes, self.raised_m::<BEGINS>(simd, row));
        }
    }

    /// The same where a column is looked at along several rays: it yields along all of them, and rises where none presses.
    #[inline(always)]
    fn lay_parts<'a, P: Iterator<Item = Yielding<'a>>>(
        &self,
        simd: S,
        rows: &[RimRow],
        parts: impl Fn() -> P,
        lanes: &mut [[f32; LANES]],
        taker: &mut impl Taker<S>,
    ) {
        for (number, (lanes, row)) in lanes.iter_mut().zip(rows).enumerate() {
            let at = |(start, pushes): Yielding<'a>| pushes.get(number.wrapping_sub(start));
            let mut push_m =
                if self.begins { self.raised_m::<true>(simd, row) } else { self.raised_m::<false>(simd, row) };
            for push in parts().skip(1).filter_map(at) {
                push_m *= push.rising.on(simd);
            }
            if let Some(push) = parts().next().and_then(at) {
                push_m = push_m * push.rising.on(simd) + push.delta_m.on(simd);
            }
            for push in parts().skip(1).filter_map(at) {
                push_m += push.delta_m.on(simd);
            }
            taker.take(lanes, push_m);
        }
    }

    /// By how much eight rows rise, m; where it does not begin in this column, it has begun everywhere.
    #[inline(always)]
    fn raised_m<const BEGINS: bool>(&self, simd: S, row: &RimRow) -> f32x8<S> {
        let zero = splat(simd, 0.0);
        let line = splat(simd, self.line) - row.fallen.on(simd);
        let above = line.max(zero);
        let square = above * above;
        let beside = (row.ahead.on(simd) + self.beside).max(zero);
        let raised = square * (square * self.sharp_m + self.blunt_m) * beside;
        if !BEGINS {
            return raised;
        }
        raised * ((self.at_begin - line) * self.by_line).max(zero).min(splat(simd, 1.0))
    }
}
