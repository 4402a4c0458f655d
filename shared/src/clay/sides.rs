//! The two sides of a contact: what a sum over columns leaves out there.
//!
//! Knows no clay: whatever columns bear, and how steeply that begins at an edge.
//! Invariant: a contact of three columns or fewer, one of columns that are looked at in parts and one whose pressure rises slowly are taken as their sums.

use super::lanes::{Simd, f32x8, splat, sum};
use super::law::PlasticLaw;

/// Columns up to which nothing is said of what a sum leaves out, and by how many more all is.
const FEW: f32 = 3.0;
const FADES_IN: f32 = 2.0;
/// Columns over which pressure rises at an edge up to which a sum leaves anything out, and by how many more nothing: what rises slowly is summed as it
/// is.
const STEEP: f32 = 1.0;
const FADES_OUT: f32 = 1.0;
/// Part of the next column's that the outermost one bears from which on the contact is taken to end at once, as at the flank of a tool: wholly
/// where both bear as much.
const ENDS_AT_ONCE: f32 = 0.68;

/// What the first two and the last two columns of a contact bear.
///
/// A contact ends between two columns, and what a column bears goes to nothing there more steeply than a straight line, nearly as a root does: summed over columns it
/// is too large or too small by a share of the outer columns that goes by where between them the end lies (Navot 1961, "An extension of the
/// Euler-Maclaurin summation formula to functions with a branch singularity"). With q what the outermost column bears over what the next one
/// does, which says where, the sum leaves out of that next one's
/// `k₀ + (k₁ + k_w·w)·q + k₃·q³`,
/// where w is the width over which pressure rises at the edge, over that of a column. Eleven columns are off by 1.4 % at most without, and by 0.9 with it; see
/// `accuracy-chart fit`.
pub(super) struct Sides<S: Simd> {
    /// From outside to inside.
    first: [f32x8<S>; 2],
    last: [f32x8<S>; 2],
    columns: usize,
    are_whole: bool,
}

impl<S: Simd> Sides<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let none = [splat(simd, 0.0); 2];
        Self { first: none, last: none, columns: 0, are_whole: true }
    }

    /// Adds what the next column bears, of which so much is looked at.
    #[inline(always)]
    pub(super) fn add(&mut self, borne: f32x8<S>, share: f32) {
        if let Some(first) = self.first.get_mut(self.columns) {
            *first = borne;
        }
        self.last = [borne, self.last[0]];
        self.columns += 1;
        self.are_whole &= share >= 1.0;
    }

    /// What is borne over the sum of all columns, for the width over which pressure rises at the edge, in columns.
    #[inline(always)]
    pub(super) fn whole(&self, law: &PlasticLaw, all: f32, ramp: f32) -> f32 {
        let steep = (1.0 - (ramp - STEEP) / FADES_OUT).clamp(0.0, 1.0);
        let known = steep * ((self.columns as f32 - FEW) / FADES_IN).clamp(0.0, 1.0);
        if known == 0.0 || !self.are_whole || all <= 0.0 {
            return 1.0;
        }
        let left_out = |side: &[f32x8<S>; 2]| {
            let [outer, next] = side.map(sum);
            law.left_out_of_side(outer, next, ramp)
        };
        1.0 + known * (left_out(&self.first) + left_out(&self.last)) / all
    }
}

impl PlasticLaw {
    /// What a sum over columns leaves out where the outermost and the next bear so much.
    fn left_out_of_side(&self, outer: f32, next: f32, ramp: f32) -> f32 {
        if next <= outer {
            return 0.0;
        }
        let part = outer / next;
        let (near, ends) = (part.min(ENDS_AT_ONCE), (part - ENDS_AT_ONCE).max(0.0) / (1.0 - ENDS_AT_ONCE));
        let by_part = self.side_by_part + self.side_by_ramp * ramp.min(STEEP);
        next * (1.0 - ends) * (self.side_grazed + near * (by_part + self.side_by_cube * near * near))
    }
}
