//! The state of a connection, for both ends: what arrived (`handle_*`) and what to send (`poll_*`).
//!
//! Holds no socket and no clock; bytes and time are arguments.
//! Invariant: whatever a peer sends, a session answers with an event, an error or a counted refusal, and holds bounded
//! memory.

mod allowance;
mod assembly;
mod class;
mod clay;
mod client;
mod course;
mod effort;
mod events;
mod guidance;
mod inputs;
mod lead;
mod mending;
mod pace;
mod peer;
mod putting;
mod redundancy;
mod retelling;
mod runs;
mod setting;
mod tools;
mod watched;
mod watcher;
mod welcome;

pub use allowance::Allowance;
pub use assembly::WAITING_BYTES_MAX;
pub use class::{ClassEvent, ClassView, Progress, greeting};
pub use client::Client;
pub use course::Implausible;
pub use events::{ClientError, ClientEvent, RemoteTool, StepCounts};
pub use guidance::{
    GuidanceEvent, GuidancePair, GuidanceView, GuidingHand, guidance_of, guidance_wire, hand_of, hand_wire, target_of,
    target_wire,
};
pub use inputs::{InputQueue, Refusals};
pub use lead::Lead;
pub use mending::MendCounts;
pub use pace::{Pace, Telling};
pub use peer::{Peer, PeerError};
pub use putting::{PutError, fitted};
pub use runs::{Packed, pack};
pub(crate) use tools::with_one_more;
pub use tools::{BROUGHT_MAX, BROUGHT_TRIANGLES_MAX, BringError, mesh_of, tool_of};
pub use watched::Watched;
pub use watcher::Watcher;

/// Longest list of tiles' digests that fits into a control frame; who has more tiles asks for the whole pot.
const MEND_BYTES_MAX: usize = crate::protocol::CONTROL_MAX - 16;
