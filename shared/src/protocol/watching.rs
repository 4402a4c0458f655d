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
    /// How much of it.
    pub detail: DetailWire,
}

/// How much of a wheel is shown. What has a name is said by that, which is short.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode)]
pub enum DetailWire {
    /// To who looks on at one wheel.
    Spectator,
    /// In a small picture among many.
    Gallery,
    /// What was pressed, to who can press it again.
    Retold,
    /// Otherwise.
    Own {
        /// How coarse radii are, in the finest steps: 1 to 256.
        quantum: u16,
        /// Elements that are taken together, each way: 1 to 8.
        fold: u8,
        /// Snapshots of which one is told: 1 to 60.
        every: u8,
        /// First row of tiles that is shown, of the sight's own grid.
        first: u8,
        /// The row after the last; 255 for all from the first up.
        end: u8,
        /// Whether tools are shown.
        tools: bool,
    },
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
