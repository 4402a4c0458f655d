//! One wheel with its pot and the people at it: sub-steps, snapshots and pulses.
//!
//! Owns the authoritative clay; who may come to it is the room's affair.
//! Invariant: each snapshot holds exactly the samples below the numbers acknowledged with it.

mod hands;
mod holding;
mod keyframes;
mod pulses;
mod putting;
mod sights;
mod stepping;
mod waiting;

use alloc::collections::{BTreeMap, BTreeSet, VecDeque};
use alloc::vec::Vec;
use core::ops::Range;

use self::holding::Hold;
use self::pulses::Way;
pub(super) use self::sights::Seen;
use self::sights::Sights;
use self::stepping::Wish;
use self::waiting::Pressers;
use super::history::{History, Setting};
use super::journal::{Happening, Journal, WheelState};
use super::pieces::{WAYS_MAX, bodies, fragments};
use super::{Lane, Outbox, PeerId, Transmit};
use crate::clay::{Conditions, Material, MethodKind, Pot, PotSpec, Press, Schedule, SubStep, Surface, Wheel};
use crate::protocol::{
    self, ClayWire, FragmentOf, MeshWire, NewsOf, NoTool, Notice, PotWire, Retelling, StepsWire, ToolWire, Welcome,
    WheelWire,
};
use crate::session::{BROUGHT_MAX, Peer, Refusals, Telling, tool_of, with_one_more};
use crate::snapshot::{Author, Moment, PotRecord, Pressed, SnapshotClock, Touched, Transcript, Version};
use crate::units::{Rpm, Tick};

/// Ticks between the order to change a setting and the change, so that everybody hears of it before.
const NOTICE_TICKS: i64 = 200;
/// Settings change at multiples of this many ticks only, so that however often they are asked for, a wheel remembers
/// every change within the time for which samples are taken.
const SETTINGS_EVERY: u64 = 50;
/// Ticks between two notices of settings: a part of the step of changes, so that they hold two of them at most.
const TELL_EVERY: u64 = 10;
/// Samples of one tool done in one tick when they come late.
const CATCH_UP_MAX: usize = 8;
/// Ticks after which a resting tool is no longer shown.
const TOOL_SHOWN_TICKS: i64 = 500;
/// Ticks after which somebody is told again who says with every datagram that something is missing: what was pressed is short,
/// and tiles are not.
const AGAIN_TICKS_RETOLD: i64 = 40;
const AGAIN_TICKS: i64 = 150;
/// Most tools told of in a pulse.
const TOOLS_MAX: usize = 30;

#[derive(Debug)]
struct Seat {
    client: u16,
    peer: Peer,
    /// Whether the client presses again what was pressed.
    retells: bool,
    /// Whether it is to press, and not to look on.
    works: bool,
    /// What it missed and asked for: everything newer than this version.
    again_from: Option<Version>,
    /// When it was last told again because a datagram asked for it.
    again_at: Option<Tick>,
    telling: Telling,
    /// The longest datagram that its path takes.
    datagram_bytes: usize,
    /// The latest snapshot holds its samples below this number.
    acknowledged: u32,
    /// Over which versions it was last told by a keyframe, and when.
    answered: Option<(Range<u32>, Tick)>,
    /// The snapshots that it was told of with the last pulse and the one before.
    told_of: [Version; 2],
    /// Gone, but with samples still to be pressed.
    leaving: bool,
    told_steps: StepsWire,
    /// The pieces of a pot that it brings, as far as they are here.
    coming: Vec<u8>,
    /// Has not been sent a keyframe yet, so that an older one is news as well.
    is_new: bool,
}

/// A keyframe of the whole pot as it was lately.
#[derive(Debug)]
struct Whole {
    version: Version,
    tick: Tick,
    bytes: Vec<u8>,
}

