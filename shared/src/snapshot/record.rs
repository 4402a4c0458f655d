//! A pot as its snapshots hold it, apart from any wheel: what it was made from, and its radii in quantum steps.
//!
//! What a file keeps and a wheel can begin with; knows no versions, and of bytes only the order in which files keep radii.
//! Invariant: a record that exists makes a pot, and the same one wherever it is made, bit for bit.

use alloc::vec::Vec;

use super::grid::{Quantum, dequantise, quantise, untouched_grids};
use crate::clay::{Pot, PotError, PotSpec, Support, Surface, Window};
use crate::units::Metres;

/// What a pot was made from and the radii that it has now.
///
/// ```
/// use pottery_shared::clay::{Pot, PotSpec};
/// use pottery_shared::snapshot::PotRecord;
///
/// let record = PotRecord::of(&Pot::new(PotSpec::default())?);
/// let pot = record.pot();
/// assert_eq!(PotRecord::of(&pot), record);
/// # Ok::<(), pottery_shared::clay::PotError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PotRecord {
    spec: PotSpec,
    /// `[surface][columns][rows]`, quantum steps.
    steps: Vec<Vec<u16>>,
}

/// Why radii are none of a pot of that specification.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// No pot is made like that; choose other measures.
    #[error(transparent)]
    Pot(#[from] PotError),
    /// Too few or too many surfaces; give those that a pot has.
    #[error("{surfaces} surfaces are not those of a pot, which has {expected}")]
    Surfaces {
        /// How many were given.
        surfaces: usize,
        /// How many a pot has.
        expected: usize,
    },
    /// Too few or too many radii; give one for each element.
    #[error("{radii} radii do not cover a grid of {elements} elements")]
    Count {
        /// How many were given.
        radii: usize,
        /// How many the grid has.
        elements: usize,
    },
    /// A radius that an element of this pot cannot have; choose one within the bounds.
    #[error(
        "a radius of {radius_mm:.2} mm at column {column}, row {row} cannot be used: this pot takes {min_mm:.2} to {max_mm:.2} mm"
    )]
    Radius {
        /// Where, round the pot.
        column: usize,
        /// Where, from the foot up.
        row: usize,
        /// What was given, mm.
        radius_mm: f32,
        /// Smallest, mm.
        min_mm: f32,
        /// Largest, mm.
        max_mm: f32,
    },
    /// Skins of a wall that cross each other; let the inner one lie within the outer one.
    #[error("the inner wall lies outside of the outer one at column {column}, row {row}")]
    Crossed {
        /// Where, round the pot.
        column: usize,
        /// Where, from the foot up.
        row: usize,
    },
}

impl PotRecord {
    /// The record of a pot, whose radii are rounded to the quantum as a snapshot rounds them.
    ///
    /// Of a pot as a snapshot left it, nothing is rounded.
    #[must_use]
    pub fn of(pot: &Pot) -> Self {
        let rounded =
            |surface: &Surface| surface.radii_m().iter().map(|&radius_m| quantise(radius_m)).collect::<Vec<_>>();
        Self { spec: *pot.spec(), steps: pot.surfaces()[..pot.spec().skins()].iter().map(rounded).collect() }
    }

    /// A record of radii in quantum steps, `[surface][columns][rows]`.
    ///
    /// # Errors
    /// [`RecordError`] for a specification that makes no pot, or for radii that are none of it.
    pub fn new(spec: PotSpec, steps: Vec<Vec<u16>>) -> Result<Self, RecordError> {
        let pot = Pot::new(spec)?;
        if steps.len() != spec.skins() {
            return Err(RecordError::Surfaces { surfaces: steps.len(), expected: spec.skins() });
        }
        for (surface, steps) in pot.surfaces().iter().zip(&steps) {
            check(surface, steps)?;
        }
        if let [outer, inner] = &*steps
            && let Some(at) = outer.iter().zip(inner).position(|(outer, inner)| inner > outer)
        {
            let rows = spec.shape.rows() as usize;
            return Err(RecordError::Crossed { column: at / rows, row: at % rows });
        }
        Ok(Self { spec, steps })
    }

    /// The same clay with another specification: a core is filled in or taken out behind a wall as thick as it was made.
    ///
    /// # Errors
    /// [`RecordError`] for a specification that makes no pot, or another grid's.
    pub fn made_as(&self, spec: PotSpec) -> Result<Self, RecordError> {
        Self::of_surfaces(spec, self.steps.clone())
    }

    /// A record of as many surfaces as are given: a wall whose inner skin is not told is as thick as it was made.
    fn of_surfaces(spec: PotSpec, mut steps: Vec<Vec<u16>>) -> Result<Self, RecordError> {
        match (spec.support, &*steps) {
            (Support::Hollow, [outer]) => {
                let thick = quantise(spec.radius.0).saturating_sub(quantise(spec.radius.0 - spec.wall.0));
                steps.push(outer.iter().map(|outer| outer.saturating_sub(thick)).collect());
            }
            (Support::Backed, [_, ..]) => steps.truncate(1),
            _ => {}
        }
        Self::new(spec, steps)
    }

