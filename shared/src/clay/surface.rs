//! One skin of the pot: a grid of radii over angle and height.
//!
//! Owns the radii and their bounds, and the places of the elements; no method and no tool.
//! Invariant: every radius is finite and within the bounds; `set_radius`, `set_run`, `change_window`, `Mover`, `Wall` and `folds` see to it.

use alloc::sync::Arc;
use alloc::vec::Vec;

use glam::Vec2;

use super::lanes::{LANES, Simd, SimdBase, f32x8, load, numbers, with_vectors};
use super::uptake::{Mover, Taker};
use super::{Digest, Footprint, GridShape, Support, WallBending, Window};
use crate::tool::{Lattice, Side};

/// A grid of circular sector elements: radius r(θ, z) of the skin at evenly spaced angles and heights.
///
/// Column j stands at θ = j·2π/columns, row i at z = i·height/(rows − 1), so that the first row is the foot and
/// the last the rim. Lee and Choi, section II A.
#[derive(Clone, Debug)]
pub struct Surface {
    shape: GridShape,
    height_m: f32,
    ledger: Ledger,
    radius_min_m: f32,
    radius_max_m: f32,
    thickness_m: f32,
    /// From where tools meet it, when those from the other side meet another.
    met_from: Option<Side>,
    /// How the wall bends, when nothing stands behind it.
    bending: Option<Arc<WallBending>>,
    /// No element is or ever was narrower or wider, m.
    narrowest_m: f32,
    widest_m: f32,
    /// Cosine and sine of each column's angle.
    directions: Arc<[Vec2]>,
    /// `[columns][rows]`, m.
    radii_m: Vec<f32>,
}

impl PartialEq for Surface {
    /// Whether both are the same clay; by how much they were once wider does not matter.
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape
            && self.height_m == other.height_m
            && self.bounds_m() == other.bounds_m()
            && self.thickness_m == other.thickness_m
            && self.met_from == other.met_from
            && self.bending == other.bending
            && self.radii_m == other.radii_m
    }
}

impl Surface {
    /// Step of the radii that are kept for good: 2⁻¹⁸ m = 3.8 µm, a power of two so that it is exact in `f32`. The bounds are
    /// multiples of it.
    pub const STEP_M: f32 = 1.0 / 262_144.0;

    /// A cylinder of `radius_m` and `height_m` with `thickness_m` of clay behind its skin, whose radii will stay within
    /// `radius_min_m..=radius_max_m`, and which bends when nothing stands behind the clay.
    pub(super) fn cylinder(
        shape: GridShape,
        height_m: f32,
        radius_m: f32,
        (radius_min_m, radius_max_m): (f32, f32),
        thickness_m: f32,
        bending: Option<Arc<WallBending>>,
    ) -> Self {
        let (radius_min_m, radius_max_m) = (
            libm::floorf(radius_min_m / Self::STEP_M) * Self::STEP_M,
            libm::ceilf(radius_max_m / Self::STEP_M) * Self::STEP_M,
        );
        assert!(radius_min_m > 0.0 && radius_min_m <= radius_m && radius_m <= radius_max_m);
        Self {
            shape,
            height_m,
            ledger: Ledger::untouched(shape, height_m, radius_m),
            radius_min_m,
            radius_max_m,
            thickness_m,
            met_from: None,
            bending,
            narrowest_m: radius_m,
            widest_m: radius_m,
            directions: directions(shape.columns()),
            radii_m: alloc::vec![radius_m; shape.elements()],
        }
    }

    /// The same, as the face that tools from one side alone meet.
    pub(super) const fn met_from(mut self, side: Side) -> Self {
        self.met_from = Some(side);
        self
    }

    /// Number of elements each way.
    #[must_use]
    pub const fn shape(&self) -> GridShape {
        self.shape
    }

    /// Height from foot to rim, m.
    #[must_use]
    pub const fn height_m(&self) -> f32 {
        self.height_m
    }

    /// Smallest and largest radius an element may take, m.
    #[must_use]
    pub const fn bounds_m(&self) -> (f32, f32) {
        (self.radius_min_m, self.radius_max_m)
    }

    /// Thickness of the clay behind the skin, m.
    #[must_use]
    pub const fn thickness_m(&self) -> f32 {
        self.thickness_m
    }

    /// How far the face that a tool from this side meets lies within the radii, m.
    #[must_use]
    pub const fn inset_m(&self, side: Side) -> f32 {
        match (self.met_from, side) {
            (None, Side::Inside) => self.thickness_m,
            _ => 0.0,
        }
    }

