//! The server's end of a connection: the greeting, requests and samples of one client.
//!
//! Owns what one client may say; what it does to the clay is the room's affair.
//! Invariant: nothing but a sound greeting is heard from a peer that has not been let in.

use alloc::vec::Vec;

use bytes::Bytes;

use super::inputs::InputQueue;
use super::runs;
use super::{Allowance, hand_of};
use crate::protocol::{self, Greeting, HandWire, Hello, Notice, Pulse, PulseHead, Refusal, Request, ToolWire, Upload};
use crate::tool::{Position, Side, ToolSample};
use crate::units::Tick;

/// What a peer said that cannot be answered; close the connection.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PeerError {
    /// It may not come in, and is told why.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// It does not speak this protocol.
    #[error(transparent)]
    Protocol(#[from] protocol::ProtocolError),
}

/// One client's connection, as the server sees it.
#[derive(Debug, Default)]
pub struct Peer {
    inputs: InputQueue,
    last: Option<(ToolSample, bool)>,
    allowance: Allowance,
    /// When its line last lost something.
    lost_at: Option<Tick>,
    /// Where its hand is, when it last said so.
    hand: Option<HandWire>,
    /// The hand that guides it, to be shown.
    teacher: Option<HandWire>,
}

impl Peer {
    /// How long a line that lost something counts as one that loses.
    const LOSSY_TICKS: i64 = 10_000;

    /// Reads the first frame of a connection.
    ///
    /// # Errors
    /// [`PeerError`] for another version or no greeting at all.
    pub fn read_greeting(frame: &[u8]) -> Result<Hello, PeerError> {
        let greeting: Greeting =
            protocol::decode::<{ protocol::CONTROL_MAX }, _>(frame).map_err(|_| Refusal::Greeting)?;
        if greeting.magic != Greeting::MAGIC {
            return Err(Refusal::Greeting.into());
        }
        let client = u16::from_le_bytes(greeting.version);
        if client != protocol::VERSION {
            return Err(Refusal::Version { server: protocol::VERSION, client }.into());
        }
        Ok(protocol::decode::<{ protocol::CONTROL_MAX }, _>(&greeting.hello).map_err(|_| Refusal::Greeting)?)
    }

    /// Reads a later frame.
    ///
    /// # Errors
    /// [`PeerError::Protocol`] when it is no request.
    pub fn read_request(frame: &[u8]) -> Result<Request, PeerError> {
        Ok(protocol::decode::<{ protocol::CONTROL_MAX }, _>(frame)?)
    }

    /// Whether a request may be answered; see [`Allowance::grant`]. A request too many is counted and not answered.
    pub fn may_ask(&mut self, now: Tick, cost: i64) -> bool {
        let may = self.allowance.grant(now, cost);
        if !may {
            self.inputs.count_request();
        }
        may
    }

    /// Notes that something did not arrive.
    pub const fn note_loss(&mut self, now: Tick) {
        self.lost_at = Some(now);
    }

    /// Whether its line has lost something lately, so that what it carries is better said twice.
    #[must_use]
    pub fn loses(&self, now: Tick) -> bool {
        self.lost_at.is_some_and(|lost_at| now.since(lost_at) < Self::LOSSY_TICKS)
    }

    /// A notice ready for the control stream.
    #[must_use]
    pub fn notice(notice: &Notice) -> Vec<u8> {
        protocol::frame(&protocol::encode(notice))
    }

    /// Takes in a datagram while `now` is the next tick to be done and the rack has so many `tools`; refusals are counted.
    /// The version from which it wants to be told again, if it misses something.
    pub fn handle_datagram(&mut self, bytes: &[u8], now: Tick, tools: usize) -> Option<u32> {
        match protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, Upload>(bytes) {
            Ok(Upload { inputs, hand, again }) => {
                self.inputs.handle_inputs(&inputs, now, tools);
                // datagrams overtake each other, and a hand of a time far ahead would be the newest for long
                let is_newest = |hand: &HandWire| {
                    Tick(hand.tick).since(now) <= InputQueue::FUTURE_MAX
                        && self.hand.is_none_or(|known| hand.tick > known.tick)
                };
                self.hand = hand.filter(|hand| is_newest(hand) && hand_of(0, hand).is_some()).or(self.hand);
                again
            }
            Err(_) => {
                self.inputs.count_malformed();
                None
            }
        }
    }

    /// Where its hand was, when it last said so.
    #[must_use]
    pub const fn hand(&self) -> Option<&HandWire> {
        self.hand.as_ref()
    }

    /// Shows the hand that guides it with the next datagram, or none.
    pub const fn show_hand(&mut self, hand: Option<HandWire>) {
        self.teacher = hand;
    }

    /// Its samples.
    #[must_use]
    pub const fn inputs(&self) -> &InputQueue {
        &self.inputs
    }

    /// The oldest sample that is due, taken out.
    pub fn take_due(&mut self, tick: Tick) -> Option<ToolSample> {
        self.inputs.take_due(tick)
    }

    /// The sample of its tool that was pressed last.
    #[must_use]
    pub fn last_sample(&self) -> Option<&ToolSample> {
        self.last.as_ref().map(|(sample, _)| sample)
    }

    /// Notes where the tool was pressed last, and whether it touched.
    pub const fn note_tool(&mut self, sample: ToolSample, touching: bool) {
        self.last = Some((sample, touching));
    }

    /// Its tool as others should see it, when it moved within `ticks` before `now`.
    #[must_use]
    pub fn tool(&self, client: u16, now: Tick, ticks: i64) -> Option<ToolWire> {
        let (sample, touching) = self.last.filter(|(sample, _)| now.since(sample.tick) < ticks)?;
        let Position(centre) = sample.centre;
        let (tool, inside) = (runs::shape_of(sample.tool, sample.orientation), sample.side == Side::Inside);
        Some(ToolWire { client, centre, tool, touching, inside })
    }

    /// Whether there is something that this client alone has to be told soon.
    #[must_use]
    pub fn has_word(&self) -> bool {
        self.teacher.is_some() || !self.inputs.is_quiet()
    }

    /// What is said to this client alone, with the number below which the latest snapshot holds its samples.
    pub const fn pulse_head(&mut self, acknowledged: u32) -> PulseHead {
        PulseHead { acknowledged, slack: self.inputs.take_slack(), teacher: self.teacher }
    }

    /// A head and an encoded body make a datagram, since a message is the bytes of its fields in order.
    #[must_use]
    pub fn pulse(head: &PulseHead, body: &[u8]) -> Bytes {
        let head = protocol::encode(head);
        // exactly as long as it is, so that whoever sends it need not copy it
        let mut bytes = Vec::with_capacity(head.len() + body.len());
        bytes.extend_from_slice(&head);
        bytes.extend_from_slice(body);
        debug_assert!(protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, Pulse>(&bytes).is_ok());
        bytes.into()
    }
}
