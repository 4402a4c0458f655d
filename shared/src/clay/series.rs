//! Two springs in series: a wall that bends as a whole under a tool, and the clay that the tool then still meets.
//!
//! Owns the balance between the two; what the clay opposes and how the wall answers is told by who asks.
//! Invariant: the same question always takes the same steps to the same answer, and never more than [`LOOKS_MAX`] looks at the
//! contact.

use super::WallBending;
use super::contact::{Chunk, Column, Contacts};
use super::lanes::{Simd, SimdBase, SimdMask, f32x8, positive, splat};

/// Looks at the contact, at most.
pub(super) const LOOKS_MAX: u32 = 8;
/// Difference between what the wall bears and what is on it at which both are taken as one, as a share of it; it bounds the
/// error of the force.
const CLOSE: f32 = 1.0 / 400.0;
/// Smallest square of a contact's radius that is counted on before it is looked at, over the last one's.
const PATCH_MIN: f32 = 1e-3;

/// How far the wall gives way under a tool: `depth − bow·s²` at the distance s from it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GivenWay {
    /// m.
    pub(super) depth_m: f32,
    /// 1/m.
    bow_per_m: f32,
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
    /// What of the depth an elastic wall would not give way, m.
    pub(super) hinge_m: f32,
    /// Sixth power of how near the wall is to folding: see [`Hinge`].
    pub(super) folds: f32,
}

/// What a contact asks of the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked<'a> {
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
    pub(super) bending: &'a WallBending,
    /// Height of the contact's middle, and its radius, m.
    pub(super) z_m: f32,
    pub(super) patch_m: f32,
    /// When the wall yields.
    pub(super) hinge: Hinge,
    /// How far an elastic wall would give way to the force at which it folds, m, whatever the contact is.
    pub(super) fold_m: f32,
}

impl Asked<'_> {
    /// Depth that a load makes, 1/m.
    fn compliance_per_m(&self) -> f32 {
        self.bending.compliance(self.z_m, self.patch_m)
    }

    /// How far an elastic wall would give way, m.
    fn elastic_m(&self) -> f32 {
        self.load_m2 * self.compliance_per_m()
    }

    /// How far an elastic wall would give way to what gives this one way by a depth, m.
    fn borne_m(&self, depth_m: f32) -> f32 {
        let compliance_per_m = self.compliance_per_m();
        self.hinge.load_m2(depth_m / compliance_per_m) * compliance_per_m
    }

    /// The wall that gives way by a depth under a contact that is left so many times as deep as this one: its radius, by which the wall
    /// bows, has to go with it, or a look would be at another wall than the next.
    fn given(&self, depth_m: f32, deeper: f32) -> GivenWay {
        // as a sphere's; a wider one is not counted on, since beside the foot the wall would not give way to it
        let patch_m = self.patch_m * libm::sqrtf(deeper.clamp(PATCH_MIN, 1.0));
        let compliance_per_m = self.bending.compliance(self.z_m, patch_m);
        let load_m2 = self.hinge.load_m2(depth_m / compliance_per_m);
        let hinge_m = (depth_m - load_m2 * compliance_per_m).max(0.0);
        // told by the depth alone, or one look at the contact would decide on what the next one meets
        let along = Hinge { fold_m2: self.fold_m, ..self.hinge };
        let folds = along.folds(along.load_m2(depth_m));
        GivenWay { depth_m, bow_per_m: load_m2 * self.bending.bow(patch_m), load_m2, hinge_m, folds }
    }
}

/// How a wall yields where it bends most: it gives way by `C·L·(1 + α·(L/P)⁶)` under the load L, with an elastic wall's compliance
/// C and the load P at which a plate folds (Ramberg and Osgood 1943 for the form).
#[derive(Clone, Copy, Debug)]
pub(super) struct Hinge {
    /// α.
    pub(super) share: f32,
    /// P, a force over Young's modulus, m².
    pub(super) fold_m2: f32,
}

impl Hinge {
    /// Newton's steps, from a start that is at most a tenth too high: what is left is below the rounding of `f32`.
    const STEPS: u32 = 4;

    /// `(L/P)⁶`.
    fn folds(&self, load_m2: f32) -> f32 {
        let square = (load_m2 / self.fold_m2) * (load_m2 / self.fold_m2);
        square * square * square
    }

    /// `α·(L/P)⁶`.
    fn softer(&self, load_m2: f32) -> f32 {
        self.share * self.folds(load_m2)
    }

