//! What both ends of a chain of deltas remember from one to the next: the last delta, and what was learned.
//!
//! Knows differences, no clay and no versions; author and replica hold one each.
//! Invariant: after the same deltas, or a keyframe that was written between two of them, both ends remember the same.

use alloc::vec::Vec;

use super::TileLayout;
use super::models::Models;
use super::motion::{Motion, Motions, Turned};
use super::plane::Plane;
use super::sweep::{Exhausted, Sweep};
use crate::clay::{Vectors, with_vectors};
use crate::coding::{Decoder, Encoder, Symbols};

/// The memory of one end.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// The last delta, a plane a surface.
    last: Vec<Plane>,
    /// The delta that is being made or read.
    pub(super) current: Vec<Plane>,
    motions: Motions,
    models: Models,
    sweep: Sweep,
    vectors: Vectors,
}

impl Chain {
    pub(super) fn new(layouts: impl Iterator<Item = TileLayout>) -> Self {
        let last: Vec<_> = layouts.map(Plane::unchanged).collect();
        Self {
            current: last.clone(),
            last,
            motions: Motions::new(),
            models: Models::new(),
            sweep: Sweep::default(),
            vectors: Vectors::default(),
        }
    }

    /// The bytes of the current delta, which then becomes the last.
    pub(super) fn encode(&mut self, motion: Motion) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.code(Encoder::new(&mut bytes), motion).expect("writing meets no end").finish();
        self.advance();
        bytes
    }

    /// Reads a delta into `current`, which is then taken and followed by [`Chain::advance`].
    ///
    /// # Errors
    /// [`Exhausted`] when the bytes are no delta; nothing is then remembered of it.
    pub(super) fn decode(&mut self, bytes: &[u8]) -> Result<(), Exhausted> {
        let learned = (self.models.clone(), self.motions.clone());
        let read = self.code(Decoder::new(bytes), Motion::default());
        if read.is_ok_and(|decoder| !decoder.is_exhausted() && !decoder.has_rest()) {
            return Ok(());
        }
        (self.models, self.motions) = learned;
        self.drop_current();
        Err(Exhausted)
    }

    /// Codes the current delta.
    ///
    /// # Errors
    /// [`Exhausted`], when reading; what was learned of it stays.
    pub(super) fn code<S: Symbols>(&mut self, mut symbols: S, motion: Motion) -> Result<S, Exhausted> {
        let before = self.motions.last;
        let motion = self.motions.code(&mut symbols, motion);
        self.motions.last = motion;
        for (last, current) in self.last.iter().zip(&mut self.current) {
            let turned = Turned::new(last, before, motion);
            let (sweep, models) = (&mut self.sweep, &mut self.models);
            symbols = with_vectors!(self.vectors, simd => sweep.code(symbols, models, &turned, current))?;
        }
        Ok(symbols)
    }

    /// The current delta becomes the last, and is told to nobody: there is none to whom it would have to be foretold.
    pub(super) fn skip(&mut self, motion: Motion) {
        self.motions.last = motion;
        self.advance();
    }

    /// Forgets the current delta.
    pub(super) fn drop_current(&mut self) {
        self.current.iter_mut().for_each(Plane::clear);
    }

    /// The current delta becomes the last.
    pub(super) fn advance(&mut self) {
        core::mem::swap(&mut self.last, &mut self.current);
        self.drop_current();
    }

    /// Codes differences of which nothing is foretold.
    ///
    /// # Errors
    /// [`Exhausted`], when reading.
    pub(super) fn code_alone<S: Symbols>(
        mut symbols: S,
        models: &mut Models,
        planes: &mut [Plane],
    ) -> Result<S, Exhausted> {
        let (mut sweep, vectors) = (Sweep::default(), Vectors::default());
        for plane in planes {
            let nothing = Plane::unchanged(plane.layout());
            let turned = Turned::new(&nothing, Motion::default(), Motion::default());
            symbols = with_vectors!(vectors, simd => sweep.code(symbols, models, &turned, plane))?;
        }
        Ok(symbols)
    }

    /// Codes all that is remembered, by models that the differences before it have taught.
    ///
    /// # Errors
    /// [`Exhausted`], when reading; what is remembered is then of no use.
    pub(super) fn code_state<S: Symbols>(&mut self, symbols: S, models: &mut Models) -> Result<S, Exhausted> {
        let mut symbols = Self::code_alone(symbols, models, &mut self.last)?;
        self.motions.code_state(&mut symbols);
        self.models.code_state(&mut symbols);
        Ok(symbols)
    }
}
