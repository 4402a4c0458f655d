//! The outline of a convex tool in half-planes: the walk over the facets that they cross, in eight of them at once.
//!
//! Owns the walk and the rows that it passes; which half-planes are looked at is `section.rs`.
//! Invariant: every place met is a point of a side of the mesh, so that nothing lies outside of the tool, and the walk
//! ends after one round at most.

use alloc::vec::Vec;

use glam::{Mat3, Vec3};

use super::ConvexTool;
use super::facets::after;
use crate::lanes::{
    LANES, Select, Simd, SimdBase, SimdFloat, SimdMask, columns, counted, f32x8, i32x8, mask32x8, splat, u32x8,
};

/// How far a way may turn back before it counts as turned, m: twice what a convex tool's corners may stand out.
const SLACK_M: f32 = 2.0 * ConvexTool::BULGE_MAX.0;

/// What is seen from within half-planes: the distance s aside of them, towards rising angle, m; the radius r along them, m; and the
/// height in rows.
type Seen<S> = [f32x8<S>; 3];

/// A tool turned about its centre and set down, seen from within eight half-planes.
pub(super) struct Slices<'a, S: Simd> {
    simd: S,
    tool: &'a ConvexTool,
    steps: &'a [[u32; 4]],
    /// The tool's x, y, z and its centre as they are seen, and the same lane by lane.
    axes: [Seen<S>; 4],
    lanes: [[[f32; LANES]; 3]; 4],
    rows: f32,
    slack_rows: f32,
    reach_m: f32,
}

impl<'a, S: Simd> Slices<'a, S> {
    /// Most facets that are gone over to a half-plane before another way is tried.
    const BESIDE_MAX: usize = 12;

