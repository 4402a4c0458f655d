//! What is said of people and of the lesson: who is who, who sits where, and what a teacher orders.
//!
//! Plain data as all messages are; which role may ask for what is the room's affair.
//! Invariant: a secret never shows in a debug print.

use alloc::string::String;
use alloc::vec::Vec;
use bincode::{Decode, Encode};
use core::fmt;

use super::ClayWire;

/// What somebody is in the lesson.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Encode, Decode)]
pub enum Role {
    /// Leads the lesson.
    Teacher,
    /// Works at a wheel.
    Student,
    /// Looks on, or waits to be let in.
    Guest,
}

impl Role {
    /// All of them, the one with most rights first.
    pub const ALL: [Self; 3] = [Self::Teacher, Self::Student, Self::Guest];

    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Teacher => "teacher",
            Self::Student => "student",
            Self::Guest => "guest",
        }
    }
}

/// What a teacher shows at the door: 256 random bits that the server keeps as a hash.
#[derive(Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct TeacherToken(pub [u8; 32]);

/// What brings somebody back to their seat: 128 random bits, one for each who was let in.
#[derive(Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct ResumeToken(pub [u8; 16]);

impl fmt::Debug for TeacherToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TeacherToken(..)")
    }
}

impl fmt::Debug for ResumeToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ResumeToken(..)")
    }
}

/// What somebody shows beside the code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub enum Pass {
    /// Nothing.
    #[default]
    None,
    /// That they teach here; no code is needed then.
    Teacher(TeacherToken),
    /// That they were here before; neither code nor open door is needed then. One that is not known any more is as nothing.
    Resume(ResumeToken),
    /// That they were here before, and that they teach should they not be known any more, as after the server has begun anew. A teacher's token that
    /// is not known then either is as nothing.
    Return(ResumeToken, TeacherToken),
}

impl Pass {
    /// What one comes back with.
    #[must_use]
    pub const fn resume(&self) -> Option<&ResumeToken> {
        match self {
            Self::Resume(token) | Self::Return(token, _) => Some(token),
            Self::None | Self::Teacher(_) => None,
        }
    }
}

/// A name from the list that there is: nobody types one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Encode, Decode)]
pub struct Nickname(pub u16);

impl Nickname {
    /// The words, in English; other languages have as many in the same order.
    pub const WORDS: [&'static str; 64] = [
        "otter",
        "heron",
        "badger",
        "finch",
        "beaver",
        "robin",
        "hare",
        "owl",
        "fox",
        "swan",
        "lynx",
        "crane",
        "marten",
        "thrush",
        "seal",
        "stork",
        "hedgehog",
        "magpie",
        "squirrel",
        "falcon",
        "dormouse",
        "plover",
        "mole",
        "wren",
        "newt",
        "starling",
        "toad",
        "cuckoo",
        "salmon",
        "swift",
        "trout",
        "lark",
        "pike",
        "jay",
        "carp",
        "raven",
        "perch",
        "dove",
        "eel",
        "grouse",
        "bee",
        "quail",
        "moth",
        "gull",
        "cricket",
        "tern",
        "beetle",
        "eagle",
        "snail",
        "kite",
        "bat",
        "swallow",
        "elk",
        "nuthatch",
        "bison",
        "woodpecker",
        "wolf",
        "kingfisher",
        "bear",
        "sparrow",
        "ibex",
        "warbler",
        "stoat",
        "siskin",
    ];

    /// Which of the words it is.
    #[must_use]
    pub const fn word(self) -> usize {
        self.0 as usize % Self::WORDS.len()
    }

    /// The how manieth of that word, from 1.
    #[must_use]
    pub const fn number(self) -> usize {
        self.0 as usize / Self::WORDS.len() + 1
    }
}

impl fmt::Display for Nickname {
    /// ```
    /// use pottery_shared::protocol::Nickname;
    /// assert_eq!((Nickname(0).to_string(), Nickname(64).to_string()), ("otter".into(), "otter 2".into()));
    /// ```
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::WORDS[self.word()])?;
        if self.number() > 1 { write!(f, " {}", self.number()) } else { Ok(()) }
    }
}

/// Where somebody has come to; told after the welcome, and again when it changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct PlaceWire {
    /// Its number in the room.
    pub client: u16,
    /// What it is.
    pub role: Role,
    /// What others call it.
    pub name: Nickname,
    /// At which wheel, from 1; 0 for who looks on.
    pub wheel: u16,
    /// Whether what it presses counts: not while the wheel is frozen or closed, or while it is to look on.
    pub may_press: bool,
    /// With what it comes back; told once.
    pub resume: Option<ResumeToken>,
}

