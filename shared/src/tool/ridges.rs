//! The edges of a convex tool that has sharp ones, and between which angles about the axis they lie.
//!
//! Owns which edges count; which rays are looked along between those angles is the clay's affair.
//! Invariant: a tool without a sharp edge has none.

use alloc::vec::Vec;

use glam::{Mat3, Vec2, Vec3};

use super::{ConvexTool, Pose, Sides};
use crate::lanes::root;

/// Cosine of the least angle by which the facets of a sharp edge turn: more than those of a ball of 320 facets do.
const SHARP: f32 = 0.9;
/// The same of one that is an edge at all, and no line within a plane.
const EDGE: f32 = 0.9999;

/// Corners at both ends of every edge.
#[derive(Clone, Debug, Default)]
pub(super) struct Ridges {
    edges: Vec<[u16; 2]>,
}

impl Ridges {
    /// Most edges: what has more is as good as round.
    const MAX: usize = 1024;

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
        Self { edges: edges.into_iter().map(|side| [tool.origin(side), tool.end(side)]).collect() }
    }
}

impl ConvexTool {
    /// Angles between which a tool with sharp edges is within `reach_m` of the axis, from that of its centre, rad, or beyond it where its far side
    /// is asked for. None of another tool, of one that is out of reach, nor where that is more than a quarter of a turn aside.
    ///
    /// What of a tool is within a cylinder has its ends on edges: of a facet the cylinder cuts out a line that goes round the axis one way.
    pub(crate) fn ends_rad(&self, pose: &Pose, reach_m: f32, sides: Sides) -> Option<[f32; 2]> {
        let edges = &self.ridges().edges;
        if edges.is_empty() {
            return None;
        }
        let (turn, centre_m) = (pose.turn()?, pose.centre_m.truncate());
        let distance_m = root(centre_m.length_squared());
        if distance_m <= Self::THICKNESS_MIN.0 {
            return None;
        }
        let seen = Seen::new(&turn, centre_m / distance_m, distance_m);
        let mut ends = Ends::NONE;
        for [from, to] in edges {
            let [from_m, to_m] =
                [from, to].map(|corner| seen.place_m(self.corners_m()[usize::from(*corner)].truncate()));
            ends.add_edge(from_m, to_m - from_m, reach_m * reach_m, sides == Sides::Far);
        }
        let [begin, end] = ends.tangents;
        (begin <= end && !ends.is_wide).then(|| [begin, end].map(libm::atanf))
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

    fn place_m(&self, corner_m: Vec3) -> Vec2 {
        let [x, y, z] = self.axes;
        (x * corner_m.x + y * corner_m.y) + (z * corner_m.z + Vec2::new(self.distance_m, 0.0))
    }
}

/// Least and largest tangent of the angle of what was added.
struct Ends {
    tangents: [f32; 2],
    is_wide: bool,
}

impl Ends {
    const NONE: Self = Self { tangents: [f32::INFINITY, f32::NEG_INFINITY], is_wide: false };

    fn add(&mut self, place_m: Vec2) {
        let tangent = place_m.y / place_m.x;
        self.is_wide |= place_m.x <= 0.0;
        self.tangents = [self.tangents[0].min(tangent), self.tangents[1].max(tangent)];
    }

    /// Adds what of an edge is within a circle, or beyond it: as t goes from 0 to 1, `|from + t·way|²` is the circle's square at
    /// `t = (−b ± √(b² − a·c))/a`.
    fn add_edge(&mut self, from_m: Vec2, way_m: Vec2, reach_m2: f32, is_far: bool) {
        let (a, b, c) = (way_m.length_squared(), from_m.dot(way_m), from_m.length_squared() - reach_m2);
        let end = a + 2.0 * b + c;
        let is_across = (c > 0.0) != (end > 0.0);
        // one with both ends beyond it may still come in between them
        let dips = !is_far && c > 0.0 && b < 0.0 && a + b > 0.0;
        if !is_across && !dips && (c > 0.0) != is_far {
            return;
        }
        for (share, end_m2) in [(0.0, c), (1.0, end)] {
            if (end_m2 > 0.0) == is_far {
                self.add(from_m + way_m * share);
            }
        }
        let square = b * b - a * c;
        if (is_across || dips) && square > 0.0 && a > 0.0 {
            let half = root(square);
            for share in [(-b - half) / a, (-b + half) / a] {
                if share > 0.0 && share < 1.0 {
                    self.add(from_m + way_m * share);
                }
            }
        }
    }
}
