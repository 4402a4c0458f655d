//! What arrives at a client in datagrams and keyframes, up to the clay that it confirms.
//!
//! Owns what is asked for when something is missing; the state is the client's.
//! Invariant: a word of the server that cannot be true moves nothing and is counted, and clay that it brought is the server's again soon.

use alloc::vec::Vec;
use core::time::Duration;

use super::Client;
use crate::protocol::{self, Keyframe, Pulse, Request};
use crate::session::assembly::{Step, Traveller};
use crate::session::course::Word;
use crate::session::retelling::{UNLIKE_MAX, press_again};
use crate::session::welcome::remote_tool;
use crate::session::{ClientEvent, InputQueue, RemoteTool};
use crate::snapshot::{SnapshotError, Version};
use crate::tool::ToolSample;
use crate::units::Tick;

/// That newer clay is known of than can be come to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind {
    /// From when on it asks to be told again, and whether it has.
    ask_at: Duration,
    has_asked: bool,
    /// When it asks for a keyframe.
    resync_at: Duration,
}

impl Client {
    /// Time without getting on after which what is missing is asked for: longer than packets overtake each other.
    const AGAIN_AFTER: Duration = Duration::from_millis(40);
    /// Round trips, and somewhat, in which it asks to be told again before it asks for a keyframe.
    const AGAIN_MAX: u32 = 3;
    /// Time beside the round trip after which a keyframe is asked for, since saying it again did not help.
    const RESYNC_AFTER: Duration = Duration::from_millis(200);

    /// Takes in a datagram; false when it made no sense or cannot be true, and was dropped.
    pub fn handle_datagram(&mut self, bytes: &[u8], now: Duration) -> bool {
        let Ok(pulse) = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, Pulse>(bytes) else { return false };
        let (tick, latest) = (Tick(pulse.body.tick), Version(pulse.body.latest));
        if !self.hear((tick, latest), pulse.head.acknowledged, now, true) {
            return false;
        }
        let next = self.predictor.next_sequence();
        self.lead.handle_tick(tick, now.as_millis() as u64, next, now);
        if let Some(slack) = pulse.head.slack {
            self.redundancy.handle_slack(slack, now);
            self.lead.handle_slack(slack, pulse.head.acknowledged, next, now);
        }
        // a hand is stamped no farther ahead than the server takes samples
        if let Some(hand) = pulse.head.teacher.filter(|hand| Tick(hand.tick).since(tick) <= InputQueue::FUTURE_MAX)
            && self.guidance.hear(&hand)
        {
            self.events.push_back(ClientEvent::Hand);
        }
        let mut body = pulse.body;
        // a time that was believed wrongly is over when the server's is another
        if let Some(tools) = body.tools.take()
            && (tick > self.tools_tick || self.tools_tick > self.course.tick())
        {
            self.tools_tick = tick;
            self.tools = tools.iter().filter_map(remote_tool).collect();
            self.look_beside();
        }
        let sound = self.assembly.handle(body, pulse.head.acknowledged, self.replica.version());
        self.catch_up(now);
        sound
    }

    /// Tells prediction where others hold against a wall that bends: those first that touch it.
    fn look_beside(&mut self) {
        let tick = self.tools_tick;
        if !self.predictor.field().bends() {
            return;
        }
        let others = self.tools.iter().filter(|tool| tool.client != self.number);
        let mut beside: Vec<_> = others
            .map(|&RemoteTool { tool, orientation, centre, touching, side, .. }| {
                (touching, ToolSample { tick, tool, orientation, centre, side })
            })
            .collect();
        beside.sort_by_key(|(touching, _)| !touching);
        if self.predictor.set_beside(beside.into_iter().map(|(_, sample)| sample)) {
            self.events.push_back(ClientEvent::Beside);
        }
    }

    /// Takes in a keyframe stream; false when it made no sense or cannot be true, and was dropped.
    pub fn handle_keyframe(&mut self, bytes: &[u8], now: Duration) -> bool {
        let Ok(keyframe) = protocol::decode::<{ protocol::KEYFRAME_MAX }, Keyframe>(bytes) else { return false };
        let (version, since) = (Version(keyframe.version), Version(keyframe.since));
        if !self.hear((Tick(keyframe.tick), version), keyframe.acknowledged, now, false) {
            return false;
        }
        if version < self.replica.version() {
            return true;
        }
        let Keyframe { bytes, goes_on, .. } = &keyframe;
        match self.replica.apply_keyframe(version, since, bytes, *goes_on, &mut self.news) {
            Ok(()) => {}
            // what it starts from was lost as well, and is asked for
            Err(SnapshotError::NotNext { .. }) => return true,
            Err(_) => return false,
        }
        self.confirm(Tick(keyframe.tick), keyframe.acknowledged, now);
        self.assembly.forget(version);
        self.mending.handle_keyframe(keyframe.mended);
        self.behind = None;
        self.catch_up(now);
        true
    }

