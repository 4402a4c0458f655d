//! The client's own clay: unacknowledged presses replayed over the confirmed snapshot.
//!
//! Holds no clock and no socket. Three parts: a [`Field`] is clay with one person's samples applied up to a tick;
//! the [`Predictor`] keeps one beside the network; the [`Hand`] keeps one beside the device and takes over the
//! predictor's corrections a few samples at a time.
//! Invariant: where nobody else presses, the predicted clay is the authoritative one, bit for bit.

mod field;
mod ground;
mod hand;
mod milestones;
mod predictor;

pub use field::Field;
pub use hand::{Hand, Patch};
pub use predictor::{Correction, Pending, Predictor};
