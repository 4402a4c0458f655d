//! The finite-element reference: how a clay cylinder deforms under a sphere, read from files.
//!
//! Owns the reading and the interpolation; knows no method. `tests/data/reference/README.md` says what the files are.
//! Invariant: `radial_mm` at an undeformed mesh point that did not move sideways is the file's own figure.

use std::fmt;

/// Radial displacement of the outer surface over angle and height, symmetric about θ = 0.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Undeformed angles, rad, ascending, and heights, mm, ascending.
    angles: Vec<f64>,
    heights: Vec<f64>,
    /// `[angles][heights]`: sideways displacement, rad and mm, and radial displacement, mm.
    points: Vec<[f64; 4]>,
}

/// Why a file is no profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadProfile {
    /// Number of the line, from 1.
    pub line: usize,
}

impl fmt::Display for BadProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {} is no row of six numbers on the mesh", self.line)
    }
}

impl std::error::Error for BadProfile {}

/// Where a value stands between two neighbours of an ascending list: the lower one and the share of the upper one.
fn between(values: &[f64], value: f64) -> (usize, f64) {
    let upper = values.partition_point(|known| *known <= value).clamp(1, values.len() - 1);
    let (low, high) = (values[upper - 1], values[upper]);
    (upper - 1, ((value - low) / (high - low)).clamp(0.0, 1.0))
}

impl Profile {
    /// Part of a step that is made while a mesh point is looked for, and how often.
    const PART: f64 = 0.6;
    const LOOKS: u32 = 80;

    /// Reads the columns θ, z (deformed), u_r, θ₀, z₀ and the inner radius, below one line of names.
    ///
    /// # Errors
    /// [`BadProfile`] with the first line that does not fit.
    pub fn parse(text: &str) -> Result<Self, BadProfile> {
        let mut rows = Vec::new();
        for (number, line) in text.lines().enumerate().skip(1) {
            let values: Vec<f64> = line.split(',').filter_map(|value| value.trim().parse().ok()).collect();
            let row: [f64; 6] = values.try_into().map_err(|_| BadProfile { line: number + 1 })?;
            rows.push(row);
        }
        let sorted = |column: usize| {
            let mut values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (angles, heights) = (sorted(3), sorted(4));
        if angles.len() < 2 || heights.len() < 2 || rows.len() != angles.len() * heights.len() {
            return Err(BadProfile { line: rows.len() + 1 });
        }
        let mut points = vec![[0.0; 4]; rows.len()];
        for row in &rows {
            let angle = angles.partition_point(|known| *known < row[3]);
            let height = heights.partition_point(|known| *known < row[4]);
            points[angle * heights.len() + height] = [row[0] - row[3], row[1] - row[4], row[2], row[5]];
        }
        Ok(Self { angles, heights, points })
    }

    /// All three displacements of the undeformed point, and the radius of the inner wall behind it (bilinear).
    fn at_mesh(&self, angle_rad: f64, z_mm: f64) -> [f64; 4] {
        let (column, across) = between(&self.angles, angle_rad);
        let (row, up) = between(&self.heights, z_mm);
        let point = |column: usize, row: usize| self.points[column * self.heights.len() + row];
        let corners = [point(column, row), point(column + 1, row), point(column, row + 1), point(column + 1, row + 1)];
        std::array::from_fn(|of| {
            let (low, high) = (
                corners[0][of] + (corners[1][of] - corners[0][of]) * across,
                corners[2][of] + (corners[3][of] - corners[2][of]) * across,
            );
            low + (high - low) * up
        })
    }

    /// Points of the mesh line across the surface that began nearest to an angle, upwards: height now and radial
    /// displacement, mm. For a groove drawn so far that it is the same all along, in which points have moved too far for
    /// [`Self::radial_mm`].
    #[must_use]
    pub fn across_mm(&self, angle_rad: f64) -> Vec<[f64; 2]> {
        let (below, share) = between(&self.angles, angle_rad);
        let line = below + usize::from(share > 0.5);
        let points = &self.points[line * self.heights.len()..][..self.heights.len()];
        self.heights.iter().zip(points).map(|(z_mm, moved)| [z_mm + moved[1], moved[2]]).collect()
    }

    /// Radius of the inner wall behind the undeformed point, mm.
    #[must_use]
    pub fn inner_mm(&self, angle_rad: f64, z_mm: f64) -> f64 {
        self.at_mesh(angle_rad.abs(), z_mm)[3]
    }

    /// Radial displacement of the surface where it lies now, mm; negative is inwards.
    #[must_use]
    pub fn radial_mm(&self, angle_rad: f64, z_mm: f64) -> f64 {
        let angle_rad = angle_rad.abs();
        // which mesh point has come to lie here: under a deep tool the mesh is stretched to more than twice its length, which a whole
        // step would overshoot by more than it is off
        let (mut angle, mut height) = (angle_rad, z_mm);
        for _ in 0..Self::LOOKS {
            let moved = self.at_mesh(angle.abs(), height);
            angle += Self::PART * (angle_rad - moved[0] - angle);
            height += Self::PART * (z_mm - moved[1] - height);
        }
        self.at_mesh(angle.abs(), height)[2]
    }
}

/// Force on a sphere over its travel.
#[derive(Clone, Debug)]
pub struct ForceCurve {
    /// Travel, mm, and force, N, in the order of time.
    points: Vec<[f64; 2]>,
}

impl ForceCurve {
    /// Reads the first two columns, below one line of names.
    ///
    /// # Errors
    /// [`BadProfile`] with the first line that does not fit.
    pub fn parse(text: &str) -> Result<Self, BadProfile> {
        let mut points = Vec::new();
        for (number, line) in text.lines().enumerate().skip(1) {
            let mut values = line.split(',').map(|value| value.trim().parse::<f64>());
            match (values.next(), values.next()) {
                (Some(Ok(travel)), Some(Ok(force))) => points.push([travel, force]),
                _ => return Err(BadProfile { line: number + 1 }),
            }
        }
        Ok(Self { points })
    }

    /// Largest force, N.
    #[must_use]
    pub fn largest_n(&self) -> f64 {
        self.points.iter().map(|point| point[1]).fold(0.0, f64::max)
    }

    /// Force when the sphere reaches a travel for the first time, N; `None` when it never does.
    #[must_use]
    pub fn first_at_n(&self, travel_mm: f64) -> Option<f64> {
        let reached = self.points.windows(2).find(|pair| pair[0][0] < travel_mm && pair[1][0] >= travel_mm)?;
        let [before, after] = [reached[0], reached[1]];
        Some(before[1] + (after[1] - before[1]) * (travel_mm - before[0]) / (after[0] - before[0]))
    }
}
