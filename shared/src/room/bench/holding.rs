//! A wheel that is frozen or closed, people at it who only look on, and clay that a teacher puts there.
//!
//! Owns whether what is pressed counts; who may say so is the room's affair.
//! Invariant: what does not count is taken out and acknowledged, so that nothing waits for a wheel to thaw.

use super::{Bench, Seat, TOOL_SHOWN_TICKS};
use crate::clay::Form;
use crate::protocol::NoOrder;
use crate::room::PeerId;
use crate::room::history::{Anew, Step};
use crate::room::journal::Happening;
use crate::session::Refusals;
use crate::snapshot::KeptClay;
use crate::units::Tick;

/// What keeps everybody's presses from counting.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hold {
    is_frozen: bool,
    is_closed: bool,
}

impl Hold {
    /// Whether what a seat presses counts.
    pub(super) const fn counts(self, seat: &Seat) -> bool {
        seat.works && !self.is_frozen && !self.is_closed
    }
}

impl Bench {
    pub(in crate::room) const fn freeze(&mut self, is_frozen: bool) {
        self.hold.is_frozen = is_frozen;
    }

    pub(in crate::room) const fn close(&mut self, is_closed: bool) {
        self.hold.is_closed = is_closed;
    }

    pub(in crate::room) const fn is_frozen(&self) -> bool {
        self.hold.is_frozen
    }

    pub(in crate::room) const fn is_closed(&self) -> bool {
        self.hold.is_closed
    }

    /// Whether nobody's press counts.
    pub(in crate::room) const fn is_held(&self) -> bool {
        self.hold.is_frozen || self.hold.is_closed
    }

    /// Whether what a peer presses counts.
    pub(in crate::room) fn may_press(&self, peer: PeerId) -> bool {
        self.seats.get(&peer).is_some_and(|seat| self.hold.counts(seat))
    }

    /// Says whether a peer works here, or looks on.
    pub(in crate::room) fn set_works(&mut self, peer: PeerId, works: bool) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.works = works;
        }
    }

    /// Takes somebody's seats away at once; what was not pressed yet is not pressed any more.
    pub(in crate::room) fn drop_client(&mut self, client: u16, now: Tick, gone: &mut Refusals) {
        let before = self.seats.len();
        self.seats.retain(|_, seat| {
            if seat.client == client {
                gone.add(seat.peer.inputs().refusals());
            }
            seat.client != client
        });
        if self.seats.len() < before {
            self.note(now, Happening::Left { client });
        }
    }

    /// The numbers of those whose tools touch clay.
    pub(in crate::room) fn touching(&self, tick: Tick) -> impl Iterator<Item = u16> {
        let tools = self.present().filter_map(move |(_, seat)| seat.peer.tool(seat.client, tick, TOOL_SHOWN_TICKS));
        tools.filter(|tool| tool.touching).map(|tool| tool.client)
    }

    /// Puts new clay here at the next snapshot, as a step of a client: that with which the wheel began where it does not go into the form.
    pub(in crate::room) fn begin_anew(&mut self, client: u16, form: Option<Form>) {
        let form = form.filter(|form| form.check_clay_of(&self.pot).is_ok());
        let step = self.history.step(Step::Anew(Anew::Form(form)), client, Tick(0), &self.pot);
        debug_assert!(step.is_ok(), "there can always be new clay");
    }

    /// Puts clay here at the next snapshot, as a step of a client.
    pub(in crate::room) fn put(&mut self, client: u16, clay: KeptClay) {
        self.history.put(client, clay);
    }

    /// Puts the clay of a tick here as soon as it is made again, as a step of a client.
    ///
    /// # Errors
    /// [`NoOrder::TooLongAgo`].
    pub(in crate::room) fn go_back(&mut self, client: u16, to: u64) -> Result<(), NoOrder> {
        self.history.go_back(client, Tick(to)).map_err(|Tick(oldest)| NoOrder::TooLongAgo { oldest })
    }

    /// Undoes the newest step of a client; false when there is none.
    pub(in crate::room) fn take_back(&mut self, client: u16, now: Tick) -> bool {
        self.history.step(Step::Back, client, now, &self.pot).is_ok()
    }

    /// When the newest snapshot was taken.
    pub(in crate::room) const fn snapshot_tick(&self) -> Tick {
        self.snapshot_tick
    }

    /// Whether a tick has something to do here.
    pub(in crate::room) fn has_work(&self) -> bool {
        !self.seats.is_empty() || self.history.has_work() || self.history.has_unkept()
    }
}
