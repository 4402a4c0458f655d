//! How people come to the room, come back to it, and leave.
//!
//! Owns the order of what is looked at before somebody is let in; doors and seats are others'.
//! Invariant: whoever is refused has changed nothing.

use super::bench;
use super::{Lane, PeerId, Room, WRONG_CODES_MAX};
use crate::clay::{Method, PotSpec};
use crate::protocol::{self, Hello, Notice, Pass, PlaceWire, Purpose, Refusal, ResumeToken, Role};
use crate::room::rights::may_press;
use crate::session::{Peer, PeerError};

/// Somebody at the door.
#[derive(Debug)]
pub(super) struct Waiting {
    purpose: Purpose,
    resume: Option<ResumeToken>,
}

impl Room {
    /// Hears a greeting.
    pub(super) fn let_in(&mut self, peer: PeerId, frame: &[u8]) -> Result<(), PeerError> {
        let hello = Peer::read_greeting(frame)?;
        let back = hello.pass.resume().and_then(|token| self.people.of_token(token));
        if let Some(client) = back.filter(|client| self.is_as_before(*client, &hello)) {
            return self.take_back_in(peer, client, &hello);
        }
        let role = self.role_of(peer, &hello)?;
        if self.people() >= usize::from(self.config.people_max) {
            return Err(Refusal::Full { people: self.config.people_max }.into());
        }
        let place = match hello.purpose {
            Purpose::Works { .. } => Some(self.place_of(hello.wheel, role)?),
            Purpose::Watches { .. } => None,
        };
        let (client, resume) = self.people.add(peer, role, place, &mut self.doors);
        if self.doors.has_lobby && role != Role::Teacher {
            if let Some(person) = self.people.person_mut(client) {
                person.is_waiting = true;
            }
            self.lobby.insert(peer, Waiting { purpose: hello.purpose, resume });
            self.send(peer, Lane::Control(Peer::notice(&Notice::Waiting)));
        } else {
            self.welcome(peer, client, hello.purpose, resume);
        }
        Ok(())
    }

    /// Whether who comes back may do what it comes for: a guest who wants to work comes as somebody new.
    fn is_as_before(&self, client: u16, hello: &Hello) -> bool {
        let is_guest = self.people.person(client).is_some_and(|person| person.role == Role::Guest);
        !is_guest || matches!(hello.purpose, Purpose::Watches { .. })
    }

    /// As what somebody who greets so may come in.
    fn role_of(&mut self, peer: PeerId, hello: &Hello) -> Result<Role, Refusal> {
        let checked = match &hello.pass {
            Pass::Teacher(token) | Pass::Return(_, token) if self.doors.is_teachers(token) => return Ok(Role::Teacher),
            Pass::Teacher(_) => Err(Refusal::Token),
            Pass::None | Pass::Resume(_) | Pass::Return(..) => self.doors.check(&hello.code, self.now),
        };
        if let Err(Refusal::Code | Refusal::Token) = checked {
            if self.wrong_codes.len() == WRONG_CODES_MAX {
                self.wrong_codes.pop_front();
            }
            self.wrong_codes.push_back(peer);
        }
        checked.map(|()| match hello.purpose {
            Purpose::Works { .. } => Role::Student,
            Purpose::Watches { .. } => Role::Guest,
        })
    }

    /// The place that a wheel's number means, if people may come to it.
    fn place_of(&self, wheel: u16, role: Role) -> Result<usize, Refusal> {
        let place = usize::from(wheel).wrapping_sub(1);
        match self.benches.get(place) {
            None => Err(Refusal::Wheel { wheel, wheels: self.config.wheels }),
            Some(bench) if bench.is_closed() && role != Role::Teacher => Err(Refusal::WheelClosed { wheel }),
            Some(_) => Ok(place),
        }
    }

    /// Gives somebody who comes back its seat, its name and its number; a connection that it still had is let go.
    fn take_back_in(&mut self, peer: PeerId, client: u16, hello: &Hello) -> Result<(), PeerError> {
        let Some(person) = self.people.person(client) else { return Ok(()) };
        if person.peer.is_none() && self.people() >= usize::from(self.config.people_max) {
            return Err(Refusal::Full { people: self.config.people_max }.into());
        }
        let place = match hello.purpose {
            Purpose::Works { .. } => match person.place {
                Some(place) => Some(place),
                None => Some(self.place_of(hello.wheel, person.role)?),
            },
            Purpose::Watches { .. } => None,
        };
        if let Some(before) = self.people.reconnect(client, peer) {
            self.lobby.remove(&before);
            self.let_go(before);
            self.send(before, Lane::Close);
        }
        if let Some(person) = self.people.person_mut(client) {
            // who teaches and has looked on; a student works as long as the teacher says so
            person.works |= person.role == Role::Teacher && person.place.is_none() && place.is_some();
            person.place = place;
        }
        if let Some(place) = place {
            // what it had sent and was not pressed yet is no longer waited for
            self.benches[place].drop_client(client, self.now, &mut self.counts.refusals);
        }
        self.welcome(peer, client, hello.purpose, None);
        Ok(())
    }

