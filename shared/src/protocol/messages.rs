//! The messages themselves.
//!
//! Plain data with the units in the names; every meaning is checked by whoever receives it.
//! Invariant: no message holds a type of another module.

use alloc::string::String;
use alloc::vec::Vec;
use bincode::{Decode, Encode};

use super::{
    ClassWire, GuidanceEnd, GuidanceWire, HandWire, Inputs, LeadWire, NewsWire, NoGuidance, NoOrder, Order, Pass,
    PersonWire, PlaceWire, ProgressWire, ShapeWire, SightName, TargetWire,
};

/// The first frame of a client. Its layout never changes, so that any two versions can refuse each other politely.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Greeting {
    /// `b"POTS"`.
    pub magic: [u8; 4],
    /// The sender's [`super::VERSION`], always two bytes.
    pub version: [u8; 2],
    /// A [`Hello`] in the sender's version.
    pub hello: Vec<u8>,
}

impl Greeting {
    /// What a greeting begins with.
    pub const MAGIC: [u8; 4] = *b"POTS";
}

/// Who wants to join what.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Hello {
    /// The room's join code.
    pub code: String,
    /// Number of the wheel to work at, from 1; without meaning for who watches.
    pub wheel: u16,
    /// To do what.
    pub purpose: Purpose,
    /// What it shows beside the code.
    pub pass: Pass,
}

/// What somebody comes for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum Purpose {
    /// To work at a wheel.
    Works {
        /// Whether the client presses again what was pressed, and so wants transcripts and no deltas.
        retells: bool,
    },
    /// To look on at any number of wheels.
    Watches {
        /// What all of them together may send for long, bytes a second.
        bytes_per_s: u32,
    },
}

/// What a client asks for on the control stream.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum Request {
    /// Turn the wheel at this speed.
    WheelSpeed {
        /// Turns a minute.
        rpm: f32,
    },
    /// Make the wheel's clay another.
    Clay {
        /// What it is made of.
        clay: ClayWire,
    },
    /// Hang a tool in the wheel's rack.
    Tool {
        /// Its surface.
        mesh: MeshWire,
    },
    /// Say again what leads on from `have`: something was lost.
    Again {
        /// Version held whole.
        have: u32,
    },
    /// Send a keyframe of everything newer than `have`: saying it again did not help.
    Resync {
        /// Version held whole; 0 asks for the whole pot.
        have: u32,
    },
    /// Show a wheel, or, when it is shown already, what leads on from `have`: something was lost.
    Watch {
        /// What to show.
        sight: SightName,
        /// Version held whole; 0 asks for the whole pot.
        have: u32,
    },
    /// Show it no longer.
    Unwatch {
        /// What not to show.
        sight: SightName,
    },
    /// From now on, transcripts or deltas.
    Retell {
        /// Whether the client keeps up with pressing again what was pressed.
        retells: bool,
    },
    /// Goodbye.
    Leave,
    /// Send a keyframe of everything newer than `have`, and of what differs from what is held at it.
    Mend {
        /// Version held whole.
        have: u32,
        /// The lowest 16 bits of every tile's digest at it, low byte first.
        tiles: Vec<u8>,
    },
    /// Undo the client's newest stroke.
    Undo {
        /// The tick of its newest sample: what it pressed up to then is meant.
        held: u64,
    },
    /// Redo what it undid last.
    Redo {
        /// The tick of its newest sample.
        held: u64,
    },
    /// Put new clay on the wheel; can be undone as a stroke of the client.
    NewPot {
        /// The tick of its newest sample.
        held: u64,
        /// The number of a form, [`Form::number`](crate::clay::Form::number); any other for the clay with which the wheel began.
        form: u8,
    },
    /// What a teacher orders.
    Order(Order),
    /// Guide a student's hand, or in another way than before.
    Guide {
        /// The number of the student.
        student: u16,
        /// How.
        guidance: GuidanceWire,
    },
    /// Let go: of the student whom this client guides, or of the teacher who guides it.
    EndGuidance,
    /// What everybody's pot is to become; nothing any more.
    Target(Option<TargetWire>),
    /// As [`Request::Mend`], of a sight.
    MendSight {
        /// What is shown otherwise than it should be.
        sight: SightName,
        /// Version held whole.
        have: u32,
        /// The lowest 16 bits of every tile's digest at it, low byte first.
        tiles: Vec<u8>,
    },
    /// A piece of a pot for the wheel; with its last piece it is put there, which can be undone as a stroke of the client.
    Pot {
        /// The tick of its newest sample.
        held: u64,
        /// Number of the piece, from 0, in order.
        piece: u16,
        /// Its bytes: of the planes of the pot's radii, [`POT_PIECE`] in every piece but the last.
        bytes: Vec<u8>,
    },
}

