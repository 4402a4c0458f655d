//! Pots that people bring to a wheel, piece by piece.
//!
//! Owns when a pot is whole and whether it is one of this wheel; how it takes the place of the clay is the history's affair, as for every
//! other step.
//! Invariant: of a pot that is coming, no more is kept for a peer than the radii of the wheel's own grid, and no more than one that is whole waits
//! for its turn.

use super::Bench;
use crate::protocol::{NoStep, Notice, POT_PIECE};
use crate::room::history::{Anew, Step};
use crate::room::{Lane, Outbox, PeerId, Transmit};
use crate::session::Peer;
use crate::snapshot::{KeptClay, PotRecord};
use crate::units::Tick;

impl Bench {
    /// Whether a piece is the next of a pot that a peer brings.
    pub(in crate::room) fn awaits(&self, peer: PeerId, piece: u16) -> bool {
        self.seats.get(&peer).is_some_and(|seat| seat.coming.len() == usize::from(piece) * POT_PIECE)
    }

    /// Takes in a piece of a pot from a peer, whose newest sample is of tick `held`; the last one asks for the pot to be put here. One that does not
    /// go on from what is there undoes it, and a pot that is none of this wheel's is told to the peer with its last piece.
    pub(in crate::room) fn take_piece(
        &mut self,
        peer: PeerId,
        held: u64,
        piece: u16,
        bytes: &[u8],
        now: Tick,
        outbox: &mut Outbox,
    ) {
        let Some(seat) = self.seats.get_mut(&peer) else { return };
        let spec = *self.pot.spec();
        let whole = 2 * spec.skins() * spec.shape.elements();
        let begins = usize::from(piece) * POT_PIECE;
        if piece == 0 {
            seat.coming.clear();
        }
        let is_next = begins == seat.coming.len() && bytes.len() == whole.saturating_sub(begins).min(POT_PIECE);
        if is_next {
            // what grows by itself is up to three times as long
            seat.coming.reserve_exact(whole - begins);
            seat.coming.extend_from_slice(bytes);
        } else {
            seat.coming.clear();
        }
        if !(begins..=begins + POT_PIECE).contains(&whole) {
            return;
        }
        let planes = core::mem::take(&mut seat.coming);
        match PotRecord::of_planes(spec, &planes) {
            Ok(record) => {
                self.wishes.retain(|wish| !wish.is_clay_of(peer));
                self.ask_step(peer, Step::Anew(Anew::Clay(KeptClay::of(&record.pot()))), held, now);
            }
            Err(_) => {
                let notice = Peer::notice(&Notice::NoStep(NoStep::NoPot));
                outbox.push_back(Transmit { to: peer, lane: Lane::Control(notice) });
            }
        }
    }
}
