//! How many elements a surface has, and in which order they stand in memory.
//!
//! Owns the index arithmetic between (column, row) and the flat array; knows no radii.
//! Invariant: a shape that exists has from 8 × 4 to [`GridShape::ELEMENTS_MAX`] elements.

/// Number of circular sector elements over angle (columns) and height (rows).
///
/// Memory order is `[columns][rows]`: one column, from foot to rim, is contiguous, so that the seam at
/// θ = 0 never falls into an inner loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridShape {
    columns: u32,
    rows: u32,
}

/// Why a grid cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a grid of {columns} columns x {rows} rows cannot be used: choose at least 8 x 4 and at most {max} elements, \
     no more than 4096 a side"
)]
pub struct GridError {
    /// Columns asked for.
    pub columns: u32,
    /// Rows asked for.
    pub rows: u32,
    /// Largest number of elements.
    pub max: u32,
}

impl GridShape {
    /// The paper's grid: 360 × 400 = 144,000 elements.
    pub const PAPER: Self = Self { columns: 360, rows: 400 };
    /// That on which a hollow pot remembers how far its wall has folded: a fold is ten elements wide.
    pub(super) const FOLDS: Self = Self { columns: 96, rows: 64 };
    /// Most elements a grid may have.
    pub const ELEMENTS_MAX: u32 = 4 << 20;
    const SIDE_MAX: u32 = 4096;

    /// A grid of `columns` over the angle and `rows` over the height.
    ///
    /// # Errors
    /// [`GridError`] below 8 × 4, above 4096 on a side or above [`GridShape::ELEMENTS_MAX`] in all.
    pub fn new(columns: u32, rows: u32) -> Result<Self, GridError> {
        let sides_fit = (8..=Self::SIDE_MAX).contains(&columns) && (4..=Self::SIDE_MAX).contains(&rows);
        if sides_fit && columns * rows <= Self::ELEMENTS_MAX {
            Ok(Self { columns, rows })
        } else {
            Err(GridError { columns, rows, max: Self::ELEMENTS_MAX })
        }
    }

    /// Elements round the pot.
    #[must_use]
    pub const fn columns(self) -> u32 {
        self.columns
    }

    /// Elements from foot to rim.
    #[must_use]
    pub const fn rows(self) -> u32 {
        self.rows
    }

    /// Elements in all.
    #[must_use]
    pub const fn elements(self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Angle between neighbouring columns, rad.
    #[must_use]
    pub const fn column_angle_rad(self) -> f32 {
        core::f32::consts::TAU / self.columns as f32
    }

    /// The column at a signed column number, wrapped round the pot.
    #[must_use]
    pub const fn wrap(self, column: i64) -> u32 {
        column.rem_euclid(self.columns as i64) as u32
    }
}
