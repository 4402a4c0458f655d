//! A light follower: holds every snapshot's way by its bytes and asks for what is missing, without making clay of it.
//!
//! Holds no clock and no socket. What is told of a wheel is the same for everybody, so the bytes of each step are compared
//! with those that others got; what they make of the clay is looked at once, at the end.
//! Invariant: `held` is the newest version to which the way is whole, from a keyframe or from the untouched pot.

use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pottery_shared::protocol::{Body, Fragment, FragmentOf, Keyframe, Request, SightName};
use pottery_shared::snapshot::Detail;

/// Time without getting on after which what is missing is asked for, as a client does.
const AGAIN_AFTER: Duration = Duration::from_millis(40);
/// Times that it asks to be told again before it asks for a keyframe.
const AGAIN_MAX: u32 = 3;
/// Time beside the round trip before it asks for a keyframe once more.
const RESYNC_AFTER: Duration = Duration::from_millis(600);
/// Steps that are kept for comparison.
const STEPS_MAX: usize = 1024;

/// What a follower follows: a wheel, and at which detail; potters have none.
pub type Subject = (u16, Option<Detail>);

/// The bytes of everybody's steps, as hashes, and what keyframes decode to.
#[derive(Debug, Default)]
pub struct Ledger {
    steps: Mutex<BTreeMap<(Subject, FragmentOf, u32), u64>>,
    digests: Mutex<HashMap<u64, u64>>,
}

impl Ledger {
    /// Notes the bytes that lead to a version; false when somebody else got others.
    fn agrees(&self, subject: Subject, of: FragmentOf, version: u32, bytes: &[Vec<u8>]) -> bool {
        let hash = hash_of(&bytes);
        let mut steps = self.steps.lock().unwrap_or_else(PoisonError::into_inner);
        let known = *steps.entry((subject, of, version)).or_insert(hash);
        if let Some(old) = version.checked_sub(STEPS_MAX as u32) {
            steps.remove(&(subject, of, old));
        }
        known == hash
    }

    /// The digest that a keyframe's clay has, made once for all who got the same.
    pub fn digest(&self, subject: Subject, keyframe: &Keyframe, decode: impl FnOnce() -> Option<u64>) -> Option<u64> {
        let key = hash_of(&(subject, keyframe.version, keyframe.since, keyframe.goes_on, &keyframe.bytes));
        let mut digests = self.digests.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = digests.get(&key) {
            return Some(*known);
        }
        let digest = decode()?;
        digests.insert(key, digest);
        Some(digest)
    }
}

fn hash_of(what: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    what.hash(&mut hasher);
    hasher.finish()
}

/// What was heard of clay that is whole now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole {
    /// The tick of the clay.
    pub tick: u64,
    /// Samples below this number are in it.
    pub acknowledged: u32,
    /// Whether it is newer than what was held.
    pub is_new: bool,
}

/// Pieces of one step.
#[derive(Debug)]
struct Parts {
    of: FragmentOf,
    pieces: Vec<Option<Vec<u8>>>,
}

/// What follows one wheel.
#[derive(Debug)]
pub struct Follower {
    subject: Subject,
    held: u32,
    latest: u32,
    /// Whether the first keyframe has come; who works begins with the untouched pot.
    is_whole: bool,
    parts: BTreeMap<u32, Parts>,
    /// `(version, tick, acknowledged)` of pulses whose clay is not whole yet.
    standings: Vec<(u32, u64, u32)>,
    /// When to ask, and how often it has asked.
    ask: Option<(Duration, u32)>,
    round_trip: Duration,
    /// The newest digest told, with its version.
    told: Option<(u32, u64)>,
    asked: u64,
    unlike: u64,
}

