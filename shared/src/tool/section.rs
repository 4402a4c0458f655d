//! What a convex tool in a pose cuts out of the half-planes through the pot's axis, row by row.
//!
//! Finds the half-planes that the tool comes within reach in, and never looks at the others; the outline in one of them
//! is `outline.rs`. Knows directions and rows, no clay.
//! Invariant: the result depends on tool, pose, lattice and reach alone, and is finite for every finite pose.

use alloc::vec::Vec;
use core::ops::Range;

use glam::{Mat3, Quat, Vec2, Vec3};

use super::ConvexTool;
use super::outline::{Outline, Slices, Way};
use crate::lanes::{LANES, Simd, Vectors, root, with_vectors};

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
    /// Radius at which the tool begins, row by row, m; zero where it holds the axis, empty unless asked for.
    pub near_m: &'a [f32],
    /// Radius at which it ends, row by row, m; empty unless asked for.
    pub far_m: &'a [f32],
    /// Number of the triangle that is met at `near_m`, row by row, as in [`ConvexTool::normals`].
    pub facet: &'a [u16],
    /// The same for `far_m`.
    pub far_facet: &'a [u16],
}

/// A section's rows eight by eight, from a row on that is a multiple of eight and at most the first.
pub(crate) struct Eights<'a> {
    pub(crate) column: u32,
    pub(crate) first_row: u32,
    /// Radius of the near side if that was asked for, or else of the far one, m; where no tool is, it is endlessly far from the
    /// side that was asked for.
    pub(crate) radii_m: &'a [[f32; LANES]],
    /// Numbers of the triangles; where no tool is, of any that there are.
    pub(crate) facets: &'a [[u16; LANES]],
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
    /// Slots that are written.
    slots: usize,
    /// Rows of a slot: those of a column, with [`LANES`] more before the first and after the last.
    rows: usize,
    /// `[slots][rows]`, written where the spans say.
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
    /// Where its rows are written, and which of eight columns it is in.
    slot: usize,
    lane: usize,
    /// Where the search for its far side begins, if that is wanted.
    last_side: Option<u16>,
}

