//! How far a long measurement is.
//!
//! Owns the count of pieces; who tells the user, and how, is the caller's.
//! Invariant: no more pieces are told of than were expected.

/// What is going on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// Pieces that are finished.
    pub done: u32,
    /// Pieces in all.
    pub of: u32,
    /// The piece that begins.
    pub what: &'a str,
}

/// Counts the pieces of the work and tells of each when it begins.
pub struct Progress<'a> {
    done: u32,
    of: u32,
    tell: Box<dyn FnMut(&Piece<'_>) + 'a>,
}

impl<'a> Progress<'a> {
    /// Progress that calls `tell` at every piece.
    pub fn new(tell: impl FnMut(&Piece<'_>) + 'a) -> Self {
        Self { done: 0, of: 0, tell: Box::new(tell) }
    }

    /// Progress that tells nobody.
    #[must_use]
    pub fn silent() -> Self {
        Self::new(|_| {})
    }

    /// So many pieces are to come.
    pub(super) fn expect(&mut self, pieces: u32) {
        self.of += pieces;
    }

    /// A piece begins.
    pub(super) fn begin(&mut self, what: &str) {
        (self.tell)(&Piece { done: self.done.min(self.of), of: self.of, what });
        self.done += 1;
    }
}
