//! A tool in a pose above a lattice, of which some is to be cut: where to begin, and what its columns look like.
//!
//! Knows neither what has been cut nor where that is written, which is `section.rs`'s.
//! Invariant: all of it depends on tool, pose, lattice, reach and sides alone.

use core::ops::Range;

use glam::{Mat3, Vec2, Vec3};

use super::outline::{Begin, Slices};
use super::ray::Ray;
use super::{ConvexTool, Lattice, Pose, Sides};
use crate::lanes::{LANES, Simd, SimdBase, counted, root};

/// What comes as near as this to the axis may as well hold it, m: the least thickness of a tool.
pub(super) const AXIS_M: f32 = ConvexTool::THICKNESS_MIN.0;

/// Tool, pose and lattice, brought together once a press.
pub(super) struct Cut<'a> {
    tool: &'a ConvexTool,
    turn: Mat3,
    centre_m: Vec3,
    pub(super) lattice: Lattice<'a>,
    rows_per_m: f32,
    pub(super) reach_m: f32,
    pub(super) sides: Sides,
}

impl<'a> Cut<'a> {
    pub(super) fn new(
        tool: &'a ConvexTool,
        pose: &Pose,
        lattice: &Lattice<'a>,
        reach_m: f32,
        sides: Sides,
    ) -> Option<Self> {
        let turn = pose.turn()?;
        let (z_m, radius_m) = (pose.centre_m.z, tool.radius().0);
        let is_cut = !lattice.directions.is_empty()
            && (1..=Lattice::ROWS_MAX).contains(&lattice.rows)
            && lattice.row_height_m >= Lattice::ROW_HEIGHT_MIN_M
            && (-radius_m..=lattice.rows as f32 * lattice.row_height_m + radius_m).contains(&z_m);
        let rows_per_m = 1.0 / lattice.row_height_m;
        is_cut.then_some(Self { tool, turn, centre_m: pose.centre_m, lattice: *lattice, rows_per_m, reach_m, sides })
    }