/// Bytes of a piece of a pot.
pub const POT_PIECE: usize = 20_000;

/// Why there is no step back or forth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, thiserror::Error)]
pub enum NoStep {
    /// None of the client's strokes can be undone.
    #[error("there is nothing of yours to undo: a wheel remembers what was pressed in the last ten minutes")]
    NothingBack,
    /// None can be redone.
    #[error("there is nothing of yours to redo: whoever presses on after an undo keeps to that")]
    NothingForth,
    /// What the client sent is no pot of the wheel's grid, which programs check before they send it, or the wheel's clay does not go into the
    /// form that was asked for.
    #[error("the server cannot put that pot on this wheel")]
    NoPot,
}

/// What one client can undo and redo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct StepsWire {
    /// Strokes that can be undone.
    pub back: u16,
    /// Strokes that can be redone.
    pub forth: u16,
    /// Whether clay is being made again, for this client or another.
    pub is_remaking: bool,
}

/// Why a client may not come in.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, thiserror::Error)]
pub enum Refusal {
    /// Another protocol version.
    #[error("the server speaks protocol version {server} and this program version {client}; update the older one")]
    Version {
        /// The server's.
        server: u16,
        /// The client's.
        client: u16,
    },
    /// Not the room's code.
    #[error("that is not the code of this studio; ask the person who hosts it")]
    Code,
    /// No such wheel.
    #[error("there is no wheel {wheel} in this studio; its wheels are numbered from 1, and it has {wheels}")]
    Wheel {
        /// The wheel asked for.
        wheel: u16,
        /// How many there are.
        wheels: u16,
    },
    /// Nobody else fits in.
    #[error("the studio is full ({people} people); try again later")]
    Full {
        /// How many are in.
        people: u16,
    },
    /// Not a greeting of this protocol.
    #[error("the server did not understand the greeting; is it a pottery studio of this version?")]
    Greeting,
    /// A code that was good before.
    #[error("that code is no longer good: it has expired or was replaced; ask for the new one")]
    CodeGone,
    /// Nobody comes in now.
    #[error("the studio is locked: its teacher lets nobody in at the moment")]
    Locked,
    /// A teacher's token of another studio, or none at all.
    #[error("that is no teacher's token of this studio; it was shown once, when the server first started")]
    Token,
    /// A wheel that is closed.
    #[error("wheel {wheel} is closed at the moment; choose another")]
    WheelClosed {
        /// The wheel asked for.
        wheel: u16,
    },
    /// A teacher has not let this client in.
    #[error("the teacher has not let you in")]
    NotAdmitted,
}

/// Why a tool does not hang in the rack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, thiserror::Error)]
pub enum NoTool {
    /// No room for another.
    #[error("the rack of this wheel is full: people have brought {brought} tools; work with one of them")]
    Full {
        /// How many were brought.
        brought: u16,
    },
    /// The mesh makes no tool; programs check that before they send it.
    #[error("the server cannot make a tool of that mesh")]
    Unsound,
}

/// The closed convex surface of a tool.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct MeshWire {
    /// Corners from the tool's centre, m.
    pub corners_m: Vec<[f32; 3]>,
    /// Triangles as numbers of corners, counter-clockwise seen from outside.
    pub facets: Vec<[u16; 3]>,
}

