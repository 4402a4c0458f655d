//! Other grids for the same clay: how fine one has to be, and how clay is taken from one to the other.
//!
//! Owns the overlap of the elements of two grids; touches no radius of a pot that is there.
//! Invariant: the volume within the radii is the same on both grids, up to the rounding of an `f32` radius, but where clay stands at a bound
//! of the surface and goes to a finer grid: what would sharpen its edges beyond the bound is cut off.

use alloc::vec::Vec;

use super::{GridError, GridShape, Pot, PotSpec, Surface};
use crate::units::Metres;

/// Why no grid follows from a tool and a viewer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ResolutionError {
    /// A length is not a number or not positive; choose one that is.
    #[error("a {field} of {value_mm} mm cannot be used: choose one above 0 mm")]
    Length {
        /// Which length.
        field: &'static str,
        /// What was given, mm.
        value_mm: f32,
    },
    /// The pot would need more elements than there can be; choose a larger tool or a coarser view.
    #[error(transparent)]
    Grid(#[from] GridError),
}

impl GridShape {
    /// Elements to the radius of the smallest tool: two to the half axis of a contact that is an eighth of the radius deep.
    const ELEMENTS_A_TOOL: f32 = 4.0;

    /// The coarsest grid for a pot whose elements are no longer than a quarter of the smallest tool's radius; where the finest
    /// viewer sees no such length (`seen`, on the clay), what that viewer sees.
    ///
    /// A tool that leaves marks finer than anybody sees needs no elements for them. No pot has fewer than 8 × 4.
    ///
    /// # Errors
    /// [`ResolutionError`] for a length that is not positive, or for more elements than a grid has.
    pub fn for_tool_and_view(pot: &PotSpec, smallest_tool: Metres, seen: Metres) -> Result<Self, ResolutionError> {
        let lengths =
            [("tool radius", smallest_tool), ("visible length", seen), ("height", pot.height), ("radius", pot.radius)];
        for (field, length) in lengths {
            if !(length.0 > 0.0 && length.0.is_finite()) {
                return Err(ResolutionError::Length { field, value_mm: length.told_mm() });
            }
        }
        let element_m = (smallest_tool.0 / Self::ELEMENTS_A_TOOL).max(seen.0);
        // a hair less, so that what divides evenly does not get one more by rounding
        let whole = |length_m: f32| libm::ceilf(length_m / element_m - 1e-3).min(1e9) as u32;
        let columns = whole(core::f32::consts::TAU * pot.radius.0);
        Ok(Self::new(columns.max(8), (whole(pot.height.0) + 1).max(4))?)
    }
}

impl Pot {
    /// The same clay on another grid: see [`Surface::resampled`].
    #[must_use]
    pub fn resampled(&self, shape: GridShape) -> Self {
        self.on_grid(shape, |surface| surface.resampled(shape))
    }
}

impl Surface {
    /// Passes after which clay that went to a finer grid comes back as it was, to a rounding: each halves what is left.
    const PASSES: usize = 26;

    /// The same clay on another grid.
    ///
    /// Every element takes the mean of r² over its own area, elements being as wide as their distance and half as high at foot
    /// and rim: the volume stays. On a grid that is finer both ways the radii are such that the way back gives what
    /// was there; edges between elements are sharpened for that when the finer grid cuts them in halves. Where clay stands at a bound, which
    /// cuts off what sharpens, neither volume nor way back holds.
    #[must_use]
    pub fn resampled(&self, shape: GridShape) -> Self {
        let mut squares: Vec<f64> =
            self.radii_m().iter().map(|&radius| f64::from(radius) * f64::from(radius)).collect();
        let (old, new) = ((self.shape().columns(), self.shape().rows()), (shape.columns(), shape.rows()));
        if new.0 >= old.0 && new.1 >= old.1 {
            // one way after the other, since what is halved both ways would be left over four times as long
            for finer in [(new.0, old.1), (old.0, new.1)] {
                squares = sharpened(&squares, old, finer);
            }
        }
        let squares = Overlaps::between(old, new).apply(&squares);
        let radii_m: Vec<f32> = squares.iter().map(|&square| libm::sqrt(square.max(0.0)) as f32).collect();
        self.with_radii(shape, &radii_m)
    }
}