impl Follower {
    /// Begins to follow at a moment.
    #[must_use]
    pub fn new(subject: Subject, round_trip: Duration, now: Duration) -> Self {
        let is_whole = subject.1.is_none();
        Self {
            subject,
            held: 0,
            latest: 0,
            is_whole,
            parts: BTreeMap::new(),
            standings: Vec::new(),
            ask: (!is_whole).then_some((now + RESYNC_AFTER, AGAIN_MAX)),
            round_trip,
            told: None,
            asked: 0,
            unlike: 0,
        }
    }

    /// Takes in what a datagram says; hands on what is whole by now.
    pub fn handle(&mut self, body: Body, acknowledged: u32, ledger: &Ledger) -> Option<Whole> {
        self.latest = self.latest.max(body.latest);
        if let Some(digest) = body.digest
            && self.told.is_none_or(|(version, _)| version <= body.latest)
        {
            self.told = Some((body.latest, digest));
        }
        if body.latest >= self.held {
            self.standings.push((body.latest, body.tick, acknowledged));
        }
        for fragment in body.fragments {
            self.add(fragment);
        }
        self.get_on(ledger)
    }

    /// Takes in a keyframe; hands on what is whole by now.
    pub fn handle_keyframe(&mut self, keyframe: &Keyframe, ledger: &Ledger) -> Option<Whole> {
        if keyframe.version < self.held || keyframe.since > self.held {
            return None;
        }
        let held = self.held;
        (self.held, self.is_whole, self.ask) = (keyframe.version, true, None);
        self.latest = self.latest.max(keyframe.version);
        self.standings.push((keyframe.version, keyframe.tick, keyframe.acknowledged));
        let whole = self.get_on(ledger);
        whole.map(|whole| Whole { is_new: self.held > held, ..whole })
    }

    fn add(&mut self, fragment: Fragment) {
        let Fragment { version, of, index, count, bytes } = fragment;
        // a second of snapshots is more than anybody waits for
        if version <= self.held || version > self.held + 4096 || index >= count || self.parts.len() > 128 {
            return;
        }
        let pieces = vec![None; usize::from(count)];
        let parts = self.parts.entry(version).or_insert(Parts { of, pieces });
        if parts.of == of
            && let Some(piece) = parts.pieces.get_mut(usize::from(index))
        {
            piece.get_or_insert(bytes);
        }
    }

    fn get_on(&mut self, ledger: &Ledger) -> Option<Whole> {
        let before = self.held;
        while self.is_whole
            && let Some(mut entry) = self.parts.first_entry()
        {
            if *entry.key() > self.held {
                if *entry.key() != self.held + 1 || !entry.get().pieces.iter().all(Option::is_some) {
                    break;
                }
                let pieces: Vec<_> = entry.get_mut().pieces.drain(..).flatten().collect();
                self.held += 1;
                self.unlike += u64::from(!ledger.agrees(self.subject, entry.get().of, self.held, &pieces));
            }
            entry.remove();
        }
        if self.held > before || self.latest <= self.held {
            self.ask = if self.is_whole { None } else { self.ask };
        }
        let held = self.held;
        let reached = self.standings.iter().filter(|(version, ..)| *version <= held);
        let (_, tick, acknowledged) = reached.max_by_key(|(_, tick, _)| *tick).copied()?;
        self.standings.retain(|(version, ..)| *version > held);
        Some(Whole { tick, acknowledged, is_new: self.held > before })
    }

    /// What to ask for, if it is time.
    pub fn poll_request(&mut self, now: Duration) -> Option<Request> {
        if self.is_whole && self.latest <= self.held {
            return None;
        }
        let (at, times) = *self.ask.get_or_insert((now + AGAIN_AFTER, 0));
        if now < at {
            return None;
        }
        self.asked += 1;
        let is_again = times < AGAIN_MAX;
        let patience = self.round_trip + if is_again { AGAIN_AFTER * 2 } else { RESYNC_AFTER };
        self.ask = Some((now + patience, times + 1));
        let have = self.held;
        Some(match self.subject {
            (wheel, Some(detail)) => {
                let have = if self.is_whole && is_again { have } else { 0 };
                Request::Watch { sight: SightName { wheel, detail: detail.into() }, have }
            }
            _ if is_again => Request::Again { have },
            _ => Request::Resync { have },
        })
    }

