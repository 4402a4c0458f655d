//! Collision of a sphere with the elements of a column.
//!
//! Owns the closed form of what is touched; which columns are looked at is `contact`'s.
//! Invariant: elements that the ray of their column does not meet the sphere on are not touched.

use super::contact::{Chunks, Column, Tally};
use super::lanes::{Eight, LANES, Simd, SimdBase, SimdFloat, f32x8, load, only, positive, splat};
use crate::tool::{STEEPEST, Side};

/// A sphere, and on which side of the clay it is.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) tool_m: f32,
    pub(super) side: Side,
    pub(super) behind_m: f32,
}

impl Ball {
    /// Keeps the chunks of a column that the sphere touches, if there are any.
    #[inline(always)]
    pub(super) fn find<S: Simd, const LEANS: bool>(
        &self,
        column: &Column,
        radii_m: &[f32],
        above_m: &[Eight],
        chunks: &mut Chunks,
        tally: &mut Tally<S>,
    ) -> Option<Column> {
        let &Self { tool_m, behind_m, .. } = self;
        let Column { along_m, aside_m, .. } = *column;
        let simd = tally.elements.simd;
        let along = splat(simd, along_m);
        let cap = Cap {
            square: splat(simd, tool_m * tool_m - aside_m * aside_m),
            aside: splat(simd, aside_m),
            steepest: splat(simd, 1.0 / (STEEPEST * tool_m)),
        };
        match self.side {
            Side::Outside if along_m < tool_m => cap.look::<LEANS>(
                column,
                radii_m,
                above_m,
                chunks,
                tally,
                #[inline(always)]
                |radius, half_chord| {
                    // the tool holds the axis, beyond which there is no clay of this ray
                    let there = positive(along + half_chord);
                    only(there, (half_chord - (along - radius)).min(radius))
                },
            ),
            Side::Outside => cap.look::<LEANS>(
                column,
                radii_m,
                above_m,
                chunks,
                tally,
                #[inline(always)]
                |radius, half_chord| half_chord - (along - radius),
            ),
            Side::Inside => cap.look::<LEANS>(
                column,
                radii_m,
                above_m,
                chunks,
                tally,
                #[inline(always)]
                |radius, half_chord| half_chord - (radius - behind_m - along),
            ),
        }
    }
}

/// A sphere as the ray of a column sees it.
struct Cap<S: Simd> {
    /// Square of half the ray's length in the sphere at its middle's height, m².
    square: f32x8<S>,
    /// Its middle's distance across the ray, m.
    aside: f32x8<S>,
    /// One over the least half chord by which its slope is told, 1/m.
    steepest: f32x8<S>,
}

impl<S: Simd> Cap<S> {
    /// Looks at a column: `meets` tells penetrations of radii and half chords, m, where the ray is in the sphere.
    #[inline(always)]
    fn look<const LEANS: bool>(
        &self,
        column: &Column,
        radii_m: &[f32],
        above_m: &[Eight],
        chunks: &mut Chunks,
        tally: &mut Tally<S>,
        meets: impl Fn(f32x8<S>, f32x8<S>) -> f32x8<S>,
    ) -> Option<Column> {
        let simd = tally.elements.simd;
        let zero = splat(simd, 0.0);
        let (whole, last) = radii_m.as_chunks::<LANES>();
        chunks.keep(
            column,
            #[inline(always)]
            |number, chunk| {
                let radius_m = match whole.get(number) {
                    Some(lanes) => f32x8::load_array_ref(simd, lanes),
                    None => load(simd, last),
                };
                let above = above_m[number].on(simd);
                let square = self.square - above * above;
                let half_chord = square.max(zero).sqrt();
                let penetration_m = only(positive(square), meets(radius_m, half_chord)).max(zero);
                (chunk.penetration_m, chunk.radius_m) = (penetration_m.into(), radius_m.into());
                if LEANS {
                    let steep = (splat(simd, 1.0) / half_chord).min(self.steepest);
                    (chunk.aside, chunk.up) = ((self.aside * steep).into(), (above * steep).into());
                }
                penetration_m
            },
            tally,
        )
    }
}
