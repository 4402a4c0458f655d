//! The original Circular Sector Element Method (Lee, Han and Choi 2008): every touched element yields by itself.
//!
//! Owns the published force too, which the improved method shares. Kept as published, its faults included: no yield (a
//! still hand sinks without end), no volume returned, sharp edges, a force that jumps where the tool's centre crosses the wall.
//! Invariant: no element outside the contact moves.

use glam::Vec3;

use super::contact::{Chunk, Column, Contacts, turned};
use super::lanes::{
    Eight, LANES, Simd, SimdBase, SimdFloat, SimdMask, apart, f32x8, only, root, splat, sum, with_vectors,
};
use super::{Contact, Footprint, Method, Pot, Press, Surface};
use crate::tool::Side;

/// The original gives its constants for a pot of 50 units height; forces scale with penetration in those units.
const UNITS_PER_HEIGHT: f32 = 50.0;
/// Point-contact stiffness over all elements, N a unit: k_p = 504 / N with N the number of elements of the model.
const POINT_STIFFNESS: f32 = 504.0;
/// Line-contact stiffness, N a unit of the largest penetration.
const LINE_STIFFNESS: f32 = 0.6;
/// Drag of the turning clay, N a unit of the largest penetration.
const ROTATION_STIFFNESS: f32 = 0.35;

/// The original CSEM: `r ← r − (r − s₁)·(1 − exp(−dt/τ))`, from inside `r ← r + (s₂ − r)·(1 − exp(−dt/τ))`.
///
/// Point contact (d > r): `F = Σ k_p·p·unit(H − P₁)`. Line contact (d ≤ r): `F = 0.6·max(R − |H − (P₁ + P₂)/2|)` along
/// `Σ(2H − P₁ − P₂)`. Inside the pot P₂ stands for P₁ and `d < r` for `d > r`. A turning wheel adds `0.35·max p` along its
/// tangent.
///
/// Readings:
/// - the published `1/ν` a tick is the response of one tick of dt = 1 ms;
/// - which of the two contacts holds is decided element by element;
/// - the pot is the surface alone, without thickness, so that a tool inside presses the same elements; of a wall with two skins, those of the
///   one that it meets, and the other goes along;
/// - on which side a tool is, is its own affair ([`Side`]): it came over the rim or not;
/// - columns are sought within asin(R/d) instead of R/d, which leaves out grazed ones near the axis;
/// - a tool of facets has no middle from which a line could be seen: all its elements are in point contact, along the normal
///   of the facet;
/// - odd rows are not shifted by half an element, as in the later paper, where elements are evenly separated;
/// - the low-pass of 10 Hz on the force belongs to that system's loop and not to its clay.
#[derive(Clone, Copy, Debug, Default)]
pub struct OriginalCsem;

impl Method for OriginalCsem {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let surface = pot.met_from(press.side);
        touch(surface, press, (0, 0), footprint)
    }
}

/// Finds the touched elements, writes `∓response·p` for each and returns the force.
///
/// The footprint is laid over the touched window grown by `margin` columns and rows; empty when nothing is touched.
pub(super) fn touch(surface: &Surface, press: &Press, margin: (u32, u32), footprint: &mut Footprint) -> Contact {
    let vectors = footprint.scratch.vectors;
    with_vectors!(vectors, simd => touch_with(simd, surface, press, margin, footprint))
}