    /// The tool in the half-planes along `directions` from the axis, cosines and sines.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        tool: &'a ConvexTool,
        (turn, centre_m): (&Mat3, Vec3),
        [cos, sin]: [[f32; LANES]; 2],
        (rows, rows_per_m): (u32, f32),
        reach_m: f32,
    ) -> Self {
        let (cos, sin) = (f32x8::load_array(simd, cos), f32x8::load_array(simd, sin));
        let mut axes = [[splat(simd, 0.0); 3]; 4];
        let mut lanes = [[[0.0; LANES]; 3]; 4];
        for ((axis, lanes), vector) in
            axes.iter_mut().zip(&mut lanes).zip([turn.x_axis, turn.y_axis, turn.z_axis, centre_m])
        {
            let (aside, along) = (cos * vector.y - sin * vector.x, cos * vector.x + sin * vector.y);
            *axis = [aside, along, splat(simd, vector.z * rows_per_m)];
            *lanes = [axis[0].to_array(), axis[1].to_array(), axis[2].to_array()];
        }
        let (rows, slack_rows) = (rows as f32, SLACK_M * rows_per_m);
        Self { simd, tool, steps: tool.steps(), axes, lanes, rows, slack_rows, reach_m }
    }

    /// For each half-plane a side that crosses it, as far as there are any: the first few are looked for ahead, towards rising angle, and as
    /// many as there are after them behind.
    ///
    /// It goes over the facets at the height at which each begins, in all half-planes at once, and where that leads nowhere it climbs.
    #[inline(always)]
    pub(super) fn crossings(&self, begins: [Begin; 2], counts: [usize; 2]) -> [Option<u16>; LANES] {
        let (simd, lanes) = (self.simd, counted(self.simd, 0.0));
        let [is_ahead, is_there] = [counts[0], counts[0] + counts[1]].map(
            #[inline(always)]
            |count| lanes.simd_lt(splat(simd, count as f32)),
        );
        let (ahead, behind) = (self.set_out(&begins[0], true), self.set_out(&begins[1], false));
        let mut at = u32x8::splat(simd, u32::from(behind));
        at = is_ahead.select(u32x8::splat(simd, u32::from(ahead)), at);
        let height = is_ahead.select(splat(simd, begins[0].height), splat(simd, begins[1].height));
        let [ahead, behind] = [ahead, behind].map(|side| [self.tool.origin(side), self.tool.end(side)]);
        let mut from = is_ahead.select(self.aside(ahead[0]), self.aside(behind[0]));
        let mut to = is_ahead.select(self.aside(ahead[1]), self.aside(behind[1]));
        let zero = splat(simd, 0.0);
        let mut advances = is_there;
        let mut facets = 0;
        let (crosses, is_to) = loop {
            let (is_from, is_to) = (from.simd_gt(zero), to.simd_gt(zero));
            let crosses = is_from ^ is_to;
            let goes = advances & !crosses & (is_from ^ is_ahead);
            if facets == Self::BESIDE_MAX || !goes.any_true() {
                break (crosses.to_bitmask(), is_to.to_bitmask());
            }
            let entered = at.to_array();
            let (apex, onward) = self.see(
                #[inline(always)]
                |lane| entered[lane],
            );
            // the apex takes the place of the end on its own side of that height
            let is_above = apex[2].simd_gt(height) ^ is_ahead;
            // beyond where the tool is widest a way leads back
            advances &= !(apex[0].simd_gt(is_above.select(from, to)) ^ is_ahead);
            from = (goes & is_above).select(apex[0], from);
            to = (goes & !is_above).select(apex[0], to);
            at = goes.select(is_above.select(onward >> 16, onward & u32x8::splat(simd, 0xffff)), at);
            facets += 1;
        };
        let at = at.to_array();
        let mut found = [None; LANES];
        for lanes in [0..counts[0], counts[0]..counts[0] + counts[1]] {
            for lane in lanes {
                let side = at[lane] as u16;
                found[lane] = match (crosses >> lane & 1 > 0, is_to >> lane & 1 > 0) {
                    (true, true) => Some(side),
                    (true, false) => Some(self.tool.twin(side)),
                    // past the plane, or where the tool ends at that height
                    (false, _) => self.crossing(lane, side),
                };
                if found[lane].is_none() {
                    break;
                }
            }
        }
        found
    }

    /// The side of a facet at a height from which it lies ahead (or behind): a facet is to the left of its sides, and ahead is to the left of what
    /// goes up.
    #[inline(always)]
    fn set_out(&self, begin: &Begin, is_ahead: bool) -> u16 {
        let sides = [0, 1, 2].map(|side| 3 * begin.facet + side);
        let is_above = sides.map(|side| self.part(0, 2, self.tool.origin(side)) > begin.height);
        match is_above.map(|is_above| is_above == is_ahead) {
            [false, true, _] => sides[0],
            [_, false, true] => sides[1],
            // a height that a facet does not have is as good as any
            _ => sides[2],
        }
    }

    /// How far a corner is aside of the half-planes, m.
    #[inline(always)]
    fn aside(&self, corner: u16) -> f32x8<S> {
        let [x, y, z, centre] = &self.axes;
        let corner = self.tool.corners_m()[usize::from(corner)];
        (x[0] * corner.x + y[0] * corner.y) + (z[0] * corner.z + centre[0])
    }

    /// Sides that cross the half-planes, each found from one of its own.
    pub(super) fn crossings_from(&self, sides: [Option<u16>; LANES]) -> [Option<u16>; LANES] {
        core::array::from_fn(|lane| self.crossing(lane, sides[lane]?))
    }

    /// A corner as one half-plane sees it.
    #[inline(always)]
    fn part(&self, lane: usize, what: usize, corner: u16) -> f32 {
        let corner = self.tool.corners_m()[usize::from(corner)];
        let [x, y, z, centre] = &self.lanes;
        (x[what][lane] * corner.x + y[what][lane] * corner.y) + (z[what][lane] * corner.z + centre[what][lane])
    }

    /// A side that crosses a plane from s ≤ 0 to s > 0, found from `side` on; none when the plane passes the tool by.
    fn crossing(&self, lane: usize, side: u16) -> Option<u16> {
        let tool = self.tool;
        let (from, to) = (self.part(lane, 0, tool.origin(side)), self.part(lane, 0, tool.end(side)));
        match (from > 0.0, to > 0.0) {
            (false, true) => return Some(side),
            (true, false) => return Some(tool.twin(side)),
            _ => {}
        }
        let sense = if from > 0.0 { -1.0 } else { 1.0 };
        let side = self.cross(lane, if from * sense > to * sense { side } else { tool.twin(side) }, sense)?;
        Some(if sense > 0.0 { side } else { tool.twin(side) })
    }

    /// Climbs from where `side` begins along s (or against it) until a side crosses the plane.
    fn cross(&self, lane: usize, mut side: u16, sense: f32) -> Option<u16> {
        let tool = self.tool;
        let mut farthest = self.part(lane, 0, tool.origin(side)) * sense;
        loop {
            let (first, mut next) = (side, None);
            loop {
                let link = tool.link(side);
                let aside = self.part(lane, 0, link.apex);
                let reached = aside * sense;
                if (aside > 0.0) == (sense > 0.0) {
                    return Some(link.onward[0]);
                }
                if reached > farthest {
                    (farthest, next) = (reached, Some(link.onward[1]));
                }
                side = link.onward[0];
                if side == first {
                    break;
                }
            }
            side = next?;
        }
    }

    /// The last side of the way up the near side that begins on the far one: on over the bottom of the section.
    fn onto_near_side(&self, lane: usize, crossing: u16) -> Option<u16> {
        let tool = self.tool;
        let see = |corner: u16| [self.part(lane, 0, corner), self.part(lane, 2, corner)];
        let height = |[before, behind]: [[f32; 2]; 2]| {
            before[1] + (behind[1] - before[1]) * (before[0] / (before[0] - behind[0]))
        };
        let mut ends = [see(tool.origin(crossing)), see(tool.end(crossing))];
        let (first, mut lowest) = (tool.twin(crossing), height(ends));
        let mut at = first;
        loop {
            let link = tool.link(at);
            let apex = see(link.apex);
            // the apex takes the place of the end on its own side
            let aside = usize::from(apex[0] > 0.0);
            ends[aside] = apex;
            at = link.onward[aside];
            let height = height(ends);
            lowest = if height < lowest { height } else { lowest };
            if height > lowest + self.slack_rows {
                return Some(tool.twin(at));
            }
            if at == first {
                return None;
            }
        }
    }

    /// Sees in each half-plane the apex to which a step leads, and finds the sides that lead onward from it.
    #[inline(always)]
    fn see(&self, mut side: impl FnMut(usize) -> u32) -> (Seen<S>, u32x8<S>) {
        let [x, y, z, onward] = columns(
            self.simd,
            #[inline(always)]
            |lane| self.steps[side(lane) as usize],
        );
        let (x, y, z) = (f32x8::from_bits(x), f32x8::from_bits(y), f32x8::from_bits(z));
        let [by_x, by_y, by_z, centre] = &self.axes;
        // written out: mapped, it would be a function of its own
        let seen = [
            (by_x[0] * x + by_y[0] * y) + (by_z[0] * z + centre[0]),
            (by_x[1] * x + by_y[1] * y) + (by_z[1] * z + centre[1]),
            (by_x[2] * x + by_y[2] * y) + (by_z[2] * z + centre[2]),
        ];
        (seen, onward)
    }

    /// Walks up and down the near sides from crossed ones; none where the section is too thin to have one.
    #[inline(always)]
    pub(super) fn walk(&self, mut crossings: [Option<u16>; LANES], outline: &mut Outline) -> [Option<Way>; LANES] {
        let ways = self.walk_from(&crossings, outline);
        let mut begin_again = false;
        for (lane, way) in ways.iter().enumerate() {
            if let (None, Some(crossing)) = (way, crossings[lane]) {
                // that was the far side
                crossings[lane] = self.onto_near_side(lane, crossing);
                begin_again |= crossings[lane].is_some();
            }
        }
        if begin_again { self.walk_from(&crossings, outline) } else { ways }
    }

    /// A function of its own, since it is called in two places.
    #[inline(never)]
    fn walk_from(&self, crossings: &[Option<u16>; LANES], outline: &mut Outline) -> [Option<Way>; LANES] {
        self.simd.vectorize(
            #[inline(always)]
            || self.walk_with(crossings, outline),
        )
    }

    #[inline(always)]
    fn walk_with(&self, crossings: &[Option<u16>; LANES], outline: &mut Outline) -> [Option<Way>; LANES] {
        let (simd, tool) = (self.simd, self.tool);
        let sides = crossings.map(|crossing| crossing.unwrap_or(0));
        // the apex beyond the next side of a facet is where a side begins
        let ends = [after, |side| after(after(side))].map(|next| sides.map(|side| u32::from(next(side))));
        let ends = [self.see(|lane| ends[0][lane]).0, self.see(|lane| ends[1][lane]).0];
        let walks = u32x8::load_array(simd, crossings.map(|crossing| u32::from(crossing.is_some())));
        let walks = walks.simd_gt(u32x8::splat(simd, 0));
        // outside of the facet that a side belongs to is the next one up
        let above = sides.map(|side| u32::from(tool.twin(side)));
        let (middle, begun) = (outline.centre(), meet(&ends));
        outline.note(middle, begun, self.rows_below(begun[1]), u32x8::load_array(simd, above));
        let mut up = Going::new(simd, above, ends, begun, walks);
        let mut down = Going::new(simd, sides.map(u32::from), ends, begun, walks);
        self.go_on(&mut up, &mut down, outline);
        let slack = splat(simd, self.slack_rows);
        let extends = (up.outermost - begun[1]).simd_gt(slack) | (begun[1] - down.outermost).simd_gt(slack);
        let extends = (extends & walks).to_bitmask();
        let nearest_m = up.nearest_m.min(down.nearest_m).to_array();
        let (up, down) = (up.places.to_array(), down.places.to_array());
        core::array::from_fn(|lane| {
            let (first, last) = (middle - down[lane] as usize, middle + up[lane] as usize);
            (extends >> lane & 1 > 0).then_some(Way { lane, first, last, nearest_m: nearest_m[lane] })
        })
    }

    /// Goes on to the next sides, for as long as anything more is wanted in any half-plane: up and down by turns, since a step waits for the
    /// one before it and not for those of the other way.
    #[inline(always)]
    fn go_on(&self, up: &mut Going<S>, down: &mut Going<S>, outline: &mut Outline) {
        for step in 1..=outline.centre() {
            let [goes_up, goes_down] = [up.goes(), down.goes()];
            if goes_up {
                self.go::<true>(up, step, outline);
            }
            if goes_down {
                self.go::<false>(down, step, outline);
            }
            if !(goes_up || goes_down) {
                break;
            }
        }
    }

    /// Goes through the next sides into facets, and notes where the sides that lead out of them cross the half-planes.
    #[inline(always)]
    fn go<const UP: bool>(&self, going: &mut Going<S>, step: usize, outline: &mut Outline) {
        let simd = self.simd;
        let entered = going.at;
        let (apex, onward) = self.see(
            #[inline(always)]
            |lane| entered[lane],
        );
        // the apex takes the place of the end on its own side
        let aside = apex[0].simd_gt(splat(simd, 0.0));
        for ((before, behind), apex) in going.before.iter_mut().zip(&mut going.behind).zip(&apex) {
            (*before, *behind) = (aside.select(*before, *apex), aside.select(*apex, *behind));
        }
        let (to_before, to_behind) = (onward & u32x8::splat(simd, 0xffff), onward >> 16);
        let next = if UP { aside.select(to_behind, to_before) } else { aside.select(to_before, to_behind) };
        let met = meet(&[going.before, going.behind]);
        let place = if UP { outline.centre() + step } else { outline.centre() - step };
        outline.note(place, met, self.rows_below(met[1]), if UP { next } else { u32x8::load_array(simd, entered) });
        going.places -= going.walks.to_vector();
        // where it ended it stays
        going.radius_m = going.walks.select(met[0], going.radius_m);
        going.height = going.walks.select(met[1], going.height);
        going.nearest_m = going.nearest_m.min(going.radius_m);
        going.outermost = if UP { going.outermost.max(going.height) } else { going.outermost.min(going.height) };
        let has_turned = if UP {
            going.height.simd_lt(going.outermost - self.slack_rows)
        } else {
            going.height.simd_gt(going.outermost + self.slack_rows)
        };
        // once it recedes it goes on receding
        let has_left = going.radius_m.simd_gt((going.nearest_m + SLACK_M).max(splat(simd, self.reach_m)));
        going.walks &= !(has_turned | has_left | next.simd_eq(going.first));
        going.at = next.to_array();
    }

    /// Numbers of rows whose height is below each `height`, or at it, from none to all; without a call to round.
    #[inline(always)]
    fn rows_below(&self, height: f32x8<S>) -> u32x8<S> {
        let simd = self.simd;
        let within = height.min(splat(simd, self.rows - 0.5)).max(splat(simd, 0.0)) + 0.5;
        (within + WHOLE).to_bits() - u32x8::splat(simd, WHOLE.to_bits())
    }

    /// Writes which facets are met in the rows between the places on a way; which rows they are, and between which radii the facets lie, m.
    ///
    /// The slice begins [`LANES`] rows below the first one, and ends as many above the last one.
    #[inline(always)]
    pub(super) fn fill(&self, way: &Way, outline: &Outline, facets: &mut [u16]) -> Option<Filled> {
        let lane = way.lane;
        let height = |place: usize| of(&outline.places[place], HEIGHT, lane);
        let (mut first, mut last) = (way.first, way.last);
        // the way ends where it turned
        while last > first && height(last) <= height(last - 1) {
            last -= 1;
        }
        while last > first && height(first) >= height(first + 1) {
            first += 1;
        }
        // and a walk may have begun beyond reach
        let is_beyond = |place: usize| of(&outline.places[place], RADIUS, lane) >= self.reach_m;
        while last > first + 1 && is_beyond(last) && is_beyond(last - 1) {
            last -= 1;
        }
        while last > first + 1 && is_beyond(first) && is_beyond(first + 1) {
            first += 1;
        }
        if first == last {
            return None;
        }
        let (lowest, highest) = (
            outline.within_reach(lane, first, first + 1, self.reach_m),
            outline.within_reach(lane, last, last - 1, self.reach_m),
        );
        let (first_row, end_row) = (rows_below(lowest, self.rows), rows_below(highest, self.rows));
        if first_row >= end_row {
            return None;
        }
        // nearer and nearer, and farther from there on
        let [one, other] = [first, last].map(|place| of(&outline.places[place], RADIUS, lane));
        let radii_m = [way.nearest_m, one.max(other)];
        let mut places = &outline.places[first..=last];
        let mut begin = places[0][ROW][lane] as usize;
        while let [place, others @ ..] = places
            && let [next, ..] = others
        {
            places = others;
            let (end, facet) = (next[ROW][lane] as usize, (place[SIDE][lane] / 3) as u16);
            // eight rows at a time: the last place at or below a row is the one that counts
            loop {
                facets[begin + LANES..][..LANES].fill(facet);
                begin += LANES;
                if begin >= end {
                    break;
                }
            }
            begin = end;
        }
        Some(Filled { rows: (first_row as usize, end_row as usize), radii_m })
    }
}