    /// L for `L·(1 + α·(L/P)⁶)`, which is an elastic wall's load for the same depth, m².
    fn load_m2(&self, elastic_m2: f32) -> f32 {
        let softer = self.softer(elastic_m2);
        if softer < 1e-6 {
            return elastic_m2;
        }
        // without the one and without the other of the two summands there is more load than with both
        let mut load_m2 = if softer < 1.0 { elastic_m2 } else { elastic_m2 * libm::powf(softer, -1.0 / 7.0) };
        for _ in 0..Self::STEPS {
            let softer = self.softer(load_m2);
            load_m2 -= (load_m2 * (1.0 + softer) - elastic_m2) / (1.0 + 7.0 * softer);
        }
        load_m2
    }
}

impl GivenWay {
    /// What is left of a chunk's penetration, m.
    #[inline(always)]
    pub(super) fn rest<S: Simd>(&self, column: &Column, chunk: &Chunk, above: f32x8<S>) -> f32x8<S> {
        let simd = above.simd;
        let arc = chunk.radius_m.on(simd) * column.angle_rad;
        let given = splat(simd, self.depth_m) - (arc * arc + above * above) * self.bow_per_m;
        (chunk.penetration_m.on(simd) - given.max(splat(simd, 0.0))).max(splat(simd, 0.0))
    }

    /// Where wall and contact agree: the root of `g(w) = (C·L(w))^¾ − (C·F(p − w)/E)^¾`, with the penetration p, the radial force F and
    /// the load L under which the wall gives way by w, taken off every penetration.
    ///
    /// F falls with w and L rises, so that there is one root between 0 and p. F falls nearly as `(p − w)^(4/3)` and L rises evenly
    /// while the wall is elastic, so that g is nearly straight: regula falsi, the end that stays brought nearer as by Anderson and
    /// Björck (1973). `asked` tells F and C of the contact that is left, and nothing when none is.
    #[inline(always)]
    pub(super) fn settled<'a, S: Simd>(
        simd: S,
        contacts: &mut Contacts,
        asked: impl Fn(&Contacts, &Self) -> Option<Asked<'a>>,
    ) -> Self {
        let Some(mut asks) = asked(contacts, &Self::default()).filter(|asks| asks.load_m2 > 0.0) else {
            return Self::default();
        };
        if asks.elastic_m() <= 0.0 {
            // beside the foot, which does not give way
            return Self { load_m2: asks.load_m2, ..Self::default() };
        }
        let mut low = End { depth_m: 0.0, excess: -straight(asks.elastic_m()) };
        let mut high = End { depth_m: contacts.deepest_m, excess: straight(asks.borne_m(contacts.deepest_m)) };
        let mut depth_m = low.root_m(&high);
        let mut stayed = None;
        let deepest_m = contacts.deepest_m;
        let mut asked_at_m = 0.0;
        for _ in 1..LOOKS_MAX {
            let way = asks.given(depth_m, (deepest_m - depth_m) / (deepest_m - asked_at_m));
            let next = asked(contacts, &way);
            let asked_m = next.map_or(0.0, |next| next.elastic_m());
            if let Some(next) = next {
                (asks, asked_at_m) = (next, depth_m);
            }
            let borne_m = asks.borne_m(depth_m);
            if (borne_m - asked_m).abs() <= CLOSE * borne_m {
                break;
            }
            let end = End { depth_m, excess: straight(borne_m) - straight(asked_m) };
            if end.excess < 0.0 {
                if stayed == Some(Stayed::High) {
                    high.excess *= end.nearer(&low);
                }
                (low, stayed) = (end, Some(Stayed::High));
                // the wall gives way more than this
                contacts.keep(
                    #[inline(always)]
                    |column, chunk, above| positive(way.rest(column, chunk, above.on(simd))).any_true(),
                );
            } else {
                if stayed == Some(Stayed::Low) {
                    low.excess *= end.nearer(&high);
                }
                (high, stayed) = (end, Some(Stayed::Low));
            }
            depth_m = low.root_m(&high);
        }
        let way = asks.given(depth_m, (deepest_m - depth_m) / (deepest_m - asked_at_m));
        contacts.replace(
            simd,
            #[inline(always)]
            |column, chunk, above| way.rest(column, chunk, above),
        );
        way
    }
}

/// An end of the interval that holds the root: how far the wall gives way, m, and g there.
#[derive(Clone, Copy)]
struct End {
    depth_m: f32,
    excess: f32,
}

/// Which end was left where it was.
#[derive(Clone, Copy, PartialEq)]
enum Stayed {
    Low,
    High,
}

impl End {
    fn root_m(&self, high: &Self) -> f32 {
        self.depth_m - self.excess * (high.depth_m - self.depth_m) / (high.excess - self.excess)
    }

    /// Share of g to keep at the end that stays, after this one has taken the place of `before`.
    fn nearer(&self, before: &Self) -> f32 {
        let share = 1.0 - self.excess / before.excess;
        if share > 0.0 { share } else { 0.5 }
    }
}

/// `x^¾`.
fn straight(x: f32) -> f32 {
    let root = libm::sqrtf(x.max(0.0));
    root * libm::sqrtf(root)
}
