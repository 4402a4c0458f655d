//! What is said of a teacher's hand on a student's, and of what a pot is to become.
//!
//! Plain data as all messages are; which role may ask for what is the room's affair.
//! Invariant: a hand is told of with the tick at which it was there, so that nobody needs to know how late it is.

use alloc::vec::Vec;
use bincode::{Decode, Encode};

use super::ShapeWire;

/// In which way and how strongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct GuidanceWire {
    /// Number of the way, [`GuidanceMode::number`](crate::haptics::GuidanceMode::number).
    pub mode: u8,
    /// Percent, 0 to 100.
    pub strength: u8,
}

/// Who guides whom, and how; told to both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct LeadWire {
    /// The number of the teacher.
    pub teacher: u16,
    /// The number of the student.
    pub student: u16,
    /// How.
    pub guidance: GuidanceWire,
}

/// Where a hand is that guides, whether it presses clay or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct HandWire {
    /// When it was there.
    pub tick: u64,
    /// Where, in steps of 10 µm.
    pub centre: [i32; 3],
    /// Its tool, and how it is turned.
    pub tool: ShapeWire,
    /// The force that it feels, mN.
    pub force_mn: u16,
    /// Whether it draws a line on the student's pot.
    pub draws: bool,
    /// Whether it works inside of the pot.
    pub inside: bool,
}

/// Why a student is guided no longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum GuidanceEnd {
    /// The teacher has let go.
    Teacher,
    /// The student has.
    Student,
    /// One of both has left, or lost the connection.
    Gone,
    /// Another teacher guides the student now, or the teacher another student.
    Replaced,
}

/// Why somebody is not guided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, thiserror::Error)]
pub enum NoGuidance {
    /// Only a teacher guides.
    #[error("only a teacher can guide a hand")]
    NotTeacher,
    /// Nobody of that number works at a wheel.
    #[error("nobody of that number works at a wheel; choose one of those who are here")]
    Nobody,
    /// One hand cannot guide itself.
    #[error("a hand cannot guide itself; choose a student")]
    Oneself,
    /// The teacher has no hand at a wheel.
    #[error("who guides needs a tool in the hand: take a place at a wheel first")]
    NoHand,
    /// There is no such way of guiding, or no such profile.
    #[error("the server does not know that way of guiding; is it of another version?")]
    Unknown,
}

/// How far the pot of a wheel is from what it is to become, m; told to who teaches.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct ProgressWire {
    /// The number of the wheel, from 1.
    pub wheel: u16,
    /// The profile of its pot.
    pub is: TargetWire,
    /// Root of the mean of the squares.
    pub rms_m: f32,
    /// The largest, and the height at which it is.
    pub most_m: f32,
    /// The height of the largest.
    pub most_at_m: f32,
}

/// What pots are to become: the radius at even heights from foot to rim.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct TargetWire {
    /// Height, m.
    pub height_m: f32,
    /// Radii, in steps of 4 µm.
    pub radii: Vec<u16>,
}
