//! What client and server say to each other, and how it lies in bytes.
//!
//! The only module that names the serialiser. Wire types are separate from core types; `session` and `room` convert.
//! Invariant: decoding what a peer sent returns a message or an error, allocates no more than the message's limit
//! allows, and leaves no byte unread.
//!
//! Layout: bincode 2 (`standard`: little-endian variable-length integers, zigzag for signed ones), one message to a
//! datagram, a control frame (two bytes of length, little-endian, before each) or a whole stream (keyframes). Samples and
//! grid contents are bits of a range coder. Changing anything here means raising [`VERSION`].

mod class;
mod code;
mod frame;
mod guidance;
mod inputs;
mod messages;
mod token;
mod watching;

pub use class::{
    ClassWire, Nickname, NoOrder, Order, Pass, PersonWire, PlaceWire, PotOf, Presence, ResumeToken, Role, TeacherToken,
    WheelInfo,
};
pub use code::{JoinCode, JoinCodeError};
pub use frame::{FrameReader, frame};
pub use guidance::{GuidanceEnd, GuidanceWire, HandWire, LeadWire, NoGuidance, ProgressWire, TargetWire};
pub use inputs::{Inputs, Run, ShapeWire};
pub use messages::{
    Audience, Body, ClayWire, Fragment, FragmentOf, Greeting, Hello, Keyframe, MeshWire, NoStep, NoTool, Notice,
    POT_PIECE, PotWire, Pulse, PulseHead, Purpose, Refusal, Request, Retelling, Sight, StepsWire, ToolWire, Upload,
    Welcome, WheelWire,
};
pub use token::TokenError;
pub use watching::{DetailWire, NewsOf, NewsWire, SightName};

use alloc::vec::Vec;
use bincode::config::{Configuration, Limit, LittleEndian, Varint};
use bincode::{Decode, Encode};

/// Version of everything in this module.
pub const VERSION: u16 = 48;
/// Code with which a server closes a connection on which it heard no greeting in time.
pub const CLOSED_UNHEARD: u32 = 2;
/// Protocol name in the TLS handshake (ALPN).
pub const ALPN: &[u8] = b"pottery/1";
/// Largest datagram that is sent unasked: what fits the smallest path that QUIC allows, and browsers.
pub const DATAGRAM_MAX: usize = 1150;
/// Largest datagram that a server sends where the path is seen to take it: an Ethernet's, less what QUIC, UDP and IP put around it.
pub const DATAGRAM_LONGEST: usize = 1400;
/// Most memory that decoding a datagram may take.
pub const DATAGRAM_MEMORY_MAX: usize = 16 * 1024;
/// Largest control frame, without its length: a tool of as many triangles as may be brought, and as much again by a quarter.
pub const CONTROL_MAX: usize = 24 * 1024;
/// Largest keyframe stream: the biggest grid at four bytes an element.
pub const KEYFRAME_MAX: usize = 16 << 20;

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// Longer than any message of its kind; drop it.
    #[error("{bytes} bytes are more than the {limit} allowed")]
    TooLong {
        /// Length found.
        bytes: usize,
        /// Length allowed.
        limit: usize,
    },
    /// No message; drop it.
    #[error("{bytes} bytes are no message of this protocol")]
    Malformed {
        /// Length found.
        bytes: usize,
    },
}

const fn wire<const LIMIT: usize>() -> Configuration<LittleEndian, Varint, Limit<LIMIT>> {
    bincode::config::standard().with_limit::<LIMIT>()
}

/// The bytes of a message.
///
/// # Panics
/// When the message cannot be encoded, which no message type of this module allows.
#[must_use]
pub fn encode(message: &impl Encode) -> Vec<u8> {
    bincode::encode_to_vec(message, bincode::config::standard()).expect("every wire type can be encoded")
}

/// The message in all of `bytes`; `LIMIT` bounds what decoding may take.
///
/// # Errors
/// [`ProtocolError`] when the bytes are too long, no such message, or more than one.
pub fn decode<const LIMIT: usize, M: Decode<()>>(bytes: &[u8]) -> Result<M, ProtocolError> {
    if bytes.len() > LIMIT {
        return Err(ProtocolError::TooLong { bytes: bytes.len(), limit: LIMIT });
    }
    match bincode::decode_from_slice(bytes, wire::<LIMIT>()) {
        Ok((message, read)) if read == bytes.len() => Ok(message),
        _ => Err(ProtocolError::Malformed { bytes: bytes.len() }),
    }
}
