//! What goes to everybody at a wheel with every snapshot, as often as each line bears.
//!
//! Owns the choice of what a pulse repeats; how often a line is told is `crate::session::Pace`'s choice.
//! Invariant: what many are told is encoded once, and what all of a datagram is the same for many is made once.

use alloc::collections::{BTreeMap, VecDeque};
use alloc::vec::Vec;

use bytes::Bytes;

use super::{Bench, Outbox, bodies};
use crate::protocol::{self, Body, Fragment, PulseHead};
use crate::room::{Lane, Transmit};
use crate::session::{Peer, Telling};
use crate::snapshot::Version;
use crate::units::Tick;

/// Pulses after the last that had something to tell, in which that and what led to it is said again over a line that loses: then
/// there is room, and what is still missed has to be asked for otherwise.
const LAST_WORDS: [u64; 3] = [2, 5, 9];
/// The same for what was pressed, which is so short that it is said with every pulse: a burst of losses ends.
const LAST_WORDS_RETOLD: core::ops::RangeInclusive<u64> = 2..=9;
/// Ways that are said again then, a third of a second.
const LAST_WAYS: usize = 20;
/// Pulses of which one goes out over a line that is full, and of those that tell nothing.
const RARELY: u64 = 4;
/// Pulses after the last that had something to tell, and of a tool that is elsewhere, from which on those that tell nothing go out
/// rarely: half a second, in which all last words are said.
const QUIET_AFTER: u64 = 30;
/// Pulses between two digests, about a quarter of a second: of those that go out over any line.
const DIGEST_EVERY: u64 = 16;

/// What leads to a snapshot, in pieces; empty where nobody needed it, or it was too much.
#[derive(Debug)]
pub(in crate::room) struct Way {
    pub(super) version: Version,
    pub(super) delta: Vec<Fragment>,
    pub(super) transcript: Vec<Fragment>,
}

impl Way {
    pub(super) fn fragments(&self, retells: bool) -> &[Fragment] {
        if retells { &self.transcript } else { &self.delta }
    }
}

impl Bench {
    pub(super) fn pulse(&mut self, tick: Tick, outbox: &mut Outbox) {
        let tools = self.tools(tick);
        let pulse = self.pulses;
        let digest = pulse.is_multiple_of(DIGEST_EVERY).then(|| self.author.digest());
        self.pulses += 1;
        if tools != self.told_tools {
            (self.moved_at, self.told_tools) = (pulse, tools.clone());
        }
        let is_quiet = pulse - self.news_at.max(self.moved_at) > QUIET_AFTER;
        let first =
            Body { tick: tick.0, latest: self.author.latest().0, digest, tools: Some(tools), fragments: Vec::new() };
        let longest = self.datagram_bytes();
        let since_news = pulse - self.news_at;
        let is_last_word =
            |retells| if retells { LAST_WORDS_RETOLD.contains(&since_news) } else { LAST_WORDS.contains(&since_news) };
        let oldest = self.ways.get(self.ways.len().saturating_sub(LAST_WAYS));
        let last_words = oldest.map_or(self.author.latest(), |way| Version(way.version.0 - 1));
        // many get the same
        let mut encoded: BTreeMap<(bool, Version), Vec<Vec<u8>>> = BTreeMap::new();
        let mut alike: BTreeMap<(bool, Version), Vec<Bytes>> = BTreeMap::new();
        for (&to, seat) in self.seats.iter_mut().filter(|(_, seat)| !seat.leaving) {
            let [last, before] = seat.told_of;
            // what waits on the way is not helped by more of it
            let every = match seat.telling {
                Telling::Every(every) => every,
                Telling::Asked => RARELY,
            };
            let has_word = seat.again_from.is_some() || seat.peer.has_word();
            let every = if is_quiet && !has_word { every.max(RARELY) } else { every };
            if !pulse.is_multiple_of(every) {
                continue;
            }
            let usual = match seat.telling {
                // what was pressed is shorter than any keyframe
                Telling::Asked if !seat.retells => self.author.latest(),
                _ if seat.peer.loses(tick) => before,
                _ => last,
            };
            let head = seat.peer.pulse_head(seat.acknowledged);
            seat.told_of = [self.author.latest(), last];
            let repeats = is_last_word(seat.retells) && seat.peer.loses(tick) && seat.telling == Telling::Every(1);
            let usual = if repeats { last_words.min(usual) } else { usual };
            let from = seat.again_from.take().map_or(usual, |from| from.min(usual));
            let bodies = encoded.entry((seat.retells, from)).or_insert_with(|| {
                let newer = self.ways.iter().filter(|way| way.version > from);
                let all = bodies(&first, newer.flat_map(|way| way.fragments(seat.retells)), longest);
                all.iter().map(protocol::encode).collect()
            });
            let pulses = || bodies.iter().map(|body| Peer::pulse(&head, body));
            let mut send = |pulse| outbox.push_back(Transmit { to, lane: Lane::Datagram(pulse) });
            if head == PulseHead::default() {
                alike.entry((seat.retells, from)).or_insert_with(|| pulses().collect()).iter().cloned().for_each(send);
            } else {
                pulses().for_each(&mut send);
            }
        }
    }
}

/// Whether what leads on from a version is kept without a gap.
pub(super) fn lead_on(ways: &VecDeque<Way>, from: Version, retells: bool) -> bool {
    let mut missed = ways.iter().filter(|way| way.version > from);
    let first = missed.clone().next();
    first.is_some_and(|way| way.version == from.next()) && missed.all(|way| !way.fragments(retells).is_empty())
}
