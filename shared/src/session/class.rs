//! What a client knows of the lesson: its own place, the people, and, when it teaches, doors and wheels.
//!
//! Owns what was told and the greeting; asks for nothing by itself.
//! Invariant: the people are those of the last notice, and nobody is in it twice.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use super::target_of;
use crate::clay::{Deviation, Target};
use crate::protocol::{
    self, ClassWire, Greeting, Hello, NoOrder, Notice, PersonWire, PlaceWire, ProgressWire, ResumeToken,
};

/// What a client of this kind greets with.
#[must_use]
pub fn greeting(hello: &Hello) -> Vec<u8> {
    let (version, hello) = (protocol::VERSION.to_le_bytes(), protocol::encode(hello));
    protocol::frame(&protocol::encode(&Greeting { magic: Greeting::MAGIC, version, hello }))
}

/// Something of the lesson that a client was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClassEvent {
    /// Where it is, or whether what it presses counts.
    Place,
    /// Who is here.
    People,
    /// How the doors and the wheels stand.
    Class,
    /// It is to come back, and will find another wheel.
    Come,
    /// What it ordered was not done.
    NoOrder(NoOrder),
    /// How far pots are from what they are to become.
    Progress,
}

/// The lesson as a client knows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClassView {
    place: Option<PlaceWire>,
    resume: Option<ResumeToken>,
    people: BTreeMap<u16, PersonWire>,
    class: Option<ClassWire>,
    progress: BTreeMap<u16, Progress>,
}

/// How far the pot of a wheel is from what it is to become, as a teacher was told.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The profile of that pot.
    pub is: Target,
    /// How far it is.
    pub deviation: Deviation,
}

impl Progress {
    /// What was told, if it can be.
    fn of(wire: &ProgressWire) -> Option<Self> {
        let ProgressWire { rms_m, most_m, most_at_m, .. } = *wire;
        let is_sound = [rms_m, most_m, most_at_m].iter().all(|length_m| (0.0..10.0).contains(length_m));
        let is = target_of(&wire.is).filter(|_| is_sound)?;
        Some(Self { is, deviation: Deviation { rms_m, most_m, most_at_m, higher_m: 0.0 } })
    }
}

impl ClassView {
    /// Takes in a notice; says what it tells of the lesson, if anything.
    pub(super) fn handle(&mut self, notice: Notice) -> Option<ClassEvent> {
        match notice {
            Notice::Place(place) => {
                self.resume = place.resume.or(self.resume);
                self.place = Some(place);
                Some(ClassEvent::Place)
            }
            Notice::People { people, gone } => {
                self.people.retain(|client, _| !gone.contains(client));
                self.people.extend(people.into_iter().map(|person| (person.client, person)));
                Some(ClassEvent::People)
            }
            Notice::Class(class) => {
                self.class = Some(class);
                Some(ClassEvent::Class)
            }
            Notice::Come { .. } => Some(ClassEvent::Come),
            Notice::NoOrder(reason) => Some(ClassEvent::NoOrder(reason)),
            Notice::Progress(told) => {
                if told.is_empty() {
                    self.progress.clear();
                }
                self.progress.extend(told.iter().filter_map(|told| Some((told.wheel, Progress::of(told)?))));
                Some(ClassEvent::Progress)
            }
            _ => None,
        }
    }

    /// Where it is, once it was told.
    #[must_use]
    pub const fn place(&self) -> Option<&PlaceWire> {
        self.place.as_ref()
    }

    /// With what it comes back.
    #[must_use]
    pub const fn resume(&self) -> Option<&ResumeToken> {
        self.resume.as_ref()
    }

    /// Whether what it presses counts.
    #[must_use]
    pub fn may_press(&self) -> bool {
        self.place.as_ref().is_none_or(|place| place.may_press)
    }

    /// Those it may know of, by number, itself included.
    pub fn people(&self) -> impl Iterator<Item = &PersonWire> {
        self.people.values()
    }

    /// How far the pots are from what they are to become, by the number of the wheel, for who teaches; none without a target.
    #[must_use]
    pub const fn progress(&self) -> &BTreeMap<u16, Progress> {
        &self.progress
    }

    /// Doors and wheels, for who teaches.
    #[must_use]
    pub const fn class(&self) -> Option<&ClassWire> {
        self.class.as_ref()
    }
}
