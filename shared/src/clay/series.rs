//! Two springs in series: a wall that bends as a whole under a tool, and the clay that the tool then still meets.
//!
//! Owns the balance between the two; what the clay opposes and how the wall answers is told by who asks.
//! Invariant: the same question always takes the same steps to the same answer, and never more than [`LOOKS_MAX`] looks at the
//! contact.

use super::contact::{Chunk, Column, Contacts};
use super::lanes::{Simd, SimdBase, SimdMask, f32x8, positive, splat};

/// Looks at the contact, at most.
pub(super) const LOOKS_MAX: u32 = 8;
/// Difference between what the wall gives way and what the force would have it do at which both are taken as one, as a share
/// of it; it bounds the error of the force.
const CLOSE: f32 = 1.0 / 400.0;

/// How far the wall gives way under a tool: `depth − bow·s²` at the distance s from it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GivenWay {
    /// m.
    pub(super) depth_m: f32,
    /// 1/m.
    bow_per_m: f32,
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
}

/// What a contact asks of the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// Force on the wall over Young's modulus, m².
    pub(super) load_m2: f32,
    /// Depth and bow that a load makes, 1/m and 1/m³: see [`super::WallBending`].
    pub(super) compliance_per_m: f32,
    pub(super) bow_per_m3: f32,
}

impl Asked {
    fn depth_m(&self) -> f32 {
        self.load_m2 * self.compliance_per_m
    }

    fn given(&self, depth_m: f32) -> GivenWay {
        let load_m2 = depth_m / self.compliance_per_m;
        GivenWay { depth_m, bow_per_m: load_m2 * self.bow_per_m3, load_m2 }
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

    /// Where wall and contact agree: the root of `g(w) = w^¾ − (C·F(p − w)/E)^¾`, with the penetration p and the radial force F,
    /// taken off every penetration.
    ///
    /// F falls with w, so that there is one root between 0 and p, and nearly as `(p − w)^(4/3)`, so that g is nearly straight:
    /// regula falsi, the end that stays brought nearer as by Anderson and Björck (1973). `asked` tells F and C of the contact that
    /// is left, and nothing when none is.
    #[inline(always)]
    pub(super) fn settled<S: Simd>(
        simd: S,
        contacts: &mut Contacts,
        asked: impl Fn(&Contacts, &Self) -> Option<Asked>,
    ) -> Self {
        let Some(mut asks) = asked(contacts, &Self::default()).filter(|asks| asks.load_m2 > 0.0) else {
            return Self::default();
        };
        if asks.depth_m() <= 0.0 {
            // beside the foot, which does not give way
            return Self { load_m2: asks.load_m2, ..Self::default() };
        }
        let mut low = End { depth_m: 0.0, excess: -straight(asks.depth_m()) };
        let mut high = End { depth_m: contacts.deepest_m, excess: straight(contacts.deepest_m) };
        let mut depth_m = low.root_m(&high);
        let mut stayed = None;
        for _ in 1..LOOKS_MAX {
            let way = asks.given(depth_m);
            let next = asked(contacts, &way);
            let asked_m = next.map_or(0.0, |next| next.depth_m());
            asks = next.unwrap_or(asks);
            if (depth_m - asked_m).abs() <= CLOSE * depth_m {
                break;
            }
            let end = End { depth_m, excess: straight(depth_m) - straight(asked_m) };
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
        let way = asks.given(depth_m);
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
