//! How far a hollow wall has folded: what stays of its bending.
//!
//! Owns the grid on which that is remembered and what a fold does to both skins; when a wall folds, and how far, is `joint`'s.
//! Invariant: both skins go by the same, so that no fold makes a wall thinner; the foot does not move.

use glam::Vec3;

use super::contact::nearest_turn;
use super::lanes::{
    LANES, Select, Simd, SimdBase, SimdFloat, Vectors, counted, eight, f32x8, root, splat, with_vectors,
};
use super::plastic::outwards;
use super::uptake::Span;
use super::{GridShape, Pot, PotSpec, Press, Surface, Window};

/// Length within which a wall that has folded stays bent, over √(R·t): a cone that is as wide as what stays of the finite-element pot pressed
/// in by 4 mm.
const REACH: f32 = 1.2;

/// A wall that folds farther about a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fold {
    pub(super) angle_rad: f32,
    pub(super) z_m: f32,
    /// By so much, towards the axis, m.
    pub(super) inwards_m: f32,
}

impl Fold {
    /// What is left to fold so little is left as it is, m.
    const LEAST_M: f32 = 8.0 * Surface::STEP_M;

    /// That of a press from which the wall would fold away by so much more, m: as dents do, it takes its time.
    pub(super) fn of(press: &Press, away_m: f32) -> Option<Self> {
        let Vec3 { x, y, z: z_m } = press.centre_m;
        let inwards_m = outwards(press.side) * away_m * press.response;
        (away_m.abs() > Self::LEAST_M).then(|| Self { angle_rad: libm::atan2f(y, x), z_m, inwards_m })
    }
}

/// The memory of a wall that has never folded: a surface at the wall's outer radius.
pub(super) fn untouched(spec: &PotSpec, bounds_m: (f32, f32)) -> Surface {
    Surface::cylinder(GridShape::FOLDS, spec.height.0, even_m(spec), bounds_m, spec.wall.0, None)
}

/// Radius that stands for none, m: one that rounding leaves as it is.
fn even_m(spec: &PotSpec) -> f32 {
    libm::roundf(spec.radius.0 / Surface::STEP_M) * Surface::STEP_M
}

impl Pot {
    /// How far the wall has folded towards the axis at a place, an angle and a height, m, less than nothing where it has folded the other way. It is in
    /// the radii of both skins already.
    #[must_use]
    pub fn folded_m(&self, angle_rad: f32, z_m: f32) -> f32 {
        let [_, _, folds] = self.surfaces() else { return 0.0 };
        let shape = folds.shape();
        let around = angle_rad / shape.column_angle_rad();
        let column = libm::floorf(around);
        let last = shape.rows() - 1;
        let up = (z_m / folds.row_height_m()).clamp(0.0, last as f32);
        let row = (up as u32).min(last - 1) as usize;
        let [aside, above] = [around - column, up - row as f32];
        let [one, other] = [0, 1].map(|next| {
            let radii_m = folds.column_m(shape.wrap(column as i64 + next));
            radii_m[row] + (radii_m[row + 1] - radii_m[row]) * above
        });
        even_m(self.spec()) - (one + (other - one) * aside)
    }

    /// Folds the wall farther, and tells `touched` of every window that changed, with the number of its surface.
    pub(super) fn fold(&mut self, vectors: Vectors, fold: &Fold, mut touched: impl FnMut(usize, Window)) {
        let (even_m, PotSpec { radius, wall, .. }) = (even_m(self.spec()), *self.spec());
        let middle_m = radius.0 - 0.5 * wall.0;
        let reach_m = REACH * root(middle_m * wall.0);
        let [outer, inner, folds] = self.surfaces_mut() else { return };
        let sign = if fold.inwards_m < 0.0 { -1.0 } else { 1.0 };
        with_vectors!(vectors, simd => {
            let cone = Cone { simd, fold, middle_m, reach_m };
            let none = splat(simd, 0.0);
            let bounds = [outer.bounds_m(), inner.bounds_m()].map(|(low_m, high_m)| [splat(simd, low_m), splat(simd, high_m)]);
            let skins = cone.lay([outer, inner], #[inline(always)] |[outer, inner], inwards| {
                let [[outer_low, outer_high], [inner_low, inner_high]] = bounds;
                let least = (outer_low - outer).max(inner_low - inner).min(none);
                let most = (outer_high - outer).min(inner_high - inner).max(none);
                let moved = (none - inwards).max(least).min(most);
                [outer + moved, inner + moved]
            });
            (0..2).for_each(|number| touched(number, skins));
            let (even, (low_m, high_m)) = (splat(simd, even_m), folds.bounds_m());
            // what was folded the other way is forgotten
            touched(2, cone.lay([folds], #[inline(always)] |[radius], inwards| {
                let known = ((even - radius) * sign).max(none) * sign;
                let folded = (even - (known + inwards)).max(splat(simd, low_m)).min(splat(simd, high_m));
                [inwards.simd_eq(none).select(radius, folded)]
            }));
        });
    }
}