/// Where the outlines of sections pass from one facet to the next, from the lowest place to the highest: the first that is
/// met stands in the middle.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    places: Vec<Place>,
}

/// Bits of the radius, m, and of the height in rows; the first row at or above; and the side through which the facet above is entered. One
/// array, since it comes as zeros for nothing.
type Place = [[u32; LANES]; 4];
const RADIUS: usize = 0;
const HEIGHT: usize = 1;
const ROW: usize = 2;
const SIDE: usize = 3;

impl Outline {
    /// Makes room for a way once round any tool.
    pub(super) fn make_room(&mut self) {
        let places = 2 * ConvexTool::TRIANGLES_MAX + 1;
        // nothing of it is kept, and memory that is asked for as zeros costs nothing until it is used
        self.places = alloc::vec![[[0; LANES]; 4]; places];
    }

    /// Number of the first place that is met, and how many there are below and above it.
    fn centre(&self) -> usize {
        self.places.len() / 2
    }

    /// About half way.
    #[inline(always)]
    pub(super) fn middle(&self, way: &Way) -> Begin {
        let number = usize::midpoint(way.first, way.last).min(way.last - 1);
        let [place, next] = [number, number + 1].map(|number| &self.places[number]);
        let height = 0.5 * (of(place, HEIGHT, way.lane) + of(next, HEIGHT, way.lane));
        Begin { facet: (place[SIDE][way.lane] / 3) as u16, height }
    }

