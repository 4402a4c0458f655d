//! What people are told of one another, and a teacher of the lesson: what has changed, four times a second.
//!
//! Owns who may know of whom: a student of those at the same wheel and of teachers, a guest of teachers, a teacher of everybody.
//! Invariant: nobody is told the same twice in a row, and the code goes to teachers alone.

use alloc::collections::{BTreeMap, BTreeSet};
use alloc::vec::Vec;

use super::{Lane, Room};
use crate::protocol::{ClassWire, Notice, PersonWire, Presence, Role, WheelInfo};
use crate::session::Peer;
use crate::units::Tick;

/// Ticks from one telling to the next.
pub(super) const TELL_EVERY: u64 = 250;
/// Most people in one notice.
const PEOPLE_MAX: usize = 256;

impl Room {
    /// Everybody who was let in or waits, by number.
    #[must_use]
    pub fn everybody(&self) -> Vec<PersonWire> {
        let touching: BTreeSet<_> =
            self.busy.iter().flat_map(|&place| self.benches[place].touching(self.now)).collect();
        self.people.iter().map(|(client, person)| person.wire(client, touching.contains(&client))).collect()
    }

    /// Tells everybody what has changed; who has been away for long is forgotten.
    pub(super) fn tell_people(&mut self) {
        self.people.expire(self.now, usize::from(self.config.people_max));
        let has_teacher = self.people.here().any(|(_, person, _)| person.role == Role::Teacher);
        if !has_teacher && !core::mem::take(&mut self.people.is_changed) {
            return;
        }
        self.people.is_changed = false;
        let touching: BTreeSet<_> = match has_teacher {
            true => self.busy.iter().flat_map(|&place| self.benches[place].touching(self.now)).collect(),
            false => BTreeSet::new(),
        };
        let all: Vec<_> =
            self.people.iter().map(|(client, person)| person.wire(client, touching.contains(&client))).collect();
        let mut at: BTreeMap<u16, Vec<PersonWire>> = BTreeMap::new();
        let mut teachers = Vec::new();
        for person in all.iter().map(|person| PersonWire { touching: false, ..*person }) {
            if person.role == Role::Teacher {
                teachers.push(person);
            } else if person.presence != Presence::Waiting && person.wheel > 0 {
                at.entry(person.wheel).or_default().push(person);
            }
        }
        let class = has_teacher.then(|| self.lesson());
        let here: Vec<_> = self.people.here().map(|(client, _, peer)| (client, peer)).collect();
        for (client, peer) in here {
            let Some(person) = self.people.person_mut(client) else { continue };
            let own = person.wire(client, false);
            let mut notices = if own.role == Role::Teacher {
                news(&mut person.heard, all.iter().copied())
            } else {
                let others = at.get(&own.wheel).into_iter().flatten().copied();
                news(&mut person.heard, teachers.iter().copied().chain(others))
            };
            if own.role == Role::Teacher && person.heard_class != class {
                person.heard_class.clone_from(&class);
                notices.extend(class.clone().map(Notice::Class));
            }
            for notice in notices {
                self.outbox.push_back(super::Transmit { to: peer, lane: Lane::Control(Peer::notice(&notice)) });
            }
        }
    }

    /// The lesson as teachers are told.
    #[must_use]
    pub fn lesson(&self) -> ClassWire {
        let wheel = |bench: &super::Bench| WheelInfo {
            is_open: !bench.is_closed(),
            is_frozen: bench.is_frozen(),
            oldest: bench.history().oldest().0,
        };
        ClassWire {
            code: self.doors.code().into(),
            expires: self.doors.expires().map(|Tick(tick)| tick),
            is_locked: self.doors.is_locked,
            has_lobby: self.doors.has_lobby,
            wheels: self.benches.iter().map(wheel).collect(),
        }
    }
}

/// What has to be said so that somebody who `heard` that knows what is.
fn news(heard: &mut BTreeMap<u16, PersonWire>, now: impl Iterator<Item = PersonWire>) -> Vec<Notice> {
    let now: BTreeMap<_, _> = now.map(|person| (person.client, person)).collect();
    let changed: Vec<_> = now.values().filter(|person| heard.get(&person.client) != Some(*person)).copied().collect();
    let gone: Vec<_> = heard.keys().filter(|client| !now.contains_key(*client)).copied().collect();
    *heard = now;
    let mut notices = Vec::new();
    for gone in gone.chunks(PEOPLE_MAX) {
        notices.push(Notice::People { people: Vec::new(), gone: gone.to_vec() });
    }
    for people in changed.chunks(PEOPLE_MAX) {
        notices.push(Notice::People { people: people.to_vec(), gone: Vec::new() });
    }
    notices
}