    /// What stands behind the clay.
    #[must_use]
    pub const fn support(&self) -> Support {
        if self.bending.is_some() { Support::Hollow } else { Support::Backed }
    }

    /// How the wall bends; nothing when it is backed.
    #[must_use]
    pub fn bending(&self) -> Option<&WallBending> {
        self.bending.as_deref()
    }

    /// A radius that no element exceeds, m; not always the smallest such.
    pub(super) const fn widest_m(&self) -> f32 {
        self.widest_m
    }

    /// A radius that every element exceeds or has, m; not always the largest such.
    pub(super) const fn narrowest_m(&self) -> f32 {
        self.narrowest_m
    }

    /// Distance between neighbouring rows, m.
    #[must_use]
    pub fn row_height_m(&self) -> f32 {
        self.height_m / (self.shape.rows() - 1) as f32
    }

    /// Cosine and sine of a column's angle.
    ///
    /// # Panics
    /// When the grid has no such column.
    #[must_use]
    pub fn direction(&self, column: u32) -> [f32; 2] {
        self.directions[column as usize].to_array()
    }

    /// Directions of as many columns as are worked on at once, from one on, when there are so many.
    pub(super) fn directions_from(&self, column: u32) -> Option<&[Vec2; LANES]> {
        self.directions.get(column as usize..)?.first_chunk()
    }

