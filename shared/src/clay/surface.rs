//! One skin of the pot: a grid of radii over angle and height.
//!
//! Owns the radii and their bounds, and the places of the elements; no method and no tool.
//! Invariant: every radius is finite and within the bounds; `set_radius` is the only way in.

use alloc::sync::Arc;
use alloc::vec::Vec;

use wide::f32x8;

use super::contact::{LANES, load, sum};
use super::{Digest, Footprint, GridShape, Window};

/// A grid of circular sector elements: radius r(θ, z) of the skin at evenly spaced angles and heights.
///
/// Column j stands at θ = j·2π/columns, row i at z = i·height/(rows − 1), so that the first row is the foot and
/// the last the rim. Lee and Choi, section II A.
#[derive(Clone, Debug)]
pub struct Surface {
    shape: GridShape,
    height_m: f32,
    radius_min_m: f32,
    radius_max_m: f32,
    thickness_m: f32,
    /// No element is or ever was wider, m.
    widest_m: f32,
    /// Cosine and sine of each column's angle.
    directions: Arc<[[f32; 2]]>,
    /// `[columns][rows]`, m.
    radii_m: Vec<f32>,
}

impl PartialEq for Surface {
    /// Whether both are the same clay; by how much they were once wider does not matter.
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape
            && self.height_m == other.height_m
            && self.bounds_m() == other.bounds_m()
            && self.thickness_m == other.thickness_m
            && self.radii_m == other.radii_m
    }
}

impl Surface {
    /// A cylinder of `radius_m` and `height_m` with `thickness_m` of clay behind its skin, whose radii will stay within `radius_min_m..=radius_max_m`.
    pub(super) fn cylinder(
        shape: GridShape,
        height_m: f32,
        radius_m: f32,
        (radius_min_m, radius_max_m): (f32, f32),
        thickness_m: f32,
    ) -> Self {
        assert!(radius_min_m > 0.0 && radius_min_m <= radius_m && radius_m <= radius_max_m);
        Self {
            shape,
            height_m,
            radius_min_m,
            radius_max_m,
            thickness_m,
            widest_m: radius_m,
            directions: directions(shape),
            radii_m: alloc::vec![radius_m; shape.elements()],
        }
    }

    /// Number of elements each way.
    #[must_use]
    pub const fn shape(&self) -> GridShape {
        self.shape
    }

    /// Height from foot to rim, m.
    #[must_use]
    pub const fn height_m(&self) -> f32 {
        self.height_m
    }

    /// Smallest and largest radius an element may take, m.
    #[must_use]
    pub const fn bounds_m(&self) -> (f32, f32) {
        (self.radius_min_m, self.radius_max_m)
    }

    /// Thickness of the clay behind the skin, m.
    #[must_use]
    pub const fn thickness_m(&self) -> f32 {
        self.thickness_m
    }

    /// A radius that no element exceeds, m; not always the smallest such.
    pub(super) const fn widest_m(&self) -> f32 {
        self.widest_m
    }

    /// Distance between neighbouring rows, m.
    #[must_use]
    pub fn row_height_m(&self) -> f32 {
        self.height_m / (self.shape.rows() - 1) as f32
    }

    /// Cosine and sine of a column's angle.
    ///
    /// # Panics
    /// When the grid has no such column.
    #[must_use]
    pub fn direction(&self, column: u32) -> [f32; 2] {
        self.directions[column as usize]
    }

    /// Height of a row above the wheel head, m.
    #[must_use]
    pub fn row_z_m(&self, row: u32) -> f32 {
        row as f32 * self.row_height_m()
    }

    /// All radii, `[columns][rows]`, m.
    #[must_use]
    pub fn radii_m(&self) -> &[f32] {
        &self.radii_m
    }

    /// Radii of one column, foot to rim, m.
    ///
    /// # Panics
    /// When the grid has no such column.
    #[must_use]
    pub fn column_m(&self, column: u32) -> &[f32] {
        let rows = self.shape.rows() as usize;
        &self.radii_m[column as usize * rows..][..rows]
    }

    /// Sets one radius, clamped to the bounds; a value that is not a number leaves the element as it was.
    ///
    /// # Panics
    /// When the grid has no such element.
    pub fn set_radius(&mut self, column: u32, row: u32, radius_m: f32) {
        assert!(row < self.shape.rows());
        if !radius_m.is_nan() {
            let index = column as usize * self.shape.rows() as usize + row as usize;
            self.radii_m[index] = radius_m.clamp(self.radius_min_m, self.radius_max_m);
            self.widest_m = self.widest_m.max(self.radii_m[index]);
        }
    }

