//! Deltas and retellings put together from their fragments.
//!
//! Knows no clay: hands out what is whole in the order of its versions.
//! Invariant: holds at most [`VERSIONS_MAX`] unfinished versions of at most [`BYTES_MAX`] bytes each.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use crate::protocol::{self, Body, Fragment, FragmentOf, Retelling};
use crate::snapshot::Version;
use crate::units::Tick;

const VERSIONS_MAX: usize = 32;
const BYTES_MAX: usize = 1 << 20;
const FRAGMENTS_MAX: u16 = 1024;

/// What a pulse said of the snapshot that was then the latest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    pub(super) tick: Tick,
    pub(super) acknowledged: u32,
    pub(super) digest: Option<u64>,
}

/// What leads to the next snapshot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The tiles that changed.
    Delta(Vec<u8>),
    /// What was pressed, and a tick near it.
    Retelling(Retelling, Tick),
}

#[derive(Debug, Default)]
struct Parts {
    pieces: Vec<Option<Vec<u8>>>,
    bytes: usize,
    /// The tick of the pulse that brought the first of them.
    tick: Tick,
}

impl Parts {
    /// All bytes, once no piece is missing.
    fn whole(&self) -> Option<Vec<u8>> {
        let is_whole = !self.pieces.is_empty() && self.pieces.iter().all(Option::is_some);
        is_whole.then(|| self.pieces.iter().flatten().flatten().copied().collect())
    }
}

/// What is known of the way to one version.
#[derive(Debug, Default)]
struct Way {
    delta: Parts,
    transcript: Parts,
    /// The first of them that became whole.
    step: Option<Step>,
}

impl Way {
    /// Keeps what has become whole; false when it is no message.
    fn complete(&mut self) -> bool {
        if self.step.is_some() {
            return true;
        }
        if let Some(bytes) = self.delta.whole() {
            self.step = Some(Step::Delta(bytes));
        } else if let Some(bytes) = self.transcript.whole() {
            let Ok(retelling) = protocol::decode::<BYTES_MAX, Retelling>(&bytes) else {
                self.transcript = Parts::default();
                return false;
            };
            self.step = Some(Step::Retelling(retelling, self.transcript.tick));
        }
        true
    }

    /// Whether it can be gone by one who has heard the first `told` notices.
    fn is_open(&self, told: u32) -> bool {
        match &self.step {
            None => false,
            Some(Step::Delta(_)) => true,
            // as numbers that wrap
            Some(Step::Retelling(retelling, _)) => {
                (told as u16).wrapping_sub(u16::from_le_bytes(retelling.told)) as i16 >= 0
            }
        }
    }
}

/// Collects fragments and standings above the version held.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    ways: BTreeMap<Version, Way>,
    standings: BTreeMap<Version, Standing>,
    latest: Version,
}

impl Assembly {
    /// Takes in a pulse of which everything up to `held` is known; false when a fragment makes no sense.
    pub(super) fn handle(&mut self, body: Body, acknowledged: u32, held: Version) -> bool {
        let latest = Version(body.latest);
        if latest >= held {
            let standing = Standing { tick: Tick(body.tick), acknowledged, digest: body.digest };
            let known = self.standings.entry(latest).or_insert(standing);
            // pulses may come out of order: the latest word counts, and a digest stays true
            if known.tick < standing.tick {
                *known = Standing { digest: standing.digest.or(known.digest), ..standing };
            } else {
                known.digest = known.digest.or(standing.digest);
            }
            self.latest = self.latest.max(latest);
        }
        let mut sound = true;
        for fragment in body.fragments {
            sound &= self.add(fragment, Tick(body.tick), held);
        }
        while self.ways.len() > VERSIONS_MAX {
            self.ways.pop_last();
        }
        while self.standings.len() > VERSIONS_MAX {
            self.standings.pop_first();
        }
        sound
    }

    fn add(&mut self, fragment: Fragment, tick: Tick, held: Version) -> bool {
        let version = Version(fragment.version);
        if version <= held {
            return true;
        }
        if fragment.count == 0 || fragment.count > FRAGMENTS_MAX || fragment.index >= fragment.count {
            return false;
        }
        let way = self.ways.entry(version).or_default();
        let parts = match fragment.of {
            FragmentOf::Delta => &mut way.delta,
            FragmentOf::Transcript => &mut way.transcript,
        };
        if parts.pieces.is_empty() {
            parts.pieces.resize(usize::from(fragment.count), None);
            parts.tick = tick;
        }
        if parts.pieces.len() != usize::from(fragment.count) || parts.bytes + fragment.bytes.len() > BYTES_MAX {
            return false;
        }
        let piece = &mut parts.pieces[usize::from(fragment.index)];
        if piece.is_none() {
            parts.bytes += fragment.bytes.len();
            *piece = Some(fragment.bytes);
        }
        way.complete()
    }

    /// The newest version to which the way from `held` is open for one who has heard `told` notices, and of which a pulse
    /// told the standing.
    pub(super) fn reachable(&self, held: Version, told: u32) -> Option<(Version, Standing)> {
        let mut version = held;
        let mut best = self.standings.get(&held).map(|standing| (held, *standing));
        while self.ways.get(&version.next()).is_some_and(|way| way.is_open(told)) {
            version = version.next();
            if let Some(standing) = self.standings.get(&version) {
                best = Some((version, *standing));
            }
        }
        best
    }

    /// The step to a version, taken out.
    pub(super) fn take(&mut self, version: Version) -> Option<Step> {
        self.ways.remove(&version)?.step
    }

    /// Forgets what is not newer than `held`.
    pub(super) fn forget(&mut self, held: Version) {
        self.ways.retain(|version, _| *version > held);
        self.standings.retain(|version, _| *version >= held);
    }

    /// Drops the digest of a version once it was looked at.
    pub(super) fn take_digest(&mut self, version: Version) -> Option<u64> {
        self.standings.get_mut(&version)?.digest.take()
    }

    /// The newest snapshot that any pulse told of.
    pub(super) const fn latest(&self) -> Version {
        self.latest
    }
}
