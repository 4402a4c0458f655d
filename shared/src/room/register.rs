//! The class register: who was let in, and how doors and wheels were kept, for the room of a server that begins anew after it was killed.
//!
//! Pure; where it lies meanwhile is the shell's affair.
//! Invariant: tokens are in it as hashes, and nobody is in it who could not come back.

use alloc::string::String;
use alloc::vec::Vec;

use bincode::{Decode, Encode};

use super::doors::TokenHash;
use super::{Bench, Room};
use crate::protocol::{self, Nickname, Role};

/// Most bytes of one that is read: as many people as there are numbers take 3 MB.
const BYTES_MAX: usize = 1 << 22;

/// Somebody in the register.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub(super) struct Enrolled {
    pub(super) client: u16,
    pub(super) role: Role,
    pub(super) name: Nickname,
    /// Counted from 1, or 0 for who looks on.
    pub(super) wheel: u16,
    pub(super) works: bool,
    pub(super) token: TokenHash,
}

/// What of a door outlasts its server.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub(super) struct DoorState {
    pub(super) code: String,
    /// Codes before it, the oldest first.
    pub(super) former: Vec<String>,
    pub(super) is_locked: bool,
    pub(super) has_lobby: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
struct WheelState {
    is_closed: bool,
    is_frozen: bool,
}

/// Who was let in, and how doors and wheels were kept.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Register {
    door: DoorState,
    wheels: Vec<WheelState>,
    people: Vec<Enrolled>,
}

impl Register {
    /// The room's part of the code that let people in.
    #[must_use]
    pub fn code(&self) -> &str {
        &self.door.code
    }

    /// People in it.
    #[must_use]
    pub const fn people(&self) -> usize {
        self.people.len()
    }

    /// Strikes out who taught: their token is another one now.
    pub fn strike_teachers(&mut self) {
        self.people.retain(|person| person.role != Role::Teacher);
    }

    /// As it lies in a file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        protocol::encode(self)
    }

    /// What [`Register::to_bytes`] gave; none for other bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        protocol::decode::<BYTES_MAX, Self>(bytes).ok()
    }
}

impl Room {
    /// The register as it is now.
    #[must_use]
    pub fn register(&self) -> Register {
        let wheel = |bench: &Bench| WheelState { is_closed: bench.is_closed(), is_frozen: bench.is_frozen() };
        Register {
            door: self.doors.state(),
            wheels: self.benches.iter().map(wheel).collect(),
            people: self.people.enrolled().collect(),
        }
    }

    /// Goes on with a register, in a room that nobody has come to yet: its people are away and can come back, doors and wheels are
    /// as they were. The code stays the room's own, and is good for so many ticks; where it is another one, the register's is one of
    /// those before. Somebody at a wheel that there is none of is left out.
    pub fn go_on_from(&mut self, register: Register, code_ticks: Option<u64>) {
        let Register { door, wheels, people } = register;
        self.doors.go_on_from(door, code_ticks, self.now);
        for (bench, wheel) in self.benches.iter_mut().zip(wheels) {
            bench.close(wheel.is_closed);
            bench.freeze(wheel.is_frozen);
        }
        for person in people.into_iter().filter(|person| usize::from(person.wheel) <= self.benches.len()) {
            self.people.enrol(&person, self.now);
        }
    }
}
