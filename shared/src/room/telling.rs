//! What people are told of one another, and a teacher of the lesson: what has changed, four times a second.
//!
//! Owns who may know of whom: a student of those at the same wheel and of teachers, a guest of teachers, a teacher of everybody.
//! Invariant: nobody is told the same twice in a row, and the code goes to teachers alone.

use alloc::collections::{BTreeMap, BTreeSet};
use alloc::sync::Arc;
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
        let all: Arc<[_]> =
            self.people.iter().map(|(client, person)| person.wire(client, touching.contains(&client))).collect();
        let at = by_wheel(&all);
        let class = has_teacher.then(|| self.lesson());
        let mut news = News::default();
        let here: Vec<_> = self.people.here().map(|(client, _, peer)| (client, peer)).collect();
        for (client, peer) in here {
            let Some(person) = self.people.person_mut(client) else { continue };
            let own = person.wire(client, false);
            let now = if own.role == Role::Teacher { Some(&all) } else { at.get(&own.wheel).or_else(|| at.get(&0)) };
            let Some(now) = now else { continue };
            let mut frames = news.frames(person.heard.as_ref(), now).to_vec();
            person.heard = Some(Arc::clone(now));
            if own.role == Role::Teacher && person.heard_class != class {
                person.heard_class.clone_from(&class);
                frames.extend(class.clone().map(|class| Peer::notice(&Notice::Class(class))));
            }
            for frame in frames {
                self.outbox.push_back(super::Transmit { to: peer, lane: Lane::Control(frame) });
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

/// Of whom students are told, by their wheel: teachers, and those at the same one; at 0, of whom guests are.
fn by_wheel(all: &[PersonWire]) -> BTreeMap<u16, Arc<[PersonWire]>> {
    let quiet = all.iter().map(|person| PersonWire { touching: false, ..*person });
    let (teachers, others): (Vec<_>, Vec<_>) = quiet.partition(|person| person.role == Role::Teacher);
    let mut at = BTreeMap::from([(0, teachers.clone())]);
    for person in others.into_iter().filter(|person| person.presence != Presence::Waiting && person.wheel > 0) {
        at.entry(person.wheel).or_insert_with(|| teachers.clone()).push(person);
    }
    let sorted = |mut people: Vec<PersonWire>| {
        people.sort_unstable_by_key(|person| person.client);
        people.into()
    };
    at.into_iter().map(|(wheel, people)| (wheel, sorted(people))).collect()
}

/// What has to be said, made once for all who have heard the same and are to hear the same.
#[derive(Default)]
struct News {
    /// By where in memory the two lists are: none is made while this lives, so that a place stands for one list.
    made: BTreeMap<[*const PersonWire; 2], Vec<Vec<u8>>>,
}

impl News {
    /// Frames that lead from one list of people, by number, to another.
    fn frames(&mut self, heard: Option<&Arc<[PersonWire]>>, now: &Arc<[PersonWire]>) -> &[Vec<u8>] {
        let heard = heard.map_or(&[][..], |heard| heard);
        self.made.entry([heard.as_ptr(), now.as_ptr()]).or_insert_with(|| {
            let is_in = |people: &[PersonWire], client| people.binary_search_by_key(&client, |one| one.client);
            let is_news = |person: &&PersonWire| is_in(heard, person.client).map(|at| heard[at]) != Ok(**person);
            let changed: Vec<_> = now.iter().filter(is_news).copied().collect();
            let all_heard = heard.iter().map(|person| person.client);
            let gone: Vec<_> = all_heard.filter(|client| is_in(now, *client).is_err()).collect();
            let gone = gone.chunks(PEOPLE_MAX).map(|gone| Notice::People { people: Vec::new(), gone: gone.to_vec() });
            let changed =
                changed.chunks(PEOPLE_MAX).map(|people| Notice::People { people: people.to_vec(), gone: Vec::new() });
            gone.chain(changed).map(|notice| Peer::notice(&notice)).collect()
        })
    }
}