    /// Columns and rows as a convex tool is cut by them.
    pub(super) fn lattice(&self) -> Lattice<'_> {
        Lattice { directions: &self.directions, rows: self.shape.rows(), row_height_m: self.row_height_m() }
    }

    /// Height of a row above the wheel head, m.
    #[must_use]
    pub fn row_z_m(&self, row: u32) -> f32 {
        row as f32 * self.row_height_m()
    }

    /// All radii, `[columns][rows]`, m.
    #[must_use]
    pub fn radii_m(&self) -> &[f32] {
        &self.radii_m
    }

    /// Radii of one column, foot to rim, m.
    ///
    /// # Panics
    /// When the grid has no such column.
    #[must_use]
    pub fn column_m(&self, column: u32) -> &[f32] {
        let rows = self.shape.rows() as usize;
        &self.radii_m[column as usize * rows..][..rows]
    }

    /// Sets one radius, clamped to the bounds; a value that is not a number leaves the element as it was.
    ///
    /// # Panics
    /// When the grid has no such element.
    pub fn set_radius(&mut self, column: u32, row: u32, radius_m: f32) {
        assert!(row < self.shape.rows());
        if !radius_m.is_nan() {
            let index = column as usize * self.shape.rows() as usize + row as usize;
            self.radii_m[index] = radius_m.clamp(self.radius_min_m, self.radius_max_m);
            self.note_span(self.radii_m[index], self.radii_m[index]);
        }
    }

    /// Sets radii above one another, from a row on, to what is made of `values`: multiples of [`Surface::STEP_M`], where there were such. As in
    /// [`Surface::set_radius`], the bounds hold. How much clay stands there stays known, so that nothing has to be noted.
    ///
    /// # Panics
    /// When there are more of them than rows.
    #[inline(always)]
    pub(crate) fn set_run<T: Copy>(&mut self, column: u32, first_row: u32, values: &[T], radius_m: impl Fn(T) -> f32) {
        let rows = self.shape.rows() as usize;
        assert!(!values.is_empty() && first_row as usize + values.len() <= rows);
        let start = column as usize * rows + first_row as usize;
        let radii_m = &mut self.radii_m[start..][..values.len()];
        let (low_m, high_m) = (self.radius_min_m, self.radius_max_m);
        let square = |radius_m: f32| f64::from(radius_m) * f64::from(radius_m);
        let ends = [(0, first_row == 0), (values.len() - 1, first_row as usize + values.len() == rows)];
        let half_of_ends = |radii_m: &[f32]| -> f64 {
            ends.iter().filter(|(_, is_end)| *is_end).map(|(at, _)| 0.5 * square(radii_m[*at])).sum()
        };
        let ends_before_m2 = half_of_ends(radii_m);
        // one a lane, so that no element waits for the one before; an exact sum has no order
        let (mut narrowest_m, mut widest_m) = ([self.narrowest_m; LANES], [self.widest_m; LANES]);
        let mut more_m2 = [0.0; LANES];
        let narrower = |one_m: f32, other_m: f32| if one_m < other_m { one_m } else { other_m };
        let wider = |one_m: f32, other_m: f32| if one_m > other_m { one_m } else { other_m };
        // whole ones apart, so that a processor can work on their lanes at once
        let (whole_m, last_m) = radii_m.as_chunks_mut::<LANES>();
        let (whole, last) = values.as_chunks::<LANES>();
        for (kept_m, values) in whole_m.iter_mut().zip(whole) {
            let set_m = values.map(|value| radius_m(value).clamp(low_m, high_m));
            more_m2 = core::array::from_fn(|lane| more_m2[lane] + (square(set_m[lane]) - square(kept_m[lane])));
            narrowest_m = core::array::from_fn(|lane| narrower(set_m[lane], narrowest_m[lane]));
            widest_m = core::array::from_fn(|lane| wider(set_m[lane], widest_m[lane]));
            *kept_m = set_m;
        }
        for (lane, (kept_m, &value)) in last_m.iter_mut().zip(last).enumerate() {
            let set_m = radius_m(value).clamp(low_m, high_m);
            more_m2[lane] += square(set_m) - square(*kept_m);
            narrowest_m[lane] = narrower(set_m, narrowest_m[lane]);
            widest_m[lane] = wider(set_m, widest_m[lane]);
            *kept_m = set_m;
        }
        let more_m2 = more_m2.iter().sum::<f64>() - (half_of_ends(radii_m) - ends_before_m2);
        self.note_span(narrowest_m.into_iter().fold(f32::MAX, narrower), widest_m.into_iter().fold(f32::MIN, wider));
        self.ledger.add(column, more_m2);
    }

    /// Moves the elements of a window by a footprint's displacements; as in [`Surface::set_radius`], the bounds hold and
    /// what is not a number changes nothing.
    ///
    /// # Panics
    /// When the window lies outside of the grid.
    pub fn displace(&mut self, footprint: &Footprint) {
        with_vectors!(footprint.scratch.vectors, simd => self.displace_with(simd, footprint));
    }

    #[inline(always)]
    fn displace_with<S: Simd>(&mut self, simd: S, footprint: &Footprint) {
        let window = footprint.window();
        let rows = self.shape.rows();
        let mut mover = Mover::of(simd, self);
        for (local, column) in (0..).zip(window.grid_columns(self.shape)) {
            let (span, deltas_m) = footprint.span(local);
            let start = column as usize * rows as usize + window.first_row as usize + span.start;
            let radii_m = &mut self.radii_m[start..][..deltas_m.len()];
            let (radii, last_radii) = radii_m.as_chunks_mut::<LANES>();
            let (deltas, last_deltas) = deltas_m.as_chunks::<LANES>();
            for (radii, deltas) in radii.iter_mut().zip(deltas) {
                mover.take(radii, numbers(f32x8::load_array_ref(simd, deltas)));
            }
            if !last_radii.is_empty() {
                // as wide as one that is there where there is none
                let mut lanes = [last_radii[0]; LANES];
                lanes[..last_radii.len()].copy_from_slice(last_radii);
                mover.take(&mut lanes, numbers(load(simd, last_deltas)));
                last_radii.copy_from_slice(&lanes[..last_radii.len()]);
            }
        }
        mover.note(self);
    }

    /// Puts every radius of a window through `change`; as in [`Surface::set_radius`], the bounds hold and what is not a number
    /// changes nothing.
    ///
    /// # Panics
    /// When the window lies outside of the grid.
    pub fn change_window(&mut self, window: Window, change: impl Fn(f32) -> f32) {
        let rows = self.shape.rows() as usize;
        let (low_m, high_m) = (self.radius_min_m, self.radius_max_m);
        // one a lane, so that no element waits for the one before
        let mut spans_m = [(self.narrowest_m, self.widest_m); LANES];
        let put = |radius_m: &mut f32, (narrowest_m, widest_m): &mut (f32, f32)| {
            let changed_m = change(*radius_m);
            let kept_m = if changed_m.is_nan() { *radius_m } else { changed_m.clamp(low_m, high_m) };
            *narrowest_m = if kept_m < *narrowest_m { kept_m } else { *narrowest_m };
            *widest_m = if kept_m > *widest_m { kept_m } else { *widest_m };
            *radius_m = kept_m;
        };
        for column in window.grid_columns(self.shape) {
            let start = column as usize * rows + window.first_row as usize;
            let (eights, last) = self.radii_m[start..][..window.rows as usize].as_chunks_mut::<LANES>();
            for eight in eights {
                eight.iter_mut().zip(&mut spans_m).for_each(|(radius_m, span_m)| put(radius_m, span_m));
            }
            last.iter_mut().zip(&mut spans_m).for_each(|(radius_m, span_m)| put(radius_m, span_m));
        }
        for (narrowest_m, widest_m) in spans_m {
            self.note_span(narrowest_m, widest_m);
        }
    }

    /// Takes the radii of `window` over from a surface of the same shape.
    ///
    /// # Panics
    /// When the shapes differ or the window lies outside.
    pub fn copy_window(&mut self, from: &Self, window: Window) {
        assert_eq!(self.shape, from.shape);
        let rows = self.shape.rows() as usize;
        for column in window.grid_columns(self.shape) {
            let start = column as usize * rows + window.first_row as usize;
            let range = start..start + window.rows as usize;
            self.radii_m[range.clone()].copy_from_slice(&from.radii_m[range]);
        }
        self.note_span(from.narrowest_m, from.widest_m);
        self.height_m = from.height_m;
    }

    /// Becomes a surface of the same shape without allocating.
    ///
    /// # Panics
    /// When the shapes differ.
    pub fn copy_from(&mut self, from: &Self) {
        assert_eq!(self.shape, from.shape);
        self.radii_m.copy_from_slice(&from.radii_m);
        self.ledger.copy_from(&from.ledger);
        (self.height_m, self.narrowest_m, self.widest_m) = (from.height_m, from.narrowest_m, from.widest_m);
    }

    /// A skin of the same clay on another grid with radii `[columns][rows]`, m, which the bounds hold.
    pub(super) fn with_radii(&self, shape: GridShape, radii_m: &[f32]) -> Self {
        let elements = |shape: GridShape| f64::from(shape.columns()) * f64::from(shape.rows() - 1);
        let mut other = Self::cylinder(
            shape,
            self.height_m,
            self.radius_max_m,
            self.bounds_m(),
            self.thickness_m,
            self.bending.clone(),
        );
        (other.narrowest_m, other.widest_m) = (self.narrowest_m, self.widest_m);
        other.met_from = self.met_from;
        for (element, &radius_m) in radii_m.iter().enumerate() {
            let (column, row) = (element / shape.rows() as usize, element % shape.rows() as usize);
            other.set_radius(column as u32, row as u32, radius_m);
        }
        let first_sum_m2 = self.ledger.first_sum_m2 * elements(shape) / elements(self.shape);
        (other.ledger.first_height_m, other.ledger.first_sum_m2) = (self.ledger.first_height_m, first_sum_m2);
        other.ledger.stale.fill(true);
        other
    }

    /// Takes the radii as they are for those of the untouched skin, to which its height is reckoned.
    pub fn take_as_untouched(&mut self) {
        let columns = 0..self.shape.columns();
        let mut ledger = Ledger::untouched(self.shape, self.ledger.first_height_m, 0.0);
        for column in columns {
            ledger.note(column, self.column_m(column));
        }
        ledger.first_sum_m2 = ledger.sum_m2;
        self.height_m = ledger.first_height_m;
        self.ledger = ledger;
    }

    /// Notes that radii in a window are others than when [`Surface::sum_up`] last looked.
    pub(super) fn note_changed(&mut self, window: Window) {
        for column in window.grid_columns(self.shape) {
            self.ledger.stale[column as usize] = true;
        }
    }

    /// Takes in what was noted to have changed.
    pub(super) fn sum_up(&mut self) {
        let rows = self.shape.rows() as usize;
        for column in 0..self.shape.columns() {
            if core::mem::take(&mut self.ledger.stale[column as usize]) {
                self.ledger.note(column, &self.radii_m[column as usize * rows..][..rows]);
            }
        }
    }

    /// Σ r² over all elements, half at foot and rim, when it was untouched and now, m². Exact for radii that are multiples of
    /// [`Surface::STEP_M`] while it is below 2¹⁶ m², as on every grid up to a radius of 125 mm and on 1.6 million elements of the widest pot, so that
    /// it does not depend on what was summed up before.
    pub(super) const fn square_sums_m2(&self) -> [f64; 2] {
        [self.ledger.first_sum_m2, self.ledger.sum_m2]
    }

    /// Height when it was untouched, m.
    pub(super) const fn first_height_m(&self) -> f32 {
        self.ledger.first_height_m
    }

    /// Makes it so high, m.
    pub(super) const fn set_height(&mut self, height_m: f32) {
        self.height_m = height_m;
    }

    /// Radii above one another, to be changed to what its bounds allow.
    #[inline(always)]
    pub(super) fn run_mut(&mut self, column: u32, first_row: u32, rows: usize) -> &mut [f32] {
        let start = column as usize * self.shape.rows() as usize + first_row as usize;
        &mut self.radii_m[start..][..rows]
    }

    /// Takes in that elements have become so narrow and so wide, m.
    pub(super) const fn note_span(&mut self, narrowest_m: f32, widest_m: f32) {
        self.narrowest_m = self.narrowest_m.min(narrowest_m);
        self.widest_m = self.widest_m.max(widest_m);
    }

    /// Volume enclosed between the skin and the axis, m³.
    ///
    /// `V = Σ ½ r² Δθ Δz`, trapezoidal in z: exact for a cylinder.
    #[must_use]
    pub fn enclosed_volume_m3(&self) -> f64 {
        let area = f64::from(self.shape.column_angle_rad()) * f64::from(self.row_height_m());
        let rows = self.shape.rows() as usize;
        let mut sum = 0.0;
        for column in self.radii_m.chunks_exact(rows) {
            for &radius in column {
                sum += f64::from(radius) * f64::from(radius);
            }
            let (foot, rim) = (f64::from(column[0]), f64::from(column[rows - 1]));
            sum -= 0.5 * (foot * foot + rim * rim);
        }
        0.5 * sum * area
    }

    /// Volume that was pressed away between skin and axis since it was untouched, m³; negative when it was pressed out.
    ///
    /// `V₀ − V` at the first height.
    pub(super) fn pressed_m3(&self) -> f64 {
        let now = self.enclosed_volume_m3() / f64::from(self.height_m) * f64::from(self.ledger.first_height_m);
        let first_row_m = f64::from(self.ledger.first_height_m) / f64::from(self.shape.rows() - 1);
        0.5 * self.ledger.first_sum_m2 * f64::from(self.shape.column_angle_rad()) * first_row_m - now
    }

    /// Adds every radius, bit for bit, to a digest.
    pub fn digest_into(&self, digest: &mut Digest) {
        for radius in &self.radii_m {
            digest.add(radius.to_bits());
        }
    }
}

