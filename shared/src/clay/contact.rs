//! Collision of a sphere with the circular sector elements: which are touched, and how deep.
//!
//! Shared by all methods; what a touch does to the clay is theirs.
//! Invariant: only rows and columns within the sphere's reach are visited, and every touched element stands in exactly
//! one chunk.

use alloc::vec::Vec;

use glam::Vec3;
use wide::f32x8;

use super::faceted::Cutter;
use super::{Press, Surface, Window};
use crate::tool::{Side, Tool};

/// Elements worked on at once. The lanes are written out, so that their sums are the same whatever the machine offers.
pub(super) const LANES: usize = 8;

/// Eight neighbouring elements of a column, of which the tool touches at least one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    /// Column in the grid, and row of the first lane: a multiple of [`LANES`].
    pub(super) column: u32,
    pub(super) row: u32,
    /// Angle from the tool to the column, rad.
    pub(super) angle_rad: f32,
    /// Direction of the column's ray.
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// The tool's centre along the ray and across it, m.
    pub(super) along_m: f32,
    pub(super) aside_m: f32,
    /// Depth p of the tool in the clay, m; zero where it does not touch.
    pub(super) penetration_m: f32x8,
    /// Half the length of the ray within the sphere, m; zero where it does not touch, and for a tool of facets.
    pub(super) half_chord_m: f32x8,
    /// Radius r of the elements, m.
    pub(super) radius_m: f32x8,
    /// Height above the tool's centre, m; infinite beyond the rim.
    pub(super) above_m: f32x8,
}

impl Chunk {
    /// All bits set where the tool touches.
    pub(super) fn touched(&self) -> f32x8 {
        self.penetration_m.simd_gt(f32x8::ZERO)
    }
}

/// The touched elements of one press.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    pub(super) chunks: Vec<Chunk>,
    /// Distance of the tool from the axis, m, and its angle, rad.
    pub(super) distance_m: f32,
    pub(super) angle_rad: f32,
    /// Number of touched elements, and the window that holds them.
    pub(super) elements: u32,
    pub(super) window: Window,
    /// Largest penetration, m.
    pub(super) deepest_m: f32,
    /// How far the tool reaches from its centre, m.
    pub(super) tool_m: f32,
    /// Which way the clay pushes, chunk by chunk, along the ray, across it and up; none for a sphere.
    pub(super) facing: Vec<[f32x8; 3]>,
    /// Heights of the window's rows above the tool's centre, m.
    pub(super) above_m: Vec<f32x8>,
}

impl Contacts {
    /// Room for any press on `elements` elements.
    pub(super) fn with_room(elements: usize) -> Self {
        Self {
            chunks: Vec::with_capacity(elements / LANES + 1),
            above_m: Vec::with_capacity(elements / LANES + 1),
            facing: Vec::with_capacity(elements / LANES + 1),
            ..Self::default()
        }
    }

    /// Finds the elements that `press` touches, `behind_m` inside of the surface's radii; of a convex tool those that one of
    /// `cutter`'s does.
    pub(super) fn gather(&mut self, surface: &Surface, press: &Press, behind_m: f32, cutter: Option<&mut Cutter>) {
        self.chunks.clear();
        self.above_m.clear();
        self.facing.clear();
        (self.elements, self.deepest_m, self.window) = (0, 0.0, Window::default());
        match (press.tool, cutter) {
            (Tool::Sphere(sphere), _) => {
                self.tool_m = sphere.radius().0;
                self.gather_sphere(surface, press, behind_m);
            }
            (Tool::Convex(shape), Some(cutter)) => self.gather_facets(surface, press, shape, behind_m, cutter),
            (Tool::Convex(_), None) => {}
        }
    }

    /// With a sphere (radius R) at H and an element (r, θ, z), `b = H·(cosθ, sinθ)`, `a` the tool's distance from the ray's
    /// plane, `h = √(R² − a² − (z − H_z)²)` half the ray's length in the sphere: the ray meets the sphere at `s₁,₂ = b ∓ h`.
    /// From outside the penetration is `p = r − s₁`, at most r; from inside `p = s₂ − r`.
    fn gather_sphere(&mut self, surface: &Surface, press: &Press, behind_m: f32) {
        let reach = Reach::of(surface, press.centre_m, self.tool_m);
        (self.distance_m, self.angle_rad, self.window) = (reach.distance_m, reach.angle_rad, reach.window);
        let window = reach.window;
        if window.is_empty() {
            return;
        }
        let (centre, radius_m) = (press.centre_m, self.tool_m);
        self.fill_heights(surface, centre.z);
        let mut deepest = f32x8::ZERO;
        let half_columns = (window.columns / 2) as i32;
        let whole_ring = window.columns == surface.shape().columns();
        for (local, column) in window.grid_columns(surface.shape()).enumerate() {
            let [cos, sin] = surface.direction(column);
            let (along_m, aside_m) = (centre.x * cos + centre.y * sin, centre.y * cos - centre.x * sin);
            let reach_squared = radius_m * radius_m - aside_m * aside_m;
            if reach_squared <= 0.0 {
                continue;
            }
            let angle_rad = if whole_ring {
                nearest_turn(column as f32 * surface.shape().column_angle_rad() - reach.angle_rad)
            } else {
                (local as i32 - half_columns) as f32 * surface.shape().column_angle_rad() - reach.off_column_rad
            };
            let at = Ray { column, angle_rad, cos, sin, along_m, aside_m, reach_squared, reach_m: radius_m };
            self.gather_column(surface, press, behind_m, &at, &mut deepest);
        }
        self.deepest_m = deepest.to_array().into_iter().fold(0.0, f32::max);
    }

