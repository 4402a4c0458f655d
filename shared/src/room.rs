//! The authoritative studio: who is at which wheel, and the one clock by which all of them turn.
//!
//! Sans-IO: the shell passes in frames, datagrams and ticks, and sends what [`Room::poll_transmit`] returns.
//! Invariant: clay of a tick that was committed is never changed for an earlier one.

mod arriving;
mod audience;
mod bench;
mod crew;
mod doors;
mod guidance;
mod history;
mod journal;
mod orders;
mod people;
mod pieces;
mod progress;
mod register;
mod replay;
mod rights;
mod telling;
mod view;

use alloc::collections::{BTreeMap, VecDeque};
use alloc::string::String;
use alloc::vec::Vec;

use bytes::Bytes;

use crate::clay::{Conditions, Form, Material, Method, MethodKind, Pot, PotError, PotSpec};
use crate::protocol::{NoGuidance, NoOrder, Notice, Request, Role};
use crate::session::{Peer, PeerError, Refusals, Telling};
use crate::snapshot::{PotRecord, SnapshotClock};
use crate::units::{Rpm, Tick};
use arriving::Waiting;
use audience::Audience;
pub use audience::SIGHTS_MAX;
use bench::Bench;
pub use crew::{Alone, Crew};
use crew::{Desk, together};
use doors::Doors;
pub use doors::{DoorConfig, TokenHash, token_hash};
use guidance::Leads;
use history::{Anew, Step};
pub use journal::{Entry, Happening, WheelState};
use people::People;
pub use register::Register;
pub use replay::{Comparison, Replay, ReplayError};
pub use rights::{changes_clay, may, may_press};

/// What is to be sent, in order.
type Outbox = VecDeque<Transmit>;

/// The shell's own number for a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PeerId(pub u64);

/// What a room is opened with.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomConfig {
    /// Code that lets people in.
    pub code: String,
    /// Number of wheels.
    pub wheels: u16,
    /// Most people at one time.
    pub people_max: u16,
    /// The pot on every wheel.
    pub pot: PotSpec,
    /// How the clay deforms.
    pub method: MethodKind,
    /// How fast the wheels turn at first.
    pub wheel_speed: Rpm,
    /// What the clay is made of at first.
    pub clay: Material,
}

/// Something to send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmit {
    /// To whom.
    pub to: PeerId,
    /// How, and what.
    pub lane: Lane,
}

/// The ways to send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lane {
    /// Unreliable; drop it rather than delay the next. Many get the same, and then share it.
    Datagram(Bytes),
    /// On the control stream, in order.
    Control(Vec<u8>),
    /// On a stream of its own, behind everything else.
    Keyframe(Vec<u8>),
    /// Close the connection once the control stream is through.
    Close,
}

/// What a keyframe costs in plain requests: it is encoded for one peer alone.
const RESYNC_COST: i64 = 4;

/// What a step back or forth costs in plain requests: clay is made again.
const STEP_COST: i64 = 4;

/// Samples pressed again in a tick for those who undid something, at all wheels together; a wheel at which people press
/// gets twice what they press beside.
const AGAIN_A_TICK: usize = 8;

/// What a pot costs in plain requests: as many bytes as the wheel has radii are kept for it.
const POT_COST: i64 = 8;

/// What a tool costs in plain requests: it is checked and told to everybody.
const TOOL_COST: i64 = 8;

/// Ticks between two looks at what wheels remember that is too old.
const FORGET_EVERY: u64 = 15_000;

/// Wrong codes that are remembered until somebody asks.
const WRONG_CODES_MAX: usize = 256;

/// What a room counts for its operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoomCounts {
    /// People let in so far.
    pub joined: u64,
    /// Connections refused so far.
    pub refused: u64,
    /// Requests that were not allowed to who made them, or too many.
    pub forbidden: u64,
    /// Requests to say again what was lost.
    pub repeats: u64,
    /// Requests for keyframes.
    pub resyncs: u64,
    /// Those of both, refused, that named a snapshot which never was.
    pub never_were: u64,
    /// Requests to find and mend what differs.
    pub mends: u64,
    /// Tiles that had differed and were sent for it.
    pub mended_tiles: u64,
    /// Samples refused, of people who have left too.
    pub refusals: Refusals,
    /// Samples pressed again for those who undid something.
    pub remade: u64,
    /// Bytes that all wheels keep to be able to.
    pub history_bytes: usize,
}

