//! What those who look on say and are told beside the clay.
//!
//! Plain data with the units in the names; every meaning is checked by whoever receives it.
//! Invariant: no message holds a type of another module.

use alloc::vec::Vec;
use bincode::{Decode, Encode};

use super::{ClayWire, MeshWire, WheelWire};

/// Something that can be watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Encode, Decode)]
pub struct SightName {
    /// Number of the wheel, from 1.
    pub wheel: u16,
    /// Number of how much of it.
    pub detail: u8,
}

/// What was told to everybody at a wheel, for those who look on closely.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct NewsWire {
    /// Number of the wheel, from 1.
    pub wheel: u16,
    /// Notices told to everybody there, this one included.
    pub told: u32,
    /// Which it is.
    pub of: NewsOf,
}

/// A notice to everybody at a wheel, as those who look on are told of it.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum NewsOf {
    /// How everything there stands: the first that is told of a wheel. The tools that people brought follow one by one.
    Standing {
        /// The wheel's turning, earliest first, scheduled changes included.
        wheel: Vec<WheelWire>,
        /// What the clay is made of and the tick from which it is, earliest first.
        clay: Vec<(u64, ClayWire)>,
    },
    /// The wheel's turning changes.
    Wheel {
        /// First tick of the new turning.
        from: u64,
        /// Phase steps a tick.
        rate: i32,
    },
    /// The clay becomes another.
    Clay {
        /// First tick at which it is.
        from: u64,
        /// What it is made of.
        clay: ClayWire,
    },
    /// A tool hangs in the rack.
    Tool {
        /// Its number.
        shape: u8,
        /// Its surface.
        mesh: MeshWire,
    },
}