    /// Finds the element nearest to a tool that is smaller than an element and presses between the middles of all: it is
    /// touched by as much as the tool reaches beyond its radius.
    pub(super) fn gather_nearest(&mut self, surface: &Surface, press: &Press, behind_m: f32) {
        let tool_m = self.tool_m;
        let reach = Reach::of(surface, press.centre_m, tool_m);
        let column_rad = surface.shape().column_angle_rad();
        if tool_m > surface.row_height_m().max(column_rad * reach.distance_m) {
            return;
        }
        let row = libm::roundf(press.centre_m.z / surface.row_height_m());
        if row < 0.0 || row >= surface.shape().rows() as f32 {
            return;
        }
        let column = surface.shape().wrap(libm::roundf(reach.angle_rad / column_rad) as i64);
        let radius_m = surface.column_m(column)[row as usize];
        let penetration_m = match press.side {
            Side::Outside => (radius_m - reach.distance_m + tool_m).min(radius_m),
            Side::Inside => reach.distance_m + tool_m - (radius_m - behind_m),
        };
        if penetration_m <= 0.0 || penetration_m > 2.0 * tool_m {
            return;
        }
        let first_row = row as u32 / LANES as u32 * LANES as u32;
        let only = |value: f32, elsewhere: f32| {
            let mut lanes = [elsewhere; LANES];
            lanes[row as usize % LANES] = value;
            f32x8::new(lanes)
        };
        let [cos, sin] = surface.direction(column);
        (self.elements, self.deepest_m) = (1, penetration_m);
        self.window = Window { first_column: column, columns: 1, first_row, rows: LANES as u32 };
        self.window.rows = self.window.rows.min(surface.shape().rows() - first_row);
        self.chunks.push(Chunk {
            column,
            row: first_row,
            angle_rad: -reach.off_column_rad,
            cos,
            sin,
            along_m: reach.distance_m,
            aside_m: 0.0,
            penetration_m: only(penetration_m, 0.0),
            half_chord_m: only(tool_m, 0.0),
            radius_m: only(radius_m, 0.0),
            above_m: only(0.0, f32::INFINITY),
        });
    }

    pub(super) fn fill_heights(&mut self, surface: &Surface, tool_z: f32) {
        let row_height_m = surface.row_height_m();
        let lanes = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        for row in (self.window.first_row..self.window.end_row()).step_by(LANES) {
            let rows = f32x8::splat(row as f32) + lanes;
            let above = rows * row_height_m - tool_z;
            let within = rows.simd_lt(f32x8::splat(surface.shape().rows() as f32));
            self.above_m.push(within.bitselect(above, f32x8::splat(f32::INFINITY)));
        }
    }

    /// Forgets the chunks that are not wanted.
    pub(super) fn keep(&mut self, wanted: impl Fn(&Chunk) -> bool) {
        let mut kept = 0;
        for number in 0..self.chunks.len() {
            if wanted(&self.chunks[number]) {
                self.chunks.swap(kept, number);
                if !self.facing.is_empty() {
                    self.facing.swap(kept, number);
                }
                kept += 1;
            }
        }
        self.chunks.truncate(kept);
        self.facing.truncate(kept);
    }

    /// The rows less than `half_m` above or below the tool, from a multiple of [`LANES`] on, and the row after them.
    fn rows_within(&self, half_m: f32, surface: &Surface, tool_z: f32) -> (usize, usize) {
        let row = |z_m: f32| (z_m / surface.row_height_m()).max(0.0) as u32;
        let first = row(tool_z - half_m).saturating_sub(1) / LANES as u32 * LANES as u32;
        let end = (row(tool_z + half_m) + 2).next_multiple_of(LANES as u32);
        let (lowest, highest) = (self.window.first_row, self.window.end_row());
        (first.clamp(lowest, highest) as usize, end.clamp(lowest, highest) as usize)
    }