/// How much clay stands in each column, against which height makes up for what was pressed away.
#[derive(Clone, Debug)]
struct Ledger {
    /// Σ r² over a column, half at foot and rim, `[columns]`, m².
    columns_m2: Vec<f64>,
    /// Columns whose sum is not known any more.
    stale: Vec<bool>,
    sum_m2: f64,
    first_sum_m2: f64,
    first_height_m: f32,
}

impl Ledger {
    fn untouched(shape: GridShape, height_m: f32, radius_m: f32) -> Self {
        let column_m2 = f64::from(radius_m) * f64::from(radius_m) * f64::from(shape.rows() - 1);
        let sum_m2 = column_m2 * f64::from(shape.columns());
        let columns_m2 = alloc::vec![column_m2; shape.columns() as usize];
        let stale = alloc::vec![false; shape.columns() as usize];
        Self { columns_m2, stale, sum_m2, first_sum_m2: sum_m2, first_height_m: height_m }
    }

    fn copy_from(&mut self, other: &Self) {
        self.columns_m2.copy_from_slice(&other.columns_m2);
        self.stale.copy_from_slice(&other.stale);
        (self.sum_m2, self.first_sum_m2) = (other.sum_m2, other.first_sum_m2);
        self.first_height_m = other.first_height_m;
    }