    /// Gives somebody what it needs to begin.
    fn welcome(&mut self, peer: PeerId, client: u16, purpose: Purpose, resume: Option<ResumeToken>) {
        self.counts.joined += 1;
        self.people.is_changed = true;
        let place = self.people.person(client).and_then(|person| person.place);
        match (purpose, place) {
            (Purpose::Works { retells }, Some(place)) => {
                self.places.insert(peer, place);
                self.make_busy(place);
                self.benches[place].seat(peer, client, retells, self.now, &mut self.outbox);
            }
            (Purpose::Watches { bytes_per_s }, _) => self.seat_viewer(peer, bytes_per_s),
            (Purpose::Works { .. }, None) => {}
        }
        if self.has_target() {
            self.tell_target(peer);
        }
        self.tell_place(client, resume);
        if self.has_target() && self.people.person(client).is_some_and(|person| person.role == Role::Teacher) {
            self.begin_progress();
        }
    }

    fn seat_viewer(&mut self, peer: PeerId, bytes_per_s: u32) {
        self.audience.let_in(peer, bytes_per_s, self.now);
        let spec = PotSpec { keeps_volume: self.config.method.keeps_volume(), ..self.config.pot };
        let notice = Notice::Audience(protocol::Audience {
            now: self.now.0,
            wheels: self.config.wheels,
            pot: bench::pot_wire(&spec),
            method: self.config.method.number(),
        });
        self.send(peer, Lane::Control(Peer::notice(&notice)));
    }

    /// Tells somebody where it is, and sees that what it presses counts or does not.
    pub(super) fn tell_place(&mut self, client: u16, resume: Option<ResumeToken>) {
        let Some(person) = self.people.person_mut(client) else { return };
        let Some(peer) = person.peer.filter(|_| !person.is_waiting) else { return };
        let works = person.works && may_press(person.role);
        let may_press = match person.place.and_then(|place| self.benches.get_mut(place)) {
            Some(bench) => {
                bench.set_works(peer, works);
                works && !bench.is_held()
            }
            None => false,
        };
        person.told_may_press = may_press;
        let place =
            PlaceWire { client, role: person.role, name: person.name, wheel: person.wheel(), may_press, resume };
        self.send(peer, Lane::Control(Peer::notice(&Notice::Place(place))));
    }

    /// Lets somebody in who waits, or sends them away.
    pub(super) fn admit(&mut self, client: u16, is_admitted: bool) {
        let Some(peer) = self.people.person(client).and_then(|person| person.peer) else { return };
        let Some(Waiting { purpose, resume }) = self.lobby.remove(&peer) else { return };
        if is_admitted {
            if let Some(person) = self.people.person_mut(client) {
                person.is_waiting = false;
            }
            return self.welcome(peer, client, purpose, resume);
        }
        self.counts.refused += 1;
        self.send(peer, Lane::Control(Peer::notice(&Notice::Refused(Refusal::NotAdmitted))));
        self.send(peer, Lane::Close);
        self.people.forget(client);
    }

    /// Takes a connection from its wheel, its sights and the door.
    pub(super) fn let_go(&mut self, peer: PeerId) {
        self.end_leads_of(peer);
        if let Some(place) = self.places.remove(&peer) {
            self.benches[place].leave(peer);
        }
        self.audience.leave(peer, &mut self.benches);
        self.lobby.remove(&peer);
    }

    /// Somebody leaves for good, or is sent home.
    pub(super) fn say_goodbye(&mut self, peer: PeerId) {
        self.send(peer, Lane::Close);
        self.let_go(peer);
        if let Some(client) = self.people.number(peer) {
            self.people.forget(client);
        }
    }

    /// From now on, a wheel is visited in every tick, until it has nothing to do.
    pub(super) fn make_busy(&mut self, place: usize) {
        if let Err(at) = self.busy.binary_search(&place) {
            self.busy.insert(at, place);
        }
    }
}