/// Everybody and every wheel of a studio.
#[derive(Debug)]
pub struct Room {
    config: RoomConfig,
    benches: Vec<Bench>,
    /// At which wheel a peer that was let in works.
    places: BTreeMap<PeerId, usize>,
    audience: Audience,
    doors: Doors,
    people: People,
    guidance: Leads,
    /// Those who wait to be let in.
    lobby: BTreeMap<PeerId, Waiting>,
    /// The wheels at which somebody is or something is to be done, in order: no other is visited.
    busy: Vec<usize>,
    /// What each of them has to send in a tick.
    desks: Vec<Desk>,
    /// The next tick to be done.
    now: Tick,
    outbox: Outbox,
    /// Who had a wrong code; the newest, when nobody asks.
    wrong_codes: VecDeque<PeerId>,
    counts: RoomCounts,
}

impl Room {
    /// Opens a room.
    ///
    /// # Errors
    /// [`PotError`] when its pot cannot be made.
    pub fn new(config: RoomConfig) -> Result<Self, PotError> {
        Self::open(config, |_| None)
    }

    /// Opens a room with the clay of a record on every wheel; [`RoomConfig::pot`] becomes what that was made from.
    ///
    /// # Errors
    /// [`PotError`] when its pot cannot be made.
    pub fn starting_from(config: RoomConfig, record: &PotRecord) -> Result<Self, PotError> {
        let (clay, speed) = (config.clay, config.wheel_speed);
        Self::open(RoomConfig { pot: *record.spec(), ..config }, |_| Some((record, clay, speed)))
    }

    /// Opens a room with a record's pot on each wheel that has one, counted from 0, what it is made of, and how fast its wheel turns;
    /// all are made from [`RoomConfig::pot`].
    ///
    /// # Errors
    /// [`PotError`] when that pot cannot be made.
    ///
    /// # Panics
    /// When a record is of another pot.
    pub fn going_on_with(config: RoomConfig, records: &[Option<(PotRecord, Material, Rpm)>]) -> Result<Self, PotError> {
        assert!(records.iter().flatten().all(|(record, ..)| *record.spec() == config.pot), "a record of another pot");
        Self::open(config, |wheel| records.get(wheel)?.as_ref().map(|(record, clay, speed)| (record, *clay, *speed)))
    }

    fn open<'a>(
        config: RoomConfig,
        record: impl Fn(usize) -> Option<(&'a PotRecord, Material, Rpm)>,
    ) -> Result<Self, PotError> {
        let mut benches = Vec::new();
        for wheel in 0..usize::from(config.wheels) {
            let spec = PotSpec { keeps_volume: config.method.keeps_volume(), ..config.pot };
            let pot = Pot::new(spec)?;
            let clock = SnapshotClock::of_wheel(wheel);
            let (record, clay, speed) = record(wheel)
                .map_or((None, config.clay, config.wheel_speed), |(record, clay, speed)| (Some(record), clay, speed));
            benches.push(Bench::new(pot, record, config.method, speed, clay, clock));
        }
        Ok(Self {
            doors: Doors::new(config.code.clone()),
            config,
            benches,
            places: BTreeMap::new(),
            audience: Audience::default(),
            people: People::new(),
            guidance: Leads::default(),
            lobby: BTreeMap::new(),
            busy: Vec::new(),
            desks: Vec::new(),
            now: Tick(0),
            outbox: VecDeque::new(),
            wrong_codes: VecDeque::new(),
            counts: RoomCounts::default(),
        })
    }

    /// From now on, the doors are kept as given.
    pub fn keep_doors(&mut self, config: DoorConfig) {
        self.doors.keep(config, self.now);
    }

    /// The room's part of the code that lets people in.
    #[must_use]
    pub fn code(&self) -> &str {
        self.doors.code()
    }

    /// From when on that code is good no longer, if it expires.
    #[must_use]
    pub const fn code_expires(&self) -> Option<Tick> {
        self.doors.expires()
    }