    /// The side crossed last on the way up.
    pub(super) fn last_side(&self, way: &Way) -> u16 {
        self.places[way.last][SIDE][way.lane] as u16
    }

    #[inline(always)]
    fn note<S: Simd>(&mut self, place: usize, [radius_m, height]: [f32x8<S>; 2], row: u32x8<S>, side: u32x8<S>) {
        let room = &mut self.places[place];
        (room[RADIUS], room[HEIGHT]) = (radius_m.to_bits().to_array(), height.to_bits().to_array());
        (room[ROW], room[SIDE]) = (row.to_array(), side.to_array());
    }

    /// Height at the end of a way, or where it goes out of reach. The places stay, so that no row within reach depends on
    /// how far it is.
    fn within_reach(&self, lane: usize, end: usize, before: usize, reach_m: f32) -> f32 {
        let [(inside_m, from), (outside_m, to)] =
            [before, end].map(|place| (of(&self.places[place], RADIUS, lane), of(&self.places[place], HEIGHT, lane)));
        if outside_m > reach_m && inside_m < reach_m {
            from + (to - from) * ((reach_m - inside_m) / (outside_m - inside_m))
        } else {
            to
        }
    }
}

/// One of a place's numbers.
#[inline(always)]
const fn of(place: &Place, what: usize, lane: usize) -> f32 {
    f32::from_bits(place[what][lane])
}