    /// Takes in what every message says of the server's time, its snapshots and the own samples; false when that cannot be true.
    fn hear(&mut self, (tick, latest): (Tick, Version), acknowledged: u32, now: Duration, prompt: bool) -> bool {
        if (acknowledged.wrapping_sub(self.predictor.next_sequence()) as i32) > 0 {
            self.course.refuse_acknowledged();
            return false;
        }
        let word = self.course.hear(tick, latest, now.as_millis() as u64, prompt);
        if word == Word::Leapt {
            self.events.push_back(ClientEvent::Leapt);
        }
        if word != Word::Refused && tick == self.course.tick() {
            self.awaited = acknowledged;
        }
        if matches!(word, Word::Back | Word::Leapt) {
            self.assembly.go_back(latest);
            self.behind = None;
            if self.replica.version() > latest {
                // what is held never was; only the whole pot leads away from there
                self.replica.distrust();
                self.mend(now);
            }
        }
        word != Word::Refused
    }

    /// Applies every delta that is whole, checks the digest and asks for what stays missing.
    fn catch_up(&mut self, now: Duration) {
        if self.mending.is_waiting() {
            if let Some(request) = self.mending.due(&self.replica, now, self.round_trip) {
                self.request(&request);
            }
            return;
        }
        let held = self.replica.version();
        if let Some((version, standing)) = self.assembly.reachable(held, self.traveller()) {
            let mut is_alike = Ok(true);
            while is_alike == Ok(true) && self.replica.version() < version {
                is_alike = self.step();
            }
            let is_there = is_alike == Ok(true);
            if is_there && (version > held || standing.acknowledged != self.acknowledged) {
                self.confirm(standing.tick, standing.acknowledged, now);
            }
            self.assembly.forget(self.replica.version());
            match is_alike {
                Ok(true) | Err(SnapshotError::Unlearned { .. }) => {}
                Ok(false) => return self.mend(now),
                Err(SnapshotError::Malformed { .. } | SnapshotError::NotNext { .. }) => self.resync(Version(0)),
            }
        }
        match self.assembly.take_digest(self.replica.version()) {
            Some(digest) if digest == self.replica.digest() => self.mending.handle_match(),
            Some(_) => {
                self.mismatches += 1;
                return self.mend(now);
            }
            None => {}
        }
        if self.replica.version() > held || self.course.latest() <= self.replica.version() {
            self.behind = None;
        }
        if self.course.latest() > self.replica.version() {
            self.ask(now);
        }
    }

    /// Sees to it that what stays missing comes: it asks to be told again with every datagram, and then for a keyframe.
    fn ask(&mut self, now: Duration) {
        let patience = Self::AGAIN_AFTER + (self.round_trip + Self::AGAIN_AFTER * 2) * Self::AGAIN_MAX;
        let fresh = Behind { ask_at: now + Self::AGAIN_AFTER, resync_at: now + patience, has_asked: false };
        let behind = self.behind.get_or_insert(fresh);
        if now >= behind.ask_at && !behind.has_asked {
            behind.has_asked = true;
            self.repeats += 1;
        }
        if now >= behind.resync_at {
            behind.resync_at = now + (self.round_trip + Self::RESYNC_AFTER) * 3;
            self.resync(self.replica.version());
        }
    }

    /// The version from which it wants to be told again.
    pub(super) fn again(&self, now: Duration) -> Option<u32> {
        let is_late = self.behind.is_some_and(|behind| now >= behind.ask_at) && !self.mending.is_waiting();
        is_late.then_some(self.replica.version().0)
    }

    fn traveller(&self) -> Traveller {
        Traveller { told: self.told, takes_deltas: self.replica.takes_deltas() }
    }

    /// Goes one snapshot on; says whether the clay is then the author's, as far as can be seen.
    fn step(&mut self) -> Result<bool, SnapshotError> {
        let next = self.replica.version().next();
        match self.assembly.take(next, self.traveller()) {
            None => Err(SnapshotError::NotNext { delta: next, held: self.replica.version() }),
            Some(Step::Delta(bytes)) => {
                self.counts.deltas += 1;
                self.replica.apply_delta(next, &bytes, &mut self.news).map(|()| true)
            }
            Some(Step::Retelling(told, near)) => {
                self.counts.retold += 1;
                let under = (&self.conditions, &mut self.substep);
                let is_alike = press_again(&mut self.replica, &told, near, under, &mut self.news)?;
                if !is_alike {
                    self.counts.unlike += 1;
                    if self.counts.unlike == UNLIKE_MAX {
                        self.retell(false);
                    }
                }
                Ok(is_alike)
            }
        }
    }

    /// Stands still until what differs has come.
    fn mend(&mut self, now: Duration) {
        let request = self.mending.begin(&self.replica, now, self.round_trip);
        self.request(&request);
    }

    pub(super) fn resync(&mut self, have: Version) {
        self.resyncs += 1;
        self.request(&Request::Resync { have: have.0 });
    }

    fn confirm(&mut self, tick: Tick, acknowledged: u32, now: Duration) {
        if (acknowledged.wrapping_sub(self.acknowledged) as i32) > 0 {
            self.acknowledged = acknowledged;
            self.progress_at = now;
        }
        self.confirmed = Some(tick);
    }
}
