//! The wheels of one tick, each with a desk of its own, so that any number of hands can do them at one time.
//!
//! Owns no thread: who does what is the caller's, and what comes of it goes on in the order of the wheels.
//! Invariant: a wheel is done by one hand alone, and no wheel sees another within a tick.

use alloc::vec::Vec;

use super::Outbox;
use super::bench::Bench;
use crate::session::Refusals;

/// Whoever does the wheels of a tick: alone, one after the other, or several at one time.
pub trait Crew {
    /// Does every piece of work once, in any order, and returns when all are done.
    fn each<T: Send>(&self, work: &mut [T], each: impl Fn(&mut T) + Sync);
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Crew for Alone {
    fn each<T: Send>(&self, work: &mut [T], each: impl Fn(&mut T) + Sync) {
        work.iter_mut().for_each(each);
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
    busy: &[usize],
    desks: &'a mut [Desk],
) -> Vec<(&'a mut Bench, &'a mut Desk)> {
    let mut work = Vec::with_capacity(busy.len());
    let (mut rest, mut passed) = (benches, 0);
    for (&place, desk) in busy.iter().zip(desks) {
        let Some((bench, behind)) = rest.split_at_mut(place - passed).1.split_first_mut() else { break };
        work.push((bench, desk));
        (rest, passed) = (behind, place + 1);
    }
    work
}
