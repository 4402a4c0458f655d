//! The edges of a convex tool that has sharp ones, and between which angles about the axis they lie.
//!
//! Owns which edges count; which rays are looked along between those angles is the clay's affair.
//! Invariant: a tool without a sharp edge has none.

use alloc::vec::Vec;

use glam::{Mat3, Vec2, Vec3};

use super::{ConvexTool, Pose, Sides};
use crate::lanes::{Eight, LANES, Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8, positive, root, splat};

/// Cosine of the least angle by which the facets of a sharp edge turn: more than those of a ball of 320 facets do.
const SHARP: f32 = 0.9;
/// The same of one that is an edge at all, and no line within a plane.
const EDGE: f32 = 0.9999;

/// Both ends of the edges of a tool of which one is sharp, by eights along x, y and z, m; the last edge fills what is left of its eight.
#[derive(Clone, Debug, Default)]
pub(super) struct Ridges {
    ends_m: Vec<[[Eight; 3]; 2]>,
}

impl Ridges {
    /// Most edges: what has more is as good as round.
    const MAX: usize = 1024;
    /// How far apart eights are that follow each other, and how many are looked at before it is asked whether they are wide enough.
    const APART: usize = 5;
    const TOGETHER: usize = 4;

    /// Those of a tool; none where no edge is sharp or there are too many.
    pub(super) fn of(tool: &ConvexTool) -> Self {
        let turn = |side: u16| {
            let [one, other] = [side, tool.twin(side)].map(|side| tool.normals()[usize::from(side / 3)]);
            one.dot(other)
        };
        let sides = 0..tool.sides() as u16;
        let edges: Vec<u16> = sides.filter(|side| *side < tool.twin(*side) && turn(*side) < EDGE).collect();
        if edges.len() > Self::MAX || edges.iter().all(|side| turn(*side) > SHARP) {
            return Self::default();
        }
        let eight = |edges: &[u16]| {
            let side = |lane: usize| edges[lane.min(edges.len() - 1)];
            let ends = |lane: usize| [tool.origin(side(lane)), tool.end(side(lane))];
            let end_m = |lane: usize, which: usize| tool.corners_m()[usize::from(ends(lane)[which])];
            [0, 1].map(|which| [0, 1, 2].map(|axis| Eight(core::array::from_fn(|lane| end_m(lane, which)[axis]))))
        };
        let ends_m: Vec<_> = edges.chunks(LANES).map(eight).collect();
        // neighbours apart, so that a few tell how wide the tool is
        let ends_m =
            (0..Self::APART).flat_map(|first| ends_m.iter().skip(first).step_by(Self::APART).copied()).collect();
        Self { ends_m }
    }
}

impl ConvexTool {
    /// Whether it has a sharp edge.
    pub(crate) const fn is_sharp(&self) -> bool {
        !self.ridges().ends_m.is_empty()
    }

    /// Angles between which a tool with sharp edges is within `reach_m` of the axis, from that of its centre, rad, or beyond it where its far side
    /// is asked for. None of another tool, of one that is out of reach, nor where they are `wide_rad` apart or more than a quarter of a turn aside.
    ///
    /// What of a tool is within a cylinder has its ends on edges: of a facet the cylinder cuts out a line that goes round the axis one way.
    #[inline(always)]
    pub(crate) fn ends_rad<S: Simd>(
        &self,
        simd: S,
        pose: &Pose,
        reach_m: f32,
        sides: Sides,
        wide_rad: f32,
    ) -> Option<[f32; 2]> {
        let edges = &self.ridges().ends_m;
        let (turn, centre_m) = (pose.turn()?, pose.centre_m.truncate());
        let distance_m = root(centre_m.length_squared());
        if distance_m <= Self::THICKNESS_MIN.0 {
            return None;
        }
        let seen = Seen::new(&turn, centre_m / distance_m, distance_m);
        let mut ends = Ends::new(simd, reach_m * reach_m, sides == Sides::Far);
        let mut found_rad = None;
        for edges_m in edges.chunks(Ridges::TOGETHER) {
            for edges_m in edges_m {
                let [from_m, to_m] = edges_m.each_ref().map(|end_m| seen.places_m(simd, end_m));
                ends.add_edges(from_m, to_m);
            }
            found_rad = ends.rad();
            if ends.is_aside || found_rad.is_some_and(|[begin, end]| end - begin >= wide_rad) {
                return None;
            }
        }
        found_rad
    }
}