/// Specification of a pot.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct PotWire {
    /// Elements round the pot.
    pub columns: u32,
    /// Elements from foot to rim.
    pub rows: u32,
    /// Height, m.
    pub height_m: f32,
    /// Radius of the untouched pot, m.
    pub radius_m: f32,
    /// Wall thickness, m.
    pub wall_m: f32,
    /// Number of what stands behind the wall.
    pub support: u8,
}

/// What clay is made of; twelve bytes.
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
pub struct ClayWire {
    /// Time constant τ with which it gives way, s.
    pub viscosity_s: f32,
    /// Young's modulus E, Pa.
    pub youngs_pa: f32,
    /// Yield stress σ_y, Pa.
    pub yield_pa: f32,
}

/// The wheel's phase and turning.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct WheelWire {
    /// Tick at which it stands at `phase`.
    pub from: u64,
    /// Phase, 2³² a turn.
    pub phase: u32,
    /// Phase steps a tick.
    pub rate: i32,
}

/// What a client needs to begin.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct Welcome {
    /// Its number in the room.
    pub client: u16,
    /// The server's tick at the moment of writing.
    pub now: u64,
    /// The pot at version 0.
    pub pot: PotWire,
    /// The wheel's turning, earliest first, scheduled changes included.
    pub wheel: Vec<WheelWire>,
    /// What the clay is made of and the tick from which it is, earliest first.
    pub clay: Vec<(u64, ClayWire)>,
    /// Number of the deformation method.
    pub method: u8,
    /// Notices told to everybody before this welcome.
    pub told: u32,
    /// Ticks by which snapshots are taken earlier than at the first wheel.
    pub ahead: u8,
}

/// What one who watches needs to begin.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct Audience {
    /// The server's tick at the moment of writing.
    pub now: u64,
    /// Number of wheels.
    pub wheels: u16,
    /// The pot at version 0 of every wheel, on the grid of those who work.
    pub pot: PotWire,
    /// Number of the deformation method.
    pub method: u8,
}

/// What the server says on the control stream.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum Notice {
    /// Come in.
    Welcome(Welcome),
    /// Come in and look on.
    Audience(Audience),
    /// Stay out.
    Refused(Refusal),
    /// The wheel's turning changes; its phase then follows from what it was before.
    Wheel {
        /// First tick of the new turning.
        from: u64,
        /// Phase steps a tick.
        rate: i32,
    },
    /// The clay becomes another.
    Clay {
        /// First tick at which it is.
        from: u64,
        /// What it is made of.
        clay: ClayWire,
    },
    /// A tool hangs in the rack; each number is told before anybody presses with it, and they ascend.
    Tool {
        /// Its number.
        shape: u8,
        /// Its surface.
        mesh: MeshWire,
    },
    /// The tool that this client brought does not hang there.
    NoTool(NoTool),
    /// The server stops.
    Closing,
    /// What this client can undo and redo has changed.
    Steps(StepsWire),
    /// What this client wanted to undo or redo, it cannot.
    NoStep(NoStep),
    /// Wait: a teacher will let this client in, or not.
    Waiting,
    /// Where this client is.
    Place(PlaceWire),
    /// People that are new or otherwise than they were told of, and numbers of those who are gone.
    People {
        /// Those.
        people: Vec<PersonWire>,
        /// Their numbers.
        gone: Vec<u16>,
    },
    /// The lesson, for teachers.
    Class(ClassWire),
    /// This client has another place now: it is to come back, with what it was given for that.
    Come {
        /// The number of the wheel, from 1.
        wheel: u16,
    },
    /// What this client ordered was not done.
    NoOrder(NoOrder),
    /// A teacher guides a student, one of both is this client.
    Guidance(LeadWire),
    /// And no longer.
    GuidanceEnded(GuidanceEnd),
    /// What this client asked for to guide is not done.
    NoGuidance(NoGuidance),
    /// What everybody's pot is to become; nothing any more.
    Target(Option<TargetWire>),
    /// What everybody at a wheel was told, for those who look on closely.
    News(NewsWire),
    /// How far pots are from what they are to become, of some wheels, for teachers; of none when there is no target any more.
    Progress(Vec<ProgressWire>),
    /// A wheel is shown in as many ways as it can be; this one is none of them. Those with a name always are.
    NoSight(SightName),
}

