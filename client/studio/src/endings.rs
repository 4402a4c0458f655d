//! How a session ends of which several things are to be kept: each is tried, whatever became of the others.
//!
//! Owns which fault is said when; what is kept, and how, is the callers' affair.
//! Invariant: every fault is said once.

use pottery_client::sentence;

/// The first fault, for the program to end with; those after it are said here.
pub(crate) fn all(endings: impl IntoIterator<Item = anyhow::Result<()>>) -> anyhow::Result<()> {
    let mut faults = endings.into_iter().filter_map(Result::err);
    let first = faults.next();
    for other in faults {
        note!("{}", sentence(other.as_ref()));
    }
    first.map_or(Ok(()), Err)
}
