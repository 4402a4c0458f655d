//! A look at a wide contact along few rays, where one at all elements would find thousands of which few are left.
//!
//! Owns where the rays stand; what a tool meets there is found as on the elements themselves.
//! Invariant: rays and heights stand still as seen from the tool, so that what is seen has no ripples where clay turns under it or it climbs.

use alloc::vec::Vec;
use core::ops::Range;

use glam::{Vec2, Vec3};

use super::ball::Ball;
use super::contact::{Column, Contacts, Ground, Tally, nearest_turn};
use super::ellipse::Step;
use super::faceted::Cutter;
use super::lanes::{LANES, Simd, root};
use super::surface::directions;
use super::{GridShape, Press, Surface, Window};
use crate::tool::{Lattice, Pose, Side, Tool};

/// How many there are, all round the axis, and how far apart what is looked at on one of them is at most, m.
const RAYS: u32 = 128;
const RAY_RAD: f32 = core::f32::consts::TAU / RAYS as f32;
const APART_M: f32 = 0.002;
/// Cosine of half the angle of a ball's contact from which on it is wide; a narrower one loads a wall from one side.
const WIDE: f32 = 0.94;
/// Fewest rays that tell of a contact, and fewest heights on each: of a rim they would tell where they lie.
const RAYS_MIN: usize = 8;
const HEIGHTS_MIN: u32 = 8;
/// Radius that stands for rows where there is no clay, m: no tool inside reaches it.
const NO_CLAY_M: f32 = 1e3;

/// The rays' directions as a tool at angle zero sees them, and the radii of the clay on one of them, m.
#[derive(Clone, Debug, Default)]
pub(super) struct Rays {
    directions: Vec<Vec2>,
    radii_m: Vec<f32>,
}

impl Rays {
    /// Those for a grid; none where they would be hardly fewer than its columns.
    pub(super) fn with_room(shape: GridShape) -> Self {
        if !are_fewer(shape) {
            return Self::default();
        }
        Self { directions: directions(RAYS).to_vec(), radii_m: Vec::with_capacity(shape.rows() as usize) }
    }
}

/// Whether rays are much fewer than the columns of a grid.
const fn are_fewer(shape: GridShape) -> bool {
    shape.columns() >= 2 * RAYS
}

/// The heights at which clay is looked at: a whole number of them lies between a tool and the first.
#[derive(Clone, Copy)]
struct Heights {
    /// Every so many rows, from one on that may lie below the first there is.
    stride: i64,
    first_row: i64,
    count: u32,
    apart_m: f32,
    /// How far above the first the tool is, m.
    tool_m: f32,
}

impl Heights {
    /// For a tool at a height above the foot, m; none where they would be the rows.
    fn of(surface: &Surface, tool_z_m: f32) -> Option<Self> {
        let (rows, row_m) = (surface.shape().rows(), surface.row_height_m());
        let stride = (APART_M / row_m) as i64;
        if stride < 2 {
            return None;
        }
        let apart_m = stride as f32 * row_m;
        let tool_m = libm::roundf(tool_z_m / apart_m) * apart_m;
        let first_row = libm::roundf((tool_z_m - tool_m) / row_m) as i64;
        Some(Self { stride, first_row, count: (rows - 1) / stride as u32 + 2, apart_m, tool_m })
    }

    /// Radii of a column at some of them, m.
    fn read(&self, column_m: &[f32], heights: Range<u32>, radii_m: &mut Vec<f32>) {
        radii_m.clear();
        radii_m.extend(heights.map(|number| {
            let row = usize::try_from(i64::from(number) * self.stride + self.first_row);
            row.ok().and_then(|row| column_m.get(row)).copied().unwrap_or(NO_CLAY_M)
        }));
    }
}

/// How far apart what was looked at is, and the tool's angle, rad.
pub(super) struct Glance {
    pub(super) step: Step,
    pub(super) angle_rad: f32,
}

/// Clay along the rays of a tool at an angle, rad.
struct Seen<'a> {
    surface: &'a Surface,
    heights: Heights,
    directions: &'a [Vec2],
    angle_rad: f32,
    radii_m: &'a mut Vec<f32>,
}

impl Ground for Seen<'_> {
    fn lattice(&self) -> Lattice<'_> {
        Lattice { directions: self.directions, rows: self.heights.count, row_height_m: self.heights.apart_m }
    }

    fn column_rad(&self) -> f32 {
        RAY_RAD
    }

    fn radii_m(&mut self, column: u32, rows: Range<u32>) -> &[f32] {
        let nearest = column_at(self.surface, self.angle_rad + nearest_turn(column as f32 * RAY_RAD));
        self.heights.read(self.surface.column_m(nearest), rows, self.radii_m);
        self.radii_m
    }
}