    fn gather_column(&mut self, surface: &Surface, press: &Press, behind_m: f32, at: &Ray, deepest: &mut f32x8) {
        let (side, tool_z) = (press.side, press.centre_m.z);
        // no clay is wider, so that rows farther up or down cannot be met; a hair wider, since two that know another widest
        // radius must find the same
        let apart_m = (at.along_m - surface.widest_m() - 1e-6).max(0.0);
        let chord_squared = at.reach_squared - apart_m * apart_m;
        if side == Side::Outside && chord_squared <= 0.0 {
            return;
        }
        let (first, end) = match side {
            Side::Outside => self.rows_within(libm::sqrtf(chord_squared), surface, tool_z),
            Side::Inside => (self.window.first_row as usize, self.window.end_row() as usize),
        };
        let skipped = (first - self.window.first_row as usize) / LANES;
        let (radii, last) = surface.column_m(at.column)[first..end].as_chunks::<LANES>();
        let last = (!last.is_empty()).then(|| load(last).to_array());
        let along = f32x8::splat(at.along_m);
        for ((number, lanes), &above) in radii.iter().chain(&last).enumerate().zip(&self.above_m[skipped..]) {
            let radius = f32x8::new(*lanes);
            let discriminant = f32x8::splat(at.reach_squared) - above * above;
            // how far the tool's centre is on its own side of the wall
            let beyond = match side {
                Side::Outside => along - radius,
                Side::Inside => radius - behind_m - along,
            };
            let near = beyond.simd_lt(f32x8::ZERO) | (beyond * beyond).simd_lt(discriminant);
            let touched = discriminant.simd_gt(f32x8::ZERO) & near;
            if !touched.any() {
                continue;
            }
            let half_chord = (discriminant & touched).sqrt();
            let mut penetration = (half_chord - beyond) & touched;
            if side == Side::Outside && at.along_m < at.reach_m {
                // the tool holds the axis, beyond which there is no clay of this ray
                penetration = penetration.fast_min(radius) & (along + half_chord).simd_gt(f32x8::ZERO);
            }
            penetration = penetration.fast_max(f32x8::ZERO);
            let met = penetration.simd_gt(f32x8::ZERO).to_bitmask().count_ones();
            if met == 0 {
                continue;
            }
            self.elements += met;
            *deepest = deepest.fast_max(penetration);
            self.chunks.push(Chunk {
                column: at.column,
                row: (first + number * LANES) as u32,
                angle_rad: at.angle_rad,
                cos: at.cos,
                sin: at.sin,
                along_m: at.along_m,
                aside_m: at.aside_m,
                penetration_m: penetration,
                half_chord_m: half_chord,
                radius_m: radius,
                above_m: above,
            });
        }
    }
}

/// A column of elements as the tool sees it.
struct Ray {
    column: u32,
    angle_rad: f32,
    cos: f32,
    sin: f32,
    along_m: f32,
    aside_m: f32,
    /// The tool's radius, m, and the square of half its extent along the ray at its own height, m².
    reach_m: f32,
    reach_squared: f32,
}

/// Where the tool stands in the pot's cylindrical coordinates.
struct Reach {
    distance_m: f32,
    angle_rad: f32,
    /// The tool's angle beyond its nearest column, rad.
    off_column_rad: f32,
    window: Window,
}

impl Reach {
    /// The elements a sphere can touch: rows |z − H_z| ≤ R, from a multiple of [`LANES`] on, and columns
    /// |θ − φ| ≤ asin(R/d), all columns once it holds the axis. (The original used R/d, which leaves out grazed columns when
    /// the tool is near the axis.)
    ///
    /// The window is empty when the tool stands at no finite distance: comparisons with NaN would let every element pass.
    fn of(surface: &Surface, centre: Vec3, radius: f32) -> Self {
        let shape = surface.shape();
        let distance_m = libm::sqrtf(centre.x * centre.x + centre.y * centre.y);
        let angle_rad = libm::atan2f(centre.y, centre.x);
        let first_row = libm::ceilf((centre.z - radius) / surface.row_height_m());
        let last_row = libm::floorf((centre.z + radius) / surface.row_height_m());
        let column = libm::roundf(angle_rad / shape.column_angle_rad());
        let half_columns = if distance_m > radius {
            libm::ceilf(libm::asinf(radius / distance_m) / shape.column_angle_rad()) as u32
        } else {
            shape.columns()
        };
        let window = if distance_m.is_finite() && centre.z.is_finite() {
            Window::around(shape, column as i64, half_columns, first_row as i64, last_row as i64)
                .aligned(shape, LANES as u32)
        } else {
            Window::default()
        };
        let off_column_rad = angle_rad - column * shape.column_angle_rad();
        Self { distance_m, angle_rad, off_column_rad, window }
    }
}

/// Up to eight values, the rest zero.
pub(super) fn load(values: &[f32]) -> f32x8 {
    let mut lanes = [0.0; LANES];
    lanes[..values.len()].copy_from_slice(values);
    f32x8::new(lanes)
}

/// The sum of all lanes, in one order everywhere.
pub(super) fn sum(lanes: f32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The same angle within half a turn of zero.
pub(super) fn nearest_turn(angle_rad: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    match angle_rad {
        beyond if beyond > PI => beyond - TAU,
        before if before < -PI => before + TAU,
        within => within,
    }
}

/// A vector given with the tool at angle zero, with the tool at its own angle.
pub(super) fn turned(vector: Vec3, angle_rad: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(angle_rad);
    Vec3::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos, vector.z)
}
