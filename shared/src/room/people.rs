//! Everybody who was let in: role, name and seat, also of those whose connection has ended.
//!
//! Owns who is who; knows no clay and nobody's samples.
//! Invariant: of one person there is at most one connection, and a number is given to nobody else while its owner may come back.

use alloc::collections::{BTreeMap, BTreeSet};
use alloc::sync::Arc;
use alloc::vec::Vec;

use super::PeerId;
use super::doors::{Doors, TokenHash, token_hash};
use super::register::Enrolled;
use crate::protocol::{ClassWire, Nickname, PersonWire, Presence, ResumeToken, Role};
use crate::session::Allowance;
use crate::units::Tick;

/// Somebody.
#[derive(Debug)]
pub(super) struct Person {
    pub(super) role: Role,
    pub(super) name: Nickname,
    pub(super) peer: Option<PeerId>,
    /// At which wheel, counted from 0; none for who only looks on.
    pub(super) place: Option<usize>,
    /// Whether it is to work there.
    pub(super) works: bool,
    pub(super) is_waiting: bool,
    /// Its hash.
    token: Option<TokenHash>,
    left_at: Tick,
    /// For what a teacher orders.
    pub(super) allowance: Allowance,
    /// Others by number, as it was told of them: one list for all who were told the same.
    pub(super) heard: Option<Arc<[PersonWire]>>,
    pub(super) heard_class: Option<ClassWire>,
    /// Whether it was last told that what it presses counts.
    pub(super) told_may_press: bool,
}

impl Person {
    /// Somebody without a connection, who works where there is a place.
    fn away(role: Role, name: Nickname, place: Option<usize>, token: Option<TokenHash>) -> Self {
        Self {
            role,
            name,
            peer: None,
            place,
            works: place.is_some(),
            is_waiting: false,
            token,
            left_at: Tick(0),
            allowance: Allowance::default(),
            heard: None,
            heard_class: None,
            told_may_press: true,
        }
    }

    /// At which wheel, counted from 1; 0 for who only looks on.
    pub(super) fn wheel(&self) -> u16 {
        self.place.map_or(0, |place| place as u16 + 1)
    }

    /// Whether it has what brings it back.
    pub(super) const fn can_come_back(&self) -> bool {
        self.token.is_some()
    }

    /// As others are told of it.
    pub(super) fn wire(&self, client: u16, touching: bool) -> PersonWire {
        let presence = match self.peer {
            _ if self.is_waiting => Presence::Waiting,
            Some(_) => Presence::Here,
            None => Presence::Away,
        };
        let (role, name, works) = (self.role, self.name, self.works);
        PersonWire { client, role, name, wheel: self.wheel(), works, presence, touching }
    }
}

/// The people of a room.
#[derive(Debug)]
pub(super) struct People {
    people: BTreeMap<u16, Person>,
    numbers: BTreeMap<PeerId, u16>,
    names: BTreeSet<Nickname>,
    next: u16,
    /// Whether anything is otherwise than when it was last told.
    pub(super) is_changed: bool,
}

impl People {
    /// Ticks for which somebody who lost the connection is expected back: as long as strokes can be undone.
    const AWAY_TICKS: i64 = 600_000;

    pub(super) const fn new() -> Self {
        Self { people: BTreeMap::new(), numbers: BTreeMap::new(), names: BTreeSet::new(), next: 1, is_changed: false }
    }

    /// Notes somebody new; returns its number and what brings it back.
    pub(super) fn add(
        &mut self,
        peer: PeerId,
        role: Role,
        place: Option<usize>,
        doors: &mut Doors,
    ) -> (u16, Option<ResumeToken>) {
        while self.people.contains_key(&self.next) || self.next == 0 {
            self.next = self.next.wrapping_add(1);
        }
        let client = self.next;
        self.next = self.next.wrapping_add(1);
        let token = doors.draw_resume();
        let hash = token.map(|token| token_hash(&token.0));
        let person = Person { peer: Some(peer), ..Person::away(role, self.free_name(doors), place, hash) };
        self.numbers.insert(peer, client);
        self.note(client, person);
        (client, token)
    }

    fn note(&mut self, client: u16, person: Person) {
        self.names.insert(person.name);
        self.people.insert(client, person);
        self.is_changed = true;
    }