    /// Moves the elements of a window by a footprint's displacements; as in [`Surface::set_radius`], the bounds hold and
    /// what is not a number changes nothing.
    ///
    /// Returns the volume that the skin encloses more than before, m³: `Σ ½·(r₁ − r₀)·(r₁ + r₀)·Δθ·Δz`, half of it on the foot
    /// and the rim as in [`Surface::enclosed_volume_m3`].
    ///
    /// # Panics
    /// When the window lies outside of the grid.
    pub fn displace(&mut self, footprint: &Footprint) -> f64 {
        let window = footprint.window();
        let rows = self.shape.rows();
        let (low, high) = (f32x8::splat(self.radius_min_m), f32x8::splat(self.radius_max_m));
        let mut widest = f32x8::ZERO;
        let mut squares_m2 = 0.0;
        for (local, column) in window.grid_columns(self.shape).enumerate() {
            let start = column as usize * rows as usize + window.first_row as usize;
            let deltas_m = footprint.column(local as u32);
            let radii_m = &mut self.radii_m[start..][..deltas_m.len()];
            let ends = [radii_m[0], radii_m[radii_m.len() - 1]];
            let mut grown = f32x8::ZERO;
            let mut move_eight = |radii: [f32; LANES], deltas: [f32; LANES]| {
                let (radius, delta) = (f32x8::new(radii), f32x8::new(deltas));
                let moved = radius + delta;
                let within = moved.fast_max(low).fast_min(high);
                // what is not a number is equal to nothing
                let kept = moved.simd_eq(moved).bitselect(within, radius);
                widest = widest.fast_max(kept);
                grown += (kept - radius) * (kept + radius);
                kept.to_array()
            };
            let (radii, last_radii) = radii_m.as_chunks_mut::<LANES>();
            let (deltas, last_deltas) = deltas_m.as_chunks::<LANES>();
            for (radii, deltas) in radii.iter_mut().zip(deltas) {
                *radii = move_eight(*radii, *deltas);
            }
            if !last_radii.is_empty() {
                let kept = move_eight(load(last_radii).to_array(), load(last_deltas).to_array());
                last_radii.copy_from_slice(&kept[..last_radii.len()]);
            }
            squares_m2 += f64::from(sum(grown));
            let half = |before: f32, after: f32| 0.5 * f64::from((after - before) * (after + before));
            if window.first_row == 0 {
                squares_m2 -= half(ends[0], radii_m[0]);
            }
            if window.end_row() == rows {
                squares_m2 -= half(ends[1], radii_m[radii_m.len() - 1]);
            }
        }
        self.widest_m = widest.to_array().into_iter().fold(self.widest_m, f32::max);
        0.5 * squares_m2 * f64::from(self.shape.column_angle_rad()) * f64::from(self.row_height_m())
    }

    /// Takes the radii of `window` over from a surface of the same shape.
    ///
    /// # Panics
    /// When the shapes differ or the window lies outside.
    pub fn copy_window(&mut self, from: &Self, window: Window) {
        assert_eq!(self.shape, from.shape);
        let rows = self.shape.rows() as usize;
        for column in window.grid_columns(self.shape) {
            let start = column as usize * rows + window.first_row as usize;
            let range = start..start + window.rows as usize;
            self.radii_m[range.clone()].copy_from_slice(&from.radii_m[range]);
        }
        self.widest_m = self.widest_m.max(from.widest_m);
    }

    /// Volume enclosed between the skin and the axis, m³.
    ///
    /// `V = Σ ½ r² Δθ Δz`, trapezoidal in z: exact for a cylinder.
    #[must_use]
    pub fn enclosed_volume_m3(&self) -> f64 {
        let area = f64::from(self.shape.column_angle_rad()) * f64::from(self.row_height_m());
        let rows = self.shape.rows() as usize;
        let mut sum = 0.0;
        for column in self.radii_m.chunks_exact(rows) {
            for &radius in column {
                sum += f64::from(radius) * f64::from(radius);
            }
            let (foot, rim) = (f64::from(column[0]), f64::from(column[rows - 1]));
            sum -= 0.5 * (foot * foot + rim * rim);
        }
        0.5 * sum * area
    }

    /// Adds every radius, bit for bit, to a digest.
    pub fn digest_into(&self, digest: &mut Digest) {
        for radius in &self.radii_m {
            digest.add(radius.to_bits());
        }
    }
}

/// Cosine and sine of every column's angle, so that no step asks for them.
fn directions(shape: GridShape) -> Arc<[[f32; 2]]> {
    let turn = |column: u32| f64::from(column) * (core::f64::consts::TAU / f64::from(shape.columns()));
    let direction = |column| {
        let (sin, cos) = libm::sincos(turn(column));
        [cos as f32, sin as f32]
    };
    (0..shape.columns()).map(direction).collect()
}