/// A wheel, its clay and its people.
#[derive(Debug)]
pub(super) struct Bench {
    pot: Pot,
    author: Author,
    touched: Touched,
    conditions: Conditions,
    /// First ticks of settings that nobody was told of yet.
    untold_wheel: Option<Tick>,
    untold_clay: Option<Tick>,
    substep: SubStep,
    /// The tools that people brought, with their numbers in the rack.
    brought: Vec<(u8, MeshWire)>,
    seats: BTreeMap<PeerId, Seat>,
    /// Those of whom samples wait: most who sit at a large wheel look on, and a tick is too short to ask them all.
    hands: BTreeSet<PeerId>,
    hold: Hold,
    /// The latest ones, oldest first.
    ways: VecDeque<Way>,
    pulses: u64,
    /// The pulse with which the latest one went out.
    news_at: u64,
    /// The tools as they were told last, and the pulse since which they are there.
    told_tools: Vec<ToolWire>,
    moved_at: u64,
    clock: SnapshotClock,
    /// The tick of the last snapshot.
    snapshot_tick: Tick,
    pressers: Pressers,
    /// Since when a snapshot is due that waits for samples.
    owed_since: Option<Tick>,
    presses: Vec<Press>,
    pressing: Vec<(PeerId, Pressed)>,
    /// The same as the history notes them: each with whether it met clay.
    noted: Vec<(Pressed, bool)>,
    /// Samples pressed since the history had its share of time.
    pressed_in_tick: u32,
    history: History,
    /// Steps through it that were asked for, in their order.
    wishes: VecDeque<Wish>,
    /// What was pressed since the last snapshot; `None` when it was too much to tell.
    transcript: Option<Transcript>,
    /// Notices told to everybody.
    told: u32,
    sights: Sights,
    /// For those who come, by whether they go on with deltas.
    wholes: [Option<Whole>; 2],
    /// What happens here, when somebody keeps a record of it.
    journal: Option<Journal>,
}

impl Bench {
    /// A wheel with the clay of a record on it, or with the pot as it is.
    pub(super) fn new(
        mut pot: Pot,
        record: Option<&PotRecord>,
        method: MethodKind,
        wheel_speed: Rpm,
        clay: Material,
        clock: SnapshotClock,
    ) -> Self {
        let author = match record {
            Some(record) => Author::starting_from(&mut pot, record),
            None => Author::new(&mut pot),
        };
        let wheel = Wheel::starting_at(Tick(0), crate::clay::Phase(0), Wheel::rate_of(wheel_speed));
        // as it arrives at the clients
        let clay = Material::from(ClayWire::from(clay));
        let conditions = Conditions { wheel, material: Schedule::new(clay), method };
        Self {
            history: History::beginning_with(&pot, &conditions, Tick(0)),
            wishes: VecDeque::new(),
            pressed_in_tick: 0,
            touched: Touched::none(pot.surfaces().iter().map(Surface::shape)),
            substep: SubStep::for_grid(pot.spec().shape),
            pot,
            author,
            conditions,
            untold_wheel: None,
            untold_clay: None,
            brought: Vec::new(),
            seats: BTreeMap::new(),
            hands: BTreeSet::new(),
            hold: Hold::default(),
            ways: VecDeque::new(),
            pulses: 0,
            news_at: 0,
            told_tools: Vec::new(),
            moved_at: 0,
            clock,
            snapshot_tick: Tick(0),
            pressers: Pressers::Nobody,
            owed_since: None,
            presses: Vec::new(),
            pressing: Vec::new(),
            noted: Vec::new(),
            transcript: Some(Transcript::default()),
            told: 0,
            sights: Sights::default(),
            wholes: Default::default(),
            journal: None,
        }
    }

    /// From now on, what happens is told; see [`Bench::poll_journal`].
    pub(super) fn keep_journal(&mut self, now: Tick) {
        self.journal = Some(Journal::beginning_with(now, self.state()));
    }

    /// From now on, nothing is told any more, and what was not asked for is forgotten.
    pub(super) fn end_journal(&mut self) {
        self.journal = None;
    }

    /// What happened next.
    pub(super) fn poll_journal(&mut self) -> Option<(Tick, Happening)> {
        self.journal.as_mut()?.poll()
    }

    fn note(&mut self, tick: Tick, what: Happening) {
        if let Some(journal) = &mut self.journal {
            journal.note(tick, what);
        }
    }

    /// The studio closes: whoever is here leaves, as who goes by themselves does.
    pub(super) fn note_closing(&mut self, now: Tick) {
        let Some(journal) = &mut self.journal else { return };
        for seat in self.seats.values() {
            journal.note(now, Happening::Left { client: seat.client });
        }
    }

