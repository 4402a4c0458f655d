//! What a ray from the axis meets of a tool's facets, eight rows at once: how far out their planes lie, and how they face.
//!
//! Owns the planes' arithmetic; which facet is met in which row is `section.rs`'s to find.
//! Invariant: what is met depends on tool, pose, ray and facet alone, and is finite, or endlessly far from the side that is looked for.

use alloc::vec::Vec;

use glam::{Mat3, Vec3};

use super::{ConvexTool, STEEPEST, Sides};
use crate::lanes::{LANES, Simd, SimdBase, SimdFloat, columns, f32x8, splat};

/// Least part of a normal along the ray by which its plane's place there is told: what is flatter rises by less than 0.3 µm over the longest
/// tool, so that it is in a row by chance.
const FLATTEST: f32 = 1e-6;

/// Bits of a facet's normal, and of the distance of its plane from the tool's centre, m.
pub(super) type Plane = [u32; 4];

/// The planes of all facets, and after them that of none: it lies endlessly far from whatever side is looked for.
pub(super) fn planes(normals: &[Vec3], distances_m: impl Iterator<Item = f32>) -> Vec<Plane> {
    let planes = normals.iter().zip(distances_m).map(|(normal, distance_m)| normal.extend(distance_m));
    planes.chain([Vec3::ZERO.extend(f32::NEG_INFINITY)]).map(|plane| plane.to_array().map(f32::to_bits)).collect()
}

/// A tool in a pose, looked at along a ray from the axis.
pub(crate) struct Ray<'a> {
    planes: &'a [Plane],
    /// Directions in the tool's own coordinates: against the ray, against what lies across it, and down.
    axes: [Vec3; 3],
    /// The tool's centre along the ray and across it, towards rising angle, m.
    along_m: f32,
    across_m: f32,
    /// Which way the clay lies that the side presses, and how far from the centre anything of it is at most, m.
    outwards: f32,
    farthest_m: f32,
}

/// What is met in eight rows.
pub(crate) struct Met<S: Simd> {
    /// How far beyond the centre it lies, towards the clay that is pressed, m.
    pub(crate) beyond_m: f32x8<S>,
    /// Which way the clay pushes: against the normals, along the ray, across it and up.
    pub(crate) facing: [f32x8<S>; 3],
    /// One over the first of these, as far as [`STEEPEST`] allows.
    pub(crate) steep: f32x8<S>,
}

impl<'a> Ray<'a> {
    /// A ray in a direction from the axis. What is met of a side lies nowhere beyond the bound, m from the axis.
    pub(crate) fn new(
        tool: &'a ConvexTool,
        turn: &Mat3,
        centre_m: Vec3,
        [cos, sin]: [f32; 2],
        (sides, bound_m): (Sides, f32),
    ) -> Self {
        let turned = [turn.x_axis, turn.y_axis, turn.z_axis];
        let [against, across] = [(-cos, -sin), (sin, -cos)].map(|(x, y)| turned.map(|axis| axis.x * x + axis.y * y));
        let axes = [against, across, turned.map(|axis| -axis.z)].map(Vec3::from_array);
        let (along_m, across_m) = (centre_m.x * cos + centre_m.y * sin, centre_m.y * cos - centre_m.x * sin);
        let outwards = if sides == Sides::Far { -1.0 } else { 1.0 };
        Self { planes: tool.planes(), axes, along_m, across_m, outwards, farthest_m: (along_m - bound_m) * outwards }
    }

    /// The tool's centre along the ray and across it, m.
    pub(crate) const fn centre_m(&self) -> [f32; 2] {
        [self.along_m, self.across_m]
    }

    /// One towards the clay outside of the pot, minus one inside.
    pub(crate) const fn outwards(&self) -> f32 {
        self.outwards
    }

    /// Radius of what lies so far beyond the centre, m.
    #[inline(always)]
    pub(super) fn radius_m<S: Simd>(&self, beyond_m: f32x8<S>) -> f32x8<S> {
        splat(beyond_m.simd, self.along_m) - beyond_m * self.outwards
    }

    /// Which way the clay pushes in rows where facets are met: against their normals, along the ray, across it and up; and how far their planes
    /// are from the centre, m.
    #[inline(always)]
    pub(crate) fn facing<S: Simd>(&self, simd: S, facets: &[u16; LANES]) -> ([f32x8<S>; 3], f32x8<S>) {
        // one way for one facet and for many: whether eight rows have one alone is hard to foresee
        let [x, y, z, distance] = columns(
            simd,
            #[inline(always)]
            |lane| self.planes[usize::from(facets[lane])],
        );
        let [x, y, z] = [f32x8::from_bits(x), f32x8::from_bits(y), f32x8::from_bits(z)];
        // written out: mapped, it would be a function of its own
        let [ray, across, up] = self.axes;
        let facing = [
            x * ray.x + y * ray.y + z * ray.z,
            x * across.x + y * across.y + z * across.z,
            x * up.x + y * up.y + z * up.z,
        ];
        (facing, f32x8::from_bits(distance))
    }

    /// What is met of facets at heights above the tool's centre, m.
    ///
    /// With a facet's plane `n·(x − c) = d`, the ray's direction e, t across it and a height h above the centre c, it is met at the radius
    /// `r = c·e − (d + (n·t)(c·t) − (n·z)h)/(−n·e)`.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, facets: &[u16; LANES], above_m: f32x8<S>) -> Met<S> {
        let (facing, distance_m) = self.facing(simd, facets);
        let [along, across, up] = facing;
        let share = splat(simd, 1.0) / along.abs().max(splat(simd, FLATTEST));
        let beyond_m = (distance_m - across * self.across_m + up * above_m) * share;
        let steep = share.min(splat(simd, 1.0 / STEEPEST));
        Met { beyond_m: beyond_m.min(splat(simd, self.farthest_m)), facing, steep }
    }
}
