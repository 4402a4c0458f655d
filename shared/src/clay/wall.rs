//! A wall with a skin on either side: how it goes with a tool, and how two tools squeeze it thinner.
//!
//! Owns what becomes of both skins under pushes on either, and how thick a wall is about a place; what pushes it and how it bends are others' affair.
//! Invariant: no wall is squeezed thinner than the thinnest that a pot may have, and the inner skin stays off the axis.

use core::f32::consts::TAU;

use super::lanes::{LANES, Simd, SimdBase, eight, f32x8, numbers, root, splat};
use super::uptake::Span;
use super::{Footprint, Pot, PotSpec, Surface};
use crate::tool::Side;

/// Both skins of a wall.
///
/// A skin moves by what tools on its own side push, and by a share of what those on the other side do: as far as the wall folds under
/// their load ([`Footprint::follows`]). Where the wall would become thinner than the thinnest there is, who does not push gives way.
/// Clay that is squeezed away is not gone: it makes the pot higher, which is how potters pull a wall up.
pub(super) struct Wall<'a> {
    pub(super) outer: &'a mut Surface,
    pub(super) inner: &'a mut Surface,
}

/// The strongest pushes on both skins, inwards and outwards, of eight elements, m.
#[derive(Clone, Copy)]
struct Pushes<S: Simd> {
    outer_m: [f32x8<S>; 2],
    inner_m: [f32x8<S>; 2],
}

/// What holds for every element, m, and how narrow and wide either skin becomes.
struct Limits<S: Simd> {
    outer_m: [f32x8<S>; 2],
    inner_m: [f32x8<S>; 2],
    thinnest_m: f32x8<S>,
    spans: [Span<S>; 2],
}

impl<S: Simd> Limits<S> {
    #[inline(always)]
    fn of(simd: S, wall: &Wall<'_>) -> Self {
        let bounds = |surface: &Surface| {
            let (low_m, high_m) = surface.bounds_m();
            [splat(simd, low_m), splat(simd, high_m)]
        };
        Self {
            outer_m: bounds(wall.outer),
            inner_m: bounds(wall.inner),
            thinnest_m: splat(simd, PotSpec::WALL_MIN.0),
            spans: [Span::none(simd); 2],
        }
    }

    /// Tells the skins how narrow and wide they have become.
    #[inline(always)]
    fn note(&self, wall: &mut Wall<'_>) {
        self.spans[0].note(wall.outer);
        self.spans[1].note(wall.inner);
    }

    /// Where skins go.
    #[inline(always)]
    fn moved(&self, [outer_m, inner_m]: [f32x8<S>; 2], pushes: &Pushes<S>) -> [f32x8<S>; 2] {
        let ([into_m, up_m], [back_m, out_m]) = (pushes.outer_m, pushes.inner_m);
        let thinnest_m = (outer_m - inner_m).min(self.thinnest_m);
        let (to_outer_m, to_inner_m) = (outer_m + (into_m + up_m), inner_m + (back_m + out_m));
        let lacks_m = (thinnest_m - (to_outer_m - to_inner_m)).max(splat(outer_m.simd, 0.0));
        // whose side pushes less gives way by more
        let outer_share = out_m / (out_m - into_m).max(splat(outer_m.simd, f32::MIN_POSITIVE));
        let outer_m = (to_outer_m + lacks_m * outer_share).max(self.outer_m[0]).min(self.outer_m[1]);
        let inner_m = to_inner_m.min(outer_m - thinnest_m).max(self.inner_m[0]).min(self.inner_m[1]);
        [outer_m, inner_m]
    }
}