    /// The slices of columns, along their directions or against them.
    #[inline(always)]
    pub(super) fn slices<S: Simd>(&self, simd: S, columns: [usize; LANES], sense: f32, reach_m: f32) -> Slices<'a, S> {
        let mut directions = [[0.0; LANES]; 2];
        for (lane, column) in columns.into_iter().enumerate() {
            let direction = self.lattice.directions[column] * sense;
            (directions[0][lane], directions[1][lane]) = (direction.x, direction.y);
        }
        let (pose, rows) = ((&self.turn, self.centre_m), (self.lattice.rows, self.rows_per_m));
        Slices::new(simd, self.tool, pose, directions, rows, reach_m)
    }

    /// The middle of a side, to begin at.
    pub(super) fn middle_of(&self, side: u16) -> Begin {
        let [from_m, to_m] = [self.tool.origin(side), self.tool.end(side)].map(|corner| {
            let corner = self.tool.corners_m()[usize::from(corner)];
            (self.turn.x_axis.z * corner.x + self.turn.y_axis.z * corner.y)
                + (self.turn.z_axis.z * corner.z + self.centre_m.z)
        });
        Begin { facet: side / 3, height: 0.5 * (from_m + to_m) * self.rows_per_m }
    }

    /// Number of the triangle that is none.
    pub(super) fn none(&self) -> u16 {
        self.tool.normals().len() as u16
    }

    /// Measures the radii at which a side that lies between two is met in some rows of a column, m; both slices begin [`LANES`] rows below the
    /// first one, and no tool is as many rows above the last.
    #[inline(always)]
    pub(super) fn measure<S: Simd>(
        &self,
        simd: S,
        (column, rows): (u32, Range<u32>),
        (side, [least_m, most_m]): (Sides, [f32; 2]),
        facets: &[u16],
        radii_m: &mut [f32],
    ) {
        let direction = self.lattice.directions[column as usize].to_array();
        let bound_m = if side == Sides::Far { most_m } else { least_m };
        let ray = Ray::new(self.tool, &self.turn, self.centre_m, direction, (side, bound_m));
        for row in rows.step_by(LANES) {
            let begin = LANES + row as usize;
            let mut eight = [0; LANES];
            eight.copy_from_slice(&facets[begin..begin + LANES]);
            let above_m = counted(simd, row as f32) * self.lattice.row_height_m - self.centre_m.z;
            // a row that lies in a facet is met anywhere on it
            let met_m = ray.radius_m(ray.meet(simd, &eight, above_m).beyond_m).max(least_m).min(most_m);
            radii_m[begin..begin + LANES].copy_from_slice(&met_m.to_array());
        }
    }

    /// A column by its number in one of the searches that begin at the first. It is seldom beyond those that there are, and a division
    /// would take longer than all the rest.
    pub(super) fn column(&self, first: usize, is_ahead: bool, number: usize) -> usize {
        let columns = self.lattice.directions.len();
        let number = if number < columns { number } else { number % columns };
        let column = if is_ahead { first + number } else { first + columns - 1 - number };
        if column < columns { column } else { column - columns }
    }

    /// A direction of the room in the tool's own coordinates.
    fn in_tool(&self, x: f32, y: f32) -> Vec3 {
        let along = |axis: Vec3| axis.x * x + axis.y * y;
        Vec3::new(along(self.turn.x_axis), along(self.turn.y_axis), along(self.turn.z_axis))
    }

    /// A side near the place where the tool comes nearest to the axis, and the next column from there; none when it stays
    /// out of reach.
    ///
    /// Goes from corner to corner, over the nearest point of the sides between them.
    pub(super) fn nearest(&self) -> Option<(u16, usize)> {
        let tool = self.tool;
        let place = |corner: u16| {
            let corner = tool.corners_m()[usize::from(corner)];
            (self.turn.x_axis.truncate() * corner.x + self.turn.y_axis.truncate() * corner.y)
                + (self.turn.z_axis.truncate() * corner.z + self.centre_m.truncate())
        };
        let mut side = tool.outermost(self.in_tool(-self.centre_m.x, -self.centre_m.y));
        let mut nearest = place(tool.origin(side));
        loop {
            let (first, from, mut next) = (side, place(tool.origin(side)), None);
            loop {
                let link = tool.link(side);
                let way = place(link.apex) - from;
                let share = (-from.dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                let reached = from + way * share;
                if reached.length_squared() < nearest.length_squared() {
                    (nearest, next) = (reached, Some(link.onward[1]));
                }
                side = link.onward[0];
                if side == first {
                    break;
                }
            }
            match next {
                Some(nearer) => side = nearer,
                None => break,
            }
        }
        let distance_m = root(nearest.length_squared());
        if distance_m > self.reach_m {
            // the whole tool lies beyond the plane through its innermost corner that way
            let innermost = tool.climb(side, self.in_tool(-nearest.x, -nearest.y));
            if place(tool.origin(innermost)).dot(nearest) > self.reach_m * distance_m {
                return None;
            }
        }
        // beside the axis a direction is chance; the column through the tool's centre crosses it in any case
        let towards = if distance_m > AXIS_M { nearest } else { self.centre_m.truncate() };
        Some((side, self.column_after(towards)))
    }

    /// The same with the place that is farthest away on the tool's own side of the axis; none when the whole tool is within reach.
    pub(super) fn farthest(&self) -> Option<(u16, usize)> {
        let away = self.centre_m.truncate();
        if root(away.length_squared()) + self.tool.radius().0 < self.reach_m {
            return None;
        }
        Some((self.tool.outermost(self.in_tool(away.x, away.y)), self.column_after(away)))
    }

    /// The first column towards rising angle from a direction on.
    fn column_after(&self, towards: Vec2) -> usize {
        let columns = self.lattice.directions.len();
        let turns = libm::atan2f(towards.y, towards.x) * (columns as f32 / core::f32::consts::TAU);
        (libm::ceilf(turns) as i64).rem_euclid(columns as i64) as usize
    }
}
