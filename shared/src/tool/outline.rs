//! The outline of a convex tool in one half-plane: the walk over the facets that the half-plane crosses.
//!
//! Owns the walk and the rows that it passes; which half-planes are looked at is `section.rs`.
//! Invariant: every place met is a point of a side of the mesh, so that nothing lies outside of the tool, and the walk
//! ends after one round at most.

use alloc::vec::Vec;

use glam::{Mat3, Vec2, Vec3, Vec4};

use super::ConvexTool;
use super::facets::Link;

/// How far a way may turn back before it counts as turned, m: twice what a convex tool's corners may stand out.
const SLACK_M: f32 = 2.0 * ConvexTool::BULGE_MAX.0;
/// Least rise over which a slope is taken, as a share of all rows. A height in rows is exact to 2⁻²³ of them, so that no
/// row is led beyond the ends of its facet by more than a sixteenth.
const RISE_MIN: f32 = 1.0 / 524_288.0;

/// The tool seen from within one half-plane: lanes are the distance s aside of it, towards rising angle, m; the radius r
/// along it, m; and the height in rows.
pub(super) struct Slice<'a> {
    tool: &'a ConvexTool,
    corners_m: &'a [Vec4],
    links: &'a [Link],
    x: Vec4,
    y: Vec4,
    z: Vec4,
    centre: Vec4,
    rows: f32,
    slack_rows: f32,
    reach_m: f32,
}

impl<'a> Slice<'a> {
    /// A tool turned about its centre and set down there, in the half-plane along `direction` from the axis.
    pub(super) fn new(
        tool: &'a ConvexTool,
        (turn, centre_m): (&Mat3, Vec3),
        direction: Vec2,
        (rows, rows_per_m): (u32, f32),
        reach_m: f32,
    ) -> Self {
        let (cos, sin) = (direction.x, direction.y);
        let seen = |vector: Vec3| {
            let (aside, along) = (cos * vector.y - sin * vector.x, cos * vector.x + sin * vector.y);
            Vec4::new(aside, along, vector.z * rows_per_m, 0.0)
        };
        Self {
            tool,
            corners_m: tool.corners_m(),
            links: tool.links(),
            x: seen(turn.x_axis),
            y: seen(turn.y_axis),
            z: seen(turn.z_axis),
            centre: seen(centre_m),
            rows: rows as f32,
            slack_rows: SLACK_M * rows_per_m,
            reach_m,
        }
    }

    /// A corner's lanes.
    #[inline(always)]
    pub(super) fn see(&self, corner: u16) -> Vec4 {
        let corner = self.corners_m[usize::from(corner)];
        let (x, y, z) = (Vec4::splat(corner.x), Vec4::splat(corner.y), Vec4::splat(corner.z));
        // in pairs: the next step waits for this sum
        (self.x * x + self.y * y) + (self.z * z + self.centre)
    }

    /// A side that crosses the plane, found from `side` on; none when the plane passes the tool by.
    pub(super) fn crossing(&self, side: u16) -> Option<Crossing> {
        let tool = self.tool;
        let (from, to) = (self.see(tool.origin(side)), self.see(tool.end(side)));
        match (from.x > 0.0, to.x > 0.0) {
            (false, true) => return Some(Crossing { side, ends: [from, to] }),
            (true, false) => return Some(Crossing { side: tool.twin(side), ends: [to, from] }),
            _ => {}
        }
        let sense = if from.x > 0.0 { -1.0 } else { 1.0 };
        let side = self.cross(if from.x * sense > to.x * sense { side } else { tool.twin(side) }, sense)?;
        let side = if sense > 0.0 { side } else { tool.twin(side) };
        Some(Crossing { side, ends: [self.see(tool.origin(side)), self.see(tool.end(side))] })
    }

