//! What was pressed at a wheel, kept so that it can be pressed again: as transcripts, a snapshot's worth each.
//!
//! Owns what is kept of a sub-step; knows no strokes and presses nothing.
//! Invariant: pressed again from a kept clay on, in order, with the rounding at the snapshots, it makes the clay that was made.
//!
//! Of a sub-step in which nobody met clay, nothing is kept, and of one in which one tool did, that tool alone: a tool that meets
//! nothing changes nothing. Where several tools did, those in the air are kept as well, since a fast one shares the parts of
//! a sub-step out among the others.

use alloc::boxed::Box;
use alloc::collections::VecDeque;
use alloc::vec::Vec;

use crate::clay::{Conditions, Material};
use crate::snapshot::{KeptClay, Pressed, Transcript};
use crate::units::Tick;

/// A change of what clay is pressed under, or of all of it.
#[derive(Clone, Debug)]
pub(in crate::room) enum Setting {
    /// From that tick on, the wheel turns by so many phase steps a tick.
    Wheel(Tick, i32),
    /// From that tick on, the clay is that.
    Clay(Tick, Material),
    /// All of them as they are, in place of many changes.
    All(Box<Conditions>),
    /// A client puts other clay on the wheel, in a tick; it takes so many bytes beside what it shares with other clay that is kept.
    Put(u16, Tick, KeptClay, usize),
}

impl Setting {
    /// Most changes that are kept one by one while nothing is pressed.
    const MANY: usize = 64;

    fn bytes(&self) -> usize {
        let beside = match self {
            Self::Wheel(..) | Self::Clay(..) => 0,
            Self::All(all) => 16 * (all.wheel.segments().count() + all.material.entries().count()),
            Self::Put(_, _, clay, unshared) => 16 * clay.tiles() + unshared,
        };
        size_of::<Self>() + beside
    }

    pub(super) fn apply(&self, conditions: &mut Conditions) {
        match self {
            Self::Wheel(from, rate) => conditions.wheel.schedule(*from, *rate),
            Self::Clay(from, clay) => conditions.material.set(*from, *clay),
            Self::All(all) => conditions.clone_from(all),
            Self::Put(..) => {}
        }
    }
}

/// What was pressed between two snapshots, or a part of it.
#[derive(Debug)]
pub(super) struct Span {
    /// Ascending in time, before all that was pressed.
    pub(super) settings: Vec<Setting>,
    pub(super) transcript: Transcript,
    /// Which samples, counted through the span, were in the air.
    airs: Vec<u16>,
}

impl Span {
    /// A sub-step: each sample, and whether it met clay.
    pub(super) fn sub_step(&self, number: usize) -> Option<impl Iterator<Item = (&Pressed, bool)>> {
        let (start, pressed) = self.transcript.sub_step(number)?;
        let met = move |at: usize| self.airs.binary_search(&((start + at) as u16)).is_err();
        Some(pressed.iter().enumerate().map(move |(at, pressed)| (pressed, met(at))))
    }
}

/// A span, packed.
#[derive(Debug)]
struct Packed {
    settings: Box<[Setting]>,
    bytes: Box<[u8]>,
    airs: Box<[u16]>,
    since: Tick,
    /// When it was packed.
    ends: Tick,
    /// Samples in the log before it, or what counts as such.
    before: u64,
    /// Whether a snapshot was taken at its end.
    ends_in_snapshot: bool,
}

impl Packed {
    fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.bytes.len()
            + self.settings.iter().map(Setting::bytes).sum::<usize>()
            + self.airs.len() * size_of::<u16>()
    }
}

/// Everything pressed since the oldest clay that is kept.
#[derive(Debug)]
pub(super) struct Log {
    packed: VecDeque<Packed>,
    /// Number of the first packed one.
    first: u64,
    /// What is being pressed.
    open: Span,
    since: Tick,
    /// Samples before the open span, since the wheel began.
    before: u64,
    bytes: usize,
}

impl Log {
    pub(super) fn new() -> Self {
        let open = Span { settings: Vec::new(), transcript: Transcript::default(), airs: Vec::new() };
        Self { packed: VecDeque::new(), first: 0, open, since: Tick(0), before: 0, bytes: 0 }
    }

    /// Number of the span that is open; those before it, back to the oldest, are whole.
    pub(super) fn open_number(&self) -> u64 {
        self.first + self.packed.len() as u64
    }

    pub(super) const fn open(&self) -> &Span {
        &self.open
    }