    fn state(&self) -> WheelState {
        let mut people: Vec<_> =
            self.seats.values().map(|seat| (seat.client, seat.peer.last_sample().copied())).collect();
        people.sort_unstable_by_key(|(client, _)| *client);
        WheelState {
            pot: PotRecord::of(&self.pot),
            folds: self.folds(),
            conditions: self.conditions.clone(),
            brought: self.brought.clone(),
            people,
        }
    }

    pub(super) const fn pot(&self) -> &Pot {
        &self.pot
    }

    pub(super) const fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    pub(super) fn digest(&self) -> u64 {
        self.author.digest()
    }

    pub(super) fn refusals(&self) -> Refusals {
        let mut sum = Refusals::default();
        for seat in self.seats.values() {
            sum.add(seat.peer.inputs().refusals());
        }
        sum
    }

    /// Gives a new peer its place, its welcome and the clay as it is.
    pub(super) fn seat(&mut self, peer: PeerId, client: u16, retells: bool, now: Tick, outbox: &mut Outbox) {
        let seat = Seat {
            client,
            peer: Peer::default(),
            retells,
            works: true,
            again_from: None,
            again_at: None,
            telling: Telling::Every(1),
            datagram_bytes: protocol::DATAGRAM_MAX,
            acknowledged: 0,
            answered: None,
            told_of: [self.author.latest(); 2],
            leaving: false,
            told_steps: StepsWire::default(),
            coming: Vec::new(),
            is_new: true,
        };
        self.seats.insert(peer, seat);
        self.note(now, Happening::Came { client });
        let welcome = Welcome {
            client,
            now: now.0,
            pot: pot_wire(self.pot.spec()),
            wheel: self.turnings(),
            clay: self.clays(),
            method: self.conditions.method.number(),
            told: self.told_before_tools(),
            ahead: self.clock.ahead(),
        };
        let notice = Peer::notice(&Notice::Welcome(welcome));
        outbox.push_back(Transmit { to: peer, lane: Lane::Control(notice) });
        for (shape, mesh) in &self.brought {
            let notice = Peer::notice(&Notice::Tool { shape: *shape, mesh: mesh.clone() });
            outbox.push_back(Transmit { to: peer, lane: Lane::Control(notice) });
        }
        if self.author.latest() > Version(0) {
            self.answer_resync(peer, 0, now, outbox);
        }
    }