/// A client's datagram.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Upload {
    /// What it presses.
    pub inputs: Inputs,
    /// Where its hand is, while it guides another.
    pub hand: Option<HandWire>,
    /// The version held whole, while what leads on from there is missing: as [`Request::Again`], and said until it has come.
    pub again: Option<u32>,
}

/// The part of a server's datagram that is for one client; by default that of one who only looks on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct PulseHead {
    /// All of the client's samples below this number are in the latest snapshot.
    pub acknowledged: u32,
    /// Ticks to spare with which its samples arrived since the last pulse, at the worst.
    pub slack: Option<i16>,
    /// Where the hand is that guides it.
    pub teacher: Option<HandWire>,
}

/// The part of a server's datagram that all clients of a wheel share.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Body {
    /// The tick whose clay the latest snapshot is.
    pub tick: u64,
    /// The latest snapshot.
    pub latest: u32,
    /// Its digest, now and then.
    pub digest: Option<u64>,
    /// Where everybody's tools are; absent from datagrams that continue a pulse.
    pub tools: Option<Vec<ToolWire>>,
    /// Pieces of the latest snapshots.
    pub fragments: Vec<Fragment>,
}

/// A server's datagram.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Pulse {
    /// For this client.
    pub head: PulseHead,
    /// For everybody.
    pub body: Body,
}

/// A server's datagram to those who watch; all of them get the same.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Sight {
    /// What it shows.
    pub name: SightName,
    /// How the wheel turns; absent from datagrams that continue another.
    pub turning: Option<WheelWire>,
    /// What happened; versions are those of this sight.
    pub body: Body,
}

/// Somebody's tool.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct ToolWire {
    /// Whose.
    pub client: u16,
    /// Where, in steps of 10 µm.
    pub centre: [i32; 3],
    /// Which, and how it is turned.
    pub tool: ShapeWire,
    /// Whether it touches clay.
    pub touching: bool,
    /// Whether it works inside of the pot.
    pub inside: bool,
}

/// How a fragment's bytes lead from one snapshot to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Encode, Decode)]
pub enum FragmentOf {
    /// They are the tiles that changed.
    Delta,
    /// They are a [`Retelling`].
    Transcript,
}

/// What was pressed between two snapshots, for those who press it again.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Retelling {
    /// Lowest 16 bits of the tick of the snapshot before.
    pub since: [u8; 2],
    /// Lowest 16 bits of the number of notices that were told to everybody before: who has not heard them all waits.
    pub told: [u8; 2],
    /// Lowest 16 bits of the digest of the clay afterwards.
    pub digest: [u8; 2],
    /// The transcript.
    pub transcript: Vec<u8>,
}

/// A piece of what leads to a snapshot.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Fragment {
    /// The snapshot that it leads to.
    pub version: u32,
    /// What it is a piece of.
    pub of: FragmentOf,
    /// Number of the piece.
    pub index: u16,
    /// Number of pieces.
    pub count: u16,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// A keyframe stream.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Keyframe {
    /// The snapshot it leads to.
    pub version: u32,
    /// The version it starts from.
    pub since: u32,
    /// The tick whose clay it is.
    pub tick: u64,
    /// All of the client's samples below this number are in it.
    pub acknowledged: u32,
    /// Of what it is, for those who watch.
    pub sight: Option<SightName>,
    /// Tiles in it that had not changed since then and yet differed from what the client had told of.
    pub mended: u16,
    /// Whether what the next delta builds upon follows the tiles.
    pub goes_on: bool,
    /// The tiles.
    pub bytes: Vec<u8>,
}
