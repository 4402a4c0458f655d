//! The pure core of the pottery studio: everything that decides what the clay does.
//!
//! `#![no_std]`: no clock, no socket, no thread, no file and no randomness that is not passed in.
//! Time arrives as a [`units::Tick`]; what a peer sent arrives as bytes.
//! Invariant: the same calls with the same arguments give the same pot, bit for bit, everywhere.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod clay;
mod coding;
pub mod haptics;
mod lanes;
pub mod prediction;
pub mod protocol;
pub mod room;
pub mod session;
pub mod snapshot;
pub mod tool;
pub mod units;
