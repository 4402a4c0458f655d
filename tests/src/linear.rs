//! Symmetric systems of equations, dense or banded.
//!
//! Owns the factor and nothing of what the equations mean.
//! Invariant: a factor that exists belongs to a positive definite matrix.

/// Cholesky factor of a symmetric positive definite matrix: `[size][half_width + 1]`, a row's last figure on the diagonal.
pub(crate) struct Cholesky {
    size: usize,
    half_width: usize,
    factor: Vec<f64>,
}

/// Sum of products in four lanes, since one lane waits for its own last sum.
fn dot(left: &[f64], right: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (lefts, rights) = (left.chunks_exact(4), right.chunks_exact(4));
    let rest: f64 = lefts.remainder().iter().zip(rights.remainder()).map(|(left, right)| left * right).sum();
    for (left, right) in lefts.zip(rights) {
        for lane in 0..4 {
            lanes[lane] += left[lane] * right[lane];
        }
    }
    rest + lanes.iter().sum::<f64>()
}

impl Cholesky {
    /// Factor of the matrix whose entries (row ≥ column ≥ row − `half_width`) are given; `None` unless it is positive
    /// definite.
    pub(crate) fn new(size: usize, half_width: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let width = half_width + 1;
        let mut factor = vec![0.0; size * width];
        for row in 0..size {
            let first = row.saturating_sub(half_width);
            for column in first..=row {
                let (upper, lower) = factor.split_at_mut(row * width);
                let own = &mut lower[..width];
                let from = first.max(column.saturating_sub(half_width));
                let own_part = from + half_width - row..column + half_width - row;
                let given = entry(row, column);
                if column == row {
                    let square = given - dot(&own[own_part.clone()], &own[own_part]);
                    // a pivot that rounding alone could have left is no pivot
                    if square.is_nan() || square <= given.abs() * 1e-13 {
                        return None;
                    }
                    own[half_width] = square.sqrt();
                } else {
                    let other = &upper[column * width..][..width];
                    let other_part = from + half_width - column..half_width;
                    own[column + half_width - row] =
                        (given - dot(&own[own_part], &other[other_part])) / other[half_width];
                }
            }
        }
        Some(Self { size, half_width, factor })
    }

    /// Replaces a right-hand side by its solution.
    ///
    /// # Panics
    /// When its length is not the matrix's.
    pub(crate) fn solve(&self, values: &mut [f64]) {
        assert_eq!(values.len(), self.size);
        let (half_width, width) = (self.half_width, self.half_width + 1);
        let row_of = |row: usize| {
            let first = row.saturating_sub(half_width);
            (first, &self.factor[row * width + first + half_width - row..][..row - first + 1])
        };
        for row in 0..self.size {
            let (first, own) = row_of(row);
            let count = row - first;
            values[row] = (values[row] - dot(&own[..count], &values[first..row])) / own[count];
        }
        for row in (0..self.size).rev() {
            let (first, own) = row_of(row);
            let count = row - first;
            let value = values[row] / own[count];
            values[row] = value;
            for (left, factor) in values[first..row].iter_mut().zip(own) {
                *left -= value * factor;
            }
        }
    }
}
