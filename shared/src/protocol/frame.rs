//! Control messages cut out of a stream of bytes.
//!
//! Owns the two bytes of length and nothing of what stands behind them.
//! Invariant: a reader holds no more than one frame and what arrived with its last piece.

use alloc::vec::Vec;

use super::{CONTROL_MAX, ProtocolError};

/// `message` with its length before it, ready for the stream.
///
/// # Panics
/// When the message is longer than [`CONTROL_MAX`].
#[must_use]
pub fn frame(message: &[u8]) -> Vec<u8> {
    assert!(message.len() <= CONTROL_MAX);
    let mut framed = Vec::with_capacity(message.len() + 2);
    framed.extend_from_slice(&(message.len() as u16).to_le_bytes());
    framed.extend_from_slice(message);
    framed
}

/// Collects the pieces of a stream and hands out whole frames.
#[derive(Debug, Default)]
pub struct FrameReader {
    held: Vec<u8>,
}

impl FrameReader {
    /// Takes in what arrived.
    pub fn push(&mut self, piece: &[u8]) {
        self.held.extend_from_slice(piece);
    }

    /// The next whole frame, without its length.
    ///
    /// # Errors
    /// [`ProtocolError::TooLong`] when the peer announces a longer frame than allowed; the stream is then useless.
    pub fn next_frame(&mut self) -> Result<Option<Vec<u8>>, ProtocolError> {
        let Some((length, rest)) = self.held.split_first_chunk::<2>() else { return Ok(None) };
        let length = usize::from(u16::from_le_bytes(*length));
        if length > CONTROL_MAX {
            return Err(ProtocolError::TooLong { bytes: length, limit: CONTROL_MAX });
        }
        if rest.len() < length {
            return Ok(None);
        }
        let message = rest[..length].to_vec();
        self.held.drain(..length + 2);
        Ok(Some(message))
    }
}
