//! Scenarios, network simulator and golden data of the pottery studio.
//!
//! Owns what tests stand on: counted [`allocations`], seeded [`dice`], what a [`line`](mod@line) does to packets and a
//! [`proxy`] on real sockets (the client's, with which people rehearse), a [`network`] in memory and the
//! [`simulation`] of a studio over it; the [`reference`](mod@reference) dents, the [`failures`] that methods
//! are tried for, a [`display`] with the studio on it, those who are [`looking`] on, the [`load`] that a server is put under, how firmly a hand holds on in
//! [`stability`], the [`yardstick`] methods of other authors, the linear systems that those and laws of cost are solved by, a
//! [`twin`] of each haptic device, and what programs have [`printed`].
//! Invariant: every roll of the dice comes from a seed that the test names.

pub mod allocations;
pub mod chart;
pub mod dent;
pub mod display;
pub mod failures;
pub mod fit;
mod linear;
pub mod load;
pub mod looking;
pub mod network;
pub mod printed;
pub mod programs;
pub mod reference;
pub mod simulation;
pub mod stability;
pub mod transform;
pub mod twin;
pub mod yardstick;

pub use pottery_client::rehearsal::{dice, line, proxy};