    fn note(&mut self, column: u32, radii_m: &[f32]) {
        let square = |radius_m: f32| f64::from(radius_m) * f64::from(radius_m);
        // in lanes: an exact sum has no order
        let mut lanes = [0.0; 8];
        let mut eights = radii_m.chunks_exact(8);
        for eight in &mut eights {
            for (lane, &radius_m) in lanes.iter_mut().zip(eight) {
                *lane += square(radius_m);
            }
        }
        let rest: f64 = eights.remainder().iter().map(|&radius_m| square(radius_m)).sum();
        let all = lanes.iter().sum::<f64>() + rest;
        let ends = square(radii_m[0]) + square(radii_m[radii_m.len() - 1]);
        let now_m2 = all - 0.5 * ends;
        let before_m2 = core::mem::replace(&mut self.columns_m2[column as usize], now_m2);
        self.sum_m2 += now_m2 - before_m2;
    }

    /// Takes in that so much more stands in a column.
    #[inline(always)]
    fn add(&mut self, column: u32, more_m2: f64) {
        self.columns_m2[column as usize] += more_m2;
        self.sum_m2 += more_m2;
    }
}

/// Cosine and sine of every column's angle, so that no step asks for them.
pub(super) fn directions(columns: u32) -> Arc<[Vec2]> {
    let turn = |column: u32| f64::from(column) * (core::f64::consts::TAU / f64::from(columns));
    let direction = |column| {
        let (sin, cos) = libm::sincos(turn(column));
        Vec2::new(cos as f32, sin as f32)
    };
    (0..columns).map(direction).collect()
}
