//! The wheels of one tick, each with a desk of its own, so that any number of hands can do them at one time.
//!
//! Owns no thread: who does what is the caller's, and what comes of it goes on in the order of the wheels.
//! Invariant: a wheel is done by one hand alone, and no wheel sees another within a tick.

use super::Outbox;
use super::bench::Bench;
use crate::session::Refusals;

/// Whoever does the wheels of a tick: alone, one after the other, or several at one time.
pub trait Crew {
    /// Does every piece of work once, in any order, and returns when all are done.
    fn each<T: Send>(&self, work: impl ExactSizeIterator<Item = T> + Send, each: impl Fn(T) + Sync);
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Crew for Alone {
    fn each<T: Send>(&self, work: impl ExactSizeIterator<Item = T> + Send, each: impl Fn(T) + Sync) {
        work.for_each(each);
    }
}

/// What one wheel has to send and to count after a tick.
#[derive(Debug, Default)]
pub(super) struct Desk {
    pub(super) outbox: Outbox,
    pub(super) refusals: Refusals,
}

/// The wheels of `busy`, which ascends, each with a desk.
pub(super) fn together<'a>(
    benches: &'a mut [Bench],
    busy: &'a [usize],
    desks: &'a mut [Desk],
) -> impl ExactSizeIterator<Item = (&'a mut Bench, &'a mut Desk)> {
    let (mut rest, mut passed) = (benches, 0);
    busy.iter().zip(desks).map(move |(&place, desk)| {
        let bench;
        (bench, rest) =
            core::mem::take(&mut rest)[place - passed..].split_first_mut().expect("every place has a wheel");
        passed = place + 1;
        (bench, desk)
    })
}