    /// Whether people may not come to a wheel, numbered from 0.
    #[must_use]
    pub fn is_closed(&self, wheel: usize) -> bool {
        self.benches.get(wheel).is_some_and(Bench::is_closed)
    }

    /// Ticks since the clay of a wheel, numbered from 0, was taken as a snapshot; none where nobody is.
    #[must_use]
    pub fn snapshot_age(&self, wheel: usize) -> Option<u64> {
        let bench = self.benches.get(wheel).filter(|bench| bench.has_work())?;
        Some(self.now.0.saturating_sub(bench.snapshot_tick().0))
    }

    /// The next tick to be done.
    #[must_use]
    pub const fn now(&self) -> Tick {
        self.now
    }

    /// People who are in, those who look on and those who wait included.
    #[must_use]
    pub fn people(&self) -> usize {
        self.places.len() + self.audience.len() + self.lobby.len()
    }

    /// What was counted so far.
    #[must_use]
    pub fn counts(&self) -> RoomCounts {
        let mut counts = self.counts;
        counts.refusals.requests += self.audience.refused();
        let (mends, mended_tiles) = self.audience.mends();
        counts.mends += mends;
        counts.mended_tiles += mended_tiles;
        for bench in &self.benches {
            counts.refusals.add(&bench.refusals());
            counts.remade += bench.history().remade();
            counts.history_bytes += bench.history().bytes();
        }
        counts
    }

    /// Number of wheels.
    #[must_use]
    pub fn wheels(&self) -> usize {
        self.benches.len()
    }

    /// The clay on a wheel, numbered from 0.
    #[must_use]
    pub fn pot(&self, wheel: usize) -> Option<&Pot> {
        self.benches.get(wheel).map(Bench::pot)
    }

    /// How a wheel turns and what its clay is made of, numbered from 0.
    #[must_use]
    pub fn conditions(&self, wheel: usize) -> Option<&Conditions> {
        self.benches.get(wheel).map(Bench::conditions)
    }

    /// Whether a connection was let in, or waits for a teacher to let it in.
    #[must_use]
    pub fn is_in(&self, peer: PeerId) -> bool {
        self.people.number(peer).is_some()
    }

    /// People who work at a wheel, numbered from 0.
    #[must_use]
    pub fn people_at(&self, wheel: usize) -> usize {
        self.places.values().filter(|place| **place == wheel).count()
    }

    /// Somebody who was turned away for a wrong code since this was last asked.
    pub fn poll_wrong_code(&mut self) -> Option<PeerId> {
        self.wrong_codes.pop_front()
    }

    /// Digest of the newest snapshot of a wheel, numbered from 0.
    #[must_use]
    pub fn digest(&self, wheel: usize) -> Option<u64> {
        self.benches.get(wheel).map(Bench::digest)
    }

    /// Takes in a control frame; the first one of a peer is its greeting.
    ///
    /// What cannot be answered ends with [`Lane::Close`].
    pub fn handle_control(&mut self, peer: PeerId, frame: &[u8]) {
        let outcome = match self.people.number(peer) {
            None => self.let_in(peer, frame),
            Some(client) => self.hear(peer, client, frame),
        };
        if let Err(error) = outcome {
            self.counts.refused += 1;
            if let PeerError::Refused(refusal) = error {
                self.send(peer, Lane::Control(Peer::notice(&Notice::Refused(refusal))));
            }
            self.send(peer, Lane::Close);
            self.handle_gone(peer);
        }
    }

    /// Hears a request.
    fn hear(&mut self, peer: PeerId, client: u16, frame: &[u8]) -> Result<(), PeerError> {
        let request = Peer::read_request(frame)?;
        let Some(person) = self.people.person(client) else { return Ok(()) };
        let (role, is_waiting) = (person.role, person.is_waiting);
        if !may(role, &request) || (is_waiting && request != Request::Leave) {
            self.counts.forbidden += 1;
            match request {
                Request::Order(_) => {
                    self.send(peer, Lane::Control(Peer::notice(&Notice::NoOrder(NoOrder::NotTeacher))))
                }
                Request::Guide { .. } | Request::Target(_) => {
                    self.send(peer, Lane::Control(Peer::notice(&Notice::NoGuidance(NoGuidance::NotTeacher))));
                }
                _ => {}
            }
            return Ok(());
        }
        match (request, self.places.get(&peer)) {
            (Request::Leave, _) => self.say_goodbye(peer),
            (Request::Order(order), _) => self.order(peer, client, &order),
            (request @ (Request::Guide { .. } | Request::EndGuidance | Request::Target(_)), _) => {
                self.hear_of_guidance(peer, client, request);
            }
            (request, Some(&place)) => self.answer(peer, role, place, request),
            (request, None) => self.audience.answer(peer, request, &mut self.benches, self.now, &mut self.outbox),
        }
        Ok(())
    }

