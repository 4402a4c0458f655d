//! Deltas and retellings put together from their fragments.
//!
//! Knows no clay: hands out what is whole in the order of its versions.
//! Invariant: holds at most [`VERSIONS_MAX`] unfinished versions, of at most [`BYTES_MAX`] bytes each and [`ALL_BYTES_MAX`] together, in no more than
//! [`FRAGMENTS_MAX`] pieces each.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use crate::protocol::{self, Body, Fragment, FragmentOf, Retelling};
use crate::snapshot::Version;
use crate::units::Tick;

const VERSIONS_MAX: usize = 32;
const BYTES_MAX: usize = 1 << 20;
/// Bytes of all pieces: what comes once more when it is asked for again is worth no more.
const ALL_BYTES_MAX: usize = 4 << 20;
const FRAGMENTS_MAX: u16 = 1024;
/// Most memory that unfinished snapshots of one sight take: their pieces, what retellings say once they are read, and the tables of pieces and
/// versions.
pub const WAITING_BYTES_MAX: usize =
    2 * ALL_BYTES_MAX + VERSIONS_MAX * (2 * FRAGMENTS_MAX as usize * size_of::<Option<Vec<u8>>>() + 1024);

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
    fn is_whole(&self) -> bool {
        !self.pieces.is_empty() && self.pieces.iter().all(Option::is_some)
    }

    /// All bytes, once no piece is missing.
    fn whole(&self) -> Option<Vec<u8>> {
        self.is_whole().then(|| self.pieces.iter().flatten().flatten().copied().collect())
    }
}

/// What is known of the way to one version.
#[derive(Debug, Default)]
struct Way {
    delta: Parts,
    transcript: Parts,
    /// What the transcript's pieces say, once they are whole.
    retelling: Option<Retelling>,
}

impl Way {
    /// Reads what has become whole; false when it is no message.
    fn complete(&mut self) -> bool {
        if self.retelling.is_none()
            && let Some(bytes) = self.transcript.whole()
        {
            let Ok(retelling) = protocol::decode::<BYTES_MAX, Retelling>(&bytes) else {
                self.transcript = Parts::default();
                return false;
            };
            self.retelling = Some(retelling);
        }
        true
    }

    /// How it can be gone, a delta before a retelling.
    fn open(&self, traveller: Traveller) -> Option<FragmentOf> {
        if traveller.takes_deltas && self.delta.is_whole() {
            return Some(FragmentOf::Delta);
        }
        // as numbers that wrap
        let is_heard = |retelling: &Retelling| {
            (traveller.told as u16).wrapping_sub(u16::from_le_bytes(retelling.told)) as i16 >= 0
        };
        self.retelling.as_ref().is_some_and(is_heard).then_some(FragmentOf::Transcript)
    }
}

/// What a replica can take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traveller {
    /// Notices it has heard.
    pub(super) told: u32,
    /// Whether it knows what deltas build upon.
    pub(super) takes_deltas: bool,
}

/// Collects fragments and standings above the version held.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    ways: BTreeMap<Version, Way>,
    standings: BTreeMap<Version, Standing>,
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
        }
        let mut sound = true;
        for fragment in body.fragments {
            // a piece of a snapshot that there is not yet
            sound &= fragment.version <= body.latest && self.add(fragment, Tick(body.tick), held);
        }
        while self.ways.len() > VERSIONS_MAX || self.bytes() > ALL_BYTES_MAX {
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

    /// The newest version to which the way from `held` is open, and of which a pulse told the standing.
    pub(super) fn reachable(&self, held: Version, mut traveller: Traveller) -> Option<(Version, Standing)> {
        let mut version = held;
        let mut best = self.standings.get(&held).map(|standing| (held, *standing));
        while let Some(of) = self.ways.get(&version.next()).and_then(|way| way.open(traveller)) {
            version = version.next();
            // who retells does not learn what the next delta builds upon
            traveller.takes_deltas = of == FragmentOf::Delta;
            if let Some(standing) = self.standings.get(&version) {
                best = Some((version, *standing));
            }
        }
        best
    }

    /// The step to a version, taken out.
    pub(super) fn take(&mut self, version: Version, traveller: Traveller) -> Option<Step> {
        let way = self.ways.remove(&version)?;
        match way.open(traveller)? {
            FragmentOf::Delta => way.delta.whole().map(Step::Delta),
            FragmentOf::Transcript => way.retelling.map(|retelling| Step::Retelling(retelling, way.transcript.tick)),
        }
    }

    /// Bytes of all pieces.
    fn bytes(&self) -> usize {
        self.ways.values().map(|way| way.delta.bytes + way.transcript.bytes).sum()
    }

    /// Forgets what is newer than `latest`, since there is nothing newer.
    pub(super) fn go_back(&mut self, latest: Version) {
        self.ways.retain(|version, _| *version <= latest);
        self.standings.retain(|version, _| *version <= latest);
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
}
