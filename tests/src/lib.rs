//! Scenarios, network simulator and golden data of the pottery studio.
//!
//! Owns what tests stand on: counted [`allocations`], seeded [`dice`], what a [`line`](mod@line) does to packets, a [`network`] in memory and a
//! [`proxy`] on real sockets; the [`reference`](mod@reference) dents, the [`failures`] that methods
//! are tried for, how firmly a hand holds on in [`stability`], the [`yardstick`] methods of other authors, and a
//! [`twin`] of each haptic device.
//! Invariant: every roll of the dice comes from a seed that the test names.

pub mod allocations;
pub mod chart;
pub mod dent;
pub mod dice;
pub mod failures;
pub mod fit;
pub mod line;
pub mod network;
pub mod programs;
pub mod proxy;
pub mod reference;
pub mod stability;
pub mod transform;
pub mod twin;
pub mod yardstick;
