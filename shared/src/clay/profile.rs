//! The studio's own law on a profile over height: what a tool does to clay that goes round under it many times.
//!
//! Owns the arithmetic of one part of a turn; who chooses the profile instead of the grid, and when, is `lathe`'s affair.
//! Invariant: a row out of the tool's and its rim's reach keeps its radius, bit for bit.

use alloc::vec::Vec;
use core::f32::consts::{PI, TAU};

use glam::Vec3;

use super::ellipse::{Ellipse, Step};
use super::lanes::{
    LANES, Select, Simd, SimdBase, SimdFloat, SimdMask, Vectors, counted, f32x8, only, positive, root, splat, sum,
    with_vectors,
};
use super::plastic::{Bed, Behind, Met, Slide, Spot};
use super::rim::{Rim, RimShape};
use super::{Contact, PlasticCsem, Strength, Support};
use crate::tool::STEEPEST;

/// Places round the pot at which an element is looked at while it passes the tool.
const NODES: usize = 12;
/// Nodes and weights of Gauss and Legendre on 0..1, for the rim.
const RIM_NODES: [(f32, f32); 5] = [
    (0.046_910_077, 0.118_463_44),
    (0.230_765_34, 0.239_314_34),
    (0.5, 0.284_444_45),
    (0.769_234_66, 0.239_314_34),
    (0.953_089_9, 0.118_463_44),
];
/// The same for the slope, whose weight is even.
const SLOPE_NODES: [(f32, f32); 3] = [(0.112_701_67, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_35, 5.0 / 18.0)];

/// Where a tool stands beside clay that goes round, and for how long.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    /// Radius of the sphere, its distance from the axis and its height, m.
    pub(super) radius_m: f32,
    pub(super) distance_m: f32,
    pub(super) z_m: f32,
    pub(super) strength: Strength,
    /// −ln(1 − share that yields) for each radian under the tool.
    pub(super) rate_per_rad: f32,
    /// How fast the clay goes round, rad/s.
    pub(super) speed_rad_s: f32,
    /// Turns that it lasts.
    pub(super) turns: f32,
}

impl Pass {
    /// Depth of the tool in clay of a radius at an angle from it, m.
    #[inline(always)]
    fn depth_m<S: Simd>(&self, radius: f32x8<S>, angle: f32x8<S>, chord_m2: f32x8<S>) -> f32x8<S> {
        let zero = splat(radius.simd, 0.0);
        let aside = sine(angle) * self.distance_m;
        let chord2 = chord_m2 - aside * aside;
        let near_side = cosine(angle) * self.distance_m - chord2.max(zero).sqrt();
        only(positive(chord2), (radius - near_side).max(zero))
    }
}

/// One radius a row, and what a turn does to it.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    step: Step,
    thickness_m: f32,
    bounds_m: (f32, f32),
    /// Mean radius, m; rows beyond the rim are zero, so that no tool touches them.
    pub(super) radii_m: Vec<f32>,
    /// How much wider than that clay is right before it meets the tool, m.
    lead_m: Vec<f32>,
    /// How much it rises under the tool before it yields and after, m.
    inside_m: [Vec<f32>; 2],
    /// By how much it is pressed in when it passes, m.
    pressed_m: Vec<f32>,
    /// By how much it is narrower after a turn, m: a thread whose step stands at the tool.
    pub(super) fall_m: Vec<f32>,
    /// Angles before and behind the tool at which contact begins and ends, rad.
    before_rad: Vec<f32>,
    behind_rad: Vec<f32>,
    /// Rows for which all but the radii may be other than zero.
    alive: (usize, usize),
    vectors: Vectors,
}

/// Rows of one pass.
#[derive(Clone, Copy)]
struct Rows {
    first: usize,
    end: usize,
    row_m: f32,
    z_m: f32,
    radius_m: f32,
}

impl Rows {
    /// Where they begin, eight by eight.
    fn eights(&self) -> impl Iterator<Item = usize> + use<> {
        (self.first..self.end).step_by(LANES)
    }