    /// Lets a peer go once its samples are pressed.
    pub(super) fn leave(&mut self, peer: PeerId) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.leaving = true;
        }
    }

    /// Takes in samples; the version from which the peer wants to be told again, if it misses something and was not told just now.
    pub(super) fn handle_datagram(&mut self, peer: PeerId, bytes: &[u8], now: Tick) -> Option<u32> {
        let seat = self.seats.get_mut(&peer)?;
        let again = seat.peer.handle_datagram(bytes, now, self.substep.tools().len());
        if !seat.peer.inputs().is_empty() {
            self.hands.insert(peer);
        }
        let again = again?;
        let every = if seat.retells { AGAIN_TICKS_RETOLD } else { AGAIN_TICKS };
        let is_time = seat.again_at.is_none_or(|at| now.since(at) >= every);
        is_time.then(|| {
            seat.again_at = Some(now);
            again
        })
    }

    /// Whether a request of a peer may be answered; see [`Peer::may_ask`].
    pub(super) fn may_ask(&mut self, peer: PeerId, now: Tick, cost: i64) -> bool {
        self.seats.get_mut(&peer).is_some_and(|seat| seat.peer.may_ask(now, cost))
    }

    pub(super) fn set_wheel_speed(&mut self, speed: Rpm, now: Tick) {
        let (from, rate) = (change_after(now), Wheel::rate_of(speed));
        self.conditions.wheel.schedule(from, rate);
        self.untold_wheel.get_or_insert(from);
        self.history.set(Setting::Wheel(from, rate), &self.conditions);
        self.note(now, Happening::Wheel { from, rate });
    }

    pub(super) fn set_clay(&mut self, clay: ClayWire, now: Tick) {
        let (from, clay) = (change_after(now), clay.into());
        self.conditions.material.set(from, clay);
        self.untold_clay.get_or_insert(from);
        self.history.set(Setting::Clay(from, clay), &self.conditions);
        self.note(now, Happening::Clay { from, clay });
    }

    /// Hangs a tool that a peer brings in the rack and tells everybody; one that hangs there already is told to the peer
    /// alone, and so is why one does not.
    pub(super) fn bring(&mut self, peer: PeerId, mesh: MeshWire, now: Tick, outbox: &mut Outbox) {
        let known = self.brought.iter().find(|(_, known)| *known == mesh).map(|(shape, _)| *shape);
        let answer = match (known, tool_of(&mesh)) {
            (Some(shape), _) => Notice::Tool { shape, mesh },
            (None, Err(_)) => Notice::NoTool(NoTool::Unsound),
            (None, Ok(_)) if self.brought.len() == BROUGHT_MAX => {
                Notice::NoTool(NoTool::Full { brought: BROUGHT_MAX as u16 })
            }
            (None, Ok(tool)) => {
                let mut rack = with_one_more(self.substep.tools(), tool);
                let shape = (rack.len() - 1) as u8;
                self.substep.swap_rack(&mut rack);
                self.brought.push((shape, mesh.clone()));
                self.note(now, Happening::Tool { shape, mesh: mesh.clone() });
                return self.tell_all(NewsOf::Tool { shape, mesh }, outbox);
            }
        };
        outbox.push_back(Transmit { to: peer, lane: Lane::Control(Peer::notice(&answer)) });
    }

    /// Tells everybody what was set since the last time: of each tick the last word alone, so that many who ask are told little.
    fn tell_settings(&mut self, outbox: &mut Outbox) {
        if let Some(first) = self.untold_wheel.take() {
            let untold = self.conditions.wheel.segments().filter(|(from, ..)| *from >= first);
            let news: Vec<_> = untold.map(|(from, _, rate)| NewsOf::Wheel { from: from.0, rate }).collect();
            news.into_iter().for_each(|news| self.tell_all(news, outbox));
        }
        if let Some(first) = self.untold_clay.take() {
            let untold = self.conditions.material.entries().filter(|(from, _)| *from >= first);
            let news: Vec<_> = untold.map(|(from, clay)| NewsOf::Clay { from: from.0, clay: clay.into() }).collect();
            news.into_iter().for_each(|news| self.tell_all(news, outbox));
        }
    }

    /// From now on, a peer gets transcripts or deltas.
    pub(super) fn retell(&mut self, peer: PeerId, retells: bool) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.retells = retells;
        }
    }

    fn tell_all(&mut self, news: NewsOf, outbox: &mut Outbox) {
        self.told = self.told.wrapping_add(1);
        self.note_news(&news);
        let frame = Peer::notice(&match news {
            NewsOf::Standing { wheel, clay } => return debug_assert!(false, "{wheel:?} and {clay:?} are no change"),
            NewsOf::Wheel { from, rate } => Notice::Wheel { from, rate },
            NewsOf::Clay { from, clay } => Notice::Clay { from, clay },
            NewsOf::Tool { shape, mesh } => Notice::Tool { shape, mesh },
        });
        for (&to, _) in self.present() {
            outbox.push_back(Transmit { to, lane: Lane::Control(frame.clone()) });
        }
    }

    fn present(&self) -> impl Iterator<Item = (&PeerId, &Seat)> {
        self.seats.iter().filter(|(_, seat)| !seat.leaving)
    }

    /// Notes that a peer's line has lost something.
    pub(super) fn note_loss(&mut self, peer: PeerId, now: Tick) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.peer.note_loss(now);
        }
    }

    /// Notes how long a datagram a peer's path takes now.
    pub(super) fn set_datagram_bytes(&mut self, peer: PeerId, bytes: usize) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.datagram_bytes = bytes.clamp(protocol::DATAGRAM_MAX, protocol::DATAGRAM_LONGEST);
        }
    }

    /// The longest datagram that everybody's path takes: all get the same.
    fn datagram_bytes(&self) -> usize {
        self.present().map(|(_, seat)| seat.datagram_bytes).min().unwrap_or(protocol::DATAGRAM_MAX)
    }

    /// A peer is told like that from now on.
    pub(super) fn set_telling(&mut self, peer: PeerId, telling: Telling) {
        if let Some(seat) = self.seats.get_mut(&peer) {
            seat.telling = telling;
        }
    }

    /// Does one tick: every due sample, then a snapshot and a pulse if it is time. So many samples may be pressed again, for
    /// those who have undone some.
    pub(super) fn step(&mut self, tick: Tick, again: u32, outbox: &mut Outbox, gone: &mut Refusals) {
        if !self.has_work() {
            return;
        }
        for _ in 0..CATCH_UP_MAX {
            if self.is_crossing(tick) {
                self.take_snapshot(tick, outbox, gone);
                // it goes on, and what waits anew waits from now on
                self.owed_since = self.owed_since.map(|_| tick);
            }
            if !self.press_due(tick) {
                break;
            }
        }
        self.go_back_and_forth(tick, again, outbox);
        if tick.next().0.is_multiple_of(TELL_EVERY) {
            self.tell_settings(outbox);
        }
        if self.is_time(tick) {
            self.take_snapshot(tick, outbox, gone);
        }
        if self.clock.is_due(tick) {
            self.tell_steps(outbox);
            self.pulse(tick, outbox);
        }
    }

    fn take_snapshot(&mut self, tick: Tick, outbox: &mut Outbox, gone: &mut Refusals) {
        let replaced = self.history.end_span(tick, &self.pot);
        if let Some(pot) = &replaced {
            self.replace(tick, pot);
        }
        self.history.note_touched(&self.touched);
        let is_told = self.publish(tick, replaced.is_none());
        self.history.note_snapshot(&self.pot, &self.conditions, tick);
        self.transcript.get_or_insert_default().clear();
        self.snapshot_tick = tick;
        self.pressers = Pressers::Nobody;
        self.note_snapshot(tick);
        self.note_acknowledged(tick, gone);
        if !is_told {
            self.bring_clay(|retells| retells || replaced.is_some(), outbox);
        }
    }

    /// Presses the oldest due sample of every tool as one Jacobi step; false when none was due.
    fn press_due(&mut self, tick: Tick) -> bool {
        self.presses.clear();
        self.pressing.clear();
        let mut any_due = false;
        self.hands.retain(|&peer| {
            let Some(seat) = self.seats.get_mut(&peer) else { return false };
            let Some(sample) = seat.peer.take_due(tick) else { return !seat.peer.inputs().is_empty() };
            any_due = true;
            if self.hold.counts(seat) && !self.history.is_undone(seat.client, sample.tick) {
                let before = seat.peer.last_sample().filter(|before| sample.follows(before)).copied();
                self.pressers.note(peer, sample.tick);
                self.presses.push(self.conditions.press(&sample, before.as_ref()));
                self.pressing.push((peer, Pressed { client: seat.client, sample, before }));
            }
            !seat.peer.inputs().is_empty()
        });
        if self.presses.is_empty() {
            return any_due;
        }
        if let Some(journal) = &mut self.journal {
            let pressed = self.pressing.iter().map(|(_, pressed)| (pressed.client, pressed.sample)).collect();
            journal.note(tick, Happening::Pressed(pressed));
        }
        let touched = &mut self.touched;
        let contacts = self.substep.advance(&mut self.pot, &self.presses, self.conditions.method, |surface, window| {
            touched.add_window(surface, window);
        });
        for ((peer, pressed), contact) in self.pressing.iter().zip(contacts) {
            if let Some(seat) = self.seats.get_mut(peer) {
                seat.peer.note_tool(pressed.sample, contact.elements > 0);
            }
        }
        let any_touches = self.substep.met().contains(&true);
        if any_touches {
            let pressed = self.pressing.iter().map(|(_, pressed)| *pressed);
            self.noted.clear();
            self.noted.extend(pressed.zip(self.substep.met().iter().copied()));
            self.history.note(&mut self.noted);
        }
        self.pressed_in_tick += self.pressing.len() as u32;
        let told = self.pressing.iter().map(|(_, pressed)| *pressed);
        if any_touches && self.transcript.as_mut().is_some_and(|transcript| !transcript.add(told)) {
            self.transcript = None;
        }
        true
    }

    fn note_snapshot(&mut self, tick: Tick) {
        // taken out, so that it can ask how everything stands
        if let Some(mut journal) = self.journal.take() {
            journal.note_snapshot(tick, || self.author.digest(), || self.state());
            self.journal = Some(journal);
        }
    }

    /// Fixes what the snapshot holds of everybody's samples, and lets go who is through.
    fn note_acknowledged(&mut self, tick: Tick, gone: &mut Refusals) {
        let journal = &mut self.journal;
        self.seats.retain(|_, seat| {
            seat.acknowledged = seat.peer.inputs().acknowledged();
            let through = seat.leaving && seat.peer.inputs().is_empty();
            if through {
                gone.add(seat.peer.inputs().refusals());
                if let Some(journal) = journal {
                    journal.note(tick, Happening::Left { client: seat.client });
                }
            }
            !through
        });
    }

    /// Takes a snapshot and keeps what leads to it, as far as anybody needs it and it may be told; false when it was too much
    /// to tell.
    fn publish(&mut self, tick: Tick, may_tell: bool) -> bool {
        let now = Moment { tick, phase: self.conditions.phase(tick) };
        let longest = self.datagram_bytes();
        let needs = |retells: bool| self.present().any(|(_, seat)| seat.retells == retells);
        let (needs_delta, needs_transcript) = (may_tell && needs(false), needs(true) || self.sights.is_retold());
        let (version, delta) = if needs_delta {
            let Some(delta) = self.author.publish(&mut self.pot, &mut self.touched, now) else { return true };
            (delta.version, fragments(delta.version, FragmentOf::Delta, &delta.bytes, longest))
        } else {
            let told = self.author.publish_untold(&mut self.pot, &mut self.touched, now);
            let Some(version) = told else { return true };
            (version, Vec::new())
        };
        let retelling = self.transcript.as_ref().filter(|_| needs_transcript).map(|transcript| {
            protocol::encode(&Retelling {
                since: (self.snapshot_tick.0 as u16).to_le_bytes(),
                told: (self.told as u16).to_le_bytes(),
                digest: (self.author.digest() as u16).to_le_bytes(),
                transcript: transcript.encode(self.snapshot_tick),
            })
        });
        let cut = |bytes: Vec<u8>| fragments(version, FragmentOf::Transcript, &bytes, longest);
        let transcript = retelling.map_or_else(Vec::new, cut);
        let is_told = may_tell && (!needs_transcript || !transcript.is_empty());
        if self.ways.len() == WAYS_MAX {
            self.ways.pop_front();
        }
        self.ways.push_back(Way { version, delta, transcript });
        self.news_at = self.pulses;
        is_told
    }

    fn shown_tools(&self, tick: Tick) -> impl Iterator<Item = ToolWire> {
        self.present().filter_map(move |(_, seat)| seat.peer.tool(seat.client, tick, TOOL_SHOWN_TICKS))
    }

    /// Everybody's tools as others should see them.
    pub(super) fn tools(&self, tick: Tick) -> Vec<ToolWire> {
        self.shown_tools(tick).take(TOOLS_MAX).collect()
    }

    /// Whether there is a tool to be seen.
    pub(super) fn has_tools(&self, tick: Tick) -> bool {
        self.shown_tools(tick).next().is_some()
    }

    /// How the wheel turns from a tick on.
    pub(super) fn turning(&self, tick: Tick) -> WheelWire {
        WheelWire { from: tick.0, phase: self.conditions.phase(tick).0, rate: self.conditions.wheel.rate(tick) }
    }
}

/// A pot's specification as it is sent.
pub(super) fn pot_wire(spec: &PotSpec) -> PotWire {
    PotWire {
        columns: spec.shape.columns(),
        rows: spec.shape.rows(),
        height_m: spec.height.0,
        radius_m: spec.radius.0,
        wall_m: spec.wall.0,
        support: spec.support.number(),
    }
}

/// The tick of a change that is ordered now.
const fn change_after(now: Tick) -> Tick {
    Tick(now.offset(NOTICE_TICKS).0.next_multiple_of(SETTINGS_EVERY))
}
