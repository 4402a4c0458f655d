//! What happens to a client's session, as its caller hears of it.
//!
//! Plain data; what leads to it is the session's affair.
//! Invariant: each error says what the person can do.

use alloc::string::String;

use super::{BringError, ClassEvent, GuidanceEvent};
use crate::prediction::Correction;
use crate::protocol::{self, NoStep, NoTool, Refusal};
use crate::tool::{Orientation, Position, Shape, Side, Tool};

/// Why a session cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClientError {
    /// The server does not let the client in.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// Nothing is wrong yet: a teacher will let the client in, or not.
    #[error("the teacher has not let you in yet")]
    Waiting,
    /// The server says what no server of this version says.
    #[error("the server's answer makes no sense ({0}); is it a pottery studio of this version?")]
    Protocol(#[from] protocol::ProtocolError),
    /// The pot the server describes cannot be made.
    #[error("the server's pot cannot be made: {0}")]
    Pot(String),
    /// Whoever came back found another studio than was left.
    #[error("the studio has other pots or wheels now: join it anew")]
    Otherwise,
    /// The server's time is another than it was, so that nothing that was stamped is worth anything.
    #[error("the studio's time has leapt: join it anew")]
    Leapt,
    /// A tool that the server announces cannot be made.
    #[error("the server's tool {shape} cannot be made: {fault}")]
    Tool {
        /// Its number in the rack.
        shape: u8,
        /// What is wrong with it.
        fault: BringError,
    },
}

/// What the caller may want to know.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientEvent {
    /// The clay was confirmed, and the prediction corrected by so much.
    Confirmed(Correction),
    /// The wheel's or the clay's settings changed.
    Conditions,
    /// There is a tool more in the rack.
    Rack,
    /// The tool that this client brought hangs in the rack.
    Brought(Shape),
    /// The tool that this client brought does not.
    NotBrought(NoTool),
    /// What can be undone and redone has changed.
    Steps,
    /// What was to be undone or redone cannot be.
    NoStep(NoStep),
    /// Something of the lesson was told; [`super::Client::class`] has it.
    Class(ClassEvent),
    /// Something of hands that guide, or of what the pot is to become, was told; [`super::Client::guidance`] has it.
    Guidance(GuidanceEvent),
    /// There is a newer place of the hand that guides this client.
    Hand,
    /// Others hold elsewhere against a wall that bends; the predicted clay knows it.
    Beside,
    /// The server's time is another than it was: what was stamped with the one before is worth nothing, and so is this session. Leave it and join
    /// anew.
    Leapt,
    /// The server stops.
    Closing,
}

/// Somebody's tool as last heard of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemoteTool {
    /// Whose: the number given in the welcome.
    pub client: u16,
    /// The tool; of a convex one that is not in the rack yet, the notice is still on its way.
    pub tool: Tool,
    /// How it is turned.
    pub orientation: Orientation,
    /// Its centre in the room.
    pub centre: Position,
    /// Whether it touches clay.
    pub touching: bool,
    /// On which side of the wall it works.
    pub side: Side,
}

/// How the replica came to its snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCounts {
    /// By pressing again what was pressed.
    pub retold: u64,
    /// By the tiles that changed.
    pub deltas: u64,
    /// Retellings after which the clay was not the author's; each was mended.
    pub unlike: u64,
}