    /// Heights of eight rows above the tool, m, and half the tool's chord there squared, m².
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, at: usize) -> (f32x8<S>, f32x8<S>) {
        let above_m = counted(simd, at as f32) * self.row_m - self.z_m;
        (above_m, splat(simd, self.radius_m * self.radius_m) - above_m * above_m)
    }
}

impl Profile {
    pub(super) fn new(rows: usize, step: Step, thickness_m: f32, bounds_m: (f32, f32)) -> Self {
        let zeros = || alloc::vec![0.0; rows.next_multiple_of(LANES)];
        Self {
            step,
            thickness_m,
            bounds_m,
            radii_m: zeros(),
            lead_m: zeros(),
            inside_m: [zeros(), zeros()],
            pressed_m: zeros(),
            fall_m: zeros(),
            before_rad: zeros(),
            behind_rad: zeros(),
            alive: (0, 0),
            vectors: Vectors::default(),
        }
    }

    /// Forgets how clay moved before; the radii stay.
    pub(super) fn rest(&mut self) {
        self.rest_rows(self.alive.0, self.alive.1);
        self.alive = (0, 0);
    }

    /// Takes rows over as they are on the grid: their mean radius, and the thread in which they are cut.
    pub(super) fn take(&mut self, row: usize, radius_m: f32, fall_m: f32) {
        self.radii_m[row] = radius_m;
        self.fall_m[row] = fall_m;
        self.pressed_m[row] = fall_m;
        self.lead_m[row] = 0.5 * fall_m;
        self.alive = if self.alive.0 == self.alive.1 {
            (row, row + 1)
        } else {
            (self.alive.0.min(row), self.alive.1.max(row + 1))
        };
    }

    fn rest_rows(&mut self, from: usize, to: usize) {
        if from < to {
            let [before, behind] = &mut self.inside_m;
            for rows in [before, behind, &mut self.lead_m, &mut self.pressed_m, &mut self.fall_m] {
                rows[from..to].fill(0.0);
            }
            for rows in [&mut self.before_rad, &mut self.behind_rad] {
                rows[from..to].fill(0.0);
            }
        }
    }

    /// Rows that a pass can move: those of the tool, and of a rim twice as high as the contact.
    pub(super) fn reach(&self, radius_m: f32, z_m: f32) -> (usize, usize) {
        let row = |z_m: f32| (z_m / self.step.row_m).max(0.0) as usize;
        let reach_m = 2.0 * radius_m + self.step.row_m;
        let end = (row(z_m + reach_m) + 2).next_multiple_of(LANES).min(self.radii_m.len());
        ((row(z_m - reach_m) / LANES * LANES).min(end), end)
    }

    /// Half of the angle in which the tool touches a row, rad.
    pub(super) fn half_contact_rad(&self, row: usize) -> f32 {
        0.5 * (self.before_rad[row] + self.behind_rad[row])
    }

    /// Lets the clay pass a tool.
    ///
    /// With D what an element loses while it passes, u what it rises before and behind the tool, a row falls by `Δ = D − u`
    /// a turn. It meets the tool `Δ/2 + u_before` wider than its mean.
    pub(super) fn advance(&mut self, law: &PlasticCsem, pass: &Pass) -> Contact {
        with_vectors!(self.vectors, simd => self.advance_with(simd, law, pass))
    }

