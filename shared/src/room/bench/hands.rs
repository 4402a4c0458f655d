//! Hands that guide: what a teacher at this wheel shows, and what a student at it is shown.
//!
//! Owns nothing: both lie with the peers; who guides whom is the room's affair.
//! Invariant: no clay is changed here.

use super::Bench;
use crate::protocol::HandWire;
use crate::room::PeerId;

impl Bench {
    /// The newest place of a hand that guides.
    pub(in crate::room) fn hand(&self, peer: PeerId) -> Option<HandWire> {
        self.seats.get(&peer)?.peer.hand().copied()
    }

    /// Shows a hand to a peer with its next pulse, or none any more.
    pub(in crate::room) fn show_hand(&mut self, peer: PeerId, hand: Option<HandWire>) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.peer.show_hand(hand);
        }
    }
}