/// What a fold is on a grid.
struct Cone<'a, S: Simd> {
    simd: S,
    fold: &'a Fold,
    /// Radius of the wall's middle, m, and how far the fold reaches along it.
    middle_m: f32,
    reach_m: f32,
}

impl<S: Simd> Cone<'_, S> {
    /// How far eight rows from one on go towards the axis so far aside of its middle, m: the foot is held.
    #[inline(always)]
    fn inwards_m(&self, row: usize, row_m: f32, aside_m: f32) -> f32x8<S> {
        let (simd, per_m) = (self.simd, 1.0 / self.reach_m);
        let z = counted(simd, row as f32) * row_m;
        let up = z - self.fold.z_m;
        let share = (splat(simd, 1.0) - (up * up + aside_m * aside_m).sqrt() * per_m).max(splat(simd, 0.0));
        share * (z * per_m).min(splat(simd, 1.0)) * self.fold.inwards_m
    }

    /// Changes the radii of surfaces of one grid by how far they go towards the axis, m, within reach; the window that holds them.
    #[inline(always)]
    fn lay<const N: usize>(
        &self,
        mut surfaces: [&mut Surface; N],
        change: impl Fn([f32x8<S>; N], f32x8<S>) -> [f32x8<S>; N],
    ) -> Window {
        let Self { simd, fold, middle_m, reach_m } = *self;
        let (shape, row_m) = (surfaces[0].shape(), surfaces[0].row_height_m());
        let column_rad = shape.column_angle_rad();
        let row = |z_m: f32| libm::floorf(z_m / row_m) as i64;
        let half_columns = (reach_m / (middle_m * column_rad)) as u32 + 1;
        let middle = libm::roundf(fold.angle_rad / column_rad) as i64;
        let window = Window::around(shape, middle, half_columns, row(fold.z_m - reach_m), row(fold.z_m + reach_m) + 1);
        let mut spans = [Span::none(simd); N];
        for column in window.grid_columns(shape) {
            let aside_m = nearest_turn(column as f32 * column_rad - fold.angle_rad) * middle_m;
            // one more on both ends, since none may be left out by a hair, and whole eights, which are not copied to and fro
            let half_m = root((reach_m * reach_m - aside_m * aside_m).max(0.0));
            let last = i64::from(shape.rows());
            let [low, high] =
                [row(fold.z_m - half_m) - 1, row(fold.z_m + half_m) + 2].map(|row| row.clamp(0, last) as u32);
            let first_row = low / LANES as u32 * LANES as u32;
            let rows = (high.next_multiple_of(LANES as u32).min(shape.rows()) - first_row) as usize;
            let mut skins_m = surfaces.each_mut().map(|surface| surface.run_mut(column, first_row, rows));
            for at in (0..rows).step_by(LANES) {
                let radii_m = skins_m.each_ref().map(
                    #[inline(always)]
                    |skin_m| eight(simd, skin_m, at),
                );
                let changed_m = change(radii_m, self.inwards_m(first_row as usize + at, row_m, aside_m));
                for ((skin_m, changed_m), span) in skins_m.iter_mut().zip(changed_m).zip(&mut spans) {
                    span.put(skin_m, at, changed_m);
                }
            }
        }
        for (surface, span) in surfaces.into_iter().zip(spans) {
            span.note(surface);
        }
        window
    }
}