    #[inline(always)]
    fn advance_with<S: Simd>(&mut self, simd: S, law: &PlasticCsem, pass: &Pass) -> Contact {
        let (first, end) = self.reach(pass.radius_m, pass.z_m);
        let (alive_first, alive_end) = self.alive;
        self.rest_rows(alive_first, alive_end.min(first));
        self.rest_rows(alive_first.max(end), alive_end);
        self.alive = (first, end);
        let rows = Rows { first, end, row_m: self.step.row_m, z_m: pass.z_m, radius_m: pass.radius_m };
        let Some((ellipse, slope)) = self.touch(simd, pass, rows) else {
            return Contact::default();
        };
        let share = Slide::share(pass.speed_rad_s * ellipse.radius_m);
        let slide = Slide { along: share, up: 0.0, share };
        let behind = Behind { support: Support::Backed, thickness_m: self.thickness_m, layer_per_m: 0.0, folds: 0.0 };
        let met = law.met(ellipse, slope, slide, pass.strength, behind);
        let Met { spot, pressure_pa, strain, around, rim_width, .. } = &met;
        let (mut carried, dent) = self.press(simd, pass, spot, rows);
        // clay heaps up before the tool
        carried.force.y += carried.force.y.min(0.0) * share * law.law.slide_heap;
        if let Some(dent) = dent.map(|dent| dent.within(&ellipse)) {
            let rising = law.law.rim_share(*strain, share, spot.open);
            let shape = RimShape::new(slide, *around, *rim_width);
            let rim = Rim { dent, volume_m3: rising * dent.content, shape, tool_z_m: pass.z_m };
            self.rise(simd, pass, spot, &rim, rows);
        } else {
            let [before, behind] = &mut self.inside_m;
            for rows in [before, behind, &mut self.lead_m, &mut self.fall_m] {
                rows[first..end].fill(0.0);
            }
        }
        self.settle(simd, pass, rows);
        Contact {
            force_n: carried.force * (pressure_pa * self.step.row_m),
            elements: (ellipse.content / (ellipse.radius_m * self.step.element_rad_m)) as u32,
            penetration_m: carried.deepest_m,
            held_n: 0.0,
            sink: None,
        }
    }

    /// Where the tool touches, as an ellipse whose arc is counted against the clay's turning, and its slope at the edge.
    #[inline(always)]
    fn touch<S: Simd>(&mut self, simd: S, pass: &Pass, rows: Rows) -> Option<(Ellipse, f32)> {
        let [mut all, mut radii, mut arcs, mut arcs2, mut aboves, mut aboves2, mut slopes] = [splat(simd, 0.0); 7];
        let steepest_m2 = splat(simd, STEEPEST * STEEPEST * pass.radius_m * pass.radius_m);
        for at in rows.eights() {
            let (above_m, chord_m2) = rows.at(simd, at);
            let lead = eight(simd, &self.radii_m, at) + eight(simd, &self.lead_m, at);
            let before = edge_rad(lead, chord_m2, pass.distance_m);
            put(&mut self.before_rad, at, before);
            if !positive(before).any_true() {
                put(&mut self.behind_rad, at, splat(simd, 0.0));
                continue;
            }
            let (rises, after) = (eight(simd, &self.inside_m[0], at), eight(simd, &self.inside_m[1], at));
            let trail = lead + rises + after - eight(simd, &self.pressed_m, at);
            let behind = only(positive(before), edge_rad(trail, chord_m2, pass.distance_m));
            put(&mut self.behind_rad, at, behind);
            let angle = before + behind;
            let radius = (lead + trail) * 0.5;
            let weight = angle * radius;
            let above = only(positive(before), above_m);
            all += weight;
            radii += weight * radius;
            arcs += (before - behind) * weight * radius * 0.5;
            arcs2 += (before * before - before * behind + behind * behind) * weight * radius * radius * (1.0 / 3.0);
            aboves += weight * above;
            aboves2 += weight * above * above;
            for (place, share) in SLOPE_NODES {
                let aside = sine(angle * place - behind) * pass.distance_m;
                let chord = (chord_m2 - aside * aside).max(steepest_m2);
                slopes += weight * (above * above + aside * aside) / chord * share;
            }
        }
        let ellipse = self.ellipse([all, radii, arcs, arcs2, aboves, aboves2], 4.0)?;
        Some((ellipse, root(2.0 * sum(slopes) * self.step.row_m / ellipse.content)))
    }

    /// The ellipse of weights and of their products with radius, arc, arc², height and height².
    #[inline(always)]
    fn ellipse<S: Simd>(&self, sums: [f32x8<S>; 6], spread: f32) -> Option<Ellipse> {
        let [all, radius, arc, arc2, above, above2] = sums.map(sum);
        if all <= 0.0 {
            return None;
        }
        let [radius, arc, arc2, above, above2] = [radius, arc, arc2, above, above2].map(|of| of / all);
        let (column_m, row_m) = (self.step.column_rad * radius, self.step.row_m);
        let half = |variance: f32, width2: f32| root(spread * (variance.max(0.0) + width2));
        Some(Ellipse {
            content: all * row_m,
            radius_m: radius,
            arc_m: arc,
            above_m: above,
            // as wide as on the grid, where places stand at the middle of elements: there it is a sixth for both
            half_arc_m: half(arc2 - arc * arc, column_m * column_m / 12.0),
            half_height_m: half(above2 - above * above, row_m * row_m / 6.0),
        })
    }

