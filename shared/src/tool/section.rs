//! What a convex tool in a pose cuts out of the half-planes through the pot's axis, row by row.
//!
//! Finds the half-planes that the tool comes within reach in, and never looks at the others; the outline in one of them
//! is `outline.rs`. Knows directions and rows, no clay.
//! Invariant: the result depends on tool, pose, lattice and reach alone, and is finite for every finite pose.

use alloc::vec::Vec;

use glam::{Mat3, Quat, Vec2, Vec3};

use super::ConvexTool;
use super::outline::{Outline, Slice};

/// Where a tool is held, and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Place of the tool's centre, m: z up along the axis.
    pub centre_m: Vec3,
    /// Turns the tool about its centre; of any length but zero.
    pub orientation: Quat,
}

impl Pose {
    /// An orientation turned about z by an angle, in a fixed order as [`Pose::turn`] is.
    #[must_use]
    pub fn about_z(orientation: Quat, angle_rad: f64) -> Quat {
        let (sin, cos) = libm::sincos(0.5 * angle_rad);
        let (sin, cos) = (sin as f32, cos as f32);
        let [x, y, z, w] = orientation.to_array();
        Quat::from_xyzw(cos * x - sin * y, cos * y + sin * x, cos * z + sin * w, cos * w - sin * z)
    }

    /// The turn as a matrix, that of the tool's normals too: `R = I + 2/|q|²·(w[v]ₓ + [v]ₓ²)` with q = (v, w).
    ///
    /// By `+ − × ÷` in a fixed order, so that it is the same on every target. None when the pose is not finite, farther
    /// than a kilometre away, or its quaternion has no length.
    #[must_use]
    pub fn turn(&self) -> Option<Mat3> {
        let [x, y, z, w] = self.orientation.to_array();
        let scale = 2.0 / (x * x + y * y + z * z + w * w);
        let (xs, ys, zs) = (x * scale, y * scale, z * scale);
        let turn = Mat3::from_cols(
            Vec3::new(1.0 - (y * ys + z * zs), x * ys + w * zs, x * zs - w * ys),
            Vec3::new(x * ys - w * zs, 1.0 - (x * xs + z * zs), y * zs + w * xs),
            Vec3::new(x * zs + w * ys, y * zs - w * xs, 1.0 - (x * xs + y * ys)),
        );
        let is_near = self.centre_m.abs().max_element() < 1e3;
        (is_near && turn.to_cols_array().iter().all(|part| part.abs() < 2.0)).then_some(turn)
    }
}

/// The half-planes and rows that are cut: column j at angle j·2π/columns, row i at height i·`row_height_m`.
///
/// Up to [`Lattice::ROWS_MAX`] rows at least [`Lattice::ROW_HEIGHT_MIN_M`] apart; of any other nothing is cut.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// Cosine and sine of every column's angle.
    pub directions: &'a [Vec2],
    /// Rows, from z = 0.
    pub rows: u32,
    /// Distance between neighbouring rows, m.
    pub row_height_m: f32,
}

impl Lattice<'_> {
    /// Most rows.
    pub const ROWS_MAX: u32 = 1 << 16;
    /// Least distance between rows, m.
    pub const ROW_HEIGHT_MIN_M: f32 = 1e-6;
}

/// What the tool cuts out of one column: rows without a gap.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    /// Number of the column.
    pub column: u32,
    /// Number of the first row.
    pub first_row: u32,
    /// Radius at which the tool begins, row by row, m; zero where it holds the axis.
    pub near_m: &'a [f32],
    /// Radius at which it ends, row by row, m; empty unless asked for.
    pub far_m: &'a [f32],
    /// Number of the triangle that is met at `near_m`, row by row, as in [`ConvexTool::normals`].
    pub facet: &'a [u16],
    /// The same for `far_m`.
    pub far_facet: &'a [u16],
}

/// Columns and rows that hold every section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// First column, and how many there are from it on, round the axis.
    pub first_column: u32,
    /// Number of columns.
    pub columns: u32,
    /// First row.
    pub first_row: u32,
    /// Number of rows.
    pub rows: u32,
}

