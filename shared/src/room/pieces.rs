//! What leads to a snapshot, cut into pieces that fit datagrams.
//!
//! Knows sizes and no clay.
//! Invariant: a datagram made of a body is no longer than was asked for.

use alloc::vec::Vec;

use crate::protocol::{self, Body, Fragment, FragmentOf};
use crate::snapshot::Version;

/// Snapshots whose way is kept for those who missed it: half a second of a potter's, in which most lines can ask and be
/// answered.
pub(super) const WAYS_MAX: usize = 32;
/// Most bytes of a fragment, so that any datagram holds one beside the tools of a class.
const FRAGMENT_BYTES_MAX: usize = 600;
/// Bytes of a datagram that are not a fragment's own, and room for the tools of a few.
const WRAPPING_BYTES: usize = 16;
const TOOLS_BYTES: usize = 64;
/// Room for what stands before the body, a hand that guides included, and for the fixed part of the body.
const OVERHEAD_BYTES: usize = 80;

/// What leads to a version, cut into pieces of which a datagram of so many bytes holds two.
pub(super) fn fragments(version: Version, of: FragmentOf, bytes: &[u8], datagram_bytes: usize) -> Vec<Fragment> {
    let piece = (datagram_bytes.saturating_sub(OVERHEAD_BYTES + TOOLS_BYTES) / 2).saturating_sub(WRAPPING_BYTES);
    let piece = piece.clamp(1, FRAGMENT_BYTES_MAX);
    let count = bytes.len().div_ceil(piece).max(1);
    (0..count)
        .map(|index| {
            let end = bytes.len().min((index + 1) * piece);
            let bytes = bytes[index * piece..end].to_vec();
            Fragment { version: version.0, of, index: index as u16, count: count as u16, bytes }
        })
        .collect()
}

/// Bodies that carry all fragments after what the first says, each small enough for a datagram of so many bytes.
pub(super) fn bodies<'a>(
    first: &Body,
    fragments: impl Iterator<Item = &'a Fragment>,
    datagram_bytes: usize,
) -> Vec<Body> {
    let (tick, latest) = (first.tick, first.latest);
    let mut size = protocol::encode(first).len() + OVERHEAD_BYTES;
    let mut all = alloc::vec![first.clone()];
    for fragment in fragments {
        let added = fragment.bytes.len() + WRAPPING_BYTES;
        if size + added > datagram_bytes {
            all.push(Body { tick, latest, digest: None, tools: None, fragments: Vec::new() });
            size = OVERHEAD_BYTES;
        }
        size += added;
        if let Some(body) = all.last_mut() {
            body.fragments.push(fragment.clone());
        }
    }
    all
}