/// The rows of a way, from the first one to before the last, and the radii between which its facets lie there, m.
pub(super) struct Filled {
    pub(super) rows: (usize, usize),
    pub(super) radii_m: [f32; 2],
}

/// A facet from which half-planes are looked for, and the height in rows at which that is done.
#[derive(Clone, Copy)]
pub(super) struct Begin {
    pub(super) facet: u16,
    pub(super) height: f32,
}

/// What was met on a near side, from the lowest place to the highest.
pub(super) struct Way {
    lane: usize,
    first: usize,
    last: usize,
    /// Least radius, m, also between and beyond the rows.
    pub(super) nearest_m: f32,
}

/// A walk up or down in eight half-planes.
struct Going<S: Simd> {
    /// The sides through which facets are entered next, and those at which it began.
    at: [u32; LANES],
    first: u32x8<S>,
    /// Ends of the sides crossed last, at s ≤ 0 and beyond, and where those cross.
    before: Seen<S>,
    behind: Seen<S>,
    radius_m: f32x8<S>,
    height: f32x8<S>,
    /// How far it went: the number of places, the least radius, m, and the highest (lowest) place, in rows.
    places: i32x8<S>,
    nearest_m: f32x8<S>,
    outermost: f32x8<S>,
    /// Where anything more is wanted.
    walks: mask32x8<S>,
}