/// The sections of a press, and the memory they are found in.
///
/// ```
/// use glam::{Quat, Vec2, Vec3};
/// use pottery_shared::tool::{Lattice, Pose, Sections, Sides, rack};
///
/// let directions = [0.0_f32, 0.25, 0.5, 0.75].map(|turn| Vec2::from_angle(turn * std::f32::consts::TAU));
/// let lattice = Lattice { directions: &directions, rows: 11, row_height_m: 0.01 };
/// // the straight edge of the rib stands upright from 5 to 105 mm, 21 mm nearer to the axis than its centre
/// let pose = Pose { centre_m: Vec3::new(0.06, 0.0, 0.055), orientation: Quat::IDENTITY };
/// let mut sections = Sections::for_lattice(4, 11);
/// sections.cut(&rack::rib()?, &pose, &lattice, 0.04, Sides::Near);
/// let section = sections.iter().next().ok_or("nothing is cut")?;
/// assert_eq!((section.column, section.first_row, section.near_m.len()), (0, 1, 10));
/// assert!(section.near_m.iter().all(|near_m| (0.038..0.04).contains(near_m)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Sections {
    spans: Vec<Span>,
    /// First column looked at, and how many.
    columns: (usize, usize),
    sides: Option<Sides>,
    rows: usize,
    /// `[spans][rows]`, written where the spans say.
    near_m: Vec<f32>,
    facet: Vec<u16>,
    far_m: Vec<f32>,
    far_facet: Vec<u16>,
    outline: Outline,
}

#[derive(Clone, Copy, Debug)]
struct Span {
    column: u32,
    first_row: u32,
    end_row: u32,
}

/// Which sides of the tool are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Only the near one.
    Near,
    /// The far one too, at about twice the time.
    Both,
}

/// What comes as near as this to the axis may as well hold it, m: the least thickness of a tool.
const AXIS_M: f32 = ConvexTool::THICKNESS_MIN.0;

impl Sections {
    /// Memory for any tool on a lattice of so many columns and rows; a larger one allocates.
    #[must_use]
    pub fn for_lattice(columns: u32, rows: u32) -> Self {
        let mut sections = Self::default();
        sections.lay_out(columns as usize, rows as usize);
        sections
    }

    fn lay_out(&mut self, columns: usize, rows: usize) {
        self.rows = rows;
        let elements = columns * rows;
        if self.near_m.len() < elements || !self.outline.has_room(rows) {
            self.spans.reserve(columns);
            // nothing of it is kept, and memory that is asked for as zeros costs nothing until it is used
            (self.near_m, self.far_m) = (alloc::vec![0.0; elements], alloc::vec![0.0; elements]);
            (self.facet, self.far_facet) = (alloc::vec![0; elements], alloc::vec![0; elements]);
            self.outline.make_room(rows);
        }
    }

    /// Cuts the lattice with `tool` in `pose`, as far as it reaches within `reach_m` of the axis.
    ///
    /// With the tool's facets `n·x ≤ d` and the column's direction e, the near side at height z is the least r ≥ 0 for
    /// which `r·e + z·k` lies in all of them. Sections thinner than 20 µm may be left out. Nothing is cut in a pose
    /// that is not finite.
    pub fn cut(&mut self, tool: &ConvexTool, pose: &Pose, lattice: &Lattice<'_>, reach_m: f32, sides: Sides) {
        self.spans.clear();
        self.columns = (0, 0);
        self.sides = Some(sides);
        let Some(cut) = Cut::new(tool, pose, lattice, reach_m, sides) else { return };
        self.lay_out(lattice.directions.len(), lattice.rows as usize);
        let Some((side, first)) = cut.nearest() else { return };
        let columns = lattice.directions.len();
        let mut ahead = Search { side, is_found: false };
        let mut starts_here = None;
        let mut visited = 0;
        while visited < columns && self.column(&cut, (first + visited) % columns, &mut ahead) {
            starts_here.get_or_insert((ahead.side, ahead.is_found));
            visited += 1;
        }
        // the columns in reach stand side by side: behind the first one only if it is one of them, or none ahead is
        let (side, is_found) = starts_here.unwrap_or((side, false));
        let mut behind = Search { side, is_found };
        let mut visited_behind = 0;
        if is_found || !ahead.is_found {
            while visited_behind < columns - visited
                && self.column(&cut, (first + columns - visited_behind - 1) % columns, &mut behind)
            {
                visited_behind += 1;
            }
        }
        self.columns = ((first + columns - visited_behind) % columns, visited + visited_behind);
    }