    /// Answers somebody at a wheel.
    fn answer(&mut self, peer: PeerId, role: Role, place: usize, request: Request) {
        let bench = &mut self.benches[place];
        if changes_clay(&request) && role != Role::Teacher && !bench.may_press(peer) {
            self.counts.forbidden += 1;
            return;
        }
        let cost = match request {
            Request::Leave => 0,
            Request::WheelSpeed { .. } | Request::Clay { .. } | Request::Retell { .. } | Request::Again { .. } => 1,
            Request::Resync { .. } | Request::Mend { .. } => RESYNC_COST,
            Request::Tool { .. } => TOOL_COST,
            Request::Undo { .. } | Request::Redo { .. } | Request::NewPot { .. } => STEP_COST,
            Request::Pot { piece: 0, .. } => POT_COST,
            // what follows the first piece is as much as the wheel's grid has, and no more
            Request::Pot { piece, .. } => i64::from(!bench.awaits(peer, piece)),
            // for those who only look on, and those who teach
            Request::Watch { .. }
            | Request::Unwatch { .. }
            | Request::MendSight { .. }
            | Request::Order(_)
            | Request::Guide { .. }
            | Request::EndGuidance
            | Request::Target(_) => 1,
        };
        if !bench.may_ask(peer, self.now, cost) {
            return;
        }
        match request {
            Request::WheelSpeed { rpm } => bench.set_wheel_speed(Rpm(rpm), self.now),
            Request::Clay { clay } => bench.set_clay(clay, self.now),
            Request::Retell { retells } => bench.retell(peer, retells),
            Request::Again { have } | Request::Resync { have } if bench.never_was(have) => self.counts.never_were += 1,
            Request::Again { have } => {
                self.counts.repeats += 1;
                bench.say_again(peer, have, self.now, &mut self.outbox);
            }
            Request::Resync { have } => {
                self.counts.resyncs += 1;
                bench.answer_resync(peer, have, self.now, &mut self.outbox);
            }
            Request::Mend { have, tiles } => {
                self.counts.mends += 1;
                self.counts.mended_tiles += bench.mend(peer, have, &tiles, &mut self.outbox);
            }
            Request::Tool { mesh } => bench.bring(peer, mesh, self.now, &mut self.outbox),
            Request::Undo { held } => bench.ask_step(peer, Step::Back, held, self.now),
            Request::Redo { held } => bench.ask_step(peer, Step::Forth, held, self.now),
            Request::NewPot { held, form } => {
                bench.ask_step(peer, Step::Anew(Anew::Form(Form::from_number(form))), held, self.now);
            }
            Request::Pot { held, piece, bytes } => {
                bench.take_piece(peer, held, piece, &bytes, self.now, &mut self.outbox);
            }
            Request::Watch { .. }
            | Request::Unwatch { .. }
            | Request::MendSight { .. }
            | Request::Order(_)
            | Request::Guide { .. }
            | Request::EndGuidance
            | Request::Target(_)
            | Request::Leave => {}
        }
    }

    /// Takes in a datagram; one from a peer that was not let in is ignored.
    pub fn handle_datagram(&mut self, peer: PeerId, bytes: &[u8]) {
        if let Some(&place) = self.places.get(&peer) {
            let bench = &mut self.benches[place];
            match bench.handle_datagram(peer, bytes, self.now) {
                Some(have) if bench.never_was(have) => self.counts.never_were += 1,
                Some(have) => {
                    self.counts.repeats += 1;
                    bench.say_again(peer, have, self.now, &mut self.outbox);
                }
                None => {}
            }
        }
    }