    /// Follows every row through the contact; what it loses goes to `pressed_m`, and by how much of its depth to `fall_m`.
    #[inline(always)]
    fn press<S: Simd>(&mut self, simd: S, pass: &Pass, spot: &Spot, rows: Rows) -> (Carried, Option<Ellipse>) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let mut sums = [zero; 6];
        let [mut radial, mut along, mut up, mut deepest] = [zero; 4];
        let steepest = splat(simd, STEEPEST * pass.radius_m);
        let bed = spot.bed();
        for at in rows.eights() {
            let (above_m, chord_m2) = rows.at(simd, at);
            let (before, behind) = (eight(simd, &self.before_rad, at), eight(simd, &self.behind_rad, at));
            let touched = positive(before);
            if !touched.any_true() {
                put(&mut self.pressed_m, at, zero);
                continue;
            }
            let above = only(touched, above_m);
            let lead =
                eight(simd, &self.radii_m, at) + eight(simd, &self.lead_m, at) + eight(simd, &self.inside_m[0], at);
            let width = (before + behind) * (1.0 / NODES as f32);
            let share = gives_way(width * pass.rate_per_rad);
            let (mut radius, mut angle) = (lead, before - width * 0.5);
            for _ in 0..NODES {
                let sin = sine(angle);
                let aside = sin * pass.distance_m;
                let chord = (chord_m2 - aside * aside).max(zero).sqrt();
                let depth = only(touched, (radius - (cosine(angle) * pass.distance_m - chord)).max(zero));
                let arc = radius * angle;
                let (elastic, shape) = bed.depth_m(arc, above);
                let push = (depth - elastic).max(zero) * share;
                let carried = (depth / elastic).min(one) * shape * (radius - depth) * width;
                let slope = carried / chord.max(steepest);
                radial += carried - slope * aside * sin;
                along -= carried * sin + slope * aside;
                up -= slope * above;
                deepest = deepest.max(depth);
                let weight = push * radius;
                let arc_width = radius * width;
                sums[0] += weight;
                sums[1] += weight * radius;
                sums[2] += weight * arc;
                sums[3] += weight * (arc * arc + arc_width * arc_width * (1.0 / 12.0));
                sums[4] += weight * above;
                sums[5] += weight * above * above;
                radius -= push;
                angle -= width;
            }
            put(&mut self.pressed_m, at, only(touched, lead - radius));
        }
        let deepest_m = deepest.to_array().into_iter().fold(0.0, f32::max);
        let force = Vec3::new(sum(radial), sum(along), sum(up));
        (Carried { force, deepest_m }, self.ellipse(sums, 6.0))
    }

    /// Lays the rim of all that was pressed in a turn; what rises before the tool goes to `lead_m`, both to `fall_m`.
    ///
    /// A turn of an element under a rim of volume V a turn raises it by `V/(π·a·b·I)·∫κ ds/(2π·r)`.
    #[inline(always)]
    fn rise<S: Simd>(&mut self, simd: S, pass: &Pass, spot: &Spot, rim: &Rim, rows: Rows) {
        let zero = splat(simd, 0.0);
        let Rim { dent, volume_m3, shape, .. } = rim;
        let scale = volume_m3 / (PI * dent.half_height_m * shape.area());
        let end = splat(simd, shape.end);
        let bed = spot.bed();
        let narrowest_m = self.bounds_m.0;
        for at in rows.eights() {
            let (above_m, chord_m2) = rows.at(simd, at);
            let high = (above_m - dent.above_m) * (1.0 / dent.half_height_m);
            let high2 = high * high;
            let outer = (end - high2).max(zero).sqrt();
            if !positive(outer).any_true() {
                let [before, behind] = &mut self.inside_m;
                for rows in [before, behind, &mut self.lead_m, &mut self.fall_m] {
                    put(rows, at, zero);
                }
                continue;
            }
            let inner = (splat(simd, Rim::BEGIN) - high2).max(zero).sqrt();
            let radius = eight(simd, &self.radii_m, at);
            // nothing rises beyond the rim
            let there = positive(radius);
            let lead = radius + eight(simd, &self.lead_m, at);
            let lead = lead + eight(simd, &self.inside_m[0], at);
            let trail = lead - eight(simd, &self.pressed_m, at);
            let across = Across { pass, bed: &bed, dent, shape, above_m, chord_m2, high2, inner, outer };
            let edge_rad = eight(simd, &self.before_rad, at);
            let [under, outside] = across.risen(1.0, lead.max(splat(simd, narrowest_m)), edge_rad, scale);
            put(&mut self.inside_m[0], at, only(there, under));
            put(&mut self.lead_m, at, only(there, outside));
            let edge_rad = eight(simd, &self.behind_rad, at);
            let [under, outside] = across.risen(-1.0, trail.max(splat(simd, narrowest_m)), edge_rad, scale);
            put(&mut self.inside_m[1], at, only(there, under));
            put(&mut self.fall_m, at, only(there, outside));
        }
    }

    /// Moves the rows by the turns that the pass lasts.
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S, pass: &Pass, rows: Rows) {
        let (low, high) = (splat(simd, self.bounds_m.0), splat(simd, self.bounds_m.1));
        for at in rows.eights() {
            let risen_before = eight(simd, &self.lead_m, at);
            let (under_before, under_behind) = (eight(simd, &self.inside_m[0], at), eight(simd, &self.inside_m[1], at));
            let risen = (risen_before + eight(simd, &self.fall_m, at)) + (under_before + under_behind);
            let pressed = eight(simd, &self.pressed_m, at);
            if !(positive(risen) | positive(pressed)).any_true() {
                // nothing moves, and it falls no more
                put(&mut self.fall_m, at, splat(simd, 0.0));
                continue;
            }
            let fall = pressed - risen;
            let (before, behind) = (eight(simd, &self.before_rad, at), eight(simd, &self.behind_rad, at));
            // what is pressed comes to rest as its depth goes: half of that change belongs to this pass
            let slower = gives_way((before + behind) * pass.rate_per_rad) * (0.5 * pass.turns) + 1.0;
            let radius = eight(simd, &self.radii_m, at);
            let moved = (radius - fall * pass.turns / slower).max(low).min(high);
            let kept = moved.simd_eq(moved) & fall.simd_ne(splat(simd, 0.0));
            put(&mut self.radii_m, at, kept.select(moved, radius));
            put(&mut self.fall_m, at, fall);
            put(&mut self.lead_m, at, fall * 0.5 + risen_before);
        }
    }
}