    /// Climbs from where `side` begins along s (or against it) until a side crosses the plane.
    fn cross(&self, mut side: u16, sense: f32) -> Option<u16> {
        let tool = self.tool;
        let mut farthest = self.see(tool.origin(side)).x * sense;
        loop {
            let (first, mut next) = (side, None);
            loop {
                let link = tool.link(side);
                let aside = self.see(link.apex).x;
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
    fn onto_near_side(&self, crossing: &Crossing) -> Option<Crossing> {
        let (mut walker, _) = Walker::pair(self, crossing, 0);
        let mut lowest = walker.outermost;
        loop {
            let height = walker.step::<true>(self).z;
            lowest = lesser(lowest, height);
            if height > lowest + self.slack_rows {
                return Some(Crossing { side: self.tool.twin(walker.at), ends: walker.ends });
            }
            if walker.at == walker.first {
                return None;
            }
        }
    }

    /// Walks up and down the near side from a crossed side; none when the section is too thin to have one.
    pub(super) fn walk(&self, mut crossing: Crossing, outline: &mut Outline) -> Option<Way> {
        let middle = outline.radius_m.len() / 2;
        for _ in 0..2 {
            let (mut up, mut down) = Walker::pair(self, &crossing, middle);
            let begun = up.outermost;
            outline.note(middle, up.nearest_m, begun, up.at);
            while up.walks || down.walks {
                if up.walks {
                    up.advance::<true>(self, outline);
                }
                if down.walks {
                    down.advance::<false>(self, outline);
                }
            }
            if up.outermost - begun > self.slack_rows || begun - down.outermost > self.slack_rows {
                return Some(Way {
                    first: down.place,
                    last: up.place,
                    nearest_m: lesser(down.nearest_m, up.nearest_m),
                    last_side: up.at,
                });
            }
            // that was the far side
            crossing = self.onto_near_side(&crossing)?;
        }
        None
    }

    /// Writes the rows between the places met on a way; which they are.
    pub(super) fn fill(
        &self,
        way: &Way,
        outline: &mut Outline,
        radius_m: &mut [f32],
        facet: &mut [u16],
    ) -> (usize, usize) {
        let (mut first, mut last) = (way.first, way.last);
        // the way ends where it turned
        while last > first && outline.height[last] <= outline.height[last - 1] {
            last -= 1;
        }
        while last > first && outline.height[first] >= outline.height[first + 1] {
            first += 1;
        }
        if first == last {
            return (0, 0);
        }
        let (lowest, highest) =
            (outline.within_reach(first, first + 1, self.reach_m), outline.within_reach(last, last - 1, self.reach_m));
        let (first_row, end_row) = (rows_below(lowest, self.rows), rows_below(highest, self.rows));
        if first_row >= end_row {
            return (0, 0);
        }
        let radii = &outline.radius_m[first..=last];
        let heights = &outline.height[first..=last];
        let sides = &outline.side[first..=last];
        let slopes = &mut outline.slope_m[first..=last];
        let rise_min = RISE_MIN * self.rows;
        let pieces = slopes.iter_mut().zip(radii.windows(2).zip(heights.windows(2)));
        for (number, (slope_m, (radii, heights))) in pieces.enumerate() {
            *slope_m = (radii[1] - radii[0]) / greater(heights[1] - heights[0], rise_min);
            // the last place at or below a row is the one that counts
            let row = rows_below(heights[0], self.rows).clamp(first_row, end_row);
            outline.begun[row as usize] = number as u32;
        }
        let (first_row, end_row) = (first_row as usize, end_row as usize);
        let rows = radius_m[first_row..end_row].iter_mut().zip(&mut facet[first_row..end_row]);
        let mut number = 0;
        for (row, ((radius_m, facet), begun)) in (first_row as i32..).zip(rows.zip(&mut outline.begun[first_row..])) {
            number = number.max(core::mem::take(begun) as usize);
            *radius_m = radii[number] + (row as f32 - heights[number]) * slopes[number];
            *facet = sides[number] / 3;
        }
        outline.begun[end_row] = 0;
        (first_row, end_row)
    }
}

/// Where a section's outline passes from one facet to the next, from the lowest place to the highest: the first that is
/// met stands in the middle.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    radius_m: Vec<f32>,
    /// In rows.
    height: Vec<f32>,
    /// The side through which the facet above is entered.
    side: Vec<u16>,
    /// Radius gained with every row from here on, m.
    slope_m: Vec<f32>,
    /// For every row of a column, the last place at or below it, counted from the lowest one; zero between columns.
    begun: Vec<u32>,
}

impl Outline {
    /// Makes room for a way once round any tool, and for a column.
    pub(super) fn make_room(&mut self, rows: usize) {
        let places = 2 * ConvexTool::TRIANGLES_MAX + 1;
        (self.radius_m, self.height) = (alloc::vec![0.0; places], alloc::vec![0.0; places]);
        (self.side, self.slope_m) = (alloc::vec![0; places], alloc::vec![0.0; places]);
        self.begun = alloc::vec![0; rows + 1];
    }

    /// Whether there is room for a column of so many rows.
    pub(super) const fn has_room(&self, rows: usize) -> bool {
        self.begun.len() > rows
    }

    /// A side crossed about half way.
    pub(super) fn middle_side(&self, way: &Way) -> u16 {
        self.side[(way.first + way.last) / 2]
    }

    /// Whether there was room for it.
    #[inline(always)]
    fn note(&mut self, place: usize, radius_m: f32, height: f32, side: u16) -> bool {
        let is_inside = place < self.radius_m.len() && place < self.height.len() && place < self.side.len();
        if is_inside {
            self.radius_m[place] = radius_m;
            self.height[place] = height;
            self.side[place] = side;
        }
        is_inside
    }

    /// Height at the end of a way, or where it goes out of reach. The places stay, so that no row within reach depends on
    /// how far it is.
    fn within_reach(&self, end: usize, before: usize, reach_m: f32) -> f32 {
        let (inside_m, outside_m) = (self.radius_m[before], self.radius_m[end]);
        if outside_m > reach_m && inside_m < reach_m {
            let share = (reach_m - inside_m) / (outside_m - inside_m);
            self.height[before] + (self.height[end] - self.height[before]) * share
        } else {
            self.height[end]
        }
    }
}

/// A side that crosses a plane, from s ≤ 0 to s > 0, and its ends.
pub(super) struct Crossing {
    side: u16,
    ends: [Vec4; 2],
}

/// What was met on a near side, from the lowest place to the highest.
pub(super) struct Way {
    first: usize,
    last: usize,
    /// Least radius, m, also between and beyond the rows.
    pub(super) nearest_m: f32,
    /// The side crossed last on the way up.
    pub(super) last_side: u16,
}

fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Goes round a section from one crossed side to the next.
struct Walker {
    /// The side through which the next facet is entered, and the first one.
    at: u16,
    first: u16,
    /// The ends of the side crossed last: at s ≤ 0 and at s > 0.
    ends: [Vec4; 2],
    /// Number of the last place met.
    place: usize,
    /// Highest (lowest) place so far, in rows.
    outermost: f32,
    nearest_m: f32,
    walks: bool,
}

impl Walker {
    /// One that goes up from a crossed side, and one that goes down.
    #[inline(always)]
    fn pair(slice: &Slice<'_>, crossing: &Crossing, place: usize) -> (Self, Self) {
        let met = meet(&crossing.ends);
        let (ends, outermost, nearest_m) = (crossing.ends, met.z, met.y);
        let from = |at| Self { at, first: at, ends, place, outermost, nearest_m, walks: true };
        // outside of the facet that the side belongs to is the next one up
        (from(slice.tool.twin(crossing.side)), from(crossing.side))
    }

    /// Through one facet, without a branch, to where it is left.
    #[inline(always)]
    fn step<const UP: bool>(&mut self, slice: &Slice<'_>) -> Vec4 {
        let link = &slice.links[usize::from(self.at)];
        let apex = slice.see(link.apex);
        // the apex takes the place of the end on its own side
        let aside = usize::from(apex.x > 0.0);
        self.ends[aside] = apex;
        self.at = link.onward[if UP { aside } else { 1 - aside }];
        meet(&self.ends)
    }

    /// Through one facet, noting where it is left.
    #[inline(always)]
    fn advance<const UP: bool>(&mut self, slice: &Slice<'_>, outline: &mut Outline) {
        let entered = self.at;
        let left = self.step::<UP>(slice);
        let (radius_m, height) = (left.y, left.z);
        let place = if UP { self.place + 1 } else { self.place.wrapping_sub(1) };
        // there is room for every facet each way
        if !outline.note(place, radius_m, height, if UP { self.at } else { entered }) {
            self.walks = false;
            return;
        }
        self.place = place;
        self.nearest_m = lesser(radius_m, self.nearest_m);
        self.outermost = if UP { greater(height, self.outermost) } else { lesser(height, self.outermost) };
        let has_turned =
            if UP { height < self.outermost - slice.slack_rows } else { height > self.outermost + slice.slack_rows };
        // once it recedes it goes on receding
        let has_left = radius_m > greater(self.nearest_m + SLACK_M, slice.reach_m);
        self.walks = !(has_turned | has_left | (self.at == self.first));
    }
}

/// Where a side crosses the plane: always from its end at s ≤ 0, so that the same side gives the same point.
#[inline(always)]
fn meet(ends: &[Vec4; 2]) -> Vec4 {
    let [before, behind] = ends;
    *before + (*behind - *before) * Vec4::splat(before.x / (before.x - behind.x))
}

/// Number of rows whose height is below `height`, or at it, from none to all; without a call to round.
#[inline(always)]
fn rows_below(height: f32, rows: f32) -> u32 {
    // adding 3·2²² leaves no place behind the point, so that the sum is rounded to a whole number in its last bits
    const WHOLE: f32 = 12_582_912.0;
    let within = greater(lesser(height, rows - 0.5), 0.0) + 0.5;
    (within + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())
}