    /// Takes in that the line to a peer has lost packets since the last time: what it carries is said twice for a while.
    pub fn handle_loss(&mut self, peer: PeerId) {
        if let Some(&place) = self.places.get(&peer) {
            self.benches[place].note_loss(peer, self.now);
        }
    }

    /// Takes in how a peer at a wheel is to be told from now on.
    pub fn set_telling(&mut self, peer: PeerId, telling: Telling) {
        if let Some(&place) = self.places.get(&peer) {
            self.benches[place].set_telling(peer, telling);
        }
    }

    /// Takes in how long a datagram the path to a peer at a wheel takes now; what everybody there is told is cut for the shortest.
    pub fn set_datagram_bytes(&mut self, peer: PeerId, bytes: usize) {
        if let Some(&place) = self.places.get(&peer) {
            self.benches[place].set_datagram_bytes(peer, bytes);
        }
    }

    /// Takes in that a connection has ended; what it had sent is still pressed.
    pub fn handle_gone(&mut self, peer: PeerId) {
        self.let_go(peer);
        self.people.handle_gone(peer, self.now);
    }

    /// Does every tick up to and with `to`.
    pub fn advance(&mut self, to: Tick) {
        self.advance_by(to, &Alone);
    }

    /// As [`Room::advance`], where a crew does the wheels of a tick. Whoever they are, what comes of it is the same, and what is to
    /// be sent comes in the same order.
    pub fn advance_by(&mut self, to: Tick, crew: &impl Crew) {
        while self.now <= to {
            if SnapshotClock::default().is_due(self.now) {
                self.relay_hands();
            }
            let remaking = self.busy.iter().filter(|place| self.benches[**place].is_remaking()).count().max(1);
            let again = AGAIN_A_TICK.div_ceil(remaking) as u32;
            let now = self.now;
            self.desks.resize_with(self.busy.len(), Desk::default);
            let work = together(&mut self.benches, &self.busy, &mut self.desks);
            crew.each(work, |(bench, desk)| bench.step(now, again, &mut desk.outbox, &mut desk.refusals));
            for desk in &mut self.desks {
                self.outbox.append(&mut desk.outbox);
                self.counts.refusals.add(&core::mem::take(&mut desk.refusals));
            }
            if self.now.0.is_multiple_of(telling::TELL_EVERY) {
                self.tell_people();
            }
            if self.now.0.is_multiple_of(FORGET_EVERY) {
                self.benches.iter_mut().for_each(|bench| bench.note_time(now));
            }
            self.audience.serve(&mut self.benches, self.now, &mut self.outbox);
            self.compare_next();
            self.now = self.now.next();
        }
        self.busy.retain(|&place| self.benches[place].has_work());
    }

    /// Tells everybody that the studio closes, and the journal that nobody is there any more.
    pub fn close(&mut self) {
        for bench in &mut self.benches {
            bench.note_closing(self.now);
        }
        let peers: Vec<_> = self.people.iter().filter_map(|(_, person)| person.peer).collect();
        for peer in peers {
            self.send(peer, Lane::Control(Peer::notice(&Notice::Closing)));
            self.send(peer, Lane::Close);
        }
    }

    /// From now on, what happens at every wheel is told by [`Room::poll_journal`], which then has to be asked.
    pub fn keep_journal(&mut self) {
        for bench in &mut self.benches {
            bench.keep_journal(self.now);
        }
    }

    /// Nobody asks any more; what happens is kept for [`Room::poll_journal`] no longer.
    pub fn end_journal(&mut self) {
        self.benches.iter_mut().for_each(Bench::end_journal);
    }

    /// What happened next: for each wheel in order, one wheel after the other.
    pub fn poll_journal(&mut self) -> Option<Entry> {
        (0..).zip(&mut self.benches).find_map(|(wheel, bench)| {
            let (tick, what) = bench.poll_journal()?;
            Some(Entry { wheel, tick, what })
        })
    }

    fn send(&mut self, to: PeerId, lane: Lane) {
        self.outbox.push_back(Transmit { to, lane });
    }

    /// The next thing to send.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.outbox.pop_front()
    }
}