/// The rim across eight rows, from where it begins to where it ends, in half axes of the dent.
struct Across<'a, S: Simd> {
    pass: &'a Pass,
    bed: &'a Bed,
    dent: &'a Ellipse,
    shape: &'a RimShape,
    /// Heights above the tool, m, and half its chord there squared, m².
    above_m: f32x8<S>,
    chord_m2: f32x8<S>,
    /// Square of the height from the dent's middle, over the half axis.
    high2: f32x8<S>,
    inner: f32x8<S>,
    outer: f32x8<S>,
}

impl<S: Simd> Across<'_, S> {
    /// Height of the rim, over that of its crest.
    #[inline(always)]
    fn crest(&self, across: f32x8<S>, sign: f32) -> f32x8<S> {
        let (zero, one) = (splat(across.simd, 0.0), splat(across.simd, 1.0));
        let q2 = across * across + self.high2;
        let (start, slope) = self.shape.line();
        let line = splat(across.simd, start) - q2 * slope;
        let within = ((q2 - Rim::BEGIN) * (1.0 / (1.0 - Rim::BEGIN))).min(one);
        let uneven = (across * across - self.high2) * self.shape.around;
        let weight = (across * (sign * self.shape.along) + uneven + 1.0).max(zero);
        let square = line * line;
        square * (square * self.shape.slides + (1.0 - self.shape.slides)) * within * weight
    }

    /// What rises on one side of the dent's middle in a turn, m: under the tool, where it rises the less the more it is pressed,
    /// and outside of it.
    #[inline(always)]
    fn risen(&self, sign: f32, radius: f32x8<S>, edge_rad: f32x8<S>, scale: f32) -> [f32x8<S>; 2] {
        let &Self { inner, outer, dent, .. } = self;
        let simd = radius.simd;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let edge = (edge_rad * radius - dent.arc_m * sign) * (1.0 / dent.half_arc_m);
        let edge = only(positive(edge_rad), edge).max(inner).min(outer);
        let (mut under, mut outside) = (zero, zero);
        for (place, share) in RIM_NODES {
            // nearer to each other at the crest, which is narrow under a sliding tool
            outside += self.crest(edge + (outer - edge) * (place * place), sign) * (2.0 * place * share);
        }
        if edge.simd_gt(inner).any_true() {
            for (place, share) in RIM_NODES {
                let across = inner + (edge - inner) * place;
                let arc = across * (sign * dent.half_arc_m) + dent.arc_m;
                let depth = self.pass.depth_m(radius, arc / radius, self.chord_m2);
                let (elastic, _) = self.bed.depth_m(arc, self.above_m);
                under += self.crest(across, sign) * (one - depth / elastic).max(zero) * share;
            }
        }
        let scale = splat(simd, scale) / radius;
        [under * (edge - inner) * scale, outside * (outer - edge) * scale]
    }
}

