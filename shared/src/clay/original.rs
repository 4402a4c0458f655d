//! The original Circular Sector Element Method (Lee, Han and Choi 2008): every touched element yields by itself.
//!
//! Kept as published, its faults included: no yield (a still hand sinks without end), no volume returned, sharp edges.
//! Invariant: no element outside the contact moves.

use super::{Contact, Footprint, Method, Press, Surface, contact};

/// The original CSEM: `r ← r − (r − s₁)·(1 − exp(−dt/τ))`.
///
/// Readings: the published `1/ν` a tick is taken as the response of one tick of dt = 1 ms; odd rows are not shifted by
/// half an element, as in the later paper, where elements are evenly separated.
#[derive(Clone, Copy, Debug, Default)]
pub struct OriginalCsem;

impl Method for OriginalCsem {
    fn press(&self, surface: &Surface, press: &Press, footprint: &mut Footprint) -> Contact {
        contact::touch(surface, press, (0, 0), footprint)
    }
}