    /// Samples for which clay that was put on the wheel counts, so that what leads up to it is forgotten in time although nobody presses.
    const PUT_SAMPLES: u64 = 500;

    /// Bytes that it takes, the open span left out.
    pub(super) const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Notes a setting, after which everything is set as given.
    pub(super) fn set(&mut self, setting: Setting, now: &Conditions) {
        if self.open.transcript.pressed() > 0 {
            self.close(self.since, false);
        }
        self.open.settings.push(setting);
        if self.open.settings.len() == Setting::MANY {
            self.open.settings = alloc::vec![Setting::All(Box::new(now.clone()))];
        }
    }

    /// Notes a sub-step: each sample, ascending by client, and whether it met clay.
    pub(super) fn note(&mut self, sub_step: &[(Pressed, bool)]) {
        let met = sub_step.iter().filter(|(_, met)| *met).count();
        if met == 0 {
            return;
        }
        let kept = || sub_step.iter().filter(|(_, is_met)| met > 1 || *is_met);
        if !self.open.transcript.add(kept().map(|(pressed, _)| *pressed)) {
            self.close(self.since, false);
            // an empty one takes a sub-step of a whole class
            self.open.transcript.add(kept().map(|(pressed, _)| *pressed));
        }
        let start = self.open.transcript.pressed() - kept().count();
        let airs = (start..).zip(kept()).filter(|(_, (_, met))| !met).map(|(at, _)| at as u16);
        self.open.airs.extend(airs);
    }

    /// Packs the open span, if anything was pressed in it, at a tick and perhaps in a snapshot.
    pub(super) fn close(&mut self, now: Tick, in_snapshot: bool) {
        if self.open.transcript.pressed() > 0 {
            self.pack(now, in_snapshot);
        } else if in_snapshot && let Some(last) = self.packed.back_mut().filter(|last| !last.ends_in_snapshot) {
            (last.ends_in_snapshot, last.ends) = (true, now);
        }
        self.since = now;
    }

    fn pack(&mut self, now: Tick, in_snapshot: bool) {
        let transcript = &mut self.open.transcript;
        let packed = Packed {
            // there are sixty of them a second: none keeps more room than it fills
            settings: core::mem::take(&mut self.open.settings).into(),
            bytes: transcript.encode(self.since).into(),
            airs: core::mem::take(&mut self.open.airs).into(),
            since: self.since,
            ends: now,
            before: self.before,
            ends_in_snapshot: in_snapshot,
        };
        self.before += transcript.pressed() as u64;
        transcript.clear();
        self.bytes += packed.bytes();
        self.packed.push_back(packed);
    }

    /// Notes, at a snapshot, that other clay was put on the wheel; says in which span, in which there is nothing else.
    pub(super) fn put(&mut self, put: Setting, now: Tick) -> u64 {
        self.open.settings.push(put);
        self.pack(now, true);
        self.before += Self::PUT_SAMPLES;
        self.open_number() - 1
    }

    /// A whole span, if it is kept.
    pub(super) fn span(&self, number: u64) -> Option<Span> {
        let packed = self.packed(number)?;
        let transcript = Transcript::decode(&packed.bytes, packed.since).expect("the log reads what it wrote");
        Some(Span { settings: packed.settings.to_vec(), transcript, airs: packed.airs.to_vec() })
    }

    fn packed(&self, number: u64) -> Option<&Packed> {
        self.packed.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    /// Whether a whole span ended in a snapshot.
    pub(super) fn ends_in_snapshot(&self, number: u64) -> bool {
        self.packed(number).is_some_and(|packed| packed.ends_in_snapshot)
    }

    /// The tick at which a whole span begins.
    pub(super) fn since(&self, number: u64) -> Option<Tick> {
        self.packed(number).map(|packed| packed.since)
    }

    /// Samples pressed before a span, since the wheel began.
    pub(super) fn pressed_before(&self, number: u64) -> u64 {
        self.packed(number).map_or(self.before, |packed| packed.before)
    }

    /// The first span that is not in the newest snapshot at or before a tick.
    pub(super) fn after(&self, tick: Tick) -> u64 {
        let mut at = self.packed.partition_point(|packed| packed.ends <= tick);
        while at > 0 && !self.packed[at - 1].ends_in_snapshot {
            at -= 1;
        }
        self.first + at as u64
    }

    /// Forgets the spans before one.
    pub(super) fn forget_before(&mut self, number: u64) {
        while self.first < number
            && let Some(packed) = self.packed.pop_front()
        {
            self.bytes -= packed.bytes();
            self.first += 1;
        }
    }
}
