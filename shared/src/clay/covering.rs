//! Collision of a narrow tool with sharp edges: along rays that go with the tool, each of which tells of parts of columns.
//!
//! Owns where the rays stand, and which columns they tell of; what a tool meets along one is found as on a column itself.
//! Invariant: as clay turns under a tool, or it goes on, every ray covers as much, and no column is covered by more than all of it.
//!
//! Looked at along its columns, clay would have a tool whose wall stands along one touch it from top to bottom in one tick and not in
//! the next: an edge half an element wide pressed with twice its force, and then with none.

use glam::Vec2;

use super::contact::{Contacts, Tally};
use super::faceted::{Cutter, Place, met};
use super::lanes::{LANES, Simd, root};
use super::{Press, Surface, Window};
use crate::tool::{Extent, Lattice, Pose, Ray, Shape, Side};

/// How many rays there are: as many as are cut at once.
const RAYS: usize = LANES;
/// Width from which on columns tell as well what a tool meets, in columns.
const WIDE: f32 = 8.0;
/// Columns and rows at which the clay about a tool is looked at for how far it goes, or one more.
const COLUMNS: u32 = 12;
const ROWS: usize = 24;
/// How many of those radii are compared at once.
const TURNS: usize = 8;

/// Radius of the widest clay about a tool outside, of the narrowest about one inside, m, as far as some of its elements tell. It bounds where rays
/// stand: what everybody knows of the whole pot is not the same everywhere, what is there is.
#[inline(always)]
fn reach_about_m(surface: &Surface, press: &Press, tool_m: f32, behind_m: f32) -> f32 {
    let (shape, centre_m) = (surface.shape(), press.centre_m);
    let distance_m = root(centre_m.x * centre_m.x + centre_m.y * centre_m.y);
    let half_rad = libm::asinf((tool_m / distance_m).min(1.0));
    let middle = libm::roundf(libm::atan2f(centre_m.y, centre_m.x) / shape.column_angle_rad()) as i64;
    let half_columns = ((half_rad / shape.column_angle_rad()) as u32).min(shape.columns() / 2);
    let last_row = (shape.rows() - 1) as f32;
    let row = |z_m: f32| (z_m / surface.row_height_m()).clamp(0.0, last_row) as u32;
    let (first_row, end_row) = (row(centre_m.z - tool_m), row(centre_m.z + tool_m) + 1);
    let columns_apart = (2 * half_columns) / COLUMNS + 1;
    let columns = (0..=2 * half_columns).step_by(columns_apart as usize);
    let columns_m =
        columns.map(|local| surface.column_m(shape.wrap(middle + i64::from(local) - i64::from(half_columns))));
    let last = (end_row - first_row - 1) as usize;
    let apart = last / ROWS + 1;
    // as many in any case, so that it is known how many there are
    let rows = core::array::from_fn(|number| first_row as usize + (number * apart).min(last / apart * apart));
    match press.side {
        Side::Outside => most(columns_m, &rows, 0.0, |radius_m, widest_m| radius_m > widest_m),
        Side::Inside => most(columns_m, &rows, f32::MAX, |radius_m, narrowest_m| radius_m < narrowest_m) - behind_m,
    }
}

/// Of the radii in some rows of columns that which is before all others, or the least there may be, m.
///
/// By turns into several, so that none waits for the one before; which of them is the most does not go by their order.
#[inline(always)]
fn most<'a>(
    columns_m: impl Iterator<Item = &'a [f32]>,
    rows: &[usize; ROWS],
    least_m: f32,
    is_before: impl Fn(f32, f32) -> bool,
) -> f32 {
    let before = |one_m: f32, other_m: f32| if is_before(one_m, other_m) { one_m } else { other_m };
    let mut most_m = [least_m; TURNS];
    for column_m in columns_m {
        for rows in rows.as_chunks::<TURNS>().0 {
            for (most_m, row) in most_m.iter_mut().zip(rows) {
                *most_m = before(column_m[*row], *most_m);
            }
        }
    }
    most_m.into_iter().fold(least_m, before)
}

impl Contacts {
    /// Finds the elements that a convex tool with sharp edges touches, as [`Contacts::gather_facets`] does, unless it has none or is
    /// wide, or none of it is in reach: whether it was looked at.
    #[inline(always)]
    pub(super) fn gather_narrow<S: Simd>(
        &mut self,
        simd: S,
        surface: &Surface,
        press: &Press,
        shape: Shape,
        [behind_m, reach_m]: [f32; 2],
        cutter: &mut Cutter,
    ) -> bool {
        let Cutter { rack, sections } = cutter;
        let Some(tool) = rack.get(usize::from(shape.0)).filter(|tool| tool.is_sharp()) else { return false };
        let pose = Pose { centre_m: press.centre_m, orientation: press.orientation };
        let (sides, reach_m) = met(press.side, reach_m);
        let column_rad = surface.shape().column_angle_rad();
        let reach_about_m = reach_about_m(surface, press, tool.radius().0, behind_m);
        let ends_rad = tool.ends_rad(simd, &pose, reach_about_m, sides, WIDE * column_rad);
        let (Some([begin_rad, end_rad]), Some(turn)) = (ends_rad, pose.turn()) else { return false };
        let width = (end_rad - begin_rad) / column_rad;
        self.stand(press, tool);
        let ray_rad = (end_rad - begin_rad) / RAYS as f32;
        let angle_rad = |ray: u32| begin_rad + (ray as f32 + 0.5) * ray_rad;
        let mut directions = [Vec2::ZERO; RAYS];
        for (ray, direction) in (0..).zip(&mut directions) {
            let (sin, cos) = libm::sincosf(self.angle_rad + angle_rad(ray));
            *direction = Vec2::new(cos, sin);
        }
        let rows = surface.shape().rows();
        let lattice = Lattice { directions: &directions, rows, row_height_m: surface.row_height_m() };
        sections.cut_rays(simd, tool, &pose, &lattice, reach_m, sides);
        let Extent { first_row, rows: rows_cut, .. } = sections.extent();
        if rows_cut == 0 {
            return true;
        }
        // in columns, round the pot
        let begin = (self.angle_rad + begin_rad) / column_rad;
        let [first, last] = [begin, begin + width].map(|end| libm::roundf(end) as i64);
        let (first_column, columns) = (surface.shape().wrap(first), (last - first) as u32 + 1);
        self.window = Window { first_column, columns, first_row, rows: rows_cut }.aligned(rows, LANES as u32);
        self.fill_heights(simd, rows, surface.row_height_m(), press.centre_m.z);
        let mut tally = Tally::new(simd);
        let per_ray = width / RAYS as f32;
        for section in sections.eights() {
            let ray = section.column;
            let direction = directions[ray as usize].to_array();
            let along = Ray::new(tool, &turn, press.centre_m, direction, (sides, section.bound_m));
            let [from, to] = [ray, ray + 1].map(|end| begin + end as f32 * per_ray);
            for column in libm::roundf(from) as i64..=libm::roundf(to) as i64 {
                let middle = column as f32;
                let share = to.min(middle + 0.5) - from.max(middle - 0.5);
                if share > 0.0 {
                    let column = surface.shape().wrap(column);
                    let place = Place { column, share, angle_rad: angle_rad(ray), direction };
                    let met = (&section, &along);
                    self.gather_section::<S, true, _>(simd, &mut &*surface, met, &place, behind_m, &mut tally);
                }
            }
        }
        self.take(&tally);
        true
    }
}