impl<S: Simd> Going<S> {
    #[inline(always)]
    fn new(
        simd: S,
        at: [u32; LANES],
        [before, behind]: [Seen<S>; 2],
        [radius_m, height]: [f32x8<S>; 2],
        walks: mask32x8<S>,
    ) -> Self {
        Self {
            at,
            first: u32x8::load_array(simd, at),
            before,
            behind,
            radius_m,
            height,
            places: i32x8::splat(simd, 0),
            nearest_m: radius_m,
            outermost: height,
            walks,
        }
    }

    #[inline(always)]
    fn goes(&self) -> bool {
        self.walks.any_true()
    }
}

/// Radius and height where sides cross their planes: always from their ends at s ≤ 0, so that the same side gives the same point.
#[inline(always)]
fn meet<S: Simd>([before, behind]: &[Seen<S>; 2]) -> [f32x8<S>; 2] {
    let share = before[0] / (before[0] - behind[0]);
    [before[1] + (behind[1] - before[1]) * share, before[2] + (behind[2] - before[2]) * share]
}

/// Adding 3·2²² leaves no place behind the point, so that the sum is rounded to a whole number in its last bits.
const WHOLE: f32 = 12_582_912.0;

/// As [`Slices::rows_below`], of one height.
#[inline(always)]
fn rows_below(height: f32, rows: f32) -> u32 {
    let within = if height < rows - 0.5 { height } else { rows - 0.5 };
    let within = if within > 0.0 { within } else { 0.0 } + 0.5;
    (within + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())
}
