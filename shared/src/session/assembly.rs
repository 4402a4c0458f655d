//! Deltas put together from their fragments.
//!
//! Knows no clay: hands out whole deltas in the order of their versions.
//! Invariant: holds at most [`VERSIONS_MAX`] unfinished versions of at most [`BYTES_MAX`] bytes each.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use crate::protocol::{Body, Fragment};
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

#[derive(Debug, Default)]
struct Parts {
    pieces: Vec<Option<Vec<u8>>>,
    bytes: usize,
}

impl Parts {
    fn is_whole(&self) -> bool {
        !self.pieces.is_empty() && self.pieces.iter().all(Option::is_some)
    }
}

/// Collects fragments and standings above the version held.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    parts: BTreeMap<Version, Parts>,
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
            sound &= self.add(fragment, held);
        }
        while self.parts.len() > VERSIONS_MAX {
            self.parts.pop_last();
        }
        while self.standings.len() > VERSIONS_MAX {
            self.standings.pop_first();
        }
        sound
    }

    fn add(&mut self, fragment: Fragment, held: Version) -> bool {
        let version = Version(fragment.version);
        if version <= held {
            return true;
        }
        if fragment.count == 0 || fragment.count > FRAGMENTS_MAX || fragment.index >= fragment.count {
            return false;
        }
        let parts = self.parts.entry(version).or_default();
        if parts.pieces.is_empty() {
            parts.pieces.resize(usize::from(fragment.count), None);
        }
        if parts.pieces.len() != usize::from(fragment.count) || parts.bytes + fragment.bytes.len() > BYTES_MAX {
            return false;
        }
        let piece = &mut parts.pieces[usize::from(fragment.index)];
        if piece.is_none() {
            parts.bytes += fragment.bytes.len();
            *piece = Some(fragment.bytes);
        }
        true
    }

    /// The newest version up to which every delta after `held` is whole and of which a pulse told the standing.
    pub(super) fn reachable(&self, held: Version) -> Option<(Version, Standing)> {
        let mut version = held;
        let mut best = self.standings.get(&held).map(|standing| (held, *standing));
        while self.parts.get(&version.next()).is_some_and(Parts::is_whole) {
            version = version.next();
            if let Some(standing) = self.standings.get(&version) {
                best = Some((version, *standing));
            }
        }
        best
    }

    /// The whole delta to a version, taken out.
    pub(super) fn take(&mut self, version: Version) -> Vec<u8> {
        let parts = self.parts.remove(&version).unwrap_or_default();
        parts.pieces.into_iter().flatten().flatten().collect()
    }

    /// Forgets what is not newer than `held`.
    pub(super) fn forget(&mut self, held: Version) {
        self.parts.retain(|version, _| *version > held);
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