/// Values that come back as `values` from the means on a finer grid of those there.
fn sharpened(values: &[f64], old: (u32, u32), finer: (u32, u32)) -> Vec<f64> {
    let (there, back) = (Overlaps::between(old, finer), Overlaps::between(finer, old));
    let mut sharp = values.to_vec();
    if old == finer {
        return sharp;
    }
    for _ in 0..Surface::PASSES {
        let returned = back.apply(&there.apply(&sharp));
        for ((sharp, wanted), got) in sharp.iter_mut().zip(values).zip(&returned) {
            *sharp += wanted - got;
        }
    }
    sharp
}

/// From which elements of a row of elements another row takes, and how much.
struct Overlap {
    /// First element, and shares of it and those behind it, which wrap.
    from: Vec<(usize, Vec<f64>)>,
}

impl Overlap {
    /// `old` elements that reach round a ring, and `new` ones; element 0 is in the middle of both.
    fn of_ring(old: u32, new: u32) -> Self {
        let width = f64::from(old) / f64::from(new);
        let cell = |number: u32| {
            let middle = f64::from(number) * width;
            // counted from the beginning of element 0
            (middle - 0.5 * width + 0.5, middle + 0.5 * width + 0.5)
        };
        let from = (0..new).map(|number| {
            let (begin, end) = cell(number);
            let first = libm::floor(begin);
            let shares = Self::shares(begin, end, |element| (first + element, first + element + 1.0));
            ((first as i64).rem_euclid(i64::from(old)) as usize, shares)
        });
        Self { from: from.collect() }
    }

    /// `old` elements from one end to the other, the outer ones half as long, and `new` ones.
    fn of_line(old: u32, new: u32) -> Self {
        let last = f64::from(old - 1);
        let width = last / f64::from(new - 1);
        let from = (0..new).map(|number| {
            let middle = f64::from(number) * width;
            let (begin, end) = ((middle - 0.5 * width).max(0.0), (middle + 0.5 * width).min(last));
            let first = libm::floor(begin + 0.5);
            let element = |number: f64| {
                let at = first + number;
                ((at - 0.5).max(0.0), (at + 0.5).min(last))
            };
            (first as usize, Self::shares(begin, end, element))
        });
        Self { from: from.collect() }
    }

    /// Shares of the elements in `begin..end`, which add up to one.
    fn shares(begin: f64, end: f64, element: impl Fn(f64) -> (f64, f64)) -> Vec<f64> {
        let mut shares = Vec::new();
        loop {
            let (from, to) = element(shares.len() as f64);
            let common = to.min(end) - from.max(begin);
            // what is left by rounding is no element
            if common <= 1e-9 && !shares.is_empty() {
                break;
            }
            shares.push(common.max(0.0));
        }
        let all: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= all);
        shares
    }
}

/// Both ways of a grid.
struct Overlaps {
    columns: Overlap,
    rows: Overlap,
    old_rows: usize,
}

impl Overlaps {
    fn between(old: (u32, u32), new: (u32, u32)) -> Self {
        let old_rows = old.1 as usize;
        Self { columns: Overlap::of_ring(old.0, new.0), rows: Overlap::of_line(old.1, new.1), old_rows }
    }

    /// Means of `[columns][rows]` values over the elements of the other grid.
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        let (old_rows, old_columns) = (self.old_rows, values.len() / self.old_rows);
        let mut column = alloc::vec![0.0; old_rows];
        let mut means = Vec::with_capacity(self.columns.from.len() * self.rows.from.len());
        for (first, shares) in &self.columns.from {
            column.fill(0.0);
            for (number, share) in shares.iter().enumerate() {
                let start = (first + number) % old_columns * old_rows;
                column.iter_mut().zip(&values[start..][..old_rows]).for_each(|(mean, value)| *mean += share * value);
            }
            for (first, shares) in &self.rows.from {
                means.push(column[*first..].iter().zip(shares).map(|(value, share)| value * share).sum());
            }
        }
        means
    }
}
