//! A worse network than there is, so that people can feel it and tests can try it.
//!
//! Owns what a [`line`](mod@line) does to packets, seeded [`dice`] for it and a [`proxy`] that carries real packets over such lines; never
//! looks into a packet.
//! Invariant: every roll of the dice comes from a seed that the caller names.

pub mod dice;
pub mod line;
pub mod proxy;