    /// Cuts one column and says whether its neighbour may be cut too.
    fn column(&mut self, cut: &Cut<'_>, column: usize, search: &mut Search) -> bool {
        let direction = cut.lattice.directions[column];
        let slice = cut.slice(direction, cut.reach_m);
        let Some(crossing) = slice.crossing(search.side) else { return false };
        // too thin: a tip, behind which the tool may go on
        let Some(way) = slice.walk(crossing, &mut self.outline) else { return !search.is_found };
        search.side = self.outline.middle_side(&way);
        if way.nearest_m > cut.reach_m {
            return !search.is_found;
        }
        search.is_found = true;
        let rows = self.spans.len() * self.rows..(self.spans.len() + 1) * self.rows;
        let near_m = &mut self.near_m[rows.clone()];
        let (mut first, mut end) = slice.fill(&way, &mut self.outline, near_m, &mut self.facet[rows.clone()]);
        if way.nearest_m < 0.0 || cut.sides == Sides::Both {
            // the far side is the near one of the other half of the plane
            let (far_m, far_facet) = (&mut self.far_m[rows.clone()], &mut self.far_facet[rows]);
            let opposite = cut.slice(-direction, f32::MAX);
            let Some(crossing) = opposite.crossing(way.last_side) else { return true };
            let Some(way) = opposite.walk(crossing, &mut self.outline) else { return true };
            let far = opposite.fill(&way, &mut self.outline, far_m, far_facet);
            (first, end) = (first.max(far.0), end.min(far.1));
            // where it ends before the axis, no part of the tool is on this side
            while first < end && far_m[first] > 0.0 {
                first += 1;
            }
            while first < end && far_m[end - 1] > 0.0 {
                end -= 1;
            }
            for row in first..end {
                near_m[row] = near_m[row].max(0.0);
                far_m[row] = near_m[row].max(-far_m[row]);
            }
        }
        if first < end {
            self.spans.push(Span { column: column as u32, first_row: first as u32, end_row: end as u32 });
        }
        true
    }

    /// The columns that are cut, each once.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Section<'_>> {
        self.spans.iter().enumerate().map(|(slot, span)| {
            let start = slot * self.rows;
            let rows = start + span.first_row as usize..start + span.end_row as usize;
            Section {
                column: span.column,
                first_row: span.first_row,
                near_m: &self.near_m[rows.clone()],
                far_m: if self.sides == Some(Sides::Both) { &self.far_m[rows.clone()] } else { &[] },
                facet: &self.facet[rows.clone()],
                far_facet: if self.sides == Some(Sides::Both) { &self.far_facet[rows] } else { &[] },
            }
        })
    }

    /// Columns and rows that hold every section; empty when nothing is cut.
    #[must_use]
    pub fn extent(&self) -> Extent {
        let rows = |(first, end): (u32, u32), span: &Span| (first.min(span.first_row), end.max(span.end_row));
        let (first_row, end_row) = self.spans.iter().fold((u32::MAX, 0), rows);
        if first_row >= end_row {
            return Extent::default();
        }
        let (first_column, columns) = (self.columns.0 as u32, self.columns.1 as u32);
        Extent { first_column, columns, first_row, rows: end_row - first_row }
    }
}

/// Where the search for the next column begins, and whether one in reach has been found.
struct Search {
    side: u16,
    is_found: bool,
}

/// Tool, pose and lattice, brought together once a press.
struct Cut<'a> {
    tool: &'a ConvexTool,
    turn: Mat3,
    centre_m: Vec3,
    lattice: Lattice<'a>,
    rows_per_m: f32,
    reach_m: f32,
    sides: Sides,
}

impl<'a> Cut<'a> {
    fn new(tool: &'a ConvexTool, pose: &Pose, lattice: &Lattice<'a>, reach_m: f32, sides: Sides) -> Option<Self> {
        let turn = pose.turn()?;
        let (z_m, radius_m) = (pose.centre_m.z, tool.radius().0);
        let is_cut = !lattice.directions.is_empty()
            && (1..=Lattice::ROWS_MAX).contains(&lattice.rows)
            && lattice.row_height_m >= Lattice::ROW_HEIGHT_MIN_M
            && (-radius_m..=lattice.rows as f32 * lattice.row_height_m + radius_m).contains(&z_m);
        let rows_per_m = 1.0 / lattice.row_height_m;
        is_cut.then_some(Self { tool, turn, centre_m: pose.centre_m, lattice: *lattice, rows_per_m, reach_m, sides })
    }

    fn slice(&self, direction: Vec2, reach_m: f32) -> Slice<'a> {
        Slice::new(self.tool, (&self.turn, self.centre_m), direction, (self.lattice.rows, self.rows_per_m), reach_m)
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
    fn nearest(&self) -> Option<(u16, usize)> {
        let tool = self.tool;
        let from_above = self.slice(Vec2::X, self.reach_m);
        let place = |corner: u16| {
            let seen = from_above.see(corner);
            Vec2::new(seen.y, seen.x)
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
        // the whole tool lies beyond the plane through its innermost corner that way
        let innermost = tool.climb(side, self.in_tool(-nearest.x, -nearest.y));
        let distance_m = libm::sqrtf(nearest.length_squared());
        if place(tool.origin(innermost)).dot(nearest) > self.reach_m * distance_m {
            return None;
        }
        // beside the axis a direction is chance; the column through the tool's centre crosses it in any case
        let towards = if distance_m > AXIS_M { nearest } else { self.centre_m.truncate() };
        let columns = self.lattice.directions.len();
        let turns = libm::atan2f(towards.y, towards.x) * (columns as f32 / core::f32::consts::TAU);
        Some((side, (libm::ceilf(turns) as i64).rem_euclid(columns as i64) as usize))
    }
}