    /// Everybody who can come back.
    pub(super) fn enrolled(&self) -> impl Iterator<Item = Enrolled> {
        self.people.iter().filter(|(_, person)| !person.is_waiting).filter_map(|(&client, person)| {
            let wheel = person.wheel();
            let token = person.token?;
            Some(Enrolled { client, role: person.role, name: person.name, wheel, works: person.works, token })
        })
    }

    /// Notes somebody who is away since now; whose number or name somebody has is left out.
    pub(super) fn enrol(&mut self, enrolled: &Enrolled, now: Tick) {
        let Enrolled { client, role, name, wheel, works, token } = *enrolled;
        if client == 0 || self.people.contains_key(&client) || self.names.contains(&name) {
            return;
        }
        let place = usize::from(wheel).checked_sub(1);
        let person = Person { works, left_at: now, ..Person::away(role, name, place, Some(token)) };
        self.note(client, person);
    }

    /// A name that nobody has: a word at random, with the least number that is free.
    fn free_name(&self, doors: &mut Doors) -> Nickname {
        let words = Nickname::WORDS.len() as u16;
        let word = doors.draw_below(words);
        let round = (0..u16::MAX / words).map(|number| number * words);
        let mut all = round.flat_map(|first| (0..words).map(move |at| Nickname(first + (word + at) % words)));
        all.find(|name| !self.names.contains(name)).unwrap_or_default()
    }

    /// Who comes back with a token: its number.
    pub(super) fn of_token(&self, token: &ResumeToken) -> Option<u16> {
        let hash = token_hash(&token.0);
        self.people.iter().find(|(_, person)| person.token == Some(hash)).map(|(client, _)| *client)
    }

    /// Gives somebody another connection; returns the one before, if that had not ended.
    pub(super) fn reconnect(&mut self, client: u16, peer: PeerId) -> Option<PeerId> {
        let person = self.people.get_mut(&client)?;
        let before = person.peer.replace(peer);
        (person.heard, person.heard_class) = (None, None);
        if let Some(before) = before {
            self.numbers.remove(&before);
        }
        self.numbers.insert(peer, client);
        self.is_changed = true;
        before
    }

    /// Takes in that a connection has ended; says whose.
    pub(super) fn handle_gone(&mut self, peer: PeerId, now: Tick) -> Option<u16> {
        let client = self.numbers.remove(&peer)?;
        let person = self.people.get_mut(&client)?;
        (person.peer, person.left_at) = (None, now);
        (person.heard, person.heard_class) = (None, None);
        if person.token.is_none() || person.is_waiting {
            self.forget(client);
        }
        self.is_changed = true;
        Some(client)
    }

    /// Forgets somebody altogether.
    pub(super) fn forget(&mut self, client: u16) {
        if let Some(person) = self.people.remove(&client) {
            self.names.remove(&person.name);
            if let Some(peer) = person.peer {
                self.numbers.remove(&peer);
            }
        }
        self.is_changed = true;
    }

    /// Forgets who has been away for long, and the longest away beyond a number.
    pub(super) fn expire(&mut self, now: Tick, away_max: usize) {
        let mut away: Vec<_> = self
            .people
            .iter()
            .filter(|(_, person)| person.peer.is_none())
            .map(|(client, person)| (person.left_at, *client))
            .collect();
        away.sort_unstable();
        let too_many = away.len().saturating_sub(away_max);
        for (at, (left_at, client)) in away.into_iter().enumerate() {
            if at < too_many || now.since(left_at) > Self::AWAY_TICKS {
                self.forget(client);
            }
        }
    }

    pub(super) fn number(&self, peer: PeerId) -> Option<u16> {
        self.numbers.get(&peer).copied()
    }

    pub(super) fn person(&self, client: u16) -> Option<&Person> {
        self.people.get(&client)
    }

    pub(super) fn person_mut(&mut self, client: u16) -> Option<&mut Person> {
        self.people.get_mut(&client)
    }

    /// Everybody, by number.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u16, &Person)> {
        self.people.iter().map(|(client, person)| (*client, person))
    }

    /// Everybody who is connected and was let in.
    pub(super) fn here(&self) -> impl Iterator<Item = (u16, &Person, PeerId)> {
        self.iter()
            .filter(|(_, person)| !person.is_waiting)
            .filter_map(|(client, person)| person.peer.map(|peer| (client, person, peer)))
    }
}