/// Which sides of the tool are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Only the near one.
    Near,
    /// Only the far one.
    Far,
    /// Both, at about twice the time.
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
        self.rows = rows + 2 * LANES;
        let elements = columns * self.rows;
        if self.near_m.is_empty() {
            self.outline.make_room();
        }
        if self.near_m.len() < elements {
            self.spans.reserve(columns);
            // nothing of it is kept, and memory that is asked for as zeros costs nothing until it is used
            (self.near_m, self.far_m) = (alloc::vec![0.0; elements], alloc::vec![0.0; elements]);
            (self.facet, self.far_facet) = (alloc::vec![0; elements], alloc::vec![0; elements]);
        }
    }

    /// Cuts the lattice with `tool` in `pose`, as far as it reaches within `reach_m` of the axis; the far side alone as far as it is not
    /// within it.
    ///
    /// With the tool's facets `n·x ≤ d` and the column's direction e, the near side at height z is the least r ≥ 0 for
    /// which `r·e + z·k` lies in all of them, and the far one the largest. Sections thinner than 20 µm may be left out. Nothing is cut in a pose
    /// that is not finite.
    pub fn cut(&mut self, tool: &ConvexTool, pose: &Pose, lattice: &Lattice<'_>, reach_m: f32, sides: Sides) {
        with_vectors!(Vectors::default(), simd => self.cut_with(simd, tool, pose, lattice, reach_m, sides));
    }

    /// The same with the vectors of a pass.
    #[inline(never)]
    pub(crate) fn cut_with<S: Simd>(
        &mut self,
        simd: S,
        tool: &ConvexTool,
        pose: &Pose,
        lattice: &Lattice<'_>,
        reach_m: f32,
        sides: Sides,
    ) {
        let Some((cut, side, first)) = self.begin(tool, pose, lattice, reach_m, sides) else { return };
        let columns = lattice.directions.len();
        let mut searches = [Search { side, gone: 0, is_found: false, has_ended: false }; 2];
        loop {
            let left = columns - searches[AHEAD].gone - searches[BEHIND].gone;
            // half of them on either side as long as both go on: those as far from the first are about as long
            let counts = match searches.each_ref().map(|search| search.has_ended) {
                [false, false] => [left.div_ceil(2).min(LANES / 2), (left / 2).min(LANES / 2)],
                [false, true] => [left.min(LANES), 0],
                [true, false] => [0, left.min(LANES)],
                [true, true] => break,
            };
            if counts == [0, 0] {
                break;
            }
            self.eight(simd, &cut, first, &mut searches, counts);
        }
        let [ahead, behind] = searches.map(|search| search.gone);
        self.columns = ((first + columns - behind) % columns, ahead + behind);
    }

    /// Cuts along eight rays that are no columns, by their directions: a section's column is the number of its ray.
    #[inline(never)]
    pub(crate) fn cut_rays<S: Simd>(
        &mut self,
        simd: S,
        tool: &ConvexTool,
        pose: &Pose,
        lattice: &Lattice<'_>,
        reach_m: f32,
        sides: Sides,
    ) {
        let Some((cut, side, _)) = self.begin(tool, pose, lattice, reach_m, sides) else { return };
        self.columns = (0, LANES);
        simd.vectorize(
            #[inline(always)]
            || {
                let (sense, reach_m) = if sides == Sides::Far { (-1.0, -cut.reach_m) } else { (1.0, cut.reach_m) };
                let slices = cut.slices(simd, core::array::from_fn(|lane| lane), sense, reach_m);
                let ways = slices.walk(slices.crossings_from([Some(side); LANES]), &mut self.outline);
                for (lane, way) in ways.iter().enumerate() {
                    if let Some(way) = way.as_ref().filter(|way| way.nearest_m <= reach_m) {
                        self.write(&slices, sides, way, lane as u32, lane);
                    }
                }
                self.end(0);
            },
        );
    }

    /// Forgets what was cut, and finds where to begin, if there is anything to cut: the side with which, and in which column.
    fn begin<'a>(
        &mut self,
        tool: &'a ConvexTool,
        pose: &Pose,
        lattice: &'a Lattice<'a>,
        reach_m: f32,
        sides: Sides,
    ) -> Option<(Cut<'a>, u16, usize)> {
        self.spans.clear();
        self.columns = (0, 0);
        self.sides = Some(sides);
        self.slots = 0;
        let cut = Cut::new(tool, pose, lattice, reach_m, sides)?;
        self.lay_out(lattice.directions.len(), lattice.rows as usize);
        let (side, first) = if sides == Sides::Far { cut.farthest() } else { cut.nearest() }?;
        Some((cut, side, first))
    }

    /// Cuts up to eight columns, so many of them ahead and behind, as long as the next one may be cut too.
    #[inline(never)]
    fn eight<S: Simd>(&mut self, simd: S, cut: &Cut<'_>, first: usize, searches: &mut [Search; 2], counts: [usize; 2]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let is_far = cut.sides == Sides::Far;
                // the far side is the near one of the other half of the plane; as a whole it may be within reach here and there
                let (sense, reach_m) = if is_far { (-1.0, -cut.reach_m) } else { (1.0, cut.reach_m) };
                let farthest_m = if is_far { f32::MAX } else { cut.reach_m };
                let begins = [0, counts[AHEAD]];
                let mut columns = [first; LANES];
                for which in [AHEAD, BEHIND] {
                    for number in 0..counts[which] {
                        columns[begins[which] + number] = cut.column(first, which, searches[which].gone + number);
                    }
                }
                let slices = cut.slices(simd, columns, sense, reach_m);
                let mut crossings = [None; LANES];
                for which in [AHEAD, BEHIND] {
                    let found = &mut crossings[begins[which]..][..counts[which]];
                    slices.crossings(searches[which].side, which == AHEAD, found, begins[which]);
                }
                let ways = slices.walk(crossings, &mut self.outline);
                let begun = self.spans.len();
                let mut holds_axis = cut.sides == Sides::Both;
                for which in [AHEAD, BEHIND] {
                    for lane in begins[which]..begins[which] + counts[which] {
                        let search = &mut searches[which];
                        // the other side is where they are, or the plane passes the tool by
                        if search.has_ended || crossings[lane].is_none() {
                            search.has_ended = true;
                            break;
                        }
                        // too thin: a tip, behind which the tool may go on
                        let way = ways[lane].as_ref();
                        search.side = way.map_or(search.side, |way| self.outline.middle_side(way));
                        let way = way.filter(|way| way.nearest_m <= farthest_m);
                        if way.is_none() && search.is_found {
                            search.has_ended = true;
                            break;
                        }
                        search.gone += 1;
                        let Some(way) = way else { continue };
                        if !core::mem::replace(&mut search.is_found, true) {
                            // those in reach stand side by side: on the other side only if the first one is among them
                            let is_first = which == AHEAD && search.gone == 1;
                            let other = &mut searches[1 - which];
                            (other.is_found, other.has_ended) = (is_first, !is_first);
                        }
                        // all of it is within reach, and the next may not be
                        if is_far && way.nearest_m >= reach_m {
                            continue;
                        }
                        holds_axis |= way.nearest_m < 0.0 && !is_far;
                        self.write(&slices, cut.sides, way, columns[lane] as u32, lane);
                    }
                }
                if holds_axis {
                    self.far(simd, cut, columns, begun);
                }
                self.end(begun);
            },
        );
    }

    /// Writes the rows of a way in a column, which is in one of eight.
    #[inline(always)]
    fn write<S: Simd>(&mut self, slices: &Slices<'_, S>, sides: Sides, way: &Way, column: u32, lane: usize) {
        let (is_far, slot) = (sides == Sides::Far, self.slots);
        let rows = self.slot(slot);
        let (radii_m, facets) = if is_far {
            (&mut self.far_m[rows.clone()], &mut self.far_facet[rows])
        } else {
            (&mut self.near_m[rows.clone()], &mut self.facet[rows])
        };
        let filled = slices.fill(way, &self.outline, radii_m, facets);
        let (first, end) = if is_far { in_front_of_axis(radii_m, filled) } else { filled };
        let goes_on = way.nearest_m < 0.0 || sides == Sides::Both;
        let last_side = goes_on.then(|| self.outline.last_side(way));
        self.spans.push(Span { column, first_row: first as u32, end_row: end as u32, slot, lane, last_side });
        self.slots += 1;
    }

    /// Cuts the far side of the spans from number `begun` on, where it is wanted.
    #[inline(never)]
    fn far<S: Simd>(&mut self, simd: S, cut: &Cut<'_>, columns: [usize; LANES], begun: usize) {
        simd.vectorize(
            #[inline(always)]
            || {
                let opposite = cut.slices(simd, columns, -1.0, f32::MAX);
                let mut sides = [None; LANES];
                for span in &self.spans[begun..] {
                    sides[span.lane] = span.last_side;
                }
                let ways = opposite.walk(opposite.crossings_from(sides), &mut self.outline);
                for number in begun..self.spans.len() {
                    let span = self.spans[number];
                    if span.last_side.is_none() {
                        continue;
                    }
                    let rows = self.slot(span.slot);
                    let (near_m, far_m) = (&mut self.near_m[rows.clone()], &mut self.far_m[rows.clone()]);
                    let far = ways[span.lane]
                        .as_ref()
                        .map_or((0, 0), |way| opposite.fill(way, &self.outline, far_m, &mut self.far_facet[rows]));
                    let (first, end) = in_front_of_axis(far_m, far);
                    let first = first.max(span.first_row as usize);
                    let end = end.min(span.end_row as usize);
                    for (near_m, far_m) in near_m.iter_mut().zip(far_m).take(LANES + end).skip(LANES + first) {
                        *near_m = near_m.max(0.0);
                        *far_m = near_m.max(*far_m);
                    }
                    (self.spans[number].first_row, self.spans[number].end_row) = (first as u32, end as u32);
                }
            },
        );
    }

    /// Leaves out the spans without a row from number `begun` on, and puts the tool endlessly far beyond the others' ends.
    #[inline(always)]
    fn end(&mut self, begun: usize) {
        let mut kept = begun;
        for number in begun..self.spans.len() {
            let span = self.spans[number];
            if span.first_row >= span.end_row {
                continue;
            }
            let rows = self.slot(span.slot);
            let (radii_m, facets, beyond_m) = match self.sides {
                Some(Sides::Far) => (&mut self.far_m[rows.clone()], &mut self.far_facet[rows], f32::NEG_INFINITY),
                _ => (&mut self.near_m[rows.clone()], &mut self.facet[rows], f32::INFINITY),
            };
            let (first, end) = (span.first_row as usize, LANES + span.end_row as usize);
            let facet = facets[LANES + first];
            for begin in [first, end] {
                radii_m[begin..begin + LANES].fill(beyond_m);
                facets[begin..begin + LANES].fill(facet);
            }
            self.spans[kept] = span;
            kept += 1;
        }
        self.spans.truncate(kept);
    }

    /// The rows of a slot.
    fn slot(&self, number: usize) -> Range<usize> {
        number * self.rows..(number + 1) * self.rows
    }

    /// The columns that are cut, each once.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Section<'_>> {
        self.spans.iter().map(|span| {
            let slot = self.slot(span.slot);
            let (first, end) = (slot.start + span.first_row as usize, slot.start + span.end_row as usize);
            let rows = first + LANES..end + LANES;
            let near_rows = if self.sides == Some(Sides::Far) { 0..0 } else { rows.clone() };
            let far_rows = if self.sides == Some(Sides::Near) { 0..0 } else { rows };
            Section {
                column: span.column,
                first_row: span.first_row,
                near_m: &self.near_m[near_rows.clone()],
                far_m: &self.far_m[far_rows.clone()],
                facet: &self.facet[near_rows],
                far_facet: &self.far_facet[far_rows],
            }
        })
    }

    /// The same, eight rows at a time.
    pub(crate) fn eights(&self) -> impl Iterator<Item = Eights<'_>> {
        let (radii_m, facets) = match self.sides {
            Some(Sides::Far) => (&self.far_m, &self.far_facet),
            _ => (&self.near_m, &self.facet),
        };
        self.spans.iter().map(|span| {
            let first_row = span.first_row as usize / LANES * LANES;
            let start = span.slot * self.rows + LANES + first_row;
            let rows = start..start + (span.end_row as usize - first_row).next_multiple_of(LANES);
            Eights {
                column: span.column,
                first_row: first_row as u32,
                radii_m: radii_m[rows.clone()].as_chunks().0,
                facets: facets[rows].as_chunks().0,
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

/// Makes some rows of a side in the other half of the plane those of a far side in this one, m, and tells which of them are in front of the
/// axis: where none is, no part of the tool is on this side.
fn in_front_of_axis(far_m: &mut [f32], (mut first, mut end): (usize, usize)) -> (usize, usize) {
    far_m[LANES + first..LANES + end].iter_mut().for_each(|far_m| *far_m = -*far_m);
    while first < end && far_m[LANES + first] < 0.0 {
        first += 1;
    }
    while first < end && far_m[LANES + end - 1] < 0.0 {
        end -= 1;
    }
    (first, end)
}

/// The search for columns from the first one on towards rising angle, and from the one before it on the other way.
const AHEAD: usize = 0;
const BEHIND: usize = 1;

/// How far a search has come.
#[derive(Clone, Copy)]
struct Search {
    /// Where that for the next column begins.
    side: u16,
    /// Columns gone over.
    gone: usize,
    /// Whether one in reach has been found, and whether the next one cannot be cut.
    is_found: bool,
    has_ended: bool,
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

    /// The slices of columns, along their directions or against them.
    #[inline(always)]
    fn slices<S: Simd>(&self, simd: S, columns: [usize; LANES], sense: f32, reach_m: f32) -> Slices<'a, S> {
        let mut directions = [[0.0; LANES]; 2];
        for (lane, column) in columns.into_iter().enumerate() {
            let direction = self.lattice.directions[column] * sense;
            (directions[0][lane], directions[1][lane]) = (direction.x, direction.y);
        }
        let (pose, rows) = ((&self.turn, self.centre_m), (self.lattice.rows, self.rows_per_m));
        Slices::new(simd, self.tool, pose, directions, rows, reach_m)
    }

    /// A column by its number in one of the searches that begin at the first. It is seldom beyond those that there are, and a division
    /// would take longer than all the rest.
    fn column(&self, first: usize, which: usize, number: usize) -> usize {
        let columns = self.lattice.directions.len();
        let number = if number < columns { number } else { number % columns };
        let column = if which == AHEAD { first + number } else { first + columns - 1 - number };
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
    fn nearest(&self) -> Option<(u16, usize)> {
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
    fn farthest(&self) -> Option<(u16, usize)> {
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