/// Force over pressure and height of a row, and the largest depth.
struct Carried {
    force: Vec3,
    deepest_m: f32,
}

/// `1 − exp(−x)` for a small x, to 2.5·10⁻⁶ up to 0.3 and 2.7·10⁻⁵ up to 0.5.
#[inline(always)]
fn gives_way<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    x / (x * (x * (1.0 / 12.0) + 0.5) + 1.0)
}

/// Angle from a tool at `distance_m` at which it meets a row of radius r, rad; zero where it does not.
///
/// `1 − cosθ = (h² − (H − r)²)/(2·H·r)`, h half its chord.
#[inline(always)]
fn edge_rad<S: Simd>(radius: f32x8<S>, chord_m2: f32x8<S>, distance_m: f32) -> f32x8<S> {
    let apart = splat(radius.simd, distance_m) - radius;
    let over = chord_m2 - apart * apart;
    let touched = positive(over) & positive(radius);
    let versine = only(touched, over / (radius * (2.0 * distance_m)));
    (versine * 2.0).sqrt() * (versine * (versine * (3.0 / 160.0) + 1.0 / 12.0) + 1.0)
}

#[inline(always)]
fn sine<S: Simd>(angle: f32x8<S>) -> f32x8<S> {
    let square = angle * angle;
    angle * (square * (square * (1.0 / 120.0) - 1.0 / 6.0) + 1.0)
}

#[inline(always)]
fn cosine<S: Simd>(angle: f32x8<S>) -> f32x8<S> {
    let square = angle * angle;
    square * (square * (square * (-1.0 / 720.0) + 1.0 / 24.0) - 0.5) + 1.0
}

#[inline(always)]
fn eight<S: Simd>(simd: S, rows: &[f32], at: usize) -> f32x8<S> {
    f32x8::from_slice(simd, &rows[at..at + LANES])
}

#[inline(always)]
fn put<S: Simd>(rows: &mut [f32], at: usize, lanes: f32x8<S>) {
    lanes.store_slice(&mut rows[at..at + LANES]);
}

/// How far along its turn a place of the thread is, from −½ right behind the tool to ½ right before it.
///
/// `ahead_rad` is counted in the tool's own direction, within a turn; over the contact's half angle the step is a slope.
pub(super) fn thread(ahead_rad: f32, half_contact_rad: f32) -> f32 {
    let turned = ahead_rad - TAU * libm::floorf(ahead_rad / TAU);
    let half = half_contact_rad.clamp(1e-6, 0.25 * TAU);
    let even = 0.5 - turned / TAU;
    if turned < half {
        even * turned / half
    } else if turned > TAU - half {
        even * (TAU - turned) / half
    } else {
        even
    }
}
