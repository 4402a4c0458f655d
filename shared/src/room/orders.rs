//! What a teacher orders: wheels frozen, closed and set, people seated, pots put back, the door, the end of the lesson.
//!
//! Owns the meaning of an order; whoever gives one has been found to teach.
//! Invariant: an order is carried out whole, or its teacher is told why not.

use super::{Lane, PeerId, Room, STEP_COST};
use crate::clay::Form;
use crate::protocol::{NoOrder, Notice, Order, PotOf, Role, TeacherToken};
use crate::session::Peer;
use crate::snapshot::KeptClay;
use crate::units::{Rpm, Tick};

impl Room {
    /// Carries out an order.
    pub(super) fn order(&mut self, peer: PeerId, client: u16, order: &Order) {
        let cost = if matches!(order, Order::Pot { .. } | Order::GoBack { .. }) { STEP_COST } else { 1 };
        let now = self.now;
        if !self.people.person_mut(client).is_some_and(|person| person.allowance.grant(now, cost)) {
            self.counts.forbidden += 1;
            return;
        }
        if let Err(reason) = self.carry_out(client, order) {
            self.send(peer, Lane::Control(Peer::notice(&Notice::NoOrder(reason))));
        }
    }

    /// Carries out an order of somebody who is not in the room but shows the teacher's token.
    ///
    /// # Errors
    /// [`NoOrder::NotTeacher`] for another token, or why it cannot be.
    pub fn order_from_outside(&mut self, token: &TeacherToken, order: &Order) -> Result<(), NoOrder> {
        if !self.doors.is_teachers(token) {
            self.counts.forbidden += 1;
            return Err(NoOrder::NotTeacher);
        }
        self.carry_out(0, order)
    }

    fn carry_out(&mut self, client: u16, order: &Order) -> Result<(), NoOrder> {
        let now = self.now;
        match *order {
            Order::Freeze { wheel, is_frozen } => {
                let places = self.wheels_meant(wheel)?;
                self.benches[places.clone()].iter_mut().for_each(|bench| bench.freeze(is_frozen));
                self.tell_held(places);
            }
            Order::Open { wheel, is_open } => {
                let places = self.wheels_meant(wheel)?;
                self.benches[places.clone()].iter_mut().for_each(|bench| bench.close(!is_open));
                self.tell_held(places);
            }
            Order::WheelSpeed { wheel, rpm } => {
                let places = self.wheels_meant(wheel)?;
                self.benches[places].iter_mut().for_each(|bench| bench.set_wheel_speed(Rpm(rpm), now));
            }
            Order::Clay { wheel, clay } => {
                let places = self.wheels_meant(wheel)?;
                self.benches[places].iter_mut().for_each(|bench| bench.set_clay(clay, now));
            }
            Order::Pot { wheel, of } => {
                let places = self.wheels_meant(wheel)?;
                self.put_pots(client, places, of)?;
            }
            Order::GoBack { wheel, to } => {
                let places = self.wheels_meant(wheel)?;
                // all of them or none
                let newest = self.benches[places.clone()].iter().map(|bench| bench.history().oldest()).max();
                if let Some(Tick(oldest)) = newest.filter(|oldest| *oldest > Tick(to)) {
                    return Err(NoOrder::TooLongAgo { oldest });
                }
                for place in places {
                    self.benches[place].go_back(client, to)?;
                    self.make_busy(place);
                }
            }
            Order::TakeBack { wheel } => {
                let mut outcome = Err(NoOrder::NothingBack);
                for place in self.wheels_meant(wheel)? {
                    if self.benches[place].take_back(client, now) {
                        self.make_busy(place);
                        outcome = Ok(());
                    }
                }
                return outcome;
            }
            Order::Seat { client, wheel, works } => return self.seat_person(client, wheel, works),
            Order::Lock { is_locked } => self.doors.is_locked = is_locked,
            // a room that was given no secret draws none, and has the code that it was given for good
            Order::NewCode => drop(self.doors.renew_code(now)),
            Order::Lobby { is_on } => self.doors.has_lobby = is_on,
            Order::Admit { client: 0, is_admitted } => {
                let all: alloc::vec::Vec<_> =
                    self.people.iter().filter(|(_, person)| person.is_waiting).map(|(client, _)| client).collect();
                all.into_iter().for_each(|client| self.admit(client, is_admitted));
            }
            Order::Admit { client, is_admitted } => {
                self.people.person(client).filter(|person| person.is_waiting).ok_or(NoOrder::Person { client })?;
                self.admit(client, is_admitted);
            }
            Order::End => self.end_lesson(),
        }
        Ok(())
    }

