//! How a wall that bends gives way under a tool, and what of the tool is left in the clay.
//!
//! Owns the shape in which it gives way and the law by which it yields; the balance of tools and wall is `joint`'s.
//! Invariant: no depth that is left is more than was found, and a wall gives way by less than nothing only where others push it against the tool.

use super::contact::Column;
use super::lanes::{Simd, SimdBase, f32x8, splat};

/// How far the wall gives way under a tool: `depth − min(bow·s², most)` at the distance s from it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GivenWay {
    /// m.
    pub(super) depth_m: f32,
    /// 1/m.
    pub(super) bow_per_m: f32,
    /// m.
    pub(super) bow_most_m: f32,
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
    /// By how much more it gives way there than a wall as thick as it was made.
    pub(super) softer: f32,
    /// What of the depth an elastic wall would not give way, m.
    pub(super) hinge_m: f32,
    /// Share of its load that tools on the other side take up, over half of the wall's thickness, 1/m: clay between two tools is as on a core
    /// that lies in the middle of the wall.
    pub(super) layer_per_m: f32,
    /// Fifth power of how near the wall is to folding: see [`Hinge`].
    pub(super) folds: f32,
    /// Whether it folds away from the tool, and not against it.
    pub(super) folds_away: bool,
    /// By how much more it would stay folded away from the tool than it is, m: the tool's share of it; less than nothing against it.
    pub(super) folds_by_m: f32,
}

/// How a wall has given way under one tool among others, and by how much less than it the contacts were found, m: less than nothing
/// where others push it against the tool.
#[derive(Clone, Copy, Debug)]
pub(super) struct Braced {
    pub(super) found_m: f32,
    pub(super) way: GivenWay,
    /// Whether it touched in any look at it: what the others met then follows from it as well.
    pub(super) touched: bool,
}

/// What is seen of a tool at a wall that has given way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
    /// How deep the tool would be if the wall had not given way, m; less than nothing where others push the wall against it.
    pub(super) deepest_m: f32,
    /// Where the contact is, rad and m, and its radius, m.
    pub(super) angle_rad: f32,
    pub(super) z_m: f32,
    pub(super) patch_m: f32,
    /// How far the load is from one side, from nothing to 1.
    pub(super) one_sided: f32,
    /// By how much larger the load is under which the wall folds than under a point.
    pub(super) wider: f32,
    /// When the wall yields, under a point.
    pub(super) hinge: Hinge,
    /// How far an elastic wall would give way to the force at which it folds, m, whatever the contact is.
    pub(super) fold_m: f32,
}

/// How a wall yields where it bends most: it gives way by `C·L·(1 + α·(L/P)⁵)` under the load L, with an elastic wall's compliance
/// C and the load P at which a plate folds (Ramberg and Osgood 1943 for the form).
#[derive(Clone, Copy, Debug)]
pub(super) struct Hinge {
    /// α.
    pub(super) share: f32,
    /// P, a force over Young's modulus, m².
    pub(super) fold_m2: f32,
    /// Share of what it gives way more than an elastic wall by that stays.
    pub(super) stays: f64,
}

impl Default for Hinge {
    /// A wall that never yields.
    fn default() -> Self {
        Self { share: 0.0, fold_m2: 1.0, stays: 0.0 }
    }
}

impl Hinge {
    /// Newton's steps, from a start that is at most a sixth too high: what is left is below the rounding of `f32`.
    const STEPS: u32 = 4;
    /// Farthest beyond folding, so that its fifth power is finite on the way to a balance.
    const OVER_MAX: f32 = 1e6;

    /// `(L/P)⁵`.
    fn folds(&self, load_m2: f32) -> f32 {
        fifth((load_m2 / self.fold_m2).clamp(-Self::OVER_MAX, Self::OVER_MAX))
    }

    /// The same for what gives way by so much in all, as an elastic wall's load: `L·(1 + α·(L/P)⁵)`.
    pub(super) fn folds_at(&self, elastic_m2: f32) -> f32 {
        self.folds(self.load_m2(elastic_m2.abs()))
    }

    /// `α·(L/P)⁵`.
    pub(super) fn softer(&self, load_m2: f32) -> f32 {
        self.share * self.folds(load_m2)
    }

    /// L for `L·(1 + α·(L/P)⁵)`, which is an elastic wall's load for the same depth, m².
    pub(super) fn load_m2(&self, elastic_m2: f32) -> f32 {
        let elastic = (elastic_m2 / self.fold_m2).clamp(-Self::OVER_MAX, Self::OVER_MAX);
        let softer = self.share * fifth(elastic);
        if softer < 1e-6 {
            return elastic_m2;
        }
        // where either summand is by far the larger that is it, and in between too much by a sixth
        let mut over = elastic / sixth_root(1.0 + softer);
        for _ in 0..Self::STEPS {
            let softer = self.share * fifth(over);
            over -= (over * (1.0 + softer) - elastic) / (1.0 + 6.0 * softer);
        }
        over * self.fold_m2
    }
}

fn fifth(number: f32) -> f32 {
    let square = number * number;
    square * square * number.abs()
}

/// The sixth root of a number from 1 on, or up to 6 % more: that a number's bits are its logarithm, nearly, is enough to begin with.
const fn sixth_root(number: f32) -> f32 {
    let one = 1.0_f32.to_bits();
    f32::from_bits(one + (number.to_bits() - one) / 6)
}

impl Braced {
    /// Where contacts are best found for a wall that has given way so: a wall that others push against the tool may come nearer, and of a wide tool's
    /// depth up to twice as much may be left as it first seems, and half of that more where the wall bows.
    pub(super) fn found_for(way: &GivenWay) -> f32 {
        if way.depth_m < 0.0 { 1.25 * way.depth_m } else { (way.depth_m - 5.0 * way.bow_most_m).max(0.0) }
    }

    /// Whether contacts are to be found anew for a wall that has given way so.
    pub(super) fn is_beyond(&self, way: &GivenWay) -> bool {
        // a bow that is larger than the depth leaves off where the wall was
        let nearest_m = if self.found_m > 0.0 { way.least_m() } else { way.depth_m };
        nearest_m < self.found_m
    }

    /// How much farther the wall has given way than where the contacts were found.
    pub(super) fn way(&self) -> GivenWay {
        GivenWay { depth_m: self.way.depth_m - self.found_m, ..self.way }
    }
}

impl GivenWay {
    /// No place gives way by less, m.
    pub(super) fn least_m(&self) -> f32 {
        self.depth_m - self.bow_most_m
    }

    /// What is left of penetrations, m, in a column at radii and heights above the tool's centre, m.
    #[inline(always)]
    pub(super) fn rest<S: Simd>(
        &self,
        column: &Column,
        [radius, above]: [f32x8<S>; 2],
        penetration_m: f32x8<S>,
    ) -> f32x8<S> {
        let simd = above.simd;
        let arc = radius * column.angle_rad;
        let bow = ((arc * arc + above * above) * self.bow_per_m).min(splat(simd, self.bow_most_m));
        let given = splat(simd, self.depth_m) - bow;
        (penetration_m - given.max(splat(simd, 0.0))).max(splat(simd, 0.0))
    }
}