#[inline(always)]
fn touch_with<S: Simd>(
    simd: S,
    surface: &Surface,
    press: &Press,
    margin: (u32, u32),
    footprint: &mut Footprint,
) -> Contact {
    let mut contacts = core::mem::take(&mut footprint.scratch.contacts);
    let cutter = footprint.scratch.cutter.as_deref_mut();
    apart(
        simd,
        #[inline(always)]
        || contacts.gather::<S, false>(simd, surface, press, 0.0, cutter),
    );
    let window = if contacts.elements == 0 { super::Window::default() } else { contacts.window };
    let shape = surface.shape();
    footprint.reset(window.grown(shape, margin.0, margin.1).aligned(shape.rows(), LANES as u32));
    let mut sums = Sums::new(simd);
    let zero = splat(simd, 0.0);
    let response = match press.side {
        Side::Outside => -press.response,
        Side::Inside => press.response,
    };
    for stretch in contacts.stretches() {
        let column = stretch.column;
        footprint.write(simd, shape, &stretch, response);
        for (number, (chunk, above)) in stretch.iter().enumerate() {
            if let Some(facing) = stretch.facing.get(number) {
                sums.add_facing(column, chunk, facing);
                continue;
            }
            let (depth_m, radius_m, above) = (chunk.penetration_m.on(simd), chunk.radius_m.on(simd), above.on(simd));
            let touched = chunk.touched(simd);
            let distance = splat(simd, contacts.distance_m);
            let (point, met_m) = match press.side {
                Side::Outside => (radius_m.simd_lt(distance) & touched, radius_m - depth_m),
                Side::Inside => (radius_m.simd_gt(distance) & touched, radius_m + depth_m),
            };
            let line = touched & !point;
            let weight = only(point, depth_m);
            let outwards = splat(simd, column.along_m) - met_m;
            sums.add(Kind::Point, column, above, weight * outwards, weight);
            if line.any_true() {
                sums.add(Kind::Line, column, above, zero, only(line, splat(simd, 1.0)));
                let away = (above * above + column.aside_m * column.aside_m).sqrt();
                let depth = only(line, splat(simd, contacts.tool_m) - away);
                sums.line_deepest = depth.to_array().into_iter().fold(sums.line_deepest, f32::max);
            }
        }
    }
    let contact = if contacts.elements == 0 { Contact::default() } else { sums.contact(surface, press, &contacts) };
    footprint.scratch.contacts = contacts;
    contact
}

/// Point or line contact.
#[derive(Clone, Copy)]
enum Kind {
    Point,
    Line,
}

/// What is gathered over the touched elements, in the pot's frame.
struct Sums<S: Simd> {
    /// `[point, line][x, y, z]`: m² of a sphere's points, m of its lines and of facets.
    directions: [[f32x8<S>; 3]; 2],
    line_deepest: f32,
}

impl<S: Simd> Sums<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self { directions: [[splat(simd, 0.0); 3]; 2], line_deepest: 0.0 }
    }

    /// Adds the ways from a chunk's elements to the tool's centre, weighted: `outwards` along the ray is weighted already.
    #[inline(always)]
    fn add(&mut self, kind: Kind, column: &Column, above: f32x8<S>, outwards: f32x8<S>, weight: f32x8<S>) {
        let [x, y, z] = &mut self.directions[kind as usize];
        let aside = weight * column.aside_m;
        *x += outwards * column.cos - aside * column.sin;
        *y += outwards * column.sin + aside * column.cos;
        *z -= weight * above;
    }

    /// Adds the way that each facet faces, weighted by its depth.
    #[inline(always)]
    fn add_facing(&mut self, column: &Column, chunk: &Chunk, facing: &[Eight; 3]) {
        let simd = self.directions[0][0].simd;
        let depth_m = chunk.penetration_m.on(simd);
        let [outwards, aside, up] = facing;
        let (outwards, aside, up) = (outwards.on(simd) * depth_m, aside.on(simd) * depth_m, up.on(simd) * depth_m);
        let [x, y, z] = &mut self.directions[Kind::Point as usize];
        *x += outwards * column.cos - aside * column.sin;
        *y += outwards * column.sin + aside * column.cos;
        *z += up;
    }

    #[inline(always)]
    fn contact(&self, surface: &Surface, press: &Press, contacts: &Contacts) -> Contact {
        let &Contacts { deepest_m, angle_rad, elements, tool_m, .. } = contacts;
        // what a facet faces is one long already
        let size = if contacts.is_faceted() { 1.0 } else { tool_m };
        let units = UNITS_PER_HEIGHT / surface.height_m();
        let [point, line] = self.directions.map(|axes| Vec3::from_array(axes.map(sum)));
        let point = point / size * (POINT_STIFFNESS * units / surface.shape().elements() as f32);
        let shorter = 1.0 / root(line.length_squared());
        let line = if shorter.is_finite() { line * shorter } else { Vec3::ZERO };
        let line = line * (LINE_STIFFNESS * units * self.line_deepest);
        let drag = ROTATION_STIFFNESS * units * deepest_m * f32::from(press.turning);
        Contact {
            force_n: point + line + turned(Vec3::new(0.0, drag, 0.0), angle_rad),
            elements,
            penetration_m: deepest_m,
            held_n: 0.0,
            sink: None,
        }
    }
}