    /// The places that a wheel's number means.
    fn wheels_meant(&self, wheel: u16) -> Result<core::ops::Range<usize>, NoOrder> {
        match usize::from(wheel) {
            0 => Ok(0..self.benches.len()),
            number if number <= self.benches.len() => Ok(number - 1..number),
            _ => Err(NoOrder::Wheel { wheel }),
        }
    }

    /// Tells those at wheels whether what they press counts, where that is otherwise than they were told.
    fn tell_held(&mut self, places: core::ops::Range<usize>) {
        let at = |place: usize| places.contains(&place) && self.benches[place].is_held();
        let news: alloc::vec::Vec<_> = self
            .people
            .here()
            .filter_map(|(client, person, _)| {
                let place = person.place.filter(|place| places.contains(place))?;
                (person.told_may_press != (person.works && !at(place))).then_some(client)
            })
            .collect();
        news.into_iter().for_each(|client| self.tell_place(client, None));
    }

    fn put_pots(&mut self, client: u16, places: core::ops::Range<usize>, of: PotOf) -> Result<(), NoOrder> {
        match of {
            PotOf::Form(number) => {
                let form = Form::from_number(number);
                places.clone().for_each(|place| self.benches[place].begin_anew(client, form));
            }
            PotOf::Wheel(wheel) => {
                let from = usize::from(wheel).wrapping_sub(1);
                let clay = KeptClay::of(self.benches.get(from).ok_or(NoOrder::Wheel { wheel })?.pot());
                let others = places.clone().filter(|place| *place != from);
                others.for_each(|place| self.benches[place].put(client, clay.clone()));
            }
        }
        places.for_each(|place| self.make_busy(place));
        Ok(())
    }

    /// Somebody goes to a wheel: who is at another one now is asked to come back there.
    fn seat_person(&mut self, client: u16, wheel: u16, works: bool) -> Result<(), NoOrder> {
        let place = usize::from(wheel).wrapping_sub(1);
        if place >= self.benches.len() {
            return Err(NoOrder::Wheel { wheel });
        }
        let person = self.people.person_mut(client).ok_or(NoOrder::Person { client })?;
        let before = person.place.ok_or(NoOrder::CannotWork)?;
        if before != place && !person.can_come_back() {
            return Err(NoOrder::CannotWork);
        }
        (person.place, person.works) = (Some(place), works);
        let connection = person.peer.filter(|_| !person.is_waiting);
        self.people.is_changed = true;
        let Some(peer) = connection else { return Ok(()) };
        if before == place {
            self.tell_place(client, None);
            return Ok(());
        }
        self.send(peer, Lane::Control(Peer::notice(&Notice::Come { wheel })));
        self.send(peer, Lane::Close);
        self.handle_gone(peer);
        Ok(())
    }

    /// Everybody but teachers goes home.
    fn end_lesson(&mut self) {
        self.doors.is_locked = true;
        let all: alloc::vec::Vec<_> = self
            .people
            .iter()
            .filter(|(_, person)| person.role != Role::Teacher)
            .map(|(client, person)| (client, person.peer))
            .collect();
        for (client, peer) in all {
            if let Some(peer) = peer {
                self.send(peer, Lane::Control(Peer::notice(&Notice::Closing)));
                self.say_goodbye(peer);
            }
            self.people.forget(client);
        }
    }
}
