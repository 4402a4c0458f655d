//! What somebody pressed, pressed again: one way for who works and for who looks on.
//!
//! Owns how a retelling is read; the clay and what governs it are the session's.
//! Invariant: what cannot be read changes no clay.

use crate::clay::{Conditions, SubStep};
use crate::protocol::Retelling;
use crate::snapshot::{Replica, SnapshotError, Touched, Transcript};
use crate::units::Tick;

/// Retellings that may come out wrong before deltas are asked for instead.
pub(super) const UNLIKE_MAX: u64 = 3;

/// Goes one snapshot on; `near` is a tick near it. Says whether the clay is then the author's, as far as can be seen.
///
/// # Errors
/// [`SnapshotError`]; the replica is then unchanged.
pub(super) fn press_again(
    replica: &mut Replica,
    told: &Retelling,
    near: Tick,
    (conditions, substep): (&Conditions, &mut SubStep),
    news: &mut Touched,
) -> Result<bool, SnapshotError> {
    let bytes = told.transcript.len();
    let since = near.nearest(u16::from_le_bytes(told.since));
    let transcript = Transcript::decode(&told.transcript, since).ok_or(SnapshotError::Malformed { bytes })?;
    replica.retell(replica.version().next(), &transcript, conditions, substep, news)?;
    Ok(replica.digest() as u16 == u16::from_le_bytes(told.digest))
}