    /// Asks for the whole pot once more.
    #[must_use]
    pub fn whole_pot(&self) -> Request {
        match self.subject {
            (wheel, Some(detail)) => Request::Watch { sight: SightName { wheel, detail: detail.into() }, have: 0 },
            _ => Request::Resync { have: 0 },
        }
    }

    /// What it follows.
    #[must_use]
    pub const fn subject(&self) -> Subject {
        self.subject
    }

    /// The newest version to which the way is whole.
    #[must_use]
    pub const fn held(&self) -> u32 {
        self.held
    }

    /// Whether all that it knows of is whole.
    #[must_use]
    pub const fn is_current(&self) -> bool {
        self.is_whole && self.latest <= self.held
    }

    /// The version held, and the digest that the server told of it, once it did.
    #[must_use]
    pub fn told_digest(&self) -> Option<(u32, u64)> {
        self.told.filter(|(version, _)| *version == self.held && self.is_current())
    }

    /// Requests made and steps unlike others' since the last call.
    pub const fn take_counts(&mut self) -> (u64, u64) {
        let counts = (self.asked, self.unlike);
        (self.asked, self.unlike) = (0, 0);
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(tick: u64, latest: u32, pieces: &[(u32, u16, u16, u8)]) -> Body {
        let fragments = pieces
            .iter()
            .map(|&(version, index, count, byte)| Fragment {
                version,
                of: FragmentOf::Transcript,
                index,
                count,
                bytes: vec![byte],
            })
            .collect();
        Body { tick, latest, digest: None, tools: None, fragments }
    }

    #[test]
    fn clay_is_whole_with_its_last_piece_and_not_before() {
        let ledger = Ledger::default();
        let mut follower = Follower::new((1, None), Duration::ZERO, Duration::ZERO);
        assert_eq!(follower.handle(body(16, 1, &[(1, 0, 2, 7)]), 5, &ledger), None);
        let second = follower.handle(body(33, 2, &[(2, 0, 1, 9)]), 9, &ledger);
        assert_eq!(second, None, "version 1 still lacks a piece");
        let whole = follower.handle(body(33, 2, &[(1, 1, 2, 8)]), 9, &ledger);
        assert_eq!(whole, Some(Whole { tick: 33, acknowledged: 9, is_new: true }));
        assert!(follower.is_current());
    }

    #[test]
    fn what_is_missing_is_asked_for_and_then_a_keyframe() {
        let ms = Duration::from_millis;
        let mut follower = Follower::new((1, None), Duration::ZERO, Duration::ZERO);
        follower.handle(body(33, 2, &[(2, 0, 1, 9)]), 0, &Ledger::default());
        assert_eq!(follower.poll_request(ms(0)), None);
        assert_eq!(follower.poll_request(ms(40)), Some(Request::Again { have: 0 }));
        assert_eq!(follower.poll_request(ms(41)), None);
        let later: Vec<_> = (1..20).filter_map(|turn| follower.poll_request(ms(40 + 100 * turn))).collect();
        assert_eq!(later[..3], [Request::Again { have: 0 }, Request::Again { have: 0 }, Request::Resync { have: 0 }]);
    }

    #[test]
    fn other_bytes_than_everybody_got_are_found() {
        let ledger = Ledger::default();
        for (byte, unlike) in [(7, 0), (7, 0), (8, 1)] {
            let mut follower = Follower::new((1, None), Duration::ZERO, Duration::ZERO);
            follower.handle(body(16, 1, &[(1, 0, 1, byte)]), 0, &ledger);
            assert_eq!(follower.take_counts(), (0, unlike));
        }
    }
}