/// The column nearest to an angle, rad.
fn column_at(surface: &Surface, angle_rad: f32) -> u32 {
    surface.shape().wrap(libm::roundf(angle_rad / surface.shape().column_angle_rad()) as i64)
}

impl Contacts {
    /// Finds along few rays what a tool inside touches, as if it were at angle zero; nothing where a contact is narrow or low, so that
    /// [`Contacts::gather`] is to be asked.
    #[inline(always)]
    pub(super) fn glance<S: Simd>(
        &mut self,
        simd: S,
        surface: &Surface,
        press: &Press,
        behind_m: f32,
        cutter: Option<&mut Cutter>,
    ) -> Option<Glance> {
        let heights = Heights::of(surface, press.centre_m.z)?;
        // by the clay's own grid, which may be coarser than what there is room for
        let has_rays = are_fewer(surface.shape()) && !self.rays.directions.is_empty();
        if press.side == Side::Outside || !has_rays {
            return None;
        }
        let tool_m = match press.tool {
            Tool::Sphere(sphere) => sphere.radius().0,
            Tool::Convex(shape) => cutter.as_ref()?.tool(shape)?.radius().0,
        };
        let Vec3 { x, y, z } = press.centre_m;
        let (distance_m, angle_rad) = (root(x * x + y * y), libm::atan2f(y, x));
        let row = libm::roundf(z / surface.row_height_m()).clamp(0.0, (surface.shape().rows() - 1) as f32);
        let clay_m = surface.column_m(column_at(surface, angle_rad))[row as usize] - behind_m;
        // where a ball meets clay round it, by the law of cosines
        if clay_m * clay_m + distance_m * distance_m - tool_m * tool_m >= 2.0 * WIDE * clay_m * distance_m {
            return None;
        }
        self.begin::<true>(press);
        (self.distance_m, self.angle_rad, self.tool_m) = (distance_m, 0.0, tool_m);
        let mut rays = core::mem::take(&mut self.rays);
        let Rays { directions, radii_m } = &mut rays;
        let mut ground = Seen { surface, heights, directions, angle_rad, radii_m };
        let orientation = Pose::about_z(press.orientation, f64::from(-angle_rad));
        let seen = Press { centre_m: Vec3::new(distance_m, 0.0, heights.tool_m), orientation, ..*press };
        let limits_m = [behind_m, surface.narrowest_m() - behind_m - 1e-6];
        match (press.tool, cutter) {
            (Tool::Convex(shape), Some(cutter)) => {
                self.gather_facets::<S, true, _>(simd, &mut ground, &seen, shape, limits_m, cutter);
            }
            _ => self.gather_ball(simd, &mut ground, &seen, limits_m),
        }
        self.rays = rays;
        let rays = self.columns().len();
        let is_told = rays >= RAYS_MIN && self.elements >= HEIGHTS_MIN * rays as u32;
        is_told.then(|| Glance { step: Step::new(RAY_RAD, heights.apart_m), angle_rad })
    }

    /// Finds what a sphere inside touches of clay along rays, none of which is narrower than the reach, m.
    #[inline(always)]
    fn gather_ball<S: Simd>(&mut self, simd: S, ground: &mut Seen<'_>, press: &Press, [behind_m, reach_m]: [f32; 2]) {
        let (tool_m, centre_m, Heights { count, apart_m, .. }) = (self.tool_m, press.centre_m, ground.heights);
        let first = libm::ceilf((centre_m.z - tool_m) / apart_m).max(0.0) as u32;
        let end = libm::ceilf((centre_m.z + tool_m) / apart_m).clamp(0.0, count as f32) as u32;
        if first >= end {
            return;
        }
        self.window = Window { first_row: first, rows: end - first, ..Window::default() }.aligned(count, LANES as u32);
        self.fill_heights(simd, count, apart_m, centre_m.z);
        let chunks = 0..self.window.rows.div_ceil(LANES as u32);
        let rows = self.window.first_row..self.window.first_row + chunks.end * LANES as u32;
        let ball = Ball { tool_m, side: press.side, behind_m };
        let mut tally = Tally::new(simd);
        for ray in 0..RAYS {
            let direction = ground.directions[ray as usize];
            let (along_m, aside_m) = (direction.dot(centre_m.truncate()), direction.perp_dot(centre_m.truncate()));
            let half_chord_m2 = tool_m * tool_m - aside_m * aside_m;
            if half_chord_m2 <= 0.0 || along_m + root(half_chord_m2) <= reach_m {
                continue;
            }
            let angle_rad = nearest_turn(ray as f32 * RAY_RAD);
            let column =
                Column::new(ray, self.window, chunks.clone(), angle_rad, direction.to_array(), [along_m, aside_m]);
            self.add_ball(&ball, &column, ground.radii_m(ray, rows.clone()), &mut tally);
        }
        self.take(&tally);
    }
}