/// Eight places, along the ray to a tool's centre and across it.
#[derive(Clone, Copy)]
struct Places<S: Simd>([f32x8<S>; 2]);

impl<S: Simd> Places<S> {
    #[inline(always)]
    fn dot(self, other: Self) -> f32x8<S> {
        self.0[0] * other.0[0] + self.0[1] * other.0[1]
    }
}

/// The level axes of a tool along the ray to its centre and across it.
struct Seen {
    axes: [Vec2; 3],
    distance_m: f32,
}

impl Seen {
    fn new(turn: &Mat3, towards: Vec2, distance_m: f32) -> Self {
        let along = |axis: Vec3| Vec2::new(towards.dot(axis.truncate()), towards.perp_dot(axis.truncate()));
        Self { axes: [turn.x_axis, turn.y_axis, turn.z_axis].map(along), distance_m }
    }

    #[inline(always)]
    fn places_m<S: Simd>(&self, simd: S, [x_m, y_m, z_m]: &[Eight; 3]) -> Places<S> {
        let [x, y, z] = self.axes;
        let [x_m, y_m, z_m] = [x_m.on(simd), y_m.on(simd), z_m.on(simd)];
        Places([(x_m * x.x + y_m * y.x) + (z_m * z.x + self.distance_m), (x_m * x.y + y_m * y.y) + z_m * z.y])
    }
}

/// Least and largest tangent of the angle of what of a tool is within a circle, or beyond it.
struct Ends<S: Simd> {
    least: f32x8<S>,
    most: f32x8<S>,
    /// Whether something is more than a quarter of a turn aside.
    is_aside: bool,
    reach_m2: f32,
    is_far: bool,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn new(simd: S, reach_m2: f32, is_far: bool) -> Self {
        let [least, most] = [f32::INFINITY, f32::NEG_INFINITY].map(|nothing| splat(simd, nothing));
        Self { least, most, is_aside: false, reach_m2, is_far }
    }

    /// The angles, if there is anything.
    #[inline(always)]
    fn rad(&self) -> Option<[f32; 2]> {
        let begin = self.least.to_array().into_iter().fold(f32::INFINITY, f32::min);
        let end = self.most.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max);
        (begin <= end && !self.is_aside).then(|| [begin, end].map(libm::atanf))
    }

    /// Adds those of eight places that count.
    #[inline(always)]
    fn add(&mut self, counts: mask32x8<S>, Places([along_m, across_m]): Places<S>) {
        let tangent = across_m / along_m;
        self.least = counts.select(tangent, self.least).min(self.least);
        self.most = counts.select(tangent, self.most).max(self.most);
        self.is_aside |= (counts & !positive(along_m)).any_true();
    }

    /// Adds what of eight edges is within the circle, or beyond it: as t goes from 0 to 1, `|from + t·way|²` is the circle's square at
    /// `t = (−b ± √(b² − a·c))/a`.
    #[inline(always)]
    fn add_edges(&mut self, from_m: Places<S>, to_m: Places<S>) {
        let [c, end] = [from_m, to_m].map(|place_m| place_m.dot(place_m) - self.reach_m2);
        let is_beyond = [c, end].map(positive);
        let counts = if self.is_far { is_beyond } else { is_beyond.map(|is_beyond| !is_beyond) };
        let way_m = Places([to_m.0[0] - from_m.0[0], to_m.0[1] - from_m.0[1]]);
        let (a, b) = (way_m.dot(way_m), from_m.dot(way_m));
        let is_across = is_beyond[0] ^ is_beyond[1];
        // one with both ends beyond it may still come in between them
        let dips = !counts[0] & !counts[1] & positive(a + b) & !positive(b);
        let square = b * b - a * c;
        let crosses = (is_across | dips) & positive(square) & positive(a);
        let has_ends = counts[0] | counts[1];
        if !(has_ends | crosses).any_true() {
            return;
        }
        if has_ends.any_true() {
            self.add(counts[0], from_m);
            self.add(counts[1], to_m);
        }
        if crosses.any_true() {
            let half = square.max(0.0).sqrt();
            for share in [(-b - half) / a, (half - b) / a] {
                let is_between = crosses & positive(share) & !positive(share - 1.0);
                self.add(is_between, Places([from_m.0[0] + way_m.0[0] * share, from_m.0[1] + way_m.0[1] * share]));
            }
        }
    }
}
