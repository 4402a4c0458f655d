//! What a convex tool in a pose cuts out of the half-planes through the pot's axis, row by row.
//!
//! Finds the half-planes that the tool comes within reach in, and never looks at the others; the outline in one of them
//! is `outline.rs`. Knows directions and rows, no clay.
//! Invariant: the result depends on tool, pose, lattice and reach alone, and is finite for every finite pose.

use alloc::vec::Vec;
use core::ops::Range;

use glam::{Mat3, Quat, Vec2, Vec3};

use super::ConvexTool;
use super::cut::{AXIS_M, Cut};
use super::outline::{Begin, Filled, Outline, Slices, Way};
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
    /// Numbers of the triangles on the near side if that was asked for, or else on the far one; where no tool is, that of none.
    pub(crate) facets: &'a [[u16; LANES]],
    /// Radius beyond which nothing of that side lies, m.
    pub(crate) bound_m: f32,
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
    /// Radii between which its sides lie, the near one and the far one, m.
    bounds_m: [[f32; 2]; 2],
}

impl Span {
    const fn is_empty(&self) -> bool {
        self.first_row >= self.end_row
    }

    /// Its column and its rows.
    const fn place(&self) -> (u32, Range<u32>) {
        (self.column, self.first_row..self.end_row)
    }
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
        with_vectors!(Vectors::default(), simd => {
            self.cut_with(simd, tool, pose, lattice, reach_m, sides);
            if let Some(cut) = Cut::new(tool, pose, lattice, reach_m, sides) {
                self.measure(simd, &cut);
            }
        });
    }

    /// The same with the vectors of a pass, which finds the facets and no radii.
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
        let mut searches = [Search::new(cut.middle_of(side)); 2];
        loop {
            let room = LANES.min(columns - searches[AHEAD].gone - searches[BEHIND].gone);
            let [ahead, behind] = searches.each_ref().map(|search| search.left(&cut).min(room));
            // half of them on either side as long as both go on: those as far from the first are about as long
            let ahead = ahead.min(room.div_ceil(2).max(room - behind));
            let counts = [ahead, behind.min(room - ahead)];
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
                        self.write(&slices, &cut, way, lane as u32, lane);
                    }
                }
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
                        columns[begins[which] + number] =
                            cut.column(first, which == AHEAD, searches[which].gone + number);
                    }
                }
                let slices = cut.slices(simd, columns, sense, reach_m);
                let crossings = slices.crossings(searches.each_ref().map(|search| search.begin), counts);
                let ways = if crossings.iter().any(Option::is_some) {
                    slices.walk(crossings, &mut self.outline)
                } else {
                    [const { None }; LANES]
                };
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
                        let in_reach = way.filter(|way| way.nearest_m <= farthest_m);
                        if in_reach.is_none() && search.is_found {
                            search.has_ended = true;
                            break;
                        }
                        search.gone += 1;
                        let Some(way) = in_reach else {
                            search.begin = way.map_or(search.begin, |way| self.outline.middle(way));
                            continue;
                        };
                        if !core::mem::replace(&mut search.is_found, true) {
                            // those in reach stand side by side: on the other side only if the first one is among them
                            let is_first = which == AHEAD && search.gone == 1;
                            let other = &mut searches[1 - which];
                            (other.is_found, other.has_ended) = (is_first, !is_first);
                        }
                        let search = &mut searches[which];
                        // all of it is within reach, and the next may not be
                        if is_far && way.nearest_m >= reach_m {
                            search.begin = self.outline.middle(way);
                            continue;
                        }
                        holds_axis |= way.nearest_m < 0.0 && !is_far;
                        if !is_far {
                            search.nearest_m = [search.nearest_m[1], way.nearest_m];
                        }
                        let begin = self.write(&slices, cut, way, columns[lane] as u32, lane);
                        search.begin = begin.unwrap_or_else(|| self.outline.middle(way));
                    }
                }
                if holds_axis {
                    self.far(simd, cut, columns, begun);
                }
            },
        );
    }

    /// Writes the rows of a way in a column, which is in one of eight, if there are any, and tells their middle.
    #[inline(always)]
    fn write<S: Simd>(
        &mut self,
        slices: &Slices<'_, S>,
        cut: &Cut<'_>,
        way: &Way,
        column: u32,
        lane: usize,
    ) -> Option<Begin> {
        let (slot, rows) = (self.slots, self.slot(self.slots));
        let is_far = cut.sides == Sides::Far;
        let facets = if is_far { &mut self.far_facet[rows] } else { &mut self.facet[rows] };
        let Filled { rows: (first, end), radii_m: [nearest_m, farthest_m] } =
            slices.fill(way, &self.outline, facets)?;
        let middle = usize::midpoint(first, end);
        let begin = Begin { facet: facets[LANES + middle], height: middle as f32 };
        close(facets, (first, end), cut.none());
        let goes_on = way.nearest_m < 0.0 || cut.sides == Sides::Both;
        let last_side = goes_on.then(|| self.outline.last_side(way));
        let bounds_m = [[nearest_m.max(0.0), farthest_m.max(0.0)], [-farthest_m, -nearest_m]];
        self.spans.push(Span { column, first_row: first as u32, end_row: end as u32, slot, lane, last_side, bounds_m });
        self.slots += 1;
        Some(begin)
    }

    /// Cuts the far side of the spans from number `begun` on, where it is wanted, and leaves of them what is in front of the axis.
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
                    let facets = &mut self.far_facet[rows.clone()];
                    let far = ways[span.lane].as_ref().and_then(|way| opposite.fill(way, &self.outline, facets));
                    let Some(Filled { rows: (first, end), radii_m: [nearest_m, farthest_m] }) = far else {
                        self.spans[number].end_row = 0;
                        continue;
                    };
                    close(facets, (first, end), cut.none());
                    self.spans[number] = Span {
                        first_row: span.first_row.max(first as u32),
                        end_row: span.end_row.min(end as u32),
                        bounds_m: [span.bounds_m[0], [-farthest_m, -nearest_m]],
                        ..span
                    };
                    self.measure_far(simd, cut, number);
                    let Span { first_row, end_row, .. } = self.spans[number];
                    close(&mut self.facet[rows], (first_row as usize, end_row as usize), cut.none());
                }
                self.spans.retain(|span| !span.is_empty());
            },
        );
    }

    /// Measures the radii of what was found.
    #[inline(always)]
    fn measure<S: Simd>(&mut self, simd: S, cut: &Cut<'_>) {
        for number in 0..self.spans.len() {
            if cut.sides != Sides::Near {
                self.measure_far(simd, cut, number);
            }
            if cut.sides != Sides::Far {
                let span = self.spans[number];
                let rows = self.slot(span.slot);
                let (facets, near_m) = (&self.facet[rows.clone()], &mut self.near_m[rows.clone()]);
                cut.measure(simd, span.place(), (Sides::Near, span.bounds_m[0]), facets, near_m);
                if cut.sides == Sides::Both {
                    let (near_m, far_m) = (&self.near_m[rows.clone()], &mut self.far_m[rows]);
                    far_m.iter_mut().zip(near_m).for_each(|(far_m, near_m)| *far_m = far_m.max(*near_m));
                }
            }
        }
        self.spans.retain(|span| !span.is_empty());
    }

    /// Measures the far side of a span, and leaves of it what is in front of the axis: where none is, no part of the tool is on this side.
    #[inline(always)]
    fn measure_far<S: Simd>(&mut self, simd: S, cut: &Cut<'_>, number: usize) {
        let span = self.spans[number];
        let rows = self.slot(span.slot);
        let far_m = &mut self.far_m[rows.clone()];
        cut.measure(simd, span.place(), (Sides::Far, span.bounds_m[1]), &self.far_facet[rows], far_m);
        let is_behind = |row: u32| far_m[LANES + row as usize] < 0.0;
        let Span { first_row, end_row, .. } = &mut self.spans[number];
        while first_row < end_row && is_behind(*first_row) {
            *first_row += 1;
        }
        while first_row < end_row && is_behind(*end_row - 1) {
            *end_row -= 1;
        }
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
        // the near side is not nearer than its least radius, the far one not farther than its largest
        let (facets, side) = if self.sides == Some(Sides::Far) { (&self.far_facet, 1) } else { (&self.facet, 0) };
        self.spans.iter().map(move |span| {
            let first_row = span.first_row as usize / LANES * LANES;
            let start = span.slot * self.rows + LANES + first_row;
            let rows = start..start + (span.end_row as usize - first_row).next_multiple_of(LANES);
            let (facets, bound_m) = (facets[rows].as_chunks().0, span.bounds_m[side][side]);
            Eights { column: span.column, first_row: first_row as u32, facets, bound_m }
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

/// Makes what is beyond the ends of some rows, as far as eight rows may reach, facets of no tool.
fn close(facets: &mut [u16], (first, end): (usize, usize), none: u16) {
    for begin in [first, LANES + end] {
        facets[begin..begin + LANES].fill(none);
    }
}

/// The search for columns from the first one on towards rising angle, and from the one before it on the other way.
const AHEAD: usize = 0;
const BEHIND: usize = 1;

/// How far a search has come.
#[derive(Clone, Copy)]
struct Search {
    /// Where that for the next column begins.
    begin: Begin,
    /// Columns gone over.
    gone: usize,
    /// Whether one in reach has been found, and whether the next one cannot be cut.
    is_found: bool,
    has_ended: bool,
    /// Least radii of the near side in the last two columns in reach, m, as far as there are.
    nearest_m: [f32; 2],
}

impl Search {
    const fn new(begin: Begin) -> Self {
        Self { begin, gone: 0, is_found: false, has_ended: false, nearest_m: [0.0; 2] }
    }

    /// How many columns are still to be cut, at most eight.
    ///
    /// Seen along the axis, a convex tool has no part that is nearer than the line on through its nearest places in the last two columns. Columns
    /// an angle φ apart meet it at radii of which `1/r₂ = 2cosφ/r₁ − 1/r₀`, and it passes the axis at a distance of
    /// `d = sinφ/√(1/r₀² + 1/r₁² − 2cosφ/r₀r₁)`; one that is nearer by as much as corners may stand out of planes, at `1/r·d/(d − s)`.
    fn left(&self, cut: &Cut<'_>) -> usize {
        const SLACK_M: f32 = 4.0 * ConvexTool::BULGE_MAX.0;
        let [before_m, last_m] = self.nearest_m;
        if self.has_ended {
            return 0;
        }
        if before_m.min(last_m) <= AXIS_M {
            return LANES;
        }
        let [one, next] = [0, 1].map(|column| cut.lattice.directions[column % cut.lattice.directions.len()]);
        let (cos, sin, [mut before, mut last]) = (one.dot(next), one.perp_dot(next), [1.0 / before_m, 1.0 / last_m]);
        let distance_m = sin / root(before * before + last * last - 2.0 * cos * before * last);
        let mut left = 0;
        while left < LANES {
            (before, last) = (last, 2.0 * cos * last - before);
            // farther on, both places lead farther astray
            let nearer_m = distance_m - (left + 1) as f32 * SLACK_M;
            if last * distance_m * cut.reach_m < nearer_m {
                break;
            }
            left += 1;
        }
        left
    }
}
