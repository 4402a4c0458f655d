//! One skin of the pot: a grid of radii over angle and height.
//!
//! Owns the radii and their bounds, and the places of the elements; no method and no tool.
//! Invariant: every radius is finite and within the bounds; `set_radius` is the only way in.

use alloc::vec::Vec;

use super::{Digest, GridShape, Window};

/// A grid of circular sector elements: radius r(θ, z) of the skin at evenly spaced angles and heights.
///
/// Column j stands at θ = j·2π/columns, row i at z = i·height/(rows − 1), so that the first row is the foot and
/// the last the rim. Lee and Choi, section II A.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    shape: GridShape,
    height_m: f32,
    radius_min_m: f32,
    radius_max_m: f32,
    thickness_m: f32,
    /// `[columns][rows]`, m.
    radii_m: Vec<f32>,
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

    /// Distance between neighbouring rows, m.
    #[must_use]
    pub fn row_height_m(&self) -> f32 {
        self.height_m / (self.shape.rows() - 1) as f32
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
        }
    }

    /// Moves the elements of a column from `first_row` on by `deltas_m`; as in [`Surface::set_radius`], the bounds hold and
    /// what is not a number changes nothing.
    ///
    /// # Panics
    /// When the column has fewer elements.
    pub fn displace_column(&mut self, column: u32, first_row: u32, deltas_m: &[f32]) {
        let start = column as usize * self.shape.rows() as usize + first_row as usize;
        let (low, high) = (self.radius_min_m, self.radius_max_m);
        for (radius, &delta) in self.radii_m[start..][..deltas_m.len()].iter_mut().zip(deltas_m) {
            let moved = (*radius + delta).clamp(low, high);
            *radius = if moved.is_nan() { *radius } else { moved };
        }
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