    /// What the pot was made from.
    #[must_use]
    pub const fn spec(&self) -> &PotSpec {
        &self.spec
    }

    /// The radii of every surface, `[surface][columns][rows]`, in steps of [`super::QUANTUM_M`].
    #[must_use]
    pub fn steps(&self) -> &[Vec<u16>] {
        &self.steps
    }

    /// The radii as files keep them before they are packed: what differs from what is expected, small differences as small
    /// numbers, of all elements the low bytes before the high ones; `shared/files/POT-FILE.md` says it in full.
    #[must_use]
    pub fn planes(&self) -> Vec<u8> {
        let rows = self.spec.shape.rows() as usize;
        let mut planes = Vec::with_capacity(self.steps.iter().map(|steps| 2 * steps.len()).sum());
        for steps in &self.steps {
            let words: Vec<u16> = (0..steps.len())
                .map(|at| {
                    let difference = steps[at].wrapping_sub(expected(steps, at, rows)) as i16;
                    ((difference << 1) ^ (difference >> 15)) as u16
                })
                .collect();
            planes.extend(words.iter().map(|word| *word as u8));
            planes.extend(words.iter().map(|word| (word >> 8) as u8));
        }
        planes
    }

    /// The record that has these planes: of a hollow pot also those of its outer surface alone.
    ///
    /// # Errors
    /// [`RecordError`], also for planes that are too short or too long.
    pub fn of_planes(spec: PotSpec, planes: &[u8]) -> Result<Self, RecordError> {
        let (elements, rows) = (spec.shape.elements(), spec.shape.rows() as usize);
        if planes.is_empty() || !planes.len().is_multiple_of(2 * elements) {
            return Err(RecordError::Count { radii: planes.len() / 2, elements });
        }
        let of_surface = |planes: &[u8]| {
            let (low, high) = planes.split_at(elements);
            let mut steps = Vec::with_capacity(elements);
            for (at, (&low, &high)) in low.iter().zip(high).enumerate() {
                let word = u16::from_le_bytes([low, high]);
                let difference = (word >> 1) ^ (word & 1).wrapping_neg();
                steps.push(expected(&steps, at, rows).wrapping_add(difference));
            }
            steps
        };
        Self::of_surfaces(spec, planes.chunks_exact(2 * elements).map(of_surface).collect())
    }

    /// The pot, as it stands on a wheel that began with this record.
    #[must_use]
    pub fn pot(&self) -> Pot {
        let mut pot = Pot::new(self.spec).expect("the specification was checked with the record");
        untouched_grids(&mut pot, Quantum::FINEST);
        self.lay_on(&mut pot);
        let all: Vec<_> = windows(&pot).collect();
        pot.settle(all.into_iter());
        pot
    }

    /// Gives an untouched pot of the same grid these radii.
    pub(super) fn lay_on(&self, pot: &mut Pot) {
        for (surface, steps) in pot.surfaces_mut().iter_mut().zip(&self.steps) {
            let rows = surface.shape().rows();
            for (column, steps) in (0..).zip(steps.chunks_exact(rows as usize)) {
                for (row, &step) in (0..).zip(steps) {
                    surface.set_radius(column, row, dequantise(step));
                }
            }
        }
    }
}

/// What an element is expected to be from those before it: the median of its left neighbour, the one below, and what a
/// plane through both and the corner gives.
fn expected(steps: &[u16], at: usize, rows: usize) -> u16 {
    let left = || steps[at - rows];
    let below = || steps[at - 1];
    match (at >= rows, at.is_multiple_of(rows)) {
        (false, true) => 0,
        (false, false) => below(),
        (true, true) => left(),
        (true, false) => {
            let (left, below, corner) = (i32::from(left()), i32::from(below()), i32::from(steps[at - rows - 1]));
            (left + below - corner).clamp(left.min(below), left.max(below)) as u16
        }
    }
}

/// Every surface of a pot with all its elements.
pub(super) fn windows(pot: &Pot) -> impl Iterator<Item = (usize, Window)> {
    let whole = |surface: &Surface| {
        let shape = surface.shape();
        Window { first_column: 0, columns: shape.columns(), first_row: 0, rows: shape.rows() }
    };
    pot.surfaces().iter().map(whole).enumerate()
}

fn check(surface: &Surface, steps: &[u16]) -> Result<(), RecordError> {
    let shape = surface.shape();
    if steps.len() != shape.elements() {
        return Err(RecordError::Count { radii: steps.len(), elements: shape.elements() });
    }
    let (min_m, max_m) = surface.bounds_m();
    let is_outside = |&step: &u16| !(min_m..=max_m).contains(&dequantise(step));
    match steps.iter().position(is_outside) {
        None => Ok(()),
        Some(at) => Err(RecordError::Radius {
            column: at / shape.rows() as usize,
            row: at % shape.rows() as usize,
            radius_mm: Metres(dequantise(steps[at])).told_mm(),
            min_mm: Metres(min_m).told_mm(),
            max_mm: Metres(max_m).told_mm(),
        }),
    }
}