/// How somebody is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum Presence {
    /// Connected.
    Here,
    /// Not connected, and expected back.
    Away,
    /// At the door.
    Waiting,
}

/// Somebody as others are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct PersonWire {
    /// Its number in the room.
    pub client: u16,
    /// What it is.
    pub role: Role,
    /// What it is called.
    pub name: Nickname,
    /// At which wheel, from 1; 0 for who looks on.
    pub wheel: u16,
    /// Whether it is to work there, or to look on.
    pub works: bool,
    /// How it is there.
    pub presence: Presence,
    /// Whether its tool touches clay; told to teachers alone.
    pub touching: bool,
}

/// One wheel as a teacher is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct WheelInfo {
    /// Whether people may come to it.
    pub is_open: bool,
    /// Whether nobody's press counts.
    pub is_frozen: bool,
    /// The earliest tick that it can go back to.
    pub oldest: u64,
}

/// The lesson as a teacher is told.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct ClassWire {
    /// The room's part of the join code.
    pub code: String,
    /// The tick from which it lets nobody in any more.
    pub expires: Option<u64>,
    /// Whether nobody comes in with it now.
    pub is_locked: bool,
    /// Whether who comes waits until a teacher lets them in.
    pub has_lobby: bool,
    /// The wheels, in order.
    pub wheels: Vec<WheelInfo>,
}

/// Which clay is put on a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum PotOf {
    /// That of a form, by [`Form::number`](crate::clay::Form::number); any other number, and a form into which it does not go, for the clay with
    /// which the wheel began.
    Form(u8),
    /// A copy of what is on a wheel now, from 1.
    Wheel(u16),
}

/// What a teacher orders. A `wheel` is counted from 1; 0 means every wheel.
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
pub enum Order {
    /// Nobody's press counts there, or everybody's does again.
    Freeze {
        /// Which.
        wheel: u16,
        /// Whether.
        is_frozen: bool,
    },
    /// People may come to it, or not; at a closed wheel nobody's press counts either.
    Open {
        /// Which.
        wheel: u16,
        /// Whether.
        is_open: bool,
    },
    /// Turn it at this speed.
    WheelSpeed {
        /// Which.
        wheel: u16,
        /// Turns a minute.
        rpm: f32,
    },
    /// Make its clay another.
    Clay {
        /// Which.
        wheel: u16,
        /// What it is made of.
        clay: ClayWire,
    },
    /// Somebody goes to a wheel, to work there or to look on.
    Seat {
        /// Who.
        client: u16,
        /// Where to, from 1.
        wheel: u16,
        /// Whether it works there.
        works: bool,
    },
    /// Put clay there; a step as any other.
    Pot {
        /// Where.
        wheel: u16,
        /// Which.
        of: PotOf,
    },
    /// Put the clay there that was there at a tick, without what was undone since; a step as any other.
    GoBack {
        /// Where.
        wheel: u16,
        /// As at the end of which tick.
        to: u64,
    },
    /// Take back this teacher's newest step there, a pot that was put or a stroke, as undo does.
    TakeBack {
        /// Where.
        wheel: u16,
    },
    /// The code lets nobody in, or does again.
    Lock {
        /// Whether.
        is_locked: bool,
    },
    /// Another code from now on.
    NewCode,
    /// Who comes waits to be let in, or does no longer.
    Lobby {
        /// Whether.
        is_on: bool,
    },
    /// Let somebody in who waits, or send them away.
    Admit {
        /// Who; 0 for everybody who waits.
        client: u16,
        /// Whether.
        is_admitted: bool,
    },
    /// Everybody but teachers goes home, and nobody comes in until the door is unlocked.
    End,
}

/// Why an order was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, thiserror::Error)]
pub enum NoOrder {
    /// Who orders does not teach.
    #[error("only a teacher can do that; join with the teacher's token")]
    NotTeacher,
    /// No such wheel.
    #[error("there is no wheel {wheel} here")]
    Wheel {
        /// The wheel named.
        wheel: u16,
    },
    /// Nobody of that number, or not where the order needs them.
    #[error("nobody here has the number {client}")]
    Person {
        /// The number named.
        client: u16,
    },
    /// Somebody whose program only looks on, or cannot come back.
    #[error("that person's program cannot take a place at a wheel")]
    CannotWork,
    /// Before what the wheel remembers.
    #[error("the wheel remembers back to tick {oldest} and no farther")]
    TooLongAgo {
        /// The earliest tick that it can go back to.
        oldest: u64,
    },
    /// The teacher put nothing there that could be taken back.
    #[error("there is nothing of yours to take back at that wheel")]
    NothingBack,
}