impl Wall<'_> {
    /// Moves the elements that a footprint may displace by the strongest pushes, `[columns][rows]` of the whole grid, on the outer skin inwards and
    /// outwards and on the inner one, which are cleared.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, simd: S, footprint: &Footprint, pushes_m: [&mut [f32]; 4]) {
        let window = footprint.window();
        let shape = self.outer.shape();
        let mut limits = Limits::of(simd, self);
        let [into_m, up_m, back_m, out_m] = pushes_m;
        for (local, column) in (0..).zip(window.grid_columns(shape)) {
            let (span, deltas_m) = footprint.span(local);
            let first_row = window.first_row as usize + span.start;
            let start = column as usize * shape.rows() as usize + first_row;
            let rows = deltas_m.len();
            let pushes_m = [&mut *into_m, &mut *up_m, &mut *back_m, &mut *out_m];
            let pushes_m = pushes_m.map(|pushes_m| &mut pushes_m[start..start + rows]);
            {
                let [into_m, up_m, back_m, out_m] = pushes_m.each_ref();
                self.push_run(
                    &mut limits,
                    (column, first_row as u32, rows),
                    #[inline(always)]
                    |at| Pushes {
                        outer_m: [eight(simd, into_m, at), eight(simd, up_m, at)],
                        inner_m: [eight(simd, back_m, at), eight(simd, out_m, at)],
                    },
                );
            }
            pushes_m.into_iter().for_each(|pushes_m| pushes_m.fill(0.0));
        }
        limits.note(self);
    }

    /// Moves the elements of the only footprint there is.
    #[inline(always)]
    pub(super) fn push_alone<S: Simd>(&mut self, simd: S, footprint: &Footprint, side: Side) {
        let window = footprint.window();
        let mut limits = Limits::of(simd, self);
        let none = splat(simd, 0.0);
        let follows = splat(simd, footprint.follows);
        for (local, column) in (0..).zip(window.grid_columns(self.outer.shape())) {
            let (span, deltas_m) = footprint.span(local);
            self.push_run(
                &mut limits,
                (column, window.first_row + span.start as u32, deltas_m.len()),
                #[inline(always)]
                |at| {
                    let push_m = numbers(eight(simd, deltas_m, at));
                    let own_m = [push_m.min(none), push_m.max(none)];
                    let other_m = own_m.map(
                        #[inline(always)]
                        |push_m| push_m * follows,
                    );
                    match side {
                        Side::Outside => Pushes { outer_m: own_m, inner_m: other_m },
                        Side::Inside => Pushes { outer_m: other_m, inner_m: own_m },
                    }
                },
            );
        }
        limits.note(self);
    }

    /// Moves elements above one another, from a row of a column on so many; `pushes` tells of eight from one of them on.
    #[inline(always)]
    fn push_run<S: Simd>(
        &mut self,
        limits: &mut Limits<S>,
        (column, first_row, rows): (u32, u32, usize),
        pushes: impl Fn(usize) -> Pushes<S>,
    ) {
        let simd = limits.thinnest_m.simd;
        let outer_m = self.outer.run_mut(column, first_row, rows);
        let inner_m = self.inner.run_mut(column, first_row, rows);
        for at in (0..rows).step_by(LANES) {
            let skins_m = [eight(simd, outer_m, at), eight(simd, inner_m, at)];
            let skins_m = limits.moved(skins_m, &pushes(at));
            limits.spans[0].put(outer_m, at, skins_m[0]);
            limits.spans[1].put(inner_m, at, skins_m[1]);
        }
    }
}

/// Most rows that are looked at for the thickness about a place: on finer grids every second one, or fewer, tells.
const ROWS_MAX: u32 = 64;

impl Pot {
    /// How thick the wall is about a place, over how thick it was made; 1 on a core.
    ///
    /// The mean over `√(R·t)` up and down, the length within which a shell of radius R and thickness t bends under a load, with the weights
    /// `(1 − u²)²`, and over as much round the pot, with those of a cubic spline at columns half as far apart: so it changes evenly while a tool
    /// goes on. Never less than the thinnest wall.
    #[must_use]
    pub fn thickness_about(&self, angle_rad: f32, z_m: f32) -> f32 {
        let [outer, inner, ..] = self.surfaces() else { return 1.0 };
        let PotSpec { radius, wall, .. } = *self.spec();
        let reach_m = root(radius.0 * wall.0);
        let (shape, row_m) = (outer.shape(), outer.row_height_m());
        let last = (shape.rows() - 1) as f32;
        let [low, high] = [z_m - reach_m, z_m + reach_m].map(|end_m| (end_m / row_m).clamp(0.0, last));
        let (first, end) = (libm::ceilf(low) as u32, libm::floorf(high) as u32);
        // beyond foot or rim stands what ends there
        let (first, end) = (first.min(end), end.max(first));
        let step = ((end - first) / ROWS_MAX + 1) as usize;
        let columns = libm::roundf(TAU * radius.0 / (0.5 * reach_m)).max(4.0);
        let at = angle_rad / TAU * columns;
        let before = libm::floorf(at);
        let shares = cubic(at - before);
        let rows = first as usize..end as usize + 1;
        let skins_m = [-1, 0, 1, 2].map(|number| {
            let turn = (before + number as f32) / columns;
            let column = shape.wrap(libm::roundf(turn * shape.columns() as f32) as i64);
            [outer, inner].map(|surface| &surface.column_m(column)[rows.clone()])
        });
        let (mut sum, mut weights) = (0.0, 0.0);
        let (rows_per_reach, middle) = (row_m / reach_m, z_m / reach_m);
        for at in (0..rows.len()).step_by(step) {
            let away = (rows.start + at) as f32 * rows_per_reach - middle;
            let near = (1.0 - away * away).max(1e-3);
            let weight = near * near;
            let [one, two, three, four] = skins_m.each_ref().map(|[outer, inner]| outer[at] - inner[at]);
            sum += weight * ((shares[0] * one + shares[1] * two) + (shares[2] * three + shares[3] * four));
            weights += weight;
        }
        (sum / weights).max(PotSpec::WALL_MIN.0) / wall.0
    }
}

/// Weights of four places one apart for a point that is so far beyond the second.
fn cubic(share: f32) -> [f32; 4] {
    let rest = 1.0 - share;
    let middle = |near: f32| (4.0 - 6.0 * near * near + 3.0 * near * near * near) / 6.0;
    [rest * rest * rest / 6.0, middle(share), middle(rest), share * share * share / 6.0]
}
