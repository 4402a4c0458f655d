//! Eight numbers that go through the same arithmetic: the elements of one batch.
//!
//! Owns their storage only: arithmetic is written as a loop over the lanes of whole formulas, which compilers turn into
//! vector instructions and which stays quick without optimisation.
//! Invariant: a batch is aligned to a cache line.

/// Elements in a batch.
pub(super) const WIDTH: usize = 8;

/// One number for each element of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; WIDTH]);
}
